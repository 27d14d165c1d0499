! SPDX-License-Identifier: BSD-3-Clause
!> The log of rank 0 on the screen and in a file.
module base_log
   use base_error, only: code_last, error_t, exit_file, explain_hint, fail, with_hint
   use base_kinds, only: int64, wp
   use, intrinsic :: iso_fortran_env, only: error_unit, output_unit
   implicit none
   private

   public :: duration, log_t, progress_heading, progress_line, progress_row_t

   !> Levels. A line is written if its level is not above that of the log.
   integer, parameter, public :: log_error = 0, log_warn = 1, log_info = 2
   integer, parameter :: no_unit = 0                     !! No file is open

   !> A log. Before `open` lines go only to the screen.
   type :: log_t
      integer :: level = log_info                        !! Greatest level written
      integer :: warnings = 0                            !! Warnings so far
      logical :: mute = .false.                          !! Is nothing written to the screen?
      logical, private :: writes = .true.                !! Does this rank write?
      logical, private :: screen = .true.                !! Also to the screen?
      integer, private :: unit = no_unit                 !! Unit of the file
      logical, private :: hinted = .false.               !! Was the hint of a message printed?
   contains
      procedure :: open => log_open                      !! Choose rank, file and level
      procedure :: error => log_print_error              !! Errors
      procedure :: warn => log_print_warning             !! Warnings
      procedure :: info => log_print_info                !! Progress and results
      procedure :: close => log_close                    !! Close the file
   end type log_t

   !> Content of a line of progress.
   type :: progress_row_t
      real(wp) :: wall = 0.0_wp                          !! Wall time so far [s]
      real(wp) :: time = 0.0_wp                          !! Simulated time [s]
      real(wp) :: time_end = 0.0_wp                      !! End of simulated time [s]
      integer(int64) :: step = 0                         !! Steps so far
      real(wp) :: step_length = 0.0_wp                   !! Time step [s]
      real(wp) :: kinetic = 0.0_wp                       !! Kinetic energy [J]
      real(wp) :: energy_error = 0.0_wp                  !! Relative error of the energy ledger
      integer(int64) :: particles = 0                    !! Number of particles on all ranks
      real(wp) :: updates_per_second = 0.0_wp            !! Particle updates a second [1/s]
      real(wp) :: seconds_left = 0.0_wp !! Remaining wall time [s], negative: not known
   end type progress_row_t

contains

   !> Open the log of a rank.
   subroutine log_open(self, rank, path, level, quiet, error)
      class(log_t), intent(inout) :: self
      integer, intent(in) :: rank                        !! Only rank 0 writes
      character(len=*), intent(in), optional :: path     !! File, replaced
      integer, intent(in), optional :: level             !! Greatest level written
      logical, intent(in), optional :: quiet             !! Screen shows warnings and errors only
      type(error_t), allocatable, intent(out) :: error   !! The file cannot be written
      character(len=256) :: reason
      integer :: status

      self%writes = rank == 0
      if (present(level)) self%level = level
      if (present(quiet)) self%screen = .not. quiet
      if (.not. present(path) .or. .not. self%writes) return
      call self%close()
      open (newunit=self%unit, file=path, action="write", status="replace", iostat=status, &
         iomsg=reason)
      if (status == 0) return
      self%unit = no_unit
      call fail(error, exit_file, "cannot write the log: "//trim(reason)//" [F103]")
   end subroutine log_open

   !> Write an error, also to the standard error stream, quiet or not.
   subroutine log_print_error(self, text)
      class(log_t), intent(inout) :: self
      character(len=*), intent(in) :: text               !! One or more lines

      if (self%writes) call write_message(self, text)
   end subroutine log_print_error

   !> Write a warning, also to the standard error stream, quiet or not.
   subroutine log_print_warning(self, text)
      class(log_t), intent(inout) :: self
      character(len=*), intent(in) :: text               !! One or more lines

      self%warnings = self%warnings + 1
      if (self%writes .and. self%level >= log_warn) call write_message(self, text)
   end subroutine log_print_warning

   !> Write an error or a warning, its code last, and once how to read more about it.
   subroutine write_message(self, text)
      class(log_t), intent(inout) :: self
      character(len=*), intent(in) :: text               !! One or more lines
      character(len=:), allocatable :: lines

      lines = code_last(text)
      if (.not. self%hinted) lines = with_hint(lines)
      self%hinted = self%hinted .or. explain_hint(lines) /= ""
      if (.not. self%mute) call write_to_stream(error_unit, lines)
      call write_to_file(self, lines)
   end subroutine write_message

   !> Write progress and results.
   subroutine log_print_info(self, text)
      class(log_t), intent(inout) :: self
      character(len=*), intent(in) :: text               !! One or more lines

      if (.not. self%writes .or. self%level < log_info) return
      if (self%screen .and. .not. self%mute) call write_to_stream(output_unit, text)
      call write_to_file(self, text)
   end subroutine log_print_info

   !> Close the file.
   subroutine log_close(self)
      class(log_t), intent(inout) :: self
      integer :: status

      if (self%unit == no_unit) return
      close (self%unit, iostat=status)
      self%unit = no_unit
      if (status /= 0 .and. .not. self%mute) call write_to_stream(error_unit, &
         "warning: the end of the log is lost")
   end subroutine log_close

   !> Write to the file, if there is one. After a write error, such as a full disk, the file is
   !! closed and the run continues.
   subroutine write_to_file(self, text)
      class(log_t), intent(inout) :: self
      character(len=*), intent(in) :: text               !! One or more lines
      integer :: status

      if (self%unit == no_unit) return
      write (self%unit, "(a)", iostat=status) text
      if (status == 0) flush (self%unit, iostat=status)
      if (status == 0) return
      close (self%unit, iostat=status)
      self%unit = no_unit
      if (.not. self%mute) call write_to_stream(error_unit, &
         "warning: the log cannot be written; it continues only on the screen")
   end subroutine write_to_file

   !> Write to a standard stream and flush it. A closed stream is not an error.
   subroutine write_to_stream(unit, text)
      integer, intent(in) :: unit                        !! A standard stream
      character(len=*), intent(in) :: text               !! One or more lines
      integer :: status

      write (unit, "(a)", iostat=status) text
      if (status == 0) flush (unit, iostat=status)
   end subroutine write_to_stream

   !> Heading above the lines of progress.
   pure function progress_heading() result(text)
      character(len=:), allocatable :: text

      text = "     wall   t/t_end       step     dt [s]  E_kin [J]    dE/E0   particles   Mpt/s"// &
         "       left"
   end function progress_heading

   !> One line of progress.
   function progress_line(progress) result(text)
      type(progress_row_t), intent(in) :: progress           !! Current state
      character(len=:), allocatable :: text
      character(len=120) :: line
      real(wp) :: share

      share = 0.0_wp
      if (progress%time_end > 0.0_wp) share = 100.0_wp*progress%time/progress%time_end
      write (line, "(a9, f8.1, a, i11, 2es11.2e2, es9.1e2, i12, f8.2, a11)") &
         duration(progress%wall), share, " %", progress%step, progress%step_length, &
         progress%kinetic, progress%energy_error, progress%particles, &
         1.0e-6_wp*progress%updates_per_second, duration(progress%seconds_left)
      text = trim(line)
   end function progress_line

   !> A duration as h:mm:ss.
   function duration(seconds) result(text)
      real(wp), intent(in) :: seconds                    !! Negative if not known [s]
      character(len=9) :: text
      integer(int64) :: whole

      text = "        -"
      if (.not. (seconds >= 0.0_wp .and. seconds < 3.5e8_wp)) return
      whole = nint(seconds, int64)
      write (text, "(i3, 2(a, i2.2))") whole/3600_int64, ":", mod(whole, 3600_int64)/60_int64, &
         ":", mod(whole, 60_int64)
      if (whole >= 3600000_int64) write (text, "(i8, a)") whole/86400_int64, "d"
   end function duration
end module base_log
