! SPDX-License-Identifier: BSD-3-Clause
!> The fields of outputs: those that particles have and those derived from them.
module sample_fields
   use base_constants, only: xx, xy, xz, yy, yz, zz
   use base_error, only: error_t, exit_input, fail
   use base_field_worker, only: field_reader_t
   use base_kinds, only: int64, wp
   use base_text, only: append_text => append, closest, text_t
   use material_field_requests, only: field_requests_t
   use material_own_fields, only: own_fields
   use particle_store, only: store_t
   implicit none
   private

   public :: choose_columns, column_t, field_names, fill_reals, fill_integers, picks_t

   integer, parameter, public :: field_name_length = 32  !! Longest name of a field
   !> Fields of "default", if particles have them.
   character(len=field_name_length), parameter :: usual_names(12) = &
      [character(len=field_name_length) :: "identity", "material", "body", "mass", "volume", &
      "velocity", "pressure", "mises", "temperature", "plastic_strain", "damage", "failed"]

   !> Not part of "state": positions are always written, and a new run sets `load_marks` from its
   !! own loads.
   character(len=field_name_length), parameter :: passing_names(2) = &
      [character(len=field_name_length) :: "position", "load_marks"]

   !> One field of an output.
   type :: column_t
      character(len=field_name_length) :: name = ""
      character(len=field_name_length) :: unit = "1"
      integer :: components = 1                          !! 1 scalar, 3 vector, 6 or 9 tensor
      logical :: is_real = .true.                        !! Real, not integer
      logical :: derived = .false.                       !! Derived from other fields
   end type column_t

   !> Particles of a store to write.
   type :: picks_t
      integer, allocatable :: order(:)                   !! Indices in the order of the file
      integer(int64), allocatable :: fragment(:) !! Number in the table, 0 = none; on request
   end type picks_t

   !> Collects the fields that particles have.
   type, extends(field_reader_t) :: collector_t
      type(column_t), allocatable :: columns(:)          !! Fields found
   contains
      procedure :: reals => collector_reals              !! Record a field of real numbers
      procedure :: integers => collector_integers        !! Record a field of integers
      procedure :: note => collector_note                !! Record any field
   end type collector_t

   !> Copies the values of one field.
   type, extends(field_reader_t) :: fetcher_t
      character(len=field_name_length) :: name = ""      !! Name of the field
      integer, pointer, contiguous :: order(:) => null() !! Indices of the particles
      integer :: before = 0                              !! Rows before the first
      logical :: found = .false.                         !! Do the particles have the field?
      real(wp), allocatable :: numbers(:, :)             !! (component, row)
      integer(int64), allocatable :: whole_numbers(:)    !! (row)
   contains
      procedure :: reals => fetcher_reals                !! Copy a field of real numbers
      procedure :: integers => fetcher_integers          !! Copy a field of integers
   end type fetcher_t

contains

   !> All names allowed in `fields` of an output, in addition to "default" and "state".
   function field_names() result(names)
      character(len=field_name_length), allocatable :: names(:)
      type(field_requests_t) :: own
      integer :: i

      own = own_fields()
      names = [character(len=field_name_length) :: "identity", "material", "body", "mass", &
         "volume", "density", "velocity", "speed", "reference", "stress", "pressure", "mises", &
         "viscous_pressure", "energy", "temperature", "plastic_strain", "equivalent_strain", &
         "inertial_number", "damage", "failed", "deformation_gradient", "plastic_dilation", &
         (own%entries(i)%field, i=1, size(own%entries)), "porosity", "scatter", "overload", &
         "bulking", "solid_fraction", "bond", "extent", "domain", "affine", "spin", "ahead", &
         "burn_time", "fragment"]
   end function field_names

   !> Choose the columns of an output: names, "default" for the usual ones, or "state" for all
   !! fields that another run needs to start. An unknown field, or one that no particle has, is an
   !! error.
   subroutine choose_columns(stores, fields, columns, error)
      type(store_t), intent(in) :: stores(:)
      character(len=*), intent(in) :: fields(:)          !! Names, "default" or "state"
      type(column_t), allocatable, intent(out) :: columns(:) !! In the order of the request
      type(error_t), allocatable, intent(out) :: error   !! A field cannot be written
      type(collector_t) :: collector
      type(column_t) :: column
      integer :: index, usual
      logical :: found

      allocate (columns(0), collector%columns(0))
      do index = 1, size(stores)
         call stores(index)%show(collector)
      end do
      do index = 1, size(fields)
         if (fields(index) == "default") then
            do usual = 1, size(usual_names)
               call find_column(collector%columns, usual_names(usual), column, found)
               if (found) call append(columns, column)
            end do
            cycle
         end if
         if (fields(index) == "state") then
            call append_state(collector%columns, columns)
            cycle
         end if
         call find_column(collector%columns, fields(index), column, found)
         if (.not. found) then
            call fail(error, exit_input, "output field '"//trim(fields(index))//"' "// &
               reason(fields(index))//" [D221]")
            return
         end if
         call append(columns, column)
      end do
   end subroutine choose_columns

   !> Add all fields of the particles, and their material.
   pure subroutine append_state(carried, columns)
      type(column_t), intent(in) :: carried(:)           !! Fields of the particles
      type(column_t), allocatable, intent(inout) :: columns(:)
      type(column_t) :: column
      integer :: index
      logical :: found

      call find_column(carried, "material", column, found)
      call append(columns, column)
      do index = 1, size(carried)
         if (all(passing_names /= carried(index)%name)) call append(columns, carried(index))
      end do
   end subroutine append_state

   !> Why a field cannot be written.
   function reason(name) result(text)
      character(len=*), intent(in) :: name               !! Name of the field
      character(len=:), allocatable :: text
      type(text_t), allocatable :: names(:)
      character(len=:), allocatable :: near
      integer :: index

      allocate (names(0))
      associate (known => field_names())
         if (any(known == name)) then
            text = "is not stored by any material of this scene"
            return
         end if
         text = "is unknown; there are: default state"
         do index = 1, size(known)
            text = text//" "//trim(known(index))
            call append_text(names, trim(known(index)))
         end do
      end associate
      near = closest(trim(name), names)
      if (near /= "") text = text//"; did you mean '"//near//"'?"
   end function reason

   !> Find a field among those of the particles and those derived from them.
   pure subroutine find_column(carried, name, column, found)
      type(column_t), intent(in) :: carried(:)           !! Fields of the particles
      character(len=*), intent(in) :: name               !! Name of the field
      type(column_t), intent(out) :: column              !! Description of the column
      logical, intent(out) :: found                      !! True if it can be written
      integer :: index

      found = .true.
      column%name = name
      column%derived = .true.
      select case (name)
      case ("material", "fragment")
         column%is_real = .false.
      case ("pressure", "mises")
         column%unit = "Pa"
      case ("density")
         column%unit = "kg/m3"
      case ("speed")
         column%unit = "m/s"
      case default
         found = .false.
         do index = 1, size(carried)
            if (carried(index)%name /= name .or. name == "position") cycle
            column = carried(index)
            found = .true.
         end do
      end select
   end subroutine find_column

   !> Add a column unless it is already in the list.
   pure subroutine append(columns, column)
      type(column_t), allocatable, intent(inout) :: columns(:)
      type(column_t), intent(in) :: column
      type(column_t), allocatable :: larger(:)

      if (any(columns%name == column%name)) return
      allocate (larger(size(columns) + 1))
      larger(:size(columns)) = columns
      larger(size(larger)) = column
      call move_alloc(larger, columns)
   end subroutine append

   !> Fill a real column, store after store; 0 where a material lacks the field.
   subroutine fill_reals(stores, picks, column, values)
      type(store_t), intent(in) :: stores(:)
      type(picks_t), target, intent(in) :: picks(:)      !! (store) Selected particles
      type(column_t), intent(in) :: column               !! Name of the field
      real(wp), allocatable, intent(inout) :: values(:, :) !! (component, row)
      type(fetcher_t) :: fetcher
      integer :: before, last, store

      before = 0
      if (.not. column%derived) call move_alloc(values, fetcher%numbers)
      do store = 1, size(stores)
         if (column%derived) then
            call derive(stores(store), picks(store), before, column%name, values)
         else
            fetcher%name = column%name
            fetcher%before = before
            fetcher%order => picks(store)%order
            fetcher%found = .false.
            call stores(store)%show(fetcher)
            last = before + size(picks(store)%order)
            if (.not. fetcher%found) fetcher%numbers(:, before + 1:last) = 0.0_wp
         end if
         before = before + size(picks(store)%order)
      end do
      if (.not. column%derived) call move_alloc(fetcher%numbers, values)
   end subroutine fill_reals

   !> Fill an integer column, store after store; 0 where a material lacks the field.
   subroutine fill_integers(stores, picks, column, values)
      type(store_t), intent(in) :: stores(:)
      type(picks_t), target, intent(in) :: picks(:)      !! (store) Selected particles
      type(column_t), intent(in) :: column               !! Name of the field
      integer(int64), allocatable, intent(inout) :: values(:) !! (row)
      type(fetcher_t) :: fetcher
      integer :: before, last, store

      before = 0
      if (.not. column%derived) call move_alloc(values, fetcher%whole_numbers)
      do store = 1, size(stores)
         last = before + size(picks(store)%order)
         if (column%name == "fragment") then
            values(before + 1:last) = 0
            if (allocated(picks(store)%fragment)) values(before + 1:last) = picks(store)%fragment
         else if (column%derived) then
            values(before + 1:last) = stores(store)%material
         else
            fetcher%name = column%name
            fetcher%before = before
            fetcher%order => picks(store)%order
            fetcher%found = .false.
            call stores(store)%show(fetcher)
            if (.not. fetcher%found) fetcher%whole_numbers(before + 1:last) = 0
         end if
         before = last
      end do
      if (.not. column%derived) call move_alloc(fetcher%whole_numbers, values)
   end subroutine fill_integers

   !> Compute a derived field, block after block of rows in threads.
   subroutine derive(store, picks, before, name, values)
      type(store_t), intent(in) :: store
      type(picks_t), intent(in) :: picks
      integer, intent(in) :: before                      !! Rows before the first
      character(len=*), intent(in) :: name               !! Name of the field
      real(wp), contiguous, intent(inout) :: values(:, :) !! (1, row)
      integer, parameter :: block = 4096                 ! rows
      integer :: first, last

      !$omp parallel do default(none) shared(store, picks, before, name, values) &
      !$omp private(first, last) schedule(static)
      do first = 1, size(picks%order), block
         last = min(first + block - 1, size(picks%order))
         call derive_rows(store, picks%order(first:last), name, &
            values(1, before + first:before + last))
      end do
      !$omp end parallel do
   end subroutine derive

   !> Compute a derived field of some particles.
   pure subroutine derive_rows(store, order, name, value)
      type(store_t), intent(in) :: store
      integer, intent(in) :: order(:)                    !! (row) Indices of the particles
      character(len=*), intent(in) :: name               !! Name of the field
      real(wp), intent(inout) :: value(:)                !! (row)
      integer :: p, row

      associate (stress => store%state%stress)
         select case (name)
         case ("pressure")
            do row = 1, size(order)
               p = order(row)
               value(row) = -(stress(p, xx) + stress(p, yy) + stress(p, zz))/3.0_wp
            end do
         case ("mises")
            do row = 1, size(order)
               p = order(row)
               value(row) = sqrt(0.5_wp*((stress(p, xx) - stress(p, yy))**2 + &
                  (stress(p, yy) - stress(p, zz))**2 + (stress(p, zz) - stress(p, xx))**2) + &
                  3.0_wp*(stress(p, xy)**2 + stress(p, yz)**2 + stress(p, xz)**2))
            end do
         case ("density")
            do row = 1, size(order)
               value(row) = store%state%mass(order(row))/store%state%volume(order(row))
            end do
         case default
            do row = 1, size(order)
               p = order(row)
               value(row) = sqrt(store%velocity(p, 1)**2 + store%velocity(p, 2)**2 + &
                  store%velocity(p, 3)**2)
            end do
         end select
      end associate
   end subroutine derive_rows

   !> Record a field.
   subroutine collector_note(self, name, unit, components, is_real)
      class(collector_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: unit
      integer, intent(in) :: components                  !! Number of components of a particle
      logical, intent(in) :: is_real                     !! Real, not integer
      type(column_t) :: column

      column%name = name
      column%unit = unit
      column%components = components
      column%is_real = is_real
      call append(self%columns, column)
   end subroutine collector_note

   !> Record a field of real numbers.
   subroutine collector_reals(self, name, unit, is_scalar, values)
      class(collector_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: unit
      logical, intent(in) :: is_scalar                   !! One number a particle?
      real(wp), contiguous, intent(in) :: values(:, :) !! (particle, component)

      call self%note(name, unit, size(values, 2), .true.)
   end subroutine collector_reals

   !> Record a field of integers.
   subroutine collector_integers(self, name, unit, values)
      class(collector_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: unit
      integer(int64), contiguous, intent(in) :: values(:) !! (particle)

      call self%note(name, unit, 1, .false.)
   end subroutine collector_integers

   !> Copy a field of real numbers.
   subroutine fetcher_reals(self, name, unit, is_scalar, values)
      class(fetcher_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: unit
      logical, intent(in) :: is_scalar                   !! One number a particle?
      real(wp), contiguous, intent(in) :: values(:, :) !! (particle, component)
      integer :: component, row

      if (name /= self%name) return
      self%found = .true.
      !$omp parallel do default(none) shared(self, values) private(component, row) schedule(static)
      do row = 1, size(self%order)
         do component = 1, size(values, 2)
            self%numbers(component, self%before + row) = values(self%order(row), component)
         end do
      end do
      !$omp end parallel do
   end subroutine fetcher_reals

   !> Copy a field of integers.
   subroutine fetcher_integers(self, name, unit, values)
      class(fetcher_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: unit
      integer(int64), contiguous, intent(in) :: values(:) !! (particle)
      integer :: row

      if (name /= self%name) return
      self%found = .true.
      !$omp parallel do default(none) shared(self, values) private(row) schedule(static)
      do row = 1, size(self%order)
         self%whole_numbers(self%before + row) = values(self%order(row))
      end do
      !$omp end parallel do
   end subroutine fetcher_integers
end module sample_fields
