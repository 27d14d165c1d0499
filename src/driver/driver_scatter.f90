! SPDX-License-Identifier: BSD-3-Clause
!> Particles to patches, tile by tile.
module driver_scatter
   use base_kinds, only: wp
   use ddmp_alpha, only: find_alpha
   use driver_simulation, only: scratch_t, simulation_t
   use mesh_halo, only: exchange_patches
   use mesh_patch, only: ensure_patch
   use omp_lib, only: omp_get_thread_num
   use particle_store, only: store_t
   use transfer_gather, only: gather_local, locate
   use transfer_scatter, only: dual_columns, motion_columns, scatter_dual_force, scatter_force, &
      scatter_hoop, scatter_motion, scatter_product
   implicit none
   private

   public :: find_local, scatter_particles, scatter_second

   integer, parameter :: force_before = 4            !! Columns of a patch before the force

contains

   !> Mass, momentum and force of all particles to the patches of their tiles, and the patches of
   !! other ranks.
   subroutine scatter_particles(simulation)
      type(simulation_t), intent(inout) :: simulation !! The run
      integer :: tile

      call simulation%timer%start(simulation%phase%scatter)
      call ensure_patch(simulation%nodes%motion, merge(dual_columns, motion_columns, &
         simulation%method%dual), simulation%grid%tile_nodes, simulation%tiles%own)
      !$omp parallel do default(none) shared(simulation) private(tile) schedule(dynamic, 1)
      do tile = 1, simulation%tiles%own
         call scatter_tile(simulation, simulation%scratch(omp_get_thread_num()), tile, &
            simulation%nodes%motion(:, :, tile))
      end do
      !$omp end parallel do
      call simulation%timer%stop(simulation%phase%scatter)
      call simulation%timer%start(simulation%phase%exchange)
      call exchange_patches(simulation%communicator, simulation%grid, simulation%tiles, &
         simulation%nodes%motion)
      call simulation%timer%stop(simulation%phase%exchange)
   end subroutine scatter_particles

   !> One tile.
   subroutine scatter_tile(simulation, scratch, tile, patch)
      type(simulation_t), intent(in) :: simulation   !! The run
      type(scratch_t), intent(inout) :: scratch      !! Of this thread
      integer, intent(in) :: tile                    !! Which tile
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (column, node)
      integer :: index

      patch = 0.0_wp
      do index = 1, size(simulation%stores)
         if (simulation%stores(index)%count(tile) == 0) cycle
         associate (grid => simulation%grid, store => simulation%stores(index), &
            method => simulation%method)
            call find_local(simulation, scratch, store, tile)
            call scatter_motion(grid, store%cell_start(:, tile), store%first(tile), scratch%local, &
               store%matter%mass, store%velocity, patch)
            if (method%dual) then
               call scatter_dual_force(grid, store%cell_start(:, tile), store%first(tile), &
                  scratch%local, scratch%alpha, store%matter%volume, store%matter%stress, patch)
            else
               call scatter_force(grid, store%cell_start(:, tile), store%first(tile), &
                  scratch%local, store%matter%volume, store%matter%stress, patch)
            end if
            if (grid%axisymmetric) call scatter_hoop(grid, store%cell_start(:, tile), &
               store%first(tile), scratch%local, store%position, store%matter%volume, &
               store%matter%stress, patch)
            if (allocated(simulation%exact)) call add_body_force(simulation, scratch, index, tile, &
               patch)
         end associate
      end do
   end subroutine scatter_tile

   !> Body force of an exact solution, to columns 5 to 7.
   subroutine add_body_force(simulation, scratch, index, tile, patch)
      type(simulation_t), intent(in) :: simulation   !! The run with a solution
      type(scratch_t), intent(inout) :: scratch      !! Of this thread, particles located
      integer, intent(in) :: index                   !! Which material
      integer, intent(in) :: tile                    !! Which tile
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (column, node)
      real(wp) :: point(3), force(3)
      integer :: p, q, k

      if (.not. allocated(simulation%exact%material(index)%solution)) return
      associate (store => simulation%stores(index), &
         solution => simulation%exact%material(index)%solution)
         if (.not. solution%forced()) return
         do p = 1, store%count(tile)
            q = store%first(tile) + p - 1
            do k = 1, 3
               point(k) = store%reference(q, k)
            end do
            call solution%body_force(point, simulation%exact%force_time, force)
            do k = 1, 3
               scratch%vector(p, k) = force(k)
            end do
         end do
         call scatter_product(simulation%grid, store%cell_start(:, tile), store%first(tile), &
            scratch%local, store%matter%mass, scratch%vector, patch, before=force_before)
      end associate
   end subroutine add_body_force

   !> Momentum of the particles to a second patch: that of the present particle velocities, or of
   !! the node velocities seen by the particles.
   subroutine scatter_second(simulation, from_nodes)
      type(simulation_t), intent(inout) :: simulation !! The run
      logical, intent(in) :: from_nodes              !! Node velocities instead of particle ones?
      integer :: tile

      call simulation%timer%start(simulation%phase%scatter)
      call ensure_patch(simulation%nodes%extra, 3, simulation%grid%tile_nodes, &
         simulation%tiles%own)
      !$omp parallel do default(none) shared(simulation, from_nodes) private(tile) &
      !$omp schedule(dynamic, 1)
      do tile = 1, simulation%tiles%own
         call scatter_second_tile(simulation, simulation%scratch(omp_get_thread_num()), tile, &
            from_nodes, simulation%nodes%extra(:, :, tile))
      end do
      !$omp end parallel do
      call simulation%timer%stop(simulation%phase%scatter)
      call simulation%timer%start(simulation%phase%exchange)
      call exchange_patches(simulation%communicator, simulation%grid, simulation%tiles, &
         simulation%nodes%extra)
      call simulation%timer%stop(simulation%phase%exchange)
   end subroutine scatter_second

   !> One tile of the second mapping.
   subroutine scatter_second_tile(simulation, scratch, tile, from_nodes, patch)
      type(simulation_t), intent(in) :: simulation   !! The run
      type(scratch_t), intent(inout) :: scratch      !! Of this thread
      integer, intent(in) :: tile                    !! Which tile
      logical, intent(in) :: from_nodes              !! Node velocities instead of particle ones?
      real(wp), contiguous, intent(inout) :: patch(:, :) !! (node, 3)
      integer :: index, first, n

      patch = 0.0_wp
      do index = 1, size(simulation%stores)
         n = simulation%stores(index)%count(tile)
         if (n == 0) cycle
         associate (grid => simulation%grid, store => simulation%stores(index))
            first = store%first(tile)
            call find_local(simulation, scratch, store, tile)
            if (from_nodes) then
               call gather_local(grid, store%cell_start(:, tile), scratch%local, &
                  simulation%nodes%velocity(:, :, tile), scratch%vector)
            else
               scratch%vector(:n, :) = store%velocity(first:first + n - 1, :)
            end if
            call scatter_product(grid, store%cell_start(:, tile), first, scratch%local, &
               store%matter%mass, scratch%vector, patch)
         end associate
      end do
   end subroutine scatter_second_tile

   !> Places in the cells, and alpha, of the particles of a tile.
   subroutine find_local(simulation, scratch, store, tile)
      type(simulation_t), intent(in) :: simulation   !! The run
      type(scratch_t), intent(inout) :: scratch      !! Of this thread
      type(store_t), intent(in) :: store             !! The particles
      integer, intent(in) :: tile                    !! Which tile
      integer :: n

      n = store%count(tile)
      if (allocated(scratch%local)) then
         if (size(scratch%local, 1) < n) deallocate (scratch%local, scratch%alpha, scratch%vector)
      end if
      if (.not. allocated(scratch%local)) &
         allocate (scratch%local(n + n/4, 3), scratch%alpha(n + n/4, 3), scratch%vector(n + n/4, 3))
      call locate(simulation%grid, store%first(tile), n, store%position, scratch%local)
      if (simulation%method%dual) call find_alpha(simulation%grid, simulation%method%alpha, &
         simulation%method%alpha_centre, n, scratch%local, scratch%alpha)
   end subroutine find_local
end module driver_scatter
