! SPDX-License-Identifier: BSD-3-Clause
!> Exchange of patches between ranks. Patches for other ranks are computed first and sent; the inner
!! tiles are computed during the exchange. Packing and waiting are timed separately.
module step_exchange
   use base_communicator, only: communicator_t
   use base_kinds, only: wp
   use step_method, only: method_t
   use step_node_fields, only: motion_nodes_t, whole_tiles
   use step_simulation, only: machine_t, space_t
   use step_tile_cost, only: charge_own_tiles
   implicit none
   private

   public :: next_tiles, send_motion, send_patches

   integer, parameter, public :: edge_tiles = 1      !! Tiles that other ranks may need
   integer, parameter, public :: inner_tiles = 2     !! Tiles that no other rank needs

contains

   !> Own tiles of a part, to be computed now.
   subroutine next_tiles(space, communicator, part, tiles)
      type(space_t), intent(inout) :: space
      type(communicator_t), intent(in) :: communicator
      integer, intent(in) :: part                    !! The edge first
      integer, allocatable, intent(out) :: tiles(:)  !! Indices

      if (part == edge_tiles) then
         call space%halo%plan(communicator, space%grid, space%tiles)
         tiles = space%halo%edge
      else
         tiles = space%halo%inner
      end if
   end subroutine next_tiles

   !> Send the patches after the edge tiles, and receive those of other ranks after the inner tiles.
   subroutine send_patches(space, machine, part, patch, layers)
      type(space_t), intent(inout) :: space
      type(machine_t), intent(inout) :: machine
      integer, intent(in) :: part                    !! Work on tiles
      real(wp), allocatable, intent(inout) :: patch(:, :, :) !! (component, node, tile)
      !> Layers of cells beside own tiles whose nodes are needed; default: whole tiles
      integer, intent(in), optional :: layers
      real(wp) :: waited
      integer :: needed

      if (machine%communicator%size == 1) return
      associate (communicator => machine%communicator, phase => machine%phase)
         call machine%timer%start(phase%exchange)
         waited = communicator%traffic%waiting
         if (part == edge_tiles) then
            needed = whole_tiles
            if (present(layers)) needed = layers
            call space%halo%post(communicator, space%grid, space%tiles, patch, needed)
         else
            call space%halo%complete(communicator, space%grid, space%tiles, patch)
         end if
         call machine%timer%stop(phase%exchange)
         if (part == inner_tiles) call machine%timer%move(phase%exchange, phase%wait, &
            communicator%traffic%waiting - waited)
      end associate
   end subroutine send_patches

   !> The same for the packed patches of the motion.
   subroutine send_motion(space, method, machine, motion, part)
      type(space_t), intent(inout) :: space
      type(method_t), intent(in) :: method
      type(machine_t), intent(inout) :: machine
      type(motion_nodes_t), intent(inout) :: motion
      integer, intent(in) :: part                    !! Work on tiles
      real(wp) :: waited
      integer :: kinds

      if (machine%communicator%size == 1) return
      kinds = merge(2, 1, method%dual)
      associate (communicator => machine%communicator, phase => machine%phase)
         call machine%timer%start(phase%exchange)
         waited = communicator%traffic%waiting
         if (part == edge_tiles) then
            call space%halo%post_packed(communicator, space%grid, space%tiles, motion%touched, &
               motion%packed(:kinds), motion%covered, motion%layers)
         else
            call space%halo%complete_packed(communicator, space%grid, space%tiles, motion%touched, &
               motion%packed(:kinds), motion%covered)
            call charge_own_tiles(space%tiles, machine)
         end if
         call machine%timer%stop(phase%exchange)
         if (part == inner_tiles) call machine%timer%move(phase%exchange, phase%wait, &
            communicator%traffic%waiting - waited)
      end associate
   end subroutine send_motion
end module step_exchange
