! SPDX-License-Identifier: BSD-3-Clause
!> The setup of a run: all data that are set and checked before particles exist. `--check`
!! ends after it; runs, previews and job scripts continue with it. It writes no files.
module run_setup
   use base_agreement, only: agree
   use base_error, only: error_t, exit_input, fail
   use base_hash, only: add_hash, hash_text
   use base_kinds, only: int64, wp
   use base_text, only: text_t
   use base_version, only: git_commit
   use deck_reader, only: deck_t
   use deck_schema, only: schema_t
   use deck_source, only: read_deck_file
   use grains_deck, only: declare_grains, require_grains
   use io_checkpoint, only: checkpoint_place_t
   use io_lock, only: lock_t
   use output_deck, only: check_output_fields, check_output_groups, declare_output_groups
   use output_description, only: describe_simulation
   use output_streams, only: outputs_t
   use particle_body, only: body_t
   use run_cost_report, only: memory_bytes
   use run_expected_steps, only: expected_steps
   use run_fixed_step, only: check_fixed_step
   use run_limits, only: limits_t, read_limits
   use run_material_point, only: declare_point, make_scene_optional
   use run_memory, only: check_memory
   use run_options, only: run_options_t
   use run_plausible, only: check_plausible
   use scene_body_placement, only: check_elastic, check_placement, check_size, default_most_points
   use scene_deck_check, only: check_deck
   use scene_deck_schema, only: declare_deck
   use scene_inflow, only: start_inflows
   use scene_particles, only: survey_t, take_survey
   use scene_regions, only: named_shape_t
   use scene_setup, only: set_up_scene
   use scene_velocity_formula, only: check_formulas
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: a_grain_cell, a_material_point, a_scene, declare_deck_keys, run_setup_t

   !> What a deck describes.
   integer, parameter :: a_scene = 0, a_material_point = 1, a_grain_cell = 2

   !> Setup of a run.
   type :: run_setup_t
      type(run_options_t) :: options                 !! From the command line or a host program
      type(schema_t) :: schema                       !! All keys of a deck
      type(deck_t) :: deck                           !! Input deck
      character(len=:), allocatable :: deck_text     !! As written, stored in output files
      type(simulation_t) :: simulation               !! Without particles
      type(body_t), allocatable :: bodies(:)         !! Bodies that the particles will fill
      type(named_shape_t), allocatable :: shapes(:)  !! Regions of the deck
      real(wp) :: most_points = default_most_points  !! Bodies with more need --force
      type(survey_t) :: survey                       !! Particles and occupied tiles
      type(limits_t) :: limits                       !! End of the run, bounds of the step
      type(outputs_t) :: outputs                     !! Output streams
      type(checkpoint_place_t) :: place              !! Folder and numbers of checkpoints
      type(lock_t) :: lock                           !! Of the case in its folder, on rank 0
   contains
      procedure :: read => run_setup_read            !! Read the deck
      procedure :: build => run_setup_build          !! Build the simulation without particles
   end type run_setup_t

contains

   !> Declare all keys of a deck.
   subroutine declare_deck_keys(schema)
      type(schema_t), intent(inout) :: schema        !! Schema that receives the keys

      call declare_deck(schema)
      call declare_output_groups(schema)
      call declare_point(schema)
      call declare_grains(schema)
   end subroutine declare_deck_keys

   !> Read the deck on rank 0 and parse it on all ranks.
   subroutine run_setup_read(setup, subject, error)
      class(run_setup_t), intent(inout) :: setup     !! With the options; gets the deck
      integer, intent(in) :: subject                 !! What the deck describes, see above
      type(error_t), allocatable, intent(out) :: error !! The deck cannot be read
      type(text_t), allocatable :: overrides(:)

      associate (communicator => setup%simulation%machine%communicator, options => setup%options)
         call check_ranks(setup, error)
         if (allocated(error)) return
         if (communicator%rank == 0) call read_deck_file(options%deck, setup%deck_text, error)
         call agree(communicator, error)
         if (allocated(error)) return
         call communicator%broadcast(setup%deck_text)
         if (.not. allocated(setup%schema%groups)) call declare_deck_keys(setup%schema)
         if (subject /= a_scene) call make_scene_optional(setup%schema)
         if (subject == a_grain_cell) call require_grains(setup%schema)
         overrides = options%overrides
         call setup%deck%read(setup%schema, setup%deck_text, options%deck, overrides, error)
         if (allocated(error) .or. subject /= a_scene) return
         call check_deck(setup%deck)
         call check_output_groups(setup%deck)
      end associate
   end subroutine run_setup_read

   !> Refuse ranks that were started with different decks or options, since they would wait for each
   !! other. Collective.
   subroutine check_ranks(setup, error)
      class(run_setup_t), intent(in) :: setup        !! With the options
      type(error_t), allocatable, intent(out) :: error !! They differ
      integer(int64) :: extremes(2)

      ! the complement of the hash, since its negative can overflow
      extremes = add_hash(setup%options%hash, hash_text(setup%options%deck//git_commit))
      extremes(2) = not(extremes(1))
      call setup%simulation%machine%communicator%least(extremes)
      if (extremes(1) /= not(extremes(2))) call fail(error, exit_input, "the ranks have "// &
         "different decks, options or versions of scree; start all of them with one command [C118]")
   end subroutine check_ranks

   !> Build the simulation without particles, and check conditions that involve several groups of
   !! the deck.
   subroutine run_setup_build(setup, runs, error)
      class(run_setup_t), intent(inout) :: setup       !! With the deck
      logical, intent(in) :: runs                      !! Is this process to run it?
      type(error_t), allocatable, intent(out) :: error !! Errors in the deck

      call set_up_scene(setup%deck, setup%simulation, setup%bodies, setup%shapes)
      ! positions of bodies are also checked if other groups have errors
      if (allocated(setup%bodies) .and. setup%deck%sound("body")) call check_size(setup%deck, &
         setup%simulation%space%grid, setup%bodies, setup%most_points, setup%options%force)
      if (allocated(setup%bodies) .and. setup%deck%sound("body")) then
         call take_survey(setup%simulation, setup%bodies, setup%survey)
         call check_placement(setup%deck, setup%simulation, setup%bodies, setup%survey)
         ! a material with an error has no wave speed
         if (setup%deck%sound("material")) &
            call check_elastic(setup%deck, setup%simulation, setup%bodies)
      end if
      if (.not. allocated(setup%simulation%stores)) then
         call check_output_fields(setup%deck, setup%simulation)
         call setup%deck%verdict(error)
         return
      end if
      if (allocated(setup%survey%key)) call start_inflows(setup%deck, setup%simulation, &
         setup%bodies, setup%survey%key)
      if (allocated(setup%survey%key)) &
         call check_formulas(setup%deck, setup%simulation, setup%bodies, setup%survey%key)
      call read_limits(setup%deck, setup%limits)
      call check_plausible(setup%schema, setup%deck, setup%simulation, setup%bodies, setup%limits)
      if (.not. setup%options%force) call check_fixed_step(setup%deck, setup%simulation, &
         setup%bodies)
      call describe_simulation(setup%deck, setup%simulation, setup%bodies, setup%deck_text, &
         setup%options%folder, setup%outputs, setup%place)
      setup%place%schema = setup%schema
      call setup%outputs%plan(setup%deck, setup%simulation, setup%shapes, setup%limits%time_end)
      call setup%deck%verdict(error)
      if (allocated(error)) return
      if (.not. setup%options%force) call setup%outputs%limit(setup%deck, setup%survey%particles, &
         setup%limits%time_end, expected_steps(setup%simulation, setup%bodies, setup%limits))
      call check_memory(setup%deck, setup%simulation%machine%communicator, &
         memory_bytes(setup%simulation, setup%survey), setup%deck%group("grid", 1), "dx", &
         "use larger cells or fewer ppc", refuses=runs .and. .not. setup%options%force)
      call setup%deck%verdict(error)
   end subroutine run_setup_build
end module run_setup
