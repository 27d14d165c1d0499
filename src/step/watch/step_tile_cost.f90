! SPDX-License-Identifier: BSD-3-Clause
!> Work of the threads on each tile. It is measured only in the steps before the loads of ranks are
!! compared.
module step_tile_cost
   use base_kinds, only: wp
   use base_timer, only: thread_seconds
   use step_simulation, only: machine_t
   implicit none
   private

   public :: cost_clock, record_cost

contains

   !> Processor time of this thread at the start of the work on a tile; 0 where it is not measured.
   real(wp) function cost_clock(machine) result(seconds)
      type(machine_t), intent(in) :: machine

      seconds = 0.0_wp
      if (allocated(machine%cost)) seconds = thread_seconds()
   end function cost_clock

   !> Record the work on a tile since a reading of the clock. Ghosts belong to other ranks.
   subroutine record_cost(machine, tile, began)
      type(machine_t), intent(inout) :: machine
      integer, intent(in) :: tile
      real(wp), intent(in) :: began                  !! Clock at the start [s]

      if (.not. allocated(machine%cost)) return
      if (tile > size(machine%cost)) return
      machine%cost(tile) = machine%cost(tile) + thread_seconds() - began
   end subroutine record_cost
end module step_tile_cost
