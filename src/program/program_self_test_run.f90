! SPDX-License-Identifier: BSD-3-Clause
!> One run of a scene of the self-test: from its deck to its digest, with the files read back.
module program_self_test_run
   use base_agreement, only: agree
   use base_communicator, only: communicator_t
   use base_error, only: error_t, exit_internal, exit_success, fail
   use base_file, only: folder_of, join_path, list_folder, longest_name, name_of
   use base_hash, only: add_hash, hash_reals
   use base_kinds, only: int64, wp
   use base_text, only: text_t
   use io_digest, only: file_digest, state_digest
   use io_hdf5_read, only: data_info_t, hdf5_source_t
   use io_hdf5_write, only: even_rows, rows_t
   use sample_order, only: tile_order
   use io_state, only: state_t
   use omp_lib, only: omp_set_num_threads
   use output_checkpoint, only: describe_state
   use particle_store, only: store_t
   use run_setup, only: a_scene
   use run_type, only: run_t
   use step_ledger, only: balance_t
   implicit none
   private

   public :: outcome_t, run_scene

   !> What a run gave.
   type :: outcome_t
      character(len=16) :: digest = ""               !! Digest of the state at the end
      character(len=16) :: halfway = ""              !! Digest of the state at the checkpoint
      character(len=16) :: stored = ""               !! Digest in the file of the checkpoint
      character(len=:), allocatable :: checkpoint    !! Path of the checkpoint
      logical :: same_snapshot = .false.  !! Has the last snapshot the positions in memory?
      integer(int64) :: steps = 0                    !! Steps from the start of the scene
      integer(int64) :: particles = 0                !! At the end, on all ranks
      type(balance_t) :: balance                     !! Errors of mass, momentum and energy
   end type outcome_t

contains

   !> Run a scene to its end, with a checkpoint after half of its steps if it begins at its start.
   !! Nothing is printed. Collective.
   subroutine run_scene(arguments, threads, outcome, error)
      type(text_t), intent(in) :: arguments(:)       !! As on the command line of scree
      integer, intent(in) :: threads                 !! Number of threads of a rank
      type(outcome_t), intent(out) :: outcome
      type(error_t), allocatable, intent(out) :: error !! The run failed
      type(run_t), allocatable :: run
      integer :: code

      call omp_set_num_threads(threads)
      allocate (run)
      run%log%mute = .true.
      call run%options%parse(arguments, error)
      if (allocated(error)) return
      call run%simulation%machine%communicator%start()
      call run%read(a_scene, error)
      if (.not. allocated(error)) call run%build(.true., error)
      if (allocated(error)) return
      ! a test that a signal ends has no result
      deallocate (run%limits%signals)
      allocate (character(len=4) :: run%limits%signals(0))
      call run%start(error)
      if (allocated(error)) return
      call advance_to_end(run, outcome, error)
      if (.not. allocated(error)) call run%end(code, error)
      if (.not. allocated(error) .and. code /= exit_success) call fail(error, exit_internal, &
         run%loop%reason)
      if (.not. allocated(error)) call measure(run, outcome, error)
      call run%log%close()
   end subroutine run_scene

   !> Do all steps of a run, and write a checkpoint after half of them. Collective.
   subroutine advance_to_end(run, outcome, error)
      type(run_t), intent(inout) :: run      !! Has begun
      type(outcome_t), intent(inout) :: outcome      !! Gets the checkpoint
      type(error_t), allocatable, intent(out) :: error !! The checkpoint is not written

      associate (communicator => run%simulation%machine%communicator)
         do while (.not. run%loop%finished)
            call run%advance()
            if (run%options%restart) cycle
            if (run%simulation%clock%step /= run%limits%max_steps/2) cycle
            outcome%checkpoint = run%place%path()
            call run%loop%checkpoint(run%simulation, run%outputs, run%place, &
               run%log, error)
            if (allocated(error)) return
            outcome%halfway = digest_of(run)
            call file_digest(communicator, outcome%checkpoint, outcome%stored, error)
            if (allocated(error)) return
         end do
      end associate
   end subroutine advance_to_end

   !> Digest of the present state. Collective.
   function digest_of(run) result(digest)
      type(run_t), intent(in) :: run
      character(len=16) :: digest
      type(state_t) :: state

      call describe_state(run%simulation, state)
      digest = state_digest(run%simulation%machine%communicator, run%simulation%stores, &
         state)
   end function digest_of

   !> Digest, balance and last snapshot of a run at its end. Collective.
   subroutine measure(run, outcome, error)
      type(run_t), intent(inout) :: run      !! At its end
      type(outcome_t), intent(inout) :: outcome      !! Gets the digests
      type(error_t), allocatable, intent(out) :: error !! The snapshot cannot be read
      integer(int64) :: counts(1)
      integer :: index

      associate (simulation => run%simulation)
         outcome%digest = digest_of(run)
         outcome%steps = simulation%clock%step
         counts = 0
         do index = 1, size(simulation%stores)
            counts = counts + simulation%stores(index)%particles()
         end do
         call simulation%machine%communicator%total(counts)
         outcome%particles = counts(1)
         call simulation%balance%ledger%balance(simulation%machine%communicator, &
            simulation%space%grid, simulation%stores, simulation%materials, outcome%balance)
         call compare_snapshot(simulation%machine%communicator, simulation%stores, &
            join_path(run%outputs%folder, run%outputs%case//"_p_"), outcome, error)
      end associate
   end subroutine measure

   !> Compare the positions in the last snapshot with those in memory. Collective.
   subroutine compare_snapshot(communicator, stores, stem, outcome, error)
      type(communicator_t), intent(in) :: communicator
      type(store_t), intent(in) :: stores(:)         !! At the end of the run
      character(len=*), intent(in) :: stem           !! Path of the snapshots up to their numbers
      type(outcome_t), intent(inout) :: outcome      !! Gets the result
      type(error_t), allocatable, intent(out) :: error !! Cannot be read
      character(len=longest_name), allocatable :: names(:)
      integer(int64) :: sums(2), rows(1)

      call list_folder(folder_of(stem), name_of(stem), ".hdf", names, error)
      if (allocated(error)) return
      sums = 0
      call hash_file(communicator, join_path(folder_of(stem), trim(names(size(names)))), sums(1), &
         rows(1), error)
      call agree(communicator, error)
      if (allocated(error)) return
      call hash_stores(stores, sums(2))
      call communicator%total(sums)
      outcome%same_snapshot = sums(1) == sums(2) .and. rows(1) == outcome%particles .and. &
         rows(1) > 0
   end subroutine compare_snapshot

   !> Sum of the hashes of the positions of all particles of this rank.
   subroutine hash_stores(stores, sum)
      type(store_t), intent(in) :: stores(:)
      integer(int64), intent(inout) :: sum           !! Gets the hashes
      integer, allocatable :: order(:)
      real(wp), allocatable :: points(:, :)
      integer :: index

      do index = 1, size(stores)
         call tile_order(stores(index), order)
         allocate (points(3, size(order)))
         points(:, :) = transpose(stores(index)%position(order, :))
         sum = add_hash(sum, hash_points(points))
         deallocate (points)
      end do
   end subroutine hash_stores

   !> Sum of the hashes of the positions in a snapshot, for the rows of this rank.
   subroutine hash_file(communicator, path, sum, rows, error)
      type(communicator_t), intent(in) :: communicator
      character(len=*), intent(in) :: path           !! Snapshot
      integer(int64), intent(inout) :: sum           !! Gets the hashes
      integer(int64), intent(out) :: rows            !! Particles in the file
      type(error_t), allocatable, intent(out) :: error !! Cannot be read
      character(len=*), parameter :: name = "/VTKHDF/Points"
      type(hdf5_source_t) :: source
      type(data_info_t) :: info
      type(rows_t) :: mine
      real(wp), allocatable :: points(:, :)

      rows = 0
      call source%open(path, error)
      if (.not. allocated(error)) call source%info(name, info, error)
      if (.not. allocated(error)) then
         rows = info%rows
         mine = even_rows(communicator, rows)
         allocate (points(3, mine%count(1)))
         call source%read(name, mine%before(1), points, error)
         if (.not. allocated(error)) sum = add_hash(sum, hash_points(points))
      end if
      call source%close()
   end subroutine hash_file

   !> Sum of the hashes of positions. In an axisymmetric scene the second component, the angle, is
   !! not written; no scene of the self-test moves along y, so it is left out.
   pure function hash_points(points) result(sum)
      real(wp), intent(in) :: points(:, :)           !! (component, particle) [m]
      integer(int64) :: sum
      integer(int64), allocatable :: owners(:)
      real(wp), allocatable :: column(:)
      integer :: component

      allocate (owners(size(points, 2)), column(size(points, 2)))
      owners = 0
      sum = 0
      do component = 1, 3, 2
         column(:) = points(component, :)
         sum = add_hash(sum, hash_reals(int(component, int64), owners, column))
      end do
   end function hash_points
end module program_self_test_run
