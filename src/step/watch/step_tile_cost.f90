! SPDX-License-Identifier: BSD-3-Clause
!> Work of the threads on each tile. It is measured only in the steps before the loads of ranks are
!! compared.
module step_tile_cost
   use base_timer, only: thread_seconds
   use step_simulation, only: machine_t
   implicit none
   private

   public :: start_cost, stop_cost

contains

   !> Begin to measure the work on a tile. Ghosts belong to other ranks.
   subroutine start_cost(machine, tile)
      type(machine_t), intent(inout) :: machine
      integer, intent(in) :: tile

      if (.not. allocated(machine%cost)) return
      if (tile <= size(machine%cost)) machine%cost(tile) = machine%cost(tile) - thread_seconds()
   end subroutine start_cost

   !> Record the work on a tile since the start, by the same thread.
   subroutine stop_cost(machine, tile)
      type(machine_t), intent(inout) :: machine
      integer, intent(in) :: tile

      if (.not. allocated(machine%cost)) return
      if (tile <= size(machine%cost)) machine%cost(tile) = machine%cost(tile) + thread_seconds()
   end subroutine stop_cost
end module step_tile_cost
