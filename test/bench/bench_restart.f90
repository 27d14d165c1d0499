! SPDX-License-Identifier: BSD-3-Clause
!> Measures time and memory of a restart with many particles, without a material model.
!!
!! bench_restart write FOLDER TILES    writes a checkpoint of a cube with TILES tiles along an edge
!! bench_restart read FOLDER TILES     reads it, counts the tiles, and cuts the curve
!!
!! A tile has 1728 particles, 39 tiles along an edge are 1.02e8. The particles have an identity, a
!! position, mass, volume, and one component of velocity and of stress, so that all data of 1.02e8
!! particles fit into the memory of one machine (64 bytes each).
program bench_restart
   use base_communicator, only: communicator_t
   use base_error, only: error_t
   use base_kinds, only: int64, wp
   use base_process, only: peak_memory, private_memory
   use base_sort, only: sort_order
   use base_timer, only: wall_seconds
   use io_checkpoint, only: checkpoint_place_t, checkpoint_write
   use io_hdf5_write, only: even_rows, rows_t
   use io_restart, only: checkpoint_read
   use io_state, only: state_t
   use mesh_hilbert, only: hilbert_coordinate, hilbert_key
   use mesh_tiles, only: partition_scattered_keys
   use particle_store, only: traits_t
   use scene_particles, only: count_tiles, prepare_simulation
   use step_simulation, only: simulation_t
   implicit none

   integer, parameter :: edge = 12, particles_of_tile = edge**3
   type(simulation_t) :: simulation
   type(checkpoint_place_t) :: place
   type(state_t) :: state
   type(error_t), allocatable :: error
   character(len=512) :: action, folder, word
   integer :: tiles
   real(wp) :: begin

   call get_command_argument(1, action)
   call get_command_argument(2, folder)
   call get_command_argument(3, word)
   read (word, *) tiles
   call simulation%machine%communicator%start()
   begin = wall_seconds()
   simulation%space%grid%spacing = 1.0_wp
   simulation%space%grid%upper = 6.0_wp*tiles
   call simulation%space%grid%start(0)
   allocate (simulation%materials(0))
   call prepare_simulation(simulation)
   allocate (simulation%stores(1))
   call simulation%stores(1)%start("m", simulation%space%grid%tile_cells, traits_t())
   deallocate (simulation%stores(1)%velocity)
   allocate (simulation%stores(1)%velocity(0, 1))
   associate (matter => simulation%stores(1)%state)
      allocate (matter%mass(0), matter%volume(0), matter%stress(0, 1))
   end associate
   place%folder = trim(folder)
   place%case = "synthetic"
   call report("started")
   if (action == "write") then
      call make_particles(simulation)
      call report("made")
      call checkpoint_write(simulation%machine%communicator, place, simulation%stores, state, error)
      call report("written")
   else
      call checkpoint_read(simulation%machine%communicator, place%path(), simulation%stores, &
         state, error)
      call report("read")
      if (.not. allocated(error)) call cut_curve(simulation)
   end if
   if (allocated(error)) print "(a)", error%message
   call simulation%machine%communicator%finish()
   if (allocated(error)) error stop 1

contains

   !> Print the time so far, and the greatest memory of a rank.
   subroutine report(done)
      character(len=*), intent(in) :: done            !! What was done
      real(wp), parameter :: mega = 1.0e-6_wp
      real(wp) :: seconds, peak, now

      associate (communicator => simulation%machine%communicator)
         seconds = communicator%maximum(wall_seconds() - begin)
         peak = communicator%maximum(mega*real(peak_memory(), wp))
         now = communicator%maximum(mega*real(private_memory(), wp))
         if (communicator%rank == 0) print "(a,t12,f8.1,a,2(f10.1,a))", done, seconds, " s", peak, &
            " MB peak", now, " MB private"
      end associate
   end subroutine report

   !> The particles of the tiles of this rank, in the order of files.
   subroutine make_particles(run)
      type(simulation_t), intent(inout) :: run        !! Gets the particles
      integer(int64), allocatable :: key(:)
      type(rows_t) :: rows
      integer :: n, x, y, z, tile, particle, origin(3)

      allocate (key(tiles**3))
      n = 0
      do z = 0, tiles - 1
         do y = 0, tiles - 1
            do x = 0, tiles - 1
               n = n + 1
               key(n) = hilbert_key([x, y, z], 3)
            end do
         end do
      end do
      key = key(sort_order(key))
      rows = even_rows(run%machine%communicator, int(tiles, int64)**3)
      associate (store => run%stores(1), first => int(rows%before(1)), own => int(rows%count(1)))
         deallocate (store%identity, store%position, store%velocity, store%first, store%count, &
            store%state%mass, store%state%volume, store%state%stress)
         n = particles_of_tile*own
         allocate (store%identity(n), store%position(n, 3), store%velocity(n, 1))
         allocate (store%state%mass(n), store%state%volume(n), source=0.125_wp)
         allocate (store%state%stress(n, 1), source=0.0_wp)
         store%velocity = 0.0_wp
         store%first = [1]
         store%count = [n]
         n = 0
         do tile = first + 1, first + own
            origin = edge*hilbert_coordinate(key(tile), 3)
            do particle = 0, particles_of_tile - 1
               n = n + 1
               store%identity(n) = int(tile - 1, int64)*particles_of_tile + particle + 1
               store%position(n, :) = 0.5_wp*(real(origin + [mod(particle, edge), &
                  mod(particle/edge, edge), particle/edge**2], wp) + 0.5_wp)
            end do
         end do
      end associate
   end subroutine make_particles

   !> Distribute the tiles over the ranks as a restart does.
   subroutine cut_curve(run)
      type(simulation_t), intent(inout) :: run        !! With particles, anywhere
      integer(int64), allocatable :: key(:), particles(:), border(:), rows(:, :), own(:)
      integer, allocatable :: owner(:)
      integer(int64) :: sums(3), longest(1)
      integer :: n

      call count_tiles(run, key, particles)
      call report("counted")
      associate (communicator => run%machine%communicator, grid_tiles => run%space%tiles)
         call partition_scattered_keys(communicator, key, particles, border)
         call grid_tiles%cut(border)
         call report("cut")
         rows = reshape(key, [1, size(key)])
         owner = [(grid_tiles%owner(key(n)), n=1, size(key))]
         call communicator%send_rows(owner, rows, own)
         sums = [sum(particles), size(key, kind=int64), int(size(own), int64)]
         longest = -size(key, kind=int64)
         call communicator%total(sums)
         call communicator%least(longest)
         call report("sent")
         if (communicator%rank == 0) print "(4(a,i0))", "particles ", sums(1), &
            ", tiles on lists ", sums(2), ", received ", sums(3), ", longest list ", -longest(1)
      end associate
   end subroutine cut_curve
end program bench_restart
