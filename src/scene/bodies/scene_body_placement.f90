! SPDX-License-Identifier: BSD-3-Clause
!> Checks of bodies against the grid and each other: number of particles, position and thickness.
module scene_body_placement
   use base_kinds, only: int64, wp
   use base_text, only: brief, number
   use deck_reader, only: deck_t
   use material_kinds, only: supports_any_shear
   use mesh_grid, only: grid_t
   use particle_body, only: body_t
   use scene_dimension, only: axis_names
   use scene_particles, only: survey_t
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: check_elastic, check_placement, check_size

   real(wp), parameter, public :: default_most_points = 1.0e10_wp !! About 2 TB of memory
   real(wp), parameter :: most_tiles = 2.0e8_wp      !! Greatest number of tiles of a body
   real(wp), parameter :: most_identities = 4.0e18_wp !! 64-bit integers end at 9e18
   !> Impact speed over wave speed above which colliding bodies are strained by a quarter or more
   !! [1]
   real(wp), parameter :: fast = 0.5_wp
   real(wp), parameter :: thinnest = 2.0_wp          !! Cells across a body
   real(wp), parameter :: round_off = 1.0e-9_wp      !! Rounding error of lengths [cells]
   real(wp), parameter :: endless = 1.0e9_wp         !! Length of shapes without an end [grids]

contains

   !> Refuse bodies with too many particles or tiles. The test needs no survey, because the cost of
   !! a survey grows with the number of particles.
   subroutine check_size(deck, grid, bodies, most_points, force)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(grid_t), intent(in) :: grid
      type(body_t), intent(in) :: bodies(:)
      real(wp), intent(in) :: most_points            !! More need --force
      logical, intent(in) :: force                   !! Set by the user
      real(wp) :: identities, points, reach(3), low(3), high(3), tiles
      integer :: n

      identities = 0.0_wp
      do n = 1, size(bodies)
         identities = identities + product(real(bodies(n)%sites(grid), wp))
         call cut_bounds(grid, bodies(n), low, high)
         reach = max(high - low, 0.0_wp)/grid%spacing
         points = product(merge(reach*real(bodies(n)%per_cell, wp), 1.0_wp, grid%active))
         tiles = product(merge(reach/real(grid%width, wp) + 1.0_wp, 1.0_wp, grid%active))
         if (identities > most_identities) then
            call deck%add_error("body", n, "the grid has "//brief(identities)// &
               " lattice points, more than there are identities; use larger cells or "// &
               "fewer ppc [D447]", "ppc")
            return
         else if (tiles > most_tiles) then
            call deck%add_error("body", n, "its region reaches "//brief(tiles)// &
               " tiles, more than "//brief(most_tiles)//"; use larger cells [D429]", "region")
         else if (points > most_points .and. .not. force) then
            call deck%add_error("body", n, "would hold up to "//brief(points)// &
               " points, more than "//brief(most_points)//"; use larger cells or fewer ppc, "// &
               "or continue with --force [D428]", "ppc")
         end if
      end do
   end subroutine check_size

   !> The box around a body, cut at the faces of the grid [m].
   subroutine cut_bounds(grid, body, low, high)
      type(grid_t), intent(in) :: grid
      type(body_t), intent(in) :: body
      real(wp), intent(out) :: low(3), high(3)       !! Corners [m]

      call body%shape%bounds(low, high)
      where (grid%active)
         low = max(low, grid%lower)
         high = min(high, grid%upper)
      end where
   end subroutine cut_bounds

   !> Bodies without particles are errors; bodies that are cut, thin or overlapping are allowed,
   !! with a warning.
   subroutine check_placement(deck, simulation, bodies, survey)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(simulation_t), intent(in) :: simulation   !! Grid and faces
      type(body_t), intent(in) :: bodies(:)
      type(survey_t), intent(in) :: survey           !! Particles of the bodies
      real(wp) :: low(3, size(bodies)), high(3, size(bodies)), pairs
      integer :: n, other

      do n = 1, size(bodies)
         call cut_bounds(simulation%space%grid, bodies(n), low(:, n), high(:, n))
         if (survey%body(n) == 0 .or. .not. bodies(n)%share > 0.0_wp) then
            ! why it has no particle
            call bodies(n)%shape%bounds(low(:, n), high(:, n))
            if (any(simulation%space%grid%active .and. (high(:, n) <= simulation%space%grid%lower &
               .or. low(:, n) >= simulation%space%grid%upper))) then
               call deck%add_error("body", n, "lies outside of the grid; "// &
                  "move its region or widen &grid [D409]", "region")
            else
               call deck%add_error("body", n, "holds no particle: its region "// &
                  "is thinner than the lattice of dx/ppc, empty, or covered by later "// &
                  "bodies [D410]", "region")
            end if
            cycle
         end if
         call check_outside(deck, simulation, bodies(n), n)
         call check_thickness(deck, simulation, bodies(n), n)
      end do
      pairs = 0.5_wp*real(size(bodies), wp)*real(size(bodies) - 1, wp)
      do n = 1, size(bodies) - 1
         do other = n + 1, size(bodies)
            if (any(simulation%space%grid%active .and. (low(:, n) >= high(:, other) .or. &
               low(:, other) >= high(:, n)))) cycle
            call check_overlap(deck, simulation%space%grid, bodies, [n, other], pairs)
         end do
      end do
   end subroutine check_placement

   !> Warn of impacts fast enough to strain a material without yield strength or failure beyond the
   !! range of a law of small elastic strains.
   subroutine check_elastic(deck, simulation, bodies)
      type(deck_t), intent(inout) :: deck            !! Collects warnings
      type(simulation_t), intent(in) :: simulation   !! Materials, walls
      type(body_t), intent(in) :: bodies(:)
      real(wp) :: fastest, speed
      integer :: n, other
      logical :: walls

      walls = allocated(simulation%space%rigid)
      do n = 1, 6
         walls = walls .or. simulation%space%boundary%acts_on(n)
      end do
      do n = 1, size(bodies)
         associate (material => simulation%materials(bodies(n)%store))
            if (.not. supports_any_shear(material)) cycle
            fastest = 0.0_wp
            if (walls) fastest = norm2(bodies(n)%velocity)
            do other = 1, size(bodies)
               fastest = max(fastest, norm2(bodies(n)%velocity - bodies(other)%velocity))
            end do
            speed = material%reference_speed()
            if (fastest <= fast*speed) cycle
            call deck%warn("body", n, "may collide with other bodies at "//brief(fastest)// &
               " m/s, "//brief(fastest/speed)//" times its wave speed, and its material is "// &
               "elastic at any stress; give it a yield stress or a damage_model, or "// &
               "strength_model = 'neo_hookean' [D425]", "velocity")
         end associate
      end do
   end subroutine check_elastic

   !> Warn if a part of a body is outside the grid. Parts behind a mirror plane are images and are
   !! not counted. The grid must cut a shape that has no end, such as a half-space.
   subroutine check_outside(deck, simulation, body, place)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(simulation_t), intent(in) :: simulation   !! Grid and faces
      type(body_t), intent(in) :: body
      integer, intent(in) :: place                   !! Number of the body in the deck
      real(wp) :: low(3), high(3)
      integer :: inside, outside, k

      associate (grid => simulation%space%grid, boundary => simulation%space%boundary)
         call body%shape%bounds(low, high)
         if (any(grid%active .and. max(-low, high) > endless*maxval(grid%upper - grid%lower))) &
            return
         do k = 1, 3
            if (boundary%mirrors(2*k - 1)) low(k) = max(low(k), grid%lower(k))
            if (boundary%mirrors(2*k)) high(k) = min(high(k), grid%upper(k))
         end do
         if (.not. any(grid%active .and. (low < grid%lower - round_off*grid%spacing .or. &
            high > grid%upper + round_off*grid%spacing))) return
         call count_samples(grid, body, low, high, inside, outside)
      end associate
      if (outside == 0 .or. 100*outside < inside + outside) return
      call deck%warn("body", place, "its region lies "//number(nint(100.0_wp*real(outside, wp) &
         /real(inside + outside, wp)))//" % outside the grid and is cut there [D424]", "region")
   end subroutine check_outside

   !> Sample a box around a body: points of the body inside and outside the grid.
   subroutine count_samples(grid, body, low, high, inside, outside)
      type(grid_t), intent(in) :: grid
      type(body_t), intent(in) :: body
      real(wp), intent(in) :: low(3), high(3)        !! Corners of the box [m]
      integer, intent(out) :: inside                 !! Points of the body in the grid
      integer, intent(out) :: outside                !! Points of the body beyond it
      integer, parameter :: samples(3) = [4096, 128, 24] ! along an edge, by dimensions
      real(wp) :: point(3)
      integer :: number_of(3), points, x, y, z

      number_of = merge(samples(grid%dimensions), 1, grid%active)
      points = 0
      outside = 0
      point = resting_place(grid)
      do z = 1, number_of(3)
         do y = 1, number_of(2)
            do x = 1, number_of(1)
               where (grid%active) point = low + (high - low)*(real([x, y, z], wp) - 0.5_wp) &
                  /real(number_of, wp)
               if (.not. body%shape%contains(point)) cycle
               points = points + 1
               if (any(grid%active .and. (point < grid%lower .or. point >= grid%upper))) &
                  outside = outside + 1
            end do
         end do
      end do
      inside = points - outside
   end subroutine count_samples

   !> Coordinates of particles along missing directions [m].
   pure function resting_place(grid) result(point)
      type(grid_t), intent(in) :: grid
      real(wp) :: point(3)

      point = merge(0.0_wp, 0.5_wp*(grid%lower + grid%upper), grid%axisymmetric)
   end function resting_place

   !> Warn if a body is thinner than two cells. Directions in which it extends from one closed
   !! boundary to the other are not tested; at a mirror plane half the thickness is enough.
   subroutine check_thickness(deck, simulation, body, place)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(simulation_t), intent(in) :: simulation   !! Grid and faces
      type(body_t), intent(in) :: body
      integer, intent(in) :: place                   !! Number of the body in the deck
      real(wp) :: low(3), high(3), cells
      logical :: first, last
      integer :: k

      associate (grid => simulation%space%grid, boundary => simulation%space%boundary)
         call cut_bounds(grid, body, low, high)
         do k = 1, 3
            if (.not. grid%active(k)) cycle
            first = low(k) <= grid%lower(k) + round_off*grid%spacing
            last = high(k) >= grid%upper(k) - round_off*grid%spacing
            if (first .and. last .and. (grid%periodic(k) .or. &
               (grid%wall(2*k - 1) .and. grid%wall(2*k)))) cycle
            cells = (high(k) - low(k))/grid%spacing
            if (first .and. boundary%mirrors(2*k - 1)) cells = 2.0_wp*cells
            if (last .and. boundary%mirrors(2*k)) cells = 2.0_wp*cells
            if (cells >= thinnest - round_off) cycle
            call deck%warn("body", place, "is "//brief(cells)//" cells thick in "//axis_names(k)// &
               "; at least 2, better 6 [D426]", "region")
            return
         end do
      end associate
   end subroutine check_thickness

   !> Warn of two bodies that overlap, with the number of particles that the earlier one loses.
   subroutine check_overlap(deck, grid, bodies, pair, pairs)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(grid_t), intent(in) :: grid
      type(body_t), intent(in) :: bodies(:)
      integer, intent(in) :: pair(2)                 !! Earlier and later body
      real(wp), intent(in) :: pairs !! Number of pairs over which the limit is divided
      real(wp), parameter :: work = 2.0e6_wp         ! sites tested, all pairs together
      real(wp) :: low(3), high(3), other_low(3), other_high(3), point(3), edge(3), sites
      integer :: first(3), last(3), stride(3), x, y, z
      integer(int64) :: points
      character(len=:), allocatable :: about

      call cut_bounds(grid, bodies(pair(1)), low, high)
      call cut_bounds(grid, bodies(pair(2)), other_low, other_high)
      low = max(low, other_low)
      high = min(high, other_high)
      if (any(grid%active .and. low >= high)) return
      edge = merge(grid%spacing/real(bodies(pair(1))%per_cell, wp), 1.0_wp, grid%active)
      first = merge(floor((low - grid%lower)/edge), 0, grid%active)
      last = merge(ceiling((high - grid%lower)/edge) - 1, 0, grid%active)
      stride = 1
      sites = product(real(last - first + 1, wp))*pairs
      if (sites > work) stride = merge(ceiling((sites/work)**(1.0_wp/real(grid%dimensions, wp))), &
         1, grid%active)
      points = 0
      point = resting_place(grid)
      do z = first(3), last(3), stride(3)
         do y = first(2), last(2), stride(2)
            do x = first(1), last(1), stride(1)
               where (grid%active) point = grid%lower + (real([x, y, z], wp) + 0.5_wp)*edge
               if (bodies(pair(1))%shape%contains(point) .and. &
                  bodies(pair(2))%shape%contains(point)) &
                  points = points + product(int(stride, int64))
            end do
         end do
      end do
      if (points == 0) return
      about = ""
      if (any(stride > 1)) about = "about "
      call deck%warn("body", pair(2), "overlaps '"//bodies(pair(1))%name//"' in "//about// &
         number(points)//" points, which belong to the later body; to change this use shape "// &
         "= 'difference' [D427]", "region")
   end subroutine check_overlap
end module scene_body_placement
