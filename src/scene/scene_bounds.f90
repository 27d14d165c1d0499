! SPDX-License-Identifier: BSD-3-Clause
!> Bounds of steps and particles as the deck gives them.
module scene_bounds
   use base_constants, only: unset
   use base_deck, only: deck_t, group_t
   use base_kinds, only: wp
   use step_bounds, only: bounds_t
   implicit none
   private

   public :: read_bounds

contains

   !> Read the bounds from the deck.
   subroutine read_bounds(deck, bounds)
      type(deck_t), intent(in) :: deck               !! The deck
      type(bounds_t), intent(out) :: bounds          !! What it says
      type(group_t) :: group
      character(len=:), allocatable :: word
      real(wp) :: number

      group = deck%group("time", 1)
      call group%get("volume_ratio_min", bounds%ratio_min)
      call group%get("volume_ratio_max", bounds%ratio_max)
      call group%get("speed_max", number)
      if (number > unset) bounds%speed_max = number
      call group%get("strain_max", bounds%strain_max)
      call group%get("dt_collapse", bounds%collapse)
      call group%get("dt_min", number)
      if (number > unset) bounds%dt_min = number
      call group%get("dt_fixed", number)
      call group%get("retry", bounds%dt_free)
      if (number > unset) bounds%dt_free = .false.
      call group%get("on_bad", word)
      bounds%retire = word == "retire"
      call group%get("retire_max", bounds%retire_max)
   end subroutine read_bounds
end module scene_bounds
