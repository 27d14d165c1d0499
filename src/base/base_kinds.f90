! SPDX-License-Identifier: BSD-3-Clause
!> Kinds of numbers, used by every literal and every declaration of the code.
module base_kinds
   use, intrinsic :: iso_fortran_env, only: int32_kind => int32, int64_kind => int64, real64
   implicit none
   private

   integer, parameter, public :: wp = real64           !! Working precision of all fields
   integer, parameter, public :: int32 = int32_kind    !! Local indices
   integer, parameter, public :: int64 = int64_kind    !! Identities, keys, global counts
end module base_kinds
