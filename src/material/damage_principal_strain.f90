! SPDX-License-Identifier: BSD-3-Clause
!> Brittle failure where the greatest principal value of the elastic strain, s/(2 G) - p/(3 K),
!! reaches a limit. Equation (F.2) of doc/theory/failure.md.
module damage_principal_strain
   use base_deck_group, only: group_t
   use base_kinds, only: int64, wp
   use base_schema, only: schema_t
   use material_brittle, only: ages, draw_weibull, extremes, read_weibull, &
      upper_bound, weibull_t
   use material_damage, only: damage_t
   use material_effects, only: effects_t
   use material_matter, only: deformation_t, matter_t
   use material_wishes, only: wishes_t
   implicit none
   private

   public :: damage_principal_strain_t

   !> Failure by principal strain.
   type, extends(damage_t) :: damage_principal_strain_t
      real(wp) :: limit = huge(1.0_wp)               !! Greatest principal strain [1]
      real(wp) :: delay = 0.0_wp                     !! Time from load to failure [s]
      type(weibull_t), allocatable :: weibull        !! Only if strength scatters
   contains
      procedure :: declare => principal_declare      !! Declares its keys
      procedure :: needs_flow => principal_needs_flow !! It does not
      procedure :: takes_scatter => principal_takes_scatter !! It does
      procedure :: read => principal_read            !! Reads its keys
      procedure :: request => principal_request      !! Asks for damage and scatter
      procedure :: draw => principal_draw            !! Random strength
      procedure :: update => principal_update        !! Failure
   end type damage_principal_strain_t

contains

   !> Declare the keys of the model.
   subroutine principal_declare(self, schema)
      class(damage_principal_strain_t), intent(in) :: self !! The model
      type(schema_t), intent(inout) :: schema          !! Keys of the deck
      character(len=*), parameter :: owner = "effects.damage & damage_model = principal_strain"

      call schema%real("material", "failure_strain", "greatest principal elastic strain at "// &
         "failure", range="> 0", owner=owner)
      call schema%require("material", "failure_strain")
   end subroutine principal_declare

   !> It does not count plastic strain.
   pure logical function principal_needs_flow(self) result(needs)
      class(damage_principal_strain_t), intent(in) :: self !! The model

      needs = .false.
   end function principal_needs_flow

   !> Its strength may scatter.
   pure logical function principal_takes_scatter(self) result(takes)
      class(damage_principal_strain_t), intent(in) :: self !! The model

      takes = .true.
   end function principal_takes_scatter

   !> Read the keys of the model.
   pure subroutine principal_read(self, group, effects)
      class(damage_principal_strain_t), intent(inout) :: self !! The model
      type(group_t), intent(in) :: group                  !! &material
      type(effects_t), intent(in) :: effects              !! What is asked for

      call group%get("failure_strain", self%limit)
      ! Then cracks open, and nothing fails at once.
      if (group%given("fracture_energy")) self%limit = sqrt(huge(1.0_wp))
      call group%get("failure_delay", self%delay)
      if (.not. effects%size_scatter) return
      allocate (self%weibull)
      call read_weibull(group, self%weibull)
   end subroutine principal_read

   !> Damage, and a strength of its own for each particle.
   pure subroutine principal_request(self, wishes)
      class(damage_principal_strain_t), intent(in) :: self !! The model
      class(wishes_t), intent(inout) :: wishes         !! Fields to be carried

      call wishes%ask("damage", "damage model principal_strain", 1)
      if (allocated(self%weibull)) call wishes%ask("scatter", "size_scatter", 1)
   end subroutine principal_request

   !> Random strength.
   pure subroutine principal_draw(self, seed, identity, first, last, mass, scatter)
      class(damage_principal_strain_t), intent(in) :: self !! The model
      integer(int64), intent(in) :: seed                   !! Seed of the run
      integer(int64), contiguous, intent(in) :: identity(:) !! Of the particles (store)
      integer, intent(in) :: first                         !! First particle of the range
      integer, intent(in) :: last                          !! Last particle of the range
      real(wp), contiguous, intent(in) :: mass(:)          !! (store) [kg]
      real(wp), contiguous, intent(inout) :: scatter(:)    !! (store) [1]

      if (allocated(self%weibull)) call draw_weibull(self%weibull, self%density, seed, identity, &
         first, last, mass, scatter)
   end subroutine principal_draw

   !> Let overloaded particles fail. Few are near their strength, and only these are looked at one
   !! by one.
   pure subroutine principal_update(self, matter, deformation, first, last, dt)
      class(damage_principal_strain_t), intent(in) :: self !! The model
      type(matter_t), intent(inout) :: matter              !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first                         !! First particle of the range
      integer, intent(in) :: last                          !! Last particle of the range
      real(wp), intent(in) :: dt                           !! Time step [s]
      integer :: count

      count = last - first + 1
      call upper_bound(first, last, matter%stress, deformation%homologous)
      if (allocated(self%weibull)) then
         deformation%loosening(:count) = matter%scatter(first:last)
      else
         deformation%loosening(:count) = 1.0_wp
      end if
      call overload(self, first, last, dt, deformation%pressure, deformation%homologous, &
         deformation%loosening, matter%stress, matter%damage)
   end subroutine principal_update

   !> Kernel of the above.
   pure subroutine overload(model, first, last, dt, pressure, bound, factor, stress, damage)
      class(damage_principal_strain_t), intent(in) :: model !! The model
      integer, intent(in) :: first                         !! First particle of the range
      integer, intent(in) :: last                          !! Last particle of the range
      real(wp), intent(in) :: dt                           !! Time step [s]
      real(wp), contiguous, intent(in) :: pressure(:)      !! (range) [Pa]
      real(wp), contiguous, intent(in) :: bound(:) !! Of the principal deviators (range) [Pa]
      real(wp), contiguous, intent(in) :: factor(:)        !! Strength of its own (range) [1]
      real(wp), contiguous, intent(in) :: stress(:, :)     !! Deviator (store, 6) [Pa]
      real(wp), contiguous, intent(inout) :: damage(:)     !! (store) [1]
      real(wp) :: greatest, least
      integer :: i, k

      ! A gas has no bulk modulus at rest and no elastic strain.
      if (.not. model%bulk > 0.0_wp) return
      do i = 1, last - first + 1
         if (0.5_wp*bound(i)/model%shear - pressure(i)/(3.0_wp*model%bulk) &
            < model%limit*factor(i)) cycle
         k = first - 1 + i
         call extremes(stress, k, greatest, least)
         if (0.5_wp*greatest/model%shear - pressure(i)/(3.0_wp*model%bulk) &
            < model%limit*factor(i)) cycle
         damage(k) = ages(damage(k), model%delay, dt)
      end do
   end subroutine overload
end module damage_principal_strain
