! SPDX-License-Identifier: BSD-3-Clause
!> Updates of particles that keep most of their own velocity: velocity increment, displacement, and
!! the kinetic energy that the transfers dissipate, from node fields that are gathered once.
!!
!! With velocity u and gain d = a dt of the nodes, the PIC fraction g and the fraction c of the gain
!! in the displacement, the columns are d + g u and u + c d along the active directions; then, for
!! material with an internal energy, d.d/2 + g (u.u + u.d) and the moments of g u - (1 - g) d about
!! the corner of the tile that linear velocity fields need. The velocity and the gain at a particle
!! follow from the first two, so g c must not be near 1. Equations (T.1), (T.2), (T.6) and
!! (T.7) of doc/theory/transfers.md.
module transfer_increments
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   use transfer_basis, only: basis_t
   use transfer_shape_data, only: shape_data_t, spare
   implicit none
   private

   public :: increments_t

   integer, parameter :: no_moments = 0, rotation = 1, linear_field = 2 !! Particle fields

   !> Node fields of one tile.
   type :: increments_t
      private
      integer :: axes = 0                            !! Active directions
      integer :: axis(3) = 0                         !! Numbers of the directions
      integer :: columns = 0                         !! Columns of the fields
      integer :: moments = no_moments                !! Kind of the moments
      logical :: heats = .false.                     !! Is lost kinetic energy found?
      real(wp) :: pic = 0.0_wp                       !! PIC fraction g [1]
      real(wp) :: ahead = 1.0_wp !! Fraction c of the gain in the displacement [1]
      real(wp), allocatable, public :: nodes(:, :)   !! (column, node)
      real(wp), allocatable :: place(:, :) !! (3, node) In the tile, along active directions [m]
   contains
      procedure :: choose => increments_choose       !! Columns, from the transfer
      procedure :: set_nodes => increments_set_nodes !! Node fields of a tile
      procedure :: gather => increments_gather       !! Brings them to the particles
      procedure :: add_heat => increments_add_heat   !! Lost kinetic energy
      procedure :: move => increments_move           !! New velocities and positions
      procedure :: find_way => increments_find_way   !! Advection velocity
   end type increments_t

contains

   !> Choose the columns.
   pure subroutine increments_choose(self, grid, flip_fraction, ahead, heats, affine, turning)
      class(increments_t), intent(inout) :: self
      type(grid_t), intent(in) :: grid
      real(wp), intent(in) :: flip_fraction          !! Fraction of the old velocity, above 1/2 [1]
      real(wp), intent(in) :: ahead !! Fraction c of the gain in the displacement [1]
      logical, intent(in) :: heats                   !! Is lost kinetic energy found?
      logical, intent(in) :: affine                  !! Do particles carry linear velocity fields?
      logical, intent(in) :: turning                 !! True if particles carry their rotation only
      integer :: k, node, place(3)

      self%axes = 0
      do k = 1, 3
         if (.not. grid%active(k)) cycle
         self%axes = self%axes + 1
         self%axis(self%axes) = k
      end do
      self%pic = 1.0_wp - flip_fraction
      self%ahead = ahead
      self%heats = heats
      self%moments = no_moments
      self%columns = 2*self%axes
      if (heats) then
         self%columns = self%columns + 1
         if (affine) self%moments = merge(rotation, linear_field, turning)
         self%columns = self%columns + number_of_moments(self%moments, self%axes)
      end if
      if (allocated(self%nodes)) then
         if (size(self%nodes, 1) == self%columns) return
         deallocate (self%nodes)
      end if
      ! node values that no particle uses are undefined, and so are their sums
      allocate (self%nodes(self%columns, grid%tile_nodes), source=0.0_wp)
      if (allocated(self%place)) deallocate (self%place)
      allocate (self%place(3, grid%tile_nodes), source=0.0_wp)
      do node = 1, grid%tile_nodes
         place = grid%node_position(node)
         self%place(:self%axes, node) = grid%spacing*real(place(self%axis(:self%axes)), wp)
      end do
   end subroutine increments_choose

   !> Number of columns of moments.
   pure integer function number_of_moments(moments, axes) result(number)
      integer, intent(in) :: moments                 !! Kind
      integer, intent(in) :: axes                    !! Active directions

      select case (moments)
      case (rotation)
         number = axes*(axes - 1)/2
      case (linear_field)
         number = axes**2
      case default
         number = 0
      end select
   end function number_of_moments

   !> Node fields of the tile.
   pure subroutine increments_set_nodes(self, low, high, dt, velocity, acceleration)
      class(increments_t), intent(inout) :: self
      integer, intent(in) :: low                             !! First node that particles use
      integer, intent(in) :: high                            !! Last index
      real(wp), intent(in) :: dt                             !! Time over which the forces act [s]
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (3, node) u [m/s]
      real(wp), contiguous, intent(in) :: acceleration(:, :) !! (3, node) a [m/s2]

      ! a compile-time number of directions removes the loop over them
      select case (self%axes)
      case (3)
         call set_fields(self, 3, [1, 2, 3], low, high, dt, velocity, acceleration)
      case (2)
         call set_fields(self, 2, [1, 3], low, high, dt, velocity, acceleration)
      case default
         call set_fields(self, self%axes, self%axis, low, high, dt, velocity, acceleration)
      end select
   end subroutine increments_set_nodes

   !> The same for given directions.
   pure subroutine set_fields(self, axes, axis, low, high, dt, velocity, acceleration)
      class(increments_t), intent(inout) :: self
      integer, intent(in) :: axes                            !! Number of active directions
      integer, intent(in) :: axis(axes)                      !! Active directions
      integer, intent(in) :: low                             !! First node that particles use
      integer, intent(in) :: high                            !! Last index
      real(wp), intent(in) :: dt                             !! Time over which the forces act [s]
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (3, node) u [m/s]
      real(wp), contiguous, intent(in) :: acceleration(:, :) !! (3, node) a [m/s2]
      real(wp) :: u, d, t(3), lost
      integer :: node, k, l

      do node = low, high
         lost = 0.0_wp
         do l = 1, axes
            k = axis(l)
            u = velocity(k, node)
            d = dt*acceleration(k, node)
            self%nodes(l, node) = d + self%pic*u
            self%nodes(axes + l, node) = u + self%ahead*d
            lost = lost + (0.5_wp*(d*d) + self%pic*(u*(u + d)))
            t(l) = self%pic*u - (1.0_wp - self%pic)*d
         end do
         if (.not. self%heats) cycle
         self%nodes(2*axes + 1, node) = lost
         select case (self%moments)
         case (rotation)
            call set_rotation(axes, self%place(:, node), t, self%nodes(2*axes + 2:, node))
         case (linear_field)
            call set_linear_field(axes, self%place(:, node), t, self%nodes(2*axes + 2:, node))
         case default
         end select
      end do
   end subroutine set_fields

   !> Angular momentum of a vector at one node.
   pure subroutine set_rotation(axes, x, t, columns)
      integer, intent(in) :: axes                    !! Active directions
      real(wp), intent(in) :: x(3)                   !! Position in the tile along them [m]
      real(wp), intent(in) :: t(3)                   !! Vector along these directions [m/s]
      real(wp), intent(inout) :: columns(:)          !! Moments of the increment [m2/s]

      select case (axes)
      case (3)
         columns(1) = x(2)*t(3) - x(3)*t(2)
         columns(2) = x(3)*t(1) - x(1)*t(3)
         columns(3) = x(1)*t(2) - x(2)*t(1)
      case (2)
         columns(1) = x(2)*t(1) - x(1)*t(2)
      case default
      end select
   end subroutine set_rotation

   !> Products of a vector and the position of its node.
   pure subroutine set_linear_field(axes, x, t, columns)
      integer, intent(in) :: axes                    !! Active directions
      real(wp), intent(in) :: x(3)                   !! Position in the tile along them [m]
      real(wp), intent(in) :: t(3)                   !! Vector along these directions [m/s]
      real(wp), intent(inout) :: columns(:)          !! (k, l) in k + axes (l - 1) [m2/s]
      integer :: k, l

      do l = 1, axes
         do k = 1, axes
            columns(k + axes*(l - 1)) = t(k)*x(l)
         end do
      end do
   end subroutine set_linear_field

   !> First index of a plane of rotation among the active directions: of the planes yz, zx, xy in
   !! three dimensions, and of zx in a plane.
   pure integer function first_of(plane, axes) result(index)
      integer, intent(in) :: plane                   !! 1 to 3, or 1
      integer, intent(in) :: axes                    !! Active directions

      index = merge(1 + mod(plane, 3), 2, axes == 3)
   end function first_of

   !> The second one.
   pure integer function second_of(plane, axes) result(index)
      integer, intent(in) :: plane                   !! 1 to 3, or 1
      integer, intent(in) :: axes                    !! Active directions

      index = merge(1 + mod(plane + 1, 3), 1, axes == 3)
   end function second_of

   !> Bring the node fields to the particles of a tile.
   pure subroutine increments_gather(self, grid, basis, shape)
      class(increments_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      class(basis_t), intent(in) :: basis
      type(shape_data_t), intent(inout) :: shape     !! Gets the values at particles

      call shape%reserve_increments(shape%count, self%columns)
      call basis%gather_values(grid, shape, self%nodes, shape%increments)
   end subroutine increments_gather

   !> Convert the kinetic energy that the transfer to the nodes and back dissipates to heat of the
   !! particles, before they get their new velocities.
   pure subroutine increments_add_heat(self, grid, shape, first, velocity, spin, affine, energy)
      class(increments_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      type(shape_data_t), intent(inout) :: shape             !! With the gathered fields
      integer, intent(in) :: first                           !! First particle of the tile
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (particle, 3) Before the step [m/s]
      real(wp), allocatable, intent(in) :: spin(:, :)        !! (particle, 3) If carried [1/s]
      real(wp), allocatable, intent(in) :: affine(:, :)      !! (particle, 9) If carried [1/s]
      real(wp), contiguous, intent(inout) :: energy(:)       !! (particle) [J/kg]
      real(wp) :: heat(shape%count)
      integer :: p, l

      do p = 1, shape%count
         heat(p) = shape%increments(p, 2*self%axes + 1)
      end do
      do l = 1, self%axes
         call lose_energy(shape%count, first, self%pic, self%ahead, shape%increments(:, l), &
            shape%increments(:, self%axes + l), velocity(:, self%axis(l)), shape%vector(:, l), &
            heat)
      end do
      if (self%moments /= no_moments) then
         call find_offsets(self, grid, shape)
         if (self%moments == rotation) then
            call turn(self, shape, first, spin, heat)
         else
            call stretch(self, shape, first, affine, heat)
         end if
      end if
      do p = 1, shape%count
         energy(first + p - 1) = energy(first + p - 1) + heat(p)
      end do
   end subroutine increments_add_heat

   !> Energy that the motion along one direction dissipates, and the vector g u - (1 - g) d at the
   !! particles.
   pure subroutine lose_energy(count, first, pic, ahead, gain, way, velocity, moved, heat)
      integer, intent(in) :: count                           !! Particles of the tile
      integer, intent(in) :: first                           !! First of them
      real(wp), intent(in) :: pic                            !! PIC fraction g [1]
      real(wp), intent(in) :: ahead !! Fraction c of the gain in the displacement [1]
      real(wp), contiguous, intent(in) :: gain(:)            !! d + g u [m/s]
      real(wp), contiguous, intent(in) :: way(:)             !! u + c d [m/s]
      real(wp), contiguous, intent(in) :: velocity(:)        !! (particle) [m/s]
      real(wp), contiguous, intent(inout) :: moved(:)        !! g u - (1 - g) d [m/s]
      real(wp), contiguous, intent(inout) :: heat(:)         !! [J/kg]
      real(wp) :: inverse, u, d, rest
      integer :: p

      inverse = 1.0_wp/(1.0_wp - ahead*pic)
      !$omp simd private(u, d, rest)
      do p = 1, count
         u = (way(p) - ahead*gain(p))*inverse
         d = gain(p) - pic*u
         rest = velocity(first + p - 1) - u
         heat(p) = heat(p) - 0.5_wp*(d*d) - pic*(u*(u + d)) &
            + (pic*(1.0_wp - 0.5_wp*pic))*(rest*rest)
         moved(p) = pic*u - (1.0_wp - pic)*d
      end do
   end subroutine lose_energy

   !> Positions of the particles from the corner of their tile along the active directions, in the
   !! first columns of the scratch values [m].
   pure subroutine find_offsets(self, grid, shape)
      class(increments_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      type(shape_data_t), intent(inout) :: shape
      real(wp) :: corner
      integer :: cell, l, p, lane

      do l = 1, self%axes
         do cell = 0, grid%tile_cells - 1
            corner = real(grid%cell_position(self%axis(l), cell), wp)
            ! the last lanes belong to the next cells, which are processed later
            do p = shape%start(cell) + 1, shape%start(cell + 1), spare
               !$omp simd
               do lane = p, p + spare - 1
                  shape%values(lane, l) = grid%spacing*(corner + shape%local(lane, self%axis(l)))
               end do
            end do
         end do
      end do
   end subroutine find_offsets

   !> Subtract from the heat of particles that carry a rotation: the spin times the angular momentum
   !! of the gathered vector field about the particle.
   pure subroutine turn(self, shape, first, spin, heat)
      class(increments_t), intent(in) :: self
      type(shape_data_t), intent(in) :: shape                !! With offsets and vectors
      integer, intent(in) :: first                           !! First particle of the tile
      real(wp), contiguous, intent(in) :: spin(:, :)         !! (particle, 3) [1/s]
      real(wp), contiguous, intent(inout) :: heat(:)         !! [J/kg]
      integer :: p, k, l, m, normal

      do m = 1, number_of_moments(rotation, self%axes)
         k = first_of(m, self%axes)
         l = second_of(m, self%axes)
         normal = 6 - self%axis(k) - self%axis(l)
         !$omp simd
         do p = 1, shape%count
            heat(p) = heat(p) - spin(first + p - 1, normal)*(shape%increments(p, &
               2*self%axes + 1 + m) - (shape%values(p, k)*shape%vector(p, l) &
               - shape%values(p, l)*shape%vector(p, k)))
         end do
      end do
   end subroutine turn

   !> Heat of particles that carry a linear velocity field.
   pure subroutine stretch(self, shape, first, affine, heat)
      class(increments_t), intent(in) :: self
      type(shape_data_t), intent(in) :: shape                !! With offsets and vectors
      integer, intent(in) :: first                           !! First particle of the tile
      real(wp), contiguous, intent(in) :: affine(:, :)       !! (particle, 9) [1/s]
      real(wp), contiguous, intent(inout) :: heat(:)         !! [J/kg]
      integer :: p, k, l, component, column

      do l = 1, self%axes
         do k = 1, self%axes
            component = self%axis(k) + 3*(self%axis(l) - 1)
            column = 2*self%axes + 1 + k + self%axes*(l - 1)
            !$omp simd
            do p = 1, shape%count
               heat(p) = heat(p) - affine(first + p - 1, component)*(shape%increments(p, column) &
                  - shape%values(p, l)*shape%vector(p, k))
            end do
         end do
      end do
   end subroutine stretch

   !> New velocities and positions of the particles of a tile: (T.1) and (T.2).
   pure subroutine increments_move(self, shape, first, dt, velocity, position)
      class(increments_t), intent(in) :: self
      type(shape_data_t), intent(in) :: shape                !! With the gathered fields
      integer, intent(in) :: first                           !! First particle of the tile
      real(wp), intent(in) :: dt                             !! Time step [s]
      real(wp), contiguous, intent(inout) :: velocity(:, :)  !! (particle, 3) [m/s]
      real(wp), contiguous, intent(inout) :: position(:, :)  !! (particle, 3) [m]
      integer :: p, q, k, l

      do l = 1, self%axes
         k = self%axis(l)
         !$omp simd private(q)
         do p = 1, shape%count
            q = first + p - 1
            velocity(q, k) = (1.0_wp - self%pic)*velocity(q, k) + shape%increments(p, l)
            position(q, k) = position(q, k) + dt*shape%increments(p, self%axes + l)
         end do
      end do
   end subroutine increments_move

   !> Velocity with which the particles move, in all three directions.
   pure subroutine increments_find_way(self, shape)
      class(increments_t), intent(in) :: self
      type(shape_data_t), intent(inout) :: shape !! Gets the increment as its vector [m/s]
      integer :: p, l

      shape%vector(:shape%count, :) = 0.0_wp
      do l = 1, self%axes
         do p = 1, shape%count
            shape%vector(p, self%axis(l)) = shape%increments(p, self%axes + l)
         end do
      end do
   end subroutine increments_find_way
end module transfer_increments
