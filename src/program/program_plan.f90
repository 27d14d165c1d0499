! SPDX-License-Identifier: BSD-3-Clause
!> From a deck to a run that could begin: all that `--check` does. Nothing is written, and no
!! particle is made.
module program_plan
   use base_agreement, only: agree
   use base_deck, only: deck_t
   use base_error, only: error_t
   use base_kinds, only: wp
   use base_schema, only: schema_t
   use base_text, only: text_t
   use io_checkpoint, only: checkpoint_place_t
   use io_deck_file, only: read_deck_file
   use material_type, only: declare_material_keys
   use output_description, only: describe_simulation
   use output_field_names, only: check_field_names
   use output_streams, only: outputs_t
   use particle_fill, only: body_t
   use program_command_line, only: command_t
   use program_material_point, only: declare_point, relieve
   use program_step_count, only: expected_steps
   use program_time_loop, only: limits_t, read_limits
   use scene_build, only: build_scene
   use scene_check_bodies, only: check_elastic, check_places, check_size, default_most_points
   use scene_deck_check, only: check_deck
   use scene_deck_schema, only: declare_deck
   use scene_exact, only: declare_exact
   use scene_method, only: declare_method
   use scene_particles, only: survey_t, take_survey
   use scene_shapes, only: named_shape_t
   use scene_velocity_formula, only: check_formulas
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: declare_all, lay_out, plan_t, read_plan

   !> A run before it begins.
   type :: plan_t
      type(command_t) :: command                     !! What the user asked for
      type(schema_t) :: schema                       !! What a deck may hold
      type(deck_t) :: deck                           !! The deck
      character(len=:), allocatable :: deck_text     !! As written, for files
      type(simulation_t) :: simulation               !! The run
      type(body_t), allocatable :: bodies(:)         !! What fills it
      type(named_shape_t), allocatable :: shapes(:)  !! Its regions
      real(wp) :: most_points = default_most_points  !! Bodies with more need --force
      type(survey_t) :: survey                       !! Counts of it
      type(limits_t) :: limits                       !! When it ends
      type(outputs_t) :: outputs                     !! Files
      type(checkpoint_place_t) :: place              !! Checkpoints
   end type plan_t

contains

   !> All keys of a deck.
   subroutine declare_all(schema)
      type(schema_t), intent(inout) :: schema        !! Gets the keys

      call declare_deck(schema)
      call declare_method(schema)
      call declare_material_keys(schema)
      call declare_exact(schema)
      call declare_point(schema)
   end subroutine declare_all

   !> Read the deck on rank 0 and parse it on all ranks.
   subroutine read_plan(plan, error)
      class(plan_t), intent(inout) :: plan           !! The command line is known; gets the deck
      type(error_t), allocatable, intent(out) :: error !! It cannot be read
      type(text_t), allocatable :: overrides(:)

      associate (communicator => plan%simulation%machine%communicator, command => plan%command)
         if (communicator%rank == 0) call read_deck_file(command%deck, plan%deck_text, error)
         call agree(communicator, error)
         if (allocated(error)) return
         call communicator%broadcast(plan%deck_text)
         if (.not. allocated(plan%schema%groups)) call declare_all(plan%schema)
         if (command%point) call relieve(plan%schema)
         overrides = command%overrides
         call plan%deck%read(plan%schema, plan%deck_text, command%deck, overrides, error)
         if (allocated(error)) return
         if (.not. command%point) call check_deck(plan%deck)
      end associate
   end subroutine read_plan

   !> Build the run without particles and check what only the whole of it shows.
   subroutine lay_out(plan, error)
      class(plan_t), intent(inout) :: plan           !! The deck is read
      type(error_t), allocatable, intent(out) :: error !! The deck is wrong

      call build_scene(plan%deck, plan%simulation, plan%bodies, plan%shapes)
      ! Errors elsewhere do not hide those of places; the deck is refused after them.
      if (allocated(plan%bodies) .and. plan%deck%sound("body")) call check_size(plan%deck, &
         plan%simulation%space%grid, plan%bodies, plan%most_points, plan%command%force)
      if (allocated(plan%bodies) .and. plan%deck%sound("body")) then
         call take_survey(plan%simulation, plan%bodies, plan%survey)
         call check_places(plan%deck, plan%simulation, plan%bodies, plan%survey)
         ! a material with an error has no speed of waves
         if (plan%deck%sound("material")) &
            call check_elastic(plan%deck, plan%simulation, plan%bodies)
      end if
      if (.not. allocated(plan%simulation%stores)) then
         call check_field_names(plan%deck, plan%simulation)
         call plan%deck%verdict(error)
         return
      end if
      if (allocated(plan%survey%key)) &
         call check_formulas(plan%deck, plan%simulation, plan%bodies, plan%survey%key)
      call read_limits(plan%deck, plan%limits)
      call describe_simulation(plan%deck, plan%simulation, plan%bodies, plan%deck_text, &
         plan%command%output_folder, plan%outputs, plan%place)
      call plan%outputs%plan(plan%deck, plan%simulation, plan%shapes, plan%limits%time_end)
      call plan%deck%verdict(error)
      if (allocated(error)) return
      if (.not. plan%command%force) call plan%outputs%limit(plan%deck, plan%survey%particles, &
         plan%limits%time_end, expected_steps(plan%simulation, plan%bodies, plan%limits))
      call plan%deck%verdict(error)
   end subroutine lay_out
end module program_plan
