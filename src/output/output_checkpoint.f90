! SPDX-License-Identifier: BSD-3-Clause
!> Writes checkpoints of a run and resumes from them.
module output_checkpoint
   use base_error, only: error_t, exit_file, fail
   use base_file, only: file_exists, join_path, longest_path
   use base_kinds, only: int64, wp
   use deck_changes, only: changes_t
   use io_checkpoint, only: checkpoint_newest, checkpoint_place_t, checkpoint_write
   use io_restart, only: checkpoint_find, checkpoint_read
   use io_state, only: state_t
   use output_former_run, only: is_own_checkpoint
   use output_load_state, only: keep_marks, mark_new_loads, save_loads
   use output_streams, only: outputs_t
   use scene_particles, only: distribute_particles
   use mesh_rigid, only: rigid_t
   use mesh_rigid_body, only: body_state_size
   use step_body_force, only: update_gravity
   use step_rigid_bodies, only: describe_bodies
   use step_exact_error, only: load_errors, save_errors
   use step_simulation, only: simulation_t
   use step_trust_record, only: load_trust, save_trust
   implicit none
   private

   public :: describe_state, resume, write_checkpoint

contains

   !> Step, time, ledger and counters of a run.
   subroutine describe_state(simulation, state)
      type(simulation_t), intent(in) :: simulation
      type(state_t), intent(out) :: state            !! The same on all ranks

      state%step = simulation%clock%step
      state%time = simulation%clock%time
      state%dt_next = simulation%clock%dt_next
      call simulation%balance%ledger%save(simulation%machine%communicator, state)
   end subroutine describe_state

   !> Write a checkpoint and count it.
   subroutine write_checkpoint(simulation, outputs, place, error)
      type(simulation_t), intent(inout) :: simulation
      type(outputs_t), intent(in) :: outputs         !! Outputs, whose counters are written too
      type(checkpoint_place_t), intent(inout) :: place !! Where; its number grows
      type(error_t), allocatable, intent(out) :: error !! Not written; older ones are intact
      type(state_t) :: state
      integer :: n

      call simulation%machine%timer%start(simulation%machine%phase%checkpoint)
      call describe_state(simulation, state)
      call outputs%save(simulation%machine%communicator, state, error)
      if (allocated(error)) then
         call simulation%machine%timer%stop(simulation%machine%phase%checkpoint)
         return
      end if
      call save_errors(simulation%effects, state)
      call save_trust(simulation%balance%trust, state)
      call state%set("checkpoint_number", [int(place%number, int64)])
      call state%set("last_step_length", [simulation%clock%dt, simulation%clock%guard%longest])
      call state%set("space", space_of(simulation))
      if (allocated(simulation%space%rigid)) call save_bodies(simulation%space%rigid, state)
      call save_loads(simulation, state)
      if (allocated(simulation%space%cell)) call state%set("cell", simulation%space%cell%pack())
      if (allocated(simulation%effects%inflows)) call state%set("inflows", &
         [(simulation%effects%inflows(n)%state(state%time), &
         n=1, size(simulation%effects%inflows))])
      call checkpoint_write(simulation%machine%communicator, place, simulation%stores, state, error)
      if (.not. allocated(error)) place%number = place%number + 1
      call simulation%machine%timer%stop(simulation%machine%phase%checkpoint)
   end subroutine write_checkpoint

   !> Properties that the deck of a restart must not change: the number of directions, and whether
   !! the scene is axisymmetric.
   pure function space_of(simulation) result(space)
      type(simulation_t), intent(in) :: simulation
      integer(int64) :: space(2)

      space = [int(simulation%space%grid%dimensions, int64), &
         merge(1_int64, 0_int64, simulation%space%grid%axisymmetric)]
   end function space_of

   !> Resume from a checkpoint: the given one, or the newest readable one.
   subroutine resume(simulation, outputs, place, file, note, changes, error)
      type(simulation_t), intent(inout) :: simulation !! The run, without particles
      type(outputs_t), intent(inout) :: outputs      !! Their counters
      type(checkpoint_place_t), intent(inout) :: place !! Folder and case; gets the next number
      character(len=*), intent(in) :: file           !! Empty = the newest
      character(len=:), allocatable, intent(out) :: note !! Lines for the log
      type(changes_t), intent(out) :: changes        !! Keys that differ from those of the file
      type(error_t), allocatable, intent(out) :: error !! None is readable, or of another deck
      character(len=:), allocatable :: path, passed
      type(state_t) :: state
      integer(int64), allocatable :: number(:)
      real(wp), allocatable :: length(:)

      note = ""
      if (len(file) > 0) then
         path = file
         call checkpoint_read(simulation%machine%communicator, path, simulation%stores, state, &
            error, place, changes)
      else
         call checkpoint_find(simulation%machine%communicator, place, simulation%stores, state, &
            path, passed, error, changes)
         if (len(passed) > 0) note = passed//new_line("a")
      end if
      if (allocated(error)) return
      note = note//"restart from "//path
      call state%get("space", number, error)
      if (allocated(error)) return
      if (any(number /= space_of(simulation))) then
         call fail(error, exit_file, "'"//path// &
            "' belongs to another deck: its dimension in &run differs [F110]")
         return
      end if
      call simulation%balance%ledger%load(simulation%machine%communicator, state, error)
      if (allocated(error)) return
      call state%get("checkpoint_number", number, error)
      if (allocated(error)) return
      place%number = int(number(1)) + 1
      if (len(file) > 0) call pass_by(simulation, place, error)
      if (allocated(error)) return
      call continue_time(simulation, state, error)
      if (allocated(error)) return
      if (allocated(simulation%space%cell)) then
         call state%get("cell", length, error)
         if (allocated(error)) return
         call simulation%space%cell%unpack(length)
      end if
      if (allocated(simulation%space%rigid)) then
         call continue_bodies(simulation%space%rigid, state, error)
         if (allocated(error)) return
         call describe_bodies(simulation%space%rigid, simulation%balance%ledger)
      end if
      call continue_inflows(simulation, state, error)
      if (.not. allocated(error)) call keep_marks(simulation, state, error)
      if (allocated(error)) return
      call outputs%load(state, is_own_checkpoint(place%folder, place%case, path))
      call load_errors(simulation%effects, state)
      call load_trust(simulation%balance%trust, state)
      call distribute_particles(simulation)
      call mark_new_loads(simulation, state, error)
   end subroutine resume

   !> Continue from the time and the step of a checkpoint.
   subroutine continue_time(simulation, state, error)
      type(simulation_t), intent(inout) :: simulation
      type(state_t), intent(in) :: state
      type(error_t), allocatable, intent(out) :: error !! The checkpoint is incomplete
      real(wp), allocatable :: length(:)

      simulation%clock%step = state%step
      simulation%clock%time = state%time
      simulation%clock%dt_next = state%dt_next
      call state%get("last_step_length", length, error)
      if (allocated(error)) return
      simulation%clock%dt = length(1)
      simulation%clock%guard%longest = length(size(length))
      call update_gravity(simulation%effects, simulation%clock)
   end subroutine continue_time

   !> Continue inflows from their displacements, which checkpoints of older versions lack.
   subroutine continue_inflows(simulation, state, error)
      type(simulation_t), intent(inout) :: simulation
      type(state_t), intent(in) :: state
      type(error_t), allocatable, intent(out) :: error
      real(wp), allocatable :: parts(:)
      integer :: n

      if (.not. (allocated(simulation%effects%inflows) .and. state%has("inflows"))) return
      call state%get("inflows", parts, error)
      if (allocated(error)) return
      do n = 1, size(simulation%effects%inflows)
         call simulation%effects%inflows(n)%continue(state%time, parts(2*n - 1:2*n))
      end do
   end subroutine continue_inflows

   !> Add the states of rigid regions that turn, or that forces move.
   subroutine save_bodies(rigid, state)
      type(rigid_t), intent(in) :: rigid
      type(state_t), intent(inout) :: state
      real(wp) :: numbers(body_state_size*size(rigid%wall))
      integer :: n

      if (.not. rigid%has_bodies()) return
      numbers = 0.0_wp
      do n = 1, size(rigid%wall)
         if (allocated(rigid%wall(n)%body)) numbers(body_state_size*(n - 1) + 1: &
            body_state_size*n) = rigid%wall(n)%body%pack()
      end do
      call state%set("rigid_bodies", numbers)
   end subroutine save_bodies

   !> Continue these from their states.
   subroutine continue_bodies(rigid, state, error)
      type(rigid_t), intent(inout) :: rigid
      type(state_t), intent(in) :: state
      type(error_t), allocatable, intent(out) :: error !! The checkpoint is of another deck
      real(wp), allocatable :: numbers(:)
      integer :: n

      if (.not. rigid%has_bodies()) return
      call state%get("rigid_bodies", numbers, error)
      if (allocated(error)) return
      if (size(numbers) /= body_state_size*size(rigid%wall)) then
         call fail(error, exit_file, "the checkpoint belongs to another deck: its number of "// &
            "rigid regions differs [F110]")
         return
      end if
      do n = 1, size(rigid%wall)
         if (allocated(rigid%wall(n)%body)) call rigid%wall(n)%body%unpack( &
            numbers(body_state_size*(n - 1) + 1:body_state_size*n))
      end do
   end subroutine continue_bodies

   !> Number the next checkpoint after all in the folder: a run that resumes from a given file
   !! keeps later ones.
   subroutine pass_by(simulation, place, error)
      type(simulation_t), intent(in) :: simulation   !! For the ranks
      type(checkpoint_place_t), intent(inout) :: place !! Gets another number
      type(error_t), allocatable, intent(out) :: error !! The folder cannot be read
      character(len=longest_path), allocatable :: paths(:)

      if (.not. file_exists(join_path(place%folder, "."))) return
      call checkpoint_newest(simulation%machine%communicator, place%folder, place%case, paths, &
         error)
      if (allocated(error) .or. size(paths) == 0) return
      do while (.not. comes_after(place%path(), trim(paths(1))))
         place%number = place%number + 1
      end do
   end subroutine pass_by

   !> True if a checkpoint has the greater number. Numbers have at least four digits, so the longer
   !! name is greater.
   pure logical function comes_after(path, other) result(after)
      character(len=*), intent(in) :: path           !! Path of the file
      character(len=*), intent(in) :: other          !! Path of the other one

      after = len(path) > len(other) .or. (len(path) == len(other) .and. lgt(path, other))
   end function comes_after
end module output_checkpoint
