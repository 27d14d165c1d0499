! SPDX-License-Identifier: BSD-3-Clause
!> What a checkpoint holds of the loads, and how a restart with other loads continues.
!!
!! A load keeps its functions at the particles if the checkpoint has a load with the same region,
!! and stays closed if one has the same region, bodies and kind of stress. A load that is new at the
!! restart acts on the material that is in its region then.
module output_load_state
   use base_error, only: error_t
   use base_kinds, only: int64, wp
   use io_state, only: state_t
   use mesh_surface_load, only: mark_columns, surface_load_t
   use scene_load, only: mark_particles
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: keep_marks, mark_new_loads, save_loads

contains

   !> Add what a restart needs of the loads.
   subroutine save_loads(simulation, state)
      type(simulation_t), intent(in) :: simulation
      type(state_t), intent(inout) :: state

      if (.not. allocated(simulation%effects%loads)) return
      associate (loads => simulation%effects%loads)
         call state%set("load_regions", merge(loads%region_key, 0_int64, loads%slot > 0))
         call state%set("load_surfaces", loads%surface_key)
         call state%set("closed_loads", merge(1_int64, 0_int64, loads%hold%closed))
      end associate
   end subroutine save_loads

   !> Move the functions that the particles have read to the columns of the loads of this run.
   subroutine keep_marks(simulation, state, error)
      type(simulation_t), intent(inout) :: simulation !! Particles as read
      type(state_t), intent(in) :: state
      type(error_t), allocatable, intent(out) :: error !! The checkpoint is incomplete
      integer(int64), allocatable :: regions(:)
      integer, allocatable :: source(:)
      integer :: index, n

      if (.not. allocated(simulation%effects%loads)) return
      call saved(state, "load_regions", regions, error)
      if (allocated(error)) return
      associate (loads => simulation%effects%loads)
         allocate (source(maxval([0, loads%slot])), source=0)
         do n = 1, size(loads)
            if (loads(n)%slot > 0) source(loads(n)%slot) = slot_of(regions, loads(n)%region_key)
         end do
      end associate
      do index = 1, size(simulation%stores)
         associate (origin => simulation%stores(index)%origin)
            if (allocated(origin%marks)) call move_columns(source, origin%marks)
         end associate
      end do
   end subroutine keep_marks

   !> Set the functions of the loads that the checkpoint does not have, and find which of the
   !! changed loads act on closed surfaces. Collective.
   subroutine mark_new_loads(simulation, state, error)
      type(simulation_t), intent(inout) :: simulation !! Particles in their tiles
      type(state_t), intent(in) :: state
      type(error_t), allocatable, intent(out) :: error !! The checkpoint is incomplete
      integer(int64), allocatable :: closed(:), regions(:), surfaces(:)
      logical, allocatable :: known(:), marked(:)
      integer :: n, old

      if (.not. allocated(simulation%effects%loads)) return
      call saved(state, "load_regions", regions, error)
      if (.not. allocated(error)) call saved(state, "load_surfaces", surfaces, error)
      if (.not. allocated(error)) call saved(state, "closed_loads", closed, error)
      if (allocated(error)) return
      allocate (marked(size(simulation%effects%loads)), known(size(simulation%effects%loads)))
      do n = 1, size(marked)
         associate (load => simulation%effects%loads(n))
            marked(n) = slot_of(regions, load%region_key) > 0
            old = findloc(surfaces, load%surface_key, 1)
            known(n) = old > 0
            if (known(n)) load%hold%closed = closed(old) > 0
         end associate
      end do
      call mark_particles(simulation, marked, known)
   end subroutine mark_new_loads

   !> Integers of a checkpoint; none if it has no loads.
   subroutine saved(state, name, values, error)
      type(state_t), intent(in) :: state
      character(len=*), intent(in) :: name
      integer(int64), allocatable, intent(out) :: values(:)
      type(error_t), allocatable, intent(out) :: error

      if (state%has(name)) then
         call state%get(name, values, error)
      else
         allocate (values(0))
      end if
   end subroutine saved

   !> Slot of the first load with a region among those of a checkpoint, 0 = none.
   pure integer function slot_of(regions, key) result(slot)
      integer(int64), intent(in) :: regions(:)        !! (load) Keys, 0 = without a slot
      integer(int64), intent(in) :: key
      integer :: n

      n = findloc(regions, key, 1)
      slot = count(regions(:n) /= 0)
   end function slot_of

   !> Functions of other loads in the columns of a store; those without a source are zero.
   pure subroutine move_columns(source, marks)
      integer, intent(in) :: source(:)                !! (slot) Slot in `marks`, 0 = none
      real(wp), allocatable, intent(inout) :: marks(:, :) !! (particle, 4 slots)
      real(wp), allocatable :: moved(:, :)
      integer :: n

      allocate (moved(size(marks, 1), mark_columns*size(source)), source=0.0_wp)
      do n = 1, size(source)
         if (source(n) == 0) cycle
         moved(:, mark_columns*(n - 1) + 1:mark_columns*n) = &
            marks(:, mark_columns*(source(n) - 1) + 1:mark_columns*source(n))
      end do
      call move_alloc(moved, marks)
   end subroutine move_columns
end module output_load_state
