! SPDX-License-Identifier: BSD-3-Clause
!> Common parts of the models of brittle failure: principal values, and the keys of their scatter.
module material_brittle
   use base_kinds, only: wp
   use deck_schema, only: schema_t
   use material_principal, only: principal
   implicit none
   private

   public :: bound_deviator, declare_brittle, find_extremes, weibull_t

   !> Scatter of strength after W. Weibull, Ingenioersvetenskapsakad. Handl. 151 (1939): the
   !! probability that a volume V fails below f times the characteristic strength is
   !! 1 - exp(-V/V0 f**m).
   type :: weibull_t
      real(wp) :: modulus = 1.0_wp                   !! m [1]
      real(wp) :: volume = 1.0_wp                    !! V0 [m3]
   end type weibull_t

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
         "applies: 63 % of specimens of this volume fail below it, larger ones are weaker", &
         unit="m3", range="> 0", &
         owner="effects.size_scatter & damage_model = principal_stress principal_strain")
      call schema%require("material", "weibull_volume")
      call schema%real("material", "weibull_size", "edge of the smallest cubes with a strength "// &
         "of their own, such as the size of grains; smaller particles have that of the cube "// &
         "around them; with 0 smaller ones are always stronger", unit="m", default="0", &
         range=">= 0", owner="effects.size_scatter & damage_model = principal_stress "// &
         "principal_strain grady_kipp")
      call schema%forbid_change("material", "weibull_m weibull_volume weibull_size", &
         "the strengths of the particles were drawn with it")
   end subroutine declare_brittle

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
