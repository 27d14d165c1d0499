! SPDX-License-Identifier: BSD-3-Clause
!> The group &method: its keys and the method that they select.
module scene_method
   use base_kinds, only: wp
   use ddmp_alpha, only: alpha_names
   use ddmp_catalogue, only: quadrature_names
   use ddmp_dual, only: surface_names
   use deck_reader, only: deck_t, group_t
   use deck_schema, only: changes_physics, schema_t
   use material_kinds, only: kinds_t
   use scene_method_defaults, only: set_method_defaults
   use scene_dimension, only: is_dual
   use step_method, only: method_t, position_of, stress_after, stress_names
   use transfer_basis, only: basis_t
   use transfer_catalogue, only: basis_names, choose_basis, choose_velocity, velocity_names
   use transfer_shock_compression, only: monotone
   use transfer_velocity, only: velocity_t
   implicit none
   private

   public :: declare_method, read_method

contains

   !> Declare the keys of &method that are not those of materials.
   subroutine declare_method(schema)
      type(schema_t), intent(inout) :: schema        !! Keys of the deck
      class(velocity_t), allocatable :: transfer
      character(len=:), allocatable :: turning
      integer :: n

      call schema%group("method", "numerical method")
      call schema%text("method", "basis", "shape functions; ddmp needs linear", default="linear")
      call schema%words("method", "basis", basis_names)
      call schema%text("method", "transfer", "transfer of velocity between particles and "// &
         "nodes; default: rflip with ddmp, flip with mpm and where stress_update is usavg in "// &
         "axisymmetry", default="rflip")
      call schema%words("method", "transfer", velocity_names)
      turning = "transfer ="
      do n = 1, size(velocity_names)
         call choose_velocity(velocity_names(n), transfer)
         call transfer%declare(schema)
         if (transfer%turning()) turning = turning//" "//trim(velocity_names(n))
      end do
      call schema%logical("method", "paper", &
         "use the scheme of LA-UR-11-06616 (2011); it fixes the other keys of the scheme", &
         default=".false.", owner="run.method = ddmp")
      call schema%text("method", "alpha", "weight alpha of the gradient in the own cell: "// &
         "split, one bubble function per direction; product, their product; bubble_squared, "// &
         "the square of the product", default="split", owner="run.method = ddmp")
      call schema%words("method", "alpha", alpha_names)
      call schema%real("method", "alpha_0", "alpha at the centre of a cell", default="1.0", &
         range=">= 0 <= 1", owner="run.method = ddmp")
      call schema%text("method", "blend", "interpolation of the node gradient; smooth has no "// &
         "kinks; default: smooth with alpha = 'split', linear with others and in axisymmetry", &
         words="smooth linear", owner="run.method = ddmp")
      call schema%text("method", "free_surface", "cell weights of the dual gradient: fill, the "// &
         "least fill of the nodes; cells, 1 in cells without an empty node; none, 1 everywhere", &
         default="fill", owner="run.method = ddmp")
      call schema%words("method", "free_surface", surface_names)
      call schema%text("method", "quadrature", "where the dual gradient is evaluated: "// &
         "point, at the particle; sub_points, mean over points of its box; control, at the "// &
         "particle, for the stress less a mean stress of the nodes; default: control where all "// &
         "material is elastic and stress_update is usavg, not in axisymmetry, else point", &
         default="point", owner="run.method = ddmp")
      call schema%words("method", "quadrature", quadrature_names)
      call schema%text("method", "normalise", "divide sums over particles by the sums of their "// &
         "weights, so that uniform pressure exerts no force: gases, in gases and explosives; "// &
         "fluids, in all material without strength; "// &
         "none; all; default: none where the quadrature of the dual gradient forbids it", &
         words="gases fluids none all", default="gases", owner="run.method = ddmp")
      call declare_strain(schema, turning)
      call schema%text("method", "antilock", "treatment of volumetric locking; bbar: the "// &
         "particles of a material in a cell have a common mean dilatation and pressure", &
         default="none", words="none bbar")
      call declare_shocks(schema)
      call declare_split(schema)
      call schema%allow_change("method", "# transfer alpha blend free_surface "// &
         "normalise turn_from antilock viscosity_limiter split split_what split_max", &
         changes_physics)
      call schema%forbid_change("method", "basis paper quadrature stress_update", &
         "the fields and velocities of the checkpoint belong to this scheme")
   end subroutine declare_method

   !> Declare the splitting of particles.
   subroutine declare_split(schema)
      type(schema_t), intent(inout) :: schema        !! Keys of the deck

      call schema%logical("method", "split", "halve particles that have become long, so that "// &
         "stretched material stays connected; default: .true. where all material is gas with "// &
         "normalised sums, and for gases alone where a scene has gases and other material", &
         default=".false.")
      call schema%text("method", "split_what", "which particles are halved: all, those of "// &
         "every material; gases, those of gases and products of explosives", default="all", &
         words="all gases", owner="split")
      call schema%real("method", "split_at", &
         "edge length of a particle, in cells, at which it is halved", default="0.55", &
         range="> 0 <= 2", owner="split")
      call schema%integer("method", "split_max", &
         "greatest number of times that a particle and its parts are halved", default="10", &
         range="> 0 <= 20", owner="split")
   end subroutine declare_split

   !> Declare the keys of the strain update and of the rotation of particles.
   subroutine declare_strain(schema, turning)
      type(schema_t), intent(inout) :: schema        !! Keys of the deck
      character(len=*), intent(in) :: turning        !! Condition: particles carry a rotation

      call schema%text("method", "stress_update", "when the stress is updated: usl after the "// &
         "step, usf before it, musl after mapping the new velocities; usavg uses the average "// &
         "of both maps, which conserves energy; default with ddmp: usavg where some material "// &
         "has no internal energy, none is loose or a gas and no key excludes it, else usl, or "// &
         "musl with transfer = apic or aflip and where elastic bodies have contact; with mpm: "// &
         "musl", &
         words="usl usf musl usavg")
      call schema%text("method", "turn_from", "rotation used by rflip: point, that of the "// &
         "velocity at the particle; tiles, the mean over the surrounding tiles, which "// &
         "conserves the energy of thin bodies; default: tiles with stress_update = 'usavg'", &
         default="point", words="point tiles", owner=turning)
   end subroutine declare_strain

   !> Declare the keys of artificial viscosity and heat flux that concern nodes.
   subroutine declare_shocks(schema)
      type(schema_t), intent(inout) :: schema        !! Keys of the deck

      call schema%text("method", "viscosity_limiter", "part of the compression that artificial "// &
         "viscosity resists: smooth, the compression less the part that the surrounding node "// &
         "gradients predict, so that smoothly converging flow is not heated; monotone, less of "// &
         "slopes that change evenly; none, all of it; default: monotone with metals and other "// &
         "condensed material that has an internal energy, smooth where stress_update is usavg "// &
         "by default and some material is not elastic", &
         default="none", words="none smooth monotone", &
         owner="effects.artificial_viscosity & run.method = ddmp")
      call schema%real("method", "heat_flux", &
         "coefficient of an artificial heat flux in shocks, about 2, against wall heating", &
         default="0", range=">= 0 <= 100", owner="effects.artificial_viscosity")
   end subroutine declare_shocks

   !> Make the method from the deck.
   subroutine read_method(method, deck, kinds)
      type(method_t), intent(inout) :: method
      type(deck_t), intent(inout) :: deck            !! The deck, gets defaults and complaints
      type(kinds_t), intent(in) :: kinds           !! Kinds of the materials
      type(group_t) :: group
      character(len=:), allocatable :: word, basis, quadrature
      class(basis_t), allocatable :: functions
      logical :: linear

      call set_method_defaults(deck, kinds)
      group = deck%group("method", 1)
      call group%get("basis", basis)
      call group%get("quadrature", quadrature)
      call method%choose(is_dual(deck), basis, quadrature)
      ! a quadrature may have replaced the functions of the method
      call choose_basis(basis, functions)
      linear = .false.
      if (allocated(functions)) linear = functions%is_linear()
      if (method%dual .and. .not. linear .and. group%valid(["basis"])) &
         call deck%add_error(group, &
         "basis = '"//basis//"' needs method = 'mpm' in &run; ddmp has linear functions [D311]", &
         "basis")
      if (method%dual) call read_dual(method, deck, group)
      call group%get("stress_update", word)
      method%stress = max(position_of(word, stress_names), 1)
      call group%get("transfer", word)
      call choose_velocity(word, method%transfer)
      if (.not. allocated(method%transfer)) call choose_velocity("flip", method%transfer)
      call method%transfer%read(deck, group)
      if (linear .and. .not. method%dual) call warn_of_linear(method, deck, group, word)
      if (method%dual .and. method%stress == stress_after .and. method%transfer%affine() .and. &
         .not. method%transfer%turning()) call deck%warn(group, "transfer = '"//word//"' with "// &
         "stress_update = 'usl' gains energy without bound where bodies vibrate; remove "// &
         "stress_update [D355]", "stress_update")
      if (method%transfer%turning()) then
         call group%get("turn_from", word)
         method%smooth_turn = word == "tiles"
      end if
      call group%get("antilock", word)
      method%even = word == "bbar"
      call group%get("heat_flux", method%heat_flux)
      call group%get("viscosity_limiter", word)
      method%limited = method%dual .and. word /= "none"
      if (word == "monotone") method%slack = monotone
      call read_splitting(method, group)
   end subroutine read_method

   !> Warn of combinations with plain linear functions that gain energy without bound, because the
   !! force jumps where particles cross cells (test/verify/matrix).
   subroutine warn_of_linear(method, deck, group, transfer)
      type(method_t), intent(in) :: method
      type(deck_t), intent(inout) :: deck            !! Gets the warning
      type(group_t), intent(in) :: group             !! &method
      character(len=*), intent(in) :: transfer       !! Word of the deck

      if (method%transfer%affine() .and. .not. method%transfer%turning()) then
         call deck%warn(group, "linear functions with transfer = '"//transfer// &
            "' gain energy without bound; write basis = 'quadratic' [D355]", "transfer")
      else if (method%stress == stress_after .and. method%transfer%flip_fraction() > 0.0_wp) then
         call deck%warn(group, "linear functions with stress_update = 'usl' gain energy "// &
            "without bound where bodies cross cells; write stress_update = 'musl' [D355]", &
            "stress_update")
      end if
   end subroutine warn_of_linear

   !> Criteria for the splitting of long particles.
   subroutine read_splitting(method, group)
      type(method_t), intent(inout) :: method
      type(group_t), intent(in) :: group             !! &method
      character(len=:), allocatable :: word
      logical :: split

      call group%get("split", split)
      if (.not. split) return
      allocate (method%splitting)
      call group%get("split_at", method%splitting%longest)
      call group%get("split_what", word)
      method%splitting%gases = word == "gases"
      call group%get("split_max", method%splitting%generations)
   end subroutine read_splitting

   !> Check the keys of the dual domain gradient.
   subroutine read_dual(method, deck, group)
      type(method_t), intent(inout) :: method        !! The method with its rule chosen
      type(deck_t), intent(inout) :: deck            !! Collects complaints
      type(group_t), intent(in) :: group             !! &method
      character(len=:), allocatable :: word, quadrature
      logical :: paper

      call group%get("alpha", word)
      method%quadrature%alpha = max(position_of(word, alpha_names), 1)
      call group%get("quadrature", quadrature)
      if (method%quadrature%needs_split() .and. word /= "split") call deck%add_error(group, &
         "quadrature = '"//quadrature//"' needs alpha = 'split', whose means are "// &
         "products [D355]", "alpha")
      call group%get("blend", word)
      method%quadrature%smooth = word == "smooth"
      call group%get("alpha_0", method%quadrature%alpha_centre)
      call group%get("normalise", method%normalise)
      call group%get("free_surface", word)
      method%surface = max(position_of(word, surface_names), 1)
      call group%get("paper", paper)
      method%leapfrog = .not. paper
   end subroutine read_dual
end module scene_method
