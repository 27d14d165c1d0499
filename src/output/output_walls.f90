! SPDX-License-Identifier: BSD-3-Clause
!> The walls of a scene for pictures: boundaries of the domain, parts of them, and rigid regions,
!! written once per run. See doc/developer/decisions.md (Files) for the reason.
module output_walls
   use base_error, only: error_t
   use base_file, only: join_path
   use base_kinds, only: wp
   use io_walls, only: never, walls_t, walls_write
   use mesh_boundary, only: boundary_t
   use mesh_boundary_walls, only: face_names
   use mesh_grid, only: grid_t
   use mesh_surface_cut, only: cut_surface
   use mesh_wall, only: wall_t
   use output_streams, only: outputs_t
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: write_walls

   integer, parameter :: entries = 201               !! Times at which moving walls are placed
   integer, parameter :: most_cells = 256            !! Squares of a divided face a direction

contains

   !> Write CASE_walls.hdf. Collective.
   subroutine write_walls(simulation, outputs, folder, time_end, error)
      type(simulation_t), intent(in) :: simulation
      type(outputs_t), intent(in) :: outputs         !! Case and header
      character(len=*), intent(in) :: folder         !! Folder of the file
      real(wp), intent(in) :: time_end               !! End of the run [s]
      type(error_t), allocatable, intent(out) :: error !! The file cannot be written
      type(walls_t) :: walls
      integer :: face

      do face = 1, 6
         if (simulation%space%grid%active(ishft(face + 1, -1))) call add_face(walls, simulation, &
            face)
      end do
      if (allocated(simulation%space%rigid)) call add_rigid(walls, simulation, time_end)
      call walls_write(simulation%machine%communicator, join_path(folder, &
         outputs%case//"_walls.hdf"), &
         walls, outputs%header, error)
   end subroutine write_walls

   !> A boundary of the domain: as a whole, or in the squares of its cells where it has parts.
   subroutine add_face(walls, simulation, face)
      type(walls_t), intent(inout) :: walls          !! Get the face
      type(simulation_t), intent(in) :: simulation
      integer, intent(in) :: face                    !! 1 to 6
      real(wp) :: low(3), high(3), first(3), last(3)
      integer :: axis, across(2), cells(3), i, j, part, wall
      real(wp) :: begin, finish

      associate (grid => simulation%space%grid, boundary => simulation%space%boundary)
         axis = ishft(face + 1, -1)
         across = pack([1, 2, 3], [1, 2, 3] /= axis)
         call flat_box(grid, low, high)
         if (mod(face, 2) == 1) high(axis) = low(axis)
         if (mod(face, 2) == 0) low(axis) = high(axis)
         cells = 1
         if (boundary%is_divided(face)) cells = merge(min(grid%cells, most_cells), 1, grid%active)
         do j = 1, cells(across(2))
            do i = 1, cells(across(1))
               first = low
               last = high
               first(across) = low(across) + real([i, j] - 1, wp)*(high(across) - low(across)) &
                  /real(cells(across), wp)
               last(across) = low(across) + real([i, j], wp)*(high(across) - low(across)) &
                  /real(cells(across), wp)
               part = part_of(boundary, face, 0.5_wp*(first + last))
               begin = never
               finish = never
               if (part > 0) then
                  call name_part(walls, boundary%wall(part), begin, finish, wall)
                  call walls%add(wall, square(first, last, across, grid%active))
               end if
               ! the whole face, before a part is added and after it is removed
               call add_plain(walls, boundary, face, -never, begin, square(first, last, across, &
                  grid%active))
               call add_plain(walls, boundary, face, finish, never, square(first, last, across, &
                  grid%active))
            end do
         end do
      end associate
   end subroutine add_face

   !> Add a part of a face, for a time interval that is not empty.
   pure subroutine add_plain(walls, boundary, face, begin, finish, piece)
      type(walls_t), intent(inout) :: walls          !! Get the face
      type(boundary_t), intent(in) :: boundary
      integer, intent(in) :: face                    !! 1 to 6
      real(wp), intent(in) :: begin                  !! Start of the time interval [s]
      real(wp), intent(in) :: finish                 !! End of the time interval [s]
      real(wp), intent(in) :: piece(:, :, :)         !! (3, corner, 1) [m]
      character(len=:), allocatable :: kind
      integer :: wall

      if (.not. finish > begin .or. finish <= 0.0_wp) return
      kind = "outflow"
      wall = boundary%whole(face)
      if (wall > 0) then
         ! a whole boundary is open while its wall does not act
         associate (motion => boundary%wall(wall)%motion)
            if (.not. motion%begin > 0.0_wp .and. motion%end >= huge(1.0_wp)) &
               kind = trim(boundary%wall(wall)%condition%name)
         end associate
      end if
      call walls%name_wall(face_names(face), kind, face, begin, finish, wall)
      call walls%add(wall, piece)
   end subroutine add_plain

   !> Index of the part of a face, or of the whole face with a time interval, that covers a
   !! position: the last one; 0 = the permanent condition.
   pure integer function part_of(boundary, face, place) result(part)
      type(boundary_t), intent(in) :: boundary
      integer, intent(in) :: face                    !! 1 to 6
      real(wp), intent(in) :: place(3)               !! On the face [m]
      integer :: n

      part = 0
      if (.not. allocated(boundary%wall)) return
      do n = 1, size(boundary%wall)
         associate (wall => boundary%wall(n))
            if (wall%face /= face) cycle
            if (.not. allocated(wall%region)) then
               part = n
            else if (wall%region%contains(place)) then
               part = n
            end if
         end associate
      end do
   end function part_of

   !> The number of a wall in the file, with the time interval in which it exists.
   pure subroutine name_part(walls, source, begin, finish, wall)
      type(walls_t), intent(inout) :: walls          !! Receives it if missing
      type(wall_t), intent(in) :: source             !! A part of a face, or a rigid region
      real(wp), intent(out) :: begin                 !! Start of the time interval [s]
      real(wp), intent(out) :: finish                !! End of the time interval [s]
      integer, intent(out) :: wall                   !! Number
      character(len=:), allocatable :: name

      name = trim(source%name)
      if (source%face > 0) then
         name = face_names(source%face)
         if (source%name /= "") name = name//" "//trim(source%name)
      end if
      begin = source%motion%begin
      if (.not. begin > 0.0_wp) begin = -never
      finish = min(source%motion%end, never)
      call walls%name_wall(name, trim(source%condition%name), source%face, begin, finish, wall)
   end subroutine name_part

   !> Corners of the box; along missing directions the position of the particles [m].
   pure subroutine flat_box(grid, low, high)
      type(grid_t), intent(in) :: grid
      real(wp), intent(out) :: low(3)                !! Lower corner [m]
      real(wp), intent(out) :: high(3)               !! Upper corner [m]

      low = grid%lower
      high = grid%upper
      where (.not. grid%active) low = merge(0.0_wp, 0.5_wp*(grid%lower + grid%upper), &
         grid%axisymmetric)
      where (.not. grid%active) high = low
   end subroutine flat_box

   !> A square in space, a segment in a plane, a point along a line, as (3, corner, 1) [m].
   pure function square(first, last, across, active) result(piece)
      real(wp), intent(in) :: first(3)               !! A corner [m]
      real(wp), intent(in) :: last(3)                !! The opposite one [m]
      integer, intent(in) :: across(2)               !! Directions in which it extends
      logical, intent(in) :: active(3)               !! Active directions
      real(wp), allocatable :: piece(:, :, :)
      integer :: ways(2)

      ways = across
      allocate (piece(3, 2**count(active(across)), 1))
      piece(:, 1, 1) = first
      if (size(piece, 2) == 2) piece(:, 2, 1) = last
      if (size(piece, 2) < 4) return
      piece(:, 2, 1) = first
      piece(ways(1), 2, 1) = last(ways(1))
      piece(:, 3, 1) = last
      piece(:, 4, 1) = first
      piece(ways(2), 4, 1) = last(ways(2))
   end function square

   !> Surfaces of the rigid regions at the start, and their paths.
   subroutine add_rigid(walls, simulation, time_end)
      type(walls_t), intent(inout) :: walls          !! Get the surfaces
      type(simulation_t), intent(in) :: simulation
      real(wp), intent(in) :: time_end               !! End of the run [s]
      real(wp), parameter :: part = 0.5_wp           ! step of the lattice over a cell
      real(wp), allocatable :: piece(:, :, :), way(:, :, :)
      real(wp) :: low(3), high(3), begin, finish
      integer :: faces, n, number, wall

      faces = size(walls%name)
      walls%time = [(time_end*real(n, wp)/real(entries - 1, wp), n=0, entries - 1)]
      allocate (way(3, size(simulation%space%rigid%wall), entries))
      do number = 1, size(way, 2)
         associate (rigid => simulation%space%rigid%wall(number))
            do n = 1, entries
               way(:, number, n) = rigid%displacement(walls%time(n))
            end do
            call name_part(walls, rigid, begin, finish, wall)
            ! an inflow has no surface
            if (rigid%stays) cycle
            ! walls inside the box at some time, at their initial position
            call flat_box(simulation%space%grid, low, high)
            low = low - maxval(way(:, number, :), dim=2)
            high = high - minval(way(:, number, :), dim=2)
            call cut_surface(rigid%region, low, high, simulation%space%grid%active, &
               part*simulation%space%grid%spacing, piece)
            call walls%add(wall, piece)
         end associate
      end do
      if (.not. any(abs(way) > 0.0_wp)) then
         deallocate (walls%time)
         return
      end if
      allocate (walls%shift(3, size(walls%name), entries), source=0.0_wp)
      walls%shift(:, faces + 1:, :) = way
   end subroutine add_rigid
end module output_walls
