! SPDX-License-Identifier: BSD-3-Clause
!> Builds a run from a deck whose words and numbers are known to be right one by one.
module scene_build
   use base_deck, only: deck_t, group_t
   use base_kinds, only: int64, wp
   use base_text, only: text_t
   use material_kinds, only: all_gases, stores_work
   use material_record, only: read_record
   use material_type, only: material_t
   use mesh_boundary, only: face_names, face_outflow, face_periodic, face_symmetry, face_types
   use mesh_grid, only: grid_t
   use particle_disks, only: disks_t, start_disks
   use particle_fill, only: body_t
   use particle_store, only: traits_t
   use scene_absorbing, only: read_absorbing
   use scene_bounds, only: read_bounds
   use scene_contact, only: read_contact
   use scene_deck_check_grid, only: axis_names
   use scene_exact, only: read_exact
   use scene_gravity, only: read_gravity
   use scene_lithostatic, only: read_lithostatic
   use scene_method, only: read_method
   use scene_particles, only: make_stores, prepare
   use scene_points, only: compare_fields, pack_points
   use scene_points_clock, only: check_clocks
   use scene_shapes, only: named_shape_t, read_shapes
   use scene_walls, only: read_walls
   use step_method, only: position_of
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: build_scene

contains

   !> Build grid, faces, materials, method and bodies; particles come later. Errors go into the
   !! deck's list of problems. What does not depend on them is built and checked all the same, so
   !! that one pass reports as much as can be known: bodies are then allocated if their places are
   !! sound, and stores if nothing that they depend on has an error.
   subroutine build_scene(deck, simulation, bodies, shapes, coarser)
      type(deck_t), intent(inout) :: deck            !! The deck, collects complaints
      type(simulation_t), intent(inout) :: simulation !! The run
      type(body_t), allocatable, intent(out) :: bodies(:) !! What is to be filled
      type(named_shape_t), allocatable, intent(out) :: shapes(:) !! The regions
      integer, intent(in), optional :: coarser       !! Cells so many times as large as in the deck
      type(traits_t) :: traits
      integer :: n

      call read_materials(deck, simulation)
      call read_method(simulation%method, deck, stores_work(simulation%materials), &
         all_gases(simulation%materials))
      do n = 1, size(simulation%materials)
         if (allocated(simulation%materials(n)%viscosity)) &
            simulation%materials(n)%viscosity%limited = simulation%method%limited
      end do
      call read_bounds(deck, simulation%guard%bounds)
      call read_grid(deck, simulation)
      call set_crack_bands(deck, simulation)
      if (present(coarser)) call coarsen(simulation%grid, coarser)
      if (.not. (deck%sound("run") .and. deck%sound("grid") .and. deck%sound("method") .and. &
         deck%sound("effects") .and. deck%sound("boundary"))) return
      if (deck%sound("material")) then
         call check_volumes(deck, simulation)
         call check_heat_flux(deck, simulation)
      end if
      call read_boundary(deck, simulation)
      simulation%grid%margin = simulation%method%margin()
      simulation%grid%reaches = merge(2, 1, simulation%method%dual)
      call simulation%grid%start(block_of(deck))
      call check_periodic(deck, simulation%grid)
      call read_effects(deck, simulation)
      if (.not. deck%sound("region")) return
      call read_shapes(deck, simulation%communicator, simulation%grid, shapes)
      if (.not. (deck%sound("region") .and. deck%sound("body") .and. deck%count("body") > 0)) return
      call read_bodies(deck, simulation, shapes, bodies)
      call read_walls(deck, simulation, shapes)
      ! errors in groups that the stores do not depend on, such as &time, hide nothing
      if (.not. is_sound(deck)) return
      call read_absorbing(deck, simulation, bodies)
      if (.not. is_sound(deck)) return
      call read_contact(deck, simulation, bodies)
      if (.not. is_sound(deck)) return
      call read_exact(deck, simulation, bodies)
      if (.not. is_sound(deck)) return
      call check_clocks(deck, simulation, bodies, shapes)
      call prepare(simulation)
      traits%body = size(bodies) > 1
      allocate (simulation%body_names(size(bodies)))
      do n = 1, size(bodies)
         simulation%body_names(n)%text = bodies(n)%name
      end do
      call simulation%method%request(traits)
      call make_stores(simulation, traits)
   end subroutine build_scene

   !> True if no group has an error on which bodies and the fields of their particles depend.
   logical function is_sound(deck) result(sound)
      type(deck_t), intent(in) :: deck               !! The deck
      character(len=8), parameter :: groups(10) = [character(len=8) :: "run", "grid", "method", &
         "effects", "boundary", "material", "region", "body", "contact", "exact"]
      integer :: n

      sound = .true.
      do n = 1, size(groups)
         sound = sound .and. deck%sound(trim(groups(n)))
      end do
   end function is_sound

   !> Box, spacing and problem class.
   subroutine read_grid(deck, simulation)
      type(deck_t), intent(in) :: deck               !! The deck
      type(simulation_t), intent(inout) :: simulation !! The run
      type(group_t) :: group
      character(len=:), allocatable :: word
      integer :: cells(3)

      group = deck%group("run", 1)
      call group%get("dimension", word)
      associate (grid => simulation%grid)
         select case (word)
         case ("1d")
            grid%dimensions = 1
         case ("plane_strain", "axisymmetric")
            grid%dimensions = 2
         case default
            grid%dimensions = 3
         end select
         grid%axisymmetric = word == "axisymmetric"
         group = deck%group("grid", 1)
         call group%get("lo", grid%lower)
         call group%get("hi", grid%upper)
         if (group%given("cells")) then
            call group%get("cells", cells)
            grid%spacing = (grid%upper(1) - grid%lower(1))/real(cells(1), wp)
         else
            call group%get("dx", grid%spacing)
         end if
         ! a direction that the scene lacks counts with its full extent, or with a unit if it has
         ! none
         if (grid%dimensions < 3 .and. .not. grid%upper(2) > grid%lower(2)) &
            grid%upper(2) = grid%lower(2) + merge(0.0_wp, 1.0_wp, grid%axisymmetric)
         if (grid%dimensions < 2 .and. .not. grid%upper(3) > grid%lower(3)) &
            grid%upper(3) = grid%lower(3) + 1.0_wp
      end associate
   end subroutine read_grid

   !> Make the cells larger, and the box by less than one of them where it holds no whole number.
   pure subroutine coarsen(grid, coarser)
      type(grid_t), intent(inout) :: grid            !! Corners, spacing and dimensions are set
      integer, intent(in) :: coarser                 !! How many times as large
      real(wp), parameter :: grain = 1.0e-6_wp       ! rounding of a number of cells
      integer :: direction

      grid%spacing = grid%spacing*real(coarser, wp)
      do direction = 1, 3
         if (direction == 2 .and. grid%dimensions < 3) cycle
         if (direction == 3 .and. grid%dimensions < 2) cycle
         grid%upper(direction) = grid%lower(direction) + grid%spacing &
            *real(ceiling((grid%upper(direction) - grid%lower(direction))/grid%spacing - grain), wp)
      end do
   end subroutine coarsen

   !> Cells along a tile that the user wished, 0 = the program chooses.
   integer function block_of(deck) result(block)
      type(deck_t), intent(in) :: deck               !! The deck
      type(group_t) :: group

      group = deck%group("grid", 1)
      call group%get("block", block)
   end function block_of

   !> Conditions on the faces of the box.
   subroutine read_boundary(deck, simulation)
      type(deck_t), intent(in) :: deck               !! The deck
      type(simulation_t), intent(inout) :: simulation !! The run
      type(group_t) :: group
      character(len=:), allocatable :: face, kind
      integer :: index, side, pass

      if (simulation%grid%axisymmetric) simulation%boundary%kind(1) = face_symmetry
      ! what is said of all faces gives way to what is said of one
      do pass = 1, 2
         do index = 1, deck%count("boundary")
            group = deck%group("boundary", index)
            call group%get("face", face)
            call group%get("type", kind)
            if (((face == "all") .neqv. (pass == 1)) .or. group%given("region")) cycle
            do side = 1, 6
               if (face /= face_names(side) .and. face /= "all") cycle
               simulation%boundary%kind(side) = position_of(kind, face_types)
               call group%get("velocity", simulation%boundary%velocity(:, side))
               simulation%boundary%warm(side) = group%given("temperature")
               if (simulation%boundary%warm(side)) &
                  call group%get("temperature", simulation%boundary%temperature(side))
               if (kind == "friction") &
                  call group%get("friction", simulation%boundary%friction(side))
            end do
         end do
      end do
      associate (sides => simulation%boundary%kind)
         if (simulation%grid%axisymmetric) sides(1) = face_symmetry
         simulation%grid%wall = sides /= face_outflow .and. sides /= face_periodic
         do side = 1, 3
            simulation%grid%periodic(side) = sides(2*side) == face_periodic .and. &
               sides(2*side - 1) == face_periodic
         end do
      end associate
   end subroutine read_boundary

   !> The fill of nodes, which corrects volumes, is found with the dual gradient.
   subroutine check_volumes(deck, simulation)
      type(deck_t), intent(inout) :: deck            !! The deck, collects complaints
      type(simulation_t), intent(in) :: simulation   !! The run, materials and method are read
      integer :: n

      if (simulation%method%dual) return
      do n = 1, size(simulation%materials)
         if (simulation%materials(n)%repacks) call deck%complain("material", n, &
            "volume_from = 'grid' needs method = 'ddmp' in &run; remove it", "volume_from")
      end do
   end subroutine check_volumes

   !> An artificial heat flux needs matter that carries an internal energy.
   subroutine check_heat_flux(deck, simulation)
      type(deck_t), intent(inout) :: deck            !! The deck, collects complaints
      type(simulation_t), intent(in) :: simulation   !! The run, materials and method are read
      integer :: n

      if (.not. simulation%method%heat_flux > 0.0_wp) return
      do n = 1, size(simulation%materials)
         if (simulation%materials(n)%carries_energy()) return
      end do
      call deck%complain(deck%group("method", 1), "no material carries an internal energy; "// &
         "remove heat_flux", "heat_flux")
   end subroutine check_heat_flux

   !> Node functions that reach beyond a cell must not meet themselves round a periodic box.
   subroutine check_periodic(deck, grid)
      type(deck_t), intent(inout) :: deck            !! The deck, collects complaints
      type(grid_t), intent(in) :: grid               !! The grid
      integer, parameter :: least = 4                ! nodes that a particle may touch along a line
      type(group_t) :: group
      character(len=:), allocatable :: basis
      integer :: direction

      if (grid%margin == 0) return
      group = deck%group("method", 1)
      call group%get("basis", basis)
      do direction = 1, 3
         if (.not. (grid%active(direction) .and. grid%periodic(direction))) cycle
         if (grid%cells(direction) >= least) cycle
         call deck%complain(group, "basis = '"//basis//"' needs at least 4 cells along "// &
            axis_names(direction)//", which is periodic, but there are "// &
            achar(iachar("0") + grid%cells(direction))//"; take smaller cells or "// &
            "basis = 'linear'", "basis")
      end do
   end subroutine check_periodic

   !> Erosion, and gravity if it acts.
   subroutine read_effects(deck, simulation)
      type(deck_t), intent(inout) :: deck            !! The deck, collects complaints
      type(simulation_t), intent(inout) :: simulation !! The run
      type(group_t) :: group

      group = deck%group("effects", 1)
      call group%get("erosion", simulation%erosion)
      call read_gravity(deck, simulation)
   end subroutine read_effects

   !> The materials.
   subroutine read_materials(deck, simulation)
      type(deck_t), intent(inout) :: deck            !! The deck, collects complaints
      type(simulation_t), intent(inout) :: simulation !! The run
      integer :: index

      allocate (simulation%materials(deck%count("material")))
      do index = 1, size(simulation%materials)
         call simulation%materials(index)%read(deck, index)
      end do
      simulation%materials%record = read_record(deck)
   end subroutine read_materials

   !> Width of the bands that cracks open in, and cells small enough for them.
   subroutine set_crack_bands(deck, simulation)
      type(deck_t), intent(inout) :: deck
      type(simulation_t), intent(inout) :: simulation
      type(group_t) :: group
      character(len=:), allocatable :: fault
      integer :: index

      if (.not. (deck%sound("grid") .and. deck%sound("method"))) return
      do index = 1, size(simulation%materials)
         associate (failure => simulation%materials(index)%failure)
            if (.not. (allocated(failure%softening) .and. deck%sound("material", index))) cycle
            failure%softening%width = simulation%method%band_width()
            fault = failure%softening%band_fault(simulation%grid%spacing, &
               simulation%grid%dimensions)
         end associate
         if (len(fault) == 0) cycle
         group = deck%group("material", index)
         call deck%complain(group, fault, "fracture_energy")
      end do
   end subroutine set_crack_bands

   !> The bodies.
   subroutine read_bodies(deck, simulation, shapes, bodies)
      type(deck_t), intent(inout) :: deck            !! The deck, collects complaints
      type(simulation_t), intent(in) :: simulation   !! Materials and grid
      type(named_shape_t), intent(in) :: shapes(:)   !! The regions
      type(body_t), allocatable, intent(out) :: bodies(:)
      type(group_t) :: group
      character(len=:), allocatable :: region, material, packing
      integer :: index

      allocate (bodies(deck%count("body")))
      do index = 1, size(bodies)
         group = deck%group("body", index)
         associate (body => bodies(index))
            call group%get("name", body%name)
            call group%get("region", region)
            call group%get("material", material)
            body%region = deck%named("region", region)
            body%shape = shapes(body%region)%shape
            body%store = max(deck%named("material", material), 1)
            call group%get("ppc", body%per_cell)
            call group%get("packing", packing)
            body%cut = packing == "cut"
            body%jitter = packing == "jitter"
            call read_velocity(group, body)
            call group%get("spin", body%spin)
            call group%get("temperature", body%temperature)
            if (deck%sound("material", body%store)) &
               call read_energy(deck, group, simulation%materials(body%store), body)
            body%density = simulation%materials(body%store)%density
            where (.not. simulation%grid%active)
               body%per_cell = 1
               body%velocity = 0.0_wp
            end where
            if (packing == "poisson_disk") call pack_disks(deck, simulation%grid, index, body)
            call read_points(deck, simulation, group, shapes(body%region), body)
            if (deck%sound("material", body%store)) &
               call read_lithostatic(deck, simulation, group, body)
         end associate
      end do
   end subroutine read_bodies

   !> Velocity by its components, or by speed and direction, and formulas of what is added.
   subroutine read_velocity(group, body)
      type(group_t), intent(in) :: group             !! The &body
      type(body_t), intent(inout) :: body            !! Gets its velocity
      real(wp) :: direction(3), speed

      call group%get("velocity", body%velocity)
      if (group%given("speed")) then
         call group%get("speed", speed)
         call group%get("direction", direction)
         direction = direction/maxval(abs(direction))
         body%velocity = speed*(direction/norm2(direction))
      end if
      if (group%given("velocity_formula")) call group%list("velocity_formula", body%formula)
   end subroutine read_velocity

   !> Particles at random places, no two of them near each other.
   subroutine pack_disks(deck, grid, index, body)
      type(deck_t), intent(in) :: deck               !! The deck
      type(grid_t), intent(in) :: grid               !! The grid
      integer, intent(in) :: index                   !! Number of the body
      type(body_t), intent(inout) :: body            !! Gets its particles
      type(group_t) :: group
      type(disks_t) :: disks
      integer :: seed

      group = deck%group("run")
      call group%get("seed", seed)
      call start_disks(disks, grid, product(body%per_cell), int(seed, int64), int(index, int64))
      allocate (body%given, source=disks)
   end subroutine pack_disks

   !> Particles of a list, where region and packing say so, and what they take from it.
   subroutine read_points(deck, simulation, group, shape, body)
      type(deck_t), intent(inout) :: deck            !! The deck, collects complaints
      type(simulation_t), intent(in) :: simulation   !! Materials and grid
      type(group_t), intent(in) :: group             !! The &body
      type(named_shape_t), intent(in) :: shape       !! Its region
      type(body_t), intent(inout) :: body            !! Gets its particles
      character(len=:), allocatable :: packing, stress
      type(traits_t) :: traits

      call group%get("packing", packing)
      call group%get("initial_stress", stress)
      body%keeps_stress = stress == "file"
      if (allocated(shape%points) .neqv. packing == "file") then
         if (packing == "file") call deck%complain(group, "packing = 'file' needs a region of "// &
            "shape = 'points'", "packing")
         if (packing /= "file") call deck%complain(group, "its region is a list of points; "// &
            "write packing = 'file'", "packing")
      else if (allocated(shape%points)) then
         call pack_points(deck, simulation%grid, simulation%boundary, group, shape%points, body)
         call simulation%method%request(traits)
         call compare_fields(deck, group, simulation%materials(body%store), traits, shape%points, &
            body%keeps_stress)
      else if (body%keeps_stress) then
         call deck%complain(group, "initial_stress = 'file' needs packing = 'file' and a "// &
            "snapshot of another run", "initial_stress")
      end if
   end subroutine read_points

   !> Internal energy at the start, of a material that carries it.
   subroutine read_energy(deck, group, material, body)
      type(deck_t), intent(inout) :: deck            !! The deck, collects complaints
      type(group_t), intent(in) :: group             !! The &body
      type(material_t), intent(in) :: material       !! Its material
      type(body_t), intent(inout) :: body            !! Gets the energy

      call group%get("specific_energy", body%energy)
      if (body%energy > 0.0_wp .and. .not. material%carries_energy()) call deck%complain(group, &
         "material '"//material%name//"' carries no internal energy; remove specific_energy or "// &
         "choose an eos_model that depends on it", "specific_energy")
   end subroutine read_energy
end module scene_build
