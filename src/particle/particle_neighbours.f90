! SPDX-License-Identifier: BSD-3-Clause
!> Distances between particles that were adjacent on the lattice of their body at the start.
!!
!! An identity is the number of a lattice site, so the neighbours of a particle are found by their
!! identities, without any field and without cost in a step. Adjacent bodies of one material on one
!! lattice count as one, unless they have contact. Pairs are searched within a tile, so that nothing
!! depends on ranks. Where particles have edges (CPDI, splitting) these are used instead.
module particle_neighbours
   use base_kinds, only: int64, wp
   use mesh_grid, only: grid_t
   use particle_store, only: store_t
   implicit none
   private

   public :: lattice_t, neighbour_table_t, shortest_longest

   !> The lattice sites of a body, numbered through the whole domain.
   type :: lattice_t
      integer(int64) :: first = 1                    !! Identity of the first site
      integer(int64) :: origin = 1                   !! First site of the first body on this lattice
      integer(int64) :: sites(3) = 1                 !! Along each direction
      logical :: regular = .false.                   !! Are its particles on the lattice?
   end type lattice_t

   !> Finds particles of a tile by their identities.
   type :: neighbour_table_t
      integer :: size = 0                            !! Entries in use, odd
      integer, allocatable :: entry(:)               !! Particle of the tile, 0 = empty
      integer, allocatable :: body(:) !! (particle of the tile) Body, whose lattice is used
      integer(int64), allocatable :: key(:)          !! (particle of the tile) Its site, < 0 = none
   contains
      procedure :: lengths => table_lengths          !! Longest distances to lattice neighbours
      procedure, private :: fill => table_fill       !! Insert the particles of a tile
      procedure, private :: find => table_find       !! The particle at a site
   end type neighbour_table_t

contains

   !> Longest vector of the shortest basis that the neighbours of each particle of a tile span. The
   !! basis is reduced because shear separates old neighbours and brings others close. Unknown where
   !! a neighbour is in another tile. Equation (P.5) of
   !! doc/theory/splitting.md.
   pure subroutine table_lengths(self, grid, lattices, store, tile, length)
      class(neighbour_table_t), intent(inout) :: self !! Scratch space
      type(grid_t), intent(in) :: grid
      type(lattice_t), intent(in) :: lattices(:)     !! (body) In the order of identities
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile
      real(wp), intent(out) :: length(:)             !! (particle of the tile) < 0 = unknown [m]
      real(wp) :: edge(3, 3)
      integer :: p, edges

      length = -1.0_wp
      if (.not. allocated(store%domain)) call self%fill(lattices, store, tile)
      do p = 1, store%count(tile)
         if (allocated(store%state%failed)) then
            if (store%state%failed(store%first(tile) + p - 1) /= 0) cycle
         end if
         if (allocated(store%domain)) then
            call own_edges(grid, store, store%first(tile) + p - 1, edge)
            edges = grid%dimensions
         else
            call edges_between(self, grid, lattices, store, tile, p, edge, edges)
         end if
         if (edges == grid%dimensions) length(p) = shortest_longest(edge(:, :edges))
      end do
   end subroutine table_lengths

   !> Insert the particles of a tile that have not failed.
   pure subroutine table_fill(self, lattices, store, tile)
      class(neighbour_table_t), intent(inout) :: self
      type(lattice_t), intent(in) :: lattices(:)     !! (body) In the order of identities
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile
      integer :: p, place

      self%size = 2*store%count(tile) + 1
      if (allocated(self%entry)) then
         if (size(self%entry) < self%size) deallocate (self%entry, self%body, self%key)
      end if
      if (.not. allocated(self%entry)) allocate (self%entry(2*self%size), &
         self%body(2*self%size), self%key(2*self%size))
      self%entry(:self%size) = 0
      do p = 1, store%count(tile)
         associate (identity => store%identity(store%first(tile) + p - 1))
            self%body(p) = body_of(lattices, identity)
            self%key(p) = identity - lattices(self%body(p))%first + lattices(self%body(p))%origin
         end associate
         if (.not. lattices(self%body(p))%regular) self%key(p) = -1
         if (allocated(store%state%failed)) then
            if (store%state%failed(store%first(tile) + p - 1) /= 0) self%key(p) = -1
         end if
         if (self%key(p) < 0) cycle
         place = place_of(self, self%key(p))
         do while (self%entry(place) > 0)
            place = mod(place, self%size) + 1
         end do
         self%entry(place) = p
      end do
   end subroutine table_fill

   !> The body of a particle, by bisection.
   pure integer function body_of(lattices, identity) result(body)
      type(lattice_t), intent(in) :: lattices(:)     !! (body) In the order of identities
      integer(int64), intent(in) :: identity         !! Identity of a particle
      integer :: last, middle

      body = 1
      last = size(lattices)
      do while (body < last)
         middle = (body + last + 1)/2
         if (identity >= lattices(middle)%first) then
            body = middle
         else
            last = middle - 1
         end if
      end do
   end function body_of

   !> Entry at which the search for a site begins.
   pure integer function place_of(table, key) result(place)
      class(neighbour_table_t), intent(in) :: table
      integer(int64), intent(in) :: key

      place = int(mod(key, int(table%size, int64))) + 1
   end function place_of

   !> Particle of the tile at a site, 0 if there is none.
   pure integer function table_find(self, key) result(particle)
      class(neighbour_table_t), intent(in) :: self
      integer(int64), intent(in) :: key
      integer :: place

      place = place_of(self, key)
      do
         particle = self%entry(place)
         if (particle == 0) return
         if (self%key(particle) == key) return
         place = mod(place, self%size) + 1
      end do
   end function table_find

   !> Edges of the domain of a particle.
   pure subroutine own_edges(grid, store, p, edge)
      type(grid_t), intent(in) :: grid
      type(store_t), intent(in) :: store
      integer, intent(in) :: p
      real(wp), intent(out) :: edge(3, 3)            !! (component, edge) [m]
      integer :: k, l, edges

      edge = 0.0_wp
      edges = 0
      do k = 1, 3
         if (.not. grid%active(k)) cycle
         edges = edges + 1
         do l = 1, 3
            if (grid%active(l)) edge(l, edges) = 2.0_wp*store%domain(p, 3*(k - 1) + l)
         end do
      end do
   end subroutine own_edges

   !> Vectors from a particle to one neighbour along each direction of its lattice, the upper one if
   !! the tile has it.
   pure subroutine edges_between(table, grid, lattices, store, tile, p, edge, edges)
      type(neighbour_table_t), intent(in) :: table   !! Filled
      type(grid_t), intent(in) :: grid
      type(lattice_t), intent(in) :: lattices(:)     !! (body) In the order of identities
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile
      integer, intent(in) :: p                       !! Particle of the tile
      real(wp), intent(out) :: edge(3, 3)            !! (component, edge) [m]
      integer, intent(out) :: edges                  !! Neighbours found
      integer(int64) :: number, stride
      integer :: k, q
      real(wp) :: sign

      edge = 0.0_wp
      edges = 0
      if (table%key(p) < 0) return
      stride = 1
      associate (lattice => lattices(table%body(p)))
         do k = 1, 3
            if (grid%active(k)) then
               number = mod((table%key(p) - lattice%origin)/stride, lattice%sites(k))
               q = 0
               sign = 1.0_wp
               if (number + 1 < lattice%sites(k)) q = table%find(table%key(p) + stride)
               if (q == 0 .and. number > 0) then
                  q = table%find(table%key(p) - stride)
                  sign = -1.0_wp
               end if
               if (q == 0) return
               edges = edges + 1
               edge(:, edges) = sign*separation_vector(grid, store, store%first(tile) + p - 1, &
                  store%first(tile) + q - 1)
            end if
            stride = stride*lattice%sites(k)
         end do
      end associate
   end subroutine edges_between

   !> Vector from one particle to another, the shortest one in periodic directions [m].
   pure function separation_vector(grid, store, from, to) result(way)
      type(grid_t), intent(in) :: grid
      type(store_t), intent(in) :: store
      integer, intent(in) :: from
      integer, intent(in) :: to
      real(wp) :: way(3), length
      integer :: k

      do k = 1, 3
         way(k) = 0.0_wp
         if (.not. grid%active(k)) cycle
         way(k) = store%position(to, k) - store%position(from, k)
         length = grid%upper(k) - grid%lower(k)
         if (grid%periodic(k)) way(k) = way(k) - length*anint(way(k)/length)
      end do
   end function separation_vector

   !> Length of the longest vector of the shortest basis of a lattice, given any basis. Vectors are
   !! shortened by integer multiples of each other until none gets shorter (C. F. Gauss,
   !! Disquisitiones Arithmeticae (1801); in space by pairs, and by all sums and differences of the
   !! others).
   pure real(wp) function shortest_longest(edge) result(length)
      real(wp), intent(in) :: edge(:, :)             !! (component, vector) One to three vectors [m]
      integer, parameter :: most = 60                ! sweeps; shears of 1e15 need fewer
      real(wp) :: basis(3, size(edge, 2))
      integer :: sweep
      logical :: shorter

      if (nearly_square(edge)) then
         length = sqrt(maxval(sum(edge**2, dim=1)))
         return
      end if
      basis = edge
      do sweep = 1, most
         shorter = .false.
         call shorten_pairs(basis, shorter)
         if (size(basis, 2) == 3) call shorten_third(basis, shorter)
         if (.not. shorter) exit
      end do
      length = sqrt(maxval(sum(basis**2, dim=1)))
   end function shortest_longest

   !> True if vectors are so nearly orthogonal that none can be shortened. With products
   !! of at most a quarter of the lesser square neither pairs nor sums of three become shorter.
   pure logical function nearly_square(edge) result(square)
      real(wp), intent(in) :: edge(:, :)             !! (component, vector) [m]
      real(wp) :: squares(3)
      integer :: i, j

      square = .true.
      do i = 1, size(edge, 2)
         squares(i) = edge(1, i)**2 + edge(2, i)**2 + edge(3, i)**2
         do j = 1, i - 1
            square = square .and. 4.0_wp*abs(edge(1, i)*edge(1, j) + edge(2, i)*edge(2, j) &
               + edge(3, i)*edge(3, j)) <= min(squares(i), squares(j))
         end do
      end do
   end function nearly_square

   !> Subtract from each vector the integer multiple of each other vector that makes it shortest.
   pure subroutine shorten_pairs(basis, shorter)
      real(wp), intent(inout) :: basis(:, :)         !! (component, vector) [m]
      logical, intent(inout) :: shorter              !! Has a vector become shorter?
      real(wp) :: other(3), square
      integer :: i, j, k

      do i = 1, size(basis, 2)
         do j = 1, size(basis, 2)
            square = basis(1, j)**2 + basis(2, j)**2 + basis(3, j)**2
            if (i == j .or. .not. square > 0.0_wp) cycle
            square = anint((basis(1, i)*basis(1, j) + basis(2, i)*basis(2, j) &
               + basis(3, i)*basis(3, j))/square)
            do k = 1, 3
               other(k) = basis(k, i) - square*basis(k, j)
            end do
            call replace_if_shorter(basis, i, other, shorter)
         end do
      end do
   end subroutine shorten_pairs

   !> Add to each of three vectors the other two with either sign, if it gets shorter.
   pure subroutine shorten_third(basis, shorter)
      real(wp), intent(inout) :: basis(:, :)         !! (component, vector) [m]
      logical, intent(inout) :: shorter              !! Has a vector become shorter?
      real(wp) :: other(3)
      integer :: i, j, k, signs

      do i = 1, 3
         do signs = 0, 3
            do k = 1, 3
               j = mod(i, 3) + 1
               other(k) = basis(k, i) + real(2*ibits(signs, 0, 1) - 1, wp)*basis(k, j)
               j = mod(i + 1, 3) + 1
               other(k) = other(k) + real(2*ibits(signs, 1, 1) - 1, wp)*basis(k, j)
            end do
            call replace_if_shorter(basis, i, other, shorter)
         end do
      end do
   end subroutine shorten_third

   !> Replace a vector by another one that is shorter by more than rounding.
   pure subroutine replace_if_shorter(basis, i, other, shorter)
      real(wp), intent(inout) :: basis(:, :)         !! (component, vector) [m]
      integer, intent(in) :: i
      real(wp), intent(in) :: other(3)               !! The other vector [m]
      logical, intent(inout) :: shorter              !! True on return if it was replaced
      real(wp), parameter :: rounding = 1.0e-12_wp
      integer :: k

      if (.not. sum(other**2) < (1.0_wp - rounding)*(basis(1, i)**2 + basis(2, i)**2 &
         + basis(3, i)**2)) return
      do k = 1, 3
         basis(k, i) = other(k)
      end do
      shorter = .true.
   end subroutine replace_if_shorter
end module particle_neighbours
