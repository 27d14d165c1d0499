! SPDX-License-Identifier: BSD-3-Clause
!> Protects the results of a previous run in the same folder: a new run is refused, continues it, or
!! removes it, depending on the command line.
module program_existing_results
   use base_agreement, only: agree
   use base_error, only: error_t, exit_file, fail
   use output_former_run, only: find_former_run, former_run_t, is_own_checkpoint, remove_former_run
   use program_run_setup, only: run_setup_t
   implicit none
   private

   public :: existing_results_text, protect_results

contains

   !> Refuse a run that would overwrite results, unless --overwrite removes them. Collective.
   subroutine protect_results(setup, error)
      class(run_setup_t), intent(in) :: setup        !! Complete, without particles
      type(error_t), allocatable, intent(out) :: error !! Results exist or cannot be removed
      type(former_run_t) :: former

      associate (communicator => setup%simulation%machine%communicator, command => setup%command, &
         outputs => setup%outputs)
         if (communicator%rank == 0) then
            call find_former_run(outputs%folder, outputs%case, outputs%header%echo, former)
            if (command%restart) then
               if (former%results .and. allocated(command%checkpoint)) then
                  if (.not. is_own_checkpoint(outputs%folder, outputs%case, &
                     command%checkpoint)) call fail(error, exit_file, location_text(setup)// &
                     " and '"//command%checkpoint//"' is not of that run; give another "// &
                     "--outdir or --case")
               end if
            else if (command%output%overwrite) then
               call remove_former_run(outputs%folder, former, error)
            else if (former%results) then
               call fail(error, exit_file, location_text(setup)//options_text(former))
            end if
         end if
         call agree(communicator, error)
      end associate
   end subroutine protect_results

   !> Warning of a check that a run would be refused because of existing results; else empty.
   function existing_results_text(setup) result(text)
      class(run_setup_t), intent(in) :: setup        !! Complete, without particles
      character(len=:), allocatable :: text
      type(former_run_t) :: former

      text = ""
      if (setup%command%output%overwrite) return
      call find_former_run(setup%outputs%folder, setup%outputs%case, setup%outputs%header%echo, &
         former)
      if (former%results) text = "warning: "//location_text(setup)//options_text(former)
   end function existing_results_text

   !> Case and folder of the results.
   function location_text(setup) result(text)
      class(run_setup_t), intent(in) :: setup
      character(len=:), allocatable :: text

      text = "results of case '"//setup%outputs%case//"' are in '"//setup%outputs%folder// &
         "' already"
   end function location_text

   !> Options of the user for existing results.
   pure function options_text(former) result(text)
      type(former_run_t), intent(in) :: former
      character(len=:), allocatable :: text

      if (former%checkpoints) then
         text = ": continue with --restart, or remove them with --overwrite"
      else
         text = ", without a checkpoint from which the run could continue: remove them with "// &
            "--overwrite"
      end if
      text = text//"; or give another --outdir or --case"
   end function options_text
end module program_existing_results
