! SPDX-License-Identifier: BSD-3-Clause
!> What &run says about the space and the gradient of a scene: the directions that it has, checks
!! that vectors have no other components, and the choice of the dual domain gradient.
module scene_dimension
   use base_kinds, only: wp
   use deck_reader, only: deck_t, group_t
   implicit none
   private

   public :: check_plane, is_axisymmetric, is_dual, read_dimension

   character(len=1), parameter, public :: axis_names(3) = ["x", "y", "z"]

contains

   !> Dimension of the scene, empty if invalid, and its active directions.
   subroutine read_dimension(deck, dimension, active)
      type(deck_t), intent(in) :: deck
      character(len=:), allocatable, intent(out) :: dimension !! As in the deck
      logical, intent(out) :: active(3)                  !! It has this direction
      type(group_t) :: run

      run = deck%group("run")
      call run%get("dimension", dimension)
      active = [.true., dimension == "3d", dimension /= "1d"]
   end subroutine read_dimension

   !> Is the scene axisymmetric?
   logical function is_axisymmetric(deck) result(yes)
      type(deck_t), intent(in) :: deck
      character(len=:), allocatable :: dimension
      logical :: active(3)

      call read_dimension(deck, dimension, active)
      yes = dimension == "axisymmetric"
   end function is_axisymmetric

   !> Does the scene use the dual domain gradient?
   logical function is_dual(deck) result(yes)
      type(deck_t), intent(in) :: deck
      character(len=:), allocatable :: method
      type(group_t) :: run

      run = deck%group("run")
      call run%get("method", method)
      yes = method == "ddmp"
   end function is_dual

   !> A vector must not leave the directions of the scene.
   subroutine check_plane(deck, group, key)
      type(deck_t), intent(inout) :: deck
      type(group_t), intent(in) :: group
      character(len=*), intent(in) :: key
      character(len=:), allocatable :: dimension
      logical :: active(3)
      real(wp) :: vector(3)
      integer :: k

      if (.not. (group%given(key) .and. group%known(key))) return
      call read_dimension(deck, dimension, active)
      if (dimension == "") return
      call group%get(key, vector)
      do k = 1, 3
         if (active(k) .or. abs(vector(k)) <= 0.0_wp) cycle
         call deck%add_error(group, key//" must be 0 in "//axis_names(k)//", as dimension = '"// &
            dimension//"' [D332]", key)
      end do
   end subroutine check_plane
end module scene_dimension
