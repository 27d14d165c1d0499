! SPDX-License-Identifier: BSD-3-Clause
!> Hints for the files of a run: those for the file system of its folder, and those of its deck.
module run_file_hints
   use base_text, only: text_t
   use io_hints, only: add_hint, file_system_of, hints_for, hints_t
   use run_cost_report, only: checkpoint_bytes
   use run_setup, only: run_setup_t
   use scene_parallel, only: read_hints
   implicit none
   private

   public :: set_file_hints

contains

   !> Set the hints, and describe them in a line for the log, which is empty without hints. With one
   !! rank there are none: it writes without MPI. Collective.
   subroutine set_file_hints(setup, folder, note)
      class(run_setup_t), intent(inout) :: setup     !! Complete, without particles
      character(len=*), intent(in) :: folder         !! Existing folder of the results
      character(len=:), allocatable, intent(out) :: note !! Line for the log
      character(len=:), allocatable :: file_system
      type(hints_t) :: hints
      type(text_t), allocatable :: names(:), values(:)
      logical :: automatic
      integer :: n

      note = ""
      associate (communicator => setup%simulation%machine%communicator)
         if (communicator%size == 1) return
         call read_hints(setup%deck, automatic, names, values)
         file_system = ""
         if (communicator%rank == 0 .and. automatic) file_system = file_system_of(folder)
         call communicator%broadcast(file_system)
         call hints_for(file_system, checkpoint_bytes(setup%simulation, setup%survey), hints)
         do n = 1, size(names)
            call add_hint(hints, names(n)%text, values(n)%text)
         end do
         call communicator%set_hints(hints%names, hints%values)
         if (size(hints%names) == 0) return
         note = "io hints  "//hints%report()
         if (file_system /= "") note = note//" ("//file_system//")"
      end associate
   end subroutine set_file_hints
end module run_file_hints
