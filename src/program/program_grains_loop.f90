! SPDX-License-Identifier: BSD-3-Clause
!> The loop of scree --grains: stages, output, checkpoints, the wall limit and signals.
module program_grains_loop
   use base_error, only: error_t, exit_again, exit_input, exit_physics, exit_success, fail
   use base_kinds, only: int64, wp
   use base_log, only: log_t
   use base_text, only: number
   use base_timer, only: wall_seconds
   use deck_changes, only: changes_t
   use grains_cell, only: cell_t
   use grains_checkpoint, only: cell_hash, load_cell, save_cell
   use grains_measures, only: energy_t, find_energy
   use grains_output, only: grains_output_t
   use grains_pairs, only: overlap
   use grains_path, only: path_t
   use grains_step, only: advance_cell, servo_gradient, start_grains_cell
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use io_checkpoint, only: checkpoint_place_t, checkpoint_write
   use io_lock, only: lock_t
   use io_restart, only: checkpoint_find, checkpoint_read
   use io_state, only: state_t
   use output_former_run, only: is_own_checkpoint
   use particle_store, only: store_t
   use run_limits, only: limits_t
   use run_setup, only: run_setup_t
   use run_signals, only: caught_signal, signal_name, watch_signal
   implicit none
   private

   public :: follow_path, grains_run_t, restart_cell, start_run

   integer, parameter :: check_steps = 50            !! Steps between checks of clock and signals
   integer(int64), parameter :: not_begun = -1       !! Start of an implicit stage
   real(wp), parameter :: deepest = 0.1_wp           !! Overlap over diameter that ends a run

   !> A run of a cell.
   type :: grains_run_t
      type(cell_t) :: cell
      type(path_t) :: path
      type(limits_t) :: limits                       !! Wall time, signals, checkpoints
      type(grains_output_t) :: output
      type(checkpoint_place_t) :: place
      character(len=:), allocatable :: reason        !! Reason of the end
      character(len=:), allocatable :: note          !! Note about a restart, for the log
      character(len=:), allocatable :: losses        !! Rank 0: what earlier files have lost
      integer(int64) :: first_step = 0               !! First step of this process
      real(wp) :: steps_wall = 0.0_wp                !! Wall time of the steps [s]
      real(wp) :: last_line = 0.0_wp                 !! Wall time of the last progress line [s]
      real(wp) :: last_checkpoint = 0.0_wp           !! ... of the last checkpoint [s]
   end type grains_run_t

contains

   !> The first state. Collective.
   subroutine start_run(run)
      type(grains_run_t), intent(inout) :: run
      type(energy_t) :: energy

      run%note = ""
      call enter_stage(run)
      call start_grains_cell(run%cell)
      call find_energy(run%cell, energy)
      run%cell%lost_before = energy%lost
      call find_energy(run%cell, energy)
      run%output%energy_at_start = energy%total
   end subroutine start_run

   !> Apply the settings of the current stage.
   subroutine enter_stage(run)
      type(grains_run_t), intent(inout) :: run
      real(wp) :: height(3)

      associate (cell => run%cell, stage => run%path%stages(run%path%now))
         height = cell%box%heights()
         run%path%from_height = maxval(height(:cell%box%dimension))
         call set_stage(run)
         call servo_gradient(cell)
         run%path%start = cell%step
         run%path%from_fraction = cell%volume_fraction()
      end associate
   end subroutine enter_stage

   !> Set velocity gradient, friction and servo of the current stage. The servo rate depends on the
   !! height of the cell at the start of the stage, not on its current height, so that a restart has
   !! the same rate.
   subroutine set_stage(run)
      type(grains_run_t), intent(inout) :: run
      real(wp) :: speed, modulus

      associate (cell => run%cell, stage => run%path%stages(run%path%now))
         cell%drive = stage%drive
         cell%law%friction = stage%friction
         if (.not. any(stage%drive%servo)) return
         modulus = cell%law%modulus(cell%box%dimension, cell%diameter, stage%drive%pressure)
         speed = sqrt(modulus/cell%density)
         call cell%drive%set_rate(cell%density, speed, run%path%from_height)
      end associate
   end subroutine set_stage

   !> Continue from a checkpoint. Collective.
   subroutine restart_cell(setup, run, error)
      class(run_setup_t), intent(in) :: setup
      type(grains_run_t), intent(inout) :: run
      type(error_t), allocatable, intent(out) :: error
      type(store_t) :: none(0)
      type(state_t) :: state
      type(changes_t) :: changes
      character(len=:), allocatable :: path, notes
      integer(int64), allocatable :: counters(:)

      notes = ""
      if (allocated(setup%options%checkpoint)) then
         path = setup%options%checkpoint
         call checkpoint_read(run%cell%communicator, path, none, state, error, run%place, &
            changes)
      else
         call checkpoint_find(run%cell%communicator, run%place, none, state, path, notes, error, &
            changes)
      end if
      if (allocated(error)) return
      call load_cell(state, run%cell, run%path, run%output%energy_at_start, error)
      if (.not. allocated(error)) call state%get("counters", counters, error)
      if (allocated(error)) return
      run%place%number = int(counters(1)) + 1
      run%output%snapshots = int(counters(2))
      run%first_step = run%cell%step
      if (is_own_checkpoint(run%place%folder, run%place%case, path)) call run%output%load(state)
      run%note = "restart from "//path
      if (len(notes) > 0) run%note = notes//new_line("a")//run%note
      if (run%path%now > size(run%path%stages)) then
         call fail(error, exit_input, run%note//": all stages of the deck are completed; add "// &
            "a &stage to continue, or start again with --overwrite [R126]")
         return
      end if
      ! the gradient of the next step is known from the state, not from the deck
      call set_stage(run)
      if (run%path%start == not_begun) call enter_stage(run)
   end subroutine restart_cell

   !> Go through the stages. Collective.
   subroutine follow_path(run, log, lock, code, error)
      type(grains_run_t), intent(inout) :: run
      type(log_t), intent(inout) :: log
      type(lock_t), intent(inout) :: lock            !! Gives signs of life
      integer, intent(out) :: code                   !! Exit code
      type(error_t), allocatable, intent(out) :: error
      integer :: n

      code = exit_success
      run%last_line = wall_seconds()
      run%last_checkpoint = run%last_line
      do n = 1, size(run%limits%signals)
         call watch_signal(trim(run%limits%signals(n)))
      end do
      if (run%cell%step == 0) call check_state(run, error)
      if (run%cell%step == 0 .and. .not. allocated(error)) call run%output%row(run%cell, &
         run%path%now, error)
      do while (.not. allocated(error) .and. run%path%now <= size(run%path%stages))
         call follow_stage(run, log, lock, code, error)
         if (code /= exit_success .or. allocated(error)) exit
      end do
      if (allocated(error)) then
         code = error%code
         run%reason = error%message
      else if (code == exit_success) then
         run%reason = "last stage finished"
         call write_checkpoint(run, log, error)
      else
         call write_checkpoint(run, log, error)
      end if
   end subroutine follow_path

   !> Run the rest of the current stage and start the next one. Collective.
   subroutine follow_stage(run, log, lock, code, error)
      type(grains_run_t), intent(inout) :: run
      type(log_t), intent(inout) :: log
      type(lock_t), intent(inout) :: lock            !! Gives signs of life
      integer, intent(out) :: code
      type(error_t), allocatable, intent(out) :: error
      real(wp) :: begin

      code = exit_success
      associate (cell => run%cell, path => run%path, output => run%output)
         call log%info("stage     "//number(path%now)//" of "//number(size(path%stages))//"  "// &
            path%stages(path%now)%name)
         do while (.not. is_over(run))
            begin = wall_seconds()
            call advance_cell(cell)
            run%steps_wall = run%steps_wall + wall_seconds() - begin
            if (path%is_row(cell%step, cell%dt)) call output%row(cell, path%now, error)
            if (allocated(error)) return
            if (path%is_snapshot(cell%step, cell%dt)) call output%snapshot(cell, error)
            if (allocated(error)) return
            if (mod(cell%step, int(check_steps, int64)) == 0) then
               call lock%beat()
               call check_run(run, log, code, error)
            end if
            if (allocated(error) .or. code /= exit_success) return
         end do
         if (cell%mean%time > 0.0_wp) call output%row(cell, path%now, error)
         if (.not. allocated(error) .and. path%stages(path%now)%probe) &
            call output%probe(cell, path%now, error)
         if (allocated(error)) return
         path%now = path%now + 1
         if (path%now <= size(path%stages)) then
            call enter_stage(run)
         else
            path%start = not_begun
         end if
      end associate
   end subroutine follow_stage

   !> True if the present stage is at its end. The same on all ranks.
   logical function is_over(run) result(over)
      type(grains_run_t), intent(in) :: run
      type(energy_t) :: energy
      real(wp) :: fraction

      associate (cell => run%cell, stage => run%path%stages(run%path%now))
         over = cell%step - run%path%start >= run%path%steps(cell%dt)
         if (over) return
         if (stage%fraction > 0.0_wp) then
            fraction = cell%volume_fraction()
            over = (fraction - stage%fraction)*(run%path%from_fraction - stage%fraction) <= 0.0_wp
         end if
         if (over .or. .not. stage%quiet > 0.0_wp) return
         if (cell%step == run%path%start .or. mod(cell%step, int(check_steps, int64)) /= 0) return
         call find_energy(cell, energy)
         over = energy%springs > 0.0_wp .and. energy%kinetic < stage%quiet*energy%springs
      end associate
   end function is_over

   !> Check the state, the clock and signals: errors of physics, progress, checkpoints, the end.
   !! Collective.
   subroutine check_run(run, log, code, error)
      type(grains_run_t), intent(inout) :: run
      type(log_t), intent(inout) :: log
      integer, intent(out) :: code
      type(error_t), allocatable, intent(out) :: error
      real(wp) :: now, requests(3)

      code = exit_success
      call check_state(run, error)
      if (allocated(error)) return
      now = wall_seconds()
      requests = 0.0_wp
      requests(1) = real(caught_signal(), wp)
      if (now - run%last_checkpoint > run%limits%checkpoint_wall) &
         requests(2) = 1.0_wp
      if (run%steps_wall > run%limits%wall_limit) requests(3) = 1.0_wp
      if (now - run%last_line >= run%limits%progress) then
         run%last_line = now
         call log%info(progress_text(run))
      end if
      call run%cell%communicator%maxima(requests)
      if (requests(3) > 0.0_wp) then
         code = exit_again
         run%reason = "wall_limit reached [R120]"
      else if (requests(1) > 0.0_wp) then
         code = exit_again
         run%reason = "signal "//signal_name(nint(requests(1)))//" [R121]"
      else if (requests(2) > 0.0_wp) then
         call write_checkpoint(run, log, error)
      end if
   end subroutine check_run

   !> Refuse a state that is not finite, a cell in which two images of a grain are neighbours of
   !! another one, and overlaps that no contact law describes. Collective.
   subroutine check_state(run, error)
      type(grains_run_t), intent(inout) :: run
      type(error_t), allocatable, intent(out) :: error
      real(wp) :: overlap_max, reach

      associate (cell => run%cell)
         if (.not. all(ieee_is_finite(cell%contact + cell%kinetic))) then
            call fail(error, exit_physics, "the stress of the cell is not finite at step "// &
               number(int(cell%step))//": use more steps_per_contact [R125]")
            return
         end if
         reach = 2.0_wp*maxval(cell%grains%radius) + cell%skin
         if (any(cell%box%heights() < 2.0_wp*reach)) then
            call fail(error, merge(exit_input, exit_physics, cell%step == 0), &
               "the cell is lower than two diameters and two skins at step "// &
               number(int(cell%step))//": use more grains, an aspect closer to 1, "// &
               "or a smaller skin in &cell [R125]")
            return
         end if
         overlap_max = 0.0_wp
         if (cell%pairs%count > 0) overlap_max = maxval(cell%pairs%history(overlap, :))
         overlap_max = cell%communicator%maximum(overlap_max)/cell%diameter
         if (overlap_max > deepest) call fail(error, exit_physics, &
            "grains overlap by more than "// &
            "a tenth of a diameter at step "//number(int(cell%step))//": the contacts are too "// &
            "soft for this pressure; raise stiffness (or young) in &grains [R125]")
      end associate
   end subroutine check_state

   !> A line of progress.
   function progress_text(run) result(text)
      type(grains_run_t), intent(in) :: run
      character(len=:), allocatable :: text
      character(len=160) :: line
      real(wp) :: share, rate

      associate (cell => run%cell)
         share = real(cell%step - run%path%start, wp)/real(run%path%steps(cell%dt), wp)
         rate = real(cell%step - run%first_step, wp)*real(cell%grains%count, wp) &
            /max(run%steps_wall, tiny(1.0_wp))
         write (line, "(a, i0, a, i3, a, f9.4, a, f7.4, a, es10.3, a, f6.2, a)") "  step ", &
            cell%step, "  ", nint(100.0_wp*share), " % of the stage   strain", cell%box%strain, &
            "   solid", cell%volume_fraction(), "   pressure", cell%pressure(), " Pa  ", &
            1.0e-6_wp*rate, " M grain steps/s"
      end associate
      text = trim(line)
   end function progress_text

   !> Write a checkpoint. Collective.
   subroutine write_checkpoint(run, log, error)
      type(grains_run_t), intent(inout) :: run
      type(log_t), intent(inout) :: log
      type(error_t), allocatable, intent(out) :: error !! Not written; older ones are intact
      type(store_t) :: none(0)
      type(state_t) :: state
      character(len=:), allocatable :: path

      path = run%place%path()
      call save_cell(run%cell, run%path, run%output%energy_at_start, state)
      call state%set("digest", [cell_hash(state)])
      call state%set("counters", [int(run%place%number, int64), int(run%output%snapshots, int64)])
      call run%output%save(run%cell, state, error)
      if (allocated(error)) return
      call checkpoint_write(run%cell%communicator, run%place, none, state, error)
      run%last_checkpoint = wall_seconds()
      if (allocated(error)) return
      run%place%number = run%place%number + 1
      call log%info("  checkpoint "//path(index(path, "/", back=.true.) + 1:)//" at step "// &
         number(int(run%cell%step)))
   end subroutine write_checkpoint
end module program_grains_loop
