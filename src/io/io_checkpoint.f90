! SPDX-License-Identifier: BSD-3-Clause
!> Writes checkpoints: the whole state of a run in double precision, for a restart on any number of
!! ranks.
!!
!! Layout: step and time are attributes of the root; /particles/MATERIAL/FIELD is one data set a
!! field, in the particle order of all files; /state has the scalar data; /deck and /deck_echo are
!! texts. Every data set has an attribute `check`, a hash that is verified on reading; the file has
!! a seal (io_seal).
module io_checkpoint
   use base_agreement, only: agree
   use base_communicator, only: communicator_t
   use base_error, only: error_t, exit_file, fail
   use base_field_worker, only: field_reader_t
   use base_file, only: join_path, list_folder, longest_name, longest_path, remove_file
   use base_hash, only: add_hash, hash_integers, hash_reals, hash_text, mix
   use base_kinds, only: int64, wp
   use deck_schema, only: schema_t
   use io_digest, only: field_key
   use io_hdf5, only: hdf5_file_t
   use io_hdf5_write, only: data_bytes, rows_of_root, rows_t, write_bytes, write_data
   use io_rows, only: store_rows
   use sample_order, only: tile_order
   use io_seal, only: checkpoint_schema
   use io_state, only: state_t
   use particle_store, only: store_t
   implicit none
   private

   public :: checkpoint_newest, checkpoint_place_t, checkpoint_write, head_check, remove_old_files

   !> Path of a checkpoint and its contents other than the state. The same on all ranks.
   type :: checkpoint_place_t
      character(len=:), allocatable :: folder             !! Folder of the results
      character(len=:), allocatable :: case               !! Prefix of all files
      integer :: number = 1                               !! Number in the name
      integer :: keep = 2                                 !! Number of checkpoints to keep, 0: all
      character(len=:), allocatable :: version            !! Version of the program
      character(len=:), allocatable :: deck               !! Text of the deck, optional
      character(len=:), allocatable :: echo               !! All keys with their values, optional
      type(schema_t) :: schema                            !! Declares which keys may change
   contains
      procedure :: path => place_path                     !! Path of the file
   end type checkpoint_place_t

   !> Sums the bytes of the fields of a store.
   type, extends(field_reader_t) :: measure_t
      type(rows_t) :: rows                                !! Rows of the store
      integer(int64) :: bytes = 0                         !! Number of bytes of all fields so far
   contains
      procedure :: reals => measure_reals                 !! Count a field of real numbers
      procedure :: integers => measure_integers           !! Count a field of integers
   end type measure_t

   !> Writes the fields of one store.
   type, extends(field_reader_t) :: writer_t
      type(hdf5_file_t) :: file
      character(len=:), allocatable :: store              !! Name of the material
      type(rows_t) :: rows                                !! Rows of this rank
      integer, allocatable :: order(:)                    !! Indices of the particles
      integer(int64), allocatable :: owners(:)            !! Row numbers, the owners in hashes
   contains
      procedure :: reals => writer_reals                  !! Write a field of real numbers
      procedure :: integers => writer_integers            !! Write a field of integers
      procedure :: write_attributes => writer_write_attributes !! Write the attributes of a field
   end type writer_t

contains

   !> Path of the file.
   function place_path(self) result(path)
      class(checkpoint_place_t), intent(in) :: self
      character(len=:), allocatable :: path
      character(len=16) :: digits

      write (digits, "(i0.4)") self%number
      path = join_path(self%folder, self%case//"_chk_"//trim(digits)//".h5")
   end function place_path

   !> Hash of step and time.
   pure function head_check(state) result(check)
      type(state_t), intent(in) :: state
      integer(int64) :: check

      check = mix(ieor(mix(ieor(mix(state%step), transfer(state%time, check))), &
         transfer(state%dt_next, check)))
   end function head_check

   !> Write a checkpoint and remove the oldest beyond the number to keep. Collective.
   subroutine checkpoint_write(communicator, place, stores, state, error)
      type(communicator_t), intent(in) :: communicator
      type(checkpoint_place_t), intent(in) :: place
      type(store_t), intent(in) :: stores(:)
      type(state_t), intent(in) :: state                  !! The same on all ranks
      type(error_t), allocatable, intent(out) :: error !! Not written; older checkpoints are intact
      type(writer_t) :: writer
      integer(int64) :: bytes
      integer :: index, row

      call bound_size(communicator, place, stores, state, bytes)
      call writer%file%create(communicator, place%path(), bytes, error)
      if (allocated(error)) return
      writer%file%seal = checkpoint_schema
      call write_head(writer%file, place, state)
      call writer%file%group("/particles")
      do index = 1, size(stores)
         writer%store = stores(index)%name
         call tile_order(stores(index), writer%order)
         writer%rows = rows_of_store(communicator, stores(index))
         if (allocated(writer%owners)) deallocate (writer%owners)
         allocate (writer%owners(size(writer%order)))
         do row = 1, size(writer%owners)
            writer%owners(row) = writer%rows%before(1) + row
         end do
         call writer%file%group("/particles/"//writer%store)
         call stores(index)%show(writer)
      end do
      call write_state(writer%file, state)
      call writer%file%finish(error)
      if (allocated(error)) return
      if (communicator%rank == 0 .and. place%keep > 0) call remove_old_files(place)
   end subroutine checkpoint_write

   !> Rows of the particles of one store. Collective.
   function rows_of_store(communicator, store) result(rows)
      type(communicator_t), intent(in) :: communicator
      type(store_t), intent(in) :: store
      type(rows_t) :: rows
      integer(int64) :: counts(1)

      counts = store%particles()
      rows = store_rows(communicator, counts, 0)
   end function rows_of_store

   !> Upper bound of the length of the file [byte]. Collective.
   subroutine bound_size(communicator, place, stores, state, bytes)
      type(communicator_t), intent(in) :: communicator
      type(checkpoint_place_t), intent(in) :: place       !! Texts
      type(store_t), intent(in) :: stores(:)
      type(state_t), intent(in) :: state                  !! Scalar data
      integer(int64), intent(out) :: bytes                !! Upper bound
      integer(int64), parameter :: heading = 16384, number = 8
      type(measure_t) :: measurer
      integer :: index

      measurer%bytes = heading
      do index = 1, size(stores)
         measurer%rows = rows_of_store(communicator, stores(index))
         call stores(index)%show(measurer)
         measurer%bytes = measurer%bytes + heading
      end do
      bytes = measurer%bytes
      if (allocated(place%deck)) bytes = bytes + len(place%deck) + heading
      if (allocated(place%echo)) bytes = bytes + len(place%echo) + heading
      if (.not. allocated(state%entries)) return
      do index = 1, size(state%entries)
         if (allocated(state%entries(index)%reals)) &
            bytes = bytes + heading + number*size(state%entries(index)%reals)
         if (allocated(state%entries(index)%integers)) &
            bytes = bytes + heading + number*size(state%entries(index)%integers)
      end do
   end subroutine bound_size

   !> Write the attributes and texts of the root.
   subroutine write_head(file, place, state)
      type(hdf5_file_t), intent(inout) :: file
      type(checkpoint_place_t), intent(in) :: place       !! Texts
      type(state_t), intent(in) :: state                  !! Step and time

      call file%attribute("/", "schema", checkpoint_schema)
      if (allocated(place%version)) call file%attribute("/", "version", place%version)
      call file%attribute("/", "case", place%case)
      call file%attribute("/", "step", state%step)
      call file%attribute("/", "time", state%time)
      call file%attribute("/", "dt_next", state%dt_next)
      call file%attribute("/", "check", head_check(state))
      if (allocated(place%deck)) call write_text(file, "/deck", place%deck)
      if (allocated(place%echo)) call write_text(file, "/deck_echo", place%echo)
   end subroutine write_head

   !> Write a text.
   subroutine write_text(file, name, text)
      type(hdf5_file_t), intent(inout) :: file
      character(len=*), intent(in) :: name                !! Path from the root
      character(len=*), intent(in) :: text

      call write_bytes(file, name, rows_of_root(file%communicator, len(text)), text)
      call file%attribute(name, "check", hash_text(text))
   end subroutine write_text

   !> Write the scalar data; all ranks have them, rank 0 writes them.
   subroutine write_state(file, state)
      type(hdf5_file_t), intent(inout) :: file
      type(state_t), intent(in) :: state                  !! Scalar data
      integer(int64), allocatable :: owners(:)
      integer(int64) :: check
      character(len=:), allocatable :: name
      integer :: index, rows

      call file%group("/state")
      if (.not. allocated(state%entries)) return
      do index = 1, size(state%entries)
         name = "/state/"//state%entries(index)%name
         if (allocated(state%entries(index)%reals)) then
            rows = size(state%entries(index)%reals)
            call number_rows(rows, owners)
            call write_data(file, name, rows_of_root(file%communicator, rows), &
               state%entries(index)%reals)
            check = hash_reals(field_key("state", name, 1), owners, state%entries(index)%reals)
         else
            rows = size(state%entries(index)%integers)
            call number_rows(rows, owners)
            call write_data(file, name, rows_of_root(file%communicator, rows), &
               state%entries(index)%integers)
            check = hash_integers(field_key("state", name, 1), owners, &
               state%entries(index)%integers)
         end if
         call file%attribute(name, "check", check)
      end do
   end subroutine write_state

   !> Number rows from 1.
   pure subroutine number_rows(count, numbers)
      integer, intent(in) :: count                        !! Number
      integer(int64), allocatable, intent(out) :: numbers(:) !! 1, 2, ...
      integer :: index

      allocate (numbers(count))
      do index = 1, count
         numbers(index) = index
      end do
   end subroutine number_rows

   !> Remove all checkpoints of a case but the newest.
   subroutine remove_old_files(place)
      type(checkpoint_place_t), intent(in) :: place
      character(len=longest_name), allocatable :: names(:)
      type(error_t), allocatable :: error
      integer :: index

      call list_checkpoints(place%folder, place%case, names, error)
      if (allocated(error)) return
      do index = place%keep + 1, size(names)
         call remove_file(join_path(place%folder, trim(names(index))))
      end do
   end subroutine remove_old_files

   !> Names of the checkpoints of a case, newest first.
   subroutine list_checkpoints(folder, case, names, error)
      character(len=*), intent(in) :: folder              !! Folder of the results
      character(len=*), intent(in) :: case                !! Prefix of all files
      character(len=longest_name), allocatable, intent(out) :: names(:) !! Padded with blanks
      type(error_t), allocatable, intent(out) :: error    !! The folder cannot be read
      character(len=longest_name), allocatable :: found(:)
      character(len=:), allocatable :: prefix
      integer, allocatable :: numbers(:)
      integer :: index, last

      prefix = case//"_chk_"
      call list_folder(folder, prefix, ".h5", found, error)
      if (allocated(error)) return
      allocate (numbers(size(found)))
      do index = 1, size(found)
         last = len_trim(found(index)) - len(".h5")
         numbers(index) = number_of(found(index)(len(prefix) + 1:last))
      end do
      allocate (names(count(numbers >= 0)))
      do index = 1, size(found)
         if (numbers(index) < 0) cycle
         ! file names are counted, because 1 and 0001 are the same number and need two positions
         names(1 + count(numbers > numbers(index)) &
            + count(numbers(:index - 1) == numbers(index))) = found(index)
      end do
   end subroutine list_checkpoints

   !> Value of a text of digits, -1 for any other text.
   pure integer function number_of(text) result(number)
      character(len=*), intent(in) :: text                !! Part of a file name
      integer :: status

      number = -1
      if (len(text) == 0 .or. verify(text, "0123456789") > 0) return
      read (text, *, iostat=status) number
      if (status /= 0) number = -1
   end function number_of

   !> Paths of the checkpoints of a case, newest first. Collective.
   subroutine checkpoint_newest(communicator, folder, case, paths, error)
      type(communicator_t), intent(in) :: communicator
      character(len=*), intent(in) :: folder              !! Folder of the results
      character(len=*), intent(in) :: case                !! Prefix of all files
      character(len=longest_path), allocatable, intent(out) :: paths(:) !! Padded with blanks
      type(error_t), allocatable, intent(out) :: error    !! The folder cannot be read
      character(len=longest_name), allocatable :: names(:)
      character(len=:), allocatable :: joined
      integer :: index

      joined = ""
      if (communicator%rank == 0) then
         call list_checkpoints(folder, case, names, error)
         if (.not. allocated(error)) then
            do index = 1, size(names)
               joined = joined//names(index)
            end do
         end if
      end if
      call agree(communicator, error)
      if (allocated(error)) return
      call communicator%broadcast(joined)
      allocate (paths(len(joined)/longest_name))
      do index = 1, size(paths)
         paths(index) = join_path(folder, joined((index - 1)*longest_name + 1:index*longest_name))
      end do
   end subroutine checkpoint_newest

   !> Write the attributes of a field. Collective.
   subroutine writer_write_attributes(self, name, unit, check)
      class(writer_t), intent(inout) :: self
      character(len=*), intent(in) :: name                !! Data set, from the root
      character(len=*), intent(in) :: unit
      integer(int64), intent(in) :: check                 !! Hash of the rows of this rank
      integer(int64) :: whole(1)

      whole = check
      call self%file%communicator%total(whole)
      call self%file%attribute(name, "units", unit)
      call self%file%attribute(name, "check", whole(1))
   end subroutine writer_write_attributes

   !> Write a field of real numbers. Collective.
   subroutine writer_reals(self, name, unit, is_scalar, values)
      class(writer_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: unit
      logical, intent(in) :: is_scalar                   !! One number a particle?
      real(wp), contiguous, intent(in) :: values(:, :) !! (particle, component)
      character(len=:), allocatable :: path
      real(wp), allocatable :: column(:), rows(:, :)
      integer(int64) :: check
      integer :: component, row

      allocate (rows(size(values, 2), size(self%order)), column(size(self%order)))
      check = 0
      do component = 1, size(values, 2)
         do row = 1, size(column)
            column(row) = values(self%order(row), component)
         end do
         rows(component, :) = column
         check = add_hash(check, hash_reals(field_key(self%store, name, component), self%owners, &
            column))
      end do
      path = "/particles/"//self%store//"/"//name
      if (is_scalar) then
         call write_data(self%file, path, self%rows, column)
      else
         call write_data(self%file, path, self%rows, rows)
      end if
      call self%write_attributes(path, unit, check)
   end subroutine writer_reals

   !> Write a field of integers. Collective.
   subroutine writer_integers(self, name, unit, values)
      class(writer_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: unit
      integer(int64), contiguous, intent(in) :: values(:) !! (particle)
      character(len=:), allocatable :: path
      integer(int64), allocatable :: rows(:)
      integer :: row

      allocate (rows(size(self%order)))
      do row = 1, size(rows)
         rows(row) = values(self%order(row))
      end do
      path = "/particles/"//self%store//"/"//name
      call write_data(self%file, path, self%rows, rows)
      call self%write_attributes(path, unit, hash_integers(field_key(self%store, name, 1), &
         self%owners, rows))
   end subroutine writer_integers

   !> Count a field of real numbers.
   subroutine measure_reals(self, name, unit, is_scalar, values)
      class(measure_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: unit
      logical, intent(in) :: is_scalar                   !! One number a particle?
      real(wp), contiguous, intent(in) :: values(:, :) !! (particle, component)

      self%bytes = self%bytes + data_bytes(self%rows, 8_int64*size(values, 2))
   end subroutine measure_reals

   !> Count a field of integers.
   subroutine measure_integers(self, name, unit, values)
      class(measure_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: unit
      integer(int64), contiguous, intent(in) :: values(:) !! (particle)

      self%bytes = self%bytes + data_bytes(self%rows, 8_int64)
   end subroutine measure_integers
end module io_checkpoint
