! SPDX-License-Identifier: BSD-3-Clause
!> Reads the state of particles from the file with their positions.
module scene_points_fields
   use base_agreement, only: agree
   use base_error, only: error_t, exit_file, fail
   use base_field_worker, only: field_worker_t
   use base_kinds, only: int64, wp
   use base_text, only: number
   use io_hdf5_read, only: data_info_t, hdf5_source_t
   use io_points, only: data_group, factor_of
   use particle_body, only: body_t
   use particle_store, only: store_t, unknown_strain
   use scene_points, only: comes_from_file, point_region_t
   use scene_points_placing, only: components_of, placing_t
   use scene_regions, only: named_shape_t
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: read_point_fields

   integer, parameter :: piece = 1048576             !! Rows that are read at once

   !> Copies values of rows to the corresponding particles of a store.
   type, extends(field_worker_t) :: putter_t
      character(len=:), allocatable :: name
      integer :: count = 0                           !! Particles of the body
      integer, allocatable :: particle(:)            !! Selected fields
      integer(int64), allocatable :: row(:)          !! Rows of the particles in the file, from 1
      integer(int64) :: before = 0                   !! Rows before those below
      real(wp), allocatable :: reals(:, :)           !! (component, row)
      logical :: adds = .false.                      !! True to add to existing values
   contains
      procedure :: scalar => put_scalar              !! A field of numbers
      procedure :: vector => put_vector              !! A field of vectors or tensors
      procedure :: whole => put_integer                !! A field of integers
   end type putter_t

contains

   !> Set the fields of the particles of bodies from files to those in the files. Collective.
   subroutine read_point_fields(simulation, bodies, shapes, error)
      type(simulation_t), intent(inout) :: simulation !! The run with particles
      type(body_t), intent(in) :: bodies(:)
      type(named_shape_t), intent(in) :: shapes(:)
      type(error_t), allocatable, intent(out) :: error !! A file has become unreadable
      type(putter_t) :: putter
      integer :: n, tile, p, found
      integer(int64) :: row

      do n = 1, size(bodies)
         if (bodies(n)%on_lattice()) cycle
         if (.not. allocated(shapes(bodies(n)%region)%points)) cycle
         associate (store => simulation%stores(bodies(n)%store), &
            points => shapes(bodies(n)%region)%points)
            ! its particles and their rows
            if (allocated(putter%particle)) deallocate (putter%particle, putter%row)
            allocate (putter%particle(store%particles()), putter%row(store%particles()))
            found = 0
            do tile = 1, size(store%count)
               do p = store%first(tile), store%first(tile) + store%count(tile) - 1
                  row = store%identity(p) - bodies(n)%first_identity + 1
                  if (row < 1 .or. row > size(points%list%position, 2)) cycle
                  found = found + 1
                  putter%particle(found) = p
                  putter%row(found) = row
               end do
            end do
            putter%count = found
            if (allocated(points%list%velocity)) then
               putter%name = "velocity"
               putter%adds = .true.
               putter%before = 0
               putter%reals = points%list%velocity
               call store%walk(putter)
            end if
            if (points%snapshot) call take_snapshot(simulation, points, bodies(n), putter, error)
         end associate
         if (allocated(error)) return
      end do
   end subroutine read_point_fields

   !> Read the fields of a snapshot that the particles carry, one chunk at a time.
   subroutine take_snapshot(simulation, points, body, putter, error)
      type(simulation_t), intent(inout) :: simulation !! The run with particles
      type(point_region_t), intent(in) :: points     !! Position of the file, and its fields
      type(body_t), intent(in) :: body
      type(putter_t), intent(inout) :: putter        !! Maps particles to rows
      type(error_t), allocatable, intent(out) :: error !! If the file cannot be read any more
      type(hdf5_source_t) :: source
      integer :: n, tile

      call source%open(points%path, error)
      associate (store => simulation%stores(body%store))
         if (allocated(store%ahead)) then
            do n = 1, putter%count
               store%ahead(putter%particle(n), :) = unknown_strain
            end do
         end if
         do n = 1, size(points%list%fields)
            if (allocated(error)) exit
            putter%name = points%list%fields(n)%text
            if (.not. comes_from_file(putter%name, body%keeps_stress)) cycle
            if (.not. points%placing%keeps(putter%name)) cycle
            putter%adds = putter%name == "velocity"
            call take_field(source, points%placing, store, putter, error)
         end do
         call source%close()
         call agree(simulation%machine%communicator, error)
         if (allocated(error) .or. body%keeps_stress) return
         do tile = 1, size(store%count)
            call simulation%materials(body%store)%find_rest_stress(store%state, store%first(tile), &
               store%first(tile) + store%count(tile) - 1)
         end do
      end associate
   end subroutine take_snapshot

   !> Read one field.
   subroutine take_field(source, placing, store, putter, error)
      type(hdf5_source_t), intent(in) :: source      !! The open file
      type(placing_t), intent(in) :: placing         !! Where the points have been moved to
      type(store_t), intent(inout) :: store
      type(putter_t), intent(inout) :: putter        !! Selects the field
      type(error_t), allocatable, intent(out) :: error !! If the file cannot be read
      type(data_info_t) :: info
      character(len=:), allocatable :: name
      real(wp), allocatable :: numbers(:)
      real(wp) :: factor
      integer :: rows

      name = data_group//"/"//putter%name
      call source%info(name, info, error)
      if (allocated(error)) return
      if (components_of(putter%name) > 1 .and. info%components /= components_of(putter%name)) then
         call fail(error, exit_file, "'"//source%path//"': the field "//putter%name//" has "// &
            number(info%components)//" components instead of "// &
            number(components_of(putter%name))//" [D356]")
         return
      end if
      factor = factor_of(source, name)
      putter%before = 0
      do while (putter%before < info%rows)
         rows = int(min(info%rows - putter%before, int(piece, int64)))
         if (allocated(putter%reals)) deallocate (putter%reals)
         allocate (putter%reals(info%components, rows))
         if (info%dimensions == 1) then
            if (allocated(numbers)) deallocate (numbers)
            allocate (numbers(rows))
            call source%read(name, putter%before, numbers, error)
            putter%reals(1, :) = numbers
         else
            call source%read(name, putter%before, putter%reals, error)
         end if
         if (allocated(error)) return
         putter%reals = factor*putter%reals
         call placing%turn(putter%name, putter%reals)
         call store%walk(putter)
         putter%before = putter%before + rows
      end do
   end subroutine take_field

   !> Put numbers.
   subroutine put_scalar(self, name, unit, values)
      class(putter_t), intent(inout) :: self
      character(len=*), intent(in) :: name           !! Name in files
      character(len=*), intent(in) :: unit           !! SI unit
      real(wp), allocatable, intent(inout) :: values(:) !! (particle)
      integer :: n

      if (name /= self%name .or. len(unit) == 0) return
      do n = 1, self%count
         if (self%row(n) <= self%before) cycle
         if (self%row(n) > self%before + size(self%reals, 2)) cycle
         values(self%particle(n)) = self%reals(1, self%row(n) - self%before)
      end do
   end subroutine put_scalar

   !> Put vectors or tensors.
   subroutine put_vector(self, name, unit, values)
      class(putter_t), intent(inout) :: self
      character(len=*), intent(in) :: name           !! Name in files
      character(len=*), intent(in) :: unit           !! SI unit
      real(wp), allocatable, intent(inout) :: values(:, :) !! (particle, component)
      integer :: n, k

      if (name /= self%name .or. len(unit) == 0) return
      do n = 1, self%count
         if (self%row(n) <= self%before) cycle
         if (self%row(n) > self%before + size(self%reals, 2)) cycle
         do k = 1, min(size(values, 2), size(self%reals, 1))
            associate (value => values(self%particle(n), k), &
               new => self%reals(k, self%row(n) - self%before))
               value = merge(value, 0.0_wp, self%adds) + new
            end associate
         end do
      end do
   end subroutine put_vector

   !> Put integers.
   subroutine put_integer(self, name, unit, values)
      class(putter_t), intent(inout) :: self
      character(len=*), intent(in) :: name           !! Name in files
      character(len=*), intent(in) :: unit           !! SI unit
      integer(int64), allocatable, intent(inout) :: values(:) !! (particle)
      integer :: n

      if (name /= self%name .or. len(unit) == 0) return
      do n = 1, self%count
         if (self%row(n) <= self%before) cycle
         if (self%row(n) > self%before + size(self%reals, 2)) cycle
         values(self%particle(n)) = nint(self%reals(1, self%row(n) - self%before), int64)
      end do
   end subroutine put_integer
end module scene_points_fields
