! SPDX-License-Identifier: BSD-3-Clause
!> Pairs of grains that are near each other, the histories of their contacts, and the forces of
!! both.
!!
!! The rank of the first grain, which has the lower identity, owns the pair. A rank holds all pairs
!! of its own rows; both ranks of a pair compute the same bits.
module grains_pairs
   use base_kinds, only: wp
   implicit none
   private

   public :: pairs_t

   !> Words of a history. The losses are sums over the lifetime of the pair.
   integer, parameter, public :: tangent = 1 !! to 3: tangential force on the second grain [N]
   integer, parameter, public :: overlap = 4         !! [m]; 0 without contact
   integer, parameter, public :: dashpot = 5         !! Force of the dashpot [N]
   integer, parameter, public :: factor = 6          !! Stiffness factor q
   integer, parameter, public :: dashpot_loss = 7    !! Energy dissipated by the dashpot [J]
   integer, parameter, public :: slip_loss = 8       !! Energy dissipated by friction [J]
   integer, parameter, public :: step_loss = 9       !! Energy lost by the length of the step [J]
   integer, parameter, public :: birth_time = 10     !! When the contact closed [s]
   integer, parameter, public :: birth_strain = 11   !! Shear strain of the cell then [1]
   integer, parameter, public :: slips = 12          !! 1 if it slipped in the last step
   integer, parameter, public :: history_words = 12

   !> Data of the interaction of a pair. Forces act on the second grain.
   integer, parameter, public :: push_force = 1      !! to 3 [N]
   integer, parameter, public :: push_moment = 4     !! to 6: normal times tangential force [N]
   integer, parameter, public :: push_arm = 7        !! and 8: centres to the contact [m]
   integer, parameter, public :: push_branch = 9     !! to 11: first to second centre [m]
   integer, parameter, public :: push_words = 12

   !> Pairs of the own rows.
   type :: pairs_t
      integer :: count = 0
      integer, allocatable :: first(:)               !! (pair) Row of the lower identity
      integer, allocatable :: second(:)              !! (pair) Row of the higher one
      real(wp), allocatable :: shift(:, :)           !! (axis, pair) Edges added to the second
      real(wp), allocatable :: history(:, :)         !! (word, pair)
      real(wp), allocatable :: push(:, :)            !! (word, pair)
      integer, allocatable :: start(:)               !! (own row + 1) First index in `incident`
      integer, allocatable :: incident(:) !! Pairs of a row by the other's identity; < 0: as second
   contains
      procedure :: allocate => pairs_allocate        !! Reserve memory
      procedure :: touches => pairs_touches          !! Is a pair in contact?
   end type pairs_t

contains

   !> Allocate pairs without a history.
   pure subroutine pairs_allocate(self, count)
      class(pairs_t), intent(inout) :: self
      integer, intent(in) :: count                   !! Their number

      if (allocated(self%first)) deallocate (self%first, self%second, self%shift, self%history, &
         self%push)
      self%count = count
      allocate (self%first(count), self%second(count), self%shift(3, count))
      allocate (self%history(history_words, count), source=0.0_wp)
      allocate (self%push(push_words, count), source=0.0_wp)
   end subroutine pairs_allocate

   !> True if the grains of a pair touch.
   pure logical function pairs_touches(self, pair) result(touches)
      class(pairs_t), intent(in) :: self
      integer, intent(in) :: pair                    !! Number

      touches = self%history(overlap, pair) > 0.0_wp
   end function pairs_touches
end module grains_pairs
