! SPDX-License-Identifier: BSD-3-Clause
!> The group &parallel: its keys and the conditions for moving tiles between ranks.
module scene_parallel
   use deck_reader, only: deck_t, group_t
   use deck_schema, only: changes_nothing, schema_t
   use step_load_balance, only: balancing_t
   implicit none
   private

   public :: declare_parallel, read_balancing

contains

   !> Declare &parallel.
   subroutine declare_parallel(schema)
      type(schema_t), intent(inout) :: schema            !! Keys of the deck

      call schema%group("parallel", &
         "distribution over ranks (load balancing); results do not depend on it")
      call schema%text("parallel", "balance", "load balancing: move tiles between ranks", &
         default="auto", words="auto never")
      call schema%integer("parallel", "balance_every", &
         "steps between two comparisons of the load of the ranks", default="25", range="> 0", &
         owner="balance = auto")
      call schema%real("parallel", "imbalance", "greatest over mean load above which tiles move", &
         default="1.1", range=">= 1", owner="balance = auto")
      call schema%allow_change("parallel", "*", changes_nothing)
   end subroutine declare_parallel

   !> Read the group &parallel.
   subroutine read_balancing(deck, balancing)
      type(deck_t), intent(in) :: deck
      type(balancing_t), intent(out) :: balancing    !! When tiles move
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
end module scene_parallel
