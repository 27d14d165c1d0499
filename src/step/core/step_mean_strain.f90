! SPDX-License-Identifier: BSD-3-Clause
!> The strain that belongs to the force with a mean stress of the nodes (`quadrature = 'control'`):
!! from the gradient at the particles their mean on the nodes is subtracted as far as it differs
!! from the exact one of the grid. With it the power of the force is that of the stress for any
!! positions of the particles, and the volumes of the particles in full cells change by the integral
!! of the divergence. Equation (Q.4) of doc/theory/quadratures.md.
module step_mean_strain
   use base_kinds, only: wp
   use mesh_patch, only: clear_patch, ensure_patch
   use omp_lib, only: omp_get_thread_num
   use step_exchange, only: edge_tiles, inner_tiles, next_tiles, send_patches
   use step_node_fields, only: gradient_rows
   use step_node_view, only: gather_parts_t, set_view, view_t
   use step_particles_to_nodes, only: locate_particles
   use step_simulation, only: scratch_t, simulation_t, velocity_field_t
   use step_strain_particles, only: gather_rate
   use step_tile_cost, only: start_cost, stop_cost
   use transfer_shape_data, only: spare
   implicit none
   private

   public :: find_mean_strain

contains

   !> Sums over the particles of the gradients of the velocities that strain them and, if materials
   !! carry internal energy, do work.
   subroutine find_mean_strain(simulation, field, parts)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(inout) :: field
      type(gather_parts_t), intent(in) :: parts      !! Parts of the transfer that follows
      integer, allocatable :: tiles(:)
      integer :: part

      associate (space => simulation%space, machine => simulation%machine, &
         stress => field%nodes%stress)
         call machine%timer%start(machine%phase%scatter)
         call ensure_patch(stress%strain, size(gradient_rows(space%grid)) &
            *simulation%scheme%gradients(), space%grid%tile_nodes, space%tiles%own)
         do part = edge_tiles, inner_tiles
            call next_tiles(space, machine%communicator, part, tiles)
            !$omp parallel default(none) shared(simulation, field, parts, tiles)
            call scatter_some(simulation, field, parts, tiles)
            !$omp end parallel
            call send_patches(space, machine, part, stress%strain, 0)
         end do
         call machine%timer%stop(machine%phase%scatter)
      end associate
   end subroutine find_mean_strain

   !> The tiles of one thread.
   subroutine scatter_some(simulation, field, parts, tiles)
      type(simulation_t), intent(inout) :: simulation
      type(velocity_field_t), intent(inout) :: field
      type(gather_parts_t), intent(in) :: parts      !! Parts of the transfer that follows
      integer, intent(in) :: tiles(:)
      type(view_t) :: view
      integer :: n

      associate (scratch => simulation%scratch(omp_get_thread_num()))
         !$omp do schedule(dynamic, 1)
         do n = 1, size(tiles)
            call start_cost(simulation%machine, tiles(n))
            call set_view(simulation%space, simulation%stores, simulation%scheme, &
               simulation%clock, field%nodes, tiles(n), &
               gather_parts_t(work=parts%work, strain=parts%strain, plain=.true.), view)
            call scatter_tile(simulation, field, scratch, tiles(n), parts, view, &
               field%nodes%stress%strain(:, :, tiles(n)))
            call stop_cost(simulation%machine, tiles(n))
         end do
         !$omp end do
      end associate
   end subroutine scatter_some

   !> One tile.
   subroutine scatter_tile(simulation, field, scratch, tile, parts, view, patch)
      type(simulation_t), intent(in) :: simulation
      type(velocity_field_t), intent(in) :: field
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread
      integer, intent(in) :: tile
      type(gather_parts_t), intent(in) :: parts      !! Parts of the transfer that follows
      type(view_t), intent(in) :: view               !! Node fields
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (column, node)
      integer :: index, number

      call clear_patch(patch)
      number = size(patch, 1)/simulation%scheme%gradients()
      associate (motion => field%nodes%motion, scheme => simulation%scheme)
         do index = field%first_store, field%last_store
            if (simulation%stores(index)%count(tile) == 0) cycle
            call locate_particles(simulation%space, scheme, field, scratch, &
               simulation%stores(index), tile)
            call scratch%deformation%reserve(simulation%stores(index)%count(tile) + spare)
            if (parts%strain) call scatter_gradient(simulation, scratch, index, tile, &
               motion%strain(:, :, view%slot), view%gradient, 0, patch)
            if (parts%strain .and. scheme%method%averages()) call scatter_gradient(simulation, &
               scratch, index, tile, motion%velocity(:, :, view%slot), view%gradient_before, &
               number, patch)
            if (scheme%works .and. parts%work) call scatter_gradient(simulation, scratch, index, &
               tile, view%middle_velocity, view%middle_gradient, size(patch, 1) - number, patch)
         end do
      end associate
   end subroutine scatter_tile

   !> The gradient of one velocity times the volume of the particles.
   subroutine scatter_gradient(simulation, scratch, index, tile, velocity, gradient, before, patch)
      type(simulation_t), intent(in) :: simulation
      type(scratch_t), intent(inout) :: scratch      !! Private to this thread, particles located
      integer, intent(in) :: index                   !! Index of the material and of its store
      integer, intent(in) :: tile
      real(wp), contiguous, intent(in) :: velocity(:, :)   !! (3, node) [m/s]
      real(wp), allocatable, intent(in) :: gradient(:, :)  !! (9, node) Node gradient [1/s]
      integer, intent(in) :: before                  !! Columns before those of the gradient
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (column, node)
      real(wp) :: weight
      integer, allocatable :: rows(:)
      integer :: p, k

      associate (space => simulation%space, method => simulation%scheme%method, &
         shape => scratch%shape, store => simulation%stores(index))
         call gather_rate(space%grid, method, scratch, store, tile, velocity, gradient, 1.0_wp)
         weight = 1.0_wp
         if (allocated(space%cell)) weight = 1.0_wp/space%cell%stretch%volume
         allocate (rows, source=gradient_rows(space%grid))
         do k = 1, size(rows)
            do p = 1, store%count(tile)
               shape%values(p, k) = weight*store%state%volume(store%first(tile) + p - 1) &
                  *scratch%deformation%gradient(p, rows(k))
            end do
         end do
         call method%basis%scatter_values(space%grid, shape, size(rows), shape%values, before, &
            patch)
      end associate
   end subroutine scatter_gradient
end module step_mean_strain
