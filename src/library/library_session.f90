! SPDX-License-Identifier: BSD-3-Clause
!> A simulation in the process of another program. Like the program scree it uses `run_t`,
!! but it writes to the screen only on request, and does not change the signals and the number of
!! threads of the caller.
module library_session
   use base_communicator, only: message_passing_has_ended, message_passing_has_started
   use base_error, only: code_last, error_t, exit_input, exit_success, fail, without_code
   use base_kinds, only: int64, wp
   use base_text, only: text_t
   use, intrinsic :: iso_c_binding, only: c_char
   use omp_lib, only: omp_get_max_threads, omp_set_num_threads
   use run_setup, only: a_scene
   use run_threads, only: share_cores
   use run_type, only: run_t
   implicit none
   private

   public :: library_session_t

   !> A session, with the data for its caller.
   type, extends(run_t) :: library_session_t
      logical :: running = .false.                   !! Has it begun, and not been ended?
      logical :: began_messages = .false.            !! Did it start MPI?
      logical :: copied = .false.                    !! Has it a duplicated communicator?
      integer :: threads = 1                         !! Threads between calls
      integer(int64) :: generation = 0               !! Changes whenever views become invalid
      character(len=:), allocatable :: message       !! Message of the last error
      character(kind=c_char), allocatable :: answer(:) !! Text for the caller, ends with a null
   contains
      procedure :: open => session_open              !! Deck to first state
      procedure :: step => session_step              !! Some steps
      procedure :: write_output => session_write_output !! All output now
      procedure :: write_checkpoint => session_write_checkpoint !! A checkpoint now
      procedure :: finish => session_finish          !! End the run, with its summary
      procedure :: close => session_close            !! Give everything back
      procedure :: refuse_ended => session_refuse_ended !! Error if it does not run
      procedure :: note => session_note              !! Exit code of an error, keeps its message
   end type library_session_t

contains

   !> Read the deck and make the first state. Collective.
   integer function session_open(self, arguments, given, communicator) result(code)
      class(library_session_t), intent(inout) :: self
      type(text_t), intent(in) :: arguments(:)       !! As on the command line of scree
      logical, intent(in) :: given                   !! Is there a communicator?
      integer, intent(in) :: communicator            !! Fortran handle of the communicator
      type(error_t), allocatable :: error
      integer :: host

      host = omp_get_max_threads()
      call self%options%parse(arguments, error)
      self%log%mute = self%options%quiet
      if (.not. allocated(error)) call join_ranks(self, given, communicator, error)
      if (.not. allocated(error)) then
         call share_cores()
         ! rank 0 reads the deck; the others need not know where it is
         call self%simulation%machine%communicator%broadcast(self%options%deck)
         call self%read(a_scene, error)
      end if
      if (.not. allocated(error)) call self%build(.true., error)
      if (.not. allocated(error)) then
         ! signals belong to the caller
         deallocate (self%limits%signals)
         allocate (character(len=4) :: self%limits%signals(0))
         call self%limit_threads()
         call self%start(error)
         self%running = .not. allocated(error)
      end if
      if (.not. self%running) call self%lock%release()
      self%threads = omp_get_max_threads()
      call omp_set_num_threads(host)
      if (allocated(self%failure)) then
         code = self%finish()
      else
         code = self%note(error)
      end if
   end function session_open

   !> Use a copy of the communicator of the caller, or of all ranks. Collective.
   subroutine join_ranks(self, given, communicator, error)
      class(library_session_t), intent(inout) :: self
      logical, intent(in) :: given                   !! Is there a communicator?
      integer, intent(in) :: communicator            !! Fortran handle of the communicator
      type(error_t), allocatable, intent(out) :: error !! MPI is not available
      integer :: all, hints

      if (message_passing_has_started()) then
         if (message_passing_has_ended()) then
            call fail(error, exit_input, "MPI was finalised in this process, so no "// &
               "simulation can start; start it earlier, or in another process [R130]")
            return
         end if
      else if (given) then
         call fail(error, exit_input, "a communicator needs MPI to be initialised [R130]")
         return
      end if
      associate (own => self%simulation%machine%communicator)
         self%began_messages = .not. message_passing_has_started()
         call own%start()
         call own%native(all, hints)
         if (given) all = communicator
         call own%duplicate(all)
         self%copied = .true.
      end associate
   end subroutine join_ranks

   !> Do steps until a number of them, a time, or the end of the run is reached. The last step is
   !! not shortened to end at the time, so results do not depend on how steps are called.
   !! Collective.
   integer function session_step(self, steps, until) result(code)
      class(library_session_t), intent(inout) :: self
      integer(int64), intent(in) :: steps            !! Maximum number of steps
      real(wp), intent(in) :: until                  !! No step starts at or after this time [s]
      type(error_t), allocatable :: error
      integer(int64) :: last
      integer :: host

      call self%refuse_ended(error)
      if (allocated(error)) then
         code = self%note(error)
         return
      end if
      code = exit_success
      host = omp_get_max_threads()
      call omp_set_num_threads(self%threads)
      last = self%simulation%clock%step + min(steps, huge(last) - self%simulation%clock%step)
      do while (.not. self%loop%finished .and. self%simulation%clock%step < last .and. &
         self%simulation%clock%time < until)
         self%generation = self%generation + 1
         call self%advance()
      end do
      self%threads = omp_get_max_threads()
      call omp_set_num_threads(host)
      if (allocated(self%failure)) code = self%finish()
   end function session_step

   !> Write the present state to all output streams. Collective.
   integer function session_write_output(self) result(code)
      class(library_session_t), intent(inout) :: self
      type(error_t), allocatable :: error

      call self%refuse_ended(error)
      if (.not. allocated(error)) call self%loop%write_all(self%simulation, self%outputs, &
         self%log, error)
      code = self%note(error)
   end function session_write_output

   !> Write a checkpoint. Collective.
   integer function session_write_checkpoint(self) result(code)
      class(library_session_t), intent(inout) :: self
      type(error_t), allocatable :: error

      call self%refuse_ended(error)
      if (.not. allocated(error)) call self%loop%checkpoint(self%simulation, self%outputs, &
         self%place, self%log, error)
      code = self%note(error)
   end function session_write_checkpoint

   !> End the run, finished or not: last output, summary, and the exit code of the program.
   !! Collective.
   integer function session_finish(self) result(code)
      class(library_session_t), intent(inout) :: self
      type(error_t), allocatable :: error
      integer :: host

      call self%refuse_ended(error)
      if (.not. allocated(error)) then
         host = omp_get_max_threads()
         call omp_set_num_threads(self%threads)
         call self%end(code, error)
         call omp_set_num_threads(host)
         if (allocated(error)) call self%log%error(error%message)
         call self%log%close()
         self%running = .false.
         self%generation = self%generation + 1
         if (.not. allocated(error)) then
            self%message = without_code(self%loop%reason)
            return
         end if
      end if
      code = self%note(error)
   end function session_finish

   !> Release files and communicator. An unfinished run gets no summary. Collective.
   subroutine session_close(self)
      class(library_session_t), intent(inout) :: self
      type(error_t), allocatable :: ignored

      if (self%running) call self%outputs%close(self%simulation%machine%communicator, ignored)
      call self%lock%release()
      call self%log%close()
      self%running = .false.
      if (self%copied) call self%simulation%machine%communicator%release()
      self%copied = .false.
   end subroutine session_close

   !> Refuse a call for a run that has ended or could not start.
   subroutine session_refuse_ended(self, error)
      class(library_session_t), intent(in) :: self
      type(error_t), allocatable, intent(out) :: error

      if (.not. self%running) call fail(error, exit_input, &
         "the simulation has ended; create a new one [R129]")
   end subroutine session_refuse_ended

   !> Keep the message of an error and return its exit code; 0 without an error.
   integer function session_note(self, error) result(code)
      class(library_session_t), intent(inout) :: self
      type(error_t), allocatable, intent(in) :: error

      code = exit_success
      self%message = ""
      if (.not. allocated(error)) return
      code = error%code
      self%message = code_last(error%message)
   end function session_note
end module library_session
