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
   use transfer_shape_data, only: shape_data_t
   implicit none
   private

   public :: basis_cpdi_t

   integer, parameter :: lines = lanes/2             !! Lines along x of a cell
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

   !> Position of a node of the cell of a corner relative to the particle; zero along a missing
   !! direction [cells].
   pure function node_way(grid, shape, p, corner, lane) result(way)
      type(grid_t), intent(in) :: grid
      type(shape_data_t), intent(in) :: shape
      integer, intent(in) :: p                               !! Index of the particle
      integer, intent(in) :: corner                          !! Index of the corner
      integer, intent(in) :: lane                            !! Lane of the node
      real(wp) :: way(3)
      integer :: k

      way = 0.0_wp
      do k = 1, 3
         way = way + grid%lane_slope(corner, k)*shape%corner%edge(3*k - 2:3*k, p)
      end do
      way = way + (1.0_wp - grid%lane_constant(lane, :) - shape%corner%local(corner, :, p))
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
      real(wp) :: weight(lines), lower(count), upper(count), x, share
      integer :: p, c, m, at, n, corners

      corners = 2**grid%dimensions
      share = 1.0_wp/real(corners, wp)
      do p = 1, shape%count
         do c = 1, corners
            x = shape%corner%local(c, 1, p)
            call weigh_lines(grid, shape%corner%local(c, 2, p), shape%corner%local(c, 3, p), weight)
            do n = 1, count
               lower(n) = (1.0_wp - x)*(values(p, n)*share)
               upper(n) = x*(values(p, n)*share)
            end do
            do m = 1, corners/2
               at = before + size(patch, 1)*(shape%corner%node(c, p) - 1 &
                  + grid%lane_offset(2*m - 1))
               call add_line(count, weight(m), lower, upper, at, size(patch, 1), size(patch), patch)
            end do
         end do
      end do
   end subroutine cpdi_scatter_values

   !> Functions of the lines along x of a cell at a corner.
   pure subroutine weigh_lines(grid, y, z, weight)
      type(grid_t), intent(in) :: grid
      real(wp), intent(in) :: y, z                           !! Coordinates of the corner [1]
      real(wp), intent(out) :: weight(lines)                 !! (line)
      integer :: m

      !$omp simd
      do m = 1, lines
         weight(m) = (grid%lane_constant(2*m, 2) + grid%lane_slope(2*m, 2)*y) &
            *(grid%lane_constant(2*m, 3) + grid%lane_slope(2*m, 3)*z)
      end do
   end subroutine weigh_lines

   !> Add columns to the two nodes of a line. The patch is a one-dimensional array.
   pure subroutine add_line(count, weight, lower, upper, at, rows, numbers, patch)
      integer, intent(in) :: count                           !! Number of columns
      real(wp), intent(in) :: weight                         !! Function of the line
      real(wp), intent(in) :: lower(count), upper(count)     !! (column) For its two nodes
      integer, intent(in) :: at                              !! Index offset in the patch
      integer, intent(in) :: rows                            !! Columns of the patch
      integer, intent(in) :: numbers                         !! Numbers of the patch
      real(wp), intent(inout) :: patch(numbers)              !! (column, node), flat
      integer :: n

      ! a compile-time constant makes the columns one vector
      if (count == 4) then
         !$omp simd
         do n = 1, 4
            patch(at + n) = patch(at + n) + weight*lower(n)
            patch(at + rows + n) = patch(at + rows + n) + weight*upper(n)
         end do
      else
         do n = 1, count
            patch(at + n) = patch(at + n) + weight*lower(n)
            patch(at + rows + n) = patch(at + rows + n) + weight*upper(n)
         end do
      end if
   end subroutine add_line

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
      integer, parameter :: symmetric(3, 3) = reshape([1, 4, 6, 4, 2, 5, 6, 5, 3], [3, 3])
      real(wp) :: weight(lines), along(3, 3), force(3), lower(3), upper(3), x, v
      integer :: p, q, c, m, at, k, l, corners

      corners = 2**grid%dimensions
      do p = 1, shape%count
         q = first + p - 1
         v = -volume(q)/(grid%spacing*real(corners, wp))
         ! the stress in the basis of the edges
         do l = 1, 3
            do k = 1, 3
               along(k, l) = v*(stress(q, symmetric(k, 1))*shape%corner%inverse(l, p) &
                  + stress(q, symmetric(k, 2))*shape%corner%inverse(l + 3, p) &
                  + stress(q, symmetric(k, 3))*shape%corner%inverse(l + 6, p))
            end do
         end do
         do c = 1, corners
            do k = 1, 3
               force(k) = grid%lane_slope(c, 1)*along(k, 1) + grid%lane_slope(c, 2)*along(k, 2) &
                  + grid%lane_slope(c, 3)*along(k, 3)
            end do
            x = shape%corner%local(c, 1, p)
            call weigh_lines(grid, shape%corner%local(c, 2, p), shape%corner%local(c, 3, p), weight)
            lower = (1.0_wp - x)*force
            upper = x*force
            do m = 1, corners/2
               at = size(patch, 1)*(shape%corner%node(c, p) + grid%lane_offset(2*m - 1) - 1) + 4
               call add_line(3, weight(m), lower, upper, at, size(patch, 1), size(patch), patch)
            end do
         end do
      end do
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
         call gather_vector(grid, shape, nodes, 0, values)
         return
      end if
      part = 0.0_wp
      do skip = 0, size(nodes, 1) - 1, 3
         count = min(size(nodes, 1) - skip, 3)
         part(:count, :) = nodes(skip + 1:skip + count, :)
         call gather_vector(grid, shape, part, skip, values)
      end do
   end subroutine cpdi_gather_values

   !> Values of three columns.
   pure subroutine gather_vector(grid, shape, nodes, skip, values)
      type(grid_t), intent(in) :: grid
      type(shape_data_t), intent(in) :: shape
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (3, node)
      integer, intent(in) :: skip                            !! Column offset in the values
      real(wp), contiguous, intent(inout) :: values(:, :)    !! (particle of the tile, column)
      real(wp) :: value(3), total(3), share
      integer :: p, c

      share = 1.0_wp/real(2**grid%dimensions, wp)
      do p = 1, shape%count
         total = 0.0_wp
         do c = 1, 2**grid%dimensions
            call find_value(grid, shape, p, c, size(nodes), nodes, value)
            total = total + value
         end do
         values(p, skip + 1:skip + 3) = share*total
      end do
   end subroutine gather_vector

   !> Vector at a corner. The components and nodes of a line along x are the lanes, and the node
   !! field is a one-dimensional array.
   pure subroutine find_value(grid, shape, p, corner, numbers, nodes, value)
      type(grid_t), intent(in) :: grid
      type(shape_data_t), intent(in) :: shape
      integer, intent(in) :: p                               !! Index of the particle
      integer, intent(in) :: corner                          !! Index of the corner
      integer, intent(in) :: numbers                         !! Numbers of the node field
      real(wp), intent(in) :: nodes(numbers)                 !! (component, node), flat
      real(wp), intent(out) :: value(3)                      !! Value of the field
      real(wp) :: weight(lines), sums(6), x
      integer :: m, n, at

      x = shape%corner%local(corner, 1, p)
      call weigh_lines(grid, shape%corner%local(corner, 2, p), shape%corner%local(corner, 3, p), &
         weight)
      sums = 0.0_wp
      do m = 1, 2**(grid%dimensions - 1)
         at = 3*(shape%corner%node(corner, p) + grid%lane_offset(2*m - 1) - 1)
         !$omp simd
         do n = 1, 6
            sums(n) = sums(n) + weight(m)*nodes(at + n)
         end do
      end do
      do n = 1, 3
         value(n) = (1.0_wp - x)*sums(n) + x*sums(n + 3)
      end do
   end subroutine find_value

   !> Scaled velocity gradient: mean differences along the edges, times the inverse of the edges.
   pure subroutine cpdi_gather_gradient(self, grid, shape, nodes, scale, gradient)
      class(basis_cpdi_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      type(shape_data_t), intent(in) :: shape
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (3, node) Velocity [m/s]
      real(wp), intent(in) :: scale                          !! Factor, such as the step [s]
      real(wp), contiguous, intent(inout) :: gradient(:, :)  !! (particle of the tile, 9)
      real(wp) :: value(3), along(3, 3), factor
      integer :: p, c, k, l

      factor = scale/(grid%spacing*real(2**grid%dimensions, wp))
      do p = 1, shape%count
         along = 0.0_wp
         do c = 1, 2**grid%dimensions
            call find_value(grid, shape, p, c, size(nodes), nodes, value)
            do l = 1, 3
               do k = 1, 3
                  along(k, l) = along(k, l) + grid%lane_slope(c, l)*value(k)
               end do
            end do
         end do
         do l = 1, 3
            do k = 1, 3
               gradient(p, k + 3*(l - 1)) = factor*(along(k, 1)*shape%corner%inverse(3*l - 2, p) &
                  + along(k, 2)*shape%corner%inverse(3*l - 1, p) &
                  + along(k, 3)*shape%corner%inverse(3*l, p))
            end do
         end do
      end do
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
