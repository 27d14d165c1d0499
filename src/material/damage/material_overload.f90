! SPDX-License-Identifier: BSD-3-Clause
!> Brittle failure where the load of a particle reaches 1: the greatest principal stress over the
!! strength, or in compression half the difference of the principal stresses over that of shear; or
!! the greatest principal value of the elastic strain, s/(2 G) - p/(3 K), over its limit. Equations
!! (F.1) and (F.2) of doc/theory/failure.md.
module material_overload
   use base_kinds, only: int64, wp
   use deck_group_values, only: group_t
   use material_brittle, only: bound_deviator, draw_weibull, find_extremes, read_weibull, &
      weibull_t
   use material_damage, only: damage_t
   use material_delay, only: age_damage, delay_fault, delay_t
   use material_effects, only: effects_t
   use material_field_requests, only: field_requests_t
   use material_law, only: law_t
   use material_state, only: deformation_t, material_state_t
   implicit none
   private

   public :: overload_t, read_overload

   !> A limit that does not overflow when multiplied by random factors.
   real(wp), parameter, public :: no_limit = sqrt(huge(1.0_wp))

   !> Failure by a principal stress or strain.
   type, abstract, extends(damage_t) :: overload_t
      real(wp) :: strength = no_limit                !! Greatest principal stress [Pa]
      real(wp) :: crushing = no_limit                !! Greatest shear stress [Pa]
      real(wp) :: limit = 0.0_wp !! Greatest principal strain; 0: the limits are stresses [1]
      type(delay_t) :: delay                         !! Time from load to failure
      type(weibull_t), allocatable :: weibull        !! Only if strength scatters
   contains
      procedure :: fault => overload_fault           !! Error in the combination of its keys
      procedure :: needs_flow => overload_needs_flow !! Returns false
      procedure :: takes_scatter => overload_takes_scatter !! Returns true
      procedure :: request => overload_request       !! Requests damage and scatter
      procedure :: draw_strength => overload_draw_strength !! Random strength
      procedure :: update => overload_update         !! Failure
   end type overload_t

contains

   !> Error in the combination of its keys; empty if there is none.
   pure function overload_fault(self, group, law) result(text)
      class(overload_t), intent(in) :: self
      type(group_t), intent(in) :: group                  !! &material
      class(law_t), allocatable, intent(in) :: law        !! Law of strength, if there is one
      character(len=:), allocatable :: text

      text = delay_fault(group)
   end function overload_fault

   !> It does not use the plastic strain.
   pure logical function overload_needs_flow(self) result(needs)
      class(overload_t), intent(in) :: self

      needs = .false.
   end function overload_needs_flow

   !> Its strength may scatter.
   pure logical function overload_takes_scatter(self) result(takes)
      class(overload_t), intent(in) :: self

      takes = .true.
   end function overload_takes_scatter

   !> Read the keys of delay and scatter.
   pure subroutine read_overload(model, group, effects)
      class(overload_t), intent(inout) :: model
      type(group_t), intent(in) :: group                  !! &material
      type(effects_t), intent(in) :: effects

      call model%delay%read(group)
      if (.not. effects%size_scatter) return
      allocate (model%weibull)
      call read_weibull(group, model%weibull)
   end subroutine read_overload

   !> Damage, and a separate strength for each particle.
   pure subroutine overload_request(self, requests)
      class(overload_t), intent(in) :: self
      class(field_requests_t), intent(inout) :: requests

      call requests%add("damage", "damage model "//merge("principal_strain", &
         "principal_stress", self%limit > 0.0_wp), 1)
      call self%delay%request(requests)
      if (allocated(self%weibull)) call requests%add("scatter", "size_scatter", 1)
   end subroutine overload_request

   !> Random strength.
   pure subroutine overload_draw_strength(self, seed, identity, first, last, mass, scatter)
      class(overload_t), intent(in) :: self
      integer(int64), intent(in) :: seed                   !! Seed of the random numbers
      integer(int64), contiguous, intent(in) :: identity(:) !! Identities of the particles (store)
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp), contiguous, intent(in) :: mass(:)          !! (store) [kg]
      real(wp), contiguous, intent(inout) :: scatter(:)    !! (store) [1]

      if (allocated(self%weibull)) call draw_weibull(self%weibull, self%slice, self%density, seed, &
         identity, first, last, mass, scatter)
   end subroutine overload_draw_strength

   !> Mark overloaded particles as failed.
   pure subroutine overload_update(self, state, deformation, first, last, dt)
      class(overload_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state       !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp), intent(in) :: dt                           !! Time step [s]
      integer :: i, k

      call deformation%damage%reserve(last - first + 1)
      call bound_deviator(first, last, state%stress, deformation%damage%bound)
      call find_loads(self, state, deformation, first, last)
      if (allocated(state%brittle%overload)) then
         call self%delay%grow_damage(first, last, dt, deformation%damage%load, &
            state%brittle%overload, state%damage)
         return
      end if
      do i = 1, last - first + 1
         k = first - 1 + i
         if (deformation%damage%load(i) >= 1.0_wp) &
            state%damage(k) = age_damage(state%damage(k), self%delay%time, dt)
      end do
   end subroutine overload_update

   !> Loads of the particles. Where a load is below 1, and was below 1 before, an upper bound is
   !! sufficient: few particles are near their strength, and only these need principal values.
   !! Equation (F.3).
   pure subroutine find_loads(model, state, deformation, first, last)
      class(overload_t), intent(in) :: model
      type(material_state_t), intent(in) :: state          !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! With bounds of the deviators
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp) :: greatest, least, factor
      integer :: i, k

      associate (load => deformation%damage%load, bound => deformation%damage%bound, &
         pressure => deformation%pressure)
         if (model%limit > 0.0_wp .and. .not. model%bulk > 0.0_wp) then
            ! A gas has no bulk modulus at rest and no elastic strain.
            load(:last - first + 1) = 0.0_wp
            return
         end if
         factor = 1.0_wp
         do i = 1, last - first + 1
            k = first - 1 + i
            if (allocated(model%weibull)) factor = state%brittle%scatter(k)
            load(i) = load_of(model, bound(i), bound(i), pressure(i), factor)
            if (load(i) < 1.0_wp) then
               if (.not. allocated(state%brittle%overload)) cycle
               if (.not. state%brittle%overload(k) > 0.0_wp) cycle
            end if
            call find_extremes(state%stress, k, greatest, least)
            load(i) = load_of(model, greatest, 0.5_wp*(greatest - least), pressure(i), factor)
         end do
      end associate
   end subroutine find_loads

   !> Load over strength; of stresses the greater one of tension and shear.
   pure real(wp) function load_of(model, greatest, shear, pressure, factor) result(load)
      class(overload_t), intent(in) :: model
      real(wp), intent(in) :: greatest               !! Greatest value of the deviator [Pa]
      real(wp), intent(in) :: shear                  !! Half the difference of its values [Pa]
      real(wp), intent(in) :: pressure               !! [Pa]
      real(wp), intent(in) :: factor                 !! Random factor of the strength [1]

      if (model%limit > 0.0_wp) then
         load = (0.5_wp*greatest/model%shear - pressure/(3.0_wp*model%bulk))/(model%limit*factor)
      else
         load = max((greatest - pressure)/(model%strength*factor), shear/(model%crushing*factor))
      end if
   end function load_of
end module material_overload
