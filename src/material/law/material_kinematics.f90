! SPDX-License-Identifier: BSD-3-Clause
!> Kernels that turn a velocity gradient into volume, rotation and trial stress.
module material_kinematics
   use base_kinds, only: wp
   use material_state, only: deformation_t, material_state_t
   implicit none
   private

   public :: centre_backward, centre_gradient, corotate_strain, deform, dilate, follow_motion, &
      predict_deviator, strain_rate

   real(wp), parameter :: third = 1.0_wp/3.0_wp, twelfth = 1.0_wp/12.0_wp

contains

   !> Refer velocity gradients times the time step to the middle of the step: with A = I + G/2 the
   !! gradient G of the start becomes G A^-1.
   !!
   !! The positions after a step are x + G x. A rotation then has no strain, however long the step,
   !! and the volume grows by det(I + G) to third order, so that volume and positions stay
   !! consistent in a shock (T. J. R. Hughes, J. Winget, Int. J. Numer. Methods Eng. 15 (1980)
   !! 1862). Equation (M.18) of doc/theory/method.md.
   pure subroutine centre_gradient(count, plane, gradient)
      integer, intent(in) :: count                         !! Particles
      logical, intent(in) :: plane !! Plane motion: components with one index y are 0
      real(wp), contiguous, intent(inout) :: gradient(:, :) !! (particle, 9) (k, l) in k + 3 (l - 1)
      real(wp) :: g(9), b(9), minors, cube, inverse
      integer :: i

      if (plane) then
         call centre_plane(count, gradient)
         return
      end if
      !$omp simd private(g, b, minors, cube, inverse)
      do i = 1, count
         g(:) = gradient(i, 1:9)
         ! The adjugate B of G gives that of A and its determinant, so no product of matrices
         ! remains: G A^-1 = (G - B/2 + (tr B/2 + det G/4) I)/det A. Unlike in 2 (I - A^-1) small
         ! gradients lose no digits.
         b(1) = g(5)*g(9) - g(8)*g(6)
         b(2) = g(8)*g(3) - g(2)*g(9)
         b(3) = g(2)*g(6) - g(5)*g(3)
         b(4) = g(7)*g(6) - g(4)*g(9)
         b(5) = g(1)*g(9) - g(7)*g(3)
         b(6) = g(4)*g(3) - g(1)*g(6)
         b(7) = g(4)*g(8) - g(7)*g(5)
         b(8) = g(7)*g(2) - g(1)*g(8)
         b(9) = g(1)*g(5) - g(4)*g(2)
         cube = 0.25_wp*(g(1)*b(1) + g(4)*b(2) + g(7)*b(3))
         minors = 0.5_wp*(b(1) + b(5) + b(9)) + cube
         ! For an inverting gradient the middle of the step is undefined; bounds keep the result
         ! finite, and the next time step limits it.
         inverse = 1.0_wp/max(1.0_wp + 0.5_wp*(g(1) + g(5) + g(9) + minors), 0.05_wp)
         gradient(i, 1) = (g(1) - 0.5_wp*b(1) + minors)*inverse
         gradient(i, 2) = (g(2) - 0.5_wp*b(2))*inverse
         gradient(i, 3) = (g(3) - 0.5_wp*b(3))*inverse
         gradient(i, 4) = (g(4) - 0.5_wp*b(4))*inverse
         gradient(i, 5) = (g(5) - 0.5_wp*b(5) + minors)*inverse
         gradient(i, 6) = (g(6) - 0.5_wp*b(6))*inverse
         gradient(i, 7) = (g(7) - 0.5_wp*b(7))*inverse
         gradient(i, 8) = (g(8) - 0.5_wp*b(8))*inverse
         gradient(i, 9) = (g(9) - 0.5_wp*b(9) + minors)*inverse
      end do
   end subroutine centre_gradient

   !> The same for plane motion: components with one index y are zero and are not used.
   pure subroutine centre_plane(count, gradient)
      integer, intent(in) :: count                         !! Particles
      real(wp), contiguous, intent(inout) :: gradient(:, :) !! (particle, 9) (k, l) in k + 3 (l - 1)
      real(wp) :: xx, zx, xz, zz, yy, a1, a3, a5, a7, a9, determinant, both, inverse
      integer :: i

      !$omp simd private(xx, zx, xz, zz, yy, a1, a3, a5, a7, a9, determinant, both, inverse)
      do i = 1, count
         xx = gradient(i, 1)
         zx = gradient(i, 3)
         yy = gradient(i, 5)
         xz = gradient(i, 7)
         zz = gradient(i, 9)
         a1 = 1.0_wp + 0.5_wp*xx
         a3 = 0.5_wp*zx
         a7 = 0.5_wp*xz
         a9 = 1.0_wp + 0.5_wp*zz
         ! bounds as above; those of the determinant of all three directions
         determinant = max(a1*a9 - a7*a3, 0.05_wp)
         a5 = max(1.0_wp + 0.5_wp*yy, 0.05_wp)
         both = 1.0_wp/(determinant*a5)
         inverse = a5*both
         gradient(i, 1) = (xx*a9 - xz*a3)*inverse
         gradient(i, 3) = (zx*a9 - zz*a3)*inverse
         gradient(i, 7) = (xz*a1 - xx*a7)*inverse
         gradient(i, 9) = (zz*a1 - zx*a7)*inverse
         gradient(i, 5) = yy*(determinant*both)
      end do
   end subroutine centre_plane

   !> Gradient at the middle of a step that has ended: positions were x - G x with the gradient
   !! at the new positions, so it is G (I - G/2)**-1. Equation (M.19).
   pure subroutine centre_backward(count, plane, gradient)
      integer, intent(in) :: count                   !! Particles
      logical, intent(in) :: plane !! Plane motion: components with one index y are 0
      real(wp), contiguous, intent(inout) :: gradient(:, :) !! (particle of the tile, 9)

      gradient(:count, 1:9) = -gradient(:count, 1:9)
      call centre_gradient(count, plane, gradient)
      gradient(:count, 1:9) = -gradient(:count, 1:9)
   end subroutine centre_backward

   !> Divisor of the growth of a volume or a temperature in a step, 1 + x over this divisor. It is
   !! the Pade approximant of order (2, 2) of the exponential function: relative error x**5/720,
   !! positive for every x, vectorises, and exactly 1 for 0. Equation (A.1) of doc/theory/matter.md.
   elemental real(wp) function growth_divisor(x) result(divisor)
      real(wp), intent(in) :: x                      !! Exponent [1]

      divisor = 1.0_wp - x*(0.5_wp - twelfth*x)
   end function growth_divisor

   !> Volume after the step, for material without a deviator of stress.
   pure subroutine dilate(state, deformation, first, last)
      type(material_state_t), intent(inout) :: state       !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp) :: trace
      integer :: i, k

      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         trace = deformation%gradient(i, 1) + deformation%gradient(i, 5) &
            + deformation%gradient(i, 9)
         deformation%dilatation(i) = trace
         deformation%old_volume(i) = state%volume(k)
         state%volume(k) = state%volume(k) + state%volume(k)*(trace/growth_divisor(trace))
      end do
   end subroutine dilate

   !> Volume and deformation gradient after the step: F becomes (I + G) F and the volume grows by
   !! det(I + G), where C = G (I + G/2)^-1 is given and so G = (I - C/2)^-1 C. Equation (Y.14) of
   !! doc/theory/strength.md.
   pure subroutine deform(state, deformation, first, last)
      type(material_state_t), intent(inout) :: state       !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      ! An inverted particle keeps a positive volume; the run then stops on its time step or stress.
      real(wp), parameter :: least_growth = 1.0e-3_wp
      real(wp) :: c(9), a(9), b(9), g(9), f(9), determinant, inverse
      integer :: i, k, row

      !$omp simd private(c, a, b, g, f, determinant, inverse, k, row)
      do i = 1, last - first + 1
         k = first - 1 + i
         c(:) = deformation%gradient(i, 1:9)
         a(:) = -0.5_wp*c
         f(:) = state%deformation_gradient(k, 1:9)
         deformation%dilatation(i) = c(1) + c(5) + c(9)
         a(1) = 1.0_wp + a(1)
         a(5) = 1.0_wp + a(5)
         a(9) = 1.0_wp + a(9)
         b(1) = a(5)*a(9) - a(8)*a(6)
         b(2) = a(8)*a(3) - a(2)*a(9)
         b(3) = a(2)*a(6) - a(5)*a(3)
         b(4) = a(7)*a(6) - a(4)*a(9)
         b(5) = a(1)*a(9) - a(7)*a(3)
         b(6) = a(4)*a(3) - a(1)*a(6)
         b(7) = a(4)*a(8) - a(7)*a(5)
         b(8) = a(7)*a(2) - a(1)*a(8)
         b(9) = a(1)*a(5) - a(4)*a(2)
         ! The determinant is 1/det(I + G/2), close to 1 in a step of normal length.
         inverse = 1.0_wp/max(a(1)*b(1) + a(4)*b(2) + a(7)*b(3), least_growth)
         do row = 1, 3
            g(row) = (b(row)*c(1) + b(row + 3)*c(2) + b(row + 6)*c(3))*inverse
            g(row + 3) = (b(row)*c(4) + b(row + 3)*c(5) + b(row + 6)*c(6))*inverse
            g(row + 6) = (b(row)*c(7) + b(row + 3)*c(8) + b(row + 6)*c(9))*inverse
         end do
         do row = 1, 3
            state%deformation_gradient(k, row) = f(row) &
               + (g(row)*f(1) + g(row + 3)*f(2) + g(row + 6)*f(3))
            state%deformation_gradient(k, row + 3) = f(row + 3) &
               + (g(row)*f(4) + g(row + 3)*f(5) + g(row + 6)*f(6))
            state%deformation_gradient(k, row + 6) = f(row + 6) &
               + (g(row)*f(7) + g(row + 3)*f(8) + g(row + 6)*f(9))
         end do
         g(1) = 1.0_wp + g(1)
         g(5) = 1.0_wp + g(5)
         g(9) = 1.0_wp + g(9)
         determinant = g(1)*(g(5)*g(9) - g(8)*g(6)) - g(4)*(g(2)*g(9) - g(8)*g(3)) &
            + g(7)*(g(2)*g(6) - g(5)*g(3))
         deformation%old_volume(i) = state%volume(k)
         state%volume(k) = state%volume(k)*max(determinant, least_growth)
      end do
   end subroutine deform

   !> Convert the gradient C, which refers to the middle of the step, to dt L with the constant
   !! velocity gradient L of the same motion, update the volume, and move the mean stress into
   !! `pressure`.
   !!
   !! From exp(dt L) = I + G follows dt L = 2 artanh(C/2) = C + C**3/12 + C**5/80 + C**7/448 +
   !! C**9/2304 + ... The next term is C**11/11264; for a full turn in 50 steps the stress lags by
   !! 1e-14. Equation (Y.20).
   pure subroutine follow_motion(state, deformation, first, last)
      type(material_state_t), intent(inout) :: state       !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp) :: c(3, 3), square(3, 3), rest(3, 3), mean
      integer :: i, k, axis

      do i = 1, last - first + 1
         k = first - 1 + i
         c(:, 1) = deformation%gradient(i, 1:3)
         c(:, 2) = deformation%gradient(i, 4:6)
         c(:, 3) = deformation%gradient(i, 7:9)
         square = matmul(c, c)
         rest = square/2304.0_wp
         do axis = 1, 3
            rest(axis, axis) = rest(axis, axis) + 1.0_wp/448.0_wp
         end do
         rest = matmul(square, rest)
         do axis = 1, 3
            rest(axis, axis) = rest(axis, axis) + 1.0_wp/80.0_wp
         end do
         rest = matmul(square, rest)
         do axis = 1, 3
            rest(axis, axis) = rest(axis, axis) + 1.0_wp/12.0_wp
         end do
         c = c + matmul(c, matmul(square, rest))
         deformation%gradient(i, 1:3) = c(:, 1)
         deformation%gradient(i, 4:6) = c(:, 2)
         deformation%gradient(i, 7:9) = c(:, 3)
         deformation%dilatation(i) = c(1, 1) + c(2, 2) + c(3, 3)
         deformation%old_volume(i) = state%volume(k)
         state%volume(k) = state%volume(k) + state%volume(k) &
            *(deformation%dilatation(i)/growth_divisor(deformation%dilatation(i)))
         mean = third*(state%stress(k, 1) + state%stress(k, 2) + state%stress(k, 3))
         deformation%pressure(i) = -mean
         state%stress(k, 1) = state%stress(k, 1) - mean
         state%stress(k, 2) = state%stress(k, 2) - mean
         state%stress(k, 3) = state%stress(k, 3) - mean
      end do
   end subroutine follow_motion

   !> Volume and elastic trial deviator of stress after the step, with the Jaumann rate.
   !!
   !! The rotation is that of T. J. R. Hughes, J. Winget, "Finite rotation effects in numerical
   !! integration of rate constitutive equations arising in large-deformation analysis", Int. J.
   !! Numer. Meth. Eng. 15 (1980) 1862, in closed form and orthogonal to round-off. Half of the
   !! strain is added before the rotation and half after it, so the step is of second order. On
   !! return the stress is a deviator and the pressure is the old mean pressure with its viscous
   !! part. Equation (A.2).
   pure subroutine predict_deviator(shear, state, deformation, first, last)
      real(wp), intent(in) :: shear                        !! Shear modulus [Pa]
      type(material_state_t), intent(inout) :: state       !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp) :: trace, mean, sxx, syy, szz, sxy, syz, sxz, dxx, dyy, dzz, dxy, dyz, dxz
      real(wp) :: wx, wy, wz, turn, divisor, inverse
      integer :: i, k

      if (deformation%plane) then
         call predict_plane(shear, state, deformation, first, last)
         return
      end if
      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         trace = deformation%gradient(i, 1) + deformation%gradient(i, 5) &
            + deformation%gradient(i, 9)
         deformation%dilatation(i) = trace
         deformation%old_volume(i) = state%volume(k)
         divisor = growth_divisor(trace)
         dxx = shear*(deformation%gradient(i, 1) - third*trace)
         dyy = shear*(deformation%gradient(i, 5) - third*trace)
         dzz = shear*(deformation%gradient(i, 9) - third*trace)
         dxy = 0.5_wp*shear*(deformation%gradient(i, 4) + deformation%gradient(i, 2))
         dyz = 0.5_wp*shear*(deformation%gradient(i, 8) + deformation%gradient(i, 6))
         dxz = 0.5_wp*shear*(deformation%gradient(i, 7) + deformation%gradient(i, 3))
         mean = third*(state%stress(k, 1) + state%stress(k, 2) + state%stress(k, 3))
         deformation%pressure(i) = -mean
         sxx = state%stress(k, 1) - mean + dxx
         syy = state%stress(k, 2) - mean + dyy
         szz = state%stress(k, 3) - mean + dzz
         sxy = state%stress(k, 4) + dxy
         syz = state%stress(k, 5) + dyz
         sxz = state%stress(k, 6) + dxz
         wx = 0.5_wp*(deformation%gradient(i, 6) - deformation%gradient(i, 8))
         wy = 0.5_wp*(deformation%gradient(i, 7) - deformation%gradient(i, 3))
         wz = 0.5_wp*(deformation%gradient(i, 2) - deformation%gradient(i, 4))
         ! One division for the growth of the volume and the rotation.
         turn = 1.0_wp + 0.25_wp*(wx*wx + wy*wy + wz*wz)
         inverse = 1.0_wp/(turn*divisor)
         state%volume(k) = state%volume(k) + state%volume(k)*(trace*(turn*inverse))
         call rotate(divisor*inverse, wx, wy, wz, sxx, syy, szz, sxy, syz, sxz)
         state%stress(k, 1) = sxx + dxx
         state%stress(k, 2) = syy + dyy
         state%stress(k, 3) = szz + dzz
         state%stress(k, 4) = sxy + dxy
         state%stress(k, 5) = syz + dyz
         state%stress(k, 6) = sxz + dxz
      end do
   end subroutine predict_deviator

   !> Replace the strain D of gradients by that of the frame at the end of the step, (D + Q D QT)/2
   !! with the rotation Q of the step, for laws that add a stress to the rotated one. Equation
   !! (Y.11) of doc/theory/strength.md.
   pure subroutine corotate_strain(deformation, count)
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: count                         !! Particles of the range
      real(wp) :: g(9), d(6), e(6), wx, wy, wz
      integer :: i

      do i = 1, count
         g(:) = deformation%gradient(i, 1:9)
         wx = 0.5_wp*(g(6) - g(8))
         wy = 0.5_wp*(g(7) - g(3))
         wz = 0.5_wp*(g(2) - g(4))
         d(:) = [g(1), g(5), g(9), 0.5_wp*(g(4) + g(2)), 0.5_wp*(g(8) + g(6)), &
            0.5_wp*(g(7) + g(3))]
         e(:) = d
         call rotate(1.0_wp/(1.0_wp + 0.25_wp*(wx*wx + wy*wy + wz*wz)), wx, wy, wz, e(1), e(2), &
            e(3), e(4), e(5), e(6))
         d(:) = 0.5_wp*(d + e)
         deformation%gradient(i, 1:9) = [d(1), d(4) + wz, d(6) - wy, d(4) - wz, d(2), d(5) + wx, &
            d(6) + wy, d(5) - wx, d(3)]
      end do
   end subroutine corotate_strain

   !> The same if y is decoupled: gradients and stresses with one index y are zero,
   !! and rotations are about y.
   pure subroutine predict_plane(shear, state, deformation, first, last)
      real(wp), intent(in) :: shear                        !! Shear modulus [Pa]
      type(material_state_t), intent(inout) :: state       !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp) :: trace, mean, sxx, szz, sxz, dxx, dyy, dzz, dxz, turn, a, c, s, half, rest, sheared
      real(wp) :: divisor, inverse
      integer :: i, k

      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         trace = deformation%gradient(i, 1) + deformation%gradient(i, 5) &
            + deformation%gradient(i, 9)
         deformation%dilatation(i) = trace
         deformation%old_volume(i) = state%volume(k)
         divisor = growth_divisor(trace)
         dxx = shear*(deformation%gradient(i, 1) - third*trace)
         dyy = shear*(deformation%gradient(i, 5) - third*trace)
         dzz = shear*(deformation%gradient(i, 9) - third*trace)
         dxz = 0.5_wp*shear*(deformation%gradient(i, 7) + deformation%gradient(i, 3))
         mean = third*(state%stress(k, 1) + state%stress(k, 2) + state%stress(k, 3))
         deformation%pressure(i) = -mean
         sxx = state%stress(k, 1) - mean + dxx
         szz = state%stress(k, 3) - mean + dzz
         sxz = state%stress(k, 6) + dxz
         ! cosine and sine of the rotation from z to x, by the tangent of its half; the mean of xx
         ! and zz does not change
         turn = 0.5_wp*(deformation%gradient(i, 7) - deformation%gradient(i, 3))
         half = 1.0_wp + 0.25_wp*turn*turn
         inverse = 1.0_wp/(half*divisor)
         state%volume(k) = state%volume(k) + state%volume(k)*(trace*(half*inverse))
         a = divisor*inverse
         c = 1.0_wp - 0.5_wp*a*turn*turn
         s = a*turn
         half = 0.5_wp*(sxx + szz)
         rest = 0.5_wp*(sxx - szz)
         sheared = c*sxz - s*rest
         rest = c*rest + s*sxz
         ! turned once; a tensor of second order turns twice
         sxz = c*sheared - s*rest
         rest = c*rest + s*sheared
         state%stress(k, 1) = half + rest + dxx
         state%stress(k, 2) = state%stress(k, 2) - mean + 2.0_wp*dyy
         state%stress(k, 3) = half - rest + dzz
         state%stress(k, 6) = sxz + dxz
      end do
   end subroutine predict_plane

   !> Rotate a symmetric tensor by the rotation Q = I + (W + W W/2)/(1 + w w/4) of the spin
   !! increment W with axial vector w. Equation (A.3).
   ! The components are scalars, so that they stay in registers.
   pure subroutine rotate(a, wx, wy, wz, sxx, syy, szz, sxy, syz, sxz)
      real(wp), intent(in) :: a                      !! 1/(1 + w w/4) [1]
      real(wp), intent(in) :: wx, wy, wz             !! Rotation vector of the step [1]
      real(wp), intent(inout) :: sxx, syy, szz       !! Diagonal of the tensor
      real(wp), intent(inout) :: sxy, syz, sxz       !! The other components
      real(wp) :: h, trace, q11, q12, q13, q21, q22, q23, q31, q32, q33
      real(wp) :: t11, t12, t13, t21, t22, t23

      trace = sxx + syy + szz
      h = 0.5_wp*a
      q11 = 1.0_wp - h*(wy*wy + wz*wz)
      q22 = 1.0_wp - h*(wx*wx + wz*wz)
      q33 = 1.0_wp - h*(wx*wx + wy*wy)
      q12 = h*wx*wy - a*wz
      q21 = h*wx*wy + a*wz
      q13 = h*wx*wz + a*wy
      q31 = h*wx*wz - a*wy
      q23 = h*wy*wz - a*wx
      q32 = h*wy*wz + a*wx
      t11 = q11*sxx + q12*sxy + q13*sxz
      t12 = q11*sxy + q12*syy + q13*syz
      t13 = q11*sxz + q12*syz + q13*szz
      t21 = q21*sxx + q22*sxy + q23*sxz
      t22 = q21*sxy + q22*syy + q23*syz
      t23 = q21*sxz + q22*syz + q23*szz
      sxx = t11*q11 + t12*q12 + t13*q13
      syy = t21*q21 + t22*q22 + t23*q23
      ! A rotation keeps the trace.
      szz = trace - sxx - syy
      sxy = t11*q21 + t12*q22 + t13*q23
      syz = t21*q31 + t22*q32 + t23*q33
      sxz = t11*q31 + t12*q32 + t13*q33
   end subroutine rotate

   !> Equivalent rate of strain, sqrt(2/3 d:d) of its deviator.
   pure subroutine strain_rate(count, gradient, dt, rate)
      integer, intent(in) :: count                   !! Particles of the range
      real(wp), contiguous, intent(in) :: gradient(:, :)  !! dt du_k/dx_l (range, 9) [1]
      real(wp), intent(in) :: dt                     !! Time step [s]
      real(wp), contiguous, intent(inout) :: rate(:) !! (range) [1/s]
      real(wp) :: mean
      integer :: i

      do concurrent (i=1:count)
         mean = (gradient(i, 1) + gradient(i, 5) + gradient(i, 9))/3.0_wp
         rate(i) = sqrt(2.0_wp/3.0_wp*((gradient(i, 1) - mean)**2 + (gradient(i, 5) - mean)**2 &
            + (gradient(i, 9) - mean)**2 + 0.5_wp*((gradient(i, 2) + gradient(i, 4))**2 &
            + (gradient(i, 3) + gradient(i, 7))**2 + (gradient(i, 6) + gradient(i, 8))**2)))/dt
      end do
   end subroutine strain_rate
end module material_kinematics
