! SPDX-License-Identifier: BSD-3-Clause
!> Impulses and work of rigid regions that turn, or that forces move, on the nodes of a tile.
module step_body_impulses
   use base_elementary, only: cross
   use base_exact_sum, only: exact_sum_t
   use base_kinds, only: wp
   use mesh_rigid, only: held_t
   use mesh_wall, only: wall_t
   use mesh_wall_sums, only: body_entries, wall_push_t
   use step_node_fields, only: motion_nodes_t
   use step_simulation, only: space_t
   implicit none
   private

   public :: record_bodies, record_turning

contains

   !> Record the impulse of rigid bodies that forces move on the nodes of a tile, its moment about
   !! their centres, exactly as the particles get it. Equation (R.9) of doc/theory/rigid.md.
   subroutine record_bodies(space, motion, before, sums, tile, each)
      type(space_t), intent(in) :: space
      type(motion_nodes_t), intent(in) :: motion
      integer, intent(in) :: before                  !! Walls before the rigid regions
      type(exact_sum_t), intent(inout) :: sums(:, :) !! (entry, region), private to this thread
      integer, intent(in) :: tile
      type(wall_push_t), intent(in) :: each          !! Force of each wall
      real(wp) :: own(size(each%velocity, 2)), part(3), total(body_entries, size(sums, 2)), arm(3)
      integer :: k, n, node, wall

      call motion%own_mass(space%grid, tile, own)
      total = 0.0_wp
      associate (held => space%rigid%held(tile))
         do n = 1, size(held%node)
            node = held%node(n)
            wall = held%wall(n)
            if (.not. own(node) > 0.0_wp) cycle
            if (.not. allocated(space%rigid%wall(wall)%body)) cycle
            part = own(node)*each%gain(:, node, before + wall)
            total(:3, wall) = total(:3, wall) + part
            arm = held%place(:, n) - space%rigid%wall(wall)%body%centre
            total(4:, wall) = total(4:, wall) + cross(arm, part)
         end do
      end associate
      do wall = 1, size(sums, 2)
         do k = 1, body_entries
            if (abs(total(k, wall)) > 0.0_wp) call sums(k, wall)%add(total(k, wall))
         end do
      end do
   end subroutine record_bodies

   !> Add the work of the rotation of a rigid region on the nodes of a tile.
   subroutine record_turning(held, own, gain, number, wall, work)
      type(held_t), intent(in) :: held               !! Nodes of the tile in regions
      real(wp), intent(in) :: own(:)                 !! (node) Mass of its particles [kg]
      real(wp), intent(in) :: gain(:, :)             !! (3, node) By the region [m/s]
      integer, intent(in) :: number                  !! Index of the region
      type(wall_t), intent(in) :: wall
      type(exact_sum_t), intent(inout) :: work
      real(wp) :: moment(3), arm(3), push(3)
      integer :: n

      if (.not. allocated(wall%body)) return
      moment = 0.0_wp
      do n = 1, size(held%node)
         if (held%wall(n) /= number .or. .not. own(held%node(n)) > 0.0_wp) cycle
         arm = held%place(:, n) - wall%body%centre
         push = own(held%node(n))*gain(:, held%node(n))
         moment = moment + cross(arm, push)
      end do
      call work%add(0.5_wp*dot_product(wall%body%spin + wall%body%spin_end, moment))
   end subroutine record_turning
end module step_body_impulses
