! SPDX-License-Identifier: BSD-3-Clause
!> Protects the results of another run in the same folder: while it runs, a new run is refused. When
!! it has ended, a new run is refused, continues it, or removes it, depending on the command line.
module run_existing_results
   use base_agreement, only: agree
   use base_error, only: error_t, exit_file, fail, without_code
   use base_libc, only: c_usleep
   use base_log, only: log_t
   use io_lock, only: lock_refused, lock_unclear
   use, intrinsic :: iso_c_binding, only: c_int
   use output_former_run, only: find_former_run, former_run_t, is_own_checkpoint, remove_former_run
   use run_setup, only: run_setup_t
   implicit none
   private

   public :: existing_results_text, lock_case, protect_results

   !> Note of a run that --restart starts from the first step
   character(len=*), parameter, public :: nothing_to_restart = &
      "there are no results of this case to continue, so --restart starts it at step 0"

contains

   !> Make this run the only one that writes files of its case. A run on another host is waited for
   !! until it gives a sign of life, or has given none for so long that it must have ended.
   !! Collective.
   subroutine lock_case(setup, log, error)
      class(run_setup_t), intent(inout) :: setup     !! With the names of the outputs; gets the lock
      type(log_t), intent(inout) :: log              !! Gets what was found
      type(error_t), allocatable, intent(out) :: error !! Another run writes them
      integer(c_int), parameter :: pause = 200000    ! microseconds
      integer(c_int) :: ignored
      integer :: verdict
      logical :: waits

      associate (communicator => setup%simulation%machine%communicator, lock => setup%lock, &
         outputs => setup%outputs)
         waits = .false.
         do while (communicator%rank == 0)
            call lock%take(outputs%folder, outputs%case, verdict, error)
            if (allocated(error) .or. verdict /= lock_unclear) exit
            if (.not. waits) call log%info("waiting until it is clear whether "//lock%message// &
               ", still runs: a lock of another host without a sign of life for 10 minutes is "// &
               "taken over")
            waits = .true.
            ignored = c_usleep(pause)
         end do
         if (communicator%rank == 0 .and. .not. allocated(error)) then
            if (verdict == lock_refused) then
               call fail(error, exit_file, "case '"//outputs%case//"' in '"//outputs%folder// &
                  "' is in use by "//lock%message//": wait for its end or stop it; or give "// &
                  "another --outdir or --case [F125]")
            else if (allocated(lock%message)) then
               call log%info(lock%message)
            end if
         end if
         call agree(communicator, error)
      end associate
   end subroutine lock_case

   !> Refuse a run that would overwrite results, unless --overwrite removes them. Without any
   !! results a restart from the newest checkpoint becomes a run from the first step. Collective.
   subroutine protect_results(setup, fresh, error)
      class(run_setup_t), intent(inout) :: setup     !! Complete, without particles
      logical, intent(out) :: fresh                  !! Is it a restart without results?
      type(error_t), allocatable, intent(out) :: error !! Results exist or cannot be removed
      type(former_run_t) :: former

      fresh = .false.
      associate (communicator => setup%simulation%machine%communicator, options => setup%options, &
         outputs => setup%outputs)
         if (communicator%rank == 0) then
            call find_former_run(outputs%folder, outputs%case, outputs%header%echo, former)
            if (options%restart) then
               fresh = .not. (former%results .or. allocated(options%checkpoint))
               if (former%results .and. allocated(options%checkpoint)) then
                  if (.not. is_own_checkpoint(outputs%folder, outputs%case, &
                     options%checkpoint)) call fail(error, exit_file, location_text(setup)// &
                     " and '"//options%checkpoint//"' is not of that run; give another "// &
                     "--outdir or --case [F111]")
               end if
            else if (options%overwrite) then
               call remove_former_run(outputs%folder, former, error)
            else if (former%results) then
               call fail(error, exit_file, location_text(setup)//options_text(former))
            end if
         end if
         call agree(communicator, error)
         fresh = communicator%any(fresh)
         if (fresh) options%restart = .false.
      end associate
   end subroutine protect_results

   !> Warning of a check that a run would be refused because of existing results; else empty.
   function existing_results_text(setup) result(text)
      class(run_setup_t), intent(in) :: setup        !! Complete, without particles
      character(len=:), allocatable :: text
      type(former_run_t) :: former

      text = ""
      if (setup%options%overwrite) return
      call find_former_run(setup%outputs%folder, setup%outputs%case, setup%outputs%header%echo, &
         former)
      if (former%results) text = "warning: "//location_text(setup)// &
         without_code(options_text(former))
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
      text = text//"; or give another --outdir or --case [F111]"
   end function options_text
end module run_existing_results
