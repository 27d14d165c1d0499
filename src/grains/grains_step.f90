! SPDX-License-Identifier: BSD-3-Clause
!> One time step of a cell of grains: velocity Verlet with velocities relative to the cell,
!! m du/dt = F - m L u (D. J. Evans, G. P. Morriss, Statistical Mechanics of Nonequilibrium Liquids,
!! 2008, section 6.3), which is exact for a cell that follows the gradient L.
!!
!! Equations of doc/theory/grains.md.
module grains_step
   use base_kinds, only: int64, wp
   use base_matrix, only: inverse
   use base_sort, only: sort_order
   use grains_cell, only: cell_t, losses
   use grains_discs, only: push_discs, sum_discs
   use grains_exchange, only: exchange_grains, gather_rows, link_halo, own_rows, total_of
   use grains_histories, only: collect_records, drop_parted, give_records, share_records
   use grains_motion, only: finish_velocities, move_grains, start_velocities
   use grains_neighbours, only: find_pairs
   use grains_pairs, only: dashpot_loss
   use grains_spheres, only: push_spheres, sum_spheres
   use grains_state, only: block_rows
   use mesh_hilbert, only: hilbert_key
   implicit none
   private

   public :: advance_cell, renew_pairs, servo_gradient, start_grains_cell

   real(wp), parameter :: sort_strain = 0.5_wp       !! Shear strain between two sorts of rows
   integer, parameter :: curve_cells = 1024          !! Cells of the curve along an edge

contains

   !> Find the pairs and the forces of the first state. The elastic energy of springs does not count
   !! as lost.
   subroutine start_grains_cell(cell)
      type(cell_t), intent(inout) :: cell
      real(wp) :: dt

      dt = cell%dt
      cell%dt = 0.0_wp
      call renew_pairs(cell)
      call find_forces(cell)
      cell%pairs%history(dashpot_loss:dashpot_loss + losses - 1, :) = 0.0_wp
      call end_velocities(cell)
      cell%dt = dt
      call servo_gradient(cell)
   end subroutine start_grains_cell

   !> Advance by a time step.
   subroutine advance_cell(cell)
      type(cell_t), intent(inout) :: cell
      real(wp) :: mean_dual(3, 3), steps(3, 3), power, travel
      logical :: renew

      power = working(cell)
      call start_velocities(cell%grains, cell%box%gradient, cell%dt)
      call cell%box%advance(cell%dt, mean_dual)
      call move_grains(cell%grains, cell%box%edges, cell%reference%place, mean_dual, cell%dt, &
         travel)
      call cell%box%reduce(steps)
      renew = any(abs(steps) > 0.0_wp)
      if (renew) call shift_places(steps, cell)
      if (.not. renew) renew = cell%communicator%maximum(travel) > reach_left(cell)
      cell%time = cell%time + cell%dt
      cell%step = cell%step + 1
      if (renew) then
         call renew_pairs(cell)
      else
         call exchange_grains(cell%communicator, cell%halo, cell%grains)
      end if
      call find_forces(cell)
      call end_velocities(cell)
      cell%work = cell%work + 0.5_wp*cell%dt*(power + working(cell))
      cell%mean%time = cell%mean%time + cell%dt
      cell%mean%contact = cell%mean%contact + cell%dt*cell%contact
      cell%mean%kinetic = cell%mean%kinetic + cell%dt*cell%kinetic
      call servo_gradient(cell)
   end subroutine advance_cell

   !> Power of the stress on the cell, V stress : gradient [W].
   pure real(wp) function working(cell) result(power)
      type(cell_t), intent(in) :: cell

      power = -sum(reshape(cell%contact + cell%kinetic, [3, 3])*cell%box%gradient)
   end function working

   !> Displacement of a grain that requires a new neighbour search: half of the skin less the effect
   !! of the deformation of the cell [m].
   pure real(wp) function reach_left(cell) result(left)
      type(cell_t), intent(in) :: cell
      real(wp) :: change(3, 3), dual(3, 3), reach
      integer :: axis

      dual = inverse(cell%reference%edges)
      change = matmul(cell%box%edges, dual)
      do axis = 1, 3
         change(axis, axis) = change(axis, axis) - 1.0_wp
      end do
      reach = 2.0_wp*maxval(cell%grains%radius) + cell%skin
      left = 0.5_wp*(cell%skin - sqrt(sum(change**2))*reach)
   end function reach_left

   !> Adapt the coordinates of grains to edges that were replaced by equivalent ones.
   subroutine shift_places(steps, cell)
      real(wp), intent(in) :: steps(3, 3)            !! From `reduce` of the box
      type(cell_t), intent(inout) :: cell
      integer :: row, lower, upper

      do upper = cell%box%dimension, 2, -1
         do lower = upper - 1, 1, -1
            if (.not. abs(steps(lower, upper)) > 0.0_wp) cycle
            do row = cell%grains%first, cell%grains%last
               cell%grains%place(lower, row) = cell%grains%place(lower, row) &
                  + steps(lower, upper)*cell%grains%place(upper, row)
            end do
         end do
      end do
   end subroutine shift_places

   !> Repeat the neighbour search and keep the histories of contacts. Collective.
   subroutine renew_pairs(cell)
      type(cell_t), intent(inout) :: cell
      real(wp), allocatable :: records(:, :)
      logical :: sorts

      associate (grains => cell%grains, communicator => cell%communicator)
         call gather_rows(communicator, grains%first, grains%last, grains%place)
         grains%place = grains%place - floor(grains%place)
         where (grains%place >= 1.0_wp) grains%place = 0.0_wp
         sorts = cell%reference%sorted < 0.0_wp .or. &
            cell%box%strain - cell%reference%sorted > sort_strain
         if (allocated(cell%pairs%first)) then
            call drop_parted(grains, cell%pairs, cell%lost)
            call collect_records(grains, cell%pairs, sorts, records)
            if (sorts) call share_records(communicator, records)
         end if
         if (sorts) call sort_rows(cell)
         call find_pairs(grains, cell%box, cell%skin, cell%pairs)
         if (allocated(records)) call give_records(grains, records, cell%pairs)
         call link_halo(communicator, grains, cell%pairs, cell%halo)
         call grains%locate(cell%box, 1, grains%count)
         call exchange_grains(communicator, cell%halo, grains)
      end associate
      cell%reference%place = cell%grains%place
      cell%reference%edges = cell%box%edges
      cell%searches = cell%searches + 1
   end subroutine renew_pairs

   !> Sort the rows along a space-filling curve, and distribute them over the ranks. Collective.
   subroutine sort_rows(cell)
      type(cell_t), intent(inout) :: cell            !! Coordinates of all rows are known
      integer(int64), allocatable :: key(:)
      integer, allocatable :: order(:)
      integer :: row, bin(3), first, last

      cell%reference%sorted = cell%box%strain
      associate (grains => cell%grains)
         first = grains%first
         last = grains%last
         call gather_rows(cell%communicator, first, last, grains%velocity)
         call gather_rows(cell%communicator, first, last, grains%spin)
         call gather_rows(cell%communicator, first, last, grains%force)
         allocate (key(grains%count))
         do row = 1, grains%count
            bin = int(grains%place(:, row)*real(curve_cells, wp))
            key(row) = (hilbert_key(bin, 3))*(grains%count + 1_int64) + grains%identity(row)
         end do
         order = sort_order(key)
         grains%identity = grains%identity(order)
         grains%radius = grains%radius(order)
         grains%mass = grains%mass(order)
         grains%inertia = grains%inertia(order)
         grains%place = grains%place(:, order)
         grains%velocity = grains%velocity(:, order)
         grains%spin = grains%spin(:, order)
         grains%force = grains%force(:, order)
         call own_rows(cell%communicator, grains)
      end associate
   end subroutine sort_rows

   !> Forces of the pairs, their sums on the grains and in the stress.
   subroutine find_forces(cell)
      type(cell_t), intent(inout) :: cell
      real(wp), allocatable :: virial(:, :)

      allocate (virial(9, (cell%grains%last - cell%grains%first + block_rows)/block_rows))
      if (cell%box%dimension == 2) then
         call push_discs(cell%grains, cell%box, cell%law, cell%time, cell%dt, cell%pairs)
         call sum_discs(cell%pairs, cell%grains, virial)
      else
         call push_spheres(cell%grains, cell%box, cell%law, cell%time, cell%dt, cell%pairs)
         call sum_spheres(cell%pairs, cell%grains, virial)
      end if
      call total_of(cell%communicator, virial, cell%contact)
   end subroutine find_forces

   !> Second half of the change of the velocities, and the sums of m u u.
   subroutine end_velocities(cell)
      type(cell_t), intent(inout) :: cell
      real(wp), allocatable :: squares(:, :)
      real(wp) :: sums(6)

      allocate (squares(6, (cell%grains%last - cell%grains%first + block_rows)/block_rows))
      call finish_velocities(cell%grains, cell%box%gradient, cell%dt, squares)
      call total_of(cell%communicator, squares, sums)
      cell%kinetic = sums([1, 4, 5, 4, 2, 6, 5, 6, 3])
   end subroutine end_velocities

   !> Velocity gradient of the next step: the given one, and on stress-controlled axes the rate that
   !! brings the stress to its target.
   pure subroutine servo_gradient(cell)
      type(cell_t), intent(inout) :: cell

      call cell%drive%steer(cell%stress(cell%contact, cell%kinetic), cell%box)
   end subroutine servo_gradient
end module grains_step
