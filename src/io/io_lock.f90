! SPDX-License-Identifier: BSD-3-Clause
!> The lock of a case: a file CASE.lock beside its results, which exists while a run writes them.
!!
!! The file has one line: host, identity of the system, process, start of the process, start of the
!! run, and the time of the last sign of life. A run that was killed leaves its lock. On the same
!! system its process is looked up; on another one only the signs of life show whether it runs.
module io_lock
   use base_clock, only: clock_text
   use base_error, only: error_t, exit_file, fail
   use base_file, only: file_exists, join_path, make_folder, read_file, remove_file, rename_file
   use base_kinds, only: int64
   use base_libc, only: c_close, c_getpid, c_kill, c_open, c_readlink, c_rmdir, c_time, c_usleep, &
      c_write, failure_number, failure_text
   use base_process, only: node_name
   use base_text, only: number, split, text_t
   use, intrinsic :: iso_c_binding, only: c_int, c_int32_t, c_loc, c_null_char, c_null_ptr, c_size_t
   implicit none
   private

   public :: lock_t

   integer, parameter, public :: lock_taken = 0      !! This run has the lock
   integer, parameter, public :: lock_refused = 1    !! Another run has it
   integer, parameter, public :: lock_unclear = 2    !! Try again: a run on another host may have it

   integer, parameter :: beat_interval = 10          !! Between two signs of life [s]
   integer, parameter :: silence = 600               !! A lock of another host is old after it [s]
   !> A lock is watched at least so long before it is called old, since clocks of hosts can differ
   integer, parameter :: least_watch = 3*beat_interval
   integer, parameter :: empty_silence = 10          !! The same for a lock without a line [s]
   integer, parameter :: words_of_line = 6           !! See the head of this module
   integer(c_int), parameter :: write_only = 1, create_new = 64 + 128 !! O_CREAT and O_EXCL
   integer(c_int), parameter :: exists_already = 17, not_permitted = 1 !! EEXIST, EPERM
   integer(c_int32_t), parameter :: file_mode = int(o"666", c_int32_t)

   !> A lock. It belongs to one process, the first rank.
   type :: lock_t
      character(len=:), allocatable :: message       !! Owner, and what was found
      logical :: lost = .false.                      !! Has another run taken it over?
      character(len=:), allocatable, private :: path !! Its file; not allocated: no lock
      character(len=:), allocatable, private :: new_folder !! Folder that was made for it
      character(len=:), allocatable, private :: owner !! Line of this run without the sign of life
      character(len=:), allocatable, private :: seen !! Line of another run, as read before
      integer(c_int), private :: process = 0         !! The process that has it
      integer(int64), private :: since = 0           !! Time of that, or of the sign of life [s]
   contains
      procedure :: take => lock_take                 !! Try once to get it
      procedure :: beat => lock_beat                 !! Give a sign of life if it is time to
      procedure :: release => lock_release           !! Remove it
   end type lock_t

contains

   !> Try to get the lock of a case, and make the folder of its results. After `lock_unclear` the
   !! caller tries again. Local to a rank.
   subroutine lock_take(self, folder, case, verdict, error)
      class(lock_t), intent(inout) :: self
      character(len=*), intent(in) :: folder         !! Folder of the results
      character(len=*), intent(in) :: case           !! Prefix of all files
      integer, intent(out) :: verdict                !! One of the constants above
      type(error_t), allocatable, intent(out) :: error !! The lock cannot be read or written
      character(len=:), allocatable :: line, path
      logical :: made

      verdict = lock_taken
      if (.not. file_exists(join_path(folder, "."))) self%new_folder = folder
      call make_folder(folder, error)
      if (allocated(error)) return
      path = join_path(folder, case//".lock")
      if (.not. allocated(self%owner)) self%owner = own_line()
      call write_lock(path, self%owner//time_text(), made, error)
      if (allocated(error)) return
      if (made) then
         call keep(self, path)
         return
      end if
      call read_line(path, line)
      verdict = verdict_on(self, line)
      if (verdict == lock_taken) call take_over(self, path, line, verdict, error)
      if (verdict /= lock_taken .or. allocated(error)) return
      self%message = "the lock of an earlier run, "//owner_text(line)//", was taken over"
      call keep(self, path)
   end subroutine lock_take

   !> Note that this run has the lock.
   subroutine keep(lock, path)
      type(lock_t), intent(inout) :: lock
      character(len=*), intent(in) :: path           !! Its file

      lock%path = path
      lock%process = c_getpid()
      lock%since = now()
   end subroutine keep

   !> Whether a lock may be taken over.
   integer function verdict_on(lock, line) result(verdict)
      class(lock_t), intent(inout) :: lock           !! Remembers the line
      character(len=*), intent(in) :: line           !! Present line of the lock of another run
      type(text_t), allocatable :: own(:), other(:)
      integer(int64) :: age

      call split(line, other)
      call split(lock%owner, own)
      verdict = lock_unclear
      if (size(other) == words_of_line) then
         lock%message = owner_text(line)
         if (other(2)%text == own(2)%text) then
            verdict = lock_taken
            if (is_alive(integer_of(other(3)%text), integer_of(other(4)%text))) &
               verdict = lock_refused
            return
         end if
      else
         lock%message = "a lock without a line"
      end if
      if (.not. allocated(lock%seen)) then
         lock%seen = line
         lock%since = now()
         return
      end if
      age = now() - lock%since
      if (line /= lock%seen) then
         ! a sign of life, or another run that was faster
         verdict = lock_refused
         if (size(other) /= words_of_line .or. len(lock%seen) == 0) then
            verdict = lock_unclear
            deallocate (lock%seen)
         end if
      else if (size(other) /= words_of_line) then
         if (age >= empty_silence) verdict = lock_taken
      else if (age >= least_watch) then
         if (max(age, now() - integer_of(other(6)%text)) >= silence) verdict = lock_taken
      end if
   end function verdict_on

   !> Replace the lock of a run that has ended. Of two runs that do so at the same time the last one
   !! keeps it.
   subroutine take_over(lock, path, line, verdict, error)
      type(lock_t), intent(inout) :: lock
      character(len=*), intent(in) :: path           !! File of the lock
      character(len=*), intent(in) :: line           !! Its line
      integer, intent(out) :: verdict                !! One of the constants above
      type(error_t), allocatable, intent(out) :: error !! Cannot be written
      integer(c_int), parameter :: half_a_second = 500000
      character(len=:), allocatable :: mine, present_line
      integer(c_int) :: ignored
      logical :: made

      verdict = lock_refused
      mine = path//"."//number(int(c_getpid()))
      call remove_file(mine)
      call write_lock(mine, lock%owner//time_text(), made, error)
      call read_line(path, present_line)
      if (.not. allocated(error) .and. present_line == line) call rename_file(mine, path, error)
      if (allocated(error) .or. present_line /= line) then
         call remove_file(mine)
         return
      end if
      ignored = c_usleep(half_a_second)
      call read_line(path, present_line)
      if (index(present_line, lock%owner) == 1) verdict = lock_taken
      if (verdict == lock_refused) lock%message = owner_text(present_line)
   end subroutine take_over

   !> Give a sign of life every few seconds, and notice a lock that another run has taken over.
   subroutine lock_beat(self)
      class(lock_t), intent(inout) :: self
      character(len=:), allocatable :: line
      logical :: made
      type(error_t), allocatable :: ignored

      if (.not. allocated(self%path)) return
      if (now() - self%since < beat_interval) return
      self%since = now()
      call read_line(self%path, line)
      self%lost = index(line, self%owner) /= 1 .and. len(line) > 0
      if (self%lost) then
         self%message = owner_text(line)
         deallocate (self%path)
      else
         call write_lock(self%path, self%owner//time_text(), made, ignored, again=.true.)
      end if
   end subroutine lock_beat

   !> Remove the lock, if this run has it, and its folder, if this run made it and wrote nothing.
   subroutine lock_release(self)
      class(lock_t), intent(inout) :: self
      character(len=:), allocatable :: line
      integer(c_int) :: ignored

      if (.not. allocated(self%path)) return
      ! a copy of the process, made by the host program, does not end the run
      if (self%process /= c_getpid()) return
      call read_line(self%path, line)
      if (index(line, self%owner) == 1) call remove_file(self%path)
      deallocate (self%path)
      if (allocated(self%new_folder)) ignored = c_rmdir(self%new_folder//c_null_char)
   end subroutine lock_release

   !> Write the line of a lock: into a new file, or over the line of the same length in an existing
   !! one. It is written at once, so that no other run reads a part of it.
   subroutine write_lock(path, line, made, error, again)
      character(len=*), intent(in) :: path
      character(len=*), intent(in) :: line           !! Without its end
      logical, intent(out) :: made                   !! False: there is a lock already
      type(error_t), allocatable, intent(out) :: error !! Cannot be written
      logical, intent(in), optional :: again         !! The file exists
      character(len=:), allocatable, target :: letters
      integer(c_int) :: descriptor, flags, status

      flags = write_only + create_new
      if (present(again)) flags = write_only
      descriptor = c_open(path//c_null_char, flags, file_mode)
      made = descriptor >= 0
      if (.not. made) then
         if (failure_number() == exists_already) return
      end if
      if (made) then
         letters = line//new_line("a")
         made = c_write(descriptor, c_loc(letters(1:1)), len(letters, c_size_t)) == len(letters)
      end if
      if (.not. made) call fail(error, exit_file, "cannot write '"//path//"': "//failure_text()// &
         " [F103]")
      if (descriptor >= 0) status = c_close(descriptor)
      if (allocated(error) .and. descriptor >= 0) call remove_file(path)
   end subroutine write_lock

   !> The line of a lock; empty if there is none.
   subroutine read_line(path, line)
      character(len=*), intent(in) :: path
      character(len=:), allocatable, intent(out) :: line !! Without its end
      type(error_t), allocatable :: ignored

      call read_file(path, line, ignored)
      if (allocated(ignored)) line = ""
      line = line(:index(line//new_line("a"), new_line("a")) - 1)
   end subroutine read_line

   !> Line of this run without the time at its end.
   function own_line() result(line)
      character(len=:), allocatable :: line
      integer :: process

      process = int(c_getpid())
      line = first_line("/proc/sys/kernel/hostname")//" "//system_text()//" "//number(process)// &
         " "//number(start_of(process))//" "//number(now())//" "
   end function own_line

   !> Identity of this system: that of its kernel since the last boot, and that of the space of
   !! process numbers, in which containers differ.
   function system_text() result(text)
      character(len=:), allocatable :: text
      character(len=64), target :: letters
      integer(c_size_t) :: length

      length = c_readlink("/proc/self/ns/pid"//c_null_char, c_loc(letters(1:1)), &
         int(len(letters), c_size_t))
      text = trim(node_name())//letters(:max(int(length), 0))
      if (text == "") text = "unknown"
   end function system_text

   !> First line of a file of the system, a dash if there is none.
   function first_line(path) result(text)
      character(len=*), intent(in) :: path
      character(len=:), allocatable :: text
      character(len=1024) :: line
      integer :: status, unit

      line = ""
      open (newunit=unit, file=path, action="read", status="old", iostat=status)
      if (status == 0) then
         read (unit, "(a)", iostat=status) line
         close (unit)
      end if
      text = trim(line)
      if (text == "") text = "-"
   end function first_line

   !> Time at which a process started [1/100 s after the boot]; -1 if it has ended, 0 if it is not
   !! known.
   function start_of(process) result(start)
      integer, intent(in) :: process                 !! Number of the process
      integer(int64) :: start
      integer, parameter :: place_of_start = 20      ! words behind the name of the program
      type(text_t), allocatable :: words(:)
      character(len=:), allocatable :: line

      start = 0
      line = first_line("/proc/"//number(process)//"/stat")
      call split(line(index(line, ")", back=.true.) + 1:), words)
      if (size(words) < place_of_start) return
      start = integer_of(words(place_of_start)%text)
      ! ended, but its parent has not noticed
      if (words(1)%text == "Z" .or. words(1)%text == "X") start = -1
   end function start_of

   !> True if a process of this system runs.
   logical function is_alive(process, start) result(alive)
      integer(int64), intent(in) :: process          !! Number of the process
      integer(int64), intent(in) :: start            !! From `start_of` when it wrote its lock
      integer(int64) :: found

      alive = .false.
      if (process <= 0) return
      alive = c_kill(int(process, c_int), 0_c_int) == 0
      if (.not. alive) alive = failure_number() == not_permitted
      if (.not. alive) return
      found = start_of(int(process))
      ! another process may have its number by now
      alive = found == start .or. found == 0
   end function is_alive

   !> Owner of a lock for messages.
   function owner_text(line) result(text)
      character(len=*), intent(in) :: line           !! Line of a lock
      character(len=:), allocatable :: text
      type(text_t), allocatable :: words(:)

      text = "a lock without a line"
      call split(line, words)
      if (size(words) /= words_of_line) return
      text = "process "//words(3)%text//" on host '"//words(1)%text//"', started "// &
         age_text(words(5)%text)//" ago, last sign of life "//age_text(words(6)%text)//" ago"
   end function owner_text

   !> Time since a given one.
   function age_text(word) result(text)
      character(len=*), intent(in) :: word           !! Seconds since 1970
      character(len=:), allocatable :: text

      text = clock_text(int(min(max(now() - integer_of(word), 0_int64), int(huge(1), int64))))
   end function age_text

   !> An integer; 0 for any other text.
   pure integer(int64) function integer_of(word) result(value)
      character(len=*), intent(in) :: word
      integer :: status

      value = 0
      if (word == "" .or. verify(word, "0123456789") > 0) return
      read (word, *, iostat=status) value
   end function integer_of

   !> The present time in ten digits, so that the line of a lock keeps its length.
   function time_text() result(text)
      character(len=10) :: text

      write (text, "(i10)") now()
   end function time_text

   !> Seconds since 1970.
   integer(int64) function now() result(seconds)
      seconds = int(c_time(c_null_ptr), int64)
   end function now
end module io_lock
