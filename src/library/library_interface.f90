! SPDX-License-Identifier: BSD-3-Clause
!> The interface of the library libscree to C, Python and other languages: doc/guide/in_process.md.
!! Functions return the exit codes of the program, 0 = success; `scree_text` gives the message.
!! Functions marked as collective are called by all ranks of the communicator.
! allow(C071): texts of C have no length
module library_interface
   use base_communicator, only: communicator_t
   use base_error, only: error_t, exit_input, exit_internal, exit_success, fail, without_code
   use base_kinds, only: int64, wp
   use base_text, only: text_t
   use, intrinsic :: iso_c_binding, only: c_char, c_double, c_f_pointer, c_int, &
      c_int64_t, c_loc, c_null_ptr, c_ptr
   use library_controls, only: control_names, get_control, set_control
   use library_fields, only: field_list, field_view_t, find_field
   use library_session, only: library_session_t
   use library_text, only: from_c, to_c, words_from_c
   use step_sort_particles, only: count_particles
   implicit none
   private

   public :: scree_checkpoint, scree_close, scree_control, scree_end_messages, scree_field, &
      scree_finish, scree_open, scree_output, scree_state, scree_step, scree_steer, scree_text, &
      run_state_t

   !> Texts that `scree_text` gives.
   integer(c_int), parameter, public :: text_message = 0, text_folder = 1, text_case = 2, &
      text_reason = 3, text_controls = 4, text_store = 5, text_fields = 6

   !> State of a simulation between calls.
   type, bind(c) :: run_state_t
      real(c_double) :: time = 0                     !! [s]
      real(c_double) :: dt = 0                       !! Length of the last time step [s]
      real(c_double) :: dt_next = 0                  !! Next stable step [s]
      real(c_double) :: time_end = 0                 !! End of the run [s]
      integer(c_int64_t) :: step = 0                 !! Steps done
      integer(c_int64_t) :: particles = 0            !! Number of particles of this rank
      integer(c_int64_t) :: generation = 0           !! Views of an earlier one are invalid
      integer(c_int64_t) :: warnings = 0             !! In the log
      integer(c_int) :: stores = 0                   !! Particle stores
      integer(c_int) :: rank = 0                     !! This rank, from 0
      integer(c_int) :: ranks = 1                    !! Number of ranks
      integer(c_int) :: running = 0                  !! 1 until `scree_finish` or an error
      integer(c_int) :: finished = 0                 !! 1 = the run is finished
      integer(c_int) :: began_messages = 0           !! 1 = this simulation started MPI
   end type run_state_t

   !> What a handle points to. It is small and never freed, so that a handle that was closed is
   !! recognised, and so is, almost certainly, an address of anything else.
   type :: handle_t
      integer(int64) :: mark = 0                     !! `valid_mark` and the address of the handle
      type(library_session_t), pointer :: session => null()
   end type handle_t

   integer(int64), parameter :: valid_mark = int(z"5C4EE0A7D1B26F93", int64) !! Any number
   integer(int64), parameter :: least_address = 65536 !! No memory of a process is below
   integer(int64), parameter :: alignment = 8        !! Of all allocated memory, in bytes

contains

   !> Read a deck and make its first state. A handle is returned also with an error, for its
   !! message, and has to be closed. Collective.
   integer(c_int) function scree_open(words, count, given, communicator, handle) &
      bind(c) result(code)
      character(kind=c_char), intent(in) :: words(*) !! Arguments of scree, each ends with a null
      integer(c_int), value, intent(in) :: count     !! Their number
      integer(c_int), value, intent(in) :: given     !! 1 = use `communicator`, 0 = all ranks
      integer(c_int), value, intent(in) :: communicator !! Fortran handle of MPI
      type(c_ptr), intent(out) :: handle
      type(handle_t), pointer :: place
      type(text_t), allocatable :: arguments(:)

      allocate (place)
      allocate (place%session)
      handle = c_loc(place)
      place%mark = ieor(valid_mark, transfer(handle, place%mark))
      call words_from_c(words, int(count), arguments)
      code = int(place%session%open(arguments, given == 1, int(communicator)), c_int)
   end function scree_open

   !> Do steps until a number of them, a time, or the end of the run is reached. Views of fields
   !! become invalid. Collective.
   integer(c_int) function scree_step(handle, steps, until) bind(c) result(code)
      type(c_ptr), value, intent(in) :: handle
      integer(c_int64_t), value, intent(in) :: steps !! Maximum number of steps
      real(c_double), value, intent(in) :: until     !! No step begins from this time on [s]
      type(library_session_t), pointer :: session

      code = exit_internal
      call find_session(handle, session)
      if (associated(session)) code = int(session%step(int(steps, int64), real(until, wp)), c_int)
   end function scree_step

   !> State of a simulation.
   integer(c_int) function scree_state(handle, state) bind(c) result(code)
      type(c_ptr), value, intent(in) :: handle
      type(run_state_t), intent(out) :: state
      type(library_session_t), pointer :: session

      code = exit_internal
      call find_session(handle, session)
      if (.not. associated(session)) return
      code = exit_success
      associate (simulation => session%simulation, clock => session%simulation%clock)
         state%time = clock%time
         state%dt = clock%dt
         state%dt_next = clock%dt_next
         state%time_end = session%limits%time_end
         state%step = clock%step
         state%generation = session%generation
         state%warnings = int(session%log%warnings, c_int64_t)
         state%rank = int(simulation%machine%communicator%rank, c_int)
         state%ranks = int(simulation%machine%communicator%size, c_int)
         state%running = merge(1_c_int, 0_c_int, session%running)
         state%finished = merge(1_c_int, 0_c_int, session%loop%finished)
         state%began_messages = merge(1_c_int, 0_c_int, session%began_messages)
         if (.not. allocated(simulation%stores)) return
         state%particles = int(count_particles(simulation%stores), c_int64_t)
         state%stores = size(simulation%stores, kind=c_int)
      end associate
   end function scree_state

   !> A text, valid until the next call for this simulation: the message of the last error, folder
   !! and case of the results, why the run ended; controls, one per line with its number of
   !! components; the material of a store; its fields, one per line with name, unit, components, 1
   !! for integers, and 1 if writable.
   type(c_ptr) function scree_text(handle, what, index) bind(c) result(text)
      type(c_ptr), value, intent(in) :: handle
      integer(c_int), value, intent(in) :: what      !! One of the constants `text_`
      integer(c_int), value, intent(in) :: index     !! Store, from 0
      type(library_session_t), pointer :: session

      text = c_null_ptr
      call find_session(handle, session)
      if (.not. associated(session)) return
      session%answer = to_c(answer(session, int(what), int(index) + 1))
      text = c_loc(session%answer)
   end function scree_text

   !> The text of `scree_text`; empty if there is none.
   function answer(session, what, place) result(text)
      type(library_session_t), intent(in) :: session
      integer, intent(in) :: what                    !! One of the constants `text_`
      integer, intent(in) :: place                   !! Store, from 1
      character(len=:), allocatable :: text
      logical :: known

      text = ""
      known = .false.
      if (allocated(session%simulation%stores)) known = place >= 1 .and. &
         place <= size(session%simulation%stores)
      select case (what)
      case (text_message)
         if (allocated(session%message)) text = session%message
      case (text_folder)
         if (allocated(session%outputs%folder)) text = session%outputs%folder
      case (text_case)
         if (allocated(session%outputs%case)) text = session%outputs%case
      case (text_reason)
         if (allocated(session%loop%reason)) text = without_code(session%loop%reason)
      case (text_controls)
         text = control_names(session%simulation)
      case (text_store)
         if (known) text = session%simulation%stores(place)%name
      case (text_fields)
         if (known) text = field_list(session%simulation%stores(place))
      case default
         text = ""
      end select
   end function answer

   !> Memory of a field of a store, valid until the next step or the end of the simulation.
   integer(c_int) function scree_field(handle, store, name, view) bind(c) result(code)
      type(c_ptr), value, intent(in) :: handle
      integer(c_int), value, intent(in) :: store     !! From 0
      character(kind=c_char), intent(in) :: name(*)  !! Name of the field, ends with a null
      type(field_view_t), intent(out) :: view
      type(library_session_t), pointer :: session
      type(error_t), allocatable :: error

      code = exit_internal
      call find_session(handle, session)
      if (.not. associated(session)) return
      call session%refuse_ended(error)
      if (.not. allocated(error)) then
         if (store < 0 .or. store >= size(session%simulation%stores)) then
            call fail(error, exit_input, "no such particle store [R128]")
         else
            call find_field(session%simulation%stores(store + 1), from_c(name), view)
            if (view%components == 0) call fail(error, exit_input, "no field '"//from_c(name)// &
               "' in this simulation [R128]")
         end if
      end if
      code = int(session%note(error), c_int)
   end function scree_field

   !> Present value of a control.
   integer(c_int) function scree_control(handle, name, values) bind(c) result(code)
      type(c_ptr), value, intent(in) :: handle
      character(kind=c_char), intent(in) :: name(*)  !! Ends with a null
      real(c_double), intent(out) :: values(3)       !! Velocity, factor or gravity
      type(library_session_t), pointer :: session
      type(error_t), allocatable :: error

      code = exit_internal
      call find_session(handle, session)
      if (.not. associated(session)) return
      call get_control(session%simulation, from_c(name), values, error)
      code = int(session%note(error), c_int)
   end function scree_control

   !> Change a control. All ranks give the same value.
   integer(c_int) function scree_steer(handle, name, values) bind(c) result(code)
      type(c_ptr), value, intent(in) :: handle
      character(kind=c_char), intent(in) :: name(*)  !! Ends with a null
      real(c_double), intent(in) :: values(3)        !! Velocity, factor or gravity
      type(library_session_t), pointer :: session
      type(error_t), allocatable :: error

      code = exit_internal
      call find_session(handle, session)
      if (.not. associated(session)) return
      call session%refuse_ended(error)
      if (.not. allocated(error)) call set_control(session%simulation, from_c(name), values, error)
      code = int(session%note(error), c_int)
   end function scree_steer

   !> Write the present state to all output streams. Collective.
   integer(c_int) function scree_output(handle) bind(c) result(code)
      type(c_ptr), value, intent(in) :: handle
      type(library_session_t), pointer :: session

      code = exit_internal
      call find_session(handle, session)
      if (associated(session)) code = int(session%write_output(), c_int)
   end function scree_output

   !> Write a checkpoint. Collective.
   integer(c_int) function scree_checkpoint(handle) bind(c) result(code)
      type(c_ptr), value, intent(in) :: handle
      type(library_session_t), pointer :: session

      code = exit_internal
      call find_session(handle, session)
      if (associated(session)) code = int(session%write_checkpoint(), c_int)
   end function scree_checkpoint

   !> End a run, with its last output and summary. Collective.
   integer(c_int) function scree_finish(handle) bind(c) result(code)
      type(c_ptr), value, intent(in) :: handle
      type(library_session_t), pointer :: session

      code = exit_internal
      call find_session(handle, session)
      if (associated(session)) code = int(session%finish(), c_int)
   end function scree_finish

   !> Free a simulation, finished or not. Its handle is invalid afterwards. Collective.
   integer(c_int) function scree_close(handle) bind(c) result(code)
      type(c_ptr), value, intent(in) :: handle
      type(library_session_t), pointer :: session
      type(handle_t), pointer :: place

      code = exit_internal
      call find_session(handle, session)
      if (.not. associated(session)) return
      call c_f_pointer(handle, place)
      place%mark = 0
      call session%close()
      deallocate (session)
      code = exit_success
   end function scree_close

   !> Finish MPI. For a process in which a simulation started it, after the last simulation.
   integer(c_int) function scree_end_messages() bind(c) result(code)
      type(communicator_t) :: communicator

      call communicator%finish()
      code = exit_success
   end function scree_end_messages

   !> The session of a handle; not associated if the handle is null, was closed, or is none.
   subroutine find_session(handle, session)
      type(c_ptr), intent(in) :: handle
      type(library_session_t), pointer, intent(out) :: session
      type(handle_t), pointer :: place
      integer(int64) :: address

      nullify (session)
      address = transfer(handle, address)
      if (address < least_address .or. mod(address, alignment) /= 0) return
      call c_f_pointer(handle, place)
      if (place%mark == ieor(valid_mark, address)) session => place%session
   end subroutine find_session
end module library_interface
