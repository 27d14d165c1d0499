! SPDX-License-Identifier: BSD-3-Clause
!> Writes and verifies the seal of a file: a title and a hash of all preceding bytes at its end.
!!
!! The hashes inside a checkpoint protect its data, but not the metadata of HDF5, which can crash
!! the program when damaged. So the seal of a file is verified before the library opens it. HDF5
!! ignores bytes after its own end of file.
module io_seal
   use base_agreement, only: agree
   use base_communicator, only: communicator_t
   use base_error, only: error_t, exit_file, fail
   use base_file, only: file_size, output_file_t
   use base_hash, only: add_hash, digest_text, hash_integers, mix
   use base_kinds, only: int64
   use base_libc, only: failure_text
   implicit none
   private

   public :: check_seal, write_seal

   character(len=*), parameter, public :: checkpoint_schema = "scree-checkpoint-4"

   integer, parameter :: digits = 16                     !! Digits of the hash
   integer, parameter, public :: seal_bytes = 48         !! Title, blanks, digits, end of line
   integer, parameter :: block_words = 131072            !! Words that are read together
   integer, parameter :: word_bytes = 8
   character(len=*), parameter :: title_prefix = "scree-"       !! Beginning of all titles

contains

   !> Append the seal to a file. Collective.
   subroutine write_seal(communicator, path, title, error)
      type(communicator_t), intent(in) :: communicator
      character(len=*), intent(in) :: path               !! The file, complete and closed
      character(len=*), intent(in) :: title              !! Kind and version of the file
      type(error_t), allocatable, intent(out) :: error   !! Cannot be read or written
      character(len=seal_bytes - digits - 1) :: padded
      type(output_file_t) :: file
      integer(int64) :: hash

      call hash_file(communicator, path, file_size(path), hash, error)
      if (.not. allocated(error) .and. communicator%rank == 0) then
         padded = title
         call file%append(path, error)
         if (.not. allocated(error)) &
            call file%write(padded//digest_text(hash)//new_line("a"), error)
         call file%close()
      end if
      call agree(communicator, error)
   end subroutine write_seal

   !> Compare a file with its seal. Collective.
   subroutine check_seal(communicator, path, title, error)
      type(communicator_t), intent(in) :: communicator
      character(len=*), intent(in) :: path
      character(len=*), intent(in) :: title              !! Kind and version that can be read
      type(error_t), allocatable, intent(out) :: error   !! Missing, another kind, or damaged
      character(len=seal_bytes) :: seal
      integer(int64) :: hash

      call read_seal(path, seal, error)
      if (.not. allocated(error)) then
         if (seal(:len(title_prefix)) /= title_prefix .or. seal(seal_bytes:) /= new_line("a")) then
            call fail(error, exit_file, "'"//path// &
               "' is truncated, or not a checkpoint of this program [F107]")
         else if (seal(:seal_bytes - digits - 1) /= title) then
            call fail(error, exit_file, "'"//path//"' is of another version: it is '"// &
               trim(seal(:seal_bytes - digits - 1))//"', this program reads '"//title//"' [F109]")
         end if
      end if
      call agree(communicator, error)
      if (allocated(error)) return
      call hash_file(communicator, path, file_size(path) - seal_bytes, hash, error)
      if (allocated(error)) return
      if (digest_text(hash) /= seal(seal_bytes - digits:seal_bytes - 1)) call fail(error, &
         exit_file, "'"//path//"' is damaged: its bytes are not those that were written [F108]")
   end subroutine check_seal

   !> Read the seal of a file.
   subroutine read_seal(path, seal, error)
      character(len=*), intent(in) :: path
      character(len=seal_bytes), intent(out) :: seal     !! Last bytes of the file
      type(error_t), allocatable, intent(out) :: error   !! Missing or unreadable
      integer(int64) :: bytes
      integer :: status, unit

      seal = ""
      bytes = file_size(path)
      if (bytes < 0) then
         call fail(error, exit_file, "cannot read '"//path//"': "//failure_text()//" [F106]")
         return
      end if
      if (bytes < seal_bytes) return
      open (newunit=unit, file=path, access="stream", action="read", status="old", iostat=status)
      if (status == 0) then
         read (unit, pos=bytes - seal_bytes + 1, iostat=status) seal
         close (unit)
      end if
      if (status /= 0) call fail(error, exit_file, "cannot read '"//path//"': it ends too "// &
         "early [F106]")
   end subroutine read_seal

   !> Hash the first bytes of a file, in parallel. Collective.
   subroutine hash_file(communicator, path, bytes, hash, error)
      type(communicator_t), intent(in) :: communicator
      character(len=*), intent(in) :: path
      integer(int64), intent(in) :: bytes                !! Number of bytes
      integer(int64), intent(out) :: hash                !! The same on all ranks
      type(error_t), allocatable, intent(out) :: error   !! Cannot be read
      integer(int64), allocatable :: word_number(:), words(:)
      integer(int64) :: block, first, last, sum(1)
      integer :: filled, n, status, unit

      allocate (word_number(block_words), words(block_words))
      sum = 0
      open (newunit=unit, file=path, access="stream", action="read", status="old", iostat=status)
      block = communicator%rank
      do while (status == 0 .and. block*block_words*word_bytes < bytes)
         first = block*block_words*word_bytes
         last = min(first + int(block_words, int64)*word_bytes, bytes)
         filled = int((last - first + word_bytes - 1)/word_bytes)
         call read_words(unit, first, last, words(:filled), status)
         do n = 1, filled
            word_number(n) = first/word_bytes + n
         end do
         sum = add_hash(sum, hash_integers(0_int64, word_number(:filled), words(:filled)))
         block = block + communicator%size
      end do
      if (status /= 0) call fail(error, exit_file, "cannot read '"//path//"': it ends too "// &
         "early [F106]")
      if (status == 0) close (unit)
      call communicator%total(sum)
      hash = mix(add_hash(sum(1), mix(bytes)))
      call agree(communicator, error)
   end subroutine hash_file

   !> Read bytes of a file as words; the last one is padded with zeros.
   subroutine read_words(unit, first, last, words, status)
      integer, intent(in) :: unit                        !! The open file
      integer(int64), intent(in) :: first                !! Position before the first byte
      integer(int64), intent(in) :: last                 !! Position of the last byte
      integer(int64), contiguous, intent(out) :: words(:) !! Bytes read
      integer, intent(out) :: status                     !! 0 if all was read
      character(len=word_bytes) :: rest
      integer :: full, left

      full = int((last - first)/word_bytes)
      left = int(last - first) - full*word_bytes
      status = 0
      if (full > 0) read (unit, pos=first + 1, iostat=status) words(:full)
      if (left == 0 .or. status /= 0) return
      rest = repeat(achar(0), word_bytes)
      read (unit, pos=first + int(full, int64)*word_bytes + 1, iostat=status) rest(:left)
      words(full + 1) = transfer(rest, words(1))
   end subroutine read_words
end module io_seal
