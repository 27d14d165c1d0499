! SPDX-License-Identifier: BSD-3-Clause
!> Bodies to be made of particles, and where their particles come from if not from the lattice.
module particle_body
   use base_kinds, only: int64, wp
   use base_text, only: text_t
   use mesh_grid, only: grid_t
   use particle_shape, only: shape_holder_t
   implicit none
   private

   public :: belongs, body_t, cell_of, given_t, site_position, tile_sites

   !> Particles whose places are given rather than those of the lattice. Threads may ask side by
   !! side, and the answer must not depend on who asks.
   type, abstract :: given_t
      logical :: clipped = .true.                     !! Do those outside the region of the body go?
   contains
      procedure(numbers_i), deferred :: numbers       !! Numbers that its particles may have
      procedure(collect_i), deferred :: collect       !! The particles of a tile
   end type given_t

   abstract interface
      pure function numbers_i(self, grid) result(numbers)
         import :: given_t, grid_t, int64
         implicit none
         class(given_t), intent(in) :: self           !! The particles
         type(grid_t), intent(in) :: grid             !! The grid
         integer(int64) :: numbers(3)                 !! Their product is the greatest number
      end function numbers_i

      pure subroutine collect_i(self, grid, coordinate, position, volume, number)
         import :: given_t, grid_t, int64, wp
         implicit none
         class(given_t), intent(in) :: self           !! The particles
         type(grid_t), intent(in) :: grid             !! The grid
         integer, intent(in) :: coordinate(3)         !! Tile, counted from 0
         real(wp), allocatable, intent(out) :: position(:, :) !! (3, particle) [m]
         real(wp), allocatable, intent(out) :: volume(:) !! (particle) Or a share of the body's [m3]
         integer(int64), allocatable, intent(out) :: number(:) !! (particle) From 1, each once
      end subroutine collect_i
   end interface

   !> A body to be made of particles.
   type :: body_t
      character(len=:), allocatable :: name           !! For messages and files
      type(shape_holder_t) :: shape                   !! Where it is
      class(given_t), allocatable :: given            !! Its particles, if not those of the lattice
      integer :: store = 1                            !! Index of its material
      integer :: per_cell(3) = 1                      !! Particles along each edge of a cell
      !> Do sites at the surface hold what is inside?
      logical :: cut = .false.
      logical :: jitter = .false.                     !! Are particles moved aside by chance?
      real(wp) :: density = 0.0_wp                    !! [kg/m3]
      real(wp) :: velocity(3) = 0.0_wp                !! [m/s]
      real(wp) :: spin(3) = 0.0_wp                    !! About its centre of mass [rad/s]
      !> (3) Formulas of velocities that are added, if there are any
      type(text_t), allocatable :: formula(:)
      real(wp) :: temperature = 0.0_wp                !! [K]
      real(wp) :: energy = 0.0_wp                     !! Internal, per mass, at the start [J/kg]
      integer :: region = 0                           !! Number of its region
      logical :: keeps_stress = .false.               !! Is its stress that of a file?
      !> Stress across gravity over that along it, from its weight; below 0 without stress [1]
      real(wp) :: lateral = -1.0_wp
      real(wp) :: share = 1.0_wp                      !! Factor of the volumes of given particles
      integer(int64) :: first_identity = 1            !! Identity of the first site of the box
   contains
      procedure :: sites => body_sites                !! Sites of the whole box
      procedure :: on_lattice => body_on_lattice      !! Do its particles stand for lattice sites?
   end type body_t

contains

   !> Lattice sites of the whole box, along each direction; of given particles the numbers that they
   !! may have.
   pure function body_sites(self, grid) result(sites)
      class(body_t), intent(in) :: self               !! The body
      type(grid_t), intent(in) :: grid                !! The grid
      integer(int64) :: sites(3)

      sites = 1
      if (allocated(self%given)) then
         sites = self%given%numbers(grid)
      else
         where (grid%active) sites = int(grid%cells, int64)*self%per_cell
      end if
   end function body_sites

   !> True if each particle stands for a site of the lattice.
   pure logical function body_on_lattice(self) result(yes)
      class(body_t), intent(in) :: self               !! The body

      yes = .not. allocated(self%given)
   end function body_on_lattice

   !> Lattice sites of one tile along each direction.
   pure function tile_sites(grid, body, coordinate) result(sites)
      type(grid_t), intent(in) :: grid                !! The grid
      type(body_t), intent(in) :: body                !! The body
      integer, intent(in) :: coordinate(3)            !! Tile, counted from 0
      integer :: sites(3)

      sites = 1
      where (grid%active) sites = grid%tile_extent(coordinate)*body%per_cell
   end function tile_sites

   !> Position of a lattice site [m]. In missing directions it is the middle of the box, on the axis
   !! plane 0 in axisymmetry.
   pure function site_position(grid, body, coordinate, site) result(position)
      type(grid_t), intent(in) :: grid                !! The grid
      type(body_t), intent(in) :: body                !! The body
      integer, intent(in) :: coordinate(3)            !! Tile, counted from 0
      integer, intent(in) :: site(3)                  !! Site in the tile, counted from 0
      real(wp) :: position(3)

      position = merge(0.0_wp, 0.5_wp*(grid%lower + grid%upper), grid%axisymmetric)
      where (grid%active) position = grid%lower + grid%spacing*(real(coordinate*grid%width, wp) &
         + (real(site, wp) + 0.5_wp)/real(body%per_cell, wp))
   end function site_position

   !> Cell of the box that a place lies in, counted from 0; places beyond a face belong to its cell.
   pure function cell_of(grid, position) result(cell)
      type(grid_t), intent(in) :: grid                !! The grid
      real(wp), intent(in) :: position(3)             !! [m]
      integer :: cell(3)

      cell = 0
      where (grid%active) cell = max(min(floor(max(min((position - grid%lower) &
         *(1.0_wp/grid%spacing), real(grid%cells, wp)), -1.0_wp)), grid%cells - 1), 0)
   end function cell_of

   !> True if a place belongs to a body and to no later one.
   pure logical function belongs(bodies, body, position) result(inside)
      type(body_t), intent(in) :: bodies(:)           !! The bodies
      integer, intent(in) :: body                     !! Which body
      real(wp), intent(in) :: position(3)             !! [m]
      integer :: later
      logical :: clipped

      clipped = .true.
      if (allocated(bodies(body)%given)) clipped = bodies(body)%given%clipped
      inside = .true.
      if (clipped) inside = bodies(body)%shape%contains(position)
      do later = body + 1, size(bodies)
         if (.not. inside) return
         inside = .not. bodies(later)%shape%contains(position)
      end do
   end function belongs
end module particle_body
