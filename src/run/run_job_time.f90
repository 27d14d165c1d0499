! SPDX-License-Identifier: BSD-3-Clause
!> Remaining wall time of a Slurm job, requested once at the start of a run.
! allow(C071, C072): texts of C have no length
module run_job_time
   use base_communicator, only: communicator_t
   use base_error, only: error_t, exit_input, fail
   use base_kinds, only: int64, wp
   use base_libc, only: c_time
   use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_int, c_null_char, &
      c_null_ptr, c_ptr
   implicit none
   private

   public :: job_seconds_left, no_job, span_seconds

   integer, parameter :: longest_answer = 256        !! Characters of a line
   real(wp), parameter :: unlimited = 1.0e12_wp      !! Seconds of a job without an end
   real(wp), parameter :: no_job = huge(1.0_wp)      !! Seconds of a run outside of a job

   interface
      !> Start a command and return its output as a stream.
      function c_popen(command, mode) bind(c, name="popen") result(stream)
         import :: c_char, c_ptr
         implicit none
         character(kind=c_char), intent(in) :: command(*) !! Null-terminated
         character(kind=c_char), intent(in) :: mode(*)    !! Null-terminated
         type(c_ptr) :: stream
      end function c_popen

      !> Read a line.
      function c_fgets(line, length, stream) bind(c, name="fgets") result(answer)
         import :: c_char, c_int, c_ptr
         implicit none
         character(kind=c_char), intent(inout) :: line(*) !! Gets the line and a null
         integer(c_int), value :: length             !! Capacity of the line
         type(c_ptr), value :: stream                !! From popen
         type(c_ptr) :: answer
      end function c_fgets

      !> Wait for the end of a command.
      function c_pclose(stream) bind(c, name="pclose") result(status)
         import :: c_int, c_ptr
         implicit none
         type(c_ptr), value :: stream                !! From popen
         integer(c_int) :: status
      end function c_pclose
   end interface

contains

   !> Wall time until the end of the Slurm job of this run, from SLURM_JOB_END_TIME or else from
   !! `squeue`. Outside of Slurm the time is not limited, so that a deck for a cluster also runs on
   !! a workstation. Collective.
   subroutine job_seconds_left(communicator, seconds, error)
      type(communicator_t), intent(in) :: communicator
      real(wp), intent(out) :: seconds               !! [s]; `no_job` outside of a job
      type(error_t), allocatable, intent(out) :: error !! The end of the job is not known
      character(len=:), allocatable :: word
      integer(int64) :: ends
      integer :: status

      seconds = -1.0_wp
      if (communicator%rank == 0) then
         word = environment_value("SLURM_JOB_END_TIME")
         read (word, *, iostat=status) ends
         if (len(word) > 0 .and. status == 0) then
            seconds = max(real(ends - int(c_time(c_null_ptr), int64), wp), 0.0_wp)
         else
            word = environment_value("SLURM_JOB_ID")
            if (len(word) == 0) seconds = no_job
            if (len(word) > 0 .and. verify(word, "0123456789_") == 0) &
               seconds = span_seconds(first_line("squeue -h -j "//word//" -o %L 2>/dev/null"))
         end if
      end if
      seconds = communicator%maximum(seconds)
      if (seconds < 0.0_wp) call fail(error, exit_input, "wall_limit = 'slurm': the end "// &
         "of the job is not known, neither from SLURM_JOB_END_TIME nor from squeue; "// &
         "write hours, minutes and seconds such as '03:30:00' instead [R122]")
   end subroutine job_seconds_left

   !> Value of an environment variable, empty if it is not set.
   function environment_value(name) result(value)
      character(len=*), intent(in) :: name           !! Name of the variable
      character(len=:), allocatable :: value
      integer :: length

      call get_environment_variable(name, length=length)
      allocate (character(len=length) :: value)
      if (length > 0) call get_environment_variable(name, value)
   end function environment_value

   !> First line that a command prints, empty if it fails.
   function first_line(command) result(line)
      character(len=*), intent(in) :: command        !! For the shell
      character(len=:), allocatable :: line
      character(kind=c_char) :: buffer(longest_answer)
      type(c_ptr) :: stream
      integer :: n

      line = ""
      stream = c_popen(command//c_null_char, "r"//c_null_char)
      if (.not. c_associated(stream)) return
      buffer = c_null_char
      if (c_associated(c_fgets(buffer, int(longest_answer, c_int), stream))) then
         do n = 1, longest_answer
            if (buffer(n) == c_null_char .or. buffer(n) == new_line("a")) exit
            line = line//buffer(n)
         end do
      end if
      if (c_pclose(stream) /= 0) line = ""
   end function first_line

   !> Seconds of a duration of Slurm, days-hours:minutes:seconds with optional leading parts, or
   !! UNLIMITED; negative for any other text.
   pure real(wp) function span_seconds(text) result(seconds)
      character(len=*), intent(in) :: text           !! Such as 1-03:30:00
      character(len=len(text)) :: rest
      integer :: number(4), parts, place, status

      seconds = -1.0_wp
      rest = adjustl(text)
      if (rest == "UNLIMITED") seconds = unlimited
      if (len_trim(rest) == 0 .or. verify(trim(rest), "0123456789:-") > 0) return
      number = 0
      place = index(rest, "-")
      if (place > 0) then
         read (rest(:place - 1), *, iostat=status) number(1)
         if (status /= 0) return
         rest = rest(place + 1:)
      end if
      do parts = 1, 3
         place = index(rest//":", ":")
         number(2:3) = number(3:4)
         read (rest(:place - 1), *, iostat=status) number(4)
         if (status /= 0) return
         if (place > len_trim(rest)) exit
         rest = rest(place + 1:)
      end do
      if (parts > 3) return
      seconds = 86400.0_wp*real(number(1), wp) + 3600.0_wp*real(number(2), wp) &
         + 60.0_wp*real(number(3), wp) + real(number(4), wp)
   end function span_seconds
end module run_job_time
