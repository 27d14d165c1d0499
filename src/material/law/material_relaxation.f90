! SPDX-License-Identifier: BSD-3-Clause
!> Kernels of a stress that rotates, grows elastically and relaxes simultaneously, exact for a
!! velocity gradient that is constant over the step.
!!
!! With x from 0 to 1 along the step, the spin increment W, the relaxation k = dt/tau and the strain
!! increment D the deviator follows ds/dx = W s - s W - k s + 2 G D'. In a frame whose third axis is
!! that of the rotation by the angle w, the combinations s33, s13 + i s23 and (s11 - s22)/2 + i s12
!! follow dz/dx = -(k - i m w) z + g with m = 0, 1, 2 independently, and the solution is
!! z(1) = exp(-y) z(0) + g f1(y) with y = k - i m w and f1(y) = (1 - exp(-y))/y. The integral of z
!! over the step, which gives the work, is z(0) f1(y) + g f2(y) with f2(y) = (1 - f1(y))/y.
!! Equations (Y.21) and (Y.22) of doc/theory/strength.md.
module material_relaxation
   use base_kinds, only: wp
   use material_state, only: deformation_t, material_state_t
   implicit none
   private

   public :: relax_deviator, relax_pressure

   !> A deviator in the frame of a rotation.
   type :: harmonics_t
      real(wp) :: along = 0.0_wp                     !! Component 33
      complex(wp) :: first = (0.0_wp, 0.0_wp)        !! 13 + i 23, turns once with the rotation
      complex(wp) :: second = (0.0_wp, 0.0_wp)       !! (11 - 22)/2 + i 12, turns twice
   end type harmonics_t

contains

   !> Deviator after the step, its flow and its losses.
   pure subroutine relax_deviator(shear, relaxation, inverse_contact_strain, state, deformation, &
      first, last)
      real(wp), intent(in) :: shear                  !! Shear modulus [Pa]
      real(wp), intent(in) :: relaxation             !! Time step over relaxation time at rest [1]
      real(wp), intent(in) :: inverse_contact_strain !! Relaxation for each unit of shear [1]
      type(material_state_t), intent(inout) :: state       !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      type(harmonics_t) :: old, strain, new, total
      real(wp) :: g(9), s(6), e(6), w(3), frame(3, 3), angle, rate, gain, k
      integer :: i, p

      do i = 1, last - first + 1
         p = first - 1 + i
         g = deformation%gradient(i, :)
         call split(g, e, w)
         k = relaxation + inverse_contact_strain*sqrt(2.0_wp*square(e))
         angle = sqrt(w(1)**2 + w(2)**2 + w(3)**2)
         call make_frame(w, angle, frame)
         s = state%stress(p, :)
         call to_frame(frame, s, old)
         call to_frame(frame, e, strain)
         call advance(2.0_wp*shear, k, angle, old, strain, new, total)
         call from_frame(frame, new, s)
         state%stress(p, :) = s
         gain = (contract(new, new) - contract(old, old))/(4.0_wp*shear)
         deformation%plastic_work(i) = state%volume(p)*max(contract(total, strain) - gain, 0.0_wp)
         rate = k/(2.0_wp*shear)
         deformation%plastic_increment(i) = rate*sqrt(2.0_wp/3.0_wp*contract(total, total))
      end do
   end subroutine relax_deviator

   !> Pressure after the step, dp/dx = -k p - K tr D, and its losses.
   pure subroutine relax_pressure(bulk, relaxation, inverse_contact_strain, state, deformation, &
      first, last)
      real(wp), intent(in) :: bulk                   !! Bulk modulus [Pa]
      real(wp), intent(in) :: relaxation             !! Time step over relaxation time at rest [1]
      real(wp), intent(in) :: inverse_contact_strain !! Relaxation for each unit of shear [1]
      type(material_state_t), intent(in) :: state          !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      complex(wp) :: f1, f2, decay
      real(wp) :: g(9), e(6), w(3), k, trace, before, total
      integer :: i

      do i = 1, last - first + 1
         g = deformation%gradient(i, :)
         call split(g, e, w)
         k = relaxation + inverse_contact_strain*sqrt(2.0_wp*square(e))
         trace = g(1) + g(5) + g(9)
         call functions(cmplx(k, 0.0_wp, wp), decay, f1, f2)
         before = deformation%pressure(i)
         deformation%pressure(i) = real(decay, wp)*before - bulk*trace*real(f1, wp)
         total = real(f1, wp)*before - bulk*trace*real(f2, wp)
         deformation%plastic_work(i) = deformation%plastic_work(i) + state%volume(first - 1 + i) &
            *max(0.0_wp, -total*trace - (deformation%pressure(i)**2 - before**2)/(2.0_wp*bulk))
      end do
   end subroutine relax_pressure

   !> Deviator of strain and rotation vector of a gradient.
   pure subroutine split(g, e, w)
      real(wp), intent(in) :: g(9)                   !! Component (k, l) in k + 3 (l - 1) [1]
      real(wp), intent(out) :: e(6)                  !! Deviator of strain [1]
      real(wp), intent(out) :: w(3)                  !! Rotation vector [1]
      real(wp) :: mean

      mean = (g(1) + g(5) + g(9))/3.0_wp
      e = [g(1) - mean, g(5) - mean, g(9) - mean, 0.5_wp*(g(4) + g(2)), 0.5_wp*(g(8) + g(6)), &
         0.5_wp*(g(7) + g(3))]
      w = 0.5_wp*[g(6) - g(8), g(7) - g(3), g(2) - g(4)]
   end subroutine split

   !> Sum of the squares of all components of a symmetric tensor.
   pure real(wp) function square(e) result(total)
      real(wp), intent(in) :: e(6)                   !! xx, yy, zz, xy, yz, xz

      total = e(1)**2 + e(2)**2 + e(3)**2 + 2.0_wp*(e(4)**2 + e(5)**2 + e(6)**2)
   end function square

   !> Right-handed frame with the axis of rotation as third axis, or z without rotation (T. Duff and
   !! others, J. Comput. Graphics Tech. 6 (2017) 1).
   pure subroutine make_frame(w, angle, frame)
      real(wp), intent(in) :: w(3)                   !! Rotation vector [1]
      real(wp), intent(in) :: angle                  !! Length of the rotation vector [1]
      real(wp), intent(out) :: frame(3, 3)           !! Axis j in (:, j) [1]
      real(wp) :: n(3), a, b, up

      n = [0.0_wp, 0.0_wp, 1.0_wp]
      if (angle > 0.0_wp) n = w/angle
      up = sign(1.0_wp, n(3))
      a = -1.0_wp/(up + n(3))
      b = n(1)*n(2)*a
      frame(:, 1) = [1.0_wp + up*n(1)**2*a, up*b, -up*n(1)]
      frame(:, 2) = [b, up + n(2)**2*a, -n(2)]
      frame(:, 3) = n
   end subroutine make_frame

   !> Transform a deviator to the frame.
   pure subroutine to_frame(frame, s, z)
      real(wp), intent(in) :: frame(3, 3)            !! Axis j in (:, j) [1]
      real(wp), intent(in) :: s(6)                   !! xx, yy, zz, xy, yz, xz
      type(harmonics_t), intent(out) :: z            !! Combinations of s in the frame
      real(wp) :: t(3, 3)

      ! The tensor times each axis.
      t(1, :) = s(1)*frame(1, :) + s(4)*frame(2, :) + s(6)*frame(3, :)
      t(2, :) = s(4)*frame(1, :) + s(2)*frame(2, :) + s(5)*frame(3, :)
      t(3, :) = s(6)*frame(1, :) + s(5)*frame(2, :) + s(3)*frame(3, :)
      z%along = dot_product(frame(:, 3), t(:, 3))
      z%first = cmplx(dot_product(frame(:, 1), t(:, 3)), dot_product(frame(:, 2), t(:, 3)), wp)
      z%second = cmplx(0.5_wp*(dot_product(frame(:, 1), t(:, 1)) &
         - dot_product(frame(:, 2), t(:, 2))), dot_product(frame(:, 1), t(:, 2)), wp)
   end subroutine to_frame

   !> Transform a deviator back from the frame.
   pure subroutine from_frame(frame, z, s)
      real(wp), intent(in) :: frame(3, 3)            !! Axis j in (:, j) [1]
      type(harmonics_t), intent(in) :: z             !! In the frame
      real(wp), intent(out) :: s(6)                  !! xx, yy, zz, xy, yz, xz
      real(wp) :: t(3, 3), m(3, 3)

      m(1, :) = [-0.5_wp*z%along + real(z%second, wp), aimag(z%second), real(z%first, wp)]
      m(2, :) = [aimag(z%second), -0.5_wp*z%along - real(z%second, wp), aimag(z%first)]
      m(3, :) = [real(z%first, wp), aimag(z%first), z%along]
      t = matmul(frame, m)
      s(1) = dot_product(t(1, :), frame(1, :))
      s(2) = dot_product(t(2, :), frame(2, :))
      s(3) = dot_product(t(3, :), frame(3, :))
      s(4) = dot_product(t(1, :), frame(2, :))
      s(5) = dot_product(t(2, :), frame(3, :))
      s(6) = dot_product(t(1, :), frame(3, :))
   end subroutine from_frame

   !> Deviator after the step, and its integral over the step.
   pure subroutine advance(modulus, k, angle, old, strain, new, total)
      real(wp), intent(in) :: modulus                !! 2 G [Pa]
      real(wp), intent(in) :: k                      !! Relaxation of the step [1]
      real(wp), intent(in) :: angle                  !! Rotation of the step [1]
      type(harmonics_t), intent(in) :: old           !! Before the step [Pa]
      type(harmonics_t), intent(in) :: strain        !! Increment [1]
      type(harmonics_t), intent(out) :: new          !! After the step [Pa]
      type(harmonics_t), intent(out) :: total        !! Integral [Pa]
      complex(wp) :: decay, f1, f2

      call functions(cmplx(k, 0.0_wp, wp), decay, f1, f2)
      new%along = real(decay, wp)*old%along + modulus*real(f1, wp)*strain%along
      total%along = real(f1, wp)*old%along + modulus*real(f2, wp)*strain%along
      call functions(cmplx(k, -angle, wp), decay, f1, f2)
      new%first = decay*old%first + modulus*f1*strain%first
      total%first = f1*old%first + modulus*f2*strain%first
      call functions(cmplx(k, -2.0_wp*angle, wp), decay, f1, f2)
      new%second = decay*old%second + modulus*f1*strain%second
      total%second = f1*old%second + modulus*f2*strain%second
   end subroutine advance

   !> exp(-y), f1(y) = (1 - exp(-y))/y and f2(y) = (1 - f1(y))/y, by their series where the
   !! differences would lose digits. The series is cut where the next term is below round-off: most
   !! steps turn and relax by less than a thousandth.
   pure subroutine functions(y, decay, f1, f2)
      complex(wp), intent(in) :: y                   !! Real part not below 0 [1]
      complex(wp), intent(out) :: decay              !! exp(-y)
      complex(wp), intent(out) :: f1                 !! 1 at 0
      complex(wp), intent(out) :: f2                 !! 1/2 at 0
      real(wp) :: size

      size = abs(real(y, wp)) + abs(aimag(y))
      if (size < 0.4_wp) then
         if (size < 1.0e-3_wp) then
            f2 = 0.5_wp + series(y, 4)
         else if (size < 0.03_wp) then
            f2 = 0.5_wp + series(y, 7)
         else
            f2 = 0.5_wp + series(y, 12)
         end if
         f1 = 1.0_wp - y*f2
         decay = 1.0_wp - y*f1
      else
         decay = exp(-y)
         f1 = (1.0_wp - decay)/y
         f2 = (1.0_wp - f1)/y
      end if
   end subroutine functions

   !> Sum of the terms (-y)**j/(j + 2)! with j from 1 to the given number, innermost first.
   pure complex(wp) function series(y, terms) result(total)
      complex(wp), intent(in) :: y                   !! Argument, below 1 [1]
      integer, intent(in) :: terms                   !! Power of the last term
      real(wp), parameter :: factor(12) = [-1.0_wp/6.0_wp, 1.0_wp/24.0_wp, -1.0_wp/120.0_wp, &
         1.0_wp/720.0_wp, -1.0_wp/5040.0_wp, 1.0_wp/40320.0_wp, -1.0_wp/362880.0_wp, &
         1.0_wp/3628800.0_wp, -1.0_wp/39916800.0_wp, 1.0_wp/479001600.0_wp, &
         -1.0_wp/6227020800.0_wp, 1.0_wp/87178291200.0_wp]
      integer :: j

      total = cmplx(factor(terms), 0.0_wp, wp)
      do j = terms - 1, 1, -1
         total = factor(j) + y*total
      end do
      total = y*total
   end function series

   !> Double contraction of two deviators.
   pure real(wp) function contract(a, b) result(total)
      type(harmonics_t), intent(in) :: a             !! One
      type(harmonics_t), intent(in) :: b

      total = 1.5_wp*a%along*b%along + 2.0_wp*real(a%first*conjg(b%first), wp) &
         + 2.0_wp*real(a%second*conjg(b%second), wp)
   end function contract
end module material_relaxation
