! SPDX-License-Identifier: BSD-3-Clause
!> Where the particles of a tile are, as the node functions see them; scratch space of a thread.
module transfer_shape_data
   use base_kinds, only: wp
   implicit none
   private

   public :: shape_data_t

   integer, parameter, public :: line = 4            !! Nodes along a line of a wide stencil

   !> Places of the particles of one tile. What the method does not need is not allocated.
   type :: shape_data_t
      real(wp), allocatable :: local(:, :)           !! (particle, 3) Place in its cell, 0 to 1
      real(wp), allocatable :: alpha(:, :)           !! (particle, 3) Share of the own cell
      real(wp), allocatable :: blend(:, :)           !! (particle, 3) Place with a smooth start
      !> (particle, node, direction) Functions of the nodes -1, 0, 1, 2 of the cell along a line
      real(wp), allocatable :: weight(:, :, :)
      real(wp), allocatable :: slope(:, :, :)        !! The same: their mean derivatives [1/m]
      integer, allocatable :: low(:, :)              !! (particle, 3) First node that counts, 1 or 2
      real(wp), allocatable :: whole(:, :, :)        !! The same as weight, of the dual gradient
      real(wp), allocatable :: share(:, :, :)        !! The same: alpha times derivative
      real(wp), allocatable :: rest(:, :, :)         !! The same: (1 - alpha) times function
      real(wp), allocatable :: corner(:, :, :)       !! (corner, direction, particle) In its cell
      integer, allocatable :: corner_node(:, :)      !! (corner, particle) First node of that cell
      real(wp), allocatable :: edge(:, :)            !! (9, particle) Half edges, one after another
      real(wp), allocatable :: inverse(:, :)         !! (9, particle) The inverse of their matrix
      !> (edge, cell) Factors of the part of the gradient on the cell, if sums are normalised [1]
      real(wp), allocatable :: factor(:, :)
      real(wp), allocatable :: vector(:, :)          !! (particle, 3) What is mapped
      real(wp), allocatable :: values(:, :)          !! (particle, 9) Between two steps of a map
      real(wp), allocatable :: affine(:, :)          !! (particle, 9) Linear velocity fields [1/s]
   contains
      procedure :: reserve => places_reserve         !! Room for the particles of a tile
      procedure :: reserve_wide => places_reserve_wide !! Room for wide stencils
      procedure :: reserve_affine => places_reserve_affine !! Room for linear velocity fields
      procedure :: reserve_corners => places_reserve_corners !! Room for corners
      procedure :: reserve_split => places_reserve_split !! Room for means of the dual gradient
   end type shape_data_t

contains

   !> Make room for a number of particles. What was there is lost.
   pure subroutine places_reserve(self, particles)
      class(shape_data_t), intent(inout) :: self         !! The scratch space
      integer, intent(in) :: particles               !! Most particles in a tile
      integer :: n

      if (allocated(self%local)) then
         if (size(self%local, 1) >= particles) return
         deallocate (self%local, self%alpha, self%blend, self%vector, self%values)
      end if
      n = room_for(particles)
      allocate (self%local(n, 3), self%alpha(n, 3), self%blend(n, 3), self%vector(n, 3), &
         self%values(n, 9))
   end subroutine places_reserve

   !> Make room for the functions of wide stencils. What was there is lost.
   pure subroutine places_reserve_wide(self, particles)
      class(shape_data_t), intent(inout) :: self         !! The scratch space
      integer, intent(in) :: particles               !! Most particles in a tile
      integer :: n

      if (allocated(self%weight)) then
         if (size(self%weight, 1) >= particles) return
         deallocate (self%weight, self%slope, self%low)
      end if
      n = room_for(particles)
      allocate (self%weight(n, line, 3), self%slope(n, line, 3), self%low(n, 3))
   end subroutine places_reserve_wide

   !> Make room for the corners of particles. What was there is lost.
   pure subroutine places_reserve_corners(self, particles, corners)
      class(shape_data_t), intent(inout) :: self         !! The scratch space
      integer, intent(in) :: particles               !! Most particles in a tile
      integer, intent(in) :: corners                 !! Corners of a particle
      integer :: n

      if (allocated(self%corner)) then
         if (size(self%corner, 3) >= particles) return
         deallocate (self%corner, self%corner_node, self%edge, self%inverse)
      end if
      n = room_for(particles)
      allocate (self%corner(corners, 3, n), self%corner_node(corners, n), self%edge(9, n), &
         self%inverse(9, n))
   end subroutine places_reserve_corners

   !> Make room for the two parts of the dual gradient. What was there is lost.
   pure subroutine places_reserve_split(self, particles)
      class(shape_data_t), intent(inout) :: self         !! The scratch space
      integer, intent(in) :: particles               !! Most particles in a tile
      integer :: n

      if (allocated(self%share)) then
         if (size(self%share, 1) >= particles) return
         deallocate (self%whole, self%share, self%rest)
      end if
      n = room_for(particles)
      allocate (self%whole(n, line, 3), self%share(n, line, 3), self%rest(n, line, 3))
   end subroutine places_reserve_split

   !> Make room for linear velocity fields. What was there is lost.
   pure subroutine places_reserve_affine(self, particles)
      class(shape_data_t), intent(inout) :: self         !! The scratch space
      integer, intent(in) :: particles               !! Most particles in a tile

      if (allocated(self%affine)) then
         if (size(self%affine, 1) >= particles) return
         deallocate (self%affine)
      end if
      allocate (self%affine(room_for(particles), 9))
   end subroutine places_reserve_affine

   !> Length of columns: not as long as the particles are many, since a length that is a power of
   !! two would put all columns into the same few places of the cache.
   pure integer function room_for(particles) result(room)
      integer, intent(in) :: particles               !! Particles of a tile

      room = 64*((particles + particles/4 + 63)/64) + 8
   end function room_for
end module transfer_shape_data
