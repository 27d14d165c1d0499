! SPDX-License-Identifier: BSD-3-Clause
!> Bodies to be filled with particles, on the lattice or at given positions.
module particle_body
   use base_constants, only: pi
   use base_elementary, only: power
   use base_kinds, only: int64, wp
   use base_text, only: text_t
   use mesh_grid, only: grid_t
   use particle_shape, only: shape_holder_t
   implicit none
   private

   public :: belongs, body_t, cell_of, find_box, find_boxes, find_near, given_t, site_position, &
      tile_sites

   !> Particles at given positions instead of lattice sites. Threads call these procedures
   !! concurrently, so the result must depend on the arguments alone.
   type, abstract :: given_t
      logical :: clipped = .true. !! Are those outside the body's region dropped?
   contains
      procedure(numbers_i), deferred :: numbers       !! Number of possible identities
      procedure(collect_i), deferred :: collect       !! The particles of a tile
   end type given_t

   abstract interface
      pure function numbers_i(self, grid) result(numbers)
         import :: given_t, grid_t, int64
         implicit none
         class(given_t), intent(in) :: self
         type(grid_t), intent(in) :: grid
         integer(int64) :: numbers(3)                 !! Their product is the greatest number
      end function numbers_i

      pure subroutine collect_i(self, grid, coordinate, position, volume, number)
         import :: given_t, grid_t, int64, wp
         implicit none
         class(given_t), intent(in) :: self
         type(grid_t), intent(in) :: grid
         integer, intent(in) :: coordinate(3)         !! Tile, counted from 0
         real(wp), allocatable, intent(out) :: position(:, :) !! (3, particle) [m]
         real(wp), allocatable, intent(out) :: volume(:) !! (particle) Or relative weights [m3]
         integer(int64), allocatable, intent(out) :: number(:) !! (particle) From 1, each once
      end subroutine collect_i
   end interface

   !> State of the particles of a body at the start.
   type :: initial_state_t
      real(wp) :: density = 0.0_wp                    !! [kg/m3]
      real(wp) :: velocity(3) = 0.0_wp                !! [m/s]
      real(wp) :: spin(3) = 0.0_wp                    !! About its centre of mass [rad/s]
      !> (3) Formulas of additional velocities, if any
      type(text_t), allocatable :: formula(:)
      real(wp) :: temperature = 0.0_wp                !! [K]
      real(wp) :: energy = 0.0_wp                     !! Internal, per mass [J/kg]
      logical :: keeps_stress = .false.               !! Is its stress read from a file?
      !> Ratio of lateral to vertical stress under its weight; below 0: no initial stress [1]
      real(wp) :: lateral = -1.0_wp
   end type initial_state_t

   !> A body to be filled with particles.
   type, extends(initial_state_t) :: body_t
      character(len=:), allocatable :: name           !! For messages and files
      type(shape_holder_t) :: shape                   !! Region of the body
      class(given_t), allocatable :: given !! Particles of the body, if not on the lattice
      integer :: store = 1                            !! Index of its material
      integer :: per_cell(3) = 2                      !! Particles along each edge of a cell
      logical :: cut = .false.                        !! Are sites at the surface cut by it?
      logical :: jitter = .false.                     !! Are particles displaced at random?
      integer :: region = 0                           !! Number of its region
      real(wp) :: share = 1.0_wp                      !! Factor of the volumes of given particles
      integer(int64) :: first_identity = 1            !! Identity of the first site of the domain
   contains
      procedure :: sites => body_sites                !! Sites of the whole domain
      procedure :: on_lattice => body_on_lattice      !! Are its particles on lattice sites?
   end type body_t

contains

   !> Lattice sites of the whole domain along each direction; for given particles, the number of
   !! possible identities.
   pure function body_sites(self, grid) result(sites)
      class(body_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer(int64) :: sites(3)

      sites = 1
      if (allocated(self%given)) then
         sites = self%given%numbers(grid)
      else
         where (grid%active) sites = int(grid%cells, int64)*self%per_cell
      end if
   end function body_sites

   !> True if each particle is on a site of the lattice.
   pure logical function body_on_lattice(self) result(yes)
      class(body_t), intent(in) :: self

      yes = .not. allocated(self%given)
   end function body_on_lattice

   !> Lattice sites of one tile along each direction.
   pure function tile_sites(grid, body, coordinate) result(sites)
      type(grid_t), intent(in) :: grid
      type(body_t), intent(in) :: body
      integer, intent(in) :: coordinate(3)            !! Tile, counted from 0
      integer :: sites(3)

      sites = 1
      where (grid%active) sites = grid%tile_extent(coordinate)*body%per_cell
   end function tile_sites

   !> Position of a lattice site [m]. In missing directions it is the middle of the domain; in
   !! axisymmetry it is 0.
   pure function site_position(grid, body, coordinate, site) result(position)
      type(grid_t), intent(in) :: grid
      type(body_t), intent(in) :: body
      integer, intent(in) :: coordinate(3)            !! Tile, counted from 0
      integer, intent(in) :: site(3)                  !! Site in the tile, counted from 0
      real(wp) :: position(3)

      position = merge(0.0_wp, 0.5_wp*(grid%lower + grid%upper), grid%axisymmetric)
      where (grid%active) position = grid%lower + grid%spacing*(real(coordinate*grid%width, wp) &
         + (real(site, wp) + 0.5_wp)/real(body%per_cell, wp))
   end function site_position

   !> Box that a particle fills at the start: its lattice site, also if the particle is displaced in
   !! it; the part of a cut site as a similar box around the particle; a cube for given particles.
   !! Lattice sites fill the body without gaps. In missing directions both corners are 0.
   pure subroutine find_box(grid, body, identity, position, volume, low, high)
      type(grid_t), intent(in) :: grid
      type(body_t), intent(in) :: body
      integer(int64), intent(in) :: identity          !! Of the particle
      real(wp), intent(in) :: position(3)             !! Of the particle [m]
      real(wp), intent(in) :: volume                  !! Of the particle [m3]
      real(wp), intent(out) :: low(3), high(3)        !! Corners of the box [m]
      real(wp) :: edge(3), depth
      integer(int64) :: sites(3), number, site(3)

      low = 0.0_wp
      high = 0.0_wp
      edge = 1.0_wp
      if (.not. allocated(body%given)) edge = grid%spacing/real(body%per_cell, wp)
      if (body%cut .or. allocated(body%given)) then
         depth = merge(2.0_wp*pi*position(1), grid%depth, grid%axisymmetric)
         edge = 0.5_wp*edge*power(volume/(depth*product(edge, mask=grid%active)), &
            1.0_wp/real(grid%dimensions, wp))
         where (grid%active)
            low = position - edge
            high = position + edge
         end where
         return
      end if
      sites = body%sites(grid)
      number = identity - body%first_identity
      site = [modulo(number, sites(1)), modulo(number/sites(1), sites(2)), &
         number/(sites(1)*sites(2))]
      where (grid%active)
         low = grid%lower + edge*real(site, wp)
         high = grid%lower + edge*real(site + 1_int64, wp)
      end where
   end subroutine find_box

   !> Cell of a position, counted from 0; positions outside the domain belong to the nearest cell.
   pure function cell_of(grid, position) result(cell)
      type(grid_t), intent(in) :: grid
      real(wp), intent(in) :: position(3)             !! [m]
      integer :: cell(3)

      cell = 0
      where (grid%active) cell = max(min(floor(max(min((position - grid%lower) &
         *(1.0_wp/grid%spacing), real(grid%cells, wp)), -1.0_wp)), grid%cells - 1), 0)
   end function cell_of

   !> Boxes around the shapes of bodies, a little larger than these, and unbounded for bodies of
   !! given particles, which may be outside of their shape.
   pure subroutine find_boxes(grid, bodies, low, high)
      type(grid_t), intent(in) :: grid
      type(body_t), intent(in) :: bodies(:)
      real(wp), allocatable, intent(out) :: low(:, :) !! (direction, body) [m]
      real(wp), allocatable, intent(out) :: high(:, :) !! (direction, body) [m]
      real(wp), parameter :: margin = 1.0e-3_wp       ! cells, against rounding
      integer :: body

      allocate (low(3, size(bodies)), high(3, size(bodies)))
      do body = 1, size(bodies)
         call bodies(body)%shape%bounds(low(:, body), high(:, body))
         low(:, body) = low(:, body) - margin*grid%spacing
         high(:, body) = high(:, body) + margin*grid%spacing
         if (.not. allocated(bodies(body)%given)) cycle
         low(:, body) = -huge(1.0_wp)
         high(:, body) = huge(1.0_wp)
      end do
   end subroutine find_boxes

   !> List the bodies whose boxes touch a tile, in their order. Only they can have particles in it.
   !! A tile at a boundary of the domain is unbounded there, because its cells also contain material
   !! outside.
   pure subroutine find_near(grid, low, high, coordinate, near, number)
      type(grid_t), intent(in) :: grid
      real(wp), contiguous, intent(in) :: low(:, :)   !! (direction, body) From `find_boxes` [m]
      real(wp), contiguous, intent(in) :: high(:, :)  !! (direction, body) [m]
      integer, intent(in) :: coordinate(3)            !! Tile, counted from 0
      integer, intent(inout) :: near(:)               !! The first ones are bodies
      integer, intent(out) :: number                  !! Bodies in the list
      real(wp) :: edge(3), upper(3)
      integer :: extent(3)
      integer :: body, k
      logical :: touches

      edge = grid%tile_corner(coordinate)
      extent = grid%tile_extent(coordinate)
      upper = edge + extent*grid%spacing
      where (coordinate == 0) edge = -huge(1.0_wp)
      where (coordinate*grid%width + extent >= grid%cells) upper = huge(1.0_wp)
      number = 0
      do body = 1, size(low, 2)
         touches = .true.
         do k = 1, 3
            if (grid%active(k)) touches = touches .and. edge(k) <= high(k, body) .and. &
               upper(k) >= low(k, body)
         end do
         if (.not. touches) cycle
         number = number + 1
         near(number) = body
      end do
   end subroutine find_near

   !> True if a position is inside a body and in no later body.
   pure logical function belongs(bodies, body, position, later) result(inside)
      type(body_t), intent(in) :: bodies(:)
      integer, intent(in) :: body
      real(wp), intent(in) :: position(3)             !! [m]
      integer, intent(in) :: later(:)                 !! Later bodies near it, by `find_near`
      integer :: n
      logical :: clipped

      clipped = .true.
      if (allocated(bodies(body)%given)) clipped = bodies(body)%given%clipped
      inside = .true.
      if (clipped) inside = bodies(body)%shape%contains(position)
      do n = 1, size(later)
         if (.not. inside) return
         inside = .not. bodies(later(n))%shape%contains(position)
      end do
   end function belongs
end module particle_body
