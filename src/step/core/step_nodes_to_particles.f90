! SPDX-License-Identifier: BSD-3-Clause
!> Nodes to particles, tile by tile: work, strain and stress, velocity and position. A tile stays in
!! cache throughout.
module step_nodes_to_particles
   use base_kinds, only: int64, wp
   use material_kinematics, only: centre_backward, centre_gradient
   use omp_lib, only: omp_get_thread_num
   use particle_place, only: place_tile
   use particle_split, only: find_opening
   use particle_store, only: moved_off, store_t
   use particle_stretch, only: stretch_tile
   use step_body_force, only: record_loads
   use step_bounds, only: count_bad, find_steepest
   use step_contact, only: add_contact_heat
   use step_dissipation, only: damps, record_damping, record_losses
   use step_grid_volumes, only: correct_volumes
   use step_method, only: method_t, stress_before
   use step_move_nodes, only: restore_velocities
   use step_node_view, only: gather_parts_t, set_other_view, set_view, view_t
   use step_offending_particle, only: tile_bounds
   use step_particles_to_nodes, only: locate_particles
   use step_pressure_relaxation, only: normalised, relax_pressures
   use step_remove_particles, only: erode_tile, fastest_left, retire_tile
   use step_simulation, only: scheme_t, scratch_t, simulation_t, space_t, velocity_field_t
   use step_strain_average, only: average_strain, keep_earlier
   use step_tile_cost, only: cost_clock, record_cost
   use step_velocity_remap, only: find_slopes
   use transfer_affine, only: gather_affine_heat, keep_affine
   use transfer_basis, only: expand_spin
   use transfer_bbar, only: average_dilatation
   use transfer_shape_data, only: shape_data_t, spare
   use transfer_shock_compression, only: limit_compression, find_jump
   use transfer_side_kernels, only: add_other_gradient, add_other_values
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

      call simulation%machine%timer%start(simulation%machine%phase%gather)
      if (allocated(simulation%scheme%method%splitting) .and. parts%strain) &
         call ensure_opening(simulation%stores(field%first_store:field%last_store))
      !$omp parallel default(none) shared(simulation, field, parts, dt)
      call gather_some(simulation, field, parts, dt)
      !$omp end parallel
      call simulation%machine%timer%stop(simulation%machine%phase%gather)
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
      real(wp) :: began, lap

      associate (scratch => simulation%scratch(omp_get_thread_num()))
         call scratch%laps%start_step(simulation%clock%step)
         !$omp do schedule(dynamic, 1)
         do tile = 1, simulation%space%tiles%own
            began = cost_clock(simulation%machine)
            lap = scratch%laps%read_clock()
            call gather_tile(simulation, field, scratch, tile, parts, dt, view, other)
            call scratch%laps%record(lap)
            call record_cost(simulation%machine, tile, began)
         end do
         !$omp end do
      end associate
   end subroutine gather_some

   !> Allocate the growth rates of particles. Those of other velocity fields are kept.
   pure subroutine ensure_opening(stores)
      type(store_t), intent(inout) :: stores(:)      !! The particles of the velocity field
      integer :: index

      do index = 1, size(stores)
         if (.not. allocated(stores(index)%opening)) cycle
         deallocate (stores(index)%opening)
         allocate (stores(index)%opening(size(stores(index)%home)))
      end do
   end subroutine ensure_opening

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

      if (allocated(simulation%effects%contact)) then
         if (all([(simulation%stores(index)%count(tile) == 0, &
            index=field%first_store, field%last_store)])) return
      end if
      call restore_velocities(simulation, field, tile)
      call set_view(simulation, field, tile, parts, view)
      call set_other_view(simulation, field, tile, parts, other)
      do index = field%first_store, field%last_store
         if (simulation%stores(index)%count(tile) == 0) cycle
         associate (store => simulation%stores(index))
            call locate_particles(simulation%space, simulation%scheme, field, scratch, store, tile)
            call scratch%deformation%reserve(store%count(tile) + spare)
            if (parts%work) call find_gradient(simulation, scratch, store, tile, view%centre, &
               view%middle, simulation%clock%kick, .true.)
            if (parts%work .and. other%slot > 0) call add_gradient(simulation, field, scratch, &
               index, tile, other%centre - view%centre, simulation%clock%kick)
            if (parts%work .and. allocated(store%state%energy)) call add_work(scratch, store, tile)
            if (parts%work .and. allocated(simulation%effects%loads)) call record_loads( &
               simulation, scratch, store, tile, view%centre)
            if (parts%motion .and. view%at_once) call view%increments%gather( &
               simulation%space%grid, simulation%scheme%method%basis, scratch%shape)
            if (parts%motion .and. view%at_once .and. other%slot > 0) call add_values(simulation, &
               field, scratch%shape, index, tile, 1.0_wp, view%increments%nodes, &
               other%increments%nodes, 0, scratch%shape%increments)
            ! before the strain, which may renew the linear velocity fields
            if (parts%motion .and. allocated(store%state%energy)) &
               call add_heat(simulation%space, simulation%scheme, scratch, store, tile, view)
            if (parts%motion .and. simulation%materials(index)%repacks) &
               call repack_particles(simulation, scratch, index, tile, view)
            if (parts%motion .and. allocated(simulation%effects%contact)) &
               call add_contact_heat(simulation%space, simulation%scheme, field, scratch, store, &
                  tile)
            fastest = 0.0_wp
            steepest = scratch%steepest
            if (parts%strain) call strain_particles(simulation, field, scratch, index, tile, view, &
               dt, fastest)
            if (parts%motion) then
               call move_particles(simulation, field, scratch, index, tile, view, other, dt)
               call place_tile(simulation%space%grid, simulation%space%boundary, &
                  simulation%space%tiles%coordinate(:, tile), store, tile)
               call judge_particles(simulation, scratch, index, tile, fastest, steepest)
            end if
            scratch%fastest = max(scratch%fastest, fastest)
         end associate
      end do
   end subroutine gather_tile

   !> Find particles that are out of bounds or have failed, and remove them if the deck says so. The
   !! remaining particles limit the next step.
   subroutine judge_particles(simulation, scratch, index, tile, fastest, steepest)
      type(simulation_t), intent(inout) :: simulation
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      integer, intent(in) :: index                   !! Index of the material and of its store
      integer, intent(in) :: tile
      real(wp), intent(inout) :: fastest             !! Fastest signal and motion of tile [m/s]
      real(wp), intent(in) :: steepest               !! Square of |grad v|, tile excluded [1/s2]
      logical :: sound

      associate (store => simulation%stores(index))
         sound = count_bad(store, tile, simulation%materials(index)%density, &
            tile_bounds(simulation%materials, simulation%clock, index)) < 0.5_wp
         if (.not. sound .and. simulation%clock%guard%bounds%retire) then
            call retire_tile(simulation%materials, simulation%stores, simulation%clock, scratch, &
               index, tile, sound)
            scratch%retired = .true.
         end if
         scratch%sound = scratch%sound .and. sound
         if (simulation%scheme%erosion .and. allocated(store%state%failed)) &
            call erode_tile(simulation%materials, simulation%stores, scratch, index, tile)
         if (.not. (simulation%scheme%erosion .or. simulation%clock%guard%bounds%retire)) return
         if (.not. any(store%home(store%first(tile):store%first(tile) + store%count(tile) - 1) &
            == moved_off)) return
         if (fastest > 0.0_wp) fastest = fastest_left(store, tile, scratch%deformation%wave_speed)
         scratch%steepest = steepest
      end associate
   end subroutine judge_particles

   !> Heat from the kinetic energy that the transfers to the nodes and back lose.
   subroutine add_heat(space, scheme, scratch, store, tile, view)
      type(space_t), intent(in) :: space
      type(scheme_t), intent(in) :: scheme
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      type(store_t), intent(inout) :: store
      integer, intent(in) :: tile
      type(view_t), intent(in) :: view               !! Node fields
      integer :: p, k

      associate (grid => space%grid, method => scheme%method, shape => scratch%shape, &
         start => store%cell_start(:, tile), first => store%first(tile))
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

   !> Volumes of the loose particles of a tile from the fill of the nodes.
   subroutine repack_particles(simulation, scratch, index, tile, view)
      type(simulation_t), intent(inout) :: simulation
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread, particles located
      integer, intent(in) :: index                   !! Index of the material and of its store
      integer, intent(in) :: tile
      type(view_t), intent(in) :: view               !! Node fields

      associate (store => simulation%stores(index))
         call simulation%scheme%method%basis%gather_values(simulation%space%grid, scratch%shape, &
            view%excess, &
            scratch%shape%values)
         call correct_volumes(store, tile, simulation%materials(index), scratch%shape%values, &
            scratch%ledger)
      end associate
   end subroutine repack_particles

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

      associate (grid => simulation%space%grid, method => simulation%scheme%method, shape => &
         scratch%shape, &
         store => simulation%stores(index), start => simulation%stores(index)%cell_start(:, tile), &
         first => simulation%stores(index)%first(tile))
         if (view%at_once) then
            call view%increments%move(shape, first, dt, store%velocity, store%position)
         else
            call method%basis%gather_motion(grid, shape, first, view%push, view%carry, &
               method%transfer%flip_fraction(), dt, store%velocity, store%position)
            if (other%slot > 0) then
               call add_values(simulation, field, shape, index, tile, 1.0_wp, view%push, &
                  other%push, first - 1, store%velocity)
               call add_values(simulation, field, shape, index, tile, dt, view%carry, &
                  other%carry, first - 1, store%position)
            end if
         end if
         if (allocated(simulation%space%cell)) call carry_particles(simulation, scratch, store, &
            tile, view, dt)
         if (damps(method, simulation%scheme%carries_energy)) then
            if (view%at_once) then
               call view%increments%find_way(shape)
            else
               call method%basis%gather_values(grid, shape, view%carry, shape%vector)
            end if
            call record_damping(scratch%ledger, store, tile, shape%vector, &
               method%transfer%flip_fraction())
         end if
         if (.not. method%transfer%affine() .or. strained(simulation, index)) return
         call find_slopes(simulation, shape, view%after, view%gradient, &
            scratch%deformation%gradient)
         if (other%slot > 0) call add_gradient(simulation, field, scratch, index, tile, &
            other%after - view%after, 1.0_wp)
         call keep_affine(store, tile, 1.0_wp, scratch%deformation%gradient)
      end associate
   end subroutine move_particles

   !> Positions on the mesh of a cell that deforms.
   subroutine carry_particles(simulation, scratch, store, tile, view, dt)
      type(simulation_t), intent(in) :: simulation
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      type(store_t), intent(inout) :: store
      integer, intent(in) :: tile
      type(view_t), intent(in) :: view               !! Node fields
      real(wp), intent(in) :: dt                     !! Time step [s]

      associate (shape => scratch%shape)
         if (view%at_once) then
            call view%increments%find_way(shape)
         else
            call simulation%scheme%method%basis%gather_values(simulation%space%grid, shape, &
               view%carry, shape%vector)
         end if
         call simulation%space%cell%carry(store%first(tile), store%count(tile), dt, shape%vector, &
            store%position)
      end associate
   end subroutine carry_particles

   !> Do linear velocity fields come from the strain of the step? The modified gradient is less
   !! noisy than that of the cell, and after the step it is the gradient of the new velocities. With
   !! normalised sums it is not used: there the modified gradient of a linear field is not uniform.
   pure logical function strained(simulation, index) result(renewed)
      type(simulation_t), intent(in) :: simulation
      integer, intent(in) :: index                   !! Index of the material and of its store

      renewed = simulation%scheme%method%dual .and. simulation%scheme%method%stress /= stress_before
      if (renewed .and. allocated(simulation%scheme%normalises)) &
         renewed = .not. simulation%scheme%normalises(index)
   end function strained

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
   subroutine find_gradient(simulation, scratch, store, tile, velocity, gradient, dt, works)
      type(simulation_t), intent(in) :: simulation
      type(scratch_t), intent(inout) :: scratch      !! Gets the gradient
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile
      real(wp), contiguous, intent(in) :: velocity(:, :)   !! (3, node) [m/s]
      real(wp), allocatable, intent(in) :: gradient(:, :)  !! (9, node) Node gradient, if dual [1/s]
      real(wp), intent(in) :: dt                     !! Time step [s]
      logical, intent(in) :: works                   !! For the work of the stress, not the strain?

      associate (grid => simulation%space%grid, method => simulation%scheme%method, shape => &
         scratch%shape, &
         start => store%cell_start(:, tile))
         if (method%dual) then
            call method%quadrature%gather_gradient(grid, shape, velocity, gradient, dt, &
               scratch%deformation%gradient)
         else
            call method%basis%gather_gradient(grid, shape, velocity, dt, &
               scratch%deformation%gradient)
         end if
         if (grid%axisymmetric) call method%basis%gather_hoop(grid, shape, store%first(tile), &
            store%position, velocity, dt, scratch%deformation%gradient)
         if (allocated(simulation%space%cell)) then
            if (works) then
               call simulation%space%cell%place_work(store%count(tile), dt, &
                  scratch%deformation%gradient)
            else
               call simulation%space%cell%place_strain(store%count(tile), &
                  scratch%deformation%gradient)
            end if
         end if
         if (method%even) call average_dilatation(grid, start, store%first(tile), &
            store%state%volume, scratch%deformation%gradient)
      end associate
   end subroutine find_gradient

   !> Add the difference between the sides of nodes to a velocity gradient times the time step.
   subroutine add_gradient(simulation, field, scratch, index, tile, difference, dt)
      type(simulation_t), intent(in) :: simulation
      type(velocity_field_t), intent(in) :: field    !! Field with two sides
      type(scratch_t), intent(inout) :: scratch !! Scratch memory of this thread, with the gradient
      integer, intent(in) :: index                   !! Index of the material and of its store
      integer, intent(in) :: tile
      real(wp), intent(in) :: difference(:, :)       !! (3, node) Difference of the velocities [m/s]
      real(wp), intent(in) :: dt                     !! Time step [s]

      if (.not. field%sides%cut(tile)) return
      associate (store => simulation%stores(index))
         call add_other_gradient(simulation%space%grid, scratch%shape, store, tile, &
            field%sides%store(index - field%sides%before)%other, field%sides%split(:, tile), dt, &
            difference, scratch%deformation%gradient)
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

      call find_gradient(simulation, scratch, simulation%stores(index), tile, &
         field%nodes%motion%strain(:, :, view%slot), view%gradient, dt, .false.)
      if (field%other > 0) call add_gradient(simulation, field, scratch, index, tile, &
         simulation%fields(field%other)%nodes%motion%strain(:, :, tile) &
         - field%nodes%motion%strain(:, :, tile), dt)
   end subroutine find_strain

   !> Add the difference between the sides of nodes to values of the particles of a tile.
   ! gate: long kernel because the node fields of both sides are arguments of their own
   subroutine add_values(simulation, field, shape, index, tile, factor, mine, theirs, before, &
      values)
      type(simulation_t), intent(in) :: simulation
      type(velocity_field_t), intent(in) :: field    !! Field with two sides
      type(shape_data_t), intent(in) :: shape        !! Shape data of the tile
      integer, intent(in) :: index                   !! Index of the material and of its store
      integer, intent(in) :: tile
      real(wp), intent(in) :: factor                 !! Such as the step [s]
      real(wp), intent(in) :: mine(:, :)             !! (column, node) Values of the first side
      real(wp), intent(in) :: theirs(:, :)           !! (column, node) Values of the other side
      integer, intent(in) :: before                  !! Rows of the values before the tile
      real(wp), intent(inout) :: values(:, :)        !! (particle, column)

      call add_other_values(simulation%space%grid, shape, simulation%stores(index)%first(tile), &
         field%sides%store(index - field%sides%before)%other, field%sides%split(:, tile), factor, &
         mine, theirs, before, values)
   end subroutine add_values

   !> Strain the particles of a tile and update the stress of their material.
   subroutine strain_particles(simulation, field, scratch, index, tile, view, dt, fastest)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(inout) :: field
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      integer, intent(in) :: index                   !! Index of the material and of its store
      integer, intent(in) :: tile
      type(view_t), intent(in) :: view               !! Node fields
      real(wp), intent(in) :: dt                     !! Time of the strain [s]
      real(wp), intent(out) :: fastest               !! Fastest signal and motion [m/s]
      integer :: p, first, n

      first = simulation%stores(index)%first(tile)
      n = simulation%stores(index)%count(tile)
      associate (store => simulation%stores(index), deformation => scratch%deformation, &
         method => simulation%scheme%method)
         deformation%plane = simulation%space%grid%dimensions < 3
         if (method%averages()) then
            call find_gradient(simulation, scratch, store, tile, &
               field%nodes%motion%velocity(:, :, view%slot), view%earlier, simulation%clock%dt, &
               .false.)
            call centre_backward(n, deformation%plane, deformation%gradient)
            call keep_earlier(n, deformation%gradient, scratch%earlier)
         end if
         call find_strain(simulation, field, scratch, index, tile, view, dt)
         if (.not. view%slow) call find_steepest(deformation%gradient, &
            store%identity(first:first + n - 1), dt, view%matters, scratch%steepest, &
            scratch%steepest_identity)
         if (method%transfer%affine() .and. strained(simulation, index) .and. .not. view%moved) &
            call keep_affine(store, tile, 1.0_wp/dt, deformation%gradient)
         call stretch_tile(store, tile, deformation%gradient)
         if (allocated(store%opening)) call find_opening(method%splitting, &
            simulation%space%grid%spacing, store, tile, deformation%gradient, dt)
         if (view%moved .and. method%leapfrog) then
            call centre_backward(n, deformation%plane, deformation%gradient)
         else
            call centre_gradient(n, deformation%plane, deformation%gradient)
         end if
         if (method%averages()) call average_strain(store, tile, scratch%earlier, &
            deformation%gradient)
         if (method%limited) call find_jump(simulation%space%grid, store%cell_start(:, tile), &
            field%nodes%motion%strain(:, :, view%slot), view%gradient, deformation%gradient, &
            deformation%jump)
         if (normalised(simulation, index)) call limit_compression(simulation%space%grid, &
            store%cell_start(:, tile), field%nodes%motion%strain(:, :, view%slot), dt, &
            deformation%gradient, deformation%jump)
         call scratch%laps%update(simulation%materials(index), store%state, deformation, &
            first, first + n - 1, dt, simulation%space%grid%spacing)
         call relax_pressures(simulation, field, index, tile, scratch%shape%local, &
            deformation%wave_speed, dt)
         fastest = 0.0_wp
         do p = 1, n
            fastest = max(fastest, &
            deformation%wave_speed(p) + sqrt(store%velocity(first + p - 1, 1)**2 &
               + store%velocity(first + p - 1, 2)**2 + store%velocity(first + p - 1, 3)**2))
         end do
         call record_losses(scratch%ledger, simulation%materials(index), store%state, &
            deformation, n)
      end associate
   end subroutine strain_particles
end module step_nodes_to_particles
