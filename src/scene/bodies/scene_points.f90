! SPDX-License-Identifier: BSD-3-Clause
!> Regions that are lists of points, and the bodies that are made of them.
module scene_points
   use base_agreement, only: agree
   use base_communicator, only: communicator_t
   use base_error, only: error_t
   use base_file, only: read_file
   use base_hash, only: mix
   use base_kinds, only: int64, wp
   use base_sort, only: sort_order
   use base_text, only: append, brief, join, lower, number, text_t
   use deck_reader, only: deck_t, group_t
   use deck_units, only: unit_of, unit_t
   use io_hdf5_read, only: hdf5_source_t
   use io_points, only: point_list_t, read_point_text, read_snapshot
   use material_field_requests, only: field_requests_t
   use material_type, only: material_t
   use mesh_boundary, only: boundary_t
   use mesh_grid, only: grid_t
   use particle_body, only: body_t
   use particle_points, only: cloud, points_t, set_points
   use particle_shape, only: shape_holder_t
   use particle_store, only: traits_t
   use sample_fields, only: field_names
   use scene_file_paths, only: path_in_deck
   use scene_points_placing, only: placing_t, read_placing
   implicit none
   private

   public :: comes_from_file, compare_fields, pack_points, point_region_t, read_point_region

   !> Points of a region.
   type :: point_region_t
      type(point_list_t) :: list                     !! Lengths, velocities and volumes in SI
      character(len=:), allocatable :: path
      character(len=:), allocatable :: body          !! Body whose rows are used, or empty
      logical :: snapshot = .false.                  !! Is the file a snapshot of another run?
      type(placing_t) :: placing                     !! Where the list has been moved to
   end type point_region_t

contains

   !> Read the points of a region: the first rank reads a text and broadcasts it; each
   !! reads a snapshot. Collective.
   subroutine read_point_region(communicator, deck, grid, group, points, holder)
      type(communicator_t), intent(in) :: communicator !! The first rank reads
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(grid_t), intent(in) :: grid               !! Gives the active directions
      type(group_t), intent(in) :: group
      type(point_region_t), allocatable, intent(out) :: points
      type(shape_holder_t), intent(inout) :: holder  !! Receives the particles
      type(error_t), allocatable :: error
      character(len=:), allocatable :: text
      type(hdf5_source_t) :: source

      allocate (points)
      points%path = path_in_deck(group, "file")
      call group%get("from_body", points%body)
      points%snapshot = is_snapshot(points%path)
      if (points%snapshot) then
         call source%open(points%path, error)
         if (.not. allocated(error)) call read_snapshot(source, points%list, error)
         call source%close()
         call agree(communicator, error)
      else
         if (communicator%rank == 0) call read_file(points%path, text, error)
         call agree(communicator, error)
         if (.not. allocated(error)) then
            call communicator%broadcast(text)
            call read_point_text(text, points%path, points%list, error)
         end if
      end if
      if (allocated(error)) then
         call deck%add_error(group, error%message, "file")
         return
      end if
      if (.not. points%snapshot) call to_si(deck, points%list)
      call read_placing(deck, grid, group, points%placing)
      call find_volumes(deck, group, points%list)
      call points%placing%move(grid, points%list)
      call holder%set(cloud(points%list%position))
   end subroutine read_point_region

   !> True if a file is a snapshot by its name.
   pure logical function is_snapshot(path) result(yes)
      character(len=*), intent(in) :: path
      character(len=:), allocatable :: ending

      ending = lower(path(index(path, ".", back=.true.) + 1:))
      yes = ending == "hdf" .or. ending == "h5" .or. ending == "hdf5"
   end function is_snapshot

   !> Convert the numbers of a text from the units of the deck to SI.
   subroutine to_si(deck, list)
      type(deck_t), intent(in) :: deck               !! Deck with the system of units
      type(point_list_t), intent(inout) :: list      !! Changed

      list%position = factor("m")*list%position
      if (allocated(list%volume)) list%volume = factor("m3")*list%volume
      if (allocated(list%velocity)) list%velocity = factor("m/s")*list%velocity

   contains

      !> Conversion from the unit of the deck to SI.
      real(wp) function factor(text) result(value)
         character(len=*), intent(in) :: text        !! Unit of SI
         type(unit_t) :: unit
         logical :: known

         call unit_of(text, unit, known)
         value = 10.0_wp**nint(unit%exponent(deck%system))
      end function factor
   end subroutine to_si

   !> Volumes of points whose file has none.
   subroutine find_volumes(deck, group, list)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(group_t), intent(in) :: group
      type(point_list_t), intent(inout) :: list      !! Gets volumes
      real(wp) :: volume

      if (allocated(list%volume)) then
         if (group%given("point_volume")) call deck%add_error(group, "the file has volumes; "// &
            "remove point_volume [D356]", "point_volume")
      else if (group%given("point_volume")) then
         call group%get("point_volume", volume)
         allocate (list%volume(size(list%position, 2)))
         list%volume = volume
      else
         call deck%add_error(group, "the file has no volumes; add a column or field volume, "// &
            "or give point_volume [D356]", "file")
      end if
   end subroutine find_volumes

   !> Make a body of the points of a region that belong to it.
   subroutine pack_points(deck, grid, boundary, group, points, body)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(grid_t), intent(in) :: grid
      type(boundary_t), intent(in) :: boundary       !! Faces of the domain
      type(group_t), intent(in) :: group
      type(point_region_t), intent(in) :: points     !! All of them
      type(body_t), intent(inout) :: body            !! Gets its particles
      type(points_t) :: given
      integer(int64), allocatable :: row(:)
      integer, allocatable :: place(:)
      logical, allocatable :: meant(:)
      real(wp), allocatable :: position(:, :), volume(:)
      integer :: n, large
      real(wp), parameter :: pi2 = 6.283185307179586_wp
      real(wp), parameter :: little = 1.0e-6_wp
      real(wp) :: cell

      allocate (meant(size(points%list%position, 2)))
      meant = .true.
      call choose_material(deck, group, points%list, meant)
      call choose_body(deck, group, points, meant)
      if (.not. deck%sound("body", group%place)) return
      place = pack([(n, n=1, size(meant))], meant)
      call check_positions(deck, grid, boundary, group, points, place)
      if (.not. deck%sound("body", group%place)) return
      ! points larger than a cell may share no node with their neighbours
      large = 0
      do n = 1, size(place)
         cell = grid%spacing**grid%dimensions*grid%depth
         if (grid%axisymmetric) cell = grid%spacing**2*pi2*points%list%position(1, place(n))
         if (points%list%volume(place(n)) > (1.0_wp + little)*cell) large = large + 1
      end do
      if (large > 0) call deck%warn(group, number(large)//" of "//number(size(place))// &
         " points are larger than a cell: the material has gaps; use larger cells or more "// &
         "points [D412]", "region")
      allocate (row(size(place)), position(3, size(place)), volume(size(place)))
      do n = 1, size(place)
         row(n) = place(n)
         position(:, n) = points%list%position(:, place(n))
         volume(n) = points%list%volume(place(n))
      end do
      call set_points(given, grid, position, volume, row, size(meant, kind=int64))
      allocate (body%given, source=given)
   end subroutine pack_points

   !> From a list with names of materials, a body uses the points of its own material.
   subroutine choose_material(deck, group, list, meant)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(group_t), intent(in) :: group
      type(point_list_t), intent(in) :: list
      logical, intent(inout) :: meant(:)             !! (row) Changed
      character(len=:), allocatable :: name
      integer :: n, found

      if (.not. allocated(list%material)) return
      call group%get("material", name)
      found = 0
      do n = 1, size(list%material_names)
         if (list%material_names(n)%text == name) found = n
      end do
      meant = meant .and. list%material == found
      if (any(meant)) return
      call deck%add_error(group, "the file of its region has no point of material '"//name// &
         "'; there are: "//join(list%material_names, ", ")//" [D356]", "material")
   end subroutine choose_material

   !> A region may select the points of one body of a snapshot.
   subroutine choose_body(deck, group, points, meant)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(group_t), intent(in) :: group
      type(point_region_t), intent(in) :: points
      logical, intent(inout) :: meant(:)             !! (row) Changed
      integer :: n, found

      if (points%body == "" .or. .not. any(meant)) return
      found = 0
      do n = 1, size(points%list%body_names)
         if (points%list%body_names(n)%text == points%body) found = n
      end do
      if (allocated(points%list%body)) then
         meant = meant .and. points%list%body == found
      else if (size(points%list%body_names) > 1) then
         call deck%add_error(group, "the snapshot does not contain the field body; write it "// &
            "in the other run, or remove from_body [D356]", "region")
         return
      else
         meant = meant .and. found == 1
      end if
      if (.not. any(meant)) call deck%add_error(group, "the snapshot has no point of body '"// &
         points%body//"' and of its material; its bodies are: "// &
         join(points%list%body_names, ", ")//" [D356]", "region")
   end subroutine choose_body

   !> Position of a point in its file.
   function where_text(points, row) result(text)
      type(point_region_t), intent(in) :: points
      integer, intent(in) :: row                     !! Row of the table
      character(len=:), allocatable :: text

      if (points%snapshot) then
         text = "row "//number(row)
      else
         text = "line "//number(points%list%line(row))
      end if
   end function where_text

   !> Refuse points outside of the grid and two at one position. Material moves a little into closed
   !! faces, so points of a snapshot may be behind one.
   subroutine check_positions(deck, grid, boundary, group, points, place)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(grid_t), intent(in) :: grid
      type(boundary_t), intent(in) :: boundary       !! Faces of the domain
      type(group_t), intent(in) :: group
      type(point_region_t), intent(in) :: points
      integer, intent(in) :: place(:)                !! Rows of the body
      real(wp), parameter :: behind = 0.5_wp         ! cells behind a closed face
      real(wp) :: low(3), high(3)
      integer(int64), allocatable :: key(:)
      integer, allocatable :: order(:)
      logical :: open(3)
      integer :: n, k

      low = grid%lower
      high = grid%upper
      do k = 1, 3
         if (grid%wall(2*k - 1) .and. .not. boundary%lets_out(2*k - 1)) &
            low(k) = low(k) - behind*grid%spacing
         if (grid%wall(2*k) .and. .not. boundary%lets_out(2*k)) &
            high(k) = high(k) + behind*grid%spacing
      end do
      open = [(boundary%lets_out(2*k), k=1, 3)]
      if (grid%axisymmetric) low(1) = grid%lower(1)
      allocate (key(size(place)))
      do n = 1, size(place)
         associate (x => points%list%position(:, place(n)))
            if (any(grid%active .and. (x < low .or. x > high .or. (x >= high .and. &
               (grid%periodic .or. open))))) then
               call deck%add_error(group, where_text(points, place(n))//" of '"//points%path// &
                  "': the point "//place_text(deck, grid, x)//" lies outside of the grid; "// &
                  "widen &grid or move the points with translate [F116]", "region")
               return
            end if
            ! adding 0 turns -0 into 0, so that equal positions have equal keys
            key(n) = 0
            do k = 1, 3
               key(n) = mix(ieor(key(n), transfer(x(k) + 0.0_wp, key(n))))
            end do
         end associate
      end do
      order = sort_order(key)
      do n = 2, size(place)
         if (key(order(n)) /= key(order(n - 1))) cycle
         call deck%add_error(group, where_text(points, place(order(n - 1)))//" and "// &
            where_text(points, place(order(n)))//" of '"//points%path// &
            "': two points at "//place_text(deck, grid, points%list%position(:, &
            place(order(n))))//" [F117]", "region")
         return
      end do
   end subroutine check_positions

   !> A place in the units of the deck.
   function place_text(deck, grid, x) result(text)
      type(deck_t), intent(in) :: deck
      type(grid_t), intent(in) :: grid               !! Grid with its directions
      real(wp), intent(in) :: x(3)                   !! [m]
      character(len=:), allocatable :: text
      type(unit_t) :: length
      integer :: k
      logical :: known

      call unit_of("m", length, known)
      text = ""
      do k = 1, 3
         if (grid%active(k)) text = text//" "//brief(x(k)/10.0_wp**nint( &
            length%exponent(deck%system)))
      end do
      text = "("//text(2:)//")"
   end function place_text

   !> True for fields that particles read from a snapshot in addition to position and volume. They
   !! get new identities.
   pure logical function comes_from_file(name, stress) result(yes)
      character(len=*), intent(in) :: name           !! Name of the field
      logical, intent(in) :: stress                  !! Is the stress requested?

      select case (name)
      case ("identity", "body", "material", "position", "volume", "reference", "density", "speed", &
         "pressure", "mises")
         yes = .false.
      case ("stress", "viscous_pressure")
         yes = stress
      case default
         yes = .true.
      end select
   end function comes_from_file

   !> Report the fields of the particles that a snapshot lacks.
   subroutine compare_fields(deck, group, material, traits, points, stress)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(group_t), intent(in) :: group
      type(material_t), intent(in) :: material       !! Material of the body
      type(traits_t), intent(in) :: traits           !! Particle fields that the method needs
      type(point_region_t), intent(in) :: points
      logical, intent(in) :: stress                  !! Is the stress requested?
      type(field_requests_t) :: requests
      type(text_t), allocatable :: missing(:)
      integer :: n, k

      allocate (missing(0))
      requests = material%field_requests()
      if (points%snapshot) then
         associate (names => field_names())
            do n = 1, size(names)
               if (.not. (requests%has(trim(names(n))) .or. of_method(names(n)))) cycle
               if (.not. comes_from_file(trim(names(n)), stress)) cycle
               do k = size(points%list%fields), 1, -1
                  if (points%list%fields(k)%text == names(n)) exit
               end do
               if (k == 0) call append(missing, trim(names(n)))
               if (k > 0 .and. .not. points%placing%keeps(trim(names(n)))) &
                  call deck%warn(group, "boxes along the coordinates can be rotated only by "// &
                  "right angles, so '"//trim(names(n))//"' of '"//points%path// &
                  "' is not used; its particles start as cubes of their volume [D417]", "region")
            end do
         end associate
      else if (stress) then
         call append(missing, "stress")
      end if
      do n = 1, size(missing)
         if (missing(n)%text == "stress") call deck%add_error(group, "'"//points%path// &
            "' has no field stress; write it in the other run, or initial_stress = 'zero' [D356]", &
            "initial_stress")
      end do
      if (size(missing) > 0) call deck%warn(group, "'"//points%path//"' lacks "// &
         join(missing, ", ")//"; these start from their initial values [D413]", &
         "region")

   contains

      !> True if the method needs a field.
      pure logical function of_method(name) result(yes)
         character(len=*), intent(in) :: name        !! Name of the field

         yes = (name == "extent" .and. traits%extent) .or. (name == "domain" .and. traits%domain) &
            .or. (name == "affine" .and. traits%affine) .or. (name == "spin" .and. traits%spin) &
            .or. (name == "ahead" .and. traits%averaged)
      end function of_method
   end subroutine compare_fields
end module scene_points
