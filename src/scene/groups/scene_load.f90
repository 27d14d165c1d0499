! SPDX-License-Identifier: BSD-3-Clause
!> The group &load: pressures and tractions on the surfaces of bodies.
module scene_load
   use base_constants, only: symmetric
   use base_hash, only: hash_integers, hash_text
   use base_kinds, only: int64, wp
   use base_text, only: text_t
   use deck_reader, only: deck_t, group_t
   use deck_schema, only: changes_physics, schema_t
   use mesh_grid, only: grid_t
   use mesh_motion, only: motion_t
   use mesh_surface_load, only: mark_tile, surface_load_t
   use particle_body, only: body_t
   use particle_closed_loads, only: find_closed_loads
   use particle_store, only: store_t
   use scene_regions, only: named_shape_t
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: declare_load, mark_particles, read_loads

contains

   !> Declare &load.
   subroutine declare_load(schema)
      type(schema_t), intent(inout) :: schema        !! Schema that receives the keys

      call schema%group("load", "a pressure or traction on the surface of bodies", many=.true.)
      call schema%text("load", "name", "name of the load, for messages")
      call schema%text("load", "bodies(:20)", "bodies whose surface is loaded; default: all")
      call schema%text("load", "region", "region in which surfaces are loaded; its edge should "// &
         "lie inside the material or in the void, not along a surface; default: everywhere")
      call schema%logical("load", "follow", "the load stays on the material that is in the "// &
         "region at the start, or at the restart that adds the load; .false.: the region is "// &
         "fixed in space", default=".true.")
      call schema%real("load", "pressure", "pressure on the surface; positive pushes inwards", &
         unit="Pa")
      call schema%real("load", "traction(3)", &
         "force per area on a flat surface, whose direction is normal", unit="Pa")
      call schema%real("load", "normal(3)", "outward normal of the flat surface")
      call schema%real("load", "times(:50)", "times of factors, ascending", unit="s")
      call schema%real("load", "factors(:50)", "factors on pressure and traction at these "// &
         "times, interpolated linearly, constant before and after; default: 1 at all times")
      call schema%refer("load", "bodies", "body")
      call schema%refer("load", "region", "region")
      call schema%allow_change("load", "* + -", changes_physics)
   end subroutine declare_load

   !> Read all loads.
   subroutine read_loads(deck, simulation, bodies, shapes)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(simulation_t), intent(inout) :: simulation !! Gets the loads
      type(body_t), intent(in) :: bodies(:)
      type(named_shape_t), intent(in) :: shapes(:)
      type(surface_load_t), allocatable :: loads(:)
      integer :: n, slots

      if (deck%count("load") == 0) return
      allocate (loads(deck%count("load")))
      slots = 0
      do n = 1, size(loads)
         call read_one(deck, deck%group("load", n), bodies, shapes, loads(n))
         if (loads(n)%slot > 0) then
            slots = slots + 1
            loads(n)%slot = slots
         end if
         if (.not. finds_body(loads(n), bodies)) call deck%warn(deck%group("load", n), &
            "the load has no effect: none of its bodies reaches into its region [D354]", "region")
      end do
      call move_alloc(loads, simulation%effects%loads)
   end subroutine read_loads

   !> Read one load.
   subroutine read_one(deck, group, bodies, shapes, load)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(group_t), intent(in) :: group             !! The &load
      type(body_t), intent(in) :: bodies(:)
      type(named_shape_t), intent(in) :: shapes(:)
      type(surface_load_t), intent(out) :: load
      type(text_t), allocatable :: names(:)
      character(len=:), allocatable :: region
      logical :: follow
      integer :: n, place
      real(wp), parameter :: resolution = 1.0e6_wp
      integer(int64) :: way(7)

      call group%get("name", load%name)
      call read_stress(deck, group, load%stress)
      call read_course(deck, group, load)
      call group%get("region", region)
      do n = 1, size(shapes)
         if (region == "" .or. shapes(n)%name /= region) cycle
         if (allocated(shapes(n)%points)) then
            call deck%add_error(group, "'"//region//"' is a list of points, which has no "// &
               "interior; name another region [D414]", "region")
         else if (allocated(shapes(n)%shape%shape)) then
            allocate (load%region, source=shapes(n)%shape%shape)
         end if
      end do
      call group%get("follow", follow)
      if (follow .and. allocated(load%region)) load%slot = 1
      call group%list("bodies", names)
      if (size(names) > 0 .and. size(bodies) > 1) then
         allocate (load%bodies(0))
         do n = 1, size(names)
            place = deck%named("body", names(n)%text)
            if (place > 0) load%bodies = [load%bodies, int(place, int64)]
         end do
      end if
      ! the keys by which a restart finds the load in a checkpoint
      load%region_key = hash_text(region)
      way = 0
      if (norm2(load%stress) > 0.0_wp) way(:6) = nint(resolution*load%stress/norm2(load%stress), &
         int64)
      if (allocated(load%bodies)) way(7) = sum(2_int64**mod(load%bodies, 60_int64))
      load%surface_key = hash_integers(load%region_key, [(int(n, int64), n=1, size(way))], way)
   end subroutine read_one

   !> Set the functions of the loads that follow the material, and find which loads act on closed
   !! surfaces: at the start, or at a restart for those that the checkpoint does not have.
   !! Collective.
   subroutine mark_particles(simulation, marked, known)
      type(simulation_t), intent(inout) :: simulation !! With particles in their tiles
      logical, intent(in), optional :: marked(:)     !! (load) Particles have its functions
      logical, intent(in), optional :: known(:)      !! (load) It is known whether it is closed
      logical, allocatable :: has(:), judged(:)
      integer :: n

      if (.not. allocated(simulation%effects%loads)) return
      allocate (has(size(simulation%effects%loads)), judged(size(simulation%effects%loads)), &
         source=.false.)
      if (present(marked)) has = marked
      if (present(known)) judged = known
      associate (loads => simulation%effects%loads)
         do n = 1, size(loads)
            if (.not. has(n)) call mark_stores(simulation%space%grid, &
               simulation%space%tiles%coordinate, loads(n:n), simulation%stores)
            if (.not. judged(n)) call find_closed_loads(simulation%machine%communicator, &
               simulation%space%grid, simulation%space%tiles%coordinate, simulation%stores, &
               loads(n:n))
         end do
      end associate
   end subroutine mark_particles

   !> Set the function of a load at all particles.
   subroutine mark_stores(grid, tiles, load, stores)
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: tiles(:, :) !! (direction, tile) Tiles, counted from 0
      type(surface_load_t), intent(in) :: load(1)
      type(store_t), intent(inout) :: stores(:)      !! With particles in their tiles
      integer :: index, tile

      do index = 1, size(stores)
         associate (store => stores(index))
            if (.not. allocated(store%origin%marks)) cycle
            do tile = 1, size(store%count)
               call mark_tile(load, grid, tiles(:, tile), store%first(tile), store%count(tile), &
                  store%position, store%origin%marks)
            end do
         end associate
      end do
   end subroutine mark_stores

   !> Do the bounding boxes of a body of a load and of its region overlap?
   pure logical function finds_body(load, bodies) result(finds)
      type(surface_load_t), intent(in) :: load
      type(body_t), intent(in) :: bodies(:)
      real(wp) :: high(3), low(3), of_body(3), to_body(3)
      integer :: n

      finds = .true.
      if (.not. allocated(load%region)) return
      call load%region%bounds(low, high)
      do n = 1, size(bodies)
         if (allocated(load%bodies)) then
            if (all(load%bodies /= n)) cycle
         end if
         if (.not. allocated(bodies(n)%shape%shape)) return
         call bodies(n)%shape%bounds(of_body, to_body)
         if (all(of_body <= high .and. low <= to_body)) return
      end do
      finds = .false.
   end function finds_body

   !> The stress T of pressure and traction: T n = t, and no other traction on surfaces across n.
   subroutine read_stress(deck, group, stress)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(group_t), intent(in) :: group             !! The &load
      real(wp), intent(out) :: stress(6)             !! [Pa]
      real(wp) :: normal(3), pressure, traction(3)
      integer :: i, j

      stress = 0.0_wp
      if (.not. (group%given("pressure") .or. group%given("traction"))) then
         call deck%add_error(group, &
            "give a pressure, or a traction and the normal of the surface [D354]", "pressure")
         return
      end if
      if (group%given("pressure")) then
         call group%get("pressure", pressure)
         stress(:3) = -pressure
      end if
      if (.not. group%given("traction")) return
      if (.not. group%valid([character(len=8) :: "traction", "normal"])) return
      normal = 0.0_wp
      if (group%given("normal")) call group%get("normal", normal)
      if (.not. norm2(normal) > 0.0_wp) then
         call deck%add_error(group, "a traction needs the direction of the surface, such as "// &
            "normal = 0, 0, 1 [D354]", "normal")
         return
      end if
      normal = normal/norm2(normal)
      call group%get("traction", traction)
      do j = 1, 3
         do i = 1, j
            stress(symmetric(i, j)) = stress(symmetric(i, j)) + traction(i)*normal(j) &
               + normal(i)*traction(j) - dot_product(traction, normal)*normal(i)*normal(j)
         end do
      end do
   end subroutine read_stress

   !> Read the table of the time factor.
   subroutine read_course(deck, group, load)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(group_t), intent(in) :: group             !! The &load
      type(surface_load_t), intent(inout) :: load            !! Gets its time factor
      type(motion_t) :: course
      real(wp), allocatable :: factors(:)
      integer :: n

      if (.not. (group%given("times") .or. group%given("factors"))) return
      if (.not. group%valid([character(len=7) :: "times", "factors"])) return
      call group%list("times", course%time)
      call group%list("factors", factors)
      if (size(factors) /= size(course%time)) then
         call deck%add_error(group, "times and factors must have the same length [D354]", "factors")
         return
      end if
      do n = 2, size(factors)
         if (course%time(n) > course%time(n - 1)) cycle
         call deck%add_error(group, "times must ascend [D354]", "times")
         return
      end do
      allocate (course%speed(3, size(factors)), source=0.0_wp)
      course%speed(1, :) = factors
      allocate (load%course, source=course)
   end subroutine read_course
end module scene_load
