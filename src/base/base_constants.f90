! SPDX-License-Identifier: BSD-3-Clause
!> Constants used in several layers.
module base_constants
   use base_kinds, only: wp
   implicit none
   private

   real(wp), parameter, public :: pi = 3.14159265358979323846264338327950288_wp
   !> Components of a symmetric tensor are stored in the order of VTK: xx, yy, zz, xy, yz, xz.
   integer, parameter, public :: xx = 1, yy = 2, zz = 3, xy = 4, yz = 5, xz = 6
   !> Index of the component (k, l) of a tensor in its symmetric storage.
   integer, parameter, public :: symmetric(3, 3) = reshape([xx, xy, xz, xy, yy, yz, xz, yz, zz], &
      [3, 3])
   integer, parameter, public :: most_lanes = 64         !! Particles that a kernel treats together
   !> A value that is not set.
   real(wp), parameter, public :: unset = -huge(1.0_wp)
end module base_constants
