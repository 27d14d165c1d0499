! SPDX-License-Identifier: BSD-3-Clause
!> State of a run other than its particles, for checkpoints: step, time, and named values.
module io_state
   use base_error, only: error_t, exit_file, fail
   use base_kinds, only: int64, wp
   implicit none
   private

   public :: entry_t, state_t

   !> Named values, either real or integer.
   type :: entry_t
      character(len=:), allocatable :: name               !! Unique
      real(wp), allocatable :: reals(:)                   !! Allocated if real
      integer(int64), allocatable :: integers(:)            !! Allocated if integer
   end type entry_t

   !> State of a run other than its particles. The same on all ranks.
   type :: state_t
      integer(int64) :: step = 0                          !! Steps done
      real(wp) :: time = 0.0_wp                           !! Simulated time [s]
      real(wp) :: dt_next = 0.0_wp                        !! Length of the next step [s]
      type(entry_t), allocatable :: entries(:)            !! In the order of insertion
   contains
      procedure :: place => state_place                   !! Index of an entry, 0 if absent
      procedure :: has => state_has                       !! Is there an entry of this name?
      procedure, private :: set_reals, set_integers, get_reals, get_integers, find_or_add
      !> Store values under a name.
      generic :: set => set_reals, set_integers
      !> Get the values of a name.
      generic :: get => get_reals, get_integers
   end type state_t

contains

   !> Index of an entry, 0 if there is none.
   pure integer function state_place(self, name) result(place)
      class(state_t), intent(in) :: self
      character(len=*), intent(in) :: name                !! Name of an entry
      integer :: index

      place = 0
      if (.not. allocated(self%entries)) return
      do index = 1, size(self%entries)
         if (self%entries(index)%name == name) place = index
      end do
   end function state_place

   !> True if there is an entry of this name.
   pure logical function state_has(self, name) result(has)
      class(state_t), intent(in) :: self
      character(len=*), intent(in) :: name                !! Name of an entry

      has = self%place(name) > 0
   end function state_has

   !> Empty the entry of a name, and add it if it is new.
   subroutine find_or_add(self, name, place)
      class(state_t), intent(inout) :: self
      character(len=*), intent(in) :: name                !! Name of the entry
      integer, intent(out) :: place                       !! Index
      type(entry_t), allocatable :: larger(:)
      integer :: index

      if (.not. allocated(self%entries)) allocate (self%entries(0))
      place = self%place(name)
      if (place == 0) then
         place = size(self%entries) + 1
         allocate (larger(place))
         do index = 1, place - 1
            call move_alloc(self%entries(index)%name, larger(index)%name)
            call move_alloc(self%entries(index)%reals, larger(index)%reals)
            call move_alloc(self%entries(index)%integers, larger(index)%integers)
         end do
         call move_alloc(larger, self%entries)
      end if
      self%entries(place)%name = name
      if (allocated(self%entries(place)%reals)) deallocate (self%entries(place)%reals)
      if (allocated(self%entries(place)%integers)) deallocate (self%entries(place)%integers)
   end subroutine find_or_add

   !> Store reals under a name.
   subroutine set_reals(self, name, values)
      class(state_t), intent(inout) :: self
      character(len=*), intent(in) :: name                !! Name of the entry
      real(wp), intent(in) :: values(:)                   !! Values
      integer :: place

      call self%find_or_add(name, place)
      allocate (self%entries(place)%reals(size(values)))
      self%entries(place)%reals(:) = values
   end subroutine set_reals

   !> Store integers under a name.
   subroutine set_integers(self, name, values)
      class(state_t), intent(inout) :: self
      character(len=*), intent(in) :: name                !! Name of the entry
      integer(int64), intent(in) :: values(:)             !! Values
      integer :: place

      call self%find_or_add(name, place)
      allocate (self%entries(place)%integers(size(values)))
      self%entries(place)%integers(:) = values
   end subroutine set_integers

   !> Get the reals of a name.
   subroutine get_reals(self, name, values, error)
      class(state_t), intent(in) :: self
      character(len=*), intent(in) :: name                !! Name of the entry
      real(wp), allocatable, intent(out) :: values(:)     !! Values
      type(error_t), allocatable, intent(out) :: error    !! There is no such entry
      integer :: place

      place = self%place(name)
      if (place > 0) then
         if (allocated(self%entries(place)%reals)) then
            allocate (values, source=self%entries(place)%reals)
            return
         end if
      end if
      call fail(error, exit_file, "the checkpoint has no real values '"//name//"' [F112]")
   end subroutine get_reals

   !> Get the integers of a name.
   subroutine get_integers(self, name, values, error)
      class(state_t), intent(in) :: self
      character(len=*), intent(in) :: name                !! Name of the entry
      integer(int64), allocatable, intent(out) :: values(:) !! Values
      type(error_t), allocatable, intent(out) :: error    !! There is no such entry
      integer :: place

      place = self%place(name)
      if (place > 0) then
         if (allocated(self%entries(place)%integers)) then
            allocate (values, source=self%entries(place)%integers)
            return
         end if
      end if
      call fail(error, exit_file, "the checkpoint has no integers '"//name//"' [F112]")
   end subroutine get_integers
end module io_state
