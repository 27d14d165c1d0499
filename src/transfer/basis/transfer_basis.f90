! SPDX-License-Identifier: BSD-3-Clause
!> Shape functions of a method: maps between the particles of a tile and its nodes.
!!
!! A basis defines six maps. The others are composed of them here, and a basis may override them
!! where one pass is faster than two. A particle q of the store has index q - first + 1 in its tile;
!! `start` counts the particles of the tile before each cell.
module transfer_basis
   use base_kinds, only: wp
   use deck_schema, only: schema_t
   use mesh_grid, only: grid_t
   use particle_store, only: store_t, traits_t
   use transfer_hoop, only: scatter_factored_hoop
   use transfer_shape_data, only: shape_data_t
   implicit none
   private

   public :: basis_gather_motion, basis_scatter_motion, basis_t, expand_spin

   !> Shape functions.
   type, abstract :: basis_t
   contains
      procedure :: margin => basis_margin            !! Layers of nodes reached beyond a tile
      procedure :: at_wall => basis_at_wall          !! Integral of the function of a wall
      procedure :: band_width => basis_band_width    !! Width of a crack across a cell
      procedure :: is_linear => basis_is_linear      !! Are its functions linear in each cell?
      procedure :: suits_cell => basis_suits_cell    !! May the mesh deform with its cell?
      procedure :: declare => basis_declare          !! Declares its keys, if it has any
      procedure :: request => basis_request !! Requests fields of particles
      procedure(locate_i), deferred :: locate        !! Finds the shape data of a tile
      procedure(scatter_values_i), deferred :: scatter_values !! Values to nodes
      procedure(scatter_affine_i), deferred :: scatter_affine !! Mass and a linear velocity field
      procedure(scatter_stress_i), deferred :: scatter_stress !! Force of the stress
      procedure(gather_values_i), deferred :: gather_values !! Node values to particles
      procedure(gather_gradient_i), deferred :: gather_gradient !! Gradients of the values
      procedure :: gather_affine => basis_gather_affine !! Linear velocity field around a particle
      procedure :: scatter_motion => basis_scatter_motion !! Mass and momentum
      procedure :: scatter_turning => basis_scatter_turning !! Vectors of rotating particles
      procedure :: scatter_product => basis_scatter_product !! Mass times a vector
      procedure :: scatter_hoop => basis_scatter_hoop !! Force of the hoop stress
      procedure :: gather_motion => basis_gather_motion !! Velocity and position
      procedure :: gather_vector => basis_gather_vector !! One particle vector
      procedure :: gather_hoop => basis_gather_hoop  !! Hoop rate
      procedure :: gather_heat => basis_gather_heat  !! Kinetic energy that is lost
   end type basis_t

   abstract interface
      !> Shape data of the particles of a tile, for all other maps.
      pure subroutine locate_i(self, grid, coordinate, store, tile, shape)
         import :: basis_t, grid_t, shape_data_t, store_t
         implicit none
         class(basis_t), intent(in) :: self
         type(grid_t), intent(in) :: grid
         integer, intent(in) :: coordinate(3)                   !! The tile, counted from 0
         type(store_t), intent(in) :: store
         integer, intent(in) :: tile                            !! Index of the tile
         type(shape_data_t), intent(inout) :: shape
      end subroutine locate_i

      !> Add sum S_i value to columns of a patch.
      pure subroutine scatter_values_i(self, grid, shape, count, values, before, patch)
         import :: basis_t, grid_t, shape_data_t, wp
         implicit none
         class(basis_t), intent(in) :: self
         type(grid_t), intent(in) :: grid
         type(shape_data_t), intent(in) :: shape
         integer, intent(in) :: count                           !! Number of columns
         real(wp), contiguous, intent(in) :: values(:, :)       !! (particle of the tile, column)
         integer, intent(in) :: before                          !! Column offset in the patch
         real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)
      end subroutine scatter_values_i

      !> Add mass and momentum sum m S_i (v + C (x_i - x)) to columns 1 to 4 of a patch.
      pure subroutine scatter_affine_i(self, grid, shape, first, mass, velocity, affine, patch)
         import :: basis_t, grid_t, shape_data_t, wp
         implicit none
         class(basis_t), intent(in) :: self
         type(grid_t), intent(in) :: grid
         integer, intent(in) :: first                           !! First particle of the tile
         type(shape_data_t), intent(in) :: shape
         real(wp), contiguous, intent(in) :: mass(:)            !! (particle) [kg]
         real(wp), contiguous, intent(in) :: velocity(:, :)     !! (particle, 3) [m/s]
         real(wp), contiguous, intent(in) :: affine(:, :)       !! (particle, 9) C_kl, k + 3 (l - 1)
         real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)
      end subroutine scatter_affine_i

      !> Add the internal force - sum v sigma . grad S_i to columns 5 to 7 of a patch.
      pure subroutine scatter_stress_i(self, grid, shape, first, volume, stress, patch)
         import :: basis_t, grid_t, shape_data_t, wp
         implicit none
         class(basis_t), intent(in) :: self
         type(grid_t), intent(in) :: grid
         integer, intent(in) :: first                           !! First particle of the tile
         type(shape_data_t), intent(in) :: shape
         real(wp), contiguous, intent(in) :: volume(:)          !! (particle) [m3]
         real(wp), contiguous, intent(in) :: stress(:, :)       !! (particle, 6) Cauchy stress [Pa]
         real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)
      end subroutine scatter_stress_i

      !> Values sum S_i node_i.
      pure subroutine gather_values_i(self, grid, shape, nodes, values)
         import :: basis_t, grid_t, shape_data_t, wp
         implicit none
         class(basis_t), intent(in) :: self
         type(grid_t), intent(in) :: grid
         type(shape_data_t), intent(in) :: shape
         real(wp), contiguous, intent(in) :: nodes(:, :)        !! (column, node)
         !> (particle of the tile, column) Columns up to the next multiple of three and rows up to
         !! `spare` after the last particle may be written
         real(wp), contiguous, intent(inout) :: values(:, :)
      end subroutine gather_values_i

      !> Scaled velocity gradient scale sum u_k dS_i/dx_l.
      pure subroutine gather_gradient_i(self, grid, shape, nodes, scale, gradient)
         import :: basis_t, grid_t, shape_data_t, wp
         implicit none
         class(basis_t), intent(in) :: self
         type(grid_t), intent(in) :: grid
         type(shape_data_t), intent(in) :: shape
         real(wp), contiguous, intent(in) :: nodes(:, :)        !! (3, node) Velocity [m/s]
         real(wp), intent(in) :: scale                          !! Factor, such as the step [s]
         !> (particle of the tile, 9) Component (k, l) in column k + 3 (l - 1)
         real(wp), contiguous, intent(inout) :: gradient(:, :)
      end subroutine gather_gradient_i
   end interface

contains

   !> Layers of nodes beyond a tile that its particles reach; default: none.
   pure integer function basis_margin(self) result(margin)
      class(basis_t), intent(in) :: self

      margin = 0
   end function basis_margin

   !> Integral over the box of the function of a node on a face, along the normal of that face, in
   !! cells; it is 1 on the face, and no other function is nonzero there.
   pure real(wp) function basis_at_wall(self) result(integral)
      class(basis_t), intent(in) :: self

      integral = 0.5_wp
   end function basis_at_wall

   !> Width in cells of the band that a crack opens across an edge of the grid: one if the gradient
   !! of a cell uses its own nodes only. Smoother gradients involve particles of adjacent cells;
   !! their widths are measured with a bar (test/verify/crack).
   pure real(wp) function basis_band_width(self) result(width)
      class(basis_t), intent(in) :: self

      width = 1.0_wp
   end function basis_band_width

   !> Are the functions the linear ones, which reach only the nodes of the own cell?
   pure logical function basis_is_linear(self) result(yes)
      class(basis_t), intent(in) :: self

      yes = .false.
   end function basis_is_linear

   !> May the mesh deform with a periodic cell? Fields of particles that follow the mesh forbid it.
   pure logical function basis_suits_cell(self) result(yes)
      class(basis_t), intent(in) :: self

      yes = .false.
   end function basis_suits_cell

   !> Declare the keys of &method that belong to the basis. Most have none.
   subroutine basis_declare(self, schema)
      class(basis_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema
   end subroutine basis_declare

   !> Request fields of particles. Most request none.
   pure subroutine basis_request(self, traits)
      class(basis_t), intent(in) :: self
      type(traits_t), intent(inout) :: traits
   end subroutine basis_request

   !> Linear velocity field around each particle: its gradient; a basis may override it.
   pure subroutine basis_gather_affine(self, grid, shape, nodes, affine)
      class(basis_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      type(shape_data_t), intent(in) :: shape
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (3, node) Velocity [m/s]
      real(wp), contiguous, intent(inout) :: affine(:, :)    !! (particle of the tile, 9) [1/s]

      call self%gather_gradient(grid, shape, nodes, 1.0_wp, affine)
   end subroutine basis_gather_affine

   !> Add mass and momentum to columns 1 to 4 of a patch.
   pure subroutine basis_scatter_motion(self, grid, shape, first, mass, velocity, patch)
      class(basis_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: first                           !! First particle of the tile
      type(shape_data_t), intent(inout) :: shape
      real(wp), contiguous, intent(in) :: mass(:)            !! (particle) [kg]
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (particle, 3) [m/s]
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)
      integer :: p, k

      do p = 1, shape%count
         shape%values(p, 1) = mass(first + p - 1)
      end do
      do k = 1, 3
         do p = 1, shape%count
            shape%values(p, 1 + k) = mass(first + p - 1)*velocity(first + p - 1, k)
         end do
      end do
      call self%scatter_values(grid, shape, 4, shape%values, 0, patch)
   end subroutine basis_scatter_motion

   !> Add mass and momentum of rotating particles, sum m S_i (v + w x (x_i - x)), to columns 1 to
   !! 4.
   pure subroutine basis_scatter_turning(self, grid, shape, first, mass, velocity, spin, patch)
      class(basis_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: first                           !! First particle of the tile
      type(shape_data_t), intent(inout) :: shape
      real(wp), contiguous, intent(in) :: mass(:)            !! (particle) [kg]
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (particle, 3) [m/s]
      real(wp), contiguous, intent(in) :: spin(:, :)         !! (particle, 3) w [1/s]
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)
      real(wp) :: tile_mass(shape%count)
      integer :: p, k, count

      count = shape%count
      do p = 1, count
         tile_mass(p) = mass(first + p - 1)
      end do
      do k = 1, 3
         do p = 1, count
            shape%vector(p, k) = velocity(first + p - 1, k)
         end do
      end do
      call shape%reserve_affine(count)
      call expand_spin(first, count, spin, shape%affine)
      call self%scatter_affine(grid, shape, 1, tile_mass, shape%vector, shape%affine, patch)
   end subroutine basis_scatter_turning

   !> Linear velocity fields of rotations.
   pure subroutine expand_spin(first, count, spin, affine)
      integer, intent(in) :: first                           !! First particle of the tile
      integer, intent(in) :: count                           !! Particles of the tile
      real(wp), contiguous, intent(in) :: spin(:, :)         !! (particle, 3) [1/s]
      real(wp), contiguous, intent(inout) :: affine(:, :)    !! (particle of the tile, 9) [1/s]
      integer :: p, q

      do p = 1, count
         q = first + p - 1
         affine(p, 1) = 0.0_wp
         affine(p, 2) = spin(q, 3)
         affine(p, 3) = -spin(q, 2)
         affine(p, 4) = -spin(q, 3)
         affine(p, 5) = 0.0_wp
         affine(p, 6) = spin(q, 1)
         affine(p, 7) = spin(q, 2)
         affine(p, 8) = -spin(q, 1)
         affine(p, 9) = 0.0_wp
      end do
   end subroutine expand_spin

   !> Add mass times a vector to three columns of a patch.
   pure subroutine basis_scatter_product(self, grid, shape, first, mass, vector, before, patch)
      class(basis_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: first                           !! First particle of the tile
      type(shape_data_t), intent(inout) :: shape
      real(wp), contiguous, intent(in) :: mass(:)            !! (particle) [kg]
      real(wp), contiguous, intent(in) :: vector(:, :)       !! (particle of the tile, 3)
      integer, intent(in) :: before                          !! Column offset in the patch
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)
      integer :: p, k

      do k = 1, 3
         do p = 1, shape%count
            shape%values(p, k) = mass(first + p - 1)*vector(p, k)
         end do
      end do
      call self%scatter_values(grid, shape, 3, shape%values, before, patch)
   end subroutine basis_scatter_product

   !> Add the force of the hoop stress in axisymmetry, - sum v sigma_yy S / r, to column 5. Equation
   !! (M.25) of doc/theory/method.md; with factors where sums are normalised.
   pure subroutine basis_scatter_hoop(self, grid, shape, first, position, volume, stress, patch)
      class(basis_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: first                           !! First particle of the tile
      type(shape_data_t), intent(inout) :: shape
      real(wp), contiguous, intent(in) :: position(:, :)     !! (particle, 3) Radius in column 1 [m]
      real(wp), contiguous, intent(in) :: volume(:)          !! (particle) [m3]
      real(wp), contiguous, intent(in) :: stress(:, :)       !! (particle, 6) [Pa]
      real(wp), contiguous, intent(inout) :: patch(:, :)     !! (column, node)
      integer :: p, q

      if (allocated(shape%factor)) then
         call scatter_factored_hoop(grid, shape%start, first, shape%local, shape%factor, position, &
            volume, stress, patch)
         return
      end if
      do p = 1, shape%count
         q = first + p - 1
         shape%values(p, 1) = -(volume(q)*stress(q, 2)/position(q, 1))
      end do
      call self%scatter_values(grid, shape, 1, shape%values, 4, patch)
   end subroutine basis_scatter_hoop

   !> Velocity and position together: velocity = f velocity + sum S_i increment_i, position =
   !! position + dt sum S_i advection_i, f the flip fraction.
   pure subroutine basis_gather_motion(self, grid, shape, first, increment, advection, &
      flip_fraction, dt, velocity, position)
      class(basis_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: first                           !! First particle of the tile
      type(shape_data_t), intent(inout) :: shape
      real(wp), contiguous, intent(in) :: increment(:, :)    !! (3, node) [m/s]
      real(wp), contiguous, intent(in) :: advection(:, :)    !! (3, node) [m/s]
      real(wp), intent(in) :: flip_fraction                  !! Fraction of the old velocity [1]
      real(wp), intent(in) :: dt                             !! Time step [s]
      real(wp), contiguous, intent(inout) :: velocity(:, :)  !! (particle, 3) [m/s]
      real(wp), contiguous, intent(inout) :: position(:, :)  !! (particle, 3) [m]

      call self%gather_vector(grid, shape, first, increment, flip_fraction, 1.0_wp, velocity)
      call self%gather_vector(grid, shape, first, advection, 1.0_wp, dt, position)
   end subroutine basis_gather_motion

   !> Particle vectors from node vectors: values = keep values + scale sum S_i nodes_i.
   pure subroutine basis_gather_vector(self, grid, shape, first, nodes, kept, scale, values)
      class(basis_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: first                           !! First particle of the tile
      type(shape_data_t), intent(inout) :: shape
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (3, node)
      real(wp), intent(in) :: kept                           !! Fraction of the old values [1]
      real(wp), intent(in) :: scale                          !! Factor of the node values
      real(wp), contiguous, intent(inout) :: values(:, :)    !! (particle, 3)
      integer :: p, k

      call self%gather_values(grid, shape, nodes, shape%values)
      do k = 1, 3
         do p = 1, shape%count
            values(first + p - 1, k) = kept*values(first + p - 1, k) + scale*shape%values(p, k)
         end do
      end do
   end subroutine basis_gather_vector

   !> Hoop rate of axisymmetry, scale u_r / r, into component (2, 2) of the gradient. Equation
   !! (M.25).
   pure subroutine basis_gather_hoop(self, grid, shape, first, position, nodes, scale, gradient)
      class(basis_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: first                           !! First particle of the tile
      type(shape_data_t), intent(inout) :: shape
      real(wp), contiguous, intent(in) :: position(:, :)     !! (particle, 3) Radius in column 1 [m]
      real(wp), contiguous, intent(in) :: nodes(:, :)        !! (3, node) Velocity [m/s]
      real(wp), intent(in) :: scale                          !! Time step [s]
      real(wp), contiguous, intent(inout) :: gradient(:, :)  !! (particle of the tile, 9)
      integer :: p

      call self%gather_values(grid, shape, nodes, shape%values)
      do p = 1, shape%count
         gradient(p, 5) = scale*shape%values(p, 1)/position(first + p - 1, 1)
      end do
   end subroutine basis_gather_hoop

   !> Heat from the kinetic energy that the transfer from nodes to particles dissipates.
   !!
   !! With a = sum S_i a_i dt, u = sum S_i u_i and r = v_p - u a step v_p <- v_p + a - g r, g the
   !! PIC fraction, loses per mass 1/2 var(a) + g (r.r + var(u) + cov(u, a)) - 1/2 g^2 r.r, where
   !! var and cov are those of the node values under the weights S_i. Terms that only carry energy
   !! from particle to particle, and add up to zero, are left out; the rest is not negative for g <=
   !! 1. Equation (T.6) of doc/theory/transfers.md.
   pure subroutine basis_gather_heat(self, grid, shape, first, nodes, share, velocity, energy)
      class(basis_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: first                           !! First particle of the tile
      type(shape_data_t), intent(inout) :: shape
      !> (7, node) a dt + g u [m/s]; u + a dt/2 [m/s]; 1/2 |a dt|^2 + g (|u|^2 + u . a dt) [J/kg]
      real(wp), contiguous, intent(in) :: nodes(:, :)
      real(wp), intent(in) :: share                          !! PIC fraction g
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (particle, 3) Before the step [m/s]
      real(wp), contiguous, intent(inout) :: energy(:)       !! (particle) [J/kg]
      real(wp) :: slow, gain, rest, heat
      integer :: p, q, k

      call self%gather_values(grid, shape, nodes, shape%values)
      !$omp simd private(q, k, slow, gain, rest, heat)
      do p = 1, shape%count
         q = first + p - 1
         heat = shape%values(p, 7)
         do k = 1, 3
            slow = (shape%values(p, 3 + k) - 0.5_wp*shape%values(p, k)) &
               *(1.0_wp/(1.0_wp - 0.5_wp*share))
            gain = shape%values(p, k) - share*slow
            rest = velocity(q, k) - slow
            heat = heat - 0.5_wp*gain*gain - share*(slow*slow + slow*gain) &
               + share*(1.0_wp - 0.5_wp*share)*(rest*rest)
         end do
         energy(q) = energy(q) + heat
      end do
   end subroutine basis_gather_heat
end module transfer_basis
