! SPDX-License-Identifier: BSD-3-Clause
!> Keys of the deck that say how the run is spread over the machine.
module scene_deck_output
   use base_schema, only: schema_t
   implicit none
   private

   public :: declare_parallel

contains

   !> Declare &parallel.
   subroutine declare_parallel(schema)
      type(schema_t), intent(inout) :: schema            !! Keys of the deck

      call schema%group("parallel", "distribution over ranks; results do not depend on it")
      call schema%text("parallel", "balance", "move tiles between ranks", default="auto", &
         words="auto never")
      call schema%integer("parallel", "balance_every", "steps between two looks at the work", &
         default="25", range="> 0", owner="balance = auto")
      call schema%real("parallel", "imbalance", "greatest over mean work that moves tiles", &
         default="1.1", range=">= 1", owner="balance = auto")
      call schema%former("parallel", "balance = every", becomes="balance = auto")
      call schema%former("parallel", "layout", becomes="", doc="ranks share the tiles along a "// &
         "curve through the box, and results do not depend on it", holds=.true.)
   end subroutine declare_parallel
end module scene_deck_output
