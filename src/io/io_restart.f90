! SPDX-License-Identifier: BSD-3-Clause
!> Reads checkpoints to restart a run on any number of ranks.
module io_restart
   use base_agreement, only: agree
   use base_communicator, only: communicator_t
   use base_error, only: error_t, exit_file, fail
   use base_field_worker, only: field_worker_t
   use base_file, only: longest_path
   use base_hash, only: add_hash, hash_integers, hash_reals, hash_text
   use base_kinds, only: int64, wp
   use deck_changes, only: changes_t, compare_decks
   use io_checkpoint, only: checkpoint_newest, checkpoint_place_t, head_check
   use io_digest, only: field_key
   use io_hdf5_read, only: data_info_t, hdf5_source_t
   use io_hdf5_write, only: even_rows, rows_t
   use io_seal, only: check_seal, checkpoint_schema
   use io_state, only: state_t
   use particle_store, only: store_t
   implicit none
   private

   public :: checkpoint_find, checkpoint_read, checkpoint_text

   !> Rows that are read together, so that reading takes little memory beyond that of the particles
   integer, parameter :: block_rows = 65536
   !> A field whose columns belong to groups of the deck that a restart may change: it is read as it
   !! is in the file, and set for the deck of this run afterwards
   character(len=*), parameter :: set_anew = "load_marks"

   !> Reads the fields of one store. A failure is stored and raised at the end, so that all ranks
   !! make the same collective calls.
   type, extends(field_worker_t) :: reader_t
      type(communicator_t) :: communicator
      type(hdf5_source_t) :: source                       !! The open file
      character(len=:), allocatable :: store              !! Name of the material
      integer(int64) :: total = 0                         !! Particles on all ranks
      integer(int64) :: before = 0                        !! Rows of lower ranks
      integer :: count = 0                                !! Rows of this rank
      type(error_t), allocatable :: problem               !! First failure on this rank
   contains
      procedure :: scalar => reader_scalar                !! Read a scalar field
      procedure :: vector => reader_vector                !! Read a vector or tensor field
      procedure :: whole => reader_whole                  !! Read an integer field
      procedure :: check_field => reader_check_field                    !! Is the field complete?
      procedure :: columns => reader_columns              !! Columns of a field in the file
      procedure :: verify => reader_verify                !! Compare the hash
   end type reader_t

contains

   !> Read the newest undamaged checkpoint of a case. Collective.
   !!
   !! A checkpoint of another deck ends the search: a restart from an older one would overwrite
   !! newer results.
   subroutine checkpoint_find(communicator, place, stores, state, path, notes, error, changes)
      type(communicator_t), intent(in) :: communicator
      type(checkpoint_place_t), intent(in) :: place       !! Folder, case and keys of this run
      type(store_t), intent(inout) :: stores(:) !! With the requested fields allocated; filled
      type(state_t), intent(inout) :: state               !! Filled
      character(len=:), allocatable, intent(out) :: path  !! The checkpoint that was read
      character(len=:), allocatable, intent(out) :: notes !! Why newer ones were skipped
      type(error_t), allocatable, intent(out) :: error    !! No checkpoint can be used
      type(changes_t), intent(out), optional :: changes   !! Differences from the deck in the file
      character(len=longest_path), allocatable :: paths(:)
      integer :: index

      notes = ""
      path = ""
      call checkpoint_newest(communicator, place%folder, place%case, paths, error)
      if (allocated(error)) return
      do index = 1, size(paths)
         call checkpoint_read(communicator, trim(paths(index)), stores, state, error, &
            place, changes)
         if (.not. allocated(error)) then
            path = trim(paths(index))
            return
         end if
         if (present(changes)) then
            if (allocated(changes%refused)) then
               if (len(changes%refused) > 0) return
            end if
         end if
         if (len(notes) > 0) notes = notes//new_line("a")
         notes = notes//error%message
      end do
      if (size(paths) == 0) then
         call fail(error, exit_file, "no checkpoint '"//place%case//"_chk_*.h5' in '"// &
            place%folder//"'; --overwrite removes the results and starts again [F104]")
      else
         call fail(error, exit_file, "no checkpoint of '"//place%case//"' can be used: [F105]"// &
            new_line("a")//notes)
      end if
   end subroutine checkpoint_find

   !> Read a checkpoint. Collective.
   !!
   !! The required fields must be allocated, with any size. Each rank gets an equal part of each
   !! store as one range, regardless of the tiles of the particles.
   subroutine checkpoint_read(communicator, path, stores, state, error, place, changes)
      type(communicator_t), intent(in) :: communicator
      character(len=*), intent(in) :: path
      type(store_t), intent(inout) :: stores(:) !! With the requested fields allocated; filled
      type(state_t), intent(inout) :: state               !! Filled
      type(error_t), allocatable, intent(out) :: error    !! Damaged, or of another deck
      type(checkpoint_place_t), intent(in), optional :: place !! Keys of this run, to compare
      type(changes_t), intent(out), optional :: changes   !! Differences from the deck in the file
      type(reader_t) :: reader
      integer :: index

      reader%communicator = communicator
      call check_seal(communicator, path, checkpoint_schema, error)
      if (allocated(error)) return
      call reader%source%open(path, error)
      if (.not. allocated(error)) call read_head(reader%source, state, error)
      if (.not. allocated(error)) call read_state(reader%source, state, error)
      if (.not. allocated(error) .and. present(changes)) &
         call check_deck(reader%source, place, changes, error)
      if (.not. allocated(error)) call check_materials(reader%source, stores, error)
      call agree(communicator, error)
      if (.not. allocated(error)) then
         do index = 1, size(stores)
            call read_store(reader, stores(index))
         end do
         if (allocated(reader%problem)) error = reader%problem
         call agree(communicator, error)
      end if
      call reader%source%close()
   end subroutine checkpoint_read

   !> Read the text of the deck ("/deck") or the echo ("/deck_echo") of a checkpoint.
   subroutine checkpoint_text(path, name, text, error)
      character(len=*), intent(in) :: path
      character(len=*), intent(in) :: name                !! Path from the root
      character(len=:), allocatable, intent(out) :: text
      type(error_t), allocatable, intent(out) :: error    !! Cannot be read
      type(hdf5_source_t) :: source

      text = ""
      call source%open(path, error)
      if (.not. allocated(error)) call read_text(source, name, text, error)
      call source%close()
   end subroutine checkpoint_text

   !> Read a text of an open file and compare its hash.
   subroutine read_text(source, name, text, error)
      type(hdf5_source_t), intent(in) :: source           !! Open file
      character(len=*), intent(in) :: name                !! Path from the root
      character(len=:), allocatable, intent(out) :: text
      type(error_t), allocatable, intent(out) :: error    !! Cannot be read, or damaged
      integer(int64) :: check

      check = 0
      call source%text(name, text, error)
      if (.not. allocated(error)) call source%attribute(name, "check", check, error)
      if (allocated(error)) return
      if (hash_text(text) /= check) call fail_check(source%path, name, error)
   end subroutine read_text

   !> Compare the keys of this run with those of the run that wrote the file.
   subroutine check_deck(source, place, changes, error)
      type(hdf5_source_t), intent(in) :: source           !! Open file
      type(checkpoint_place_t), intent(in) :: place       !! All keys of this run
      type(changes_t), intent(out) :: changes             !! Differences
      type(error_t), allocatable, intent(out) :: error    !! Keys that may not change differ
      character(len=:), allocatable :: old

      call read_text(source, "/deck_echo", old, error)
      if (allocated(error)) return
      call compare_decks(old, place%echo, place%schema, changes)
      if (len(changes%refused) > 0) call fail(error, exit_file, "'"//source%path// &
         "' belongs to another deck: these keys must not change in a restart (values in SI): "// &
         "[F110]"// &
         changes%refused//new_line("a")//"use the deck of that run, or start again in "// &
         "another folder (--outdir) or with --overwrite")
   end subroutine check_deck

   !> Make the error on a wrong hash.
   subroutine fail_check(path, name, error)
      character(len=*), intent(in) :: path
      character(len=*), intent(in) :: name                !! Object in the file
      type(error_t), allocatable, intent(out) :: error

      call fail(error, exit_file, "'"//path//"' is damaged: the check of '"//name//"' is "// &
         "wrong [F108]")
   end subroutine fail_check

   !> Read step and time.
   subroutine read_head(source, state, error)
      type(hdf5_source_t), intent(in) :: source           !! Open file
      type(state_t), intent(inout) :: state               !! Step and time are set
      type(error_t), allocatable, intent(out) :: error    !! Damaged, or no checkpoint
      integer(int64) :: check

      check = 0
      if (.not. source%has("/particles")) then
         call fail(error, exit_file, "'"//source%path//"' is not a checkpoint of this "// &
            "program [F107]")
         return
      end if
      call source%attribute("/", "step", state%step, error)
      if (.not. allocated(error)) call source%attribute("/", "time", state%time, error)
      if (.not. allocated(error)) call source%attribute("/", "dt_next", state%dt_next, error)
      if (.not. allocated(error)) call source%attribute("/", "check", check, error)
      if (allocated(error)) return
      if (check /= head_check(state)) call fail_check(source%path, "step and time", error)
   end subroutine read_head

   !> Read the scalar data.
   subroutine read_state(source, state, error)
      type(hdf5_source_t), intent(in) :: source           !! Open file
      type(state_t), intent(inout) :: state               !! Entries are set
      type(error_t), allocatable, intent(out) :: error    !! Damaged
      type(data_info_t), allocatable :: members(:)
      integer :: index

      if (allocated(state%entries)) deallocate (state%entries)
      call source%members("/state", members, error)
      if (allocated(error)) return
      do index = 1, size(members)
         call read_entry(source, members(index), state, error)
         if (allocated(error)) return
      end do
   end subroutine read_state

   !> Read one entry of the scalar data.
   subroutine read_entry(source, member, state, error)
      type(hdf5_source_t), intent(in) :: source           !! Open file
      type(data_info_t), intent(in) :: member             !! Data set of the field
      type(state_t), intent(inout) :: state               !! The entry is set
      type(error_t), allocatable, intent(out) :: error    !! Damaged
      integer(int64), allocatable :: owners(:), integers(:)
      real(wp), allocatable :: reals(:)
      integer(int64) :: check, found
      character(len=:), allocatable :: name
      integer :: row

      name = "/state/"//trim(member%name)
      check = 0
      allocate (owners(member%rows))
      do row = 1, size(owners)
         owners(row) = row
      end do
      if (member%is_real) then
         allocate (reals(member%rows))
         call source%read(name, 0_int64, reals, error)
         if (allocated(error)) return
         found = hash_reals(field_key("state", name, 1), owners, reals)
         call state%set(trim(member%name), reals)
      else
         allocate (integers(member%rows))
         call source%read(name, 0_int64, integers, error)
         if (allocated(error)) return
         found = hash_integers(field_key("state", name, 1), owners, integers)
         call state%set(trim(member%name), integers)
      end if
      call source%attribute(name, "check", check, error)
      if (allocated(error)) return
      if (check /= found) call fail_check(source%path, name, error)
   end subroutine read_entry

   !> Check that the file has exactly the materials of the run.
   subroutine check_materials(source, stores, error)
      type(hdf5_source_t), intent(in) :: source           !! Open file
      type(store_t), intent(in) :: stores(:)
      type(error_t), allocatable, intent(out) :: error    !! Another set of materials
      type(data_info_t), allocatable :: groups(:)
      character(len=:), allocatable :: names
      integer :: index
      logical :: same

      call source%members("/particles", groups, error)
      if (allocated(error)) return
      names = ""
      do index = 1, size(groups)
         names = names//" '"//trim(groups(index)%name)//"'"
      end do
      same = size(groups) == size(stores)
      do index = 1, size(stores)
         same = same .and. any(groups%name == stores(index)%name)
      end do
      if (.not. same) call fail(error, exit_file, "'"//source%path// &
         "' belongs to another deck: its materials are"//names//" [F110]")
   end subroutine check_materials

   !> Read the particles of one store. Collective.
   subroutine read_store(reader, store)
      type(reader_t), intent(inout) :: reader
      type(store_t), intent(inout) :: store !! With the requested fields allocated; filled
      type(data_info_t) :: identity
      type(error_t), allocatable :: error
      type(rows_t) :: rows

      reader%store = store%name
      call reader%source%info("/particles/"//store%name//"/identity", identity, error)
      if (allocated(error) .and. .not. allocated(reader%problem)) reader%problem = error
      reader%total = identity%rows
      rows = even_rows(reader%communicator, reader%total)
      reader%before = rows%before(1)
      reader%count = int(rows%count(1))
      call store%walk(reader)
      call set_single(store%first, 1)
      call set_single(store%count, reader%count)
      call set_single(store%capacity, reader%count)
      store%used = reader%count
      if (allocated(store%cell_start)) deallocate (store%cell_start)
   end subroutine read_store

   !> Replace an array by one with a single element.
   pure subroutine set_single(array, number)
      integer, allocatable, intent(inout) :: array(:)
      integer, intent(in) :: number

      if (allocated(array)) deallocate (array)
      allocate (array(1))
      array = number
   end subroutine set_single

   !> Check that the file has a field for all particles.
   logical function reader_check_field(self, name) result(there)
      class(reader_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      type(data_info_t) :: info
      type(error_t), allocatable :: error
      character(len=:), allocatable :: group

      group = "/particles/"//self%store
      there = self%source%has(group//"/"//name)
      if (there) then
         call self%source%info(group//"/"//name, info, error)
         if (.not. allocated(error) .and. info%rows /= self%total) &
            call fail_check(self%source%path, group//"/"//name, error)
      else
         call fail(error, exit_file, "'"//self%source%path//"' has no field '"//name// &
            "' of material '"//self%store//"': it was written with other effects or outputs [F112]")
      end if
      there = .not. allocated(error)
      if (.not. there .and. .not. allocated(self%problem)) call move_alloc(error, self%problem)
   end function reader_check_field

   !> Number of columns of a field in the file, 0 = it is not there.
   integer function reader_columns(self, path) result(columns)
      class(reader_t), intent(in) :: self
      character(len=*), intent(in) :: path                !! Data set, from the root
      type(data_info_t) :: info
      type(error_t), allocatable :: error

      columns = 0
      if (.not. self%source%has(path)) return
      call self%source%info(path, info, error)
      if (.not. allocated(error)) columns = info%components
   end function reader_columns

   !> Compare the hash of a field over all ranks. Collective.
   subroutine reader_verify(self, name, check, error)
      class(reader_t), intent(inout) :: self
      character(len=*), intent(in) :: name                !! Data set, from the root
      integer(int64), intent(in) :: check                 !! Hash of the rows of this rank
      type(error_t), allocatable, intent(inout) :: error  !! Failure in reading
      integer(int64) :: found(1), wanted

      found = check
      wanted = 0
      call self%communicator%total(found)
      if (.not. allocated(error) .and. .not. allocated(self%problem)) then
         call self%source%attribute(name, "check", wanted, error)
         if (.not. allocated(error) .and. wanted /= found(1)) &
            call fail_check(self%source%path, name, error)
      end if
      if (allocated(error) .and. .not. allocated(self%problem)) &
         call move_alloc(error, self%problem)
   end subroutine reader_verify

   !> Numbers of the rows of a block, the owners in hashes.
   pure function owners_of(self, first, last) result(owners)
      type(reader_t), intent(in) :: self
      integer, intent(in) :: first, last                  !! First and last row of this rank
      integer(int64) :: owners(last - first + 1)
      integer :: row

      do row = first, last
         owners(row - first + 1) = self%before + row
      end do
   end function owners_of

   !> Read a scalar field. Collective.
   subroutine reader_scalar(self, name, unit, values)
      class(reader_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: unit
      real(wp), allocatable, intent(inout) :: values(:)   !! (particle), filled
      type(error_t), allocatable :: error
      integer(int64) :: check
      character(len=:), allocatable :: path
      integer :: first, last

      path = "/particles/"//self%store//"/"//name
      deallocate (values)
      allocate (values(self%count))
      values = 0.0_wp
      check = 0
      if (self%check_field(name)) then
         do first = 1, self%count, block_rows
            last = min(first + block_rows - 1, self%count)
            call self%source%read(path, self%before + first - 1, values(first:last), error)
            if (allocated(error)) exit
            check = add_hash(check, hash_reals(field_key(self%store, name, 1), &
               owners_of(self, first, last), values(first:last)))
         end do
      end if
      call self%verify(path, check, error)
   end subroutine reader_scalar

   !> Read a vector or tensor field. Collective.
   subroutine reader_vector(self, name, unit, values)
      class(reader_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: unit
      real(wp), allocatable, intent(inout) :: values(:, :) !! (particle, component), filled
      type(error_t), allocatable :: error
      real(wp), allocatable :: rows(:, :)
      integer(int64) :: check
      character(len=:), allocatable :: path
      integer :: component, components, first, last

      path = "/particles/"//self%store//"/"//name
      components = size(values, 2)
      if (name == set_anew) components = self%columns(path)
      deallocate (values)
      allocate (values(self%count, components), rows(components, min(block_rows, self%count)))
      values = 0.0_wp
      if (components == 0) return
      check = 0
      if (self%check_field(name)) then
         do first = 1, self%count, block_rows
            last = min(first + block_rows - 1, self%count)
            call self%source%read(path, self%before + first - 1, rows(:, :last - first + 1), error)
            if (allocated(error)) exit
            do component = 1, components
               values(first:last, component) = rows(component, :last - first + 1)
               check = add_hash(check, hash_reals(field_key(self%store, name, component), &
                  owners_of(self, first, last), values(first:last, component)))
            end do
         end do
      end if
      call self%verify(path, check, error)
   end subroutine reader_vector

   !> Read an integer field. Collective.
   subroutine reader_whole(self, name, unit, values)
      class(reader_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: unit
      integer(int64), allocatable, intent(inout) :: values(:) !! (particle), filled
      type(error_t), allocatable :: error
      integer(int64) :: check
      character(len=:), allocatable :: path
      integer :: first, last

      path = "/particles/"//self%store//"/"//name
      deallocate (values)
      allocate (values(self%count))
      values = 0
      check = 0
      if (self%check_field(name)) then
         do first = 1, self%count, block_rows
            last = min(first + block_rows - 1, self%count)
            call self%source%read(path, self%before + first - 1, values(first:last), error)
            if (allocated(error)) exit
            check = add_hash(check, hash_integers(field_key(self%store, name, 1), &
               owners_of(self, first, last), values(first:last)))
         end do
      end if
      call self%verify(path, check, error)
   end subroutine reader_whole
end module io_restart
