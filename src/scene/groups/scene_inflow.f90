! SPDX-License-Identifier: BSD-3-Clause
!> The group &inflow: bodies whose material enters the domain continuously. Equations (O.8) to
!! (O.10) of doc/theory/instruments.md.
module scene_inflow
   use base_exact_sum, only: exact_sum_t
   use base_kinds, only: int64, wp
   use base_text, only: brief
   use deck_reader, only: deck_t, group_t
   use deck_schema, only: changes_physics, schema_t
   use io_motion, only: of_velocities
   use mesh_boundary_catalogue, only: choose_boundary
   use mesh_grid, only: grid_t
   use mesh_hilbert, only: hilbert_coordinate
   use mesh_rigid, only: rigid_t
   use mesh_wall, only: wall_t
   use particle_body, only: body_t, find_box, find_boxes
   use particle_inflow, only: inflow_t
   use particle_shape, only: box
   use particle_split, only: root_bits
   use particle_store, only: store_t
   use scene_dimension, only: check_plane
   use scene_motion_table, only: read_motion_table
   use scene_particles, only: fill_store, number_bodies
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: declare_inflow, read_inflows, start_inflows

contains

   !> Declare &inflow.
   subroutine declare_inflow(schema)
      type(schema_t), intent(inout) :: schema        !! Schema that receives the keys

      call schema%group("inflow", &
         "a body that enters with a prescribed velocity; new material follows", many=.true.)
      call schema%text("inflow", "body", "body with the cross-section of the flow, at least "// &
         "three cells long and full of material at the start")
      call schema%real("inflow", "velocity(3)", "velocity of the entering material, along x, y "// &
         "or z; with mass_rate only its direction is used", unit="m/s")
      call schema%real("inflow", "mass_rate", "mass per time that enters; it determines the "// &
         "speed; in a plane scene, for the depth of the scene", unit="kg/s", range="> 0")
      call schema%text("inflow", "table", "file with lines t, vx, vy, vz in the units of the "// &
         "deck, interpolated linearly and added to velocity; path relative to the deck")
      call schema%real("inflow", "t_off", "end of the inflow; afterwards the body moves freely", &
         unit="s", range="> 0")
      call schema%require("inflow", "body velocity")
      call schema%refer("inflow", "body", "body")
      call schema%allow_change("inflow", "# table", changes_physics)
      call schema%forbid_change("inflow", "body + -", "an inflow repeats the first "// &
         "particles of its body")
   end subroutine declare_inflow

   !> Read the inflows, set the velocities of their bodies, and prescribe those of the nodes around
   !! them. Collective.
   subroutine read_inflows(deck, simulation, bodies)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(simulation_t), intent(inout) :: simulation !! Gets inflows and rigid regions
      type(body_t), intent(inout) :: bodies(:)
      type(inflow_t), allocatable :: inflows(:)
      logical, allocatable :: taken(:)
      integer :: n

      if (deck%count("inflow") == 0) return
      if (allocated(simulation%space%cell)) call deck%add_error(deck%group("inflow", 1), &
         "&inflow cannot be combined with a deforming &cell; remove one of the two [D444]")
      allocate (inflows(deck%count("inflow")), taken(size(bodies)))
      taken = .false.
      do n = 1, size(inflows)
         call read_one(deck, deck%group("inflow", n), simulation, bodies, taken, inflows(n))
      end do
      if (.not. deck%sound("inflow")) return
      do n = 1, size(inflows)
         bodies(inflows(n)%body)%velocity = inflows(n)%motion%velocity(0.0_wp)
         call hold_nodes(simulation%space%grid, bodies(inflows(n)%body), inflows(n), simulation)
         allocate (inflows(n)%origin(0))
      end do
      call move_alloc(inflows, simulation%effects%inflows)
   end subroutine read_inflows

   !> Read one inflow.
   subroutine read_one(deck, group, simulation, bodies, taken, inflow)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(group_t), intent(in) :: group             !! The &inflow
      type(simulation_t), intent(in) :: simulation
      type(body_t), intent(in) :: bodies(:)
      logical, intent(inout) :: taken(:)             !! (body) Has the body an inflow?
      type(inflow_t), intent(out) :: inflow
      character(len=:), allocatable :: what

      if (.not. group%valid([character(len=9) :: "body", "velocity", "mass_rate", "t_off"])) return
      call group%get("body", inflow%name)
      inflow%body = deck%named("body", inflow%name)
      if (inflow%body == 0) return
      inflow%store = bodies(inflow%body)%store
      if (taken(inflow%body)) call deck%add_error(group, "'"//inflow%name//"' has another "// &
         "&inflow; give each its own body [D444]", "body")
      taken(inflow%body) = .true.
      ! bodies with a nonuniform initial state or with motion relative to the flow are refused:
      ! their copies would not join without a jump
      associate (body => bodies(inflow%body))
         what = ""
         if (allocated(body%formula)) what = "velocity_formula"
         if (any(abs(body%spin) > 0.0_wp)) what = "spin"
         if (allocated(body%given)) what = "fill = 'poisson', or a region of points"
         if (body%lateral >= 0.0_wp) what = "an initial stress by weight"
         if (allocated(simulation%materials(body%store)%burn)) what = "an explosive"
         if (norm2(body%velocity) > 0.0_wp) what = "velocity, which is that of its &inflow"
         if (what /= "") call deck%add_error(group, "the body of an inflow cannot be combined "// &
            "with "//what// &
            "; remove it from '"//body%name//"' [D444]", "body")
      end associate
      call check_plane(deck, group, "velocity")
      call group%get("velocity", inflow%motion%steady)
      if (group%given("t_off")) call group%get("t_off", inflow%motion%end)
      if (group%given("mass_rate")) call group%get("mass_rate", inflow%mass_rate)
      if (group%given("table")) then
         if (group%given("mass_rate")) call deck%add_error(group, "the speed follows from "// &
            "mass_rate; remove table or mass_rate [D444]", "table")
         call read_motion_table(deck, simulation%machine%communicator, group, "table", &
            of_velocities, "m/s", inflow%motion)
      end if
      if (deck%sound("inflow")) call find_axis(deck, group, simulation%space%grid, inflow)
   end subroutine read_one

   !> The direction of the flow; all entries of the table must have it.
   subroutine find_axis(deck, group, grid, inflow)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(group_t), intent(in) :: group             !! The &inflow
      type(grid_t), intent(in) :: grid
      type(inflow_t), intent(inout) :: inflow        !! Gets axis and sense
      real(wp), allocatable :: speed(:, :)
      integer :: n

      allocate (speed(3, 1))
      speed(:, 1) = inflow%motion%steady
      if (allocated(inflow%motion%speed)) then
         speed = inflow%motion%speed
         do n = 1, size(speed, 2)
            speed(:, n) = speed(:, n) + inflow%motion%steady
         end do
      end if
      inflow%axis = maxloc(maxval(abs(speed), dim=2), dim=1)
      inflow%sense = sign(1.0_wp, sum(speed(inflow%axis, :)))
      do n = 1, 3
         if (n == inflow%axis) cycle
         if (any(abs(speed(n, :)) > 0.0_wp)) then
            call deck%add_error(group, "the flow must be along x, y or z, such as velocity = "// &
               "0, 0, -10; rotate the scene accordingly [D444]", "velocity")
            return
         end if
      end do
      if (any(inflow%sense*speed(inflow%axis, :) < 0.0_wp) .or. &
         .not. any(abs(speed) > 0.0_wp)) call deck%add_error(group, "the flow must have a "// &
         "speed and must not reverse at any time [D444]", "velocity")
      if (grid%axisymmetric .and. inflow%axis == 1) call deck%add_error(group, &
         "in axisymmetric scenes an inflow is along z; across the radius its width would "// &
         "change [D444]", "velocity")
   end subroutine find_axis

   !> Prescribe the velocity of the flow at the nodes around the body: as far as its particles reach
   !! at its sides and behind it, and up to its front, (O.10).
   subroutine hold_nodes(grid, body, inflow, simulation)
      type(grid_t), intent(in) :: grid
      type(body_t), intent(in) :: body
      type(inflow_t), intent(inout) :: inflow        !! Gets the number of the region
      type(simulation_t), intent(inout) :: simulation
      type(wall_t) :: wall
      type(rigid_t) :: rigid
      real(wp) :: high(3), low(3), around

      call body%shape%bounds(low, high)
      around = real(1 + grid%margin, wp)*grid%spacing
      low = low - around
      high = high + around
      if (inflow%sense > 0.0_wp) then
         high(inflow%axis) = high(inflow%axis) - around
      else
         low(inflow%axis) = low(inflow%axis) + around
      end if
      call choose_boundary("stick", wall%condition)
      wall%name = inflow%name
      wall%stays = .true.
      wall%motion = inflow%motion
      allocate (wall%region, source=box(low, high))
      if (.not. allocated(simulation%space%rigid)) then
         allocate (rigid%wall(0))
         allocate (simulation%space%rigid)
         call move_alloc(rigid%wall, simulation%space%rigid%wall)
      end if
      call simulation%space%rigid%add(wall)
      inflow%wall = size(simulation%space%rigid%wall)
   end subroutine hold_nodes

   !> Make the particles of the bodies that inflows repeat, and compute speeds from rates.
   !! Collective.
   subroutine start_inflows(deck, simulation, bodies, keys)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(simulation_t), intent(inout) :: simulation !! With empty stores
      type(body_t), intent(inout) :: bodies(:)       !! Get their identities, and these speeds
      integer(int64), intent(in) :: keys(:)          !! Tiles that this rank has counted
      integer(int64) :: next
      real(wp) :: mass, finish
      integer :: n
      type(group_t) :: time

      if (.not. allocated(simulation%effects%inflows)) return
      call number_bodies(simulation%space%grid, bodies, next)
      do n = 1, size(simulation%effects%inflows)
         associate (inflow => simulation%effects%inflows(n))
            inflow%identities = next - 1
            call make_pattern(simulation, bodies, keys, inflow)
            call measure_pattern(deck, deck%group("inflow", n), simulation, bodies(inflow%body), &
               inflow, mass)
            if (.not. deck%sound("inflow")) cycle
            if (inflow%mass_rate > 0.0_wp .and. mass > 0.0_wp) then
               inflow%motion%steady = 0.0_wp
               inflow%motion%steady(inflow%axis) = inflow%sense*inflow%mass_rate*inflow%length/mass
               bodies(inflow%body)%velocity = inflow%motion%steady
               simulation%space%rigid%wall(inflow%wall)%motion = inflow%motion
            end if
            ! splitting uses a part of each identity, so the identities of all copies must leave
            ! these bits free
            if (.not. inflow%length > 0.0_wp) cycle
            if (.not. allocated(simulation%scheme%method%splitting)) cycle
            time = deck%group("time", 1)
            call time%get("t_end", finish)
            if ((inflow%travel(finish)/inflow%length + 2.0_wp)*real(inflow%identities, wp) < &
               2.0_wp**root_bits) cycle
            call deck%add_error(deck%group("inflow", n), "more particles would enter until "// &
               "t_end than split = .true. can number; write split = .false. in &method, a "// &
               "longer body, or a grid of fewer cells [D447]", "velocity")
         end associate
      end do
   end subroutine start_inflows

   !> The particles of a body in the tiles of this rank.
   subroutine make_pattern(simulation, bodies, keys, inflow)
      type(simulation_t), intent(in) :: simulation   !! With empty stores
      type(body_t), intent(in) :: bodies(:)
      integer(int64), intent(in) :: keys(:)          !! Tiles that this rank has counted
      type(inflow_t), intent(inout) :: inflow        !! Gets the pattern
      type(store_t) :: store
      integer, allocatable :: tiles(:, :), own(:)
      real(wp), allocatable :: low(:, :), high(:, :)
      real(wp) :: corner(3)
      integer :: n, p, filled

      associate (grid => simulation%space%grid)
         call find_boxes(grid, bodies, low, high)
         allocate (tiles(3, size(keys)))
         filled = 0
         do n = 1, size(keys)
            tiles(:, filled + 1) = hilbert_coordinate(keys(n), grid%dimensions)
            corner = grid%tile_corner(tiles(:, filled + 1))
            if (any(grid%active .and. (corner > high(:, inflow%body) .or. &
               corner + real(grid%width, wp)*grid%spacing < low(:, inflow%body)))) cycle
            filled = filled + 1
         end do
         store = simulation%stores(inflow%store)
         call fill_store(grid, simulation%materials(inflow%store), bodies, tiles(:, :filled), &
            inflow%store, store)
         allocate (own(0))
         do n = 1, size(store%count)
            do p = store%first(n), store%first(n) + store%count(n) - 1
               if (store%identity(p) >= bodies(inflow%body)%first_identity .and. &
                  store%identity(p) < bodies(inflow%body)%first_identity + &
                  product(bodies(inflow%body)%sites(grid))) own = [own, p]
            end do
         end do
         inflow%origin = store%position(own, inflow%axis)
         inflow%identity = store%identity(own)
         inflow%particle = own
         inflow%pattern = store
         if (.not. allocated(store%state%brittle%scatter)) return
         allocate (inflow%low(3, size(store%identity)), inflow%high(3, size(store%identity)), &
            inflow%back(size(store%identity)))
         do n = 1, size(own)
            p = own(n)
            call find_box(grid, bodies(inflow%body), store%identity(p), [store%position(p, 1), &
               store%position(p, 2), store%position(p, 3)], store%state%volume(p), &
               inflow%low(:, p), inflow%high(:, p))
         end do
      end associate
   end subroutine make_pattern

   !> Position at which material enters, length of the body, and its mass. Each layer of particles
   !! across the flow must have the same mass.
   subroutine measure_pattern(deck, group, simulation, body, inflow, mass)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(group_t), intent(in) :: group             !! The &inflow
      type(simulation_t), intent(in) :: simulation
      type(body_t), intent(in) :: body
      type(inflow_t), intent(inout) :: inflow        !! Gets plane and length
      real(wp), intent(out) :: mass                  !! Mass of the body [kg]
      real(wp), parameter :: alike = 1.0e-6_wp, shortest = 3.0_wp
      type(exact_sum_t), allocatable :: sums(:)
      real(wp), allocatable :: layers(:), masses(:)
      real(wp) :: edge
      integer :: first, last, n

      mass = 0.0_wp
      associate (communicator => simulation%machine%communicator, grid => simulation%space%grid)
         edge = grid%spacing/real(body%per_cell(inflow%axis), wp)
         allocate (layers, source=(inflow%origin - grid%lower(inflow%axis))/edge)
         last = floor(communicator%maximum(maxval([-1.0_wp, layers])))
         first = floor(communicator%minimum(minval([real(last, wp), layers])))
         ! a body without particles is reported elsewhere
         if (last < 0) return
         allocate (sums(first:last))
         do n = 1, size(layers)
            call sums(floor(layers(n)))%add(inflow%pattern%state%mass(inflow%particle(n)))
         end do
         do n = first, last
            call sums(n)%over_ranks(communicator)
         end do
         allocate (masses, source=[(sums(n)%value(), n=first, last)])
         mass = sum(masses)
         inflow%length = real(last - first + 1, wp)*edge
         inflow%plane = grid%lower(inflow%axis) + edge*real(merge(first, last + 1, &
            inflow%sense > 0.0_wp), wp)
         if (maxval(masses) - minval(masses) > alike*maxval(masses)) then
            call deck%add_error(group, "the cross-section of '"//inflow%name//"' changes along "// &
               "the flow; use a box, prism or cylinder along it whose ends lie where particles "// &
               "end, "//brief(edge)//" m apart from the corner of the grid [D444]", "body")
         else if (inflow%length < (shortest - alike)*grid%spacing) then
            call deck%add_error(group, "'"//inflow%name//"' is "//brief(inflow%length)// &
               " m long; give it three cells ("//brief(shortest*grid%spacing)//" m) or more "// &
               "along the flow [D444]", "body")
         end if
      end associate
   end subroutine measure_pattern
end module scene_inflow
