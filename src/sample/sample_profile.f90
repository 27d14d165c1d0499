! SPDX-License-Identifier: BSD-3-Clause
!> Profiles hold counts, masses and means of particles in equal bins along an axis, and the greatest
!! height of the material in each. All sums are exact, so they do not depend on the order of the
!! particles.
module sample_profile
   use base_communicator, only: communicator_t
   use base_constants, only: pi
   use base_exact_sum, only: exact_sum_t
   use base_exact_totals, only: totals_over_ranks
   use base_kinds, only: int64, wp
   use mesh_grid, only: grid_t
   use particle_store, only: store_t
   use sample_fields, only: picks_t
   use sample_means, only: added, along_axis, by_volume, fill_mean, highest, mean_t
   use sample_pick, only: pick_rule_t
   implicit none
   private

   public :: field_columns, half_size, profile_columns, profile_rows, profile_t

   integer, parameter :: column_length = 40              !! Longest heading of a column
   integer, parameter :: before = 5                      !! Columns before the means, and time, step
   !> Names of components by their number: of vectors, of symmetric tensors, of others.
   character(len=2), parameter :: parts_3(3) = ["x ", "y ", "z "]
   character(len=2), parameter :: parts_6(6) = ["xx", "yy", "zz", "xy", "yz", "xz"]
   character(len=2), parameter :: parts_9(9) = ["xx", "yx", "zx", "xy", "yy", "zy", "xz", "yz", &
      "zz"]

   !> Definition of a profile.
   type :: profile_t
      integer :: axis = 1                                !! Direction of the bins
      integer :: bins = 100                              !! Number of bins
      real(wp) :: lower = 0.0_wp                         !! Start of the first bin [m]
      real(wp) :: upper = 1.0_wp                         !! End of the last bin [m]
      type(mean_t), allocatable :: means(:)              !! Fields
      type(pick_rule_t) :: rule
   end type profile_t

contains

   !> Headings of the columns.
   function profile_columns(profile) result(columns)
      type(profile_t), intent(in) :: profile             !! Definition of the profile
      character(len=column_length), allocatable :: columns(:)

      columns = [character(len=column_length) :: "time [s]", "step", "bin", "position [m]", &
         "particles", "mass [kg]", "volume [m3]"]
      columns = [columns, field_columns(profile%means)]
   end function profile_columns

   !> Headings of the components of fields.
   function field_columns(means) result(columns)
      type(mean_t), intent(in) :: means(:)               !! In the order of the columns
      character(len=column_length), allocatable :: columns(:)
      character(len=column_length) :: heading
      integer :: n, part

      allocate (columns(0))
      do n = 1, size(means)
         associate (column => means(n)%column)
            do part = 1, column%components
               heading = trim(column%name)//part_name(column%components, part)//" ["// &
                  trim(column%unit)//"]"
               columns = [columns, heading]
            end do
         end associate
      end do
   end function field_columns

   !> Ending of the name of a component, empty for a scalar.
   pure function part_name(components, part) result(name)
      integer, intent(in) :: components                  !! How many there are
      integer, intent(in) :: part                        !! Index
      character(len=:), allocatable :: name

      select case (components)
      case (3)
         name = "_"//trim(parts_3(part))
      case (6)
         name = "_"//trim(parts_6(part))
      case (9)
         name = "_"//trim(parts_9(part))
      case default
         name = ""
      end select
   end function part_name

   !> The table of one time, all columns but time and step: (column, bin). Collective.
   subroutine profile_rows(communicator, grid, stores, profile, rows)
      type(communicator_t), intent(inout) :: communicator
      type(grid_t), intent(in) :: grid                   !! The grid and its directions
      type(store_t), intent(in) :: stores(:)             !! Particles
      type(profile_t), intent(in) :: profile             !! Bins, fields and selection
      real(wp), allocatable, intent(out) :: rows(:, :)   !! (column, row)
      type(picks_t), allocatable :: picks(:)
      integer(int64), allocatable :: counts(:)
      integer, allocatable :: bin(:)
      real(wp), allocatable :: mass(:), volume(:), values(:, :), one(:)
      integer :: at, n, row

      allocate (picks(size(stores)))
      do n = 1, size(stores)
         call profile%rule%pick(stores(n), picks(n)%order)
      end do
      call sort_into_bins(stores, picks, profile, bin, mass, volume)
      at = before
      do n = 1, size(profile%means)
         at = at + profile%means(n)%column%components
      end do
      allocate (rows(at, profile%bins), source=0.0_wp)
      allocate (counts(profile%bins), source=0_int64)
      do row = 1, size(bin)
         counts(bin(row)) = counts(bin(row)) + 1
      end do
      call communicator%total(counts)
      do row = 1, profile%bins
         rows(1, row) = real(row, wp)
         rows(2, row) = profile%lower + (real(row, wp) - 0.5_wp) &
            *(profile%upper - profile%lower)/real(profile%bins, wp)
      end do
      rows(3, :) = real(counts, wp)
      allocate (one(size(bin)), source=1.0_wp)
      call add_up(communicator, bin, one, mass, rows(4, :))
      call add_up(communicator, bin, one, volume, rows(5, :))
      at = before
      do n = 1, size(profile%means)
         if (profile%means(n)%weight == highest) then
            at = at + 1
            call find_heights(communicator, grid, stores, picks, bin, rows(at, :))
            cycle
         end if
         call fill_values(stores, picks, profile%means(n), profile%axis, values)
         select case (profile%means(n)%weight)
         case (added)
            call add_means(communicator, bin, one, values, at, rows)
         case (by_volume)
            call add_means(communicator, bin, volume, values, at, rows, divisor=5)
         case default
            call add_means(communicator, bin, mass, values, at, rows, divisor=4)
         end select
         at = at + size(values, 1)
      end do
   end subroutine profile_rows

   !> Sums or means of the components of a field in each bin. Collective.
   subroutine add_means(communicator, bin, weight, values, at, rows, divisor)
      type(communicator_t), intent(in) :: communicator
      integer, intent(in) :: bin(:)                      !! (row)
      real(wp), intent(in) :: weight(:)                  !! (row) Factor
      real(wp), intent(in) :: values(:, :)               !! (component, row)
      integer, intent(in) :: at                          !! Columns before those of the field
      real(wp), intent(inout) :: rows(:, :)              !! (column, bin) The table
      integer, intent(in), optional :: divisor           !! Column that divides the sums
      integer :: part

      do part = 1, size(values, 1)
         call add_up(communicator, bin, weight, values(part, :), rows(at + part, :))
         if (.not. present(divisor)) cycle
         where (rows(divisor, :) > 0.0_wp) rows(at + part, :) = rows(at + part, :)/rows(divisor, :)
      end do
   end subroutine add_means

   !> Values of all particles, of which the rows are means or sums.
   subroutine fill_values(stores, picks, mean, axis, values)
      type(store_t), intent(in) :: stores(:)             !! Particles
      type(picks_t), intent(in) :: picks(:)              !! (store) Selected particles
      type(mean_t), intent(in) :: mean
      integer, intent(in) :: axis                        !! Direction of the bins
      real(wp), allocatable, intent(out) :: values(:, :) !! (component, row)
      integer :: filled, rows, store

      if (mean%weight /= along_axis) then
         call fill_mean(stores, picks, mean%column, values)
         return
      end if
      rows = 0
      do store = 1, size(picks)
         rows = rows + size(picks(store)%order)
      end do
      allocate (values(1, rows))
      filled = 0
      do store = 1, size(picks)
         rows = size(picks(store)%order)
         values(1, filled + 1:filled + rows) = stores(store)%velocity(picks(store)%order, axis)
         filled = filled + rows
      end do
   end subroutine fill_values

   !> Greatest height of material in each bin, on all ranks; that of the lower end of the grid in an
   !! empty bin. Collective.
   subroutine find_heights(communicator, grid, stores, picks, bin, heights)
      type(communicator_t), intent(inout) :: communicator
      type(grid_t), intent(in) :: grid                   !! The grid and its directions
      type(store_t), intent(in) :: stores(:)
      type(picks_t), intent(in) :: picks(:)              !! (store) Selected particles
      integer, intent(in) :: bin(:)                      !! (row)
      real(wp), intent(out) :: heights(:)                !! (bin) [m]
      real(wp) :: greatest(size(heights))
      integer :: row, seen, store

      greatest = grid%lower(3)
      seen = 0
      do store = 1, size(stores)
         do row = 1, size(picks(store)%order)
            associate (p => picks(store)%order(row), top => greatest(bin(seen + row)))
               top = max(top, stores(store)%position(p, 3) + half_size(grid, stores(store), p, 3))
            end associate
         end do
         seen = seen + size(picks(store)%order)
      end do
      call communicator%maxima(greatest)
      heights = greatest
   end subroutine find_heights

   !> Half the size of a particle along an axis [m]: half the extent of its own domain if it has
   !! one, otherwise half the edge of a cube (in 2-D a square, in 1-D an interval) of its current
   !! volume.
   pure real(wp) function half_size(grid, store, p, axis) result(half)
      type(grid_t), intent(in) :: grid                   !! The grid and its directions
      type(store_t), intent(in) :: store
      integer, intent(in) :: p                           !! Index
      integer, intent(in) :: axis                        !! 1 to 3
      real(wp) :: width

      if (allocated(store%extent)) then
         half = store%extent(p, axis)
      else if (allocated(store%domain)) then
         half = abs(store%domain(p, axis)) + abs(store%domain(p, 3 + axis)) &
            + abs(store%domain(p, 6 + axis))
      else
         width = grid%depth
         if (grid%axisymmetric) width = width*max(store%position(p, 1), tiny(width))
         half = 0.5_wp*(store%state%volume(p)/width)**(1.0_wp/real(count(grid%active), wp))
      end if
   end function half_size

   !> Bin, mass and volume of each particle, store after store.
   pure subroutine sort_into_bins(stores, picks, profile, bin, mass, volume)
      type(store_t), intent(in) :: stores(:)
      type(picks_t), intent(in) :: picks(:)              !! (store) Selected particles
      type(profile_t), intent(in) :: profile
      integer, allocatable, intent(out) :: bin(:)        !! (row) From 1
      real(wp), allocatable, intent(out) :: mass(:)      !! (row) [kg]
      real(wp), allocatable, intent(out) :: volume(:)    !! (row) [m3]
      integer :: filled, row, store
      real(wp) :: place

      filled = 0
      do store = 1, size(stores)
         filled = filled + size(picks(store)%order)
      end do
      allocate (bin(filled), mass(filled), volume(filled))
      filled = 0
      do store = 1, size(stores)
         do row = 1, size(picks(store)%order)
            filled = filled + 1
            associate (p => picks(store)%order(row))
               place = (stores(store)%position(p, profile%axis) - profile%lower) &
                  /(profile%upper - profile%lower)*real(profile%bins, wp)
               bin(filled) = min(max(floor(min(max(place, 0.0_wp), real(profile%bins, wp))), 0), &
                  profile%bins - 1) + 1
               mass(filled) = stores(store)%state%mass(p)
               volume(filled) = stores(store)%state%volume(p)
            end associate
         end do
      end do
   end subroutine sort_into_bins

   !> Sums over the particles of each bin, on all ranks, rounded once. Collective.
   subroutine add_up(communicator, bin, weight, values, sums)
      type(communicator_t), intent(in) :: communicator
      integer, intent(in) :: bin(:)                      !! (row)
      real(wp), intent(in) :: weight(:)                  !! (row) Factor
      real(wp), intent(in) :: values(:)                  !! (row)
      real(wp), intent(out) :: sums(:)                   !! (bin)
      type(exact_sum_t), allocatable :: total(:)
      integer :: n

      allocate (total(size(sums)))
      do n = 1, size(bin)
         call total(bin(n))%add(weight(n)*values(n))
      end do
      call totals_over_ranks(communicator, total, sums)
   end subroutine add_up
end module sample_profile
