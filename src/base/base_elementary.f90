! SPDX-License-Identifier: BSD-3-Clause
!> Exponential function, natural logarithm and power of sums, products, quotients and bit operations
!! alone, without branches; the cross product.
!!
!! Compilers vectorise loops over them, and the vector body, the remainder and a single number have
!! the same bits. Those of the mathematics library differ between its scalar and its vector
!! variants, and from one version to the next. Errors are at most 0.65 units in the last place of
!! the exponential function, 0.9 of the logarithm and 0.8 of the power.
!!
!! Arguments are reduced to an interval around 1 or 0 by multiples of ln 2 in two parts (W. J. Cody,
!! W. Waite, Software Manual for the Elementary Functions, 1980). On this interval a polynomial
!! approximates the function, and the rounding errors of sums are added as corrections (T. J.
!! Dekker, Numer. Math. 18 (1971) 224), as P. T. P. Tang (ACM Trans. Math. Softw. 15 (1989) 144 and
!! 16 (1990) 378) does with tables.
module base_elementary
   use base_kinds, only: int64, wp
   implicit none
   private

   public :: cross, exponential, logarithm, power, take_exponentials, take_fast_powers, &
      take_logarithms, take_powers

   !> Adding it to a number below 2**51 leaves the nearest integer in the last bits of the sum.
   real(wp), parameter :: shifter = 6755399441055744.0_wp
   integer(int64), parameter :: shifter_bits = 4843621399236968448_int64
   integer(int64), parameter :: bits_of_one = 4607182418800017408_int64 !! 1.0
   integer(int64), parameter :: bits_of_root = 4604544271217802189_int64 !! sqrt(1/2)
   integer(int64), parameter :: fraction_bits = 4503599627370495_int64 !! Those below the exponent
   integer(int64), parameter :: upper_bits = not(134217727_int64) !! All but the last 27
   integer(int64), parameter :: infinity_bits = 9218868437227405312_int64
   integer(int64), parameter :: negative_infinity_bits = -4503599627370496_int64
   integer(int64), parameter :: nan_bits = 9221120237041090560_int64
   integer, parameter :: mantissa = 52                  !! Bits of the fraction
   real(wp), parameter :: per_ln2 = 1.4426950408889634_wp !! 1/ln 2
   real(wp), parameter :: ln2_high = 0.6931471805598903_wp !! Ends with 11 bits of zero
   real(wp), parameter :: ln2_low = 5.497923018708371e-14_wp !! Remainder of ln 2
   !> Beyond these bounds the exponential function is 0 or too large for a real.
   real(wp), parameter :: least_exponent = -746.0_wp, greatest_exponent = 710.0_wp

contains

   !> Exponential function of the sum of two numbers, |low| far below |high|.
   elemental real(wp) function exponential_of_sum(high, low) result(value)
      real(wp), intent(in) :: high                         !! Larger part
      real(wp), intent(in) :: low                          !! Smaller part
      !> Coefficients of (exp(r) - 1 - r - r**2/2)/r**3 for |r| <= ln(2)/2.
      real(wp), parameter :: c(10) = [0.16666666666666669_wp, 0.041666666666666664_wp, &
         0.008333333333330062_wp, 0.0013888888888886552_wp, 0.00019841269863053618_wp, &
         2.4801587317144498e-05_wp, 2.7557268459997064e-06_wp, 2.755728296954995e-07_wp, &
         2.510038549551032e-08_wp, 2.0911236630261545e-09_wp]
      real(wp) :: x, rest, number, half, other, r, r_low, r2, r4, tail, whole

      x = min_of(max_of(high, least_exponent), greatest_exponent)
      rest = merge(low, 0.0_wp, abs(high) < 1000.0_wp)
      number = (x*per_ln2 + shifter) - shifter
      ! Two factors replace the power of two, which alone could overflow or underflow.
      half = 0.5_wp*number + shifter
      other = (number - (half - shifter)) + shifter
      x = x - number*ln2_high
      rest = number*ln2_low - rest
      r = x - rest
      r_low = (x - r) - rest
      r2 = r*r
      r4 = r2*r2
      tail = ((c(1) + c(2)*r) + (c(3) + c(4)*r)*r2) + r4*((c(5) + c(6)*r) + (c(7) + c(8)*r)*r2 &
         + r4*(c(9) + c(10)*r))
      tail = r2*(0.5_wp + r*tail)
      whole = 1.0_wp + r
      value = whole + ((r - (whole - 1.0_wp)) + (tail + r_low*whole))
      value = value*power_of_two(half)*power_of_two(other)
   end function exponential_of_sum

   !> Two to the power of the integer in the last bits of a number.
   elemental real(wp) function power_of_two(shifted) result(value)
      real(wp), intent(in) :: shifted                      !! Integer plus `shifter`

      value = transfer(shiftl(transfer(shifted, 1_int64), mantissa) + bits_of_one, value)
   end function power_of_two

   !> Smaller of two numbers; the first if it is NaN.
   elemental real(wp) function min_of(x, bound) result(value)
      real(wp), intent(in) :: x, bound

      value = merge(bound, x, x > bound)
   end function min_of

   !> Larger of two numbers; the first if it is NaN.
   elemental real(wp) function max_of(x, bound) result(value)
      real(wp), intent(in) :: x, bound

      value = merge(bound, x, x < bound)
   end function max_of

   !> Upper half of the bits of a number, so that the product of two such is exact.
   elemental real(wp) function upper_half(x) result(value)
      real(wp), intent(in) :: x

      value = transfer(iand(transfer(x, 1_int64), upper_bits), value)
   end function upper_half

   !> Split x = 2**number (1 + fraction) with 1 + fraction between sqrt(1/2) and sqrt(2). Zero,
   !! negative numbers, infinity and NaN have some finite fraction.
   elemental subroutine split_number(x, number, fraction)
      real(wp), intent(in) :: x                            !! Number above 0
      real(wp), intent(out) :: number                      !! Integer
      real(wp), intent(out) :: fraction                    !! -0.293 to 0.414, exact
      real(wp), parameter :: two54 = 18014398509481984.0_wp
      integer(int64), parameter :: bias = shiftl(1024_int64, mantissa)
      logical :: small
      integer(int64) :: bits

      ! The exponent field of a subnormal number is not its exponent, so small numbers are
      ! multiplied by 2**54. The other factor is 1/2: with 1 the compiler would generate two
      ! branches.
      small = x < 1.0e-290_wp
      bits = transfer(x*merge(two54, 0.5_wp, small), bits) - bits_of_root
      fraction = transfer(iand(bits, fraction_bits) + bits_of_root, fraction) - 1.0_wp
      number = transfer(shiftr(bits + bias, mantissa) + shifter_bits, number) &
         - merge(shifter + 1078.0_wp, shifter + 1023.0_wp, small)
   end subroutine split_number

   !> Exponential function. It is 0 below -745.13 and infinite above 709.78.
   elemental real(wp) function exponential(x) result(value)
      real(wp), intent(in) :: x                            !! Argument

      value = exponential_of_sum(x, 0.0_wp)
   end function exponential

   !> Natural logarithm: -infinity of 0, NaN of negative numbers. ln(1 + f) is found as 2 artanh(s)
   !! with s = f/(2 + f), where f - f**2/2 is split off.
   elemental real(wp) function logarithm(x) result(value)
      real(wp), intent(in) :: x                            !! Argument
      !> Coefficients of (ln((1 + s)/(1 - s))/s - 2)/s**2 as a polynomial of s**2.
      real(wp), parameter :: c(7) = [0.666666666666667_wp, 0.3999999999989889_wp, &
         0.28571428626253836_wp, 0.22222211089379496_wp, 0.1818289243253687_wp, &
         0.15331611722055008_wp, 0.14617807153417325_wp]
      real(wp) :: number, f, s, z, z2, square, tail, high, low

      call split_number(x, number, f)
      s = f/(2.0_wp + f)
      z = s*s
      z2 = z*z
      tail = z*((c(1) + c(2)*z) + z2*((c(3) + c(4)*z) + z2*((c(5) + c(6)*z) + z2*c(7))))
      square = 0.5_wp*f*f
      high = number*ln2_high + f
      low = (number*ln2_high - high) + f
      value = high + (low + (number*ln2_low - (square - s*(square + tail))))
      value = merge(value, x, x <= huge(1.0_wp))
      value = merge(value, transfer(negative_infinity_bits, value), x > 0.0_wp)
      value = merge(value, transfer(nan_bits, value), x >= 0.0_wp)
   end function logarithm

   !> Power x**y of x >= 0; NaN of negative x, and 1 if y is 0.
   elemental real(wp) function power(x, y) result(value)
      real(wp), intent(in) :: x                            !! Base
      real(wp), intent(in) :: y                            !! Exponent

      value = power_of_any(x, bounded_exponent(y), power_of_zero(y), power_of_zero(-y))
   end function power

   !> Exponent within bounds beyond which the power of any base other than 1 is 0 or infinite.
   elemental real(wp) function bounded_exponent(y) result(value)
      real(wp), intent(in) :: y
      real(wp), parameter :: greatest = 36893488147419103232.0_wp

      value = min_of(max_of(y, -greatest), greatest)
   end function bounded_exponent

   !> Power 0**y, which is also infinity**(-y).
   elemental real(wp) function power_of_zero(y) result(value)
      real(wp), intent(in) :: y

      value = merge(0.0_wp, transfer(infinity_bits, value), y > 0.0_wp)
      value = merge(value, 1.0_wp, abs(y) > 0.0_wp)
   end function power_of_zero

   !> Power of any base. The logarithm is the sum of two numbers with an error of 2**-65, so that
   !! the power is also accurate where y ln(x) is large.
   elemental real(wp) function power_of_any(x, exponent, at_zero, at_infinity) result(value)
      real(wp), intent(in) :: x                            !! Base
      real(wp), intent(in) :: exponent                     !! Within its bounds
      real(wp), intent(in) :: at_zero                      !! Power of 0
      real(wp), intent(in) :: at_infinity                  !! Power of infinity
      real(wp) :: high, low, upper, main, rest

      call find_long_logarithm(x, high, low)
      upper = upper_half(exponent)
      main = upper_half(high)
      rest = (high - main) + low
      rest = exponent*rest + (exponent - upper)*main
      main = upper*main
      high = main + rest
      value = exponential_of_sum(high, (main - high) + rest)
      value = merge(value, at_zero, x > 0.0_wp)
      value = merge(at_infinity, value, x > huge(1.0_wp))
      value = merge(value, transfer(nan_bits, value), x >= 0.0_wp)
   end function power_of_any

   !> Natural logarithm as the sum of two numbers.
   !!
   !! With s = f/(2 + f) it is 2 s + s**3 (2/3 + ...). Products of upper halves are exact.
   elemental subroutine find_long_logarithm(x, high, low)
      real(wp), intent(in) :: x                            !! Number above 0
      real(wp), intent(out) :: high                        !! Logarithm
      real(wp), intent(out) :: low                         !! Rounding error of the result
      !> Coefficients of ((ln((1 + s)/(1 - s))/s - 2)/s**2 - 2/3)/s**2 as a polynomial of s**2.
      real(wp), parameter :: c(8) = [0.4_wp, 0.2857142857142937_wp, 0.22222222221652765_wp, &
         0.18181818336099848_wp, 0.1538459488700718_wp, 0.1333480879881234_wp, &
         0.11706126464563398_wp, 0.11724327060846747_wp]
      real(wp), parameter :: third = 2.0_wp/3.0_wp, third_low = 3.700743415417188e-17_wp
      real(wp) :: number, f, d, d_low, inverse, s, s_low, z, z_low, z2, z4, u, u_low, v, v_low, t

      call split_number(x, number, f)
      d = 2.0_wp + f
      d_low = f - (d - 2.0_wp)
      inverse = 1.0_wp/d
      s = upper_half(f*inverse)
      z = upper_half(d)
      s_low = (((f - s*z) - s*(d - z)) - s*d_low)*inverse
      z = s*s
      z_low = s_low*(2.0_wp*s + s_low)
      v = z + z_low
      z2 = v*v
      z4 = z2*z2
      t = v*(((c(1) + c(2)*v) + z2*(c(3) + c(4)*v)) + z4*((c(5) + c(6)*v) + z2*(c(7) + c(8)*v)))
      u = third + t
      u_low = (t - (u - third)) + third_low
      ! v = z u, then t = s v
      t = upper_half(u)
      u_low = (u - t) + u_low
      v = upper_half(z)
      z_low = (z - v) + z_low
      v_low = z_low*(t + u_low) + v*u_low
      v = v*t
      t = upper_half(v)
      v_low = s*((v - t) + v_low) + s_low*(v + v_low)
      t = s*t
      ! 2 s + t, then the multiple of ln 2
      s = 2.0_wp*s
      u = s + t
      u_low = ((s - u) + t) + (2.0_wp*s_low + v_low)
      high = number*ln2_high + u
      low = ((number*ln2_high - high) + u) + (u_low + number*ln2_low)
      t = high + low
      low = (high - t) + low
      high = t
   end subroutine find_long_logarithm

   !> Exponential functions in place of numbers.
   pure subroutine take_exponentials(count, x)
      integer, intent(in) :: count                         !! Numbers
      real(wp), contiguous, intent(inout) :: x(:)          !! (at least count)
      integer :: i

      !$omp simd
      do i = 1, count
         x(i) = exponential(x(i))
      end do
   end subroutine take_exponentials

   !> Natural logarithms in place of numbers.
   pure subroutine take_logarithms(count, x)
      integer, intent(in) :: count                         !! Numbers
      real(wp), contiguous, intent(inout) :: x(:)          !! (at least count)
      integer :: i

      !$omp simd
      do i = 1, count
         x(i) = logarithm(x(i))
      end do
   end subroutine take_logarithms

   !> Powers with one exponent; they overwrite their bases.
   pure subroutine take_powers(count, exponent, x)
      integer, intent(in) :: count                         !! Numbers
      real(wp), intent(in) :: exponent                     !! Common exponent of all bases
      real(wp), contiguous, intent(inout) :: x(:)          !! (at least count)
      real(wp) :: bounded, at_zero, at_infinity
      integer :: i

      bounded = bounded_exponent(exponent)
      at_zero = power_of_zero(exponent)
      at_infinity = power_of_zero(-exponent)
      !$omp simd
      do i = 1, count
         x(i) = power_of_any(x(i), bounded, at_zero, at_infinity)
      end do
   end subroutine take_powers

   !> Powers with one exponent, which overwrite their bases, as exp(y ln(x)). This takes less than
   !! half of the time of `take_powers`; the error is about 1 + |y ln(x)| units in the last place.
   !! The power of 0 is 0 if the exponent is above 0.01.
   pure subroutine take_fast_powers(count, exponent, x)
      integer, intent(in) :: count                         !! Numbers
      real(wp), intent(in) :: exponent                     !! Common exponent of all bases
      real(wp), contiguous, intent(inout) :: x(:)          !! (at least count)
      real(wp), parameter :: least = -1.0e5_wp
      integer :: i

      !$omp simd
      do i = 1, count
         x(i) = exponential(exponent*max_of(logarithm(x(i)), least))
      end do
   end subroutine take_fast_powers

   !> Cross product.
   pure function cross(a, b) result(product)
      real(wp), intent(in) :: a(3), b(3)                   !! Vectors
      real(wp) :: product(3)

      product = [a(2)*b(3) - a(3)*b(2), a(3)*b(1) - a(1)*b(3), a(1)*b(2) - a(2)*b(1)]
   end function cross
end module base_elementary
