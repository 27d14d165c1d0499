! SPDX-License-Identifier: BSD-3-Clause
!> The state of a cell of grains as named values of a checkpoint, and back.
!!
!! With the coordinates at which pairs were found a restart finds the same pairs, and finds new ones
!! in the same step as a run without a restart.
module grains_checkpoint
   use base_error, only: error_t, exit_file, fail
   use base_exact_sum, only: exact_sum_words
   use base_exact_totals, only: total_words
   use base_hash, only: hash_integers, hash_reals, mix
   use base_kinds, only: int64, wp
   use grains_cell, only: cell_t, losses
   use grains_exchange, only: gather_rows, link_halo, own_rows
   use grains_histories, only: collect_records, give_records, record_words, share_records
   use grains_neighbours, only: find_pairs
   use grains_path, only: path_t
   use grains_state, only: grains_t
   use io_state, only: entry_t, state_t
   implicit none
   private

   public :: cell_hash, load_cell, save_cell

contains

   !> Write the state. Collective; the same on all ranks.
   subroutine save_cell(cell, path, energy_at_start, state)
      type(cell_t), intent(inout) :: cell            !! Only rows of other ranks are changed
      type(path_t), intent(in) :: path
      real(wp), intent(in) :: energy_at_start        !! [J]
      type(state_t), intent(out) :: state
      real(wp), allocatable :: records(:, :)
      integer(int64) :: words(exact_sum_words)
      integer :: loss

      associate (grains => cell%grains, c => cell%communicator)
         call gather_rows(c, grains%first, grains%last, grains%place)
         call gather_rows(c, grains%first, grains%last, grains%velocity)
         call gather_rows(c, grains%first, grains%last, grains%spin)
         call gather_rows(c, grains%first, grains%last, grains%force)
         call gather_rows(c, grains%first, grains%last, grains%torque)
         call collect_records(grains, cell%pairs, .true., records)
         call share_records(c, records)
         state%step = cell%step
         state%time = cell%time
         state%dt_next = cell%dt
         call state%set("space", [int(cell%box%dimension, int64), int(grains%count, int64)])
         call state%set("identity", int(grains%identity, int64))
         call state%set("radius", grains%radius)
         call set_rows(state, "place", grains%place)
         call set_rows(state, "velocity", grains%velocity)
         call set_rows(state, "spin", grains%spin)
         call set_rows(state, "force", grains%force)
         call set_rows(state, "torque", grains%torque)
         call set_rows(state, "reference", cell%reference%place)
         call sort_records(records)
         call set_rows(state, "contacts", records)
      end associate
      do loss = 1, losses
         call save_lost(cell, loss, words)
         call state%set("lost_"//"123"(loss:loss), words)
      end do
      call state%set("edges", reshape([cell%box%edges, cell%reference%edges, cell%box%gradient], &
         [27]))
      call state%set("sums", [cell%contact, cell%kinetic, cell%mean%contact, cell%mean%kinetic])
      call state%set("numbers", [cell%box%strain, cell%reference%sorted, cell%work, &
         cell%lost_before, cell%mean%time, energy_at_start, path%from_fraction, &
         path%from_height])
      call state%set("path", [int(path%now, int64), path%start, cell%searches])
   end subroutine save_cell

   !> Words of a sum of losses over the ranks. Collective.
   subroutine save_lost(cell, loss, words)
      type(cell_t), intent(in) :: cell
      integer, intent(in) :: loss
      integer(int64), intent(out) :: words(exact_sum_words)

      call cell%lost(loss)%save(words)
      call total_words(cell%communicator, words)
   end subroutine save_lost

   !> Store rows of several words.
   subroutine set_rows(state, name, values)
      type(state_t), intent(inout) :: state
      character(len=*), intent(in) :: name
      real(wp), intent(in) :: values(:, :)           !! (word, row)

      call state%set(name, reshape(values, [size(values)]))
   end subroutine set_rows

   !> Sort records by identity, so that their order does not depend on ranks.
   pure subroutine sort_records(records)
      real(wp), intent(inout) :: records(:, :)       !! (word, record)
      real(wp) :: record(record_words)
      integer :: gap, n, m

      gap = size(records, 2)/2
      do while (gap > 0)
         do n = gap + 1, size(records, 2)
            record = records(:, n)
            m = n - gap
            do while (m >= 1)
               if (.not. comes_after(records(1:2, m), record(1:2))) exit
               records(:, m + gap) = records(:, m)
               m = m - gap
            end do
            records(:, m + gap) = record
         end do
         gap = gap/2
      end do
   end subroutine sort_records

   !> True if a pair of identities sorts after another pair.
   pure logical function comes_after(a, b) result(after)
      real(wp), intent(in) :: a(2), b(2)             !! Identities

      after = a(1) > b(1) .or. (a(1) >= b(1) .and. a(2) > b(2))
   end function comes_after

   !> Read the state. Collective.
   subroutine load_cell(state, cell, path, energy_at_start, error)
      type(state_t), intent(in) :: state
      type(cell_t), intent(inout) :: cell            !! As the deck describes it
      type(path_t), intent(inout) :: path
      real(wp), intent(out) :: energy_at_start       !! [J]
      type(error_t), allocatable, intent(out) :: error !! The file is of other grains
      integer(int64), allocatable :: words(:)
      real(wp), allocatable :: numbers(:)

      energy_at_start = 0.0_wp
      call state%get("space", words, error)
      if (allocated(error)) return
      if (any(words /= [int(cell%box%dimension, int64), int(cell%grains%count, int64)])) then
         call fail(error, exit_file, "the checkpoint has other grains: shape and number of "// &
            "&grains must not change [F112]")
         return
      end if
      call load_grains(state, cell%grains, error)
      if (.not. allocated(error)) call state%get("numbers", numbers, error)
      if (allocated(error)) return
      cell%step = state%step
      cell%time = state%time
      cell%box%strain = numbers(1)
      cell%reference%sorted = numbers(2)
      cell%work = numbers(3)
      cell%lost_before = numbers(4:3 + losses)
      cell%mean%time = numbers(4 + losses)
      energy_at_start = numbers(5 + losses)
      path%from_fraction = numbers(6 + losses)
      path%from_height = numbers(7 + losses)
      call load_sums(state, cell, error)
      if (.not. allocated(error)) call load_lost(state, cell, error)
      if (.not. allocated(error)) call state%get("path", words, error)
      if (allocated(error)) return
      path%now = int(words(1))
      path%start = words(2)
      cell%searches = words(3)
      call load_pairs(state, cell, error)
   end subroutine load_cell

   !> Read the grains.
   subroutine load_grains(state, grains, error)
      type(state_t), intent(in) :: state
      type(grains_t), intent(inout) :: grains
      type(error_t), allocatable, intent(out) :: error
      integer(int64), allocatable :: identity(:)
      real(wp) :: mass(grains%count), inertia(grains%count)
      real(wp), allocatable :: radius(:)

      call state%get("identity", identity, error)
      if (.not. allocated(error)) call state%get("radius", radius, error)
      if (allocated(error)) return
      ! the deck has filled them in the order of identities
      mass = grains%mass
      inertia = grains%inertia
      grains%identity = int(identity)
      grains%radius = radius
      grains%mass = mass(grains%identity)
      grains%inertia = inertia(grains%identity)
      call get_rows(state, "place", grains%place, error)
      if (.not. allocated(error)) call get_rows(state, "velocity", grains%velocity, error)
      if (.not. allocated(error)) call get_rows(state, "spin", grains%spin, error)
      if (.not. allocated(error)) call get_rows(state, "force", grains%force, error)
      if (.not. allocated(error)) call get_rows(state, "torque", grains%torque, error)
   end subroutine load_grains

   !> Get rows of several words.
   subroutine get_rows(state, name, values, error)
      type(state_t), intent(in) :: state
      character(len=*), intent(in) :: name
      real(wp), intent(inout) :: values(:, :)        !! (word, row)
      type(error_t), allocatable, intent(out) :: error
      real(wp), allocatable :: flat(:)

      call state%get(name, flat, error)
      if (.not. allocated(error)) values = reshape(flat, shape(values))
   end subroutine get_rows

   !> Read edges, gradient and sums.
   subroutine load_sums(state, cell, error)
      type(state_t), intent(in) :: state
      type(cell_t), intent(inout) :: cell
      type(error_t), allocatable, intent(out) :: error
      real(wp), allocatable :: numbers(:)

      call state%get("edges", numbers, error)
      if (allocated(error)) return
      cell%box%edges = reshape(numbers(1:9), [3, 3])
      cell%reference%edges = reshape(numbers(10:18), [3, 3])
      cell%box%gradient = reshape(numbers(19:27), [3, 3])
      call state%get("sums", numbers, error)
      if (allocated(error)) return
      cell%contact = numbers(1:9)
      cell%kinetic = numbers(10:18)
      cell%mean%contact = numbers(19:27)
      cell%mean%kinetic = numbers(28:36)
   end subroutine load_sums

   !> Read the losses of pairs that have separated; rank 0 keeps them.
   subroutine load_lost(state, cell, error)
      type(state_t), intent(in) :: state
      type(cell_t), intent(inout) :: cell
      type(error_t), allocatable, intent(out) :: error
      integer(int64), allocatable :: words(:)
      integer :: loss

      do loss = 1, losses
         call cell%lost(loss)%clear()
         call state%get("lost_"//"123"(loss:loss), words, error)
         if (allocated(error)) return
         if (cell%communicator%rank == 0) call cell%lost(loss)%load(words)
      end do
   end subroutine load_lost

   !> Find the pairs from the coordinates of the last neighbour search, and restore their histories.
   !! Collective.
   subroutine load_pairs(state, cell, error)
      type(state_t), intent(in) :: state
      type(cell_t), intent(inout) :: cell
      type(error_t), allocatable, intent(out) :: error
      real(wp), allocatable :: flat(:), place(:, :)
      real(wp) :: edges(3, 3)

      cell%reference%place = cell%grains%place
      call get_rows(state, "reference", cell%reference%place, error)
      if (.not. allocated(error)) call state%get("contacts", flat, error)
      if (allocated(error)) return
      call own_rows(cell%communicator, cell%grains)
      place = cell%grains%place
      edges = cell%box%edges
      cell%grains%place = cell%reference%place
      cell%box%edges = cell%reference%edges
      call find_pairs(cell%grains, cell%box, cell%skin, cell%pairs)
      cell%grains%place = place
      cell%box%edges = edges
      call give_records(cell%grains, reshape(flat, [record_words, size(flat)/record_words]), &
         cell%pairs)
      call link_halo(cell%communicator, cell%grains, cell%pairs, cell%halo)
      call cell%grains%locate(cell%box, 1, cell%grains%count)
   end subroutine load_pairs

   !> Hash of a state: equal hashes mean equal bits. Checkpoints store it as `digest`.
   pure function cell_hash(state) result(sum)
      type(state_t), intent(in) :: state             !! From `save_cell`
      integer(int64) :: sum
      integer(int64), allocatable :: owners(:)
      integer(int64) :: n
      integer :: entry

      sum = mix(ieor(mix(state%step), transfer(state%time, sum)))
      do entry = 1, size(state%entries)
         associate (values => state%entries(entry))
            if (allocated(values%reals)) then
               owners = [(n, n=1, size(values%reals))]
               sum = ieor(mix(sum), hash_reals(int(entry, int64), owners, values%reals))
            else
               owners = [(n, n=1, size(values%integers))]
               sum = ieor(mix(sum), hash_integers(int(entry, int64), owners, values%integers))
            end if
         end associate
      end do
   end function cell_hash
end module grains_checkpoint
