! SPDX-License-Identifier: BSD-3-Clause
!> Dashpots of absorbing boundaries, from the wave speeds of the materials that touch them at the
!! start.
module scene_absorbing
   use base_kinds, only: wp
   use boundary_absorbing, only: boundary_absorbing_t
   use deck_reader, only: deck_t, group_t
   use mesh_boundary_condition, only: normal_direction
   use mesh_boundary_walls, only: face_names
   use mesh_grid, only: grid_t
   use particle_body, only: body_t
   use particle_points, only: points_t
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: read_absorbing

contains

   !> Set the dashpots of absorbing boundaries, if any.
   subroutine read_absorbing(deck, simulation, bodies)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(simulation_t), intent(inout) :: simulation !! The run, its faces are read
      type(body_t), intent(in) :: bodies(:)          !! Bodies of the scene
      integer :: n, face, refused, material_number
      real(wp) :: share

      if (.not. allocated(simulation%space%boundary%wall)) return
      do n = 1, size(simulation%space%boundary%wall)
         face = simulation%space%boundary%wall(n)%face
         if (.not. simulation%space%grid%active(normal_direction(face))) cycle
         refused = 0
         select type (condition => simulation%space%boundary%wall(n)%condition)
         type is (boundary_absorbing_t)
            ! the material beyond the boundary and the damping rate of its nodes, equations (R.6)
            ! and (R.7) of doc/theory/rigid.md
            share = boundary_area_per_volume(simulation%space%grid, face, &
               simulation%scheme%method%basis%at_wall())
            call find_beyond(simulation%space%grid, bodies, face, condition%beyond)
            allocate (condition%decay(2, size(simulation%materials)))
            do material_number = 1, size(simulation%materials)
               associate (material => simulation%materials(material_number))
                  condition%decay(1, material_number) = share*material%reference_speed()
                  condition%decay(2, material_number) = share*sqrt(material%shear/material%density)
               end associate
               if (condition%decay(1, material_number) > 0.0_wp .or. &
                  .not. any(condition%beyond == material_number)) cycle
               refused = material_number
               exit
            end do
         end select
         if (refused == 0) cycle
         call refuse(deck, face, simulation%materials(refused)%name)
         return
      end do
   end subroutine read_absorbing

   !> Report a material without a wave speed, at the &boundary.
   subroutine refuse(deck, face, material)
      type(deck_t), intent(inout) :: deck            !! The deck, collects the problem
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
         call deck%add_error(group, "material '"//material//"' has no wave speed at rest, "// &
            "which an absorbing boundary needs; use type = 'outflow' [D327]", "type")
         return
      end do
   end subroutine refuse

   !> Area of the boundary of a node divided by the volume of the node [1/m].
   pure real(wp) function boundary_area_per_volume(grid, face, at_wall) result(share)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: face                    !! 1 to 6
      real(wp), intent(in) :: at_wall                !! Integral of its shape function [cells]
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
   end function boundary_area_per_volume

   !> Index of the material at each node of a boundary at the start, from the adjacent cells; 0 if
   !! none.
   subroutine find_beyond(grid, bodies, face, beyond)
      type(grid_t), intent(in) :: grid
      type(body_t), intent(in) :: bodies(:)
      integer, intent(in) :: face                    !! 1 to 6
      integer, allocatable, intent(out) :: beyond(:, :, :) !! (x, y, z) From 0
      integer, allocatable :: beside(:, :, :)
      integer :: last(3), x, y, z, n, cell(3), point, normal
      real(wp), allocatable :: position(:, :)
      real(wp) :: place(3)

      last = merge(grid%cells, 0, grid%active)
      last(ishft(face + 1, -1)) = 0
      allocate (beyond(0:last(1), 0:last(2), 0:last(3)), source=0)
      allocate (beside(0:max(last(1) - 1, 0), 0:max(last(2) - 1, 0), 0:max(last(3) - 1, 0)), &
         source=0)
      ! the cells adjacent to the boundary whose middle is in a body, or that contain a particle of
      ! its list; where bodies overlap, the later one counts
      do n = 1, size(bodies)
         normal = ishft(face + 1, -1)
         do z = 0, ubound(beside, 3)
            do y = 0, ubound(beside, 2)
               do x = 0, ubound(beside, 1)
                  place = grid%lower + (real([x, y, z], wp) + 0.5_wp)*grid%spacing
                  where (.not. grid%active) place = merge(0.0_wp, &
                     0.5_wp*(grid%lower + grid%upper), grid%axisymmetric)
                  if (mod(face, 2) == 0) place(normal) = grid%upper(normal) - 0.5_wp*grid%spacing
                  if (bodies(n)%shape%contains(place)) beside(x, y, z) = bodies(n)%store
               end do
            end do
         end do
         if (.not. allocated(bodies(n)%given)) cycle
         select type (points => bodies(n)%given)
         type is (points_t)
            position = points%positions()
            do point = 1, size(position, 2)
               cell = min(max(floor((position(:, point) - grid%lower)/grid%spacing), 0), &
                  grid%cells - 1)
               if (cell(normal) /= merge(0, grid%cells(normal) - 1, mod(face, 2) == 1)) cycle
               cell(normal) = 0
               beside(cell(1), cell(2), cell(3)) = bodies(n)%store
            end do
         end select
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
end module scene_absorbing
