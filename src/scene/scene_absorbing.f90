! SPDX-License-Identifier: BSD-3-Clause
!> What lies beyond absorbing faces, and how fast they slow their nodes: from the speeds of waves in
!! what touches them at the start.
module scene_absorbing
   use base_deck, only: deck_t, group_t
   use base_kinds, only: wp
   use mesh_boundary, only: face_absorbing, face_names
   use mesh_grid, only: grid_t
   use particle_fill, only: body_t
   use particle_points, only: points_t
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: read_absorbing

contains

   !> Find what lies beyond absorbing faces and how fast they slow their nodes, if there are some.
   !! Equations (R.6) and (R.7) of doc/theory/rigid.md.
   subroutine read_absorbing(deck, simulation, bodies)
      type(deck_t), intent(inout) :: deck            !! The deck, collects complaints
      type(simulation_t), intent(inout) :: simulation !! The run, its faces are read
      type(body_t), intent(in) :: bodies(:)          !! Its bodies
      real(wp) :: share
      integer :: face, n

      if (.not. any(simulation%space%boundary%kind == face_absorbing)) return
      allocate (simulation%space%absorbing)
      do face = 1, 6
         if (simulation%space%boundary%kind(face) /= face_absorbing) cycle
         if (.not. simulation%space%grid%active(ishft(face + 1, -1))) cycle
         share = share_of_face(simulation%space%grid, face, &
            simulation%scheme%method%basis%at_wall())
         associate (dashpots => simulation%space%absorbing%face(face))
            call find_beyond(simulation%space%grid, bodies, face, dashpots%beyond)
            allocate (dashpots%decay(2, size(simulation%materials)))
            do n = 1, size(simulation%materials)
               associate (material => simulation%materials(n))
                  dashpots%decay(1, n) = share*material%reference_speed()
                  dashpots%decay(2, n) = share*sqrt(material%shear/material%density)
                  if (dashpots%decay(1, n) > 0.0_wp .or. .not. any(dashpots%beyond == n)) cycle
                  call refuse(deck, face, material%name)
                  return
               end associate
            end do
         end associate
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

   !> Numbers of the materials that reach the nodes of a face at the start: those of the cells
   !! beside it; 0 where there is none.
   subroutine find_beyond(grid, bodies, face, beyond)
      type(grid_t), intent(in) :: grid               !! The grid
      type(body_t), intent(in) :: bodies(:)          !! The bodies
      integer, intent(in) :: face                    !! 1 to 6
      integer, allocatable, intent(out) :: beyond(:, :, :) !! (x, y, z) From 0
      integer, allocatable :: beside(:, :, :)
      integer :: last(3), x, y, z, n

      last = merge(grid%cells, 0, grid%active)
      last(ishft(face + 1, -1)) = 0
      allocate (beyond(0:last(1), 0:last(2), 0:last(3)), source=0)
      allocate (beside(0:max(last(1) - 1, 0), 0:max(last(2) - 1, 0), 0:max(last(3) - 1, 0)), &
         source=0)
      ! of bodies that overlap the later one counts
      do n = 1, size(bodies)
         call find_beside(grid, bodies(n), face, beside)
      end do
      do z = 0, ubound(beside, 3)
         do y = 0, ubound(beside, 2)
            do x = 0, ubound(beside, 1)
               associate (nodes => beyond(x:min(x + 1, last(1)), y:min(y + 1, last(2)), &
                  z:min(z + 1, last(3))))
                  where (nodes == 0) nodes = beside(x, y, z)
               end associate
            end do
         end do
      end do
   end subroutine find_beyond

   !> Mark the cells beside a face whose middle is in a body, or that hold a particle of a list.
   subroutine find_beside(grid, body, face, beside)
      type(grid_t), intent(in) :: grid               !! The grid
      type(body_t), intent(in) :: body               !! The body
      integer, intent(in) :: face                    !! 1 to 6
      integer, intent(inout) :: beside(0:, 0:, 0:)   !! (x, y, z) Gets the material of the body
      real(wp), allocatable :: position(:, :)
      integer :: cell(3), x, y, z, n, normal
      real(wp) :: place(3)

      normal = ishft(face + 1, -1)
      do z = 0, ubound(beside, 3)
         do y = 0, ubound(beside, 2)
            do x = 0, ubound(beside, 1)
               place = grid%lower + (real([x, y, z], wp) + 0.5_wp)*grid%spacing
               where (.not. grid%active) place = merge(0.0_wp, &
                  0.5_wp*(grid%lower + grid%upper), grid%axisymmetric)
               if (mod(face, 2) == 0) place(normal) = grid%upper(normal) - 0.5_wp*grid%spacing
               if (body%shape%contains(place)) beside(x, y, z) = body%store
            end do
         end do
      end do
      if (.not. allocated(body%given)) return
      select type (points => body%given)
      type is (points_t)
         position = points%places()
         do n = 1, size(position, 2)
            cell = min(max(floor((position(:, n) - grid%lower)/grid%spacing), 0), grid%cells - 1)
            if (cell(normal) /= merge(0, grid%cells(normal) - 1, mod(face, 2) == 1)) cycle
            cell(normal) = 0
            beside(cell(1), cell(2), cell(3)) = body%store
         end do
      end select
   end subroutine find_beside
end module scene_absorbing
