! SPDX-License-Identifier: BSD-3-Clause
!> Fields that particles carry for outputs only; no law uses them.
module material_record
   use base_kinds, only: wp
   use base_text, only: text_t
   use deck_reader, only: deck_t, group_t
   implicit none
   private

   public :: add_strain, read_record, record_t

   !> Fields that outputs request.
   type :: record_t
      logical :: strain = .false.                    !! equivalent_strain
      logical :: inertia = .false.                   !! inertial_number, of laws with grains
   end type record_t

contains

   !> Fields that the outputs of a deck request.
   function read_record(deck) result(record)
      type(deck_t), intent(in) :: deck
      type(record_t) :: record
      type(group_t) :: group
      type(text_t), allocatable :: names(:)
      integer :: n, place

      do place = 1, deck%count("output")
         group = deck%group("output", place)
         call group%list("fields", names)
         do n = 1, size(names)
            record%strain = record%strain .or. names(n)%text == "equivalent_strain"
            record%inertia = record%inertia .or. names(n)%text == "inertial_number"
         end do
      end do
   end function read_record

   !> Add the equivalent strain sqrt(2/3 e:e) of the step, e the deviator of the symmetric gradient.
   !! Simple shear by an angle of tangent g adds g/sqrt(3). Equation (A.18) of doc/theory/matter.md.
   pure subroutine add_strain(first, last, plane, gradient, strain)
      integer, intent(in) :: first, last             !! Particles of the range
      logical, intent(in) :: plane !! Plane motion: components with one index y are 0
      real(wp), contiguous, intent(in) :: gradient(:, :) !! dt du_k/dx_l (range, 9) [1]
      real(wp), contiguous, intent(inout) :: strain(:)   !! (store) [1]
      real(wp) :: mean, square
      integer :: i, k

      if (plane) then
         do concurrent (i=1:last - first + 1)
            k = first - 1 + i
            mean = (gradient(i, 1) + gradient(i, 5) + gradient(i, 9))/3.0_wp
            square = (gradient(i, 1) - mean)**2 + (gradient(i, 5) - mean)**2 &
               + (gradient(i, 9) - mean)**2 + 0.5_wp*(gradient(i, 3) + gradient(i, 7))**2
            strain(k) = strain(k) + sqrt(2.0_wp/3.0_wp*square)
         end do
         return
      end if
      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         mean = (gradient(i, 1) + gradient(i, 5) + gradient(i, 9))/3.0_wp
         square = (gradient(i, 1) - mean)**2 + (gradient(i, 5) - mean)**2 &
            + (gradient(i, 9) - mean)**2 + 0.5_wp*((gradient(i, 2) + gradient(i, 4))**2 &
            + (gradient(i, 6) + gradient(i, 8))**2 + (gradient(i, 3) + gradient(i, 7))**2)
         strain(k) = strain(k) + sqrt(2.0_wp/3.0_wp*square)
      end do
   end subroutine add_strain
end module material_record
