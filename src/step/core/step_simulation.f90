! SPDX-License-Identifier: BSD-3-Clause
!> The state of a simulation, in parts.
module step_simulation
   use base_communicator, only: communicator_t
   use base_exact_sum, only: exact_sum_t
   use base_kinds, only: int64, wp
   use base_text, only: text_t
   use base_timer, only: timer_t
   use ddmp_dual, only: dual_t
   use exact_solution, only: exact_case_t
   use material_effect_timers, only: stage_clock_t
   use material_stages, only: effect_count
   use material_state, only: deformation_t
   use material_type, only: material_t
   use mesh_boundary, only: boundary_t
   use mesh_grid, only: grid_t
   use mesh_halo, only: halo_t
   use mesh_motion, only: motion_t
   use mesh_moving_cell, only: moving_cell_t
   use mesh_rigid, only: rigid_t
   use mesh_surface_load, only: surface_load_t
   use mesh_tiles, only: tiles_t
   use particle_inflow, only: inflow_t
   use particle_leavers, only: leavers_t
   use particle_store, only: store_t
   use step_bounds, only: guard_t
   use step_ledger, only: ledger_t
   use step_method, only: method_t
   use step_node_fields, only: node_needs_t, node_tally_t, nodes_t
   use step_trust_record, only: trust_t
   use transfer_contact, only: pair_law_t
   use transfer_pushed_stress, only: pushed_stress_t
   use transfer_shape_data, only: shape_data_t
   use transfer_sides, only: product_rows, sides_t
   implicit none
   private

   public :: clock_t, conduction_t, contact_t, heat_flux_t, load_t, machine_t, &
      phases_t, reach_t, requests_t, scheme_t, scratch_t, simulation_effects_t, simulation_t, &
      space_t, velocity_field_t

   integer, parameter, public :: guesses = 3         !! Candidates for the normal between two bodies

   !> Bodies with one velocity field: all bodies, if there is no contact.
   type :: velocity_field_t
      integer :: first_store = 1                     !! First of its stores
      integer :: last_store = 0                      !! Last of its stores
      type(nodes_t) :: nodes                         !! Node fields of the velocity field
      integer :: other = 0                           !! Field of the other side, if it has one
      type(sides_t), allocatable :: sides            !! Sides of particles
   contains
      procedure :: count => count_field
   end type velocity_field_t

   !> Contact between bodies with separate velocity fields.
   type :: contact_t
      type(pair_law_t), allocatable :: law(:, :)     !! (field, field) Contact law of two fields
      logical :: bonded = .false.                    !! Can bonds break?
      integer, allocatable :: field_of_body(:)       !! (body) Velocity field of the body
      integer, allocatable :: material(:)            !! (store) Number of its &material
      !> Patch (row, field): outward area of the particles [m2], with bonds the mass of those that
      !! hold [kg]
      real(wp), allocatable :: outward(:, :, :)
      real(wp), allocatable :: area(:, :, :)         !! The sums of these
      !> Patch (candidate normal, field, field): farthest position towards another field [m]
      real(wp), allocatable :: reach(:, :, :)
      logical, allocatable :: meets(:)               !! (tile) Are there nodes of several fields?
      logical, allocatable :: broken(:, :, :)        !! (field, node, tile) Does a bond break now?
   contains
      procedure :: count => count_contact
   end type contact_t

   !> Conduction of heat: node fields as above; those of the dual gradient only with it.
   type :: conduction_t
      real(wp), allocatable :: content(:, :, :)      !! Patch of heat capacity, heat, volume
      real(wp), allocatable :: total(:, :, :)        !! The sums of these
      real(wp), allocatable :: temperature(:, :, :)  !! (1) [K]
      !> Patch of heat from cells [W], heat that nodes do not resolve [J], flux times volume [W m]
      real(wp), allocatable :: flow(:, :, :)
      real(wp), allocatable :: weight(:, :)          !! (cell, tile) Weights of the dual gradient
      real(wp), allocatable :: share(:, :, :)        !! Patch (1): volume of the dual gradient [m3]
      real(wp), allocatable :: volume(:, :, :)       !! (1) Sum of volumes [m3]
      real(wp), allocatable :: slope(:, :, :)        !! Patch (9): gradient in rows 1, 4, 7 [K m2]
      real(wp), allocatable :: node_heat(:, :, :)    !! Patch (3): heat of the node flux, row 1 [W]
   contains
      procedure :: count => count_conduction
   end type conduction_t

   !> Artificial heat flux of one material at a time.
   type :: heat_flux_t
      real(wp), allocatable :: content(:, :, :)      !! Patch (2): mass [kg], internal energy [J]
      real(wp), allocatable :: flux(:, :, :)         !! Patch (1): conductance, then energy [J]
      real(wp), allocatable :: total(:, :, :)        !! (3) Sums of the content, limit of the flux
   contains
      procedure :: count => count_heat_flux
   end type heat_flux_t

   !> The node that would exceed the bounds on displacement most in a step.
   type :: reach_t
      real(wp) :: excess = 0.0_wp                    !! Greater of both over its bound [1]
      real(wp) :: moved = 0.0_wp                     !! Displacement of that node over a cell [1]
      real(wp) :: strain = 0.0_wp                    !! Or difference of two nodes over a cell [1]
      integer :: node = 0                            !! The node, in the tile
      integer(int64) :: number = huge(1_int64)       !! Number of the node in the grid
      integer :: place(3) = 0                        !! Position in the grid, from 0
   end type reach_t

   !> Scratch space of one thread.
   type :: scratch_t
      type(shape_data_t) :: shape !! Shape data of the particles of the tile
      type(pushed_stress_t) :: pushed !! Particle stress for the nodes, if different
      type(deformation_t) :: deformation             !! Step of the particles of the tile
      !> (particle, 9) Half of the strain with the velocity before the step, if needed [1]
      real(wp), allocatable :: half_strain(:, :)
      type(ledger_t) :: ledger                       !! Sums of this thread
      type(stage_clock_t) :: laps                           !! Times of effects
      real(wp) :: fastest = 0.0_wp                   !! Fastest signal and motion [m/s]
      !> Mass times acceleration of nodes in the last step, if a criterion needs it [N]
      type(exact_sum_t), allocatable :: unbalanced
      !> (entry, region) Impulses on the material of rigid bodies that forces move, in this step
      type(exact_sum_t), allocatable :: bodies(:, :)
      real(wp) :: load_work = 0.0_wp !! Greatest work of loads on a particle in a step [J/kg]
      logical :: sound = .true.                      !! Are all particles in their bounds?
      logical :: retired = .false.                   !! True if a particle was retired
      type(reach_t) :: reach                         !! Node that moves too far, if tested
      real(wp) :: steepest = 0.0_wp                  !! Square of steepest velocity gradient [1/s2]
      integer(int64) :: steepest_identity = huge(1_int64) !! Particle of the steepest gradient
   end type scratch_t

   !> Requests of one rank to all ranks; agreed at the end of each step.
   type :: requests_t
      real(wp) :: leave = 0.0_wp                     !! Number of a signal, 0 = none
      real(wp) :: line = 0.0_wp                      !! 1 = a line of progress
      real(wp) :: checkpoint = 0.0_wp                !! 1 = a checkpoint
      real(wp) :: present = -1.0_wp                  !! 1 = it has particles, -1 = not counted
   end type requests_t

   !> Load balance: ratio of the greatest to the mean work of the ranks, in the measured steps.
   type :: load_t
      integer :: measured = 0                        !! Steps measured
      integer :: cuts = 0                            !! Number of repartitions of the curve
      integer(int64) :: sent = 0                     !! Tiles that this rank sent then
      integer(int64) :: listed = 0                   !! Longest list of tiles here at the start
      real(wp) :: last = 1.0_wp                      !! Ratio in the last measured step [1]
      real(wp) :: total = 0.0_wp                     !! Sum over the measured steps [1]
      real(wp) :: greatest = 1.0_wp                  !! After the first hundred steps [1]
   contains
      procedure :: record => load_record                 !! Record a measured step
   end type load_t

   !> Indices of the timed phases.
   type :: phases_t
      integer :: sort = 0, scatter = 0, exchange = 0, wait = 0, grid = 0, gather = 0, &
         ledger = 0, output = 0, checkpoint = 0, conduction = 0, contact = 0 !! One each
      integer :: effect(effect_count) = 0           !! Timer in the material update, 0 = off
   end type phases_t

   !> The domain: the grid, its boundaries and rigid regions, and its tiles.
   type :: space_t
      type(grid_t) :: grid
      type(boundary_t) :: boundary                   !! Six boundaries of the domain
      type(rigid_t), allocatable :: rigid            !! Rigid regions that constrain nodes
      type(tiles_t) :: tiles                         !! Tiles of this rank
      !> Patch (1), at the first node of a cell: boundaries that its particles have reached, as bits
      real(wp), allocatable :: arrived(:, :, :)
      !> May particles be near a wall that they have not reached?
      logical :: approached = .true.
      type(halo_t) :: halo                           !! Tiles that other ranks need
      type(moving_cell_t), allocatable :: cell       !! Periodic cell, if it deforms
   contains
      procedure :: mesh_time => space_mesh_time      !! A time on the mesh
   end type space_t

   !> Numerical method, and the requirements of materials and output.
   type :: scheme_t
      type(method_t) :: method                       !! Choices of &method
      type(dual_t) :: dual                           !! The dual gradient
      !> (material) With normalised sums: are those of the material normalised, and is it without
      !! strength?
      logical, allocatable :: normalises(:), flows(:)
      real(wp) :: mean_alpha = 0.0_wp                !! Mean of alpha over a cell, for that [1]
      logical :: repacks = .false.                   !! Do nodes correct volumes of some material?
      logical :: keeps_nodes = .false.               !! Are the fields of all nodes requested?
      logical :: erosion = .false.                   !! Are failed particles removed?
      logical :: carries_energy = .false.            !! Does some material carry internal energy?
      logical :: works = .false.                     !! Is work of stress or loads computed?
      logical :: loose = .false.                     !! Is some material loose grains?
   contains
      procedure :: gradients => scheme_gradients     !! Number of velocity gradients of a step
      procedure :: weighs => scheme_weighs           !! Are cells weighted by their particles?
   end type scheme_t

   !> Physical effects in addition to stress. Those that a scene does not use are not allocated.
   type :: simulation_effects_t
      type(contact_t), allocatable :: contact        !! Between bodies with their own velocities
      type(conduction_t), allocatable :: conduction  !! If some material conducts heat
      type(heat_flux_t) :: heat_flux                 !! Artificial heat flux
      real(wp), allocatable :: gravity(:)            !! (3) [m/s2]
      type(motion_t), allocatable :: shaking         !! Gravity by a table of time [m/s2]
      real(wp) :: damping = 0.0_wp                   !! Rate at which motion is damped [1/s]
      type(exact_case_t), allocatable :: exact       !! Exact solution, if one is known
      type(surface_load_t), allocatable :: loads(:)          !! Pressures and tractions on surfaces
      type(inflow_t), allocatable :: inflows(:)      !! Material that enters
      !> (column, node, tile) Mass times rotation, and mass, at the corners of tiles [kg/s], [kg]
      real(wp), allocatable :: turn(:, :, :)
   contains
      procedure :: count => count_effects
   end type simulation_effects_t

   !> Time, and the limits of its steps.
   type :: clock_t
      integer(int64) :: step = 0                     !! Steps done
      real(wp) :: time = 0.0_wp                      !! [s]
      real(wp) :: dt = 0.0_wp                        !! Last time step [s]
      real(wp) :: kick = 0.0_wp                      !! Time that the forces act in this step [s]
      real(wp) :: dt_next = 0.0_wp                   !! Next stable time step [s]
      type(guard_t) :: guard                         !! Limits of steps and particles
      integer(int64) :: halved = 0                   !! Particles halved on this rank
      integer(int64) :: updates = 0                  !! Particle updates of this rank
   end type clock_t

   !> The ledger, and the record of how far results can be trusted.
   type :: conservation_t
      type(ledger_t) :: ledger                       !! Mass, momentum and energy
      type(trust_t) :: trust                         !! How far results can be trusted
   end type conservation_t

   !> Work and communication of this rank in its steps, summed over them.
   type :: rank_work_t
      integer(int64) :: steps = 0                    !! Steps of this process
      integer(int64) :: sent(4) = 0                  !! As `counts` of the communicator
      integer(int64) :: tiles = 0                    !! Own tiles at the ends of steps
      integer(int64) :: ghosts = 0                   !! Tiles of other ranks whose nodes it computes
      integer(int64) :: nodes = 0                    !! Nodes of both, of all velocity fields
   contains
      procedure :: record => rank_work_record        !! Add a step
   end type rank_work_t

   !> Ranks, timers, and load balance.
   type :: machine_t
      type(communicator_t) :: communicator
      type(timer_t) :: timer                         !! Wall time by phase
      type(phases_t) :: phase                        !! Indices of the phases
      type(requests_t) :: requests !! Requests of this rank; after a step those of all ranks
      type(load_t) :: load                           !! How evenly the ranks work
      real(wp), allocatable :: cost(:)               !! (own tile) Work, if measured [s]
      integer(int64), allocatable :: cost_key(:)     !! (own tile) Key of the tile at that time
      integer, allocatable :: cause(:) !! (tile of another rank) Own tile that causes work there
      real(wp) :: worked = 0.0_wp                    !! Processor time of the rank in its steps [s]
      type(rank_work_t) :: work                      !! Counts of work and communication
   end type machine_t

   !> A simulation: everything that a step changes.
   type :: simulation_t
      type(space_t) :: space
      type(material_t), allocatable :: materials(:)
      type(store_t), allocatable :: stores(:)        !! (material) Particles, with contact more
      type(leavers_t) :: leavers                     !! Particles on the way to other tiles
      type(velocity_field_t), allocatable :: fields(:) !! One field without contact
      type(scheme_t) :: scheme
      type(simulation_effects_t) :: effects
      type(clock_t) :: clock
      type(conservation_t) :: balance
      type(machine_t) :: machine
      type(scratch_t), allocatable :: scratch(:)     !! (thread, from 0)
      type(text_t), allocatable :: body_names(:)     !! (body) For messages
   end type simulation_t

contains

   !> Number of velocity gradients that the particles use in a step: of the strain, of the velocity
   !! before the step (usavg), and of the work.
   pure integer function scheme_gradients(self) result(number)
      class(scheme_t), intent(in) :: self

      number = 1 + merge(1, 0, self%method%averages()) + merge(1, 0, self%works)
   end function scheme_gradients

   !> Time limit for displacements on the mesh, from that for displacements in space: the same,
   !! unless the cell deforms [s].
   pure real(wp) function space_mesh_time(self, time) result(longest)
      class(space_t), intent(in) :: self
      real(wp), intent(in) :: time                   !! [s]

      longest = time
      if (allocated(self%cell)) longest = time*self%cell%greatest()
   end function space_mesh_time

   !> Do weights of cells depend on the particles in them when the force acts? With normalised sums
   !! and with a mean stress they are known before.
   pure logical function scheme_weighs(self) result(weighs)
      class(scheme_t), intent(in) :: self

      weighs = self%method%dual .and. .not. (allocated(self%normalises) .or. &
         self%method%controlled())
   end function scheme_weighs

   !> Count the node fields of a velocity field, with those of its sides.
   pure subroutine count_field(self, needs, tally)
      class(velocity_field_t), intent(in) :: self
      type(node_needs_t), intent(in) :: needs
      type(node_tally_t), intent(inout) :: tally

      call self%nodes%count(needs, tally)
      if (.not. allocated(self%sides)) return
      call tally%add(self%sides%patch, product_rows)
      call tally%add(self%sides%slope, 3)
      call tally%add(self%sides%axis, 3)
      call tally%add(self%sides%intact, .true.)
   end subroutine count_field

   !> Count the node fields of contact.
   pure subroutine count_contact(self, tally)
      class(contact_t), intent(in) :: self
      type(node_tally_t), intent(inout) :: tally

      associate (fields => size(self%law, 1), rows => merge(4, 3, self%bonded))
         call tally%add(self%outward, rows*fields)
         call tally%add(self%area, rows*fields)
         call tally%add(self%reach, guesses*fields**2)
      end associate
   end subroutine count_contact

   !> Count the node fields of heat conduction.
   pure subroutine count_conduction(self, dual, tally)
      class(conduction_t), intent(in) :: self
      logical, intent(in) :: dual                    !! Is the gradient the dual one?
      type(node_tally_t), intent(inout) :: tally

      call tally%add(self%content, merge(3, 2, dual))
      call tally%add(self%total, merge(3, 2, dual))
      call tally%add(self%temperature, 1)
      call tally%add(self%flow, merge(5, 2, dual))
      call tally%add(self%weight, dual)
      call tally%add(self%share, merge(1, 0, dual))
      call tally%add(self%volume, merge(1, 0, dual))
      call tally%add(self%slope, merge(9, 0, dual))
      call tally%add(self%node_heat, merge(3, 0, dual))
   end subroutine count_conduction

   !> Count the node fields of the artificial heat flux.
   pure subroutine count_heat_flux(self, needed, tally)
      class(heat_flux_t), intent(in) :: self
      logical, intent(in) :: needed                  !! Does the method have it?
      type(node_tally_t), intent(inout) :: tally

      call tally%add(self%content, merge(2, 0, needed))
      call tally%add(self%flux, merge(1, 0, needed))
      call tally%add(self%total, merge(3, 0, needed))
   end subroutine count_heat_flux

   !> Count the node fields of all effects.
   pure subroutine count_effects(self, method, tally)
      class(simulation_effects_t), intent(in) :: self
      type(method_t), intent(in) :: method
      type(node_tally_t), intent(inout) :: tally

      if (allocated(self%contact)) call self%contact%count(tally)
      if (allocated(self%conduction)) call self%conduction%count(method%dual, tally)
      call self%heat_flux%count(method%heat_flux > 0.0_wp, tally)
      call tally%add(self%turn, merge(4, 0, method%smooth_turn))
   end subroutine count_effects

   !> Add the counts of a step.
   pure subroutine rank_work_record(self, sent, tiles, fields)
      class(rank_work_t), intent(inout) :: self
      integer(int64), intent(in) :: sent(4)          !! As `counts` of the communicator, in the step
      type(tiles_t), intent(in) :: tiles
      type(velocity_field_t), intent(in) :: fields(:)
      integer :: n

      self%steps = self%steps + 1
      self%sent = self%sent + sent
      self%tiles = self%tiles + tiles%own
      self%ghosts = self%ghosts + tiles%all - tiles%own
      do n = 1, size(fields)
         if (allocated(fields(n)%nodes%motion%touched%before)) &
            self%nodes = self%nodes + fields(n)%nodes%motion%touched%nodes()
      end do
   end subroutine rank_work_record

   !> Record the load balance of a step.
   pure subroutine load_record(self, step, ratio)
      class(load_t), intent(inout) :: self
      integer(int64), intent(in) :: step             !! Steps done
      real(wp), intent(in) :: ratio                  !! Greatest over mean work [1]
      integer(int64), parameter :: starting_steps = 100

      self%measured = self%measured + 1
      self%last = ratio
      self%total = self%total + ratio
      if (step > starting_steps) self%greatest = max(self%greatest, ratio)
   end subroutine load_record
end module step_simulation
