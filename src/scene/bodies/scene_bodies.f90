! SPDX-License-Identifier: BSD-3-Clause
!> The group &body: its keys, their checks, and the bodies that they describe.
module scene_bodies
   use base_kinds, only: int64, wp
   use base_text, only: brief
   use deck_reader, only: deck_t, group_t
   use deck_schema, only: schema_t
   use material_type, only: material_t
   use particle_body, only: body_t
   use particle_disks, only: disks_t, start_disks
   use particle_store, only: traits_t
   use scene_dimension, only: check_plane
   use scene_lithostatic, only: read_lithostatic
   use scene_points, only: compare_fields, pack_points
   use scene_regions, only: named_shape_t
   use scene_unit_warnings, only: check_kelvin
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: check_bodies, declare_body, read_bodies

contains

   !> Declare &body.
   subroutine declare_body(schema)
      type(schema_t), intent(inout) :: schema            !! Keys of the deck

      call schema%group("body", "one body, a region filled with particles of a material", &
         many=.true.)
      call schema%text("body", "name", "name of the body, in outputs")
      call schema%text("body", "region", "region that the body fills")
      call schema%text("body", "material", "material of the body")
      call schema%integer("body", "ppc(3)", "particles per cell along x, y, z", default="2 2 2", &
         range="> 0 <= 16")
      call schema%text("body", "packing", "placement of particles: lattice, the lattice sites "// &
         "inside the region; cut, a lattice whose particles at the surface have the volume and "// &
         "centre of the part inside; jitter, a lattice with random displacements of up to a "// &
         "quarter of the spacing; poisson_disk, random with a least distance; file, the points "// &
         "of the region", default="lattice", words="lattice cut jitter poisson_disk file")
      call schema%text("body", "initial_stress", "initial stress: zero; lithostatic, from the "// &
         "weight of the material above, down to a gap; file, from the snapshot that gives the "// &
         "particles", default="zero", words="zero lithostatic file")
      call schema%real("body", "k0", &
         "coefficient of lateral pressure: stress across gravity over stress along gravity", &
         default="0.5", range=">= 0", owner="initial_stress = lithostatic")
      call schema%real("body", "velocity(3)", "initial velocity of the centre of mass", &
         unit="m/s", default="0 0 0")
      call schema%real("body", "speed", &
         "initial speed of the centre of mass along direction, instead of velocity", unit="m/s", &
         range=">= 0")
      call schema%real("body", "direction(3)", &
         "direction of speed, of any length; for an angle a: sind(a), 0, cosd(a) in braces")
      call schema%text("body", "velocity_formula(3)", "components of a velocity that is added, "// &
         "as formulas of the initial position x, y, z, such as '100*x', '0', '-100*z'", unit="m/s")
      call schema%integer("body", "repeat(3)", "number of copies along x, y, z; the copies are "// &
         "called NAME_1, NAME_2 and so on", default="1 1 1", range=">= 1 <= 10000")
      call schema%real("body", "repeat_step(3)", "distance from one copy to the next along x, "// &
         "y, z", unit="m", default="0 0 0")
      call schema%real("body", "spin(3)", "initial angular velocity about the centre of mass", &
         unit="1/s", default="0 0 0")
      call schema%real("body", "temperature", "initial temperature; a solid or liquid has "// &
         "expanded since t_ref and has no pressure, a gas has the density of the material; "// &
         "default: that of specific_energy, else t_ref", unit="K", range=">= 0", &
         owner="effects.thermal")
      call schema%real("body", "specific_energy", &
         "initial internal energy per mass, for materials that have one", unit="J/kg", &
         default="0.0", range=">= 0")
      call schema%integer("body", "field", "velocity field: bodies with the same number "// &
         "stick together where they meet; 0 = a separate field", default="0", range=">= 0", &
         owner="effects.contact")
      call schema%require("body", "name region material")
      call schema%refer("body", "region", "region")
      call schema%refer("body", "material", "material")
      call schema%forbid_change("body", "* + -", "the particles of the checkpoint "// &
         "were made from it")
   end subroutine declare_body

   !> Check that there are bodies, and the velocity, spin and temperature of each.
   subroutine check_bodies(deck)
      type(deck_t), intent(inout) :: deck                !! Collects errors
      character(len=:), allocatable :: dimension
      type(group_t) :: body, run
      real(wp) :: spin(3)
      integer :: i

      run = deck%group("run")
      call run%get("dimension", dimension)
      if (deck%count("body") == 0) call deck%add_error("body", 1, &
         "there is no body, so nothing to compute [D403]")
      do i = 1, deck%count("body")
         body = deck%group("body", i)
         call check_plane(deck, body, "velocity")
         call check_plane(deck, body, "direction")
         call check_plane(deck, body, "repeat_step")
         call check_speed(deck, body)
         ! in a plane or on a line bodies turn only in the plane
         if (dimension /= "3d" .and. body%given("spin") .and. body%known("spin")) then
            call body%get("spin", spin)
            if (dimension == "plane_strain") spin(2) = 0.0_wp
            if (any(abs(spin) > 0.0_wp)) call deck%add_error(body, &
               "spin leaves the plane of dimension = '"// &
               dimension//"'; bodies rotate only in plane_strain, about y [D333]", "spin")
         end if
         call check_kelvin(deck, body, "temperature")
      end do
   end subroutine check_bodies

   !> A speed needs a direction and replaces a velocity.
   subroutine check_speed(deck, body)
      type(deck_t), intent(inout) :: deck
      type(group_t), intent(in) :: body                  !! The &body
      real(wp) :: direction(3), velocity(3)

      if (.not. body%valid([character(len=9) :: "velocity", "speed", "direction"])) return
      if (body%given("speed") .neqv. body%given("direction")) then
         call deck%add_error(body, "speed and direction belong together; give both, or "// &
            "velocity [D205]", merge("speed    ", "direction", body%given("speed")))
      else if (body%given("speed")) then
         ! an echo of the deck contains the default, a velocity of zero
         call body%get("velocity", velocity)
         call body%get("direction", direction)
         if (any(abs(velocity) > 0.0_wp)) call deck%add_error(body, &
            "speed and velocity are both given; keep one [D205]", "speed")
         if (.not. any(abs(direction) > 0.0_wp)) call deck%add_error(body, &
            "direction must not be 0 in all components [D205]", "direction")
      end if
   end subroutine check_speed

   !> The bodies.
   subroutine read_bodies(deck, simulation, shapes, bodies)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(simulation_t), intent(in) :: simulation   !! Materials and grid
      type(named_shape_t), intent(in) :: shapes(:)
      type(body_t), allocatable, intent(out) :: bodies(:) !! In the order of the deck
      type(group_t) :: group, run
      character(len=:), allocatable :: region, material, packing
      integer :: index, seed
      real(wp) :: direction(3), speed
      type(disks_t) :: disks

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
            ! velocity from components, or from speed and direction, and formulas of an added
            ! velocity
            call group%get("velocity", body%velocity)
            if (group%given("speed")) then
               call group%get("speed", speed)
               call group%get("direction", direction)
               direction = direction/maxval(abs(direction))
               body%velocity = speed*(direction/norm2(direction))
            end if
            if (group%given("velocity_formula")) call group%list("velocity_formula", body%formula)
            call group%get("spin", body%spin)
            body%density = simulation%materials(body%store)%density
            if (deck%sound("material", body%store)) &
               call read_heat(deck, group, simulation%materials(body%store), body)
            where (.not. simulation%space%grid%active)
               body%per_cell = 1
               body%velocity = 0.0_wp
            end where
            ! random positions with a least distance between them
            if (packing == "poisson_disk") then
               run = deck%group("run")
               call run%get("seed", seed)
               call start_disks(disks, simulation%space%grid, product(body%per_cell), int(seed, &
                  int64), int(index, int64))
               allocate (body%given, source=disks)
            end if
            call read_points(deck, simulation, group, shapes(body%region), body)
            if (deck%sound("material", body%store)) &
               call read_lithostatic(deck, simulation, group, body)
         end associate
      end do
   end subroutine read_bodies

   !> Particles from a list, if region and packing request it, and the fields that the list gives.
   subroutine read_points(deck, simulation, group, shape, body)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(simulation_t), intent(in) :: simulation   !! Materials and grid
      type(group_t), intent(in) :: group             !! The &body
      type(named_shape_t), intent(in) :: shape       !! Shape of the region
      type(body_t), intent(inout) :: body            !! Gets its particles
      character(len=:), allocatable :: packing, stress
      type(traits_t) :: traits

      call group%get("packing", packing)
      call group%get("initial_stress", stress)
      body%keeps_stress = stress == "file"
      if (allocated(shape%points) .neqv. packing == "file") then
         if (packing == "file") call deck%add_error(group, "packing = 'file' needs a region of "// &
            "shape = 'points' [D356]", "packing")
         if (packing /= "file") call deck%add_error(group, "its region is a list of points; "// &
            "write packing = 'file' [D422]", "packing")
      else if (allocated(shape%points)) then
         call pack_points(deck, simulation%space%grid, simulation%space%boundary, group, &
            shape%points, body)
         call simulation%scheme%method%request(traits)
         call compare_fields(deck, group, simulation%materials(body%store), traits, shape%points, &
            body%keeps_stress)
      else if (body%keeps_stress) then
         call deck%add_error(group, "initial_stress = 'file' needs packing = 'file' and a "// &
            "snapshot of another run [D356]", "initial_stress")
      end if
   end subroutine read_points

   !> Internal energy, temperature and density at the start, of a material that carries them.
   subroutine read_heat(deck, group, material, body)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(group_t), intent(in) :: group             !! The &body
      type(material_t), intent(in) :: material       !! Material of the body
      type(body_t), intent(inout) :: body            !! Gets energy and temperature
      real(wp), parameter :: difference = 0.01_wp    ! of the temperatures that is a contradiction
      real(wp) :: of_energy

      call group%get("specific_energy", body%energy)
      if (body%energy > 0.0_wp .and. .not. material%carries_energy()) call deck%add_error(group, &
         "material '"//material%name//"' has no internal energy; remove specific_energy, or "// &
         "choose an eos_model that depends on the energy [D310]", "specific_energy")
      if (.not. allocated(material%heat)) return
      body%temperature = material%heat%reference
      if (group%given("temperature")) call group%get("temperature", body%temperature)
      if (.not. body%energy > 0.0_wp) body%density = material%free_density(body%temperature)
      of_energy = material%temperature_of(body%energy)
      if (.not. (body%energy > 0.0_wp .and. of_energy >= 0.0_wp)) return
      if (.not. group%given("temperature")) then
         body%temperature = of_energy
      else if (abs(of_energy - body%temperature) > difference*body%temperature) then
         call deck%warn(group, "specific_energy sets the pressure and belongs to "// &
            brief(of_energy)//" K, not to temperature = "//brief(body%temperature)// &
            " K; remove one of the two [D450]", "temperature")
      end if
   end subroutine read_heat
end module scene_bodies
