! SPDX-License-Identifier: BSD-3-Clause
!> Stress of bodies at rest under their weight (`initial_stress = 'lithostatic'`).
!!
!! Along gravity the stress is the weight of the material above, up to the first gap; the lateral
!! stress is a fraction of it. Where the pressure is a function of the density, particles get the
!! density of their pressure: they keep positions and volumes and become heavier.
module scene_lithostatic
   use base_constants, only: xx, xy, xz, yy, yz, zz
   use base_kinds, only: wp
   use deck_reader, only: deck_t, group_t
   use material_state, only: material_state_t
   use material_type, only: material_t
   use mesh_grid, only: grid_t
   use particle_body, only: body_t
   use particle_store, only: store_t
   use scene_particles, only: body_of
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: read_lithostatic, add_weight_stress

contains

   !> Read whether a body starts with the stress of its weight, and refuse bodies that cannot.
   subroutine read_lithostatic(deck, simulation, group, body)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(simulation_t), intent(in) :: simulation   !! Materials and gravity
      type(group_t), intent(in) :: group             !! The &body
      type(body_t), intent(inout) :: body            !! Its particles are known; gets the ratio
      character(len=:), allocatable :: word
      logical :: whole

      call group%get("initial_stress", word)
      if (word /= "lithostatic") return
      call group%get("k0", body%lateral)
      if (.not. allocated(simulation%effects%gravity)) then
         call deck%add_error(group, "initial_stress = 'lithostatic' needs gravity; write "// &
            "&effects gravity = .true. / [D353]", "initial_stress")
      else if (.not. any(abs(simulation%effects%gravity) > 0.0_wp)) then
         call deck%add_error(group, "initial_stress = 'lithostatic' needs gravity along a "// &
            "direction of the scene [D353]", "initial_stress")
      end if
      associate (material => simulation%materials(body%store))
         whole = .not. allocated(material%eos)
         if (whole) whole = .not. material%bulk_in_rate_form()
         if (whole) whole = .not. material%law%finds_rest_state()
         if (whole) call deck%add_error(group, "material '"//material%name//"' computes its "// &
            "stress from its deformation alone, which is zero at the start; write "// &
            "initial_stress = 'zero' [D423]", &
            "initial_stress")
      end associate
      if (body%on_lattice()) return
      if (.not. body%given%clipped) call deck%add_error(group, "initial_stress = "// &
         "'lithostatic' needs a region with a surface, not a list of points; write 'file' or "// &
         "'zero' [D353]", "initial_stress")
   end subroutine read_lithostatic

   !> Set the stress of particles to that of the weight above. All shapes still exist.
   subroutine add_weight_stress(simulation, bodies)
      type(simulation_t), intent(inout) :: simulation !! The run with particles
      type(body_t), intent(in) :: bodies(:)
      integer :: index

      if (.not. any(bodies%lateral >= 0.0_wp)) return
      do index = 1, size(simulation%stores)
         if (.not. any(bodies%lateral >= 0.0_wp .and. bodies%store == index)) cycle
         call weigh_store(simulation%space%grid, simulation%effects%gravity, bodies, &
            simulation%materials(index), simulation%stores(index))
      end do
   end subroutine add_weight_stress

   !> Particles of a material.
   subroutine weigh_store(grid, gravity, bodies, material, store)
      type(grid_t), intent(in) :: grid
      real(wp), intent(in) :: gravity(3)             !! [m/s2]
      type(body_t), intent(in) :: bodies(:)
      type(material_t), intent(in) :: material       !! That of the particles
      type(store_t), intent(inout) :: store
      integer :: tile

      !$omp parallel do default(none) shared(grid, gravity, bodies, material, store) &
      !$omp private(tile) schedule(dynamic, 4)
      do tile = 1, size(store%count)
         call weigh_tile(grid, gravity, bodies, material, tile, store)
      end do
      !$omp end parallel do
   end subroutine weigh_store

   !> Particles of a tile.
   subroutine weigh_tile(grid, gravity, bodies, material, tile, store)
      type(grid_t), intent(in) :: grid
      real(wp), intent(in) :: gravity(3)             !! [m/s2]
      type(body_t), intent(in) :: bodies(:)
      type(material_t), intent(in) :: material       !! That of the particles
      integer, intent(in) :: tile
      type(store_t), intent(inout) :: store
      real(wp) :: down(3), place(3), weight, across
      real(wp) :: pressure(store%count(tile))
      integer :: first, p, body

      down = gravity/norm2(gravity)
      first = store%first(tile)
      pressure = 0.0_wp
      do p = first, first + store%count(tile) - 1
         body = body_of(bodies, store%identity(p))
         if (bodies(body)%lateral < 0.0_wp) cycle
         place = store%position(p, :)
         weight = norm2(gravity)*mass_above(grid, bodies, body, place, -down)
         across = bodies(body)%lateral*weight
         associate (stress => store%state%stress)
            stress(p, xx) = -across - (weight - across)*down(1)**2
            stress(p, yy) = -across - (weight - across)*down(2)**2
            stress(p, zz) = -across - (weight - across)*down(3)**2
            stress(p, xy) = -(weight - across)*down(1)*down(2)
            stress(p, yz) = -(weight - across)*down(2)*down(3)
            stress(p, xz) = -(weight - across)*down(1)*down(3)
         end associate
         pressure(p - first + 1) = (weight + 2.0_wp*across)/3.0_wp
      end do
      if (allocated(material%eos)) then
         call press(bodies, material, pressure, first, store)
      else if (allocated(material%law)) then
         if (.not. material%law%finds_rest_state()) return
         do p = first, first + store%count(tile) - 1
            if (pressure(p - first + 1) > 0.0_wp) call material%law%find_rest_state(store%state, p)
         end do
      end if
   end subroutine weigh_tile

   !> Mass per area of the column above a position, up to the first gap [kg/m2]. Bodies without
   !! initial stress do not count: they are not yet at rest. Bisection finds the interface between
   !! two bodies.
   pure real(wp) function mass_above(grid, bodies, own, place, up) result(mass)
      type(grid_t), intent(in) :: grid
      type(body_t), intent(in) :: bodies(:)
      integer, intent(in) :: own                     !! Body at the position
      real(wp), intent(in) :: place(3)               !! [m]
      real(wp), intent(in) :: up(3)                  !! Direction of length one
      integer, parameter :: halvings = 40, parts = 4
      real(wp) :: step, height, low, high, middle
      integer :: body, next, n

      step = grid%spacing/real(parts*maxval(bodies(own)%per_cell), wp)
      mass = 0.0_wp
      height = 0.0_wp
      body = own
      do while (body > 0)
         next = body_at(grid, bodies, place + (height + step)*up)
         low = height + step
         if (next /= body) then
            low = height
            high = height + step
            do n = 1, halvings
               middle = 0.5_wp*(low + high)
               if (body_at(grid, bodies, place + middle*up) == body) then
                  low = middle
               else
                  high = middle
               end if
            end do
         end if
         mass = mass + (low - height)*bodies(body)%density
         if (next > 0 .and. next /= body) mass = mass + (height + step - low)*bodies(next)%density
         height = height + step
         body = next
      end do
   end function mass_above

   !> Body that supports its own weight and contains a position; 0 if none.
   pure integer function body_at(grid, bodies, place) result(body)
      type(grid_t), intent(in) :: grid
      type(body_t), intent(in) :: bodies(:)
      real(wp), intent(in) :: place(3)               !! [m]

      body = 0
      if (any(grid%active .and. (place < grid%lower .or. place >= grid%upper))) return
      do body = size(bodies), 1, -1
         if (bodies(body)%shape%contains(place)) exit
      end do
      if (body == 0) return
      if (bodies(body)%lateral < 0.0_wp) body = 0
   end function body_at

   !> Set the density of particles to that of their pressure, by the secant method. Other particles
   !! of the tile do not change.
   subroutine press(bodies, material, pressure, first, store)
      type(body_t), intent(in) :: bodies(:)
      type(material_t), intent(in) :: material       !! That of the particles
      real(wp), intent(in) :: pressure(:)            !! (particle of the tile) 0: unchanged [Pa]
      integer, intent(in) :: first                   !! First particle of the tile
      type(store_t), intent(inout) :: store
      integer, parameter :: rounds = 12
      type(material_state_t) :: trial
      real(wp), dimension(size(pressure)) :: factor, before, found, earlier, step
      integer :: n, round

      n = size(pressure)
      if (n == 0) return
      call material%allocate_state(trial, n)
      before = 1.0_wp
      factor = 1.0_wp + pressure/material%bulk
      call find(before, earlier)
      do round = 1, rounds
         call find(factor, found)
         step = 0.0_wp
         where (abs(found - earlier) > 0.0_wp) step = (pressure - found)*(factor - before) &
            /(found - earlier)
         before = factor
         earlier = found
         where (pressure > 0.0_wp) factor = factor + step
         if (all(abs(step) <= epsilon(1.0_wp))) exit
      end do
      where (pressure > 0.0_wp) store%state%mass(first:first + n - 1) = factor &
         *store%state%mass(first:first + n - 1)

   contains

      !> Pressure of undeformed material of some density.
      subroutine find(share, value)
         real(wp), intent(in) :: share(:)            !! Fraction of the density without stress [1]
         real(wp), intent(out) :: value(:)           !! [Pa]
         integer :: p, body

         trial%volume = store%state%volume(first:first + n - 1)
         trial%mass = share*store%state%mass(first:first + n - 1)
         do p = 1, n
            body = body_of(bodies, store%identity(first + p - 1))
            call material%start(trial, p, p, bodies(body)%temperature)
            if (bodies(body)%energy > 0.0_wp) trial%energy(p) = bodies(body)%energy
         end do
         call material%find_rest_stress(trial, 1, n)
         value = -(trial%stress(:, xx) + trial%stress(:, yy) + trial%stress(:, zz))/3.0_wp
      end subroutine find
   end subroutine press
end module scene_lithostatic
