! SPDX-License-Identifier: BSD-3-Clause
!> Sets up a simulation without particles from a deck that `check_deck` has checked. `program_plan`
!! calls it for a run and for `--check`; then `scene_first_state` adds the particles.
module scene_setup
   use base_kinds, only: wp
   use deck_reader, only: deck_t, group_t
   use material_kinds, only: kinds_of
   use material_record, only: read_record
   use particle_body, only: body_t
   use scene_absorbing, only: read_absorbing
   use scene_bodies, only: read_bodies
   use scene_boundary, only: read_boundaries, read_walls
   use scene_cell, only: read_cell, refuse_effects
   use scene_contact, only: read_contact
   use scene_detonation, only: read_detonations
   use scene_effects, only: read_effects
   use scene_exact, only: read_exact
   use scene_grid, only: check_periodic, read_grid, tile_edge
   use scene_inflow, only: read_inflows
   use scene_load, only: read_loads
   use scene_material, only: read_material
   use scene_method, only: read_method
   use scene_particles, only: make_stores, prepare_simulation
   use scene_points_clock, only: check_clocks
   use scene_regions, only: named_shape_t, read_shapes
   use scene_time, only: read_bounds
   use scene_without_effect, only: warn_without_effect
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: set_up_scene

contains

   !> Build grid, faces, materials, method and bodies; particles come later. Errors go into the
   !! deck's list of problems. Parts that do not depend on them are built and checked nevertheless,
   !! so that one pass reports as many errors as possible: bodies are then allocated if their
   !! positions are valid, and stores if nothing that they depend on has an error.
   subroutine set_up_scene(deck, simulation, bodies, shapes)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(simulation_t), intent(inout) :: simulation
      type(body_t), allocatable, intent(out) :: bodies(:) !! Simulation to build
      type(named_shape_t), allocatable, intent(out) :: shapes(:)
      integer :: n

      call read_materials(deck, simulation)
      call read_method(simulation%scheme%method, deck, &
         kinds_of(simulation%materials))
      call read_bounds(deck, simulation%clock%guard%bounds, simulation%scheme%method%cfl)
      call read_grid(deck, simulation%space%grid)
      call set_crack_bands(deck, simulation)
      if (.not. (deck%sound("run") .and. deck%sound("grid") .and. deck%sound("method") .and. &
         deck%sound("effects") .and. deck%sound("boundary"))) return
      if (deck%sound("material")) then
         call check_method(deck, simulation)
      end if
      call read_boundaries(deck, simulation)
      simulation%space%grid%margin = simulation%scheme%method%margin()
      simulation%space%grid%reaches = merge(2, 1, simulation%scheme%method%dual)
      call simulation%space%grid%start(tile_edge(deck))
      call finish_materials(deck, simulation)
      call check_periodic(deck, simulation%space%grid)
      call read_effects(deck, simulation)
      call read_cell(deck, simulation)
      if (.not. deck%sound("region")) return
      call read_shapes(deck, simulation%machine%communicator, simulation%space%grid, shapes)
      if (.not. (deck%sound("region") .and. deck%sound("body") .and. deck%count("body") > 0)) return
      call read_bodies(deck, simulation, shapes, bodies)
      call read_walls(deck, simulation, shapes)
      if (is_sound(deck)) call read_inflows(deck, simulation, bodies)
      ! errors in groups that the stores do not depend on, such as &time, do not stop these checks
      if (.not. is_sound(deck)) return
      call read_absorbing(deck, simulation, bodies)
      if (.not. is_sound(deck)) return
      call read_contact(deck, simulation, bodies)
      if (.not. is_sound(deck)) return
      call read_loads(deck, simulation, bodies, shapes)
      if (.not. is_sound(deck)) return
      call read_exact(deck, simulation, bodies)
      call refuse_effects(deck, simulation)
      if (.not. is_sound(deck)) return
      call read_detonations(deck, simulation, bodies)
      if (.not. is_sound(deck)) return
      call check_clocks(deck, simulation, bodies, shapes)
      call prepare_simulation(simulation)
      allocate (simulation%body_names(size(bodies)))
      do n = 1, size(bodies)
         simulation%body_names(n)%text = bodies(n)%name
      end do
      call make_stores(simulation, size(bodies) > 1)
      call warn_without_effect(deck, simulation)
   end subroutine set_up_scene

   !> True if no group has an error on which bodies and the fields of their particles depend.
   logical function is_sound(deck) result(sound)
      type(deck_t), intent(in) :: deck
      character(len=10), parameter :: groups(15) = [character(len=10) :: "load", "run", "grid", &
         "method", "effects", "boundary", "material", "region", "body", "contact", "exact", &
         "detonation", "cell", "stage", "inflow"]
      integer :: n

      sound = .true.
      do n = 1, size(groups)
         sound = sound .and. deck%sound(trim(groups(n)))
      end do
   end function is_sound

   !> What the method needs of the materials: internal energy for an artificial heat flux, and the
   !! dual gradient for the fill of nodes, which corrects volumes.
   subroutine check_method(deck, simulation)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(simulation_t), intent(in) :: simulation   !! The run, materials and method are read
      integer :: n

      do n = 1, size(simulation%materials)
         if (simulation%scheme%method%dual) exit
         if (simulation%materials(n)%repacks) call deck%add_error("material", n, &
            "volume_from = 'grid' needs method = 'ddmp' in &run; remove it [D316]", "volume_from")
      end do
      if (.not. simulation%scheme%method%heat_flux > 0.0_wp) return
      do n = 1, size(simulation%materials)
         if (simulation%materials(n)%carries_energy()) return
      end do
      call deck%add_error(deck%group("method", 1), "no material has an internal energy; "// &
         "remove heat_flux [D318]", "heat_flux")
   end subroutine check_method

   !> The materials.
   subroutine read_materials(deck, simulation)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(simulation_t), intent(inout) :: simulation
      integer :: index

      allocate (simulation%materials(deck%count("material")))
      do index = 1, size(simulation%materials)
         call read_material(deck, simulation%machine%communicator, index, &
            simulation%materials(index))
      end do
      simulation%materials%record = read_record(deck)
   end subroutine read_materials

   !> What materials need of method and grid: the artificial viscosity, whose defaults depend on the
   !! method, and, for random strength, the directions that are computed.
   subroutine finish_materials(deck, simulation)
      type(deck_t), intent(in) :: deck
      type(simulation_t), intent(inout) :: simulation
      type(group_t) :: group, own
      integer :: index

      group = deck%group("method", 1)
      do index = 1, size(simulation%materials)
         associate (material => simulation%materials(index), grid => simulation%space%grid)
            if (allocated(material%viscosity)) then
               call group%get("bulk_q1", material%viscosity%linear)
               own = deck%group("material", index)
               if (own%known("bulk_q1")) call own%get("bulk_q1", material%viscosity%linear)
               call group%get("bulk_q2", material%viscosity%quadratic)
               material%viscosity%limited = simulation%scheme%method%limited
            end if
            material%failure%flaws%active = grid%active
            material%failure%flaws%axisymmetric = grid%axisymmetric
            material%failure%flaws%depth = grid%depth
         end associate
      end do
   end subroutine finish_materials

   !> Set the width of crack bands, and check that cells are small enough for them.
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
            failure%softening%width = simulation%scheme%method%band_width()
            fault = failure%softening%band_fault(simulation%space%grid%spacing, &
               simulation%space%grid%dimensions)
         end associate
         if (len(fault) == 0) cycle
         group = deck%group("material", index)
         call deck%add_error(group, fault, "fracture_energy")
      end do
   end subroutine set_crack_bands
end module scene_setup
