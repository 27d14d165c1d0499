! SPDX-License-Identifier: BSD-3-Clause
!> The numerical method of a run: its keys in the deck and what they choose.
module driver_method
   use base_deck, only: deck_t, group_t
   use base_kinds, only: wp
   use base_schema, only: schema_t
   use ddmp_alpha, only: alpha_names, alpha_split
   use ddmp_catalogue, only: choose_quadrature, quadrature_names
   use ddmp_dual, only: surface_fill, surface_names
   use ddmp_quadrature, only: quadrature_t
   use driver_method_defaults, only: settle_method, stress_after, stress_average, stress_before, &
      stress_names, stress_remapped
   use particle_store, only: traits_t
   use transfer_basis, only: basis_t
   use particle_split, only: splitting_t
   use transfer_catalogue, only: basis_names, choose_basis, choose_velocity, velocity_names
   use transfer_velocity, only: velocity_t
   implicit none
   private

   public :: declare_method, method_t, position_of
   public :: stress_after, stress_before

   !> Choices of the numerical method.
   type :: method_t
      logical :: dual = .true.                       !! Dual domain gradient, else the plain one
      class(basis_t), allocatable :: basis           !! Node functions
      class(quadrature_t), allocatable :: quadrature !! Rule of the dual domain gradient, if any
      character(len=:), allocatable :: normalise     !! Whose sums are normalised: gases, ...
      integer :: surface = surface_fill              !! Weights of cells of the dual domain gradient
      integer :: stress = stress_after               !! When the stress is updated
      real(wp) :: unseen = 0.0_wp !! Share of node velocities that particles do not take, in strain
      logical :: leapfrog = .true.                   !! Velocities half a step behind positions?
      logical :: even = .false.                      !! Even dilatation in a cell?
      logical :: smooth_turn = .false.               !! Is the rotation that of the tiles?
      logical :: limited = .false.                   !! Does viscosity resist jumps only?
      real(wp) :: heat_flux = 0.0_wp                 !! Coefficient of artificial heat flux [1]
      type(splitting_t), allocatable :: splitting    !! When long particles are halved, if they are
      class(velocity_t), allocatable :: transfer     !! How velocities come back to particles
      real(wp) :: cfl = 0.4_wp !! Share of the time a signal needs for a cell [1]
      real(wp) :: step_growth = 1.1_wp               !! Greatest ratio of successive time steps [1]
   contains
      procedure :: read => method_read               !! Make it from the deck
      procedure :: choose => method_choose           !! Make it from words
      procedure :: controlled => method_controlled   !! Is a mean stress taken out?
      procedure :: strains_first => method_strains_first !! Is there strain before the force?
      procedure :: remaps => method_remaps           !! Are new velocities mapped for the strain?
      procedure :: averages => method_averages       !! Is the strain of two velocities?
      procedure :: differing => method_differing     !! Is the force of stress differences?
      procedure :: margin => method_margin           !! Layers of nodes that particles reach
      procedure :: request => method_request         !! Asks for what particles must carry
      procedure :: kick => method_kick               !! Time over which the forces act
      procedure :: lag => method_lag                 !! Time by which velocities are behind
   end type method_t

contains

   !> Declare the keys of &method that are not those of materials.
   subroutine declare_method(schema)
      type(schema_t), intent(inout) :: schema        !! Keys of the deck
      class(velocity_t), allocatable :: transfer
      integer :: n

      call schema%group("method", "numerical method")
      call schema%text("method", "basis", "node functions; ddmp needs linear", default="linear")
      call schema%words("method", "basis", basis_names)
      call schema%text("method", "transfer", "how velocities go between particles and nodes; "// &
         "default rflip with ddmp, flip with mpm", default="rflip")
      call schema%words("method", "transfer", velocity_names)
      do n = 1, size(velocity_names)
         call choose_velocity(velocity_names(n), transfer)
         call transfer%declare(schema)
      end do
      call schema%logical("method", "paper", "the exact scheme of the seed of the method; it "// &
         "fixes the other keys of the scheme", default=".false.", owner="run.method = ddmp")
      call schema%text("method", "alpha", "share of the own cell in the gradient: one bubble a "// &
         "direction, their product, or its square", default="split", owner="run.method = ddmp")
      call schema%words("method", "alpha", alpha_names)
      call schema%real("method", "alpha_0", "alpha at the centre of a cell", default="1.0", &
         range=">= 0 <= 1", owner="run.method = ddmp")
      call schema%text("method", "blend", "how the node gradient is interpolated: smooth has "// &
         "no kinks; default smooth with alpha = 'split', linear with others and round an axis", &
         words="smooth linear", owner="run.method = ddmp")
      call schema%text("method", "free_surface", &
         "cell weights of the dual gradient: least fill "// &
         "of the nodes; 1 in cells without an empty node; 1 everywhere", default="fill", &
         owner="run.method = ddmp")
      call schema%words("method", "free_surface", surface_names)
      call schema%text("method", "quadrature", "where the dual gradient is taken", &
         default="point", owner="run.method = ddmp")
      call schema%words("method", "quadrature", quadrature_names)
      call schema%text("method", "normalise", "whose sums over particles are divided by the "// &
         "sums of their weights, so that uniform pressure makes no force: matter without "// &
         "strength that carries an internal energy, all without strength, none, all; default "// &
         "none where the rule of the dual gradient forbids it", &
         words="gases fluids none all", default="gases", owner="run.method = ddmp")
      call declare_strain(schema)
      call schema%text("method", "antilock", "cure of volumetric locking: the particles of a "// &
         "material in a cell share their mean dilatation and pressure", default="none", &
         words="none bbar")
      call declare_shocks(schema)
      call schema%logical("method", "split", "particles that have become long are halved, so "// &
         "that stretched matter stays in one piece; default .true. where all matter is "// &
         "gas with normalised sums", default=".false.")
      call schema%real("method", "split_at", "edge of a particle in cells at which it is halved", &
         default="0.55", range="> 0 <= 2", owner="split")
      call schema%integer("method", "split_max", "times that a particle and its parts are "// &
         "halved", default="10", range="> 0 <= 20", owner="split")
   end subroutine declare_method

   !> Declare what strains the particles, and whose rotation they carry.
   subroutine declare_strain(schema)
      type(schema_t), intent(inout) :: schema        !! Keys of the deck

      call schema%text("method", "stress_update", &
         "after the step, before it, or after mapping the "// &
         "new velocities; or with the average of both maps, which keeps energy; default usl "// &
         "with ddmp, musl with mpm", words="usl usf musl usavg")
      call schema%real("method", "unseen_strain", "share of what nodes gain and particles do "// &
         "not take that strains with stress_update = 'usavg': damps differences of pressure "// &
         "between particles; default 0 where all matter is elastic", default="0.2", &
         range=">= 0 <= 1")
      call schema%text("method", "turn_from", "rotation that a particle carries: of the "// &
         "velocity round it, or the mean of the matter of the tiles around, which keeps the "// &
         "energy of thin bodies", default="point", words="point tiles", &
         owner="transfer = rflip")
   end subroutine declare_strain

   !> Declare the keys of artificial viscosity and heat flux that concern nodes.
   subroutine declare_shocks(schema)
      type(schema_t), intent(inout) :: schema        !! Keys of the deck

      call schema%text("method", "viscosity_limiter", "what artificial viscosity resists: "// &
         "smooth, compression less what the node gradients around predict, so that flow which "// &
         "converges evenly is not heated; none, all compression", default="none", &
         words="none smooth", owner="effects.artificial_viscosity & run.method = ddmp")
      call schema%real("method", "heat_flux", "coefficient of an artificial heat flux in "// &
         "shocks, against walls that are too hot; about 2", default="0", range=">= 0 <= 100", &
         owner="effects.artificial_viscosity")
   end subroutine declare_shocks

   !> Make the method from the deck.
   subroutine method_read(self, deck, stored, gases)
      class(method_t), intent(inout) :: self         !! The method
      type(deck_t), intent(inout) :: deck            !! The deck, gets defaults and complaints
      logical, intent(in) :: stored                  !! Does all matter give back all work?
      logical, intent(in) :: gases                   !! Is all matter a gas?
      type(group_t) :: group
      character(len=:), allocatable :: word, basis, quadrature

      call settle_method(deck, stored, gases)
      group = deck%group("run", 1)
      call group%get("method", word)
      group = deck%group("method", 1)
      call group%get("basis", basis)
      call group%get("quadrature", quadrature)
      call self%choose(word == "ddmp", basis, quadrature)
      if (self%dual .and. basis /= "linear" .and. group%valid(["basis"])) &
         call deck%complain(group, &
         "basis = '"//basis//"' needs method = 'mpm' in &run; ddmp has linear functions", "basis")
      if (self%dual) call read_dual(self, deck, group)
      if (self%controlled() .or. self%differing()) call refuse_axis(deck, group, quadrature)
      call group%get("stress_update", word)
      self%stress = max(position_of(word, stress_names), 1)
      if (self%averages()) call group%get("unseen_strain", self%unseen)
      call group%get("transfer", word)
      call choose_velocity(word, self%transfer)
      if (.not. allocated(self%transfer)) call choose_velocity("flip", self%transfer)
      call self%transfer%read(deck, group)
      if (self%transfer%affine() .and. .not. (self%transfer%turning() .or. self%dual) .and. &
         basis == "linear") call deck%warn(group, "linear functions with transfer = '"//word// &
         "' gain energy without bound; write basis = 'quadratic'", "transfer")
      if (self%transfer%turning()) then
         call group%get("turn_from", word)
         self%smooth_turn = word == "tiles"
      end if
      call group%get("antilock", word)
      self%even = word == "bbar"
      call group%get("heat_flux", self%heat_flux)
      call group%get("viscosity_limiter", word)
      self%limited = self%dual .and. word == "smooth"
      call read_splitting(self, group)
      group = deck%group("time", 1)
      call group%get("cfl", self%cfl)
   end subroutine method_read

   !> When long particles are halved.
   subroutine read_splitting(method, group)
      class(method_t), intent(inout) :: method       !! The method
      type(group_t), intent(in) :: group             !! &method
      logical :: split

      call group%get("split", split)
      if (.not. split) return
      allocate (method%splitting)
      call group%get("split_at", method%splitting%longest)
      call group%get("split_max", method%splitting%generations)
   end subroutine read_splitting

   !> What belongs to the dual domain gradient.
   subroutine read_dual(method, deck, group)
      class(method_t), intent(inout) :: method       !! The method with its rule chosen
      type(deck_t), intent(inout) :: deck            !! Collects complaints
      type(group_t), intent(in) :: group             !! &method
      character(len=:), allocatable :: word, quadrature
      logical :: paper

      call group%get("alpha", word)
      method%quadrature%alpha = max(position_of(word, alpha_names), 1)
      call group%get("quadrature", quadrature)
      if (quadrature == "sub_points" .and. word /= "split") call deck%complain(group, &
         "quadrature = 'sub_points' needs alpha = 'split', whose means are products", "alpha")
      call group%get("blend", word)
      method%quadrature%smooth = word == "smooth"
      call group%get("alpha_0", method%quadrature%alpha_centre)
      call group%get("normalise", method%normalise)
      call group%get("free_surface", word)
      method%surface = max(position_of(word, surface_names), 1)
      call group%get("paper", paper)
      method%leapfrog = .not. paper
   end subroutine read_dual

   !> Refuse rules that know nothing of the hoop stress: what they take out of the particles they
   !! give back without it.
   subroutine refuse_axis(deck, group, quadrature)
      type(deck_t), intent(inout) :: deck            !! The deck
      type(group_t), intent(in) :: group             !! &method
      character(len=*), intent(in) :: quadrature     !! Word of the rule
      character(len=:), allocatable :: dimension
      type(group_t) :: run

      run = deck%group("run", 1)
      call run%get("dimension", dimension)
      if (dimension == "axisymmetric") call deck%complain(group, "quadrature = '"//quadrature// &
         "' does not know the hoop stress of dimension = 'axisymmetric'; write 'point'", &
         "quadrature")
   end subroutine refuse_axis

   !> Choose node functions and gradient; words that are not known give the linear ones.
   subroutine method_choose(self, dual, basis, quadrature)
      class(method_t), intent(inout) :: self         !! The method
      logical, intent(in) :: dual                    !! Dual domain gradient?
      character(len=*), intent(in) :: basis          !! Word of the node functions
      character(len=*), intent(in) :: quadrature     !! Word of the rule of the dual gradient

      self%dual = dual
      call choose_basis(basis, self%basis)
      if (.not. allocated(self%basis)) call choose_basis("linear", self%basis)
      if (.not. allocated(self%transfer)) call choose_velocity("flip", self%transfer)
      if (allocated(self%quadrature)) deallocate (self%quadrature)
      if (.not. dual) return
      call choose_quadrature(quadrature, self%quadrature)
      if (.not. allocated(self%quadrature)) call choose_quadrature("point", self%quadrature)
      self%quadrature%alpha = alpha_split
      ! boxes on all ways: force without mass at free surfaces would be lost
      if (quadrature == "sub_points") call choose_basis("cpgimp", self%basis)
   end subroutine method_choose

   !> True if a mean stress of the nodes is taken out of the particles.
   pure logical function method_controlled(self) result(controlled)
      class(method_t), intent(in) :: self            !! The method

      controlled = .false.
      if (allocated(self%quadrature)) controlled = self%quadrature%controlled()
   end function method_controlled

   !> True if the force of each node is corrected for how the particles lie.
   pure logical function method_differing(self) result(differing)
      class(method_t), intent(in) :: self            !! The method

      differing = .false.
      if (allocated(self%quadrature)) differing = self%quadrature%differing()
   end function method_differing

   !> Are particles strained before the force acts, with the velocities at their new places?
   pure logical function method_strains_first(self) result(first)
      class(method_t), intent(in) :: self            !! The method

      first = self%stress == stress_before
   end function method_strains_first

   !> Are new velocities of particles, or what they gain, mapped to the nodes for the strain?
   pure logical function method_remaps(self) result(remaps)
      class(method_t), intent(in) :: self            !! The method

      remaps = self%stress == stress_remapped .or. self%stress == stress_average
   end function method_remaps

   !> Is the strain of a step half of the velocity at its begin and half of that at its end?
   pure logical function method_averages(self) result(averages)
      class(method_t), intent(in) :: self            !! The method

      averages = self%stress == stress_average
   end function method_averages

   !> Layers of nodes beyond a tile that its particles reach.
   pure integer function method_margin(self) result(margin)
      class(method_t), intent(in) :: self            !! The method

      margin = self%basis%margin()
      if (allocated(self%quadrature)) margin = max(margin, self%quadrature%margin())
   end function method_margin

   !> Ask for what particles must carry.
   pure subroutine method_request(self, traits)
      class(method_t), intent(in) :: self            !! The method
      type(traits_t), intent(inout) :: traits        !! Fields of the stores

      call self%basis%request(traits)
      traits%domain = traits%domain .or. allocated(self%splitting)
      if (self%transfer%turning()) then
         traits%spin = .true.
      else
         traits%affine = self%transfer%affine()
      end if
      traits%averaged = self%averages()
      if (allocated(self%quadrature)) call self%quadrature%request(traits)
   end subroutine method_request

   !> Place of a word in a list, 0 if it is not there.
   pure integer function position_of(word, list) result(position)
      character(len=*), intent(in) :: word           !! The word
      character(len=*), intent(in) :: list(:)        !! Where to look

      do position = 1, size(list)
         if (list(position) == word) return
      end do
      position = 0
   end function position_of

   !> Time over which the forces of a step act [s].
   !!
   !! Position and stress stand at the times of the steps, velocities half a step before: forces
   !! lead from the middle of the last step to the middle of this one, and the velocity there moves
   !! and strains through the whole step (leapfrog), which is of second order. The scheme of the
   !! seed has the velocity at the time of the position.
   pure real(wp) function method_kick(self, last, dt) result(kick)
      class(method_t), intent(in) :: self            !! The method
      real(wp), intent(in) :: last                   !! Length of the last step, 0 at the start [s]
      real(wp), intent(in) :: dt                     !! Length of this step [s]

      kick = merge(0.5_wp*(last + dt), dt, self%leapfrog)
   end function method_kick

   !> Time by which velocities are behind positions [s].
   pure real(wp) function method_lag(self, last) result(lag)
      class(method_t), intent(in) :: self            !! The method
      real(wp), intent(in) :: last                   !! Length of the last step, 0 at the start [s]

      lag = merge(0.5_wp*last, 0.0_wp, self%leapfrog)
   end function method_lag
end module driver_method
