! SPDX-License-Identifier: BSD-3-Clause
!> Work of the threads on each tile. It is measured only in the steps before the loads of ranks are
!! compared. Work on a tile of another rank is caused by an own tile beside it, and counts there.
module step_tile_cost
   use base_kinds, only: wp
   use base_timer, only: thread_seconds
   use mesh_tiles, only: neighbors, tiles_t
   use step_simulation, only: machine_t
   implicit none
   private

   public :: charge_own_tiles, start_cost, stop_cost

contains

   !> Find the own tile that causes the work on each tile of another rank: the first one beside it.
   pure subroutine charge_own_tiles(tiles, machine)
      type(tiles_t), intent(in) :: tiles
      type(machine_t), intent(inout) :: machine
      integer :: tile, place

      if (.not. allocated(machine%cost)) return
      if (allocated(machine%cause)) deallocate (machine%cause)
      allocate (machine%cause(tiles%own + 1:tiles%all), source=0)
      do tile = tiles%own + 1, tiles%all
         do place = 1, neighbors
            associate (other => tiles%neighbor(place, tile))
               if (other == 0 .or. other > tiles%own) cycle
               machine%cause(tile) = other
               exit
            end associate
         end do
      end do
   end subroutine charge_own_tiles

   !> Begin to measure the work on a tile.
   subroutine start_cost(machine, tile)
      type(machine_t), intent(inout) :: machine
      integer, intent(in) :: tile

      if (allocated(machine%cost)) call add_cost(machine, tile, -thread_seconds())
   end subroutine start_cost

   !> Record the work on a tile since the start, by the same thread.
   subroutine stop_cost(machine, tile)
      type(machine_t), intent(inout) :: machine
      integer, intent(in) :: tile

      if (allocated(machine%cost)) call add_cost(machine, tile, thread_seconds())
   end subroutine stop_cost

   !> Add a time to the work of a tile, or of the own tile that causes it. Several threads may work
   !! for one own tile.
   subroutine add_cost(machine, tile, seconds)
      type(machine_t), intent(inout) :: machine
      integer, intent(in) :: tile
      real(wp), intent(in) :: seconds
      integer :: own

      own = tile
      if (tile > size(machine%cost)) then
         own = 0
         if (allocated(machine%cause)) then
            if (tile <= ubound(machine%cause, 1)) own = machine%cause(tile)
         end if
         if (own == 0) return
      end if
      !$omp atomic
      machine%cost(own) = machine%cost(own) + seconds
   end subroutine add_cost
end module step_tile_cost
