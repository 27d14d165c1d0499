! SPDX-License-Identifier: BSD-3-Clause
!> The group &region: its keys, their checks, and the shapes that they describe.
module scene_regions
   use base_communicator, only: communicator_t
   use base_kinds, only: wp
   use base_text, only: number, text_t
   use deck_reader, only: deck_t, group_t
   use deck_schema, only: changes_nothing, changes_physics, schema_t
   use mesh_grid, only: grid_t
   use particle_shape, only: box, combine_shapes, cylinder, rotation_matrix, set_difference, &
      set_intersection, set_union, shape_holder_t, sphere, transform_point
   use particle_solids, only: cone, ellipsoid, half_space, torus
   use scene_dimension, only: axis_names, read_dimension
   use scene_facets, only: read_facets
   use scene_points, only: point_region_t, read_point_region
   use scene_prism, only: build_prism
   use scene_terrain, only: check_terrain, read_terrain
   use scene_unit_warnings, only: check_angles
   use scene_voxels, only: read_voxel_region
   implicit none
   private

   public :: check_regions, declare_region, named_shape_t, read_shapes

   character(len=*), parameter :: solids = &
      "shape = sphere cylinder ellipsoid cone torus halfspace" !! Shapes with a centre
   character(len=*), parameter :: round = "shape = sphere cylinder cone torus" !! With a radius
   character(len=*), parameter :: sets = "shape = union difference intersection"
   !> Simple shapes in all regions together. Nested set operations can double them each time.
   integer, parameter :: most_parts = 200000

   !> A region.
   type :: named_shape_t
      character(len=:), allocatable :: name          !! Name in the deck
      type(shape_holder_t) :: shape                  !! Position in the deck
      type(point_region_t), allocatable :: points    !! Points, if the region is a list of points
      integer :: parts = 1                           !! Number of simple shapes in it
      logical :: ready = .false.                     !! Is the shape built?
      logical :: in_progress = .false.               !! Is the region being built?
   end type named_shape_t

contains

   !> Declare &region.
   subroutine declare_region(schema)
      type(schema_t), intent(inout) :: schema            !! Keys of the deck

      call schema%group("region", "a shape, or a set operation on shapes", many=.true.)
      call schema%text("region", "name", "name of the region, for bodies and other regions")
      call schema%text("region", "shape", "kind of shape", &
         words="box sphere cylinder cone ellipsoid torus halfspace prism stl voxel terrain "// &
         "points union difference intersection")
      call schema%real("region", "lo(3)", "lower corner of a box", unit="m", owner="shape = box")
      call schema%real("region", "hi(3)", "upper corner of a box", unit="m", owner="shape = box")
      call schema%real("region", "centre(3)", "centre; of a cylinder or cone the middle of its "// &
         "axis, of a halfspace a point on its plane", unit="m", owner=solids)
      call schema%real("region", "radius", &
         "radius; of a cone at the start of its axis, of a torus that of its centre line", &
         unit="m", range="> 0", owner=round)
      call schema%real("region", "radius2", "radius of a cone at the end of its axis, 0 = a "// &
         "tip; of a torus that of its cross-section", unit="m", range=">= 0", &
         owner="shape = cone torus")
      call schema%real("region", "semi_axes(3)", "semi-axes along x, y and z", unit="m", &
         range="> 0", owner="shape = ellipsoid")
      call schema%real("region", "axis(3)", &
         "direction of the axis; of a prism one of the coordinate axes, in a plane scene y", &
         default="0 0 1", owner="shape = cylinder cone torus prism")
      call schema%real("region", "normal(3)", "outward normal of the halfspace", &
         owner="shape = halfspace")
      call schema%real("region", "polygon(:400)", "corners of a prism in order, two numbers "// &
         "each: in a plane scene x and z, in 3-D the two coordinates across its axis", unit="m", &
         owner="shape = prism")
      call schema%real("region", "span(2)", "start and end of a prism along its axis; 3-D only", &
         unit="m", owner="shape = prism")
      call schema%text("region", "file", "input file: of stl facets; of voxel HDF5; of "// &
         "terrain the heights as an ESRI ASCII grid (.asc); of points CSV or a snapshot (.hdf, "// &
         ".h5); lengths in the unit of the deck; path relative to the deck", &
         owner="shape = stl voxel terrain points")
      call schema%text("region", "thickness_file", "thickness of a layer on the surface of "// &
         "file, as an ESRI ASCII grid; the region is then this layer, not the ground", &
         owner="shape = terrain")
      call schema%real("region", "section", "y of the profile in a plane scene, as in the "// &
         "file, if the raster has several rows", unit="m", owner="shape = terrain")
      call schema%real("region", "point_volume", "volume of each particle, if the file has none", &
         unit="m3", range="> 0", owner="shape = points")
      call schema%text("region", "from_body", &
         "body of a snapshot whose particles are used; default: all bodies of the material", &
         owner="shape = points")
      call schema%text("region", "dataset", "name of the voxels in an HDF5 file", &
         default="/voxels", owner="shape = voxel")
      call schema%integer("region", "voxel_value", "voxel value of the material: voxels of "// &
         "this value belong to the region; of real voxels the nearest", default="1", &
         owner="shape = voxel")
      call schema%real("region", "height", "length along the axis", unit="m", range="> 0", &
         owner="shape = cylinder cone")
      call schema%text("region", "of(:8)", &
         "regions of the set operation; difference: the first without the others", owner=sets)
      call declare_placing(schema)
      call schema%require("region", "name shape lo hi centre radius radius2 semi_axes "// &
         "normal polygon file height of")
      call schema%refer("region", "of", "region")
      call schema%forbid_change("region", "*", "bodies were filled and walls are placed by it; "// &
         "add a region of another name")
      ! a region has an effect only through the group that names it
      call schema%allow_change("region", "+ -", changes_nothing)
      ! contents of files are not compared, only paths
      call schema%allow_change("region", "file thickness_file", changes_physics)
   end subroutine declare_region

   !> Declare how the shape of a region is placed.
   subroutine declare_placing(schema)
      type(schema_t), intent(inout) :: schema        !! Keys of the deck

      call schema%real("region", "scale", "scale factor, applied first", default="1.0", range="> 0")
      call schema%real("region", "rotate(3)", &
         "rotation angles about x, then y, then z, applied second", unit="deg", default="0 0 0")
      call schema%text("region", "rotate_about", &
         "centre of the rotation: the origin, or the centre of the bounding box of the shape", &
         default="origin", words="origin centre")
      call schema%real("region", "translate(3)", "displacement, applied last", unit="m", &
         default="0 0 0")
   end subroutine declare_placing

   !> All regions.
   subroutine check_regions(deck)
      type(deck_t), intent(inout) :: deck
      integer, allocatable :: state(:)
      integer :: i, k, operands
      type(group_t) :: region
      character(len=:), allocatable :: dimension, shape
      logical :: active(3)
      real(wp) :: axis(3), hi(3), lo(3)

      do i = 1, deck%count("region")
         region = deck%group("region", i)
         call check_angles(deck, region)
         call region%get("shape", shape)
         select case (shape)
         case ("box")
            if (.not. (region%known("lo") .and. region%known("hi"))) cycle
            call region%get("lo", lo)
            call region%get("hi", hi)
            call read_dimension(deck, dimension, active)
            do k = 1, 3
               if (hi(k) > lo(k) .or. .not. active(k)) cycle
               call deck%add_error(region, "hi must be above lo in "//axis_names(k)//" [D408]", &
                  "hi")
               exit
            end do
         case ("halfspace")
            call region%get("normal", axis)
            if (region%known("normal") .and. sum(abs(axis)) <= 0.0_wp) &
               call deck%add_error(region, "normal must not be 0 [D419]", "normal")
         case ("cylinder", "cone", "torus")
            call region%get("axis", axis)
            if (region%known("axis") .and. sum(abs(axis)) <= 0.0_wp) &
               call deck%add_error(region, "axis must not be 0 [D419]", "axis")
         case ("difference", "intersection")
            operands = region%count("of")
            if (operands == 1) call deck%add_error(region, &
               "of must name two regions or more for a "//shape//" [D420]", "of")
         case default
            continue
         end select
      end do
      allocate (state(deck%count("region")), source=0)
      do i = 1, size(state)
         if (state(i) == 0) call check_operands(deck, i, state)
      end do
   end subroutine check_regions

   !> Follow the operands of a region; a region that refers to itself has no shape.
   recursive subroutine check_operands(deck, place, state)
      type(deck_t), intent(inout) :: deck
      integer, intent(in) :: place                       !! Number of the region
      integer, intent(inout) :: state(:)                 !! (region) 0 new, 1 under way, 2 done
      type(group_t) :: region
      type(text_t), allocatable :: operands(:)
      integer :: i, next

      state(place) = 1
      region = deck%group("region", place)
      call region%list("of", operands)
      do i = 1, size(operands)
         next = deck%named("region", operands(i)%text)
         if (next == 0) cycle
         if (state(next) == 0) then
            call check_operands(deck, next, state)
         else if (state(next) == 1) then
            call deck%add_error(region, "'"//operands(i)%text//"' contains this region [D321]", &
               "of")
         end if
      end do
      state(place) = 2
   end subroutine check_operands

   !> Build all regions.
   subroutine read_shapes(deck, communicator, grid, shapes)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(communicator_t), intent(in) :: communicator !! Broadcasts the data of files
      type(grid_t), intent(in) :: grid               !! Gives the active directions
      type(named_shape_t), allocatable, intent(out) :: shapes(:)
      type(group_t) :: group
      integer :: index

      allocate (shapes(deck%count("region")))
      do index = 1, size(shapes)
         group = deck%group("region", index)
         call group%get("name", shapes(index)%name)
      end do
      do index = 1, size(shapes)
         call build(deck, communicator, grid, shapes, index)
      end do
   end subroutine read_shapes

   !> Build one region and its operands.
   recursive subroutine build(deck, communicator, grid, shapes, index)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(communicator_t), intent(in) :: communicator !! Broadcasts the data of files
      type(grid_t), intent(in) :: grid               !! Gives the active directions
      type(named_shape_t), intent(inout) :: shapes(:) !! All regions
      integer, intent(in) :: index                   !! Index of the region
      type(group_t) :: group
      character(len=:), allocatable :: about, word
      real(wp) :: scale, rotate(3), translate(3), centre(3), high(3), low(3), turned(3)
      logical :: own_centre
      real(wp), parameter :: unmoved(3) = 0.0_wp

      if (shapes(index)%ready) return
      group = deck%group("region", index)
      if (shapes(index)%in_progress) then
         call deck%add_error(group, "the region contains itself; name other regions [D321]", &
            key="of")
         return
      end if
      shapes(index)%in_progress = .true.
      call group%get("shape", word)
      select case (word)
      case ("union", "difference", "intersection")
         call build_set(deck, communicator, grid, shapes, index, group, word)
      case ("stl")
         call read_facets(communicator, deck, group, shapes(index)%shape)
      case ("voxel")
         call read_voxel_region(communicator, deck, grid, group, shapes(index)%shape)
      case ("terrain")
         call read_terrain(communicator, deck, grid, group, shapes(index)%shape)
      case ("points")
         call read_point_region(communicator, deck, grid, group, shapes(index)%points, &
            shapes(index)%shape)
      case ("prism")
         call build_prism(deck, grid, group, shapes(index)%shape)
      case default
         call build_solid(grid, group, word, shapes(index)%shape)
      end select
      call group%get("scale", scale)
      call group%get("rotate", rotate)
      call group%get("translate", translate)
      call group%get("rotate_about", about)
      own_centre = about == "centre"
      if (own_centre .and. (word == "halfspace" .or. word == "points" .or. word == "terrain")) then
         call deck%add_error(group, "a "//word//" has no centre to rotate about; use "// &
            "rotate_about = 'origin' [D205]", key="rotate_about")
      else if (own_centre .and. allocated(shapes(index)%shape%shape)) then
         ! the displacement keeps the centre fixed during the rotation
         call shapes(index)%shape%bounds(low, high)
         centre = scale*(0.5_wp*(low + high))
         turned = centre
         call transform_point(1.0_wp, rotation_matrix(rotate), unmoved, turned)
         translate = translate + (centre - turned)
      end if
      ! points are already at their positions
      if (allocated(shapes(index)%shape%shape) .and. .not. allocated(shapes(index)%points)) &
         call shapes(index)%shape%shape%place(scale, rotate, translate)
      if (word == "terrain") call check_terrain(deck, grid, group, shapes(index)%shape)
      shapes(index)%ready = .true.
   end subroutine build

   !> A shape of few numbers. In directions without cells a box is unbounded and the centre is at
   !! the coordinate of the particles.
   subroutine build_solid(grid, group, word, holder)
      type(grid_t), intent(in) :: grid               !! Gives the active directions
      type(group_t), intent(in) :: group
      character(len=*), intent(in) :: word           !! Kind of shape
      type(shape_holder_t), intent(inout) :: holder  !! Receives the shape
      real(wp), parameter :: far = 1.0e6_wp          ! extents of the box
      real(wp) :: lo(3), hi(3), centre(3), axis(3), semi_axes(3), radius, radius2, height, length

      call group%get("centre", centre)
      call group%get("axis", axis)
      call group%get("radius", radius)
      call group%get("radius2", radius2)
      call group%get("height", height)
      where (.not. grid%active) centre = merge(0.0_wp, 0.5_wp*(grid%lower + grid%upper), &
         grid%axisymmetric)
      select case (word)
      case ("box")
         call group%get("lo", lo)
         call group%get("hi", hi)
         length = far*maxval(grid%upper - grid%lower)
         where (.not. grid%active)
            lo = -length
            hi = length
         end where
         call holder%set(box(lo, hi))
      case ("sphere")
         call holder%set(sphere(centre, radius))
      case ("ellipsoid")
         call group%get("semi_axes", semi_axes)
         call holder%set(ellipsoid(centre, semi_axes))
      case ("cone")
         call holder%set(cone(centre, axis, radius, radius2, height))
      case ("torus")
         call holder%set(torus(centre, axis, radius, radius2))
      case ("halfspace")
         call group%get("normal", axis)
         call holder%set(half_space(centre, axis))
      case default
         call holder%set(cylinder(centre, axis, radius, height))
      end select
   end subroutine build_solid

   !> A set operation on other regions.
   recursive subroutine build_set(deck, communicator, grid, shapes, index, group, word)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(communicator_t), intent(in) :: communicator !! Broadcasts the data of files
      type(grid_t), intent(in) :: grid               !! Gives the active directions
      type(named_shape_t), intent(inout) :: shapes(:) !! All regions
      integer, intent(in) :: index                   !! Index of the region
      type(group_t), intent(in) :: group             !! Group of the region
      character(len=*), intent(in) :: word !! Set operation: union, difference, intersection
      type(text_t), allocatable :: names(:)
      type(shape_holder_t), allocatable :: operands(:)
      integer :: n, other, kind

      call group%list("of", names)
      allocate (operands(size(names)))
      shapes(index)%parts = 0
      do n = 1, size(names)
         do other = 1, size(shapes)
            if (shapes(other)%name /= names(n)%text) cycle
            call build(deck, communicator, grid, shapes, other)
            if (allocated(shapes(other)%points)) call deck%add_error(group, "'"// &
               names(n)%text//"' is a list of points, which has no interior; name other "// &
               "regions [D414]", key="of")
            shapes(index)%parts = min(shapes(index)%parts + shapes(other)%parts, most_parts)
            if (sum(shapes%parts, mask=shapes%ready) + shapes(index)%parts >= most_parts) then
               if (deck%sound("region")) call deck%add_error(group, "the regions up to this "// &
                  "one are made of more than "//number(most_parts)//" simple shapes, because "// &
                  "each region contains copies of those in of; combine pairs, then pairs of "// &
                  "these, instead of one after another, and name no region twice [D451]", key="of")
               return
            end if
            operands(n) = shapes(other)%shape
         end do
      end do
      select case (word)
      case ("union")
         kind = set_union
      case ("difference")
         kind = set_difference
      case default
         kind = set_intersection
      end select
      call shapes(index)%shape%set(combine_shapes(kind, operands))
   end subroutine build_set
end module scene_regions
