! SPDX-License-Identifier: BSD-3-Clause
!> The numerical method of a run.
module step_method
   use base_kinds, only: wp
   use ddmp_alpha, only: alpha_split
   use ddmp_catalogue, only: choose_quadrature
   use ddmp_dual, only: surface_fill
   use ddmp_quadrature, only: quadrature_t
   use particle_split, only: splitting_t
   use particle_store, only: traits_t
   use transfer_basis, only: basis_t
   use transfer_catalogue, only: choose_basis, choose_velocity
   use transfer_velocity, only: velocity_t
   implicit none
   private

   public :: method_t, position_of

   integer, parameter, public :: stress_after = 1    !! usl: with the new node velocities
   integer, parameter, public :: stress_before = 2   !! usf: before the force
   integer, parameter, public :: stress_remapped = 3 !! musl: with node velocities mapped again
   !> Half with the velocities before the nodes are moved, half with those after it (usavg)
   integer, parameter, public :: stress_average = 4
   character(len=5), parameter, public :: stress_names(4) = [character(len=5) :: "usl", "usf", &
      "musl", "usavg"]

   !> Parameters of the numerical method.
   type :: method_t
      logical :: dual = .true.                       !! Dual domain gradient, else the plain one
      class(basis_t), allocatable :: basis           !! Shape functions
      class(quadrature_t), allocatable :: quadrature !! Rule of the dual domain gradient, if any
      character(len=:), allocatable :: normalise     !! Materials with normalised sums: gases, ...
      integer :: surface = surface_fill              !! Weights of cells of the dual domain gradient
      integer :: stress = stress_after               !! When the stress is updated
      logical :: leapfrog = .true.                   !! Velocities half a step behind positions?
      logical :: even = .false.                      !! Even dilatation in a cell?
      logical :: smooth_turn = .false.               !! Is the rotation that of the tiles?
      logical :: limited = .false.                   !! Does viscosity resist jumps only?
      real(wp) :: slack = 1.0_wp                     !! Factor of the viscosity limiter [1]
      real(wp) :: heat_flux = 0.0_wp                 !! Coefficient of artificial heat flux [1]
      type(splitting_t), allocatable :: splitting    !! Criterion for halving long particles
      class(velocity_t), allocatable :: transfer     !! Velocity transfer
      real(wp) :: cfl = 0.0_wp                       !! Fraction of the stable step [1]
      real(wp) :: step_growth = 1.1_wp               !! Greatest ratio of successive time steps [1]
   contains
      procedure :: choose => method_choose           !! Create it from words
      procedure :: controlled => method_controlled   !! Is a mean stress subtracted?
      procedure :: strains_first => method_strains_first !! Is there strain before the force?
      procedure :: remaps => method_remaps           !! Are new velocities mapped for the strain?
      procedure :: averages => method_averages       !! Is the strain of two velocities?
      procedure :: band_width => method_band_width   !! Width of a crack across a cell
      procedure :: margin => method_margin           !! Layers of nodes that particles reach
      procedure :: request => method_request !! Requests the fields that particles must carry
      procedure :: kick => method_kick               !! Time over which the forces act
      procedure :: lag => method_lag                 !! Time by which velocities are behind
   end type method_t

contains

   !> Choose shape functions and gradient; unknown words give the linear ones.
   subroutine method_choose(self, dual, basis, quadrature)
      class(method_t), intent(inout) :: self
      logical, intent(in) :: dual                    !! Dual domain gradient?
      character(len=*), intent(in) :: basis          !! Word of the shape functions
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
      ! velocities need the same boxes as the force; otherwise a node without mass at a free surface
      ! would get a force, which would be lost
      if (quadrature == "sub_points") call choose_basis("cpgimp", self%basis)
   end subroutine method_choose

   !> Width in cells of the band that a crack opens across an edge of the grid; that of the dual
   !! gradient is measured with a bar (test/verify/crack).
   pure real(wp) function method_band_width(self) result(width)
      class(method_t), intent(in) :: self

      width = 1.2_wp
      if (.not. self%dual) width = self%basis%band_width()
   end function method_band_width

   !> True if a mean stress of the nodes is subtracted from the particles.
   pure logical function method_controlled(self) result(controlled)
      class(method_t), intent(in) :: self

      controlled = .false.
      if (allocated(self%quadrature)) controlled = self%quadrature%controlled()
   end function method_controlled

   !> Are particles strained before the force acts, with the velocities at their new positions?
   pure logical function method_strains_first(self) result(first)
      class(method_t), intent(in) :: self

      first = self%stress == stress_before
   end function method_strains_first

   !> Are new velocities of particles, or their changes, mapped to the nodes for the strain?
   pure logical function method_remaps(self) result(remaps)
      class(method_t), intent(in) :: self

      remaps = self%stress == stress_remapped .or. self%stress == stress_average
   end function method_remaps

   !> Does the strain of a step use the mean of the velocities at its begin and end?
   pure logical function method_averages(self) result(averages)
      class(method_t), intent(in) :: self

      averages = self%stress == stress_average
   end function method_averages

   !> Layers of nodes beyond a tile that its particles reach.
   pure integer function method_margin(self) result(margin)
      class(method_t), intent(in) :: self

      margin = self%basis%margin()
      if (allocated(self%quadrature)) margin = max(margin, self%quadrature%margin())
   end function method_margin

   !> Request the fields that particles must carry.
   pure subroutine method_request(self, traits, gas)
      class(method_t), intent(in) :: self
      type(traits_t), intent(inout) :: traits        !! Fields of the stores
      logical, intent(in), optional :: gas           !! Are they those of a gas? Default: yes

      call self%basis%request(traits)
      traits%splits = allocated(self%splitting)
      if (present(gas) .and. traits%splits) traits%splits = gas .or. .not. self%splitting%gases
      traits%domain = traits%domain .or. traits%splits
      if (self%transfer%turning()) then
         traits%spin = .true.
      else
         traits%affine = self%transfer%affine()
      end if
      traits%averaged = self%averages()
      if (allocated(self%quadrature)) call self%quadrature%request(traits)
   end subroutine method_request

   !> Index of a word in a list, 0 if it is not in the list.
   pure integer function position_of(word, list) result(position)
      character(len=*), intent(in) :: word           !! Word of the deck
      character(len=*), intent(in) :: list(:)        !! Where to look

      do position = 1, size(list)
         if (list(position) == word) return
      end do
      position = 0
   end function position_of

   !> Time over which the forces of a step act [s].
   !!
   !! Position and stress are at the times of the steps, velocities half a step before: forces
   !! accelerate from the middle of the last step to the middle of this one, and that velocity moves
   !! and strains through the whole step (leapfrog), which is of second order. The scheme of
   !! LA-UR-11-06616 has the velocity at the time of the position.
   pure real(wp) function method_kick(self, last, dt) result(kick)
      class(method_t), intent(in) :: self
      real(wp), intent(in) :: last                   !! Length of the last step, 0 at the start [s]
      real(wp), intent(in) :: dt                     !! Length of this step [s]

      kick = merge(0.5_wp*(last + dt), dt, self%leapfrog)
   end function method_kick

   !> Time by which velocities are behind positions [s].
   pure real(wp) function method_lag(self, last) result(lag)
      class(method_t), intent(in) :: self
      real(wp), intent(in) :: last                   !! Length of the last step, 0 at the start [s]

      lag = merge(0.5_wp*last, 0.0_wp, self%leapfrog)
   end function method_lag
end module step_method
