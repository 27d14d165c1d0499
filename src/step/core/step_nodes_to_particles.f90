! SPDX-License-Identifier: BSD-3-Clause
!> Nodes to particles, tile by tile: work, strain and stress, velocity and position. A tile stays in
!! cache throughout.
module step_nodes_to_particles
   use base_kinds, only: wp
   use material_kinematics, only: centre_backward, centre_gradient
   use material_type, only: material_t
   use mesh_grid, only: grid_t
   use omp_lib, only: omp_get_thread_num
   use particle_place, only: place_tile
   use particle_split, only: find_opening
   use particle_store, only: moved_off, store_t
   use particle_stretch, only: stretch_tile
   use step_body_force, only: record_loads
   use step_bounds, only: count_bad, find_steepest, guard_t
   use step_contact, only: add_contact_heat
   use step_dissipation, only: measures_damping, record_damping, record_losses
   use step_grid_volumes, only: correct_volumes
   use step_method, only: method_t, stress_before
   use step_move_nodes, only: restore_velocities
   use step_node_view, only: gather_parts_t, set_view, view_t
   use step_offending_particle, only: tile_bounds
   use step_particles_to_nodes, only: locate_particles
   use step_pressure_relaxation, only: has_normalised_sums, relax_pressures
   use step_remove_particles, only: erode_tile, fastest_left, retire_tile
   use step_simulation, only: scheme_t, scratch_t, simulation_t, space_t, velocity_field_t
   use step_strain_average, only: average_strain, keep_earlier
   use step_tile_cost, only: start_cost, stop_cost
   use step_velocity_remap, only: find_slopes
   use transfer_affine, only: gather_affine_heat, keep_affine
   use transfer_basis, only: expand_spin
   use transfer_bbar, only: average_dilatation
   use transfer_shape_data, only: spare
   use transfer_shock_compression, only: limit_compression, find_jump
   use transfer_side_kernels, only: add_other_gradient, add_other_values
   use transfer_sides, only: sides_t
   implicit none
   private

   public :: nodes_to_particles

contains

   !> Transfer the node fields to the particles.
   subroutine nodes_to_particles(simulation, field, parts, dt)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(inout) :: field
      type(gather_parts_t), intent(in) :: parts      !! Requested parts
      real(wp), intent(in) :: dt                     !! Time step [s]
      integer :: index

      associate (machine => simulation%machine)
         call machine%timer%start(machine%phase%gather)
         if (allocated(simulation%scheme%method%splitting) .and. parts%strain) then
            ! the growth rates of particles; those of other velocity fields are kept
            do index = field%first_store, field%last_store
               associate (store => simulation%stores(index))
                  if (.not. allocated(store%opening)) cycle
                  deallocate (store%opening)
                  allocate (store%opening(size(store%home)))
               end associate
            end do
         end if
         !$omp parallel default(none) shared(simulation, field, parts, dt)
         call gather_some(simulation, field, parts, dt)
         !$omp end parallel
         call machine%timer%stop(machine%phase%gather)
      end associate
   end subroutine nodes_to_particles

   !> The tiles of one thread. The view keeps its memory from tile to tile, because allocating it
   !! again costs as much as the transfer itself for a tile of one or two particles.
   subroutine gather_some(simulation, field, parts, dt)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(inout) :: field
      type(gather_parts_t), intent(in) :: parts      !! Requested parts
      real(wp), intent(in) :: dt                     !! Time step [s]
      type(view_t) :: view, other
      integer :: tile
      real(wp) :: lap

      associate (scratch => simulation%scratch(omp_get_thread_num()))
         call scratch%laps%start_step(simulation%clock%step)
         !$omp do schedule(dynamic, 1)
         do tile = 1, simulation%space%tiles%own
            call start_cost(simulation%machine, tile)
            lap = scratch%laps%read_clock()
            call gather_tile(simulation, field, scratch, tile, parts, dt, view, other)
            call scratch%laps%record(lap)
            call stop_cost(simulation%machine, tile)
         end do
         !$omp end do
      end associate
   end subroutine gather_some

   !> One tile.
   subroutine gather_tile(simulation, field, scratch, tile, parts, dt, view, other)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(inout) :: field
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      integer, intent(in) :: tile
      type(gather_parts_t), intent(in) :: parts      !! Requested parts
      real(wp), intent(in) :: dt                     !! Time step [s]
      type(view_t), intent(inout) :: view            !! Node fields for its particles
      type(view_t), intent(inout) :: other           !! The same of the other side, if it has one
      real(wp) :: fastest, steepest
      integer :: index

      associate (space => simulation%space, scheme => simulation%scheme, &
         effects => simulation%effects, materials => simulation%materials, &
         stores => simulation%stores, clock => simulation%clock)
         if (allocated(effects%contact)) then
            if (all([(stores(index)%count(tile) == 0, index=field%first_store, &
               field%last_store)])) return
         end if
         call restore_velocities(space, scheme%method, field%nodes, tile)
         call set_view(space, stores, scheme, clock, field%nodes, tile, parts, view)
         other%slot = 0
         if (allocated(field%sides)) then
            if (field%sides%cut(tile)) call set_view(space, stores, scheme, clock, &
               simulation%fields(field%other)%nodes, tile, parts, other)
         end if
         do index = field%first_store, field%last_store
            if (stores(index)%count(tile) == 0) cycle
            call locate_particles(space, scheme, field, scratch, stores(index), tile)
            call scratch%deformation%reserve(stores(index)%count(tile) + spare)
            if (parts%work) call add_particle_work(simulation, field, scratch, index, &
               tile, view, other)
            if (parts%motion) call gather_increments(simulation, field, scratch, index, &
               tile, view, other)
            fastest = 0.0_wp
            steepest = scratch%steepest
            if (parts%strain) call strain_particles(simulation, field, scratch, index, tile, &
               view, dt, fastest)
            if (parts%motion) then
               call move_particles(simulation, field, scratch, index, tile, view, other, dt)
               call place_tile(space%grid, space%boundary, space%tiles%coordinate(:, tile), &
                  stores(index), tile)
               call judge_particles(materials(index), stores(index), scheme, clock%guard, scratch, &
                  tile, fastest, steepest)
            end if
            scratch%fastest = max(scratch%fastest, fastest)
         end do
      end associate
   end subroutine gather_tile

   !> Work of the stress and of the loads on the particles of a tile.
   subroutine add_particle_work(simulation, field, scratch, index, tile, view, other)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(in) :: field
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread, particles located
      integer, intent(in) :: index                   !! Index of the material and of its store
      integer, intent(in) :: tile
      type(view_t), intent(in) :: view               !! Node fields
      type(view_t), intent(in) :: other !! Node fields of the other side, if the tile has one

      associate (space => simulation%space, method => simulation%scheme%method, &
         effects => simulation%effects, store => simulation%stores(index), &
         clock => simulation%clock)
         call find_gradient(space, method, scratch, store, tile, view%middle_velocity, &
            view%middle_gradient, clock%kick, .true.)
         if (other%slot > 0) call add_gradient(space%grid, simulation%stores, field%sides, &
            scratch, index, tile, other%middle_velocity - view%middle_velocity, clock%kick)
         if (allocated(store%state%energy)) call add_work(scratch, store, tile)
         if (allocated(effects%loads)) call record_loads(space, method, effects, clock, scratch, &
            store, tile, view%middle_velocity)
      end associate
   end subroutine add_particle_work

   !> Increments of velocity and position, if they are gathered at once, and what changes the energy
   !! and volume of the particles of a tile before the strain, which may renew the linear velocity
   !! fields.
   subroutine gather_increments(simulation, field, scratch, index, tile, view, other)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(in) :: field
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread, particles located
      integer, intent(in) :: index                   !! Index of the material and of its store
      integer, intent(in) :: tile
      type(view_t), intent(in) :: view               !! Node fields
      type(view_t), intent(in) :: other !! Node fields of the other side, if the tile has one

      associate (grid => simulation%space%grid, method => simulation%scheme%method, &
         store => simulation%stores(index), material => simulation%materials(index))
         if (view%at_once) call view%increments%gather(grid, method%basis, scratch%shape)
         if (view%at_once .and. other%slot > 0) call add_other_values(grid, scratch%shape, &
            store%first(tile), field%sides%store(index - field%sides%before)%other, &
            field%sides%split(:, tile), 1.0_wp, view%increments%nodes, other%increments%nodes, 0, &
            scratch%shape%increments)
         if (allocated(store%state%energy)) call add_heat(grid, method, scratch, store, tile, view)
         if (material%repacks) then
            ! volumes of loose particles from the fill of the nodes
            call method%basis%gather_values(grid, scratch%shape, view%excess, scratch%shape%values)
            call correct_volumes(store, tile, material, scratch%shape%values, scratch%ledger)
         end if
         if (allocated(simulation%effects%contact)) call add_contact_heat(grid, method, &
            field%nodes, scratch, store, tile)
      end associate
   end subroutine gather_increments

   !> Find particles that are out of bounds or have failed, and remove them if the deck says so. The
   !! remaining particles limit the next step.
   subroutine judge_particles(material, store, scheme, guard, scratch, tile, fastest, steepest)
      type(material_t), intent(in) :: material
      type(store_t), intent(inout) :: store
      type(scheme_t), intent(in) :: scheme
      type(guard_t), intent(in) :: guard
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      integer, intent(in) :: tile
      real(wp), intent(inout) :: fastest             !! Fastest signal and motion of tile [m/s]
      real(wp), intent(in) :: steepest               !! Square of |grad v|, tile excluded [1/s2]
      logical :: sound

      sound = count_bad(store, tile, material%density, tile_bounds(material, guard)) < 0.5_wp
      if (.not. sound .and. guard%bounds%retire) then
         call retire_tile(material, store, guard, scratch, tile, sound)
         scratch%retired = .true.
      end if
      scratch%sound = scratch%sound .and. sound
      if (scheme%erosion .and. allocated(store%state%failed)) call erode_tile(material, store, &
         scratch, tile)
      if (.not. (scheme%erosion .or. guard%bounds%retire)) return
      if (.not. any(store%home(store%first(tile):store%first(tile) + store%count(tile) - 1) == &
         moved_off)) return
      if (fastest > 0.0_wp) fastest = fastest_left(store, tile, scratch%deformation%wave_speed)
      scratch%steepest = steepest
   end subroutine judge_particles

   !> Heat from the kinetic energy that the transfers to the nodes and back lose.
   subroutine add_heat(grid, method, scratch, store, tile, view)
      type(grid_t), intent(in) :: grid
      type(method_t), intent(in) :: method
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      type(store_t), intent(inout) :: store
      integer, intent(in) :: tile
      type(view_t), intent(in) :: view               !! Node fields
      integer :: p, k

      associate (shape => scratch%shape, first => store%first(tile))
         if (view%at_once) then
            call view%increments%add_heat(grid, shape, first, store%velocity, store%spin, &
               store%affine, store%state%energy)
            return
         end if
         call method%transfer%heat(grid, method%basis, shape, first, view%loss%heat, &
            view%loss%scalar, &
            store%velocity, store%state%energy)
         if (.not. method%transfer%affine()) return
         call shape%reserve_affine(store%count(tile))
         if (allocated(store%spin)) then
            call expand_spin(first, store%count(tile), store%spin, shape%affine)
         else
            do k = 1, 9
               do p = 1, store%count(tile)
                  shape%affine(p, k) = store%affine(first + p - 1, k)
               end do
            end do
         end if
         call gather_affine_heat(grid, method%basis, shape, first, view%loss%turn, &
            view%loss%moments, &
            store%state%energy)
      end associate
   end subroutine add_heat

   !> New velocities and positions of the particles of a tile.
   subroutine move_particles(simulation, field, scratch, index, tile, view, other, dt)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(in) :: field
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      integer, intent(in) :: index                   !! Index of the material and of its store
      integer, intent(in) :: tile
      type(view_t), intent(in) :: view               !! Node fields
      type(view_t), intent(in) :: other !! Node fields of the other side, if the tile has one
      real(wp), intent(in) :: dt                     !! Time step [s]

      associate (space => simulation%space, grid => simulation%space%grid, &
         scheme => simulation%scheme, method => simulation%scheme%method, shape => scratch%shape, &
         store => simulation%stores(index), first => simulation%stores(index)%first(tile))
         if (view%at_once) then
            call view%increments%move(shape, first, dt, store%velocity, store%position)
         else
            call method%basis%gather_motion(grid, shape, first, view%velocity_increment, &
               view%advection_velocity, method%transfer%flip_fraction(), dt, store%velocity, &
               store%position)
            if (other%slot > 0) then
               associate (sides => field%sides, split => field%sides%split(:, tile))
                  call add_other_values(grid, shape, first, &
                     sides%store(index - sides%before)%other, split, 1.0_wp, &
                     view%velocity_increment, other%velocity_increment, first - 1, store%velocity)
                  call add_other_values(grid, shape, first, &
                     sides%store(index - sides%before)%other, split, dt, view%advection_velocity, &
                     other%advection_velocity, first - 1, store%position)
               end associate
            end if
         end if
         if (allocated(space%cell)) call carry_particles(space, scheme%method, scratch, store, &
            tile, view, dt)
         if (measures_damping(method, scheme%carries_energy)) then
            if (view%at_once) then
               call view%increments%find_way(shape)
            else
               call method%basis%gather_values(grid, shape, view%advection_velocity, shape%vector)
            end if
            call record_damping(scratch%ledger, store, tile, shape%vector, &
               method%transfer%flip_fraction())
         end if
         if (.not. method%transfer%affine() .or. affine_from_strain(scheme, index)) return
         call find_slopes(space%grid, scheme%method, shape, view%velocity_new, view%gradient, &
            scratch%deformation%gradient)
         if (other%slot > 0) call add_gradient(space%grid, simulation%stores, field%sides, &
            scratch, index, tile, other%velocity_new - view%velocity_new, 1.0_wp)
         call keep_affine(store, tile, 1.0_wp, scratch%deformation%gradient)
      end associate
   end subroutine move_particles

   !> Positions on the mesh of a cell that deforms.
   subroutine carry_particles(space, method, scratch, store, tile, view, dt)
      type(space_t), intent(in) :: space
      type(method_t), intent(in) :: method
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      type(store_t), intent(inout) :: store
      integer, intent(in) :: tile
      type(view_t), intent(in) :: view               !! Node fields
      real(wp), intent(in) :: dt                     !! Time step [s]

      associate (shape => scratch%shape)
         if (view%at_once) then
            call view%increments%find_way(shape)
         else
            call method%basis%gather_values(space%grid, shape, &
               view%advection_velocity, shape%vector)
         end if
         call space%cell%carry(store%first(tile), store%count(tile), dt, shape%vector, &
            store%position)
      end associate
   end subroutine carry_particles

   !> Do linear velocity fields come from the strain of the step? The modified gradient is less
   !! noisy than that of the cell, and after the step it is the gradient of the new velocities. With
   !! normalised sums it is not used: there the modified gradient of a linear field is not uniform.
   pure logical function affine_from_strain(scheme, index) result(renewed)
      type(scheme_t), intent(in) :: scheme
      integer, intent(in) :: index                   !! Index of the material and of its store

      renewed = scheme%method%dual .and. scheme%method%stress /= stress_before
      if (renewed .and. allocated(scheme%normalises)) renewed = .not. scheme%normalises(index)
   end function affine_from_strain

   !> Work of the stress that made the force on the mean of the velocities of the nodes, so that
   !! particles gain the kinetic energy that nodes lose: (T.8) of doc/theory/transfers.md.
   pure subroutine add_work(scratch, store, tile)
      type(scratch_t), intent(in) :: scratch !! Scratch memory of this thread, with the gradient
      type(store_t), intent(inout) :: store
      integer, intent(in) :: tile
      integer :: p, q, first

      first = store%first(tile)
      associate (stress => store%state%stress, gradient => scratch%deformation%gradient)
         do p = 1, store%count(tile)
            q = first + p - 1
            store%state%energy(q) = store%state%energy(q) + store%state%volume(q) &
               /store%state%mass(q)*(stress(q, 1)*gradient(p, 1) + stress(q, 2)*gradient(p, 5) &
               + stress(q, 3)*gradient(p, 9) + stress(q, 4)*(gradient(p, 2) + gradient(p, 4)) &
               + stress(q, 5)*(gradient(p, 6) + gradient(p, 8)) &
               + stress(q, 6)*(gradient(p, 3) + gradient(p, 7)))
         end do
      end associate
   end subroutine add_work

   !> Velocity gradient times the time step at the particles of a tile.
   subroutine find_gradient(space, method, scratch, store, tile, velocity, gradient, dt, works)
      type(space_t), intent(in) :: space
      type(method_t), intent(in) :: method
      type(scratch_t), intent(inout) :: scratch      !! Gets the gradient
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile
      real(wp), contiguous, intent(in) :: velocity(:, :)   !! (3, node) [m/s]
      real(wp), allocatable, intent(in) :: gradient(:, :)  !! (9, node) Node gradient, if dual [1/s]
      real(wp), intent(in) :: dt                     !! Time step [s]
      logical, intent(in) :: works                   !! For the work of the stress, not the strain?

      associate (grid => space%grid, shape => scratch%shape, start => store%cell_start(:, tile))
         if (method%dual) then
            call method%quadrature%gather_gradient(grid, shape, velocity, gradient, dt, &
               scratch%deformation%gradient)
         else
            call method%basis%gather_gradient(grid, shape, velocity, dt, &
               scratch%deformation%gradient)
         end if
         if (grid%axisymmetric) call method%basis%gather_hoop(grid, shape, store%first(tile), &
            store%position, velocity, dt, scratch%deformation%gradient)
         if (allocated(space%cell)) then
            if (works) then
               call space%cell%place_work(store%count(tile), dt, scratch%deformation%gradient)
            else
               call space%cell%place_strain(store%count(tile), scratch%deformation%gradient)
            end if
         end if
         if (method%even) call average_dilatation(grid, start, store%first(tile), &
            store%state%volume, scratch%deformation%gradient)
      end associate
   end subroutine find_gradient

   !> Add the difference between the sides of nodes to a velocity gradient times the time step.
   subroutine add_gradient(grid, stores, sides, scratch, index, tile, difference, dt)
      type(grid_t), intent(in) :: grid
      type(store_t), intent(in) :: stores(:)
      type(sides_t), intent(in) :: sides
      type(scratch_t), intent(inout) :: scratch !! Scratch memory of this thread, with the gradient
      integer, intent(in) :: index                   !! Index of the material and of its store
      integer, intent(in) :: tile
      real(wp), intent(in) :: difference(:, :)       !! (3, node) Difference of the velocities [m/s]
      real(wp), intent(in) :: dt                     !! Time step [s]

      if (.not. sides%cut(tile)) return
      associate (store => stores(index))
         call add_other_gradient(grid, scratch%shape, store, tile, &
            sides%store(index - sides%before)%other, sides%split(:, tile), dt, difference, &
            scratch%deformation%gradient)
      end associate
   end subroutine add_gradient

   !> Gradient of the velocity that strains times the time step, of both sides if the field has two.
   subroutine find_strain(simulation, field, scratch, index, tile, view, dt)
      type(simulation_t), intent(in) :: simulation
      type(velocity_field_t), intent(in) :: field
      type(scratch_t), intent(inout) :: scratch !! Scratch memory of this thread; gets the gradient
      integer, intent(in) :: index                   !! Index of the material and of its store
      integer, intent(in) :: tile
      type(view_t), intent(in) :: view               !! Node fields
      real(wp), intent(in) :: dt                     !! Time step [s]
      real(wp), allocatable :: difference(:, :)

      associate (space => simulation%space, stores => simulation%stores, &
         mine => field%nodes%motion)
         call find_gradient(space, simulation%scheme%method, scratch, stores(index), tile, &
            mine%strain(:, :, view%slot), view%gradient, dt, .false.)
         if (.not. field%other > 0) return
         associate (theirs => simulation%fields(field%other)%nodes%motion)
            difference = theirs%strain(:, :, tile) - mine%strain(:, :, tile)
            call add_gradient(space%grid, stores, field%sides, scratch, index, tile, difference, dt)
         end associate
      end associate
   end subroutine find_strain

   !> Strain the particles of a tile and update the stress of their material.
   subroutine strain_particles(simulation, field, scratch, index, tile, view, dt, fastest)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(in) :: field
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      integer, intent(in) :: index                   !! Index of the material and of its store
      integer, intent(in) :: tile
      type(view_t), intent(in) :: view               !! Node fields
      real(wp), intent(in) :: dt                     !! Time of the strain [s]
      real(wp), intent(out) :: fastest               !! Fastest signal and motion [m/s]
      integer :: p, first, n

      first = simulation%stores(index)%first(tile)
      n = simulation%stores(index)%count(tile)
      associate (grid => simulation%space%grid, scheme => simulation%scheme, &
         method => simulation%scheme%method, store => simulation%stores(index), &
         motion => field%nodes%motion, deformation => scratch%deformation)
         deformation%plane = grid%dimensions < 3
         if (method%averages()) then
            call find_gradient(simulation%space, method, scratch, store, tile, motion%velocity(:, &
               :, view%slot), view%gradient_before, simulation%clock%dt, .false.)
            call centre_backward(n, deformation%plane, deformation%gradient)
            call keep_earlier(n, deformation%gradient, scratch%half_strain)
         end if
         call find_strain(simulation, field, scratch, index, tile, view, dt)
         if (.not. view%limits_nothing) call find_steepest(deformation%gradient, &
            store%identity(first:first + n - 1), dt, view%limiting_rate, scratch%steepest, &
            scratch%steepest_identity)
         if (method%transfer%affine() .and. affine_from_strain(scheme, index) .and. &
            .not. view%particles_moved) call keep_affine(store, tile, 1.0_wp/dt, &
            deformation%gradient)
         call stretch_tile(store, tile, deformation%gradient)
         if (allocated(store%opening)) call find_opening(method%splitting, grid%spacing, &
            store, tile, deformation%gradient, dt)
         if (view%particles_moved .and. method%leapfrog) then
            call centre_backward(n, deformation%plane, deformation%gradient)
         else
            call centre_gradient(n, deformation%plane, deformation%gradient)
         end if
         if (method%averages()) call average_strain(store, tile, scratch%half_strain, &
            deformation%gradient)
         if (method%limited) call find_jump(grid, store%cell_start(:, tile), &
            motion%strain(:, :, view%slot), view%gradient, deformation%gradient, &
            deformation%jump)
         if (has_normalised_sums(scheme, index)) call limit_compression(grid, &
            store%cell_start(:, tile), motion%strain(:, :, view%slot), dt, &
            deformation%gradient, deformation%jump)
         call scratch%laps%update(simulation%materials(index), store%state, deformation, first, &
            first + n - 1, dt, grid%spacing)
         call relax_pressures(grid, simulation%stores, scheme, field%nodes%sums, index, tile, &
            scratch%shape%local, deformation%wave_speed, dt)
         fastest = 0.0_wp
         do p = 1, n
            fastest = max(fastest, deformation%wave_speed(p) &
               + sqrt(store%velocity(first + p - 1, 1)**2 + store%velocity(first + p - 1, 2)**2 &
               + store%velocity(first + p - 1, 3)**2))
         end do
         call record_losses(scratch%ledger, simulation%materials(index), store%state, &
            deformation, n)
      end associate
   end subroutine strain_particles
end module step_nodes_to_particles
