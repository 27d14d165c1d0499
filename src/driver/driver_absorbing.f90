! SPDX-License-Identifier: BSD-3-Clause
!> How fast absorbing faces slow their nodes, from the speeds of waves in what touches them.
module driver_absorbing
   use base_deck, only: deck_t, group_t
   use base_kinds, only: wp
   use driver_simulation, only: simulation_t
   use mesh_boundary, only: face_absorbing, face_names
   use mesh_grid, only: grid_t
   use particle_fill, only: body_t
   implicit none
   private

   public :: read_absorbing

   integer, parameter :: samples = 128               !! Places looked at along a direction of a face

contains

   !> Find the rates of absorbing faces. Equations (R.6) and (R.7) of doc/theory/rigid.md.
   subroutine read_absorbing(deck, simulation, bodies)
      type(deck_t), intent(inout) :: deck            !! The deck, collects complaints
      type(simulation_t), intent(inout) :: simulation !! The run, its faces are read
      type(body_t), intent(in) :: bodies(:)          !! Its bodies
      real(wp) :: speed(2)
      integer :: face, store

      do face = 1, 6
         if (simulation%boundary%kind(face) /= face_absorbing) cycle
         if (.not. simulation%grid%active(ishft(face + 1, -1))) cycle
         store = material_at(simulation%grid, bodies, face)
         associate (material => simulation%materials(store))
            speed(1) = material%reference_speed()
            speed(2) = sqrt(material%shear/material%density)
            if (.not. speed(1) > 0.0_wp) then
               call refuse(deck, face, material%name)
               return
            end if
         end associate
         simulation%boundary%decay(:, face) = speed*share_of_face(simulation%grid, face, &
            simulation%method%basis%at_wall())
      end do
   end subroutine read_absorbing

   !> Complain of a material without a speed of waves, at the &boundary of the face.
   subroutine refuse(deck, face, material)
      type(deck_t), intent(inout) :: deck            !! The deck, collects the complaint
      integer, intent(in) :: face                    !! 1 to 6
      character(len=*), intent(in) :: material       !! Name of the material
      type(group_t) :: group
      character(len=:), allocatable :: name, kind
      integer :: index

      do index = 1, deck%count("boundary")
         group = deck%group("boundary", index)
         call group%get("face", name)
         call group%get("type", kind)
         if (kind /= "absorbing" .or. (name /= face_names(face) .and. name /= "all")) cycle
         call deck%complain(group, "material '"//material//"' has no speed of waves at rest "// &
            "that the face could absorb; use outflow", "type")
         return
      end do
   end subroutine refuse

   !> Area of the face that belongs to a node on it over the volume that does [1/m].
   pure real(wp) function share_of_face(grid, face, at_wall) result(share)
      type(grid_t), intent(in) :: grid               !! The grid
      integer, intent(in) :: face                    !! 1 to 6
      real(wp), intent(in) :: at_wall                !! Integral of its function [cells]
      real(wp) :: weight(0:1), area

      associate (normal => (face + 1)/2)
         if (mod(face, 2) == 1) then
            weight = grid%line_weight(normal, 0)
            share = weight(0)
         else
            weight = grid%line_weight(normal, grid%cells(normal) - 1)
            share = weight(1)
         end if
         area = 1.0_wp
         if (grid%axisymmetric .and. normal == 1) area = grid%upper(1)
         ! the weights are those of linear functions, whose integral is half a cell
         share = area/(share*at_wall/0.5_wp)
      end associate
   end function share_of_face

   !> Number of the material that covers most of a face at the start, counted half a cell inside;
   !! that of the first body where none does.
   pure integer function material_at(grid, bodies, face) result(store)
      type(grid_t), intent(in) :: grid               !! The grid
      type(body_t), intent(in) :: bodies(:)          !! The bodies
      integer, intent(in) :: face                    !! 1 to 6
      integer :: found(maxval(bodies%store)), number_of(3), x, y, z, n, normal
      real(wp) :: place(3), step(3)

      normal = (face + 1)/2
      found = 0
      number_of = merge(min(grid%cells, samples), 1, grid%active)
      number_of(normal) = 1
      step = merge((grid%upper - grid%lower)/real(number_of, wp), 0.0_wp, grid%active)
      do z = 1, number_of(3)
         do y = 1, number_of(2)
            do x = 1, number_of(1)
               place = grid%lower + (real([x, y, z], wp) - 0.5_wp)*step
               where (.not. grid%active) place = merge(0.0_wp, &
                  0.5_wp*(grid%lower + grid%upper), grid%axisymmetric)
               place(normal) = merge(grid%lower(normal) + 0.5_wp*grid%spacing, &
                  grid%upper(normal) - 0.5_wp*grid%spacing, mod(face, 2) == 1)
               ! of bodies that overlap the later one counts
               do n = size(bodies), 1, -1
                  if (.not. bodies(n)%shape%contains(place)) cycle
                  found(bodies(n)%store) = found(bodies(n)%store) + 1
                  exit
               end do
            end do
         end do
      end do
      store = bodies(1)%store
      if (any(found > 0)) store = maxloc(found, dim=1)
   end function material_at
end module driver_absorbing
