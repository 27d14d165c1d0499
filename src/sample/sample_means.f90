! SPDX-License-Identifier: BSD-3-Clause
!> Means of particle fields in cells and bins: intensive fields are weighted by mass or by volume;
!! masses and volumes are summed.
module sample_means
   use base_error, only: error_t, exit_input, fail
   use base_kinds, only: int64, wp
   use particle_store, only: store_t
   use sample_fields, only: choose_columns, column_t, field_name_length, fill_integers, &
      fill_reals, picks_t
   implicit none
   private

   public :: choose_means, fill_mean, mean_t, profile_names

   integer, parameter, public :: added = 0               !! Sum instead of a mean
   integer, parameter, public :: by_mass = 1             !! Weight of a particle: its mass
   integer, parameter, public :: by_volume = 2           !! Weight of a particle: its volume
   integer, parameter, public :: highest = 3             !! Greatest height instead of a mean
   integer, parameter, public :: along_axis = 4 !! Weighted by mass, component along the axis
   !> Where fields are averaged.
   integer, parameter, public :: in_cells = 1, in_bins = 2, at_gauges = 3
   !> Fields of profiles only: upper end of the material, mean velocity along the axis.
   character(len=field_name_length), parameter :: profile_names(2) = &
      [character(len=field_name_length) :: "surface_height", "depth_mean_velocity"]
   !> Field of grids only: volume of material over that of the cell.
   character(len=*), parameter, public :: volume_fraction = "volume_fraction"
   !> Fields of "default", if particles have them.
   character(len=field_name_length), parameter :: usual(5) = [character(len=field_name_length) :: &
      "density", "velocity", "stress", "temperature", "failed"]

   !> One field that is averaged.
   type :: mean_t
      type(column_t) :: column
      integer :: weight = by_mass                        !! One of the constants above
   end type mean_t

contains

   !> Choose the fields to average. An unknown field, or one without a mean, is an error.
   subroutine choose_means(stores, fields, where_used, means, error)
      type(store_t), intent(in) :: stores(:)
      character(len=*), intent(in) :: fields(:)          !! Names, or "default"
      integer, intent(in) :: where_used                  !! `in_cells`, `in_bins` or `at_gauges`
      type(mean_t), allocatable, intent(out) :: means(:) !! In the order of the request
      type(error_t), allocatable, intent(out) :: error   !! A field has no mean
      integer :: n, m

      allocate (means(0))
      do n = 1, size(fields)
         if (fields(n) == "default") then
            do m = 1, size(usual)
               call add_mean(stores, usual(m), .true., means, error)
            end do
            if (where_used == in_cells) call add_fraction(means)
         else if (fields(n) == volume_fraction .and. where_used == in_cells) then
            call add_fraction(means)
         else if (any(profile_names == fields(n)) .and. where_used == in_bins) then
            call add_of_profile(fields(n), means)
         else
            call add_mean(stores, fields(n), .false., means, error)
         end if
         if (.not. allocated(error)) cycle
         if (where_used == in_bins) call add_names(error%message)
         return
      end do
   end subroutine choose_means

   !> Add the names that only a profile has to a message that lists the others.
   pure subroutine add_names(message)
      character(len=:), allocatable, intent(inout) :: message !! Message
      integer :: n

      if (index(message, "is unknown") == 0) return
      message = message//"; a profile also has"
      do n = 1, size(profile_names)
         message = message//" "//trim(profile_names(n))
      end do
   end subroutine add_names

   !> Add a field unless it is already in the list.
   subroutine add_mean(stores, name, if_carried, means, error)
      type(store_t), intent(in) :: stores(:)
      character(len=*), intent(in) :: name
      logical, intent(in) :: if_carried                  !! Skip fields that no particle has
      type(mean_t), allocatable, intent(inout) :: means(:)
      type(error_t), allocatable, intent(out) :: error   !! If the field has no mean
      type(column_t), allocatable :: columns(:)
      type(mean_t) :: mean

      call choose_columns(stores, [name], columns, error)
      if (allocated(error) .and. if_carried) then
         deallocate (error)
         return
      end if
      if (allocated(error)) return
      mean%column = columns(1)
      select case (mean%column%name)
      case ("mass", "volume")
         mean%weight = added
      case ("density")
         mean%weight = by_volume
      case default
         mean%weight = merge(by_volume, by_mass, mean%column%unit == "Pa")
      end select
      if (.not. mean%column%is_real .and. mean%column%name /= "failed") then
         call fail(error, exit_input, "output field '"//trim(name)// &
            "' is an identifier, which has no mean; remove it [D436]")
         return
      end if
      call append(means, mean)
   end subroutine add_mean

   !> Add the volume fraction.
   subroutine add_fraction(means)
      type(mean_t), allocatable, intent(inout) :: means(:)
      type(mean_t) :: mean

      mean%column%name = volume_fraction
      mean%weight = added
      call append(means, mean)
   end subroutine add_fraction

   !> Add a field of profiles only.
   subroutine add_of_profile(name, means)
      character(len=*), intent(in) :: name               !! One of `profile_names`
      type(mean_t), allocatable, intent(inout) :: means(:)
      type(mean_t) :: mean

      mean%column%name = name
      mean%column%unit = merge("m  ", "m/s", name == profile_names(1))
      mean%weight = merge(highest, along_axis, name == profile_names(1))
      call append(means, mean)
   end subroutine add_of_profile

   !> Add to the list unless it is already there.
   subroutine append(means, mean)
      type(mean_t), allocatable, intent(inout) :: means(:)
      type(mean_t), intent(in) :: mean
      type(mean_t), allocatable :: longer(:)
      integer :: n

      do n = 1, size(means)
         if (means(n)%column%name == mean%column%name) return
      end do
      allocate (longer(size(means) + 1))
      longer(:size(means)) = means
      longer(size(longer)) = mean
      call move_alloc(longer, means)
   end subroutine append

   !> Fill the values of a field for all particles of an output, store after store.
   subroutine fill_mean(stores, picks, column, values)
      type(store_t), intent(in) :: stores(:)
      type(picks_t), intent(in) :: picks(:)              !! (store) Selected particles
      type(column_t), intent(in) :: column
      real(wp), allocatable, intent(out) :: values(:, :) !! (component, row)
      integer(int64), allocatable :: integers(:)
      integer :: rows, store

      rows = 0
      do store = 1, size(picks)
         rows = rows + size(picks(store)%order)
      end do
      allocate (values(column%components, rows))
      if (column%is_real) then
         call fill_reals(stores, picks, column, values)
      else
         allocate (integers(rows))
         call fill_integers(stores, picks, column, integers)
         values(1, :) = real(integers, wp)
      end if
   end subroutine fill_mean
end module sample_means
