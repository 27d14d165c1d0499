! SPDX-License-Identifier: BSD-3-Clause
!> The keys of &boundary for rigid bodies that forces move, and for regions that turn: their mass,
!! inertia and first velocities.
!!
!! With a density, mass, centre and inertia are sums over a lattice of points in the bounds of the
!! shape. Equation (R.8) of doc/theory/rigid.md.
module scene_rigid_body
   use base_constants, only: pi
   use base_kinds, only: wp
   use base_small_system, only: solve_small
   use base_text, only: text_t
   use deck_reader, only: deck_t, group_t
   use deck_schema, only: schema_t
   use mesh_grid, only: grid_t
   use mesh_point_set, only: point_set_t
   use mesh_rigid_body, only: rigid_body_t
   use mesh_wall, only: wall_t
   use scene_dimension, only: axis_names, check_plane, read_dimension
   implicit none
   private

   public :: check_rigid_body, declare_rigid_body, read_rigid_body

   integer, parameter :: points(3) = [10000, 1000, 100] !! Of the lattice along each direction
   real(wp), parameter :: far = 1.0e29_wp            !! Bounds beyond this are infinite [m]
   character(len=7), parameter :: keys(7) = [character(len=7) :: "mass", "density", "inertia", &
      "centre", "spin", "lock", "force"]                      !! All of this module

   !> Sums over the points of a lattice in a shape, for a density of 1.
   type :: moments_t
      real(wp) :: volume = 0.0_wp                    !! [m3]; of a whole ring
      real(wp) :: centre(3) = 0.0_wp                 !! [m]
      real(wp) :: inertia(3, 3) = 0.0_wp             !! About the centre [m5]
   end type moments_t

contains

   !> Declare the keys.
   subroutine declare_rigid_body(schema, owner)
      type(schema_t), intent(inout) :: schema
      character(len=*), intent(in) :: owner          !! Condition under which they apply

      call schema%real("boundary", "density", "forces move the rigid region, with the mass of "// &
         "its volume at this density; velocity and spin are those at the start", unit="kg/m3", &
         range="> 0", owner=owner)
      call schema%real("boundary", "mass", "the same with this mass, in a plane that of the "// &
         "thickness of the grid, in axisymmetry that of the whole ring", unit="kg", &
         range="> 0", owner=owner)
      call schema%real("boundary", "inertia(6)", "moments of inertia xx, yy, zz and elements "// &
         "xy, yz, zx of the tensor about the centre of mass; default: those of a uniform "// &
         "density; in a plane only yy counts", unit="kg m2", owner=owner)
      call schema%real("boundary", "centre(3)", "centre of mass, with inertia; without mass "// &
         "and density: a point of the axis of rotation; default: centre of the volume", unit="m", &
         owner=owner)
      call schema%real("boundary", "spin(3)", "angular velocity of a rigid region about its "// &
         "centre; without mass and density it is constant", unit="1/s", default="0 0 0", &
         owner=owner)
      call schema%text("boundary", "lock(:4)", "directions in which forces do not move the "// &
         "region: x, y, z; spin: torques do not turn it", words="x y z spin", owner=owner)
      call schema%real("boundary", "force(3)", "constant external force on a region that "// &
         "forces move, besides gravity; in a plane that on the thickness of the grid, in "// &
         "axisymmetry that on the whole ring", unit="N", default="0 0 0", owner=owner)
      call schema%forbid_change("boundary", "mass density inertia centre spin lock force", &
         "the motion of a rigid region since the start is that of these values", without="face")
   end subroutine declare_rigid_body

   !> Check the keys of a &boundary.
   subroutine check_rigid_body(deck, boundary)
      type(deck_t), intent(inout) :: deck
      type(group_t), intent(in) :: boundary          !! One boundary
      character(len=:), allocatable :: dimension
      logical :: active(3), free, given, here
      real(wp) :: spin(3)
      integer :: n

      ! an echo gives defaults too
      if (.not. any([(deck%departs(boundary, trim(keys(n))), n=1, size(keys))])) return
      here = boundary%given("region") .and. .not. boundary%given("face")
      do n = 1, size(keys)
         if (here) exit
         if (deck%departs(boundary, trim(keys(n)))) call deck%add_error(boundary, &
            trim(keys(n))//" is a key of rigid regions; give region without face, or remove "// &
            "it [D369]", trim(keys(n)))
      end do
      free = boundary%given("mass") .or. boundary%given("density")
      if (boundary%given("mass") .and. boundary%given("density")) call deck%add_error(boundary, &
         "give mass or density, not both [D370]", "mass")
      if (boundary%given("inertia") .neqv. (boundary%given("centre") .and. free)) &
         call deck%add_error(boundary, "the inertia of a region that forces move belongs to a "// &
         "centre: give mass, inertia and centre together, or remove inertia and centre [D370]", &
         "inertia")
      do n = 6, size(keys)
         given = deck%departs(boundary, trim(keys(n)))
         if (given .and. .not. free) call deck%add_error(boundary, &
            "forces move only a region with mass or density; give one of them, or remove "// &
            trim(keys(n))//" [D370]", trim(keys(n)))
      end do
      if (deck%departs(boundary, "t_on")) call deck%add_error(boundary, "a region that turns, "// &
         "or that forces move, acts from the start; remove t_on [D371]", "t_on")
      given = deck%departs(boundary, "table")
      if (free .and. given) call deck%add_error(boundary, "a region that forces move follows "// &
         "no table; remove table, or mass and density [D371]", "table")
      given = deck%departs(boundary, "t_off")
      if (free .and. given) call deck%add_error(boundary, "a region that forces move acts "// &
         "until the end; remove t_off [D371]", "t_off")
      if (.not. (boundary%given("spin") .and. boundary%known("spin"))) return
      call read_dimension(deck, dimension, active)
      call boundary%get("spin", spin)
      if (dimension == "plane_strain") spin(2) = 0.0_wp
      if (dimension /= "3d" .and. any(abs(spin) > 0.0_wp)) call deck%add_error(boundary, &
         "a region cannot turn so with dimension = '"//dimension//"'; it turns only in 3d and, "// &
         "about y, in plane_strain [D372]", "spin")
   end subroutine check_rigid_body

   !> Mass, inertia and state of the body of a rigid region, if its keys request one.
   subroutine read_rigid_body(deck, grid, group, wall)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(grid_t), intent(in) :: grid
      type(group_t), intent(in) :: group             !! The &boundary
      type(wall_t), intent(inout) :: wall            !! With its region and motion
      type(rigid_body_t) :: body
      type(moments_t) :: moments
      real(wp) :: spin(3)
      integer :: n
      logical :: free

      free = group%given("mass") .or. group%given("density")
      call group%get("spin", spin)
      if (.not. (free .or. any(abs(spin) > 0.0_wp))) return
      if (.not. deck%sound("boundary")) return
      body%plane = grid%dimensions == 2
      if (free .or. .not. group%given("centre")) then
         call sample(wall%region, grid, moments)
         if (.not. moments%volume > 0.0_wp) then
            call deck%add_error(group, "the region '"//trim(wall%name)//"' has no finite "// &
               "volume, so its mass and centre are unknown; use a bounded shape, or, for a "// &
               "region that only turns, give centre [D373]", "region")
            return
         end if
      end if
      body%home = moments%centre
      if (group%given("centre")) call group%get("centre", body%home)
      where (.not. grid%active) body%home = merge(0.0_wp, 0.5_wp*(grid%lower + grid%upper), &
         grid%axisymmetric)
      if (grid%axisymmetric) body%home(1) = 0.0_wp
      body%radius = reach_of(wall%region, grid, body%home)
      if (free) call read_freedom(deck, grid, group, moments, body)
      if (free) then
         call body%begin(merge(wall%motion%steady, 0.0_wp, grid%active), spin)
         ! directions without freedom stay at rest; the others begin with the velocity
         where (.not. body%free) body%velocity = 0.0_wp
         body%velocity_end = body%velocity
         wall%motion%steady = 0.0_wp
      else
         call body%begin([(0.0_wp, n=1, 3)], spin)
      end if
      allocate (wall%body, source=body)
   end subroutine read_rigid_body

   !> Mass, inertia and free directions of a region that forces move.
   subroutine read_freedom(deck, grid, group, moments, body)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(grid_t), intent(in) :: grid
      type(group_t), intent(in) :: group             !! The &boundary
      type(moments_t), intent(in) :: moments         !! Of its shape
      type(rigid_body_t), intent(inout) :: body
      type(text_t), allocatable :: locks(:)
      real(wp) :: density, elements(6), matrix(3, 3)
      integer :: k

      if (group%given("density")) then
         call group%get("density", density)
         body%mass = density*moments%volume
      else
         call group%get("mass", body%mass)
      end if
      call group%get("force", body%force)
      call group%list("lock", locks)
      body%free = grid%active
      if (grid%axisymmetric) body%free(1) = .false.
      do k = 1, 3
         if (is_locked(locks, axis_names(k))) body%free(k) = .false.
      end do
      body%free_spin = grid%dimensions > 1 .and. .not. grid%axisymmetric
      if (is_locked(locks, "spin")) body%free_spin = .false.
      body%inertia = body%mass/moments%volume*moments%inertia
      if (group%given("inertia")) then
         call group%get("inertia", elements)
         body%inertia = reshape([elements(1), elements(4), elements(6), elements(4), elements(2), &
            elements(5), elements(6), elements(5), elements(3)], [3, 3])
      end if
      if (body%plane) then
         ! it turns about y only: any other elements give the same motion
         density = body%inertia(2, 2)
         body%inertia = 0.0_wp
         do k = 1, 3
            body%inertia(k, k) = density
         end do
      end if
      if (.not. body%free_spin) return
      if (.not. is_positive(body%inertia)) then
         call deck%add_error(group, "inertia is not that of a body: xx, yy, zz and the "// &
            "determinants of the tensor must be above 0 [D374]", "inertia")
         return
      end if
      do k = 1, 3
         matrix = body%inertia
         body%mobility(:, k) = 0.0_wp
         body%mobility(k, k) = 1.0_wp
         call solve_small(matrix, body%mobility(:, k))
      end do
      ! exactly symmetric, as its invariants need it
      body%mobility = 0.5_wp*(body%mobility + transpose(body%mobility))
   end subroutine read_freedom

   !> Whether a word is among those of `lock`.
   logical function is_locked(locks, word) result(locked)
      type(text_t), intent(in) :: locks(:)
      character(len=*), intent(in) :: word
      integer :: n

      locked = .false.
      do n = 1, size(locks)
         locked = locked .or. locks(n)%text == word
      end do
   end function is_locked

   !> Whether a symmetric tensor is positive definite.
   pure logical function is_positive(tensor) result(positive)
      real(wp), intent(in) :: tensor(3, 3)

      positive = tensor(1, 1) > 0.0_wp .and. tensor(1, 1)*tensor(2, 2) - tensor(1, 2)**2 > 0.0_wp &
         .and. tensor(1, 1)*(tensor(2, 2)*tensor(3, 3) - tensor(2, 3)**2) &
         - tensor(1, 2)*(tensor(1, 2)*tensor(3, 3) - tensor(2, 3)*tensor(1, 3)) &
         + tensor(1, 3)*(tensor(1, 2)*tensor(2, 3) - tensor(2, 2)*tensor(1, 3)) > 0.0_wp
   end function is_positive

   !> Bounds of a shape in the directions of the grid; the others are those of the grid.
   pure subroutine bounds_of(region, grid, low, high)
      class(point_set_t), intent(in) :: region
      type(grid_t), intent(in) :: grid
      real(wp), intent(out) :: low(3), high(3)       !! [m]

      call region%bounds(low, high)
      where (.not. grid%active) low = grid%lower
      where (.not. grid%active) high = grid%upper
      if (grid%axisymmetric) low(1) = max(low(1), 0.0_wp)
   end subroutine bounds_of

   !> Distance of the farthest corner of the bounds from a position, huge without bounds [m].
   pure real(wp) function reach_of(region, grid, centre) result(reach)
      class(point_set_t), intent(in) :: region
      type(grid_t), intent(in) :: grid
      real(wp), intent(in) :: centre(3)              !! [m]
      real(wp) :: low(3), high(3)

      call bounds_of(region, grid, low, high)
      reach = huge(reach)
      if (maxval(abs([low, high])) < far) reach = norm2(max(abs(low - centre), abs(high - centre)))
   end function reach_of

   !> Volume, centre and inertia of a shape, by the points of a lattice that are in it. The volume
   !! is 0 if it has no bounds.
   pure subroutine sample(region, grid, moments)
      class(point_set_t), intent(in) :: region
      type(grid_t), intent(in) :: grid
      type(moments_t), intent(out) :: moments
      real(wp) :: low(3), high(3), pace(3), x(3), weight, squares(3, 3), first(3)
      integer :: count(3), i, j, k, m

      call bounds_of(region, grid, low, high)
      if (.not. maxval(abs([low, high])) < far .or. any(high < low)) return
      count = merge(points(grid%dimensions), 1, grid%active)
      pace = (high - low)/real(count, wp)
      first = 0.0_wp
      squares = 0.0_wp
      do k = 1, count(3)
         do j = 1, count(2)
            do i = 1, count(1)
               x = low + (real([i, j, k], wp) - 0.5_wp)*pace
               where (.not. grid%active) x = merge(0.0_wp, 0.5_wp*(grid%lower + grid%upper), &
                  grid%axisymmetric)
               if (.not. region%contains(x)) cycle
               weight = merge(x(1), 1.0_wp, grid%axisymmetric)
               moments%volume = moments%volume + weight
               x = x - low
               first = first + weight*x
               do m = 1, 3
                  squares(:, m) = squares(:, m) + weight*x(m)*x
               end do
            end do
         end do
      end do
      if (.not. moments%volume > 0.0_wp) return
      moments%centre = first/moments%volume
      do m = 1, 3
         ! each point is a box of the lattice
         squares(:, m) = squares(:, m) - moments%volume*moments%centre(m)*moments%centre
         if (grid%active(m)) squares(m, m) = squares(m, m) + moments%volume*pace(m)**2/12.0_wp
      end do
      moments%inertia = -squares
      do m = 1, 3
         moments%inertia(m, m) = moments%inertia(m, m) + squares(1, 1) + squares(2, 2) &
            + squares(3, 3)
      end do
      ! the thickness of a plane or a line is that of the grid
      weight = product(pace, mask=grid%active .or. .not. grid%axisymmetric)
      if (grid%axisymmetric) weight = 2.0_wp*pi*weight
      moments%volume = weight*moments%volume
      moments%inertia = weight*moments%inertia
      moments%centre = moments%centre + low
   end subroutine sample
end module scene_rigid_body
