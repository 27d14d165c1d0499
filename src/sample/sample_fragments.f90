! SPDX-License-Identifier: BSD-3-Clause
!> Fragments are sets of particles whose cells touch each other.
!!
!! Cells with particles and a common node are connected, because their particles interact there; a
!! limit on the difference of their velocities can separate them. Bodies in contact have separate
!! velocities at a node, so their cells are not connected. All ranks receive all such cells
!! (8 bytes each, 32 with that limit) and find the same fragments; one rank sums the content of a
!! fragment in the order of its cells, so that no bit depends on the number of ranks.
module sample_fragments
   use base_communicator, only: communicator_t
   use base_kinds, only: int64, wp
   use base_sort, only: sort_order
   use mesh_grid, only: grid_t
   use mesh_hash_table, only: key_table_t
   use particle_store, only: store_t
   use sample_cells, only: cells_t, find_cells
   use sample_fields, only: picks_t
   use sample_fragment_sums, only: add_fragment, cell_sums, fragment_words, sum_words
   use sample_pick, only: pick_rule_t
   implicit none
   private

   public :: fragment_columns, fragment_labels, fragment_rows, fragments_t, labels_t

   integer, parameter :: column_length = 40              !! Longest heading of a column

   !> Definition of fragments.
   type :: fragments_t
      type(pick_rule_t) :: rule
      real(wp) :: velocity_cut = huge(1.0_wp) !! Greatest difference of cells [m/s]
      !> (store) Groups, from 0, whose cells are not connected; not allocated: all in one
      integer, allocatable :: group(:)
   end type fragments_t

   !> The fragments of the particles of a store.
   type :: labels_t
      integer(int64), allocatable :: fragment(:)         !! (particle) Number in the table, 0 = none
   end type labels_t

   !> All cells with particles, the same on all ranks.
   type :: map_t
      integer(int64), allocatable :: key(:)              !! (cell) Number in the box, ascending
      real(wp), allocatable :: velocity(:, :)            !! (3, cell) If needed [m/s]
      integer, allocatable :: fragment(:)                !! (cell) From 1
      integer, allocatable :: number(:)                  !! (fragment) In the table, by mass
      integer, allocatable :: image(:, :)                !! (3, cell) Shift in periods
      type(key_table_t) :: table                         !! From key to cell
   end type map_t

contains

   !> Headings of the columns.
   function fragment_columns() result(columns)
      character(len=column_length), allocatable :: columns(:)

      columns = [character(len=column_length) :: "time [s]", "step", "fragment", "particles", &
         "mass [kg]", "volume [m3]", "centre_x [m]", "centre_y [m]", "centre_z [m]", &
         "velocity_x [m/s]", "velocity_y [m/s]", "velocity_z [m/s]", &
         "angular_momentum_x [kg m2/s]", "angular_momentum_y [kg m2/s]", &
         "angular_momentum_z [kg m2/s]", "kinetic [J]", "lower_x [m]", "lower_y [m]", &
         "lower_z [m]", "upper_x [m]", "upper_y [m]", "upper_z [m]", "failed_share [1]", &
         "identity"]
   end function fragment_columns

   !> The table of one time, all columns but time and step: (column, fragment), the heaviest first.
   !! The same on all ranks. Collective.
   subroutine fragment_rows(communicator, grid, tiles, stores, wanted, rows)
      type(communicator_t), intent(in) :: communicator
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: tiles(:, :)     !! (3, tile) Tiles of this rank, from 0
      type(store_t), intent(in) :: stores(:)
      type(fragments_t), intent(in) :: wanted            !! Definition of fragments
      real(wp), allocatable, intent(out) :: rows(:, :)   !! (column, row)
      type(picks_t), allocatable :: picks(:)
      type(cells_t) :: cells
      type(map_t) :: map

      call find_fragments(communicator, grid, tiles, stores, wanted, picks, cells, map, rows)
   end subroutine fragment_rows

   !> The number that each particle's fragment has in the table of this time. Collective.
   subroutine fragment_labels(communicator, grid, tiles, stores, wanted, labels)
      type(communicator_t), intent(in) :: communicator
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: tiles(:, :)     !! (3, tile) Tiles of this rank, from 0
      type(store_t), intent(in) :: stores(:)
      type(fragments_t), intent(in) :: wanted            !! Definition of fragments
      type(labels_t), allocatable, intent(out) :: labels(:) !! (store)
      type(picks_t), allocatable :: picks(:)
      type(cells_t) :: cells
      type(map_t) :: map
      real(wp), allocatable :: rows(:, :)
      integer, allocatable :: number(:)
      integer :: cell, filled, n, row

      call find_fragments(communicator, grid, tiles, stores, wanted, picks, cells, map, rows)
      allocate (labels(size(stores)), number(cells%count))
      do cell = 1, cells%count
         number(cell) = map%number(map%fragment(map%table%find(cells%key(grid, cell))))
      end do
      filled = 0
      do n = 1, size(stores)
         allocate (labels(n)%fragment(size(stores(n)%identity)), source=0_int64)
         do row = 1, size(picks(n)%order)
            filled = filled + 1
            labels(n)%fragment(picks(n)%order(row)) = number(cells%of_row(filled))
         end do
      end do
   end subroutine fragment_labels

   !> Find the fragments and their contents. Collective.
   subroutine find_fragments(communicator, grid, tiles, stores, wanted, picks, cells, map, rows)
      type(communicator_t), intent(in) :: communicator
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: tiles(:, :)     !! (3, tile) Tiles of this rank, from 0
      type(store_t), intent(in) :: stores(:)
      type(fragments_t), intent(in) :: wanted            !! Definition of fragments
      type(picks_t), allocatable, intent(out) :: picks(:) !! (store) Selected particles
      type(cells_t), intent(out) :: cells                !! Cells of the fragments on this rank
      type(map_t), intent(out) :: map                    !! All cells with their fragments
      real(wp), allocatable, intent(out) :: rows(:, :)   !! (column, row)
      real(wp), allocatable :: sums(:, :), here(:, :)
      integer(int64), allocatable :: key(:)
      integer :: n

      allocate (picks(size(stores)))
      do n = 1, size(stores)
         call wanted%rule%pick(stores(n), picks(n)%order)
      end do
      call find_cells(grid, tiles, stores, picks, cells, wanted%group)
      call cell_sums(stores, picks, cells, sums)
      call learn_cells(communicator, grid, cells, sums, wanted%velocity_cut, map)
      call connect(grid, wanted%velocity_cut, map)
      call hand_over(communicator, grid, cells, sums, map, key, here)
      call add_all(grid, map, key, here, rows)
      call collect(communicator, rows, map%number)
   end subroutine find_fragments

   !> Send the cells of all ranks to all ranks. Collective.
   subroutine learn_cells(communicator, grid, cells, sums, velocity_cut, map)
      type(communicator_t), intent(in) :: communicator
      type(grid_t), intent(in) :: grid
      type(cells_t), intent(in) :: cells                 !! Part of this rank
      real(wp), intent(in) :: sums(:, :)                 !! (sum, cell)
      real(wp), intent(in) :: velocity_cut               !! Finite: velocities go along [m/s]
      type(map_t), intent(out) :: map                    !! All cells
      integer(int64), allocatable :: own(:), whole(:)
      integer, allocatable :: order(:)
      integer :: cell, words, count

      words = merge(4, 1, velocity_cut < huge(1.0_wp))
      allocate (own(words*cells%count))
      do cell = 1, cells%count
         own(words*(cell - 1) + 1) = cells%key(grid, cell)
         if (words > 1) own(words*(cell - 1) + 2:words*cell) = &
            transfer(sums(7:9, cell)/sums(2, cell), own, 3)
      end do
      call communicator%gather(own, whole)
      count = size(whole)/words
      order = sort_order(whole(1::words))
      allocate (map%key(count), map%fragment(count), map%image(3, count))
      if (words > 1) allocate (map%velocity(3, count))
      map%fragment = 0
      map%image = 0
      call map%table%clear(count)
      do cell = 1, count
         map%key(cell) = whole(words*(order(cell) - 1) + 1)
         call map%table%insert(map%key(cell), cell)
         if (words > 1) map%velocity(:, cell) = transfer( &
            whole(words*(order(cell) - 1) + 2:words*order(cell)), map%velocity, 3)
      end do
   end subroutine learn_cells

   !> Give each cell the number of its fragment, and the image of the box in which it is connected
   !! to the first cell of the fragment.
   subroutine connect(grid, velocity_cut, map)
      type(grid_t), intent(in) :: grid
      real(wp), intent(in) :: velocity_cut               !! Greater differences separate cells [m/s]
      type(map_t), intent(inout) :: map                  !! All cells
      integer, allocatable :: stack(:)
      integer :: start, cell, next, height, fragments, neighbour, image(3)

      allocate (stack(size(map%key)))
      fragments = 0
      do start = 1, size(map%key)
         if (map%fragment(start) > 0) cycle
         fragments = fragments + 1
         map%fragment(start) = fragments
         stack(1) = start
         height = 1
         do while (height > 0)
            cell = stack(height)
            height = height - 1
            do neighbour = 0, 26
               call step_to(grid, map, cell, [mod(neighbour, 3), mod(neighbour/3, 3), &
                  neighbour/9] - 1, next, image)
               if (.not. joins(map, cell, next, velocity_cut)) cycle
               map%fragment(next) = fragments
               map%image(:, next) = image
               height = height + 1
               stack(height) = next
            end do
         end do
      end do
   end subroutine connect

   !> True if a neighbour joins the fragment of a cell: it has particles, is in no fragment yet, and
   !! has a similar velocity.
   pure logical function joins(map, cell, next, velocity_cut) result(joined)
      type(map_t), intent(in) :: map                     !! All cells
      integer, intent(in) :: cell                        !! Index among the cells
      integer, intent(in) :: next                        !! Index of the neighbour, 0 = no particles
      real(wp), intent(in) :: velocity_cut               !! Least velocity of separation [m/s]

      joined = .false.
      if (next == 0) return
      if (map%fragment(next) > 0) return
      joined = .true.
      if (allocated(map%velocity)) joined = &
         .not. norm2(map%velocity(:, next) - map%velocity(:, cell)) > velocity_cut
   end function joins

   !> The neighbour of a cell, through periodic boundaries where necessary; 0 if none.
   pure subroutine step_to(grid, map, cell, way, next, image)
      type(grid_t), intent(in) :: grid
      type(map_t), intent(in) :: map                     !! All cells
      integer, intent(in) :: cell                        !! Index of the cell
      integer, intent(in) :: way(3)                      !! Direction: -1, 0 or 1 along each axis
      integer, intent(out) :: next                       !! Index of the neighbour
      integer, intent(out) :: image(3)                   !! Shift in periods
      integer :: place(3), direction
      integer(int64) :: group

      next = 0
      group = map%key(cell)/product(int(grid%cells, int64))
      place = place_of(grid, map%key(cell)) + way
      image = map%image(:, cell)
      do direction = 1, 3
         if (place(direction) >= 0 .and. place(direction) < grid%cells(direction)) cycle
         if (.not. (grid%periodic(direction) .and. grid%active(direction))) return
         image(direction) = image(direction) + way(direction)
         place(direction) = modulo(place(direction), grid%cells(direction))
      end do
      next = map%table%find(place(1) + grid%cells(1)*(place(2) &
         + int(grid%cells(2), int64)*(place(3) + grid%cells(3)*group)))
   end subroutine step_to

   !> Place of a cell in the box, from 0.
   pure function place_of(grid, key) result(place)
      type(grid_t), intent(in) :: grid
      integer(int64), intent(in) :: key                  !! Number
      integer :: place(3)

      place(1) = int(mod(key, int(grid%cells(1), int64)))
      place(2) = int(mod(key/grid%cells(1), int(grid%cells(2), int64)))
      place(3) = int(mod(key/(int(grid%cells(1), int64)*grid%cells(2)), int(grid%cells(3), int64)))
   end function place_of

   !> Send the sums of each cell to the rank that sums its fragment. Collective.
   subroutine hand_over(communicator, grid, cells, sums, map, key, here)
      type(communicator_t), intent(in) :: communicator
      type(grid_t), intent(in) :: grid
      type(cells_t), intent(in) :: cells                 !! Part of this rank
      real(wp), intent(in) :: sums(:, :)                 !! (sum, cell)
      type(map_t), intent(in) :: map                     !! All cells
      integer(int64), allocatable, intent(out) :: key(:) !! Cells of the fragments of this rank
      real(wp), allocatable, intent(out) :: here(:, :)   !! (sum, cell) Their sums
      integer, parameter :: words = sum_words + 1
      type(communicator_t) :: ranks
      integer(int64), allocatable :: outgoing(:, :), incoming(:)
      integer, allocatable :: target_rank(:), order(:)
      integer :: cell, n

      allocate (target_rank(cells%count), outgoing(words, cells%count))
      do cell = 1, cells%count
         outgoing(1, cell) = cells%key(grid, cell)
         outgoing(2:, cell) = transfer(sums(:, cell), outgoing, sum_words)
         target_rank(cell) = mod(map%fragment(map%table%find(outgoing(1, cell))), &
            communicator%size)
      end do
      ranks = communicator
      call ranks%send_rows(target_rank, outgoing, incoming)
      order = sort_order(incoming(1::words))
      allocate (key(size(order)), here(sum_words, size(order)))
      do n = 1, size(order)
         key(n) = incoming(words*(order(n) - 1) + 1)
         here(:, n) = transfer(incoming(words*(order(n) - 1) + 2:words*order(n)), here, sum_words)
      end do
   end subroutine hand_over

   !> Add up the fragments of this rank.
   subroutine add_all(grid, map, key, here, rows)
      type(grid_t), intent(in) :: grid
      type(map_t), intent(in) :: map                     !! All cells
      integer(int64), intent(in) :: key(:)               !! Cells of the fragments, ascending
      real(wp), intent(in) :: here(:, :)                 !! (sum, cell)
      real(wp), allocatable, intent(out) :: rows(:, :)   !! (column, fragment) As found, by cells
      integer, allocatable :: cell(:), order(:)
      real(wp), allocatable :: sorted(:, :)
      integer :: first, fragments, last, n

      allocate (cell(size(key)), sorted(sum_words, size(key)))
      do n = 1, size(key)
         cell(n) = map%table%find(key(n))
      end do
      order = sort_order(int(map%fragment(cell), int64))
      fragments = 0
      do n = 1, size(key)
         sorted(:, n) = here(:, order(n))
         if (n == 1) then
            fragments = 1
         else if (map%fragment(cell(order(n))) /= map%fragment(cell(order(n - 1)))) then
            fragments = fragments + 1
         end if
      end do
      allocate (rows(fragment_words, fragments))
      first = 1
      do n = 1, fragments
         last = first
         do while (last < size(key))
            if (map%fragment(cell(order(last + 1))) /= map%fragment(cell(order(first)))) exit
            last = last + 1
         end do
         call add_fragment(sorted(:, first:last), map%image(:, cell(order(first:last))), &
            grid%upper - grid%lower, grid%axisymmetric, rows(:, n))
         rows(1, n) = real(map%fragment(cell(order(first))), wp)
         first = last + 1
      end do
   end subroutine add_all

   !> Send all fragments to all ranks, sorted by mass, the heaviest first. Collective.
   subroutine collect(communicator, rows, number)
      type(communicator_t), intent(in) :: communicator
      real(wp), allocatable, intent(inout) :: rows(:, :) !! (column, fragment) Own in, all out
      integer, allocatable, intent(out) :: number(:)     !! In the table, of each as found
      integer(int64), allocatable :: whole(:)
      integer(int64) :: none(0)
      real(wp), allocatable :: unsorted(:, :)
      integer, allocatable :: by_identity(:), by_mass(:)
      integer :: n

      call communicator%gather(transfer(rows, none), whole)
      unsorted = reshape(transfer(whole, unsorted), [fragment_words, size(whole)/fragment_words])
      ! identities order fragments of equal mass; the bits of positive numbers have the order of the
      ! numbers
      by_identity = sort_order(nint(unsorted(fragment_words, :), int64))
      by_mass = sort_order(-transfer(unsorted(3, by_identity), none))
      deallocate (rows)
      allocate (rows(fragment_words, size(by_mass)), number(size(by_mass)))
      do n = 1, size(by_mass)
         rows(:, n) = unsorted(:, by_identity(by_mass(n)))
         number(nint(rows(1, n))) = n
         rows(1, n) = real(n, wp)
      end do
   end subroutine collect
end module sample_fragments
