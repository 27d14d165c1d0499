! SPDX-License-Identifier: BSD-3-Clause
!> The group &exact of a deck: the exact solution, and the bodies that follow it.
module scene_exact
   use base_kinds, only: wp
   use base_text, only: text_t
   use deck_reader, only: deck_t, group_t
   use deck_schema, only: schema_t
   use exact_catalogue, only: choose_exact, exact_names
   use exact_solution, only: exact_t
   use particle_body, only: body_t
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: declare_exact, read_exact

contains

   !> Declare the keys of &exact: those of all solutions, and those of each.
   subroutine declare_exact(schema)
      type(schema_t), intent(inout) :: schema        !! Keys of the deck
      class(exact_t), allocatable :: solution
      character(len=:), allocatable :: owner
      integer :: n

      owner = "solution ="
      do n = 1, size(exact_names)
         owner = owner//" "//trim(exact_names(n))
      end do
      call schema%group("exact", "an exact solution, which sets the initial state and, if it "// &
         "is manufactured, a body force; histories then contain the errors")
      call schema%text("exact", "solution", "name of the solution", default="none", words="none")
      call schema%words("exact", "solution", exact_names)
      call schema%text("exact", "bodies(:40)", "bodies that follow the solution; default: all", &
         owner=owner)
      call schema%refer("exact", "bodies", "body")
      call schema%real("exact", "origin(3)", "origin of the coordinates of the solution", &
         unit="m", default="0 0 0", owner=owner)
      do n = 1, size(exact_names)
         call choose_exact(exact_names(n), solution)
         call solution%declare(schema)
      end do
      call schema%forbid_change("exact", "*", "the first state of the run followed this solution")
   end subroutine declare_exact

   !> Read the solution, if there is one, and check that it fits the scene.
   subroutine read_exact(deck, simulation, bodies)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(simulation_t), intent(inout) :: simulation !! Gets the solution
      type(body_t), intent(in) :: bodies(:)
      type(group_t) :: group
      character(len=:), allocatable :: name
      logical :: follows(size(bodies))
      integer :: n

      group = deck%group("exact")
      call group%get("solution", name)
      if (name == "none") return
      if (simulation%space%grid%axisymmetric) then
         call deck%add_error(group, "no exact solution is axisymmetric; write dimension = '1d', "&
            //"'plane_strain' or '3d' in &run [D352]", "solution")
         return
      end if
      if (allocated(simulation%scheme%method%splitting)) call deck%add_error(group, &
         "particles that are split have no reference position; write split = .false. in "// &
         "&method [D352]", "solution")
      call find_followers(deck, group, bodies, follows)
      allocate (simulation%effects%exact)
      allocate (simulation%effects%exact%material(size(simulation%materials)))
      do n = 1, size(simulation%materials)
         if (any(follows .and. bodies%store == n)) call read_solution(deck, group, name, n, &
            simulation)
      end do
   end subroutine read_exact

   !> Bodies that follow the solution. Other bodies must not have their materials, because the body
   !! force and the errors are those of whole materials.
   subroutine find_followers(deck, group, bodies, follows)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(group_t), intent(in) :: group             !! &exact
      type(body_t), intent(in) :: bodies(:)
      logical, intent(out) :: follows(:)             !! (body)
      type(text_t), allocatable :: names(:)
      type(group_t) :: body
      integer :: n, other

      call group%list("bodies", names)
      follows = size(names) == 0
      do n = 1, size(names)
         other = deck%named("body", names(n)%text)
         if (other > 0) follows(other) = .true.
      end do
      do n = 1, size(bodies)
         if (.not. follows(n)) then
            if (any(follows .and. bodies%store == bodies(n)%store)) call deck%add_error("body", n, &
               "has the same material as a body in &exact; add it to bodies of &exact, or "// &
               "give it a separate &material [D344]", "material")
            cycle
         end if
         body = deck%group("body", n)
         if (body%given("velocity") .and. any(abs(bodies(n)%velocity) > 0.0_wp)) &
            call deck%add_error(body, "&exact gives the velocity; remove it here [D342]", &
            "velocity")
         if (body%given("spin") .and. any(abs(bodies(n)%spin) > 0.0_wp)) &
            call deck%add_error(body, "&exact gives the rotation; remove spin [D342]", "spin")
      end do
   end subroutine find_followers

   !> The solution in one material.
   subroutine read_solution(deck, group, name, place, simulation)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(group_t), intent(in) :: group             !! &exact
      character(len=*), intent(in) :: name           !! Name of the solution
      integer, intent(in) :: place                   !! Number of the material
      type(simulation_t), intent(inout) :: simulation !! Gets the solution
      class(exact_t), allocatable :: solution
      type(group_t) :: material
      character(len=:), allocatable :: law, text
      logical :: elastic

      call choose_exact(name, solution)
      material = deck%group("material", place)
      law = ""
      if (allocated(simulation%materials(place)%law)) call material%get("strength_model", law)
      solution%hyperelastic = .false.
      elastic = .true.
      if (allocated(simulation%materials(place)%law)) then
         elastic = .not. simulation%materials(place)%law%is_plastic()
         solution%hyperelastic = elastic .and. simulation%materials(place)%law%gives_whole_stress()
      end if
      solution%density = simulation%materials(place)%density
      solution%shear = simulation%materials(place)%shear
      solution%lambda = simulation%materials(place)%bulk - 2.0_wp/3.0_wp*solution%shear
      solution%dimensions = simulation%space%grid%dimensions
      call group%get("origin", solution%origin)
      call solution%read(group)
      text = solution%fault()
      if (len(text) > 0) call deck%add_error(group, "solution = '"//name//"' "//text, "solution")
      text = solution%law()
      if (len(text) > 0 .and. law /= text) then
         call deck%add_error(material, "solution = '"//name//"' of &exact holds for "// &
            "strength_model = '"//text//"' only [D341]", "strength_model")
      else if (.not. elastic) then
         call deck%add_error(material, "exact solutions are elastic; write strength_model = "// &
            "'elastic' or 'neo_hookean' [D352]", "strength_model")
      end if
      simulation%effects%exact%forced = simulation%effects%exact%forced .or. solution%forced()
      call move_alloc(solution, simulation%effects%exact%material(place)%solution)
   end subroutine read_solution
end module scene_exact
