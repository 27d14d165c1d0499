! SPDX-License-Identifier: BSD-3-Clause
!> Hyperelastic material after Neo and Hooke, with the whole stress from the deformation gradient F:
!! sigma = (lambda ln J I + mu (F F^T - I))/J with J = det F.
!!
!! The energy of a unit of reference volume is mu/2 (tr F^T F - 3) - mu ln J + lambda/2 (ln J)**2
!! (J. Bonet, R. D. Wood, "Nonlinear continuum mechanics for finite element analysis", 1997). The
!! stress does not depend on the path, so a released particle returns to its initial state.
!! Equations (Y.12) and (Y.13) of doc/theory/strength.md.
module law_neo_hookean
   use base_elementary, only: logarithm, take_logarithms
   use base_kinds, only: wp
   use material_field_requests, only: field_requests_t
   use material_kinematics, only: deform
   use material_law, only: law_t
   use material_state, only: deformation_t, material_state_t
   implicit none
   private

   public :: law_neo_hookean_t, neo_hookean_energy, neo_hookean_stress

   !> Lower bound of J in the logarithm: an inverted particle has J <= 0; the run then stops on its
   !! time step.
   real(wp), parameter :: least_ratio = 1.0e-6_wp

   !> Law of Neo and Hooke; lambda = bulk - 2/3 shear and mu = shear.
   type, extends(law_t) :: law_neo_hookean_t
   contains
      procedure :: gives_whole_stress => neo_hookean_gives_whole_stress !! It gives the whole stress
      procedure :: is_plastic => neo_hookean_is_plastic !! False: there is no flow
      procedure :: request => neo_hookean_request    !! Requests the deformation gradient
      procedure :: predict_trial => neo_hookean_predict_trial !! Volume and deformation gradient
      procedure :: update => neo_hookean_update      !! Stress
      !> Fastest wave of the deformed state
      procedure :: add_wave_speed => neo_hookean_add_wave_speed
      procedure :: stored_energy => neo_hookean_stored_energy !! Energy of a particle
   end type law_neo_hookean_t

contains

   !> The law excludes an equation of state.
   pure logical function neo_hookean_gives_whole_stress(self) result(whole)
      class(law_neo_hookean_t), intent(in) :: self

      whole = .true.
   end function neo_hookean_gives_whole_stress

   !> A hyperelastic law does not flow.
   pure logical function neo_hookean_is_plastic(self) result(plastic)
      class(law_neo_hookean_t), intent(in) :: self

      plastic = .false.
   end function neo_hookean_is_plastic

   !> The deformation is a state variable of a particle.
   pure subroutine neo_hookean_request(self, requests)
      class(law_neo_hookean_t), intent(in) :: self
      class(field_requests_t), intent(inout) :: requests

      call requests%add("deformation_gradient", "strength neo_hookean", 9)
   end subroutine neo_hookean_request

   !> Volume and deformation gradient after the step.
   pure subroutine neo_hookean_predict_trial(self, state, deformation, first, last)
      class(law_neo_hookean_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state              !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range

      call deform(state, deformation, first, last)
   end subroutine neo_hookean_predict_trial

   !> Deviator and pressure of the stress.
   pure subroutine neo_hookean_update(self, state, deformation, first, last, dt)
      class(law_neo_hookean_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state       !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp), intent(in) :: dt                           !! Time step [s]
      real(wp) :: f(9), s(6), lambda, mu, mean
      integer :: i, k

      lambda = self%bulk - 2.0_wp/3.0_wp*self%shear
      mu = self%shear
      call find_logarithms(first, last, state%deformation_gradient, deformation%pressure)
      !$omp simd private(k, f, s, mean)
      do i = 1, last - first + 1
         k = first - 1 + i
         f(:) = state%deformation_gradient(k, 1:9)
         call stress_with_logarithm(lambda*deformation%pressure(i), mu, f, s)
         mean = (s(1) + s(2) + s(3))/3.0_wp
         state%stress(k, 1) = s(1) - mean
         state%stress(k, 2) = s(2) - mean
         state%stress(k, 3) = s(3) - mean
         state%stress(k, 4) = s(4)
         state%stress(k, 5) = s(5)
         state%stress(k, 6) = s(6)
         deformation%pressure(i) = -mean
      end do
   end subroutine neo_hookean_update

   !> Square of the fastest wave speed.
   !!
   !! The acoustic tensor of the tangent in the direction n is, with b = F F^T,
   !! ((lambda + mu - lambda ln J) n n + mu (n b n) I)/J, so that waves of pressure have
   !! rho0 c**2 = lambda + mu - lambda ln J + mu n b n. The greatest eigenvalue of b is bounded by
   !! tr b/3 + sqrt(2/3 b' : b'), which is that of a stretch along one axis. The speed is not less
   !! than at rest. Equation (Y.15).
   pure subroutine neo_hookean_add_wave_speed(self, state, deformation, first, last)
      class(law_neo_hookean_t), intent(in) :: self
      type(material_state_t), intent(in) :: state          !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp) :: f(9), b(6), lambda, mu, j, mean, largest
      integer :: i, k

      lambda = self%bulk - 2.0_wp/3.0_wp*self%shear
      mu = self%shear
      call find_logarithms(first, last, state%deformation_gradient, deformation%wave_speed)
      !$omp simd private(k, f, b, j, mean, largest)
      do i = 1, last - first + 1
         k = first - 1 + i
         f(:) = state%deformation_gradient(k, 1:9)
         j = ratio(f)
         call stress_with_logarithm(0.0_wp, 1.0_wp, f, b)
         b(:) = j*b
         mean = (b(1) + b(2) + b(3))/3.0_wp
         largest = 1.0_wp + mean + sqrt(2.0_wp/3.0_wp*((b(1) - mean)**2 + (b(2) - mean)**2 &
            + (b(3) - mean)**2 + 2.0_wp*(b(4)**2 + b(5)**2 + b(6)**2)))
         deformation%wave_speed(i) = max(lambda + 2.0_wp*mu, mu*largest + max(lambda + mu - lambda &
            *deformation%wave_speed(i), 0.0_wp))*state%volume(k)/(state%mass(k)*j)
      end do
   end subroutine neo_hookean_add_wave_speed

   !> Energy of a particle, whose reference volume is V/J.
   pure real(wp) function neo_hookean_stored_energy(self, state, particle) result(energy)
      class(law_neo_hookean_t), intent(in) :: self
      type(material_state_t), intent(in) :: state           !! State of the store
      integer, intent(in) :: particle                       !! Index in the store
      real(wp) :: f(9)

      f = state%deformation_gradient(particle, :)
      energy = state%volume(particle)/ratio(f) &
         *neo_hookean_energy(self%bulk - 2.0_wp/3.0_wp*self%shear, self%shear, f)
   end function neo_hookean_stored_energy

   !> Stress [Pa] of a deformation gradient.
   pure subroutine neo_hookean_stress(lambda, mu, gradient, stress)
      real(wp), intent(in) :: lambda                 !! First parameter of Lame [Pa]
      real(wp), intent(in) :: mu                     !! Shear modulus [Pa]
      real(wp), intent(in) :: gradient(9)            !! dx_k/dX_l in k + 3 (l - 1) [1]
      real(wp), intent(out) :: stress(6)             !! xx, yy, zz, xy, yz, xz [Pa]
      call stress_with_logarithm(lambda*logarithm(ratio(gradient)), mu, gradient, stress)
   end subroutine neo_hookean_stress

   !> Stress [Pa] of a deformation gradient and the logarithm of its determinant.
   pure subroutine stress_with_logarithm(volumetric, mu, gradient, stress)
      real(wp), intent(in) :: volumetric             !! lambda ln J [Pa]
      real(wp), intent(in) :: mu                     !! Shear modulus [Pa]
      real(wp), intent(in) :: gradient(9)            !! dx_k/dX_l in k + 3 (l - 1) [1]
      real(wp), intent(out) :: stress(6)             !! xx, yy, zz, xy, yz, xz [Pa]
      real(wp) :: inverse

      inverse = 1.0_wp/ratio(gradient)
      stress(1) = mu*(gradient(1)**2 + gradient(4)**2 + gradient(7)**2 - 1.0_wp) + volumetric
      stress(2) = mu*(gradient(2)**2 + gradient(5)**2 + gradient(8)**2 - 1.0_wp) + volumetric
      stress(3) = mu*(gradient(3)**2 + gradient(6)**2 + gradient(9)**2 - 1.0_wp) + volumetric
      stress(4) = mu*(gradient(1)*gradient(2) + gradient(4)*gradient(5) + gradient(7)*gradient(8))
      stress(5) = mu*(gradient(2)*gradient(3) + gradient(5)*gradient(6) + gradient(8)*gradient(9))
      stress(6) = mu*(gradient(1)*gradient(3) + gradient(4)*gradient(6) + gradient(7)*gradient(9))
      stress(:) = stress*inverse
   end subroutine stress_with_logarithm

   !> Energy of a unit of reference volume [J/m3].
   pure real(wp) function neo_hookean_energy(lambda, mu, gradient) result(energy)
      real(wp), intent(in) :: lambda                 !! First parameter of Lame [Pa]
      real(wp), intent(in) :: mu                     !! Shear modulus [Pa]
      real(wp), intent(in) :: gradient(9)            !! dx_k/dX_l in k + 3 (l - 1) [1]
      real(wp) :: volumetric

      volumetric = logarithm(ratio(gradient))
      energy = 0.5_wp*mu*(sum(gradient**2) - 3.0_wp) - mu*volumetric + 0.5_wp*lambda*volumetric**2
   end function neo_hookean_energy

   !> J = det F, bounded from below.
   pure real(wp) function ratio(f) result(j)
      real(wp), intent(in) :: f(9)                   !! dx_k/dX_l in k + 3 (l - 1) [1]

      j = max(f(1)*(f(5)*f(9) - f(8)*f(6)) - f(4)*(f(2)*f(9) - f(8)*f(3)) &
         + f(7)*(f(2)*f(6) - f(5)*f(3)), least_ratio)
   end function ratio

   !> Logarithms of J of all particles of a range.
   pure subroutine find_logarithms(first, last, deformation_gradient, values)
      integer, intent(in) :: first, last             !! Particles of the range
      real(wp), contiguous, intent(in) :: deformation_gradient(:, :) !! F (store, 9) [1]
      real(wp), contiguous, intent(inout) :: values(:) !! ln J (range) [1]
      real(wp) :: f(9)
      integer :: i

      !$omp simd private(f)
      do i = 1, last - first + 1
         f(:) = deformation_gradient(first - 1 + i, 1:9)
         values(i) = ratio(f)
      end do
      call take_logarithms(last - first + 1, values)
   end subroutine find_logarithms
end module law_neo_hookean
