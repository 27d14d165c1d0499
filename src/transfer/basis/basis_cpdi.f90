! SPDX-License-Identifier: BSD-3-Clause
!> Linear functions averaged over the parallelepiped of a particle, which follows the deformation,
!! with the values at its corners (CPDI): A. Sadeghirad, R. M. Brannon, J. Burghardt, Int. J. Numer.
!! Methods Eng. 86 (2011) 1435.
!!
!! With the half edges r_a and the signs s_ca of the corners, x_c = x + sum_a s_ca r_a, the
!! functions are S_i = mean of N_i(x_c) and their gradients mean of N_i(x_c) sum_a s_ca R^-1_al,
!! R = (r_1 r_2 r_3), in one, two and three dimensions. Both are exact for linear fields whatever
!! the edges are. Equation (N.7) of doc/theory/node_functions.md.
module basis_cpdi
   use base_kinds, only: wp
   use mesh_grid, only: grid_t, lanes
   use particle_store, only: store_t, traits_t
   use transfer_basis, only: basis_t
   use transfer_cpdi_kernels, only: gather_corner_gradient, gather_corner_values, &
      scatter_corner_stress, scatter_corner_values
   use transfer_shape_data, only: shape_data_t
   implicit none
   private

   public :: basis_cpdi_t

   real(wp), parameter :: most = 1.0_wp              !! Greatest half domain [cells]
   real(wp), parameter :: least = 1.0e-6_wp          !! Least half domain [cells]
   real(wp), parameter :: flat = 1.0e-3_wp           !! Least volume of a domain in that of its box
   real(wp), parameter :: usual = 0.25_wp            !! Half a cube in place of a flat one [cells]
   real(wp), parameter :: least_moment = 1.0e-12_wp  !! Second moment that divides at least [cells2]

   !> Means over the corners of parallelepipeds.
   type, extends(basis_t) :: basis_cpdi_t
   contains
      procedure :: margin => cpdi_margin             !! Layers of nodes beyond a tile
      procedure :: request => cpdi_request           !! Particles carry their edges
      procedure :: locate => cpdi_locate             !! Corners
      procedure :: scatter_values => cpdi_scatter_values !! Values to nodes
      procedure :: scatter_affine => cpdi_scatter_affine !! Mass and a linear velocity field
      procedure :: scatter_stress => cpdi_scatter_stress !! Force of the stress
      procedure :: gather_values => cpdi_gather_values !! Node values to particles
      procedure :: gather_gradient => cpdi_gather_gradient !! Gradients of the values
      procedure :: gather_affine => cpdi_gather_affine !! Linear velocity field
   end type basis_cpdi_t

contains

   !> One layer of nodes beyond a tile.
   pure integer function cpdi_margin(self) result(margin)
      class(basis_cpdi_t), intent(in) :: self

      margin = 1
   end function cpdi_margin

   !> Particles carry half the edges of their parallelepipeds.
   pure subroutine cpdi_request(self, traits)
      class(basis_cpdi_t), intent(in) :: self
      type(traits_t), intent(inout) :: traits

      traits%domain = .true.
   end subroutine cpdi_request

   !> Corners of the particles of a tile. A corner is in the cell of its particle or in an adjacent
   !! cell, and not beyond a wall: corners there would need negative shape functions, and a node
   !! touched by such a corner alone would have a negative mass. Where a particle is almost on the
   !! wall the functions of the last cell are extrapolated, so that linear fields remain exact.
   pure subroutine cpdi_locate(self, grid, coordinate, store, tile, shape)
      class(basis_cpdi_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coordinate(3)                   !! The tile, counted from 0
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile                            !! Index of the tile
      type(shape_data_t), intent(inout) :: shape
      real(wp) :: edge(3, 3), inverse(3, 3), limit(3), at
      integer :: cell, p, c, k, step, place(3), lowest(3), highest(3)

      call shape%take_tile(grid, store, tile)
      call shape%corner%reserve(store%count(tile), lanes)
      do cell = 0, grid%tile_cells - 1
         place = coordinate*grid%width + grid%cell_position(:, cell)
         lowest = merge(0, -1, .not. grid%active .or. (grid%wall(1::2) .and. place == 0))
         highest = merge(0, 1, .not. grid%active .or. (grid%wall(2::2) .and. &
            place == grid%cells - 1))
         do p = store%cell_start(cell, tile) + 1, store%cell_start(cell + 1, tile)
            do k = 1, 3
               limit(k) = most
               if (lowest(k) == 0) limit(k) = min(limit(k), shape%local(p, k))
               if (highest(k) == 0) limit(k) = min(limit(k), 1.0_wp - shape%local(p, k))
            end do
            call find_domain(grid, store, store%first(tile) + p - 1, limit, edge, inverse)
            do k = 1, 3
               do c = 1, 3
                  shape%corner%edge(c + 3*(k - 1), p) = edge(c, k)
                  shape%corner%inverse(c + 3*(k - 1), p) = inverse(c, k)
               end do
            end do
            shape%corner%node(:, p) = grid%first_node(cell)
            do k = 1, 3
               do c = 1, lanes
                  at = shape%local(p, k) + edge(k, 1)*grid%lane_slope(c, 1) &
                     + edge(k, 2)*grid%lane_slope(c, 2) + edge(k, 3)*grid%lane_slope(c, 3)
                  step = min(max(floor(at), lowest(k)), highest(k))
                  shape%corner%local(c, k, p) = at - real(step, wp)
                  shape%corner%node(c, p) = shape%corner%node(c, p) + step*grid%stride(k)
               end do
            end do
         end do
      end do
   end subroutine cpdi_locate

   !> Half edges of the domain of a particle for the functions, in cells, and the inverse of their
   !! matrix.
   !!
   !! A domain that extends beyond one cell, or beyond a wall, is scaled, as M. A. Homel, R. M.
   !! Brannon, J. Guilkey, Int. J. Numer. Methods Eng. (2016) do; here along the directions of the
   !! grid in which it is too long, so that it stays a parallelepiped. If the edges lie nearly in a
   !! plane, it is replaced by a cube. Equation (N.9).
   pure subroutine find_domain(grid, store, q, limit, edge, inverse)
      type(grid_t), intent(in) :: grid
      type(store_t), intent(in) :: store
      integer, intent(in) :: q                               !! Index of the particle
      real(wp), intent(in) :: limit(3)                        !! Greatest half domain [cells]
      real(wp), intent(out) :: edge(3, 3)                    !! (component, edge) [cells]
      real(wp), intent(out) :: inverse(3, 3)                 !! (edge, component) [1/cells]
      real(wp) :: reach(3), wanted, volume
      integer :: k

      edge = 0.0_wp
      reach = 1.0_wp
      do k = 1, 3
         if (.not. grid%active(k)) then
            edge(k, k) = 1.0_wp
            cycle
         end if
         where (grid%active) edge(k, :) = store%domain(q, k:k + 6:3)*(1.0_wp/grid%spacing)
         reach(k) = sum(abs(edge(k, :)))
         wanted = max(min(reach(k), limit(k)), least)
         edge(k, :) = edge(k, :)*(wanted/max(reach(k), tiny(reach)))
         reach(k) = wanted
      end do
      call invert(edge, inverse, volume)
      ! this comparison also catches NaN
      if (volume > flat*product(reach)) return
      edge = 0.0_wp
      inverse = 0.0_wp
      do k = 1, 3
         edge(k, k) = merge(max(min(usual, limit(k)), least), 1.0_wp, grid%active(k))
         inverse(k, k) = 1.0_wp/edge(k, k)
      end do
   end subroutine find_domain

   !> Inverse and determinant of a matrix; the inverse is of no use if the determinant is 0.
   pure subroutine invert(a, inverse, determinant)
      real(wp), intent(in) :: a(3, 3)                        !! Any matrix
      real(wp), intent(out) :: inverse(3, 3)                 !! Inverse of the matrix
      real(wp), intent(out) :: determinant                   !! Determinant of the matrix
      integer :: i, j

      do j = 1, 3
         do i = 1, 3
            associate (i1 => mod(i, 3) + 1, i2 => mod(i + 1, 3) + 1, j1 => mod(j, 3) + 1, &
               j2 => mod(j + 1, 3) + 1)
               inverse(j, i) = a(i1, j1)*a(i2, j2) - a(i1, j2)*a(i2, j1)
            end associate
         end do
      end do
      determinant = a(1, 1)*inverse(1, 1) + a(1, 2)*inverse(2, 1) + a(1, 3)*inverse(3, 1)
      if (abs(determinant) > 0.0_wp) inverse = inverse*(1.0_wp/determinant)
   end subroutine invert

   !> Linear functions of the nodes around a corner, divided by the number of corners.
   pure subroutine corner_functions(grid, shape, p, corner, share, functions)
      type(grid_t), intent(in) :: grid
      type(shape_data_t), intent(in) :: shape
      integer, intent(in) :: p                               !! Index of the particle
      integer, intent(in) :: corner                          !! Index of the corner
      real(wp), intent(in) :: share                          !! One over the corners
      real(wp), intent(out) :: functions(lanes)                  !! (lane) The functions
      integer :: lane

      !$omp simd
      do lane = 1, lanes
         functions(lane) = share*(grid%lane_constant(lane, 1) &
            + grid%lane_slope(lane, 1)*shape%corner%local(corner, 1, p)) &
            *(grid%lane_constant(lane, 2) &
            + grid%lane_slope(lane, 2)*shape%corner%local(corner, 2, p)) &
            *(grid%lane_constant(lane, 3) &
            + grid%lane_slope(lane, 3)*shape%corner%local(corner, 3, p))
      end do
   end subroutine corner_functions

   !> Position of a corner relative to its particle [cells].
   pure function corner_offset(grid, shape, p, corner) result(way)
      type(grid_t), intent(in) :: grid
      type(shape_data_t), intent(in) :: shape
      integer, intent(in) :: p                               !! Index of the particle
      integer, intent(in) :: corner                          !! Index of the corner
      real(wp) :: way(3)
      integer :: a, k

      way = 0.0_wp
      do a = 1, 3
         do k = 1, 3
            way(k) = way(k) + grid%lane_slope(corner, a)*shape%corner%edge(k + 3*(a - 1), p)
         end do
      end do
   end function corner_offset

   !> Position of a node of the cell of a corner relative to the particle; zero along a missing
   !! direction [cells].
   pure function node_way(grid, shape, p, corner, lane) result(way)
      type(grid_t), intent(in) :: grid
      type(shape_data_t), intent(in) :: shape
      integer, intent(in) :: p                               !! Index of the particle
      integer, intent(in) :: corner                          !! Index of the corner
      integer, intent(in) :: lane                            !! Lane of the node
      real(wp) :: way(3)

      way = corner_offset(grid, shape, p, corner) + (1.0_wp - grid%lane_constant(lane, :) &
         - shape%corner%local(corner, :, p))
      where (.not. grid%active) way = 0.0_wp
   end function node_way

   !> Add sum S_i value to columns of a patch.
   pure subroutine cpdi_scatter_values(self, grid, shape, count, values, before, patch)
      class(basis_cpdi_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      type(shape_data_t), intent(in) :: shape
      integer, intent(in) :: count                           !! Number of columns
      real(wp), contiguous, intent(in) :: values(:, :)       !! (particle of the tile, column)
      integer, intent(in) :: before                          !! Column offset in the patch
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)

      call scatter_corner_values(grid, shape, count, values, before, size(patch, 1), &
         size(patch, 2), patch)
   end subroutine cpdi_scatter_values

   !> Add mass and momentum of linear velocity fields (C. Jiang, C. Schroeder, A. Selle, J. Teran,
   !! A. Stomakhin, ACM Trans. Graph. 34 (2015) 51).
   pure subroutine cpdi_scatter_affine(self, grid, shape, first, mass, velocity, affine, patch)
      class(basis_cpdi_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: first                           !! First particle of the tile
      type(shape_data_t), intent(in) :: shape
      real(wp), contiguous, intent(in) :: mass(:)            !! (particle) [kg]
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (particle, 3) [m/s]
      real(wp), contiguous, intent(in) :: affine(:, :)       !! (particle, 9) C_kl, k + 3 (l - 1)
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)
      real(wp) :: functions(lanes), way(3), part
      integer :: p, q, c, lane, node, k, corners

      corners = 2**grid%dimensions
      do p = 1, shape%count
         q = first + p - 1
         do c = 1, corners
            call corner_functions(grid, shape, p, c, mass(q)/real(corners, wp), functions)
            do lane = 1, corners
               node = shape%corner%node(c, p) + grid%lane_offset(lane)
               way = grid%spacing*node_way(grid, shape, p, c, lane)
               patch(1, node) = patch(1, node) + functions(lane)
               do k = 1, 3
                  part = velocity(q, k) + affine(q, k)*way(1) + affine(q, k + 3)*way(2) &
                     + affine(q, k + 6)*way(3)
                  patch(1 + k, node) = patch(1 + k, node) + functions(lane)*part
               end do
            end do
         end do
      end do
   end subroutine cpdi_scatter_affine

   !> Add the internal force - sum v sigma . grad S_i to columns 5 to 7 of a patch: each corner gets
   !! a force, and distributes it to its nodes.
   pure subroutine cpdi_scatter_stress(self, grid, shape, first, volume, stress, patch)
      class(basis_cpdi_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: first                           !! First particle of the tile
      type(shape_data_t), intent(in) :: shape
      real(wp), contiguous, intent(in) :: volume(:)          !! (particle) [m3]
      real(wp), contiguous, intent(in) :: stress(:, :)       !! (particle, 6) Cauchy stress [Pa]
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)

      call scatter_corner_stress(grid, shape, first, volume, stress, size(patch, 1), &
         size(patch, 2), patch)
   end subroutine cpdi_scatter_stress

   !> Values sum S_i node_i, three columns at a time.
   pure subroutine cpdi_gather_values(self, grid, shape, nodes, values)
      class(basis_cpdi_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      type(shape_data_t), intent(in) :: shape
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (column, node)
      real(wp), contiguous, intent(inout) :: values(:, :)    !! (particle of the tile, column)
      real(wp) :: part(3, size(nodes, 2))
      integer :: skip, count

      if (size(nodes, 1) == 3) then
         call gather_corner_values(grid, shape, size(nodes, 2), nodes, 0, values)
         return
      end if
      part = 0.0_wp
      do skip = 0, size(nodes, 1) - 1, 3
         count = min(size(nodes, 1) - skip, 3)
         part(:count, :) = nodes(skip + 1:skip + count, :)
         call gather_corner_values(grid, shape, size(nodes, 2), part, skip, values)
      end do
   end subroutine cpdi_gather_values

   !> Scaled velocity gradient: mean differences along the edges, times the inverse of the edges.
   pure subroutine cpdi_gather_gradient(self, grid, shape, nodes, scale, gradient)
      class(basis_cpdi_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      type(shape_data_t), intent(in) :: shape
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (3, node) Velocity [m/s]
      real(wp), intent(in) :: scale                          !! Factor, such as the step [s]
      real(wp), contiguous, intent(inout) :: gradient(:, :)  !! (particle of the tile, 9)

      call gather_corner_gradient(grid, shape, size(nodes, 2), nodes, scale, gradient)
   end subroutine cpdi_gather_gradient

   !> Linear velocity field: sum S_i u_i (x_i - x) times the inverse of the second moments, which
   !! keeps angular momentum (C. Jiang and others, 2015, as above). Equation (N.10).
   pure subroutine cpdi_gather_affine(self, grid, shape, nodes, affine)
      class(basis_cpdi_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      type(shape_data_t), intent(in) :: shape
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (3, node) Velocity [m/s]
      real(wp), contiguous, intent(inout) :: affine(:, :)    !! (particle of the tile, 9) [1/s]
      real(wp) :: functions(lanes), way(3), sums(3, 3), moment(3, 3), inverse(3, 3), determinant, &
         share
      integer :: p, c, lane, node, k, l, corners

      corners = 2**grid%dimensions
      share = 1.0_wp/real(corners, wp)
      do p = 1, shape%count
         sums = 0.0_wp
         moment = 0.0_wp
         do k = 1, 3
            moment(k, k) = merge(least_moment, 1.0_wp, grid%active(k))
         end do
         do c = 1, corners
            call corner_functions(grid, shape, p, c, share, functions)
            do lane = 1, corners
               node = shape%corner%node(c, p) + grid%lane_offset(lane)
               way = node_way(grid, shape, p, c, lane)
               do l = 1, 3
                  sums(:, l) = sums(:, l) + functions(lane)*nodes(1:3, node)*way(l)
                  moment(:, l) = moment(:, l) + functions(lane)*way*way(l)
               end do
            end do
         end do
         call invert(moment, inverse, determinant)
         do l = 1, 3
            do k = 1, 3
               affine(p, k + 3*(l - 1)) = (sums(k, 1)*inverse(1, l) + sums(k, 2)*inverse(2, l) &
                  + sums(k, 3)*inverse(3, l))*(1.0_wp/grid%spacing)
            end do
         end do
      end do
   end subroutine cpdi_gather_affine
end module basis_cpdi
