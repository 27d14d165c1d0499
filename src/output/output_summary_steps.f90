! SPDX-License-Identifier: BSD-3-Clause
!> Steps and times in the log and the summary.
module output_summary_steps
   use base_kinds, only: wp
   use base_text, only: number
   use io_summary, only: json_t
   use step_bounds, only: guard_t, rule_names, rules
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: add_rules, steps_text

contains

   !> The number of steps, their limits, and the times spent.
   function steps_text(simulation, wall, worked) result(text)
      type(simulation_t), intent(in) :: simulation   !! The run at its end
      real(wp), intent(in) :: wall                   !! Wall time of the whole call [s]
      real(wp), intent(in) :: worked                 !! Processor time of the steps, all ranks [s]
      character(len=:), allocatable :: text
      character(len=16) :: part(2)

      text = "steps     "//number(simulation%clock%step)//", "//rules_text(simulation%clock%guard)
      write (part, "(f16.1)") wall, worked
      text = text//new_line("a")//"time      wall "//trim(adjustl(part(1)))// &
         " s with start and output, processor "//trim(adjustl(part(2)))// &
         " s in the steps of all ranks"
   end function steps_text

   !> Limits of the steps of this call of the program, as a line of text.
   function rules_text(guard) result(text)
      type(guard_t), intent(in) :: guard             !! With the counts
      character(len=:), allocatable :: text
      character(len=40) :: part
      integer :: rule

      text = "limited by"
      do rule = 1, rules
         if (guard%steps(rule) == 0) cycle
         write (part, "(f8.2,a)") 100.0_wp*real(guard%steps(rule), wp) &
            /real(sum(guard%steps), wp), " %"
         if (text(len(text):) == "%") text = text//","
         text = text//" "//trim(rule_names(rule))//" "//trim(adjustl(part))
      end do
   end function rules_text

   !> The same for scripts: the numbers of steps by their limits.
   subroutine add_rules(json, guard)
      type(json_t), intent(inout) :: json
      type(guard_t), intent(in) :: guard             !! With the counts
      integer :: rule

      call json%begin("steps_limited_by")
      do rule = 1, rules
         call json%add(trim(rule_names(rule)), guard%steps(rule))
      end do
      call json%end()
   end subroutine add_rules
end module output_summary_steps
