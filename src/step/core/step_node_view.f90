! SPDX-License-Identifier: BSD-3-Clause
!> Node fields of a tile for its particles. Fields that are not needed are not allocated,
!! and the memory is reused for the next tile.
module step_node_view
   use base_kinds, only: wp
   use mesh_patch, only: combine
   use step_bounds, only: are_nodes_slow, limiting_gradient
   use step_dissipation, only: damps
   use step_dual_gradient, only: node_gradient
   use step_grid_volumes, only: excess_fill
   use step_method, only: stress_before
   use step_particles_to_nodes, only: nodes_seen
   use step_simulation, only: scheme_t, simulation_t, space_t, velocity_field_t
   use step_velocity_remap, only: find_filtered
   use transfer_affine, only: moment_fields
   use transfer_increments, only: increments_t
   implicit none
   private

   public :: gather_parts_t, set_other_view, set_view, view_t

   !> Selected parts of the transfer to the particles.
   type :: gather_parts_t
      logical :: work = .false.                      !! Work of the stress of the force
      logical :: strain = .false.                    !! Strain and stress
      logical :: motion = .false.                    !! Particle velocities, positions and cells
   end type gather_parts_t

   !> Kinetic energy lost at the nodes of a tile, for its particles.
   type :: loss_view_t
      real(wp), allocatable :: heat(:, :) !! (column, node) Fields gathered at the particles
      real(wp), allocatable :: scalar(:, :)          !! (1, node) Value of the nodes [J/kg]
      real(wp), allocatable :: turn(:, :) !! (3, node) Velocity from linear velocity fields [m/s]
      real(wp), allocatable :: moments(:, :)         !! (9, node) Moments of these [m2/s]
   end type loss_view_t

   !> Node fields of one tile that the particles need. Fields that are not needed are not allocated.
   type :: view_t
      real(wp), allocatable :: centre(:, :)          !! (3, node) Mid-step velocity [m/s]
      real(wp), allocatable :: push(:, :) !! (3, node) Velocity increment [m/s]
      real(wp), allocatable :: carry(:, :)           !! (3, node) Advection velocity [m/s]
      real(wp), allocatable :: after(:, :)           !! (3, node) Velocity after the step [m/s]
      real(wp), allocatable :: gradient(:, :)        !! (9, node) Node gradient of strain [1/s]
      real(wp), allocatable :: middle(:, :) !! (9, node) Gradient of the mid-step velocity [1/s]
      real(wp), allocatable :: earlier(:, :)         !! (9, node) Before the step [1/s]
      type(loss_view_t) :: loss                      !! Lost kinetic energy
      type(increments_t) :: increments               !! Increments and heat, if gathered at once
      logical :: at_once = .false.                   !! Are they gathered at once?
      real(wp), allocatable :: filtered(:, :)        !! (3, node) Sum of the series [m/s]
      real(wp), allocatable :: excess(:, :) !! (1, node) Fill less 1, for loose material [1]
      real(wp) :: matters = 0.0_wp                   !! Smaller |grad v| do not limit steps [1/s]
      logical :: slow = .false.                      !! Can no gradient limit the step?
      logical :: moved = .false.                     !! Have the particles moved already?
      integer :: slot = 0                            !! Index of the fields of the tile
   end type view_t

contains

   !> Set the node fields of a tile for its particles.
   subroutine set_view(simulation, field, tile, parts, view)
      type(simulation_t), intent(in) :: simulation
      type(velocity_field_t), intent(in) :: field
      integer, intent(in) :: tile
      type(gather_parts_t), intent(in) :: parts      !! Requested parts
      type(view_t), intent(inout) :: view            !! Node fields for the particles
      integer :: low, high

      view%slow = .false.
      view%moved = .not. parts%motion
      view%slot = field%nodes%slot(tile)
      if (parts%work) then
         call nodes_seen(simulation%space, field, tile, low, high)
         if (.not. allocated(view%centre)) &
            allocate (view%centre(3, simulation%space%grid%tile_nodes), source=0.0_wp)
         call combine(1.0_wp, field%nodes%motion%velocity(:, low:high, view%slot), &
            0.5_wp*simulation%clock%kick, field%nodes%motion%acceleration(:, low:high, view%slot), &
            view%centre(:, low:high))
      end if
      if (parts%motion) call set_motion_view(simulation%space, simulation%scheme, field, tile, &
         simulation%clock%kick, view)
      if (parts%strain) call find_steep(simulation, field, view)
      if (.not. simulation%scheme%method%dual) return
      if (parts%motion .and. simulation%scheme%repacks) call excess_fill(simulation%space%grid, &
         simulation%space%boundary, simulation%space%tiles%coordinate(:, tile), &
         field%nodes%dual%filled(:, :, tile), field%nodes%dual%volume(:, :, tile), view%excess)
      if (parts%strain .or. (parts%motion .and. simulation%scheme%method%transfer%affine())) &
         call node_gradient(simulation%space, field, tile, field%nodes%dual%gradient, view%gradient)
      if (parts%work .and. simulation%scheme%works) &
         call node_gradient(simulation%space, field, tile, field%nodes%dual%middle, view%middle)
      if (parts%strain .and. simulation%scheme%method%averages()) &
         call node_gradient(simulation%space, field, tile, field%nodes%dual%earlier, view%earlier)
   end subroutine set_view

   !> Fields of the other side of the nodes of a tile, if any have separated.
   subroutine set_other_view(simulation, field, tile, parts, other)
      type(simulation_t), intent(in) :: simulation
      type(velocity_field_t), intent(in) :: field
      integer, intent(in) :: tile
      type(gather_parts_t), intent(in) :: parts      !! Requested parts
      type(view_t), intent(inout) :: other           !! Its slot is 0 if there is none

      other%slot = 0
      if (.not. allocated(field%sides)) return
      if (field%sides%cut(tile)) call set_view(simulation, simulation%fields(field%other), tile, &
         parts, other)
   end subroutine set_other_view

   !> Find which velocity gradients can limit the next step, and whether any node gradient is that
   !! steep. Node velocities alone decide this only where gradients are those of shape functions.
   subroutine find_steep(simulation, field, view)
      type(simulation_t), intent(in) :: simulation
      type(velocity_field_t), intent(in) :: field
      type(view_t), intent(inout) :: view            !! Node fields for the particles

      associate (method => simulation%scheme%method, grid => simulation%space%grid)
         view%matters = limiting_gradient(simulation%clock%guard%bounds, method%step_growth, &
            simulation%clock%dt_next)
         if (method%dual .or. grid%axisymmetric .or. allocated(simulation%stores(1)%domain)) return
         if (allocated(simulation%space%cell)) return
         ! nine components, each at most twice the greatest velocity over the edge of a cell
         view%slow = are_nodes_slow(3*grid%tile_nodes, field%nodes%motion%strain(:, :, view%slot), &
            0.9_wp/6.0_wp*grid%spacing*view%matters)
      end associate
   end subroutine find_steep

   !> Do linear velocity fields of any material come from the velocity of the nodes after the step,
   !! and not from the strain?
   pure logical function needs_velocity_after(scheme) result(needs)
      type(scheme_t), intent(in) :: scheme

      needs = scheme%method%transfer%affine() .and. (allocated(scheme%normalises) .or. &
         .not. scheme%method%dual .or. scheme%method%stress == stress_before)
   end function needs_velocity_after

   !> True if particles can get their velocity, their displacement and the lost kinetic energy from
   !! fields that are gathered once. Without energy and damping the fields update velocity and
   !! position directly.
   pure logical function gathers_at_once(scheme) result(at_once)
      type(scheme_t), intent(in) :: scheme

      associate (transfer => scheme%method%transfer)
         at_once = transfer%sweeps() == 0 .and. transfer%flip_fraction() > 0.5_wp .and. &
            (scheme%carries_energy .or. damps(scheme%method, scheme%carries_energy))
      end associate
   end function gathers_at_once

   !> The node fields that move the particles of a tile, and those of the kinetic energy that the
   !! transfers to the nodes and back lose. Without leapfrog, equation (M.21) of
   !! doc/theory/method.md moves them.
   subroutine set_motion_view(space, scheme, field, tile, dt, view)
      type(space_t), intent(in) :: space
      type(scheme_t), intent(in) :: scheme
      type(velocity_field_t), intent(in) :: field
      integer, intent(in) :: tile
      real(wp), intent(in) :: dt                     !! Time over which the forces act [s]
      type(view_t), intent(inout) :: view            !! Node fields for the particles
      real(wp) :: none(1, 0)
      integer :: low, high

      view%at_once = gathers_at_once(scheme)
      if (view%at_once) then
         call nodes_seen(space, field, tile, low, high)
         call view%increments%choose(space%grid, scheme%method%transfer%flip_fraction(), &
            merge(1.0_wp, 0.5_wp, scheme%method%leapfrog), scheme%carries_energy, &
            scheme%method%transfer%affine(), scheme%method%transfer%turning())
         call view%increments%set_nodes(low, high, dt, &
            field%nodes%motion%velocity(:, :, view%slot), &
            field%nodes%motion%acceleration(:, :, view%slot))
         if (.not. needs_velocity_after(scheme)) return
         if (.not. allocated(view%after)) allocate (view%after(3, space%grid%tile_nodes))
         call combine(1.0_wp, field%nodes%motion%velocity(:, :, view%slot), dt, &
            field%nodes%motion%acceleration(:, :, view%slot), view%after)
         return
      end if
      if (.not. allocated(view%push)) allocate (view%push(3, space%grid%tile_nodes), &
         view%carry(3, space%grid%tile_nodes), source=0.0_wp)
      low = 1
      high = space%grid%tile_nodes
      ! fields of the lost energy are found on all nodes
      if (.not. scheme%carries_energy) call nodes_seen(space, field, tile, low, high)
      call find_filtered(space, scheme, field, tile, low, high, dt, view%filtered)
      call find_carriers(scheme, dt, field%nodes%motion%velocity(:, low:high, view%slot), &
         field%nodes%motion%acceleration(:, low:high, view%slot), view%filtered(:, low:high), &
         view%push(:, low:high), view%carry(:, low:high))
      associate (transfer => scheme%method%transfer, nodes => field%nodes, &
         velocity => field%nodes%motion%velocity(:, :, view%slot), filtered => view%filtered, &
         acceleration => field%nodes%motion%acceleration(:, :, view%slot))
         if (transfer%affine()) view%after = velocity + dt*acceleration
         if (.not. scheme%carries_energy) return
         if (transfer%sweeps() > 0) then
            call transfer%heat_fields(dt, velocity, acceleration, filtered, &
               nodes%series%term(:, :, tile), nodes%series%loss(:, :, tile), view%loss%heat, &
                  view%loss%scalar)
         else
            call transfer%heat_fields(dt, velocity, acceleration, filtered, filtered, none, &
               view%loss%heat, view%loss%scalar)
         end if
         if (.not. transfer%affine()) return
         view%loss%turn = (1.0_wp - transfer%flip_fraction())*velocity &
            - transfer%flip_fraction()*dt*acceleration
         if (.not. allocated(view%loss%moments)) &
            allocate (view%loss%moments(9, space%grid%tile_nodes))
         call moment_fields(space%grid, view%loss%turn, view%loss%moments)
      end associate
   end subroutine set_motion_view

   !> Velocity increment for the particles, and the velocity that moves them.
   pure subroutine find_carriers(scheme, dt, velocity, acceleration, filtered, push, carry)
      type(scheme_t), intent(in) :: scheme
      real(wp), intent(in) :: dt                     !! Time over which the forces act [s]
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (3, node) [m/s]
      real(wp), contiguous, intent(in) :: acceleration(:, :) !! (3, node) [m/s2]
      real(wp), contiguous, intent(in) :: filtered(:, :)     !! (3, node) Sum of the series [m/s]
      real(wp), contiguous, intent(inout) :: push(:, :)      !! (3, node) [m/s]
      real(wp), contiguous, intent(inout) :: carry(:, :)     !! (3, node) [m/s]

      call scheme%method%transfer%velocity_increment(dt, acceleration, filtered, push)
      if (scheme%method%leapfrog) then
         call scheme%method%transfer%advection_velocity(dt, velocity, acceleration, filtered, carry)
      else
         call combine(1.0_wp, velocity, 0.5_wp*dt, acceleration, carry)
      end if
   end subroutine find_carriers
end module step_node_view
