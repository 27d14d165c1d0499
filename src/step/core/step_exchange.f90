! SPDX-License-Identifier: BSD-3-Clause
!> Exchange of patches between ranks. Patches for other ranks are computed first and sent; the inner
!! tiles are computed during the exchange. Packing and waiting are timed separately.
module step_exchange
   use base_kinds, only: wp
   use step_simulation, only: simulation_t, velocity_field_t
   implicit none
   private

   public :: next_tiles, send_motion, send_patches

   integer, parameter, public :: edge_tiles = 1      !! Tiles that other ranks may need
   integer, parameter, public :: inner_tiles = 2     !! Tiles that no other rank needs

contains

   !> Own tiles of a part, to be computed now.
   subroutine next_tiles(simulation, part, tiles)
      type(simulation_t), intent(inout) :: simulation
      integer, intent(in) :: part                    !! The edge first
      integer, allocatable, intent(out) :: tiles(:)  !! Indices

      if (part == edge_tiles) then
         call simulation%space%halo%plan(simulation%machine%communicator, simulation%space%grid, &
            simulation%space%tiles)
         tiles = simulation%space%halo%edge
      else
         tiles = simulation%space%halo%inner
      end if
   end subroutine next_tiles

   !> Send the patches after the edge tiles, and receive those of other ranks after the inner tiles.
   subroutine send_patches(simulation, part, patch)
      type(simulation_t), intent(inout) :: simulation
      integer, intent(in) :: part                    !! Work on tiles
      real(wp), allocatable, intent(inout) :: patch(:, :, :) !! (component, node, tile)
      real(wp) :: waited

      if (simulation%machine%communicator%size == 1) return
      associate (communicator => simulation%machine%communicator, phase => simulation%machine%phase)
         call simulation%machine%timer%start(phase%exchange)
         waited = communicator%traffic%waiting
         if (part == edge_tiles) then
            call simulation%space%halo%post(communicator, simulation%space%tiles, patch)
         else
            call simulation%space%halo%complete(communicator, simulation%space%grid, &
               simulation%space%tiles, patch)
         end if
         call simulation%machine%timer%stop(phase%exchange)
         if (part == inner_tiles) call simulation%machine%timer%move(phase%exchange, phase%wait, &
            communicator%traffic%waiting - waited)
      end associate
   end subroutine send_patches

   !> The same for the packed patches of the motion.
   subroutine send_motion(simulation, field, part)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(inout) :: field
      integer, intent(in) :: part                    !! Work on tiles
      real(wp) :: waited
      integer :: kinds

      if (simulation%machine%communicator%size == 1) return
      kinds = merge(2, 1, simulation%scheme%method%dual)
      associate (communicator => simulation%machine%communicator, phase => &
         simulation%machine%phase, &
         nodes => field%nodes)
         call simulation%machine%timer%start(phase%exchange)
         waited = communicator%traffic%waiting
         if (part == edge_tiles) then
            call simulation%space%halo%post_packed(communicator, simulation%space%grid, &
               simulation%space%tiles, &
               nodes%motion%touched, nodes%motion%packed(:kinds))
         else
            call simulation%space%halo%complete_packed(communicator, simulation%space%grid, &
               simulation%space%tiles, &
               nodes%motion%touched, nodes%motion%packed(:kinds))
         end if
         call simulation%machine%timer%stop(phase%exchange)
         if (part == inner_tiles) call simulation%machine%timer%move(phase%exchange, phase%wait, &
            communicator%traffic%waiting - waited)
      end associate
   end subroutine send_motion
end module step_exchange
