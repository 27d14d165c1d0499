! SPDX-License-Identifier: BSD-3-Clause
!> The walls on the six boundaries of the domain: the condition at each part of them.
module mesh_boundary_walls
   use base_kinds, only: wp
   use mesh_boundary_catalogue, only: choose_boundary
   use mesh_boundary_condition, only: normal_direction
   use mesh_grid, only: grid_t
   use mesh_wall, only: wall_t
   implicit none
   private

   public :: boundary_walls_t, face_names

   !> Names of the boundaries, two per direction, the lower first.
   character(len=3), parameter :: face_names(6) = ["xlo", "xhi", "ylo", "yhi", "zlo", "zhi"]

   !> The walls. A boundary is open where no wall acts.
   type :: boundary_walls_t
      !> Walls in the order of their boundaries; on each the whole boundary first, then its parts,
      !! of which the last one that covers a position applies
      type(wall_t), allocatable :: wall(:)
      real(wp) :: kick = 0.0_wp                      !! Time for which forces act in this step [s]
   contains
      procedure :: impose => walls_impose         !! Set the type of whole boundaries
      procedure :: insert => walls_insert         !! Add a wall
      procedure :: advance => walls_advance       !! Set moving walls at a time
      procedure :: type_name => walls_type_name   !! Type of a whole boundary
      procedure :: whole => walls_whole           !! Index of the wall on a whole boundary
      procedure :: wall_at => walls_wall_at       !! Index of the wall at a position
      procedure :: is_divided => walls_is_divided !! Has a boundary parts?
      procedure :: mirrors => walls_mirrors       !! Is a whole boundary a mirror plane?
      procedure :: is_closed => walls_is_closed   !! Does a whole boundary keep material in?
      procedure :: is_periodic => walls_is_periodic !! Is it joined to the opposite boundary?
      procedure :: moves => walls_moves           !! Is a whole boundary a moving wall?
      procedure :: lets_out => walls_lets_out     !! Do particles leave at a position?
      procedure :: waits => walls_waits           !! Does a boundary act from the contact on?
      procedure :: keeps => walls_keeps           !! Does it hold material that began on it?
      procedure :: waits_at => walls_waits_at     !! Does a wall act from the contact on?
      procedure :: absorbs_waves => walls_absorbs_waves !! Does some boundary absorb waves?
      procedure :: acts_on => walls_acts_on       !! Does a boundary change node velocities?
   end type boundary_walls_t

contains

   !> Set the type of whole boundaries.
   subroutine walls_impose(self, type_name, faces)
      class(boundary_walls_t), intent(inout) :: self
      character(len=*), intent(in) :: type_name      !! Word of the catalogue
      integer, intent(in) :: faces(:)                !! Numbers of the boundaries, 1 to 6
      type(wall_t) :: wall
      integer :: k, n

      do k = 1, size(faces)
         n = self%whole(faces(k))
         if (n > 0) then
            call choose_boundary(type_name, self%wall(n)%condition)
         else
            wall%face = faces(k)
            call choose_boundary(type_name, wall%condition)
            call self%insert(wall)
         end if
      end do
   end subroutine walls_impose

   !> Add a wall after those of its boundary and of the boundaries before.
   subroutine walls_insert(self, wall)
      class(boundary_walls_t), intent(inout) :: self
      type(wall_t), intent(in) :: wall
      type(wall_t), allocatable :: longer(:)
      integer :: n, before

      if (.not. allocated(self%wall)) allocate (self%wall(0))
      before = count(self%wall%face <= wall%face)
      allocate (longer(size(self%wall) + 1))
      do n = 1, before
         longer(n) = self%wall(n)
      end do
      longer(before + 1) = wall
      do n = before + 1, size(self%wall)
         longer(n + 1) = self%wall(n)
      end do
      call move_alloc(longer, self%wall)
   end subroutine walls_insert

   !> Set velocities of moving walls at a time, and whether walls act.
   pure subroutine walls_advance(self, time, lag, kick, switched)
      class(boundary_walls_t), intent(inout) :: self
      real(wp), intent(in) :: time                   !! Time of the positions [s]
      real(wp), intent(in) :: lag                    !! Lag of velocities behind positions [s]
      real(wp), intent(in) :: kick                   !! Time for which forces act, 0 = none [s]
      logical, intent(out) :: switched               !! Has a wall begun or ceased to act?
      logical :: acted
      integer :: n

      self%kick = kick
      switched = .false.
      do n = 1, size(self%wall)
         acted = self%wall(n)%acts
         call self%wall(n)%advance(time, lag, kick)
         switched = switched .or. (acted .neqv. self%wall(n)%acts)
      end do
   end subroutine walls_advance

   !> Index of the wall on a boundary as a whole, whether it acts or not; 0 = none.
   pure integer function walls_whole(self, face) result(n)
      class(boundary_walls_t), intent(in) :: self
      integer, intent(in) :: face                    !! 1 to 6

      if (allocated(self%wall)) then
         do n = 1, size(self%wall)
            if (self%wall(n)%face == face .and. .not. allocated(self%wall(n)%region)) return
         end do
      end if
      n = 0
   end function walls_whole

   !> Type of a whole boundary at present.
   pure function walls_type_name(self, face) result(name)
      class(boundary_walls_t), intent(in) :: self
      integer, intent(in) :: face                    !! 1 to 6
      character(len=:), allocatable :: name
      integer :: n

      name = "outflow"
      n = self%whole(face)
      if (n == 0) return
      if (self%wall(n)%acts) name = trim(self%wall(n)%condition%name)
   end function walls_type_name

   !> Index of the wall that applies at a position on a boundary now, 0 = none.
   pure integer function walls_wall_at(self, face, place) result(n)
      class(boundary_walls_t), intent(in) :: self
      integer, intent(in) :: face                    !! 1 to 6
      real(wp), intent(in) :: place(3)               !! Position on the boundary [m]

      n = 0
      if (.not. allocated(self%wall)) return
      do n = size(self%wall), 1, -1
         if (self%wall(n)%face /= face) cycle
         if (self%wall(n)%covers(place)) return
      end do
      n = 0
   end function walls_wall_at

   !> Whether a boundary has parts of other types.
   pure logical function walls_is_divided(self, face) result(divided)
      class(boundary_walls_t), intent(in) :: self
      integer, intent(in) :: face                    !! 1 to 6
      integer :: n

      divided = .false.
      if (.not. allocated(self%wall)) return
      do n = 1, size(self%wall)
         if (self%wall(n)%face /= face .or. .not. allocated(self%wall(n)%region)) cycle
         divided = .true.
         return
      end do
   end function walls_is_divided

   !> Whether a whole boundary is a mirror plane.
   pure logical function walls_mirrors(self, face) result(mirrors)
      class(boundary_walls_t), intent(in) :: self
      integer, intent(in) :: face                    !! 1 to 6
      integer :: n

      mirrors = .false.
      n = self%whole(face)
      if (n == 0) return
      mirrors = self%wall(n)%acts .and. self%wall(n)%condition%mirrors()
   end function walls_mirrors

   !> Whether a whole boundary keeps material in.
   pure logical function walls_is_closed(self, face) result(closed)
      class(boundary_walls_t), intent(in) :: self
      integer, intent(in) :: face                    !! 1 to 6
      integer :: n

      closed = .false.
      n = self%whole(face)
      if (n == 0) return
      closed = self%wall(n)%acts .and. self%wall(n)%condition%is_closed()
   end function walls_is_closed

   !> Whether a whole boundary is joined to the opposite one.
   pure logical function walls_is_periodic(self, face) result(periodic)
      class(boundary_walls_t), intent(in) :: self
      integer, intent(in) :: face                    !! 1 to 6
      integer :: n

      periodic = .false.
      n = self%whole(face)
      if (n == 0) return
      periodic = self%wall(n)%acts .and. self%wall(n)%condition%joins_opposite()
   end function walls_is_periodic

   !> Whether a whole boundary is a moving wall.
   pure logical function walls_moves(self, face) result(moves)
      class(boundary_walls_t), intent(in) :: self
      integer, intent(in) :: face                    !! 1 to 6
      integer :: n

      moves = .false.
      n = self%whole(face)
      if (n == 0) return
      moves = self%wall(n)%acts .and. self%wall(n)%condition%moves()
   end function walls_moves

   !> Whether particles leave through a boundary, at a position or, without one, as a whole.
   pure logical function walls_lets_out(self, face, place) result(open)
      class(boundary_walls_t), intent(in) :: self
      integer, intent(in) :: face                    !! 1 to 6
      real(wp), intent(in), optional :: place(3)     !! Position on the boundary [m]
      integer :: n

      if (present(place)) then
         n = self%wall_at(face, place)
      else
         n = self%whole(face)
      end if
      open = .true.
      if (n == 0) return
      if (self%wall(n)%acts) open = self%wall(n)%condition%lets_out()
   end function walls_lets_out

   !> Whether some boundary absorbs waves.
   pure logical function walls_absorbs_waves(self) result(absorbs)
      class(boundary_walls_t), intent(in) :: self
      integer :: n

      absorbs = .false.
      if (.not. allocated(self%wall)) return
      do n = 1, size(self%wall)
         absorbs = absorbs .or. self%wall(n)%condition%absorbs_waves()
      end do
   end function walls_absorbs_waves

   !> Whether a boundary, or a part of it, changes velocities of nodes.
   pure logical function walls_acts_on(self, face) result(acts)
      class(boundary_walls_t), intent(in) :: self
      integer, intent(in) :: face                    !! 1 to 6
      integer :: n

      acts = self%is_divided(face)
      if (acts) return
      n = self%whole(face)
      if (n == 0) return
      acts = self%wall(n)%acts .and. self%wall(n)%condition%acts_on_nodes()
   end function walls_acts_on

   !> True if a boundary acts where material has reached it.
   pure logical function walls_waits(self, grid, face) result(waits)
      class(boundary_walls_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: face                    !! 1 to 6
      integer :: n

      waits = .false.
      if (.not. allocated(self%wall)) return
      do n = 1, size(self%wall)
         if (self%wall(n)%face == face) waits = waits .or. self%waits_at(grid, n)
      end do
   end function walls_waits

   !> True if a boundary acts where material has reached it, and holds material that began there.
   pure logical function walls_keeps(self, grid, face) result(keeps)
      class(boundary_walls_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: face                    !! 1 to 6
      integer :: n

      keeps = .false.
      if (.not. allocated(self%wall)) return
      do n = 1, size(self%wall)
         if (self%wall(n)%face == face) keeps = keeps .or. &
            (self%waits_at(grid, n) .and. self%wall(n)%condition%keeps())
      end do
   end function walls_keeps

   !> True if a wall acts where material has reached it.
   pure logical function walls_waits_at(self, grid, n) result(waits)
      class(boundary_walls_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: n                       !! Wall

      waits = self%wall(n)%condition%waits() .and. &
         grid%active(normal_direction(self%wall(n)%face))
   end function walls_waits_at
end module mesh_boundary_walls
