! SPDX-License-Identifier: BSD-3-Clause
!> Load balancing as the deck asks for it.
module scene_load_balance
   use base_deck, only: deck_t, group_t
   use step_load_balance, only: balancing_t
   implicit none
   private

   public :: read_balancing

contains

   !> Read the group &parallel.
   subroutine read_balancing(deck, balancing)
      type(deck_t), intent(in) :: deck               !! The deck
      type(balancing_t), intent(out) :: balancing    !! What it says
      type(group_t) :: group
      character(len=:), allocatable :: word
      integer :: every

      group = deck%group("parallel")
      call group%get("balance", word)
      balancing%allowed = word == "auto"
      if (.not. balancing%allowed) return
      call group%get("balance_every", every)
      balancing%every = every
      call group%get("imbalance", balancing%tolerance)
   end subroutine read_balancing
end module scene_load_balance
