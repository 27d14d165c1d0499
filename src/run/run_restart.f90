! SPDX-License-Identifier: BSD-3-Clause
!> Continues a run from a checkpoint, and reports how its deck differs from that of the checkpoint.
module run_restart
   use base_error, only: error_t, exit_file, fail
   use base_kinds, only: wp
   use base_log, only: log_t
   use base_text, only: brief
   use deck_changes, only: changes_t
   use output_checkpoint, only: resume
   use run_setup, only: run_setup_t
   use run_stop_criteria, only: is_finished
   implicit none
   private

   public :: log_restart, restart_run

contains

   !> Read the particles from the checkpoint of the command line, or from the newest valid one.
   subroutine restart_run(setup, note, changes, error)
      class(run_setup_t), intent(inout) :: setup     !! Gets particles
      character(len=:), allocatable, intent(out) :: note !! Text for the log
      type(changes_t), intent(out) :: changes        !! Changes of the deck since the checkpoint
      type(error_t), allocatable, intent(out) :: error !! No valid checkpoint, or the run has ended
      character(len=:), allocatable :: file
      logical :: ended

      file = ""
      if (allocated(setup%options%checkpoint)) file = setup%options%checkpoint
      call resume(setup%simulation, setup%outputs, setup%place, file, note, changes, error)
      if (allocated(error)) return
      associate (simulation => setup%simulation, limits => setup%limits)
         ! a state exactly at the new end of the run is its result; a later state is an error
         ended = len(changes%end) > 0 .and. (simulation%clock%step > limits%max_steps .or. &
            simulation%clock%time > limits%time_end*(1.0_wp + 1.0e-9_wp))
         if (changes%state() .and. .not. ended) ended = is_finished(simulation, limits) .or. &
            setup%outputs%stop_quantity%is_reached(simulation%clock%step)
         ! the last step of a run ends at t_end
         if (.not. (ended .or. simulation%clock%time <= limits%time_end*(1.0_wp + 1.0e-9_wp))) &
            call fail(error, exit_file, note//": its time, "//brief(simulation%clock%time)// &
            " s, is after t_end = "//brief(limits%time_end)//" s; raise t_end, or start again "// &
            "with --overwrite [F110]")
         if (allocated(error)) return
      end associate
      if (ended) call fail(error, exit_file, note//": the run is finished, so these changes "// &
         "of the deck would have no effect (values in SI): [F110]"//changes%physics//changes%end// &
         changes%extent//new_line("a")// &
         "raise the end of the run (t_end, max_steps), or start again in another folder "// &
         "(--outdir) or with --overwrite")
   end subroutine restart_run

   !> Log the checkpoint and the changes of the deck.
   subroutine log_restart(log, note, changes)
      type(log_t), intent(inout) :: log              !! Gets the lines
      character(len=*), intent(in) :: note           !! From `restart_run`
      type(changes_t), intent(in) :: changes         !! From `restart_run`

      ! a note of several lines lists checkpoints that cannot be read
      if (index(note, new_line("a")) > 0) then
         call log%warn(note)
      else
         call log%info(note)
      end if
      if (len(changes%physics) > 0) call log%warn("warning: these changes affect the rest of "// &
         "the run (values in SI): [F110]"//changes%physics)
      if (len(changes%end//changes%extent//changes%nothing) > 0) call log%info( &
         "the deck has changed since (in SI):"//changes%end//changes%extent//changes%nothing)
   end subroutine log_restart
end module run_restart
