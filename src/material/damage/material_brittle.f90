! SPDX-License-Identifier: BSD-3-Clause
!> Common parts of the models of brittle failure: principal values, random strength, and the volume
!! on which the strength depends.
module material_brittle
   use base_elementary, only: logarithm, power
   use base_kinds, only: int64, wp
   use base_random, only: random_uniform
   use deck_schema, only: schema_t
   use material_principal, only: principal
   implicit none
   private

   public :: declare_brittle, random_exponential, find_extremes, &
      bound_deviator, slice_t, weibull_t

   !> Scatter of strength after W. Weibull, J. Appl. Mech. 18 (1951) 293: the probability that a
   !! volume V fails below f times the characteristic strength is 1 - exp(-V/V0 f**m).
   type :: weibull_t
      real(wp) :: modulus = 1.0_wp                   !! m [1]
      real(wp) :: volume = 0.0_wp !! V0, 0 if strength does not depend on size [m3]
   end type weibull_t

   !> Extent of the particles in the directions that are not computed.
   type :: slice_t
      real(wp) :: depth = 1.0_wp                     !! Length or area [m**(3 - d)]
      real(wp) :: exponent = 1.0_wp                  !! 3/d for d directions; 1 in axisymmetry [1]
   contains
      procedure :: volume => slice_volume            !! Volume that a particle represents
   end type slice_t

contains

   !> Declare the keys common to several models.
   subroutine declare_brittle(schema)
      type(schema_t), intent(inout) :: schema
      character(len=*), parameter :: owner = "effects.damage & damage_model = principal_stress "// &
         "principal_strain"

      call schema%real("material", "failure_delay", &
         "time to failure under a load above the strength", unit="s", default="0", range=">= 0", &
         owner=owner)
      call schema%real("material", "failure_delay_power", "exponent p of the time to failure, "// &
         "failure_delay / (load/strength - 1)**p; with 0 it does not depend on the load", &
         default="0", range=">= 0 <= 30", owner=owner)
      call schema%real("material", "weibull_m", "Weibull modulus of the strength, or exponent "// &
         "of the number of flaws over strain (Grady-Kipp)", range="> 0", &
         owner=owner//" grady_kipp")
      call schema%real("material", "weibull_volume", "volume to which the given strength "// &
         "applies; without it strength does not depend on size", unit="m3", range="> 0", &
         owner="effects.size_scatter & damage_model = principal_stress principal_strain")
      call schema%forbid_change("material", "weibull_m weibull_volume", "the strengths of the "// &
         "particles were drawn with it")
   end subroutine declare_brittle

   !> Reference volume that a particle represents, on which its strength depends: its own volume; in
   !! one dimension the cube of its length and in plane strain that of the square root of its area,
   !! so that the extent of the grid in other directions has no effect. In axisymmetry it is the
   !! volume of the ring. Equation (F.6) of doc/theory/failure.md.
   elemental real(wp) function slice_volume(self, mass, density) result(volume)
      class(slice_t), intent(in) :: self
      real(wp), intent(in) :: mass                   !! [kg]
      real(wp), intent(in) :: density                !! Density of the reference state [kg/m3]

      volume = mass/density
      if (self%exponent > 1.0_wp) volume = power(volume/self%depth, self%exponent)
   end function slice_volume

   !> Exponentially distributed random number of mean 1.
   elemental real(wp) function random_exponential(seed, identity) result(number)
      integer(int64), intent(in) :: seed             !! Seed of the random numbers
      integer(int64), intent(in) :: identity         !! Identity of the particle
      ! Index of the random number of a particle; each effect uses a different index.
      integer(int64), parameter :: draw = 7717_int64

      number = -logarithm(random_uniform(seed, identity, draw))
   end function random_exponential

   !> Upper bound of the principal values of the deviator: 2/3 of the equivalent stress. Where the
   !! bound is below the strength, as for most particles, principal values need not be computed.
   pure subroutine bound_deviator(first, last, stress, bound)
      integer, intent(in) :: first, last             !! Particles of the range
      real(wp), contiguous, intent(in) :: stress(:, :)  !! Deviator (store, 6) [Pa]
      real(wp), contiguous, intent(inout) :: bound(:)   !! (range) [Pa]
      integer :: i, k

      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         bound(i) = sqrt(2.0_wp/3.0_wp*(stress(k, 1)**2 + stress(k, 2)**2 + stress(k, 3)**2 &
            + 2.0_wp*(stress(k, 4)**2 + stress(k, 5)**2 + stress(k, 6)**2)))*(1.0_wp + 1.0e-12_wp)
      end do
   end subroutine bound_deviator

   !> Greatest and least principal value of one deviator.
   pure subroutine find_extremes(stress, particle, greatest, least)
      real(wp), contiguous, intent(in) :: stress(:, :)  !! Deviator (store, 6) [Pa]
      integer, intent(in) :: particle                !! Index in the store
      real(wp), intent(out) :: greatest              !! [Pa]
      real(wp), intent(out) :: least                 !! [Pa]
      real(wp) :: tensor(6), values(3), axes(3, 3)

      tensor(:) = stress(particle, 1:6)
      call principal(tensor, values, axes)
      greatest = values(1)
      least = values(3)
   end subroutine find_extremes
end module material_brittle
