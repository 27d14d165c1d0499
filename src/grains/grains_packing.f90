! SPDX-License-Identifier: BSD-3-Clause
!> First states of a cell: grains at random without overlap, and perfect lattices.
module grains_packing
   use base_kinds, only: int64, wp
   use base_random, only: random_bits, random_normal, random_uniform
   use base_sort, only: sort_order
   use grains_cell, only: cell_t
   use grains_state, only: grain_mass
   implicit none
   private

   public :: fill_lattice, fill_random, grain_radii, set_masses

   !> Draws of random numbers of a grain.
   integer(int64), parameter :: of_size = 1, of_site = 2, of_place = 2, of_velocity = 6

contains

   !> Radii of grains: uniform in diameter, or two sizes of equal number.
   pure subroutine grain_radii(seed, diameter, spread, two_sizes, radius)
      integer(int64), intent(in) :: seed             !! Seed of the random numbers
      real(wp), intent(in) :: diameter               !! Mean [m]
      real(wp), intent(in) :: spread                 !! Half the range over the mean, or of the two
      logical, intent(in) :: two_sizes               !! Only the ends of the range?
      real(wp), intent(out) :: radius(:)             !! (grain) [m]
      integer(int64) :: key(size(radius))
      integer :: order(size(radius)), n, count

      count = size(radius)
      key = [(random_bits(seed, int(n, int64), of_size)/2_int64, n=1, count)]
      order = sort_order(key)
      do n = 1, count
         ! diameters are spaced evenly, not drawn at random, so that their mean is exact
         if (two_sizes) then
            radius(order(n)) = 0.5_wp*diameter*(1.0_wp + spread*merge(1.0_wp, -1.0_wp, &
               2*n > count))
         else
            radius(order(n)) = 0.5_wp*diameter*(1.0_wp + spread*(real(2*n - 1, wp) &
               /real(count, wp) - 1.0_wp))
         end if
      end do
   end subroutine grain_radii

   !> Masses, moments of inertia and the volume of all grains, from their radii.
   pure subroutine set_masses(cell)
      type(cell_t), intent(inout) :: cell
      integer :: row

      do row = 1, cell%grains%count
         call grain_mass(cell%box%dimension, cell%density, cell%grains%radius(row), &
            cell%grains%mass(row), cell%grains%inertia(row))
      end do
      cell%solid = cell%grains%solid_volume(cell%box%dimension)
   end subroutine set_masses

   !> Put grains on a square or cubic lattice in random order, shifted at random without overlap,
   !! with random velocities and no mean momentum.
   pure subroutine fill_random(seed, fraction, aspect, speed, cell)
      integer(int64), intent(in) :: seed             !! Seed of the random numbers
      real(wp), intent(in) :: fraction               !! Solid volume over cell volume [1]
      real(wp), intent(in) :: aspect(3)              !! Edges of the cell relative to each other
      real(wp), intent(in) :: speed                  !! Root of the mean square of a component [m/s]
      type(cell_t), intent(inout) :: cell            !! With radii and masses; gets edges
      real(wp) :: edge(3), spacing(3), free(3), drift(3)
      integer(int64) :: key(cell%grains%count), identity
      integer :: order(cell%grains%count), sites(3), site(3), n, axis, number

      call choose_edges(cell, fraction, aspect, edge, sites)
      spacing = edge/real(sites, wp)
      free = max(0.0_wp, 0.5_wp*spacing - maxval(cell%grains%radius))
      key = [(random_bits(seed, int(n, int64), of_site)/2_int64, &
         n=1, cell%grains%count)]
      order = sort_order(key)
      do n = 1, cell%grains%count
         ! sites are spread over the lattice where there are more of them than grains
         number = int(int(n - 1, int64)*product(int(sites, int64))/cell%grains%count)
         site = [mod(number, sites(1)), mod(number/sites(1), sites(2)), &
            number/(sites(1)*sites(2))]
         identity = order(n)
         do axis = 1, cell%box%dimension
            cell%grains%place(axis, order(n)) = ((real(site(axis), wp) + 0.5_wp)*spacing(axis) &
               + free(axis)*(2.0_wp*random_uniform(seed, identity, of_place + axis) &
               - 1.0_wp))/edge(axis)
            cell%grains%velocity(axis, order(n)) = speed*random_normal(seed, identity, &
               of_velocity + axis)
         end do
      end do
      do axis = 1, 3
         drift(axis) = sum(cell%grains%mass*cell%grains%velocity(axis, :))/sum(cell%grains%mass)
         cell%grains%velocity(axis, :) = cell%grains%velocity(axis, :) - drift(axis)
      end do
   end subroutine fill_random

   !> Lengths of the cell edges for a volume fraction, and numbers of lattice sites along them.
   pure subroutine choose_edges(cell, fraction, aspect, edge, sites)
      type(cell_t), intent(inout) :: cell
      real(wp), intent(in) :: fraction               !! [1]
      real(wp), intent(in) :: aspect(3)              !! Edges relative to each other
      real(wp), intent(out) :: edge(3)               !! [m]
      integer, intent(out) :: sites(3)
      real(wp) :: spacing, volume
      integer :: axis, d

      d = cell%box%dimension
      volume = cell%solid/fraction
      edge = 1.0_wp
      edge(:d) = aspect(:d)*(volume/product(aspect(:d)))**(1.0_wp/real(d, wp))
      spacing = (volume/real(cell%grains%count, wp))**(1.0_wp/real(d, wp))
      sites = 1
      do axis = 1, d
         sites(axis) = max(1, nint(edge(axis)/spacing))
      end do
      do while (product(int(sites, int64)) < cell%grains%count)
         axis = maxloc(edge(:d)/real(sites(:d), wp), dim=1)
         sites(axis) = sites(axis) + 1
      end do
      cell%box%edges = 0.0_wp
      do axis = 1, 3
         cell%box%edges(axis, axis) = edge(axis)
      end do
   end subroutine choose_edges

   !> Fill the cell with a triangular lattice of discs, rows along x, or a face-centred cubic one of
   !! spheres whose neighbours are `spacing` apart.
   pure subroutine fill_lattice(number, spacing, cell)
      integer, intent(in) :: number(3)               !! Number of rectangular cells of the lattice
      real(wp), intent(in) :: spacing                !! Between neighbours [m]
      type(cell_t), intent(inout) :: cell !! With capacity for 2 or 4 grains a lattice cell
      real(wp), parameter :: discs(3, 2) = reshape([0.0_wp, 0.0_wp, 0.0_wp, 0.5_wp, 0.5_wp, &
         0.0_wp], [3, 2])
      real(wp), parameter :: spheres(3, 4) = reshape([0.0_wp, 0.0_wp, 0.0_wp, 0.5_wp, 0.5_wp, &
         0.0_wp, 0.5_wp, 0.0_wp, 0.5_wp, 0.0_wp, 0.5_wp, 0.5_wp], [3, 4])
      integer :: i, j, k, row

      cell%box%edges = 0.0_wp
      cell%box%edges(1, 1) = real(number(1), wp)*spacing
      cell%box%edges(2, 2) = real(number(2), wp)*spacing*sqrt(3.0_wp)
      cell%box%edges(3, 3) = 1.0_wp
      if (cell%box%dimension == 3) then
         do i = 1, 3
            cell%box%edges(i, i) = real(number(i), wp)*spacing*sqrt(2.0_wp)
         end do
      end if
      row = 0
      do k = 0, number(3) - 1
         do j = 0, number(2) - 1
            do i = 0, number(1) - 1
               if (cell%box%dimension == 2) then
                  cell%grains%place(:, row + 1:row + 2) = in_cell(discs, [i, j, k], number)
                  row = row + 2
               else
                  cell%grains%place(:, row + 1:row + 4) = in_cell(spheres, [i, j, k], number)
                  row = row + 4
               end if
            end do
         end do
      end do
   end subroutine fill_lattice

   !> Coordinates of the sites of one lattice cell.
   pure function in_cell(sites, cell, number) result(place)
      real(wp), intent(in) :: sites(:, :)            !! (axis, site) In the lattice cell
      integer, intent(in) :: cell(3), number(3)      !! Index of the cell, number of cells
      real(wp) :: place(3, size(sites, 2))
      integer :: n

      do n = 1, size(sites, 2)
         place(:, n) = (real(cell, wp) + sites(:, n) + 0.25_wp)/real(number, wp)
      end do
   end function in_cell
end module grains_packing
