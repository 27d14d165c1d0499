! SPDX-License-Identifier: BSD-3-Clause
!> Cost of each tile: the thread time on it in one step, measured only in the steps before the loads
!! of ranks are compared.
module step_tile_cost
   use base_kinds, only: wp
   use base_timer, only: thread_seconds
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: record_cost, cost_clock

contains

   !> Clock at the start of the work on a tile; 0 unless costs are measured [s].
   real(wp) function cost_clock(simulation) result(seconds)
      type(simulation_t), intent(in) :: simulation

      seconds = 0.0_wp
      if (allocated(simulation%machine%cost)) seconds = thread_seconds()
   end function cost_clock

   !> Record the work on a tile since a reading of the clock. Ghosts belong to other ranks.
   subroutine record_cost(simulation, tile, began)
      type(simulation_t), intent(inout) :: simulation
      integer, intent(in) :: tile
      real(wp), intent(in) :: began                  !! Clock at the start [s]

      if (.not. allocated(simulation%machine%cost)) return
      if (tile > size(simulation%machine%cost)) return
      simulation%machine%cost(tile) = simulation%machine%cost(tile) + thread_seconds() - began
   end subroutine record_cost
end module step_tile_cost
