! SPDX-License-Identifier: BSD-3-Clause
!> Digest of the whole state of a run: equal digests mean equal bits.
!!
!! Each value of each particle is hashed with the identity of the particle and the names of material
!! and field, and the hashes are added. So the digest is independent of the order of particles, of
!! ranks, threads and restarts, and a checkpoint has the digest of its state.
module io_digest
   use base_agreement, only: agree
   use base_communicator, only: communicator_t
   use base_error, only: error_t
   use base_field_worker, only: field_reader_t
   use base_hash, only: add_hash, digest_text, hash_integers, hash_reals, hash_text, mix
   use base_kinds, only: int64, wp
   use io_hdf5_read, only: data_info_t, hdf5_source_t
   use io_hdf5_write, only: even_rows, rows_t
   use sample_order, only: tile_order
   use io_seal, only: check_seal, checkpoint_schema
   use io_state, only: state_t
   use particle_store, only: store_t
   implicit none
   private

   public :: field_key, file_digest, state_digest

   integer, parameter :: block_rows = 65536              !! Rows read together

   !> Hashes the fields of one store.
   type, extends(field_reader_t) :: digester_t
      character(len=:), allocatable :: store             !! Name of the material
      integer, allocatable :: order(:)                   !! Indices of the particles
      integer(int64), allocatable :: owners(:)           !! Identities of the particles
      integer(int64) :: sum = 0_int64                    !! Sum of all hashes
   contains
      procedure :: reals => digester_reals               !! Hash a field of real numbers
      procedure :: integers => digester_integers         !! Hash a field of integers
   end type digester_t

contains

   !> Key of one component of a field; a scalar has component 1.
   pure function field_key(store, field, component) result(key)
      character(len=*), intent(in) :: store              !! Name of the material
      character(len=*), intent(in) :: field              !! Name of the field
      integer, intent(in) :: component                   !! From 1
      integer(int64) :: key

      key = mix(ieor(hash_text(store//"/"//field), int(component, int64)))
   end function field_key

   !> Digest of a state in memory. Collective.
   function state_digest(communicator, stores, state) result(digest)
      type(communicator_t), intent(in) :: communicator
      type(store_t), intent(in) :: stores(:)
      type(state_t), intent(in) :: state                 !! Step and time
      character(len=16) :: digest
      type(digester_t) :: digester
      integer :: index

      do index = 1, size(stores)
         digester%store = stores(index)%name
         call tile_order(stores(index), digester%order)
         call gather_values(stores(index)%identity, digester%order, digester%owners)
         call stores(index)%show(digester)
      end do
      digest = digest_of(communicator, digester%sum, state%step, state%time)
   end function state_digest

   !> Digest of the state in a checkpoint, without its deck. Collective.
   subroutine file_digest(communicator, path, digest, error)
      type(communicator_t), intent(in) :: communicator
      character(len=*), intent(in) :: path               !! Checkpoint
      character(len=16), intent(out) :: digest           !! As that of the state in memory
      type(error_t), allocatable, intent(out) :: error   !! Cannot be read
      type(hdf5_source_t) :: source
      type(data_info_t), allocatable :: groups(:)
      integer(int64) :: step, sum
      real(wp) :: time
      integer :: index
      logical :: stored

      digest = ""
      sum = 0
      step = 0
      time = 0.0_wp
      call check_seal(communicator, path, checkpoint_schema, error)
      if (allocated(error)) return
      call source%open(path, error)
      if (.not. allocated(error)) call source%attribute("/", "step", step, error)
      if (.not. allocated(error)) call source%attribute("/", "time", time, error)
      if (.not. allocated(error)) call source%members("/particles", groups, error)
      if (.not. allocated(error)) then
         stored = .false.
         if (size(groups) == 0) stored = source%has("/state/digest")
         if (stored) then
            call read_digest(source, digest, error)
            call source%close()
            call agree(communicator, error)
            return
         end if
         do index = 1, size(groups)
            call digest_group(communicator, source, trim(groups(index)%name), sum, error)
            if (allocated(error)) exit
         end do
      end if
      call source%close()
      call agree(communicator, error)
      if (.not. allocated(error)) digest = digest_of(communicator, sum, step, time)
   end subroutine file_digest

   !> Read the digest of a state without particles, which its checkpoint stores.
   subroutine read_digest(source, digest, error)
      type(hdf5_source_t), intent(in) :: source          !! Open checkpoint
      character(len=16), intent(inout) :: digest         !! As that of the state in memory
      type(error_t), allocatable, intent(out) :: error   !! Cannot be read
      integer(int64) :: words(1)

      call source%read("/state/digest", 0_int64, words, error)
      if (.not. allocated(error)) digest = digest_text(words(1))
   end subroutine read_digest

   !> Add the hashes of one material in a checkpoint, for the rows of this rank.
   subroutine digest_group(communicator, source, store, sum, error)
      type(communicator_t), intent(in) :: communicator
      type(hdf5_source_t), intent(in) :: source          !! Open checkpoint
      character(len=*), intent(in) :: store              !! Name of the material
      integer(int64), intent(inout) :: sum               !! Sum of hashes
      type(error_t), allocatable, intent(out) :: error   !! Cannot be read
      type(data_info_t), allocatable :: fields(:)
      type(data_info_t) :: identity
      type(rows_t) :: rows
      integer(int64), allocatable :: owners(:)
      integer(int64) :: before, last
      character(len=:), allocatable :: group
      integer :: field

      group = "/particles/"//store
      call source%info(group//"/identity", identity, error)
      if (.not. allocated(error)) call source%members(group, fields, error)
      if (allocated(error)) return
      rows = even_rows(communicator, identity%rows)
      before = rows%before(1)
      last = before + rows%count(1)
      do while (before < last)
         allocate (owners(min(int(block_rows, int64), last - before)))
         call source%read(group//"/identity", before, owners, error)
         do field = 1, size(fields)
            if (allocated(error)) return
            call digest_block(source, store, fields(field), before, owners, sum, error)
         end do
         if (allocated(error)) return
         before = before + size(owners)
         deallocate (owners)
      end do
   end subroutine digest_group

   !> Add the hashes of some rows of one field in a checkpoint.
   subroutine digest_block(source, store, field, before, owners, sum, error)
      type(hdf5_source_t), intent(in) :: source          !! Open checkpoint
      character(len=*), intent(in) :: store              !! Name of the material
      type(data_info_t), intent(in) :: field             !! Name of the field
      integer(int64), intent(in) :: before               !! Rows before the first
      integer(int64), contiguous, intent(in) :: owners(:) !! Identities of the rows
      integer(int64), intent(inout) :: sum               !! Sum of hashes
      type(error_t), allocatable, intent(out) :: error   !! Cannot be read
      integer(int64), allocatable :: integers(:)
      real(wp), allocatable :: column(:), reals(:, :)
      character(len=:), allocatable :: path
      integer :: component

      path = "/particles/"//store//"/"//trim(field%name)
      allocate (column(size(owners)))
      if (.not. field%is_real) then
         allocate (integers(size(owners)))
         call source%read(path, before, integers, error)
         if (allocated(error)) return
         sum = add_hash(sum, hash_integers(field_key(store, trim(field%name), 1), owners, integers))
      else if (field%dimensions == 1) then
         call source%read(path, before, column, error)
         if (allocated(error)) return
         sum = add_hash(sum, hash_reals(field_key(store, trim(field%name), 1), owners, column))
      else
         allocate (reals(field%components, size(owners)))
         call source%read(path, before, reals, error)
         if (allocated(error)) return
         do component = 1, field%components
            column(:) = reals(component, :)
            sum = add_hash(sum, hash_reals(field_key(store, trim(field%name), component), owners, &
               column))
         end do
      end if
   end subroutine digest_block

   !> Digest as text: the sum over all ranks, mixed with step and time. Collective.
   function digest_of(communicator, sum, step, time) result(digest)
      type(communicator_t), intent(in) :: communicator
      integer(int64), intent(in) :: sum                  !! Sum of the hashes of this rank
      integer(int64), intent(in) :: step                 !! Steps done
      real(wp), intent(in) :: time                       !! Simulated time [s]
      character(len=16) :: digest
      integer(int64) :: whole(1)

      whole = sum
      call communicator%total(whole)
      digest = digest_text(mix(ieor(mix(ieor(mix(whole(1)), step)), transfer(time, step))))
   end function digest_of

   !> Gather values by index.
   pure subroutine gather_values(values, order, picked)
      integer(int64), contiguous, intent(in) :: values(:) !! (particle)
      integer, contiguous, intent(in) :: order(:)        !! Indices
      integer(int64), allocatable, intent(out) :: picked(:) !! Values at these indices
      integer :: index

      allocate (picked(size(order)))
      do index = 1, size(order)
         picked(index) = values(order(index))
      end do
   end subroutine gather_values

   !> Hash a field of real numbers.
   subroutine digester_reals(self, name, unit, is_scalar, values)
      class(digester_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: unit
      logical, intent(in) :: is_scalar                   !! One number a particle?
      real(wp), contiguous, intent(in) :: values(:, :) !! (particle, component)
      real(wp), allocatable :: column(:)
      integer :: component, index

      allocate (column(size(self%order)))
      do component = 1, size(values, 2)
         do index = 1, size(column)
            column(index) = values(self%order(index), component)
         end do
         self%sum = add_hash(self%sum, hash_reals(field_key(self%store, name, component), &
            self%owners, column))
      end do
   end subroutine digester_reals

   !> Hash a field of integers.
   subroutine digester_integers(self, name, unit, values)
      class(digester_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: unit
      integer(int64), contiguous, intent(in) :: values(:) !! (particle)
      integer(int64), allocatable :: column(:)

      call gather_values(values, self%order, column)
      self%sum = add_hash(self%sum, hash_integers(field_key(self%store, name, 1), self%owners, &
         column))
   end subroutine digester_integers
end module io_digest
