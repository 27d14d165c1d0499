! SPDX-License-Identifier: BSD-3-Clause
!> Boundaries of the domain with a prescribed temperature.
module step_heat_boundaries
   use base_kinds, only: wp
   use step_ledger, only: external_work, ledger_t
   use step_simulation, only: conduction_t, space_t
   implicit none
   private

   public :: hold_temperature, take_heat

contains

   !> Set the nodes of a tile on such boundaries to the temperature of the boundary.
   pure subroutine hold_temperature(space, heat, tile)
      type(space_t), intent(in) :: space
      type(conduction_t), intent(inout) :: heat
      integer, intent(in) :: tile
      real(wp) :: held(space%grid%tile_nodes)

      if (.not. any(space%boundary%warm)) return
      call space%boundary%held_at(space%grid, space%tiles%coordinate(:, tile), held)
      where (held >= 0.0_wp) heat%temperature(1, :, tile) = held
   end subroutine hold_temperature

   !> Heat that nodes on such boundaries exchange with the boundary; the tile records the part due
   !! to its own particles.
   pure subroutine take_heat(space, heat, ledger, tile, row, change)
      type(space_t), intent(in) :: space
      type(conduction_t), intent(in) :: heat
      type(ledger_t), intent(inout) :: ledger        !! Private to this thread
      integer, intent(in) :: tile
      integer, intent(in) :: row                     !! Row of heat capacity in the patch
      real(wp), contiguous, intent(inout) :: change(:, :) !! (1, node) Change of the temperature [K]
      real(wp) :: held(space%grid%tile_nodes), taken

      if (.not. any(space%boundary%warm)) return
      call space%boundary%held_at(space%grid, space%tiles%coordinate(:, tile), held)
      taken = sum(heat%content(row, :, tile)*change(1, :), mask=held >= 0.0_wp)
      where (held >= 0.0_wp) change(1, :) = 0.0_wp
      call ledger%sums(external_work)%add(-taken)
   end subroutine take_heat
end module step_heat_boundaries
