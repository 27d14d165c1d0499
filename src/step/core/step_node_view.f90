! SPDX-License-Identifier: BSD-3-Clause
!> Node fields of a tile for its particles. Fields that are not needed are not allocated,
!! and the memory is reused for the next tile.
module step_node_view
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   use mesh_patch, only: assemble, combine
   use particle_store, only: store_t
   use step_bounds, only: are_nodes_slow, limiting_gradient
   use step_dissipation, only: measures_damping
   use step_dual_gradient, only: node_gradient
   use step_grid_volumes, only: excess_fill
   use step_method, only: method_t, stress_before
   use step_node_fields, only: gradient_rows, motion_nodes_t, nodes_t
   use step_particles_to_nodes, only: nodes_seen
   use step_simulation, only: clock_t, scheme_t, space_t
   use transfer_affine, only: moment_fields
   use transfer_increments, only: increments_t
   implicit none
   private

   public :: gather_parts_t, set_view, view_t

   !> Selected parts of the transfer to the particles.
   type :: gather_parts_t
      logical :: work = .false.                      !! Work of the stress of the force
      logical :: strain = .false.                    !! Strain and stress
      logical :: motion = .false.                    !! Particle velocities, positions and cells
      logical :: plain = .false.                     !! Without the means that belong to them?
   end type gather_parts_t

   !> Kinetic energy lost at the nodes of a tile, for its particles.
   type :: loss_view_t
      real(wp), allocatable :: heat(:, :) !! (column, node) Fields gathered at the particles
      real(wp), allocatable :: turn(:, :) !! (3, node) Velocity from linear velocity fields [m/s]
      real(wp), allocatable :: moments(:, :)         !! (9, node) Moments of these [m2/s]
   end type loss_view_t

   !> Node fields of one tile that the particles need. Fields that are not needed are not allocated.
   type :: view_t
      real(wp), allocatable :: middle_velocity(:, :) !! (3, node) In the middle of the step [m/s]
      real(wp), allocatable :: velocity_increment(:, :) !! (3, node) For the particles [m/s]
      real(wp), allocatable :: advection_velocity(:, :) !! (3, node) It moves the particles [m/s]
      real(wp), allocatable :: velocity_new(:, :)    !! (3, node) After the step [m/s]
      real(wp), allocatable :: gradient(:, :)        !! (9, node) Node gradient of strain [1/s]
      real(wp), allocatable :: middle_gradient(:, :) !! (9, node) Of the middle velocity [1/s]
      real(wp), allocatable :: gradient_before(:, :) !! (9, node) Before the step [1/s]
      !> (component, node) What the means of these three over the particles have too much [1/s]
      real(wp), allocatable :: surplus(:, :), middle_surplus(:, :), surplus_before(:, :)
      type(loss_view_t) :: loss                      !! Lost kinetic energy
      type(increments_t) :: increments               !! Increments and heat, if gathered at once
      logical :: at_once = .false.                   !! Are they gathered at once?
      real(wp), allocatable :: excess(:, :) !! (1, node) Fill less 1, for loose material [1]
      real(wp) :: limiting_rate = 0.0_wp             !! Smaller |grad v| do not limit steps [1/s]
      logical :: limits_nothing = .false.            !! Can no gradient limit the step?
      logical :: particles_moved = .false.           !! Have the particles moved already?
      integer :: slot = 0                            !! Index of the fields of the tile
   end type view_t

contains

   !> Set the node fields of a tile for its particles.
   subroutine set_view(space, stores, scheme, clock, nodes, tile, parts, view)
      type(space_t), intent(in) :: space
      type(store_t), intent(in) :: stores(:)
      type(scheme_t), intent(in) :: scheme
      type(clock_t), intent(in) :: clock
      type(nodes_t), intent(in) :: nodes
      integer, intent(in) :: tile
      type(gather_parts_t), intent(in) :: parts      !! Requested parts
      type(view_t), intent(inout) :: view            !! Node fields for the particles
      integer :: low, high

      view%limits_nothing = .false.
      view%particles_moved = .not. parts%motion
      view%slot = nodes%motion%slot(tile)
      if (parts%work) then
         call nodes_seen(space%grid, nodes%motion, tile, low, high)
         if (.not. allocated(view%middle_velocity)) &
            allocate (view%middle_velocity(3, space%grid%tile_nodes), source=0.0_wp)
         call combine(1.0_wp, nodes%motion%velocity(:, low:high, view%slot), 0.5_wp*clock%kick, &
            nodes%motion%acceleration(:, low:high, view%slot), view%middle_velocity(:, low:high))
      end if
      if (parts%motion) call set_motion_view(space%grid, scheme, nodes, tile, clock%kick, view)
      if (parts%strain) call find_steep(space, stores, scheme%method, clock, nodes%motion, view)
      if (.not. scheme%method%dual) return
      if (parts%motion .and. scheme%repacks) call excess_fill(space%grid, space%boundary, &
         space%tiles%coordinate(:, tile), tile, nodes%dual%filled(:, :, tile), &
         nodes%dual%volume(:, :, tile), view%excess)
      if (parts%strain .or. (parts%motion .and. scheme%method%transfer%affine())) &
         call node_gradient(space, nodes, tile, nodes%dual%gradient, view%gradient)
      if (parts%work .and. scheme%works) call node_gradient(space, nodes, tile, &
         nodes%dual%middle_gradient, view%middle_gradient)
      if (parts%strain .and. scheme%method%averages()) call node_gradient(space, nodes, tile, &
         nodes%dual%gradient_before, view%gradient_before)
      if (.not. scheme%method%controlled() .or. parts%plain) return
      if (parts%strain) call find_surplus(space, nodes, tile, 0, view%gradient, view%surplus)
      if (parts%strain .and. scheme%method%averages()) call find_surplus(space, nodes, tile, 1, &
         view%gradient_before, view%surplus_before)
      if (parts%work .and. scheme%works) call find_surplus(space, nodes, tile, &
         scheme%gradients() - 1, view%middle_gradient, view%middle_surplus)
   end subroutine set_view

   !> What the mean of the gradients of the particles around each node has too much: its sum over
   !! the particles, less the exact one of the grid. Equation (Q.4) of doc/theory/quadratures.md.
   subroutine find_surplus(space, nodes, tile, before, gradient, surplus)
      type(space_t), intent(in) :: space
      type(nodes_t), intent(in) :: nodes
      integer, intent(in) :: tile
      integer, intent(in) :: before                  !! Sums before those of this gradient
      real(wp), intent(in) :: gradient(:, :)         !! (9, node) Of the grid [1/s]
      real(wp), allocatable, intent(inout) :: surplus(:, :) !! (component of `gradient_rows`, node)
      real(wp) :: total(size(nodes%stress%strain, 1), space%grid%tile_nodes)
      real(wp) :: tensor(9, space%grid%tile_nodes)
      integer, allocatable :: rows(:)
      integer :: node, k, first

      allocate (rows, source=gradient_rows(space%grid))
      first = before*size(rows)
      if (.not. allocated(surplus)) allocate (surplus(size(rows), space%grid%tile_nodes))
      call assemble(space%grid, space%tiles, nodes%stress%strain, tile, total)
      associate (share => nodes%stress%share(1, :, tile), &
         volume => nodes%dual%volume(1, :, nodes%motion%slot(tile)))
         do node = 1, size(surplus, 2)
            do k = 1, size(rows)
               tensor(rows(k), node) = share(node)*(total(first + k, node) &
                  - volume(node)*gradient(rows(k), node))
            end do
         end do
      end associate
      call space%boundary%mirror(space%grid, space%tiles%coordinate(:, tile), tensor)
      do node = 1, size(surplus, 2)
         do k = 1, size(rows)
            surplus(k, node) = tensor(rows(k), node)
         end do
      end do
   end subroutine find_surplus

   !> Find which velocity gradients can limit the next step, and whether any node gradient is that
   !! steep. Node velocities alone decide this only where gradients are those of shape functions.
   subroutine find_steep(space, stores, method, clock, motion, view)
      type(space_t), intent(in) :: space
      type(store_t), intent(in) :: stores(:)
      type(method_t), intent(in) :: method
      type(clock_t), intent(in) :: clock
      type(motion_nodes_t), intent(in) :: motion
      type(view_t), intent(inout) :: view            !! Node fields for the particles

      associate (grid => space%grid)
         view%limiting_rate = limiting_gradient(clock%guard%bounds, method%step_growth, &
            clock%dt_next)
         if (method%dual .or. grid%axisymmetric .or. allocated(stores(1)%domain)) return
         if (allocated(space%cell)) return
         ! nine components, each at most twice the greatest velocity over the edge of a cell
         view%limits_nothing = are_nodes_slow(3*grid%tile_nodes, motion%strain(:, :, view%slot), &
            0.9_wp/6.0_wp*grid%spacing*view%limiting_rate)
      end associate
   end subroutine find_steep

   !> The node fields that move the particles of a tile, and those of the kinetic energy that the
   !! transfers to the nodes and back lose. Without leapfrog, equation (M.21) of
   !! doc/theory/method.md moves them.
   subroutine set_motion_view(grid, scheme, nodes, tile, dt, view)
      type(grid_t), intent(in) :: grid
      type(scheme_t), intent(in) :: scheme
      type(nodes_t), intent(in) :: nodes
      integer, intent(in) :: tile
      real(wp), intent(in) :: dt                     !! Time over which the forces act [s]
      type(view_t), intent(inout) :: view            !! Node fields for the particles
      integer :: low, high

      associate (transfer => scheme%method%transfer)
         ! velocity, displacement and lost kinetic energy from fields that are gathered once;
         ! without energy and damping, fields update velocity and position
         view%at_once = transfer%flip_fraction() > 0.5_wp .and. &
            (scheme%carries_energy .or. measures_damping(scheme%method, scheme%carries_energy))
         if (view%at_once) then
            call nodes_seen(grid, nodes%motion, tile, low, high)
            call view%increments%choose(grid, transfer%flip_fraction(), &
               merge(1.0_wp, 0.5_wp, scheme%method%leapfrog), scheme%carries_energy, &
               transfer%affine(), transfer%turning())
            call view%increments%set_nodes(low, high, dt, nodes%motion%velocity(:, :, view%slot), &
               nodes%motion%acceleration(:, :, view%slot))
            if (.not. (scheme%method%transfer%affine() .and. (allocated(scheme%normalises) .or. &
               .not. scheme%method%dual .or. scheme%method%stress == stress_before))) return
            if (.not. allocated(view%velocity_new)) allocate (view%velocity_new(3, grid%tile_nodes))
            call combine(1.0_wp, nodes%motion%velocity(:, :, view%slot), dt, &
               nodes%motion%acceleration(:, :, view%slot), view%velocity_new)
            return
         end if
         if (.not. allocated(view%velocity_increment)) allocate (view%velocity_increment(3, &
            grid%tile_nodes), view%advection_velocity(3, grid%tile_nodes), source=0.0_wp)
         low = 1
         high = grid%tile_nodes
         ! fields of the lost energy are found on all nodes
         if (.not. scheme%carries_energy) call nodes_seen(grid, nodes%motion, tile, low, high)
         associate (velocity => nodes%motion%velocity(:, :, view%slot), &
            acceleration => nodes%motion%acceleration(:, :, view%slot))
            call transfer%velocity_increment(dt, velocity(:, low:high), &
               acceleration(:, low:high), view%velocity_increment(:, low:high))
            call combine(1.0_wp, velocity(:, low:high), &
               merge(1.0_wp, 0.5_wp, scheme%method%leapfrog)*dt, acceleration(:, low:high), &
               view%advection_velocity(:, low:high))
            if (transfer%affine()) view%velocity_new = velocity + dt*acceleration
            if (.not. scheme%carries_energy) return
            call transfer%heat_fields(dt, velocity, acceleration, view%loss%heat)
            if (.not. transfer%affine()) return
            view%loss%turn = (1.0_wp - transfer%flip_fraction())*velocity &
               - transfer%flip_fraction()*dt*acceleration
            if (.not. allocated(view%loss%moments)) allocate (view%loss%moments(9, grid%tile_nodes))
            call moment_fields(grid, view%loss%turn, view%loss%moments)
         end associate
      end associate
   end subroutine set_motion_view
end module step_node_view
