! SPDX-License-Identifier: BSD-3-Clause
!> Relaxes pressure differences between the particles of a cell that nodes do not resolve.
!!
!! Particles that cross a shock at different positions in their cell, or that normalised sums strain
!! by more or less than their neighbours, have different pressures. Nodes do not resolve differences
!! between particles of a cell beyond a slope, so nothing restores them. Waves would do so within
!! the time that a signal needs for a cell: particles of higher pressure expand against those of
!! lower pressure, with the same sums of volume and energy. Entropy can only grow by this, and a
!! linear pressure field does not change. Equations (Q.10), (Q.11) and (Q.12) of
!! doc/theory/quadratures.md.
module step_pressure_relaxation
   use base_elementary, only: exponential
   use base_kinds, only: wp
   use material_kinds, only: is_gas
   use material_type, only: material_t
   use mesh_grid, only: grid_t
   use particle_store, only: store_t
   use step_method, only: method_t
   use step_simulation, only: scheme_t
   implicit none
   private

   public :: relaxes_pressure, has_normalised_sums, relax_pressures, relaxation_of, &
      relaxation_t

   real(wp), parameter :: most = 0.05_wp             !! Relative change in a step [1]
   !> Greatest ratio of the stiffness of particles in one state of the material: expanded particles
   !! beside dense ones do not share a pressure, and would grow without bound [1]
   real(wp), parameter :: alike = 4.0_wp
   !> Fraction of a difference that decays in the time that a signal needs for a cell. Normalised
   !! sums make differences wherever the strain is large; to end them at once would move volume
   !! against strong gradients: that of an explosion then changes by 0.7 instead of 0.2 % [1]
   real(wp), parameter :: pace = 1.0_wp, gentle = 0.2_wp

   !> How the pressures of a material relax in a step.
   type :: relaxation_t
      real(wp) :: time = 0.0_wp                      !! Time step times the pace [s]
      real(wp) :: reserve = 0.0_wp !! Energy of condensed material at its arbitrary zero [J/kg]
   end type relaxation_t

contains

   !> Are the pressures of the particles of a material in a cell relaxed? They are if it carries
   !! energy, which takes up what the relaxation dissipates. The method of the paper has none.
   pure logical function relaxes_pressure(method, store) result(yes)
      type(method_t), intent(in) :: method
      type(store_t), intent(in) :: store

      yes = method%dual .and. method%leapfrog .and. allocated(store%state%energy)
   end function relaxes_pressure

   !> How the pressures of a material relax in a step; those of gases with plain sums do not: on an
   !! axis, where these sums are wrong, particles would shrink without bound.
   pure function relaxation_of(scheme, material, index, dt) result(relaxation)
      type(scheme_t), intent(in) :: scheme
      type(material_t), intent(in) :: material
      integer, intent(in) :: index                   !! Index of the material and of its store
      real(wp), intent(in) :: dt                     !! Time step [s]
      type(relaxation_t) :: relaxation

      if (has_normalised_sums(scheme, index)) then
         relaxation%time = dt*gentle
      else if (.not. is_gas(material)) then
         relaxation%time = dt*pace
         relaxation%reserve = material%reference_speed()**2
      end if
   end function relaxation_of

   !> Are the sums of a material normalised?
   pure logical function has_normalised_sums(scheme, index) result(yes)
      type(scheme_t), intent(in) :: scheme
      integer, intent(in) :: index                   !! Index of the material and of its store

      yes = .false.
      if (allocated(scheme%normalises)) yes = scheme%normalises(index)
   end function has_normalised_sums

   !> Relax the pressures of the particles of a tile towards the mean of their cell and the slope
   !! that accelerates its nodes.
   subroutine relax_pressures(relaxation, grid, store, tile, local, speed, acceleration, gravity)
      type(relaxation_t), intent(in) :: relaxation
      type(grid_t), intent(in) :: grid
      type(store_t), intent(inout) :: store
      integer, intent(in) :: tile
      real(wp), contiguous, intent(in) :: local(:, :) !! (particle of the tile, 3) Local coordinates
      real(wp), contiguous, intent(in) :: speed(:)   !! (particle of the tile) Wave speed [m/s]
      real(wp), contiguous, intent(in) :: acceleration(:, :) !! (3, node) [m/s2]
      real(wp), intent(in), optional :: gravity(:)   !! (3) Part that no stress makes [m/s2]
      real(wp) :: slope(3)
      integer :: cell, before, low, high, lane, lanes

      if (.not. relaxation%time > 0.0_wp) return
      before = store%first(tile) - 1
      lanes = 2**grid%dimensions
      do cell = 0, grid%tile_cells - 1
         low = store%cell_start(cell, tile) + 1
         high = store%cell_start(cell + 1, tile)
         if (high <= low) cycle
         slope = 0.0_wp
         do lane = 1, lanes
            slope = slope - acceleration(:, grid%first_node(cell) + grid%lane_offset(lane))
         end do
         slope = slope/lanes
         if (present(gravity)) slope = slope + gravity
         slope = slope*grid%spacing*sum(store%state%mass(before + low:before + high)) &
            /sum(store%state%volume(before + low:before + high))
         call relax_cell(before, low, high, local, speed, slope, &
            relaxation_t(relaxation%time/grid%spacing, relaxation%reserve), store%state%mass, &
            store%state%volume, store%state%energy, store%state%stress)
      end do
   end subroutine relax_pressures

   !> The particles of one cell.
   pure subroutine relax_cell(before, low, high, local, speed, slope, relaxation, mass, volume, &
      energy, stress)
      integer, intent(in) :: before                  !! Particles before those of the tile
      integer, intent(in) :: low                     !! First particle of the cell, in the tile
      integer, intent(in) :: high                    !! Last index
      real(wp), contiguous, intent(in) :: local(:, :) !! (particle of the tile, 3) Local coordinates
      real(wp), contiguous, intent(in) :: speed(:)   !! (particle of the tile) Wave speed [m/s]
      real(wp), intent(in) :: slope(3)               !! Slope of the pressure, per cell [Pa]
      type(relaxation_t), intent(in) :: relaxation   !! Its time is that over the cell [s/m]
      real(wp), contiguous, intent(in) :: mass(:)    !! (particle) [kg]
      real(wp), contiguous, intent(inout) :: volume(:) !! (particle) [m3]
      real(wp), contiguous, intent(inout) :: energy(:) !! (particle) [J/kg]
      real(wp), contiguous, intent(inout) :: stress(:, :) !! (particle, 6) [Pa]
      real(wp) :: soft(low:high), excess(low:high), seen(low:high), mean, whole, share, change
      real(wp) :: steepest, stiff(low:high)
      integer :: p, q

      ! volume over the stiffness against its change; material with zero wave speed has no pressure
      ! either
      if (.not. minval(speed(low:high)) > 0.0_wp) return
      do p = low, high
         q = before + p
         stiff(p) = mass(q)/volume(q)*speed(p)**2
         soft(p) = volume(q)/stiff(p)
         excess(p) = -(stress(q, 1) + stress(q, 2) + stress(q, 3))/3.0_wp
         seen(p) = local(p, 1)*slope(1) + local(p, 2)*slope(2) + local(p, 3)*slope(3)
      end do
      if (maxval(stiff) > alike*minval(stiff)) return
      whole = sum(soft)
      mean = sum(soft*excess)/whole
      excess = excess - mean
      seen = seen - sum(soft*seen)/whole
      ! the part of the node slope that the particles have
      share = sum(soft*seen**2)
      if (share > 0.0_wp) excess = excess &
         - seen*min(1.0_wp, max(0.0_wp, sum(soft*seen*excess)/share))
      share = 1.0_wp - exponential(-relaxation%time*maxval(speed(low:high)))
      steepest = maxval(soft*abs(excess)/volume(before + low:before + high))
      ! expansion work comes from the energy of the particle, which is small in thin gas near a
      ! shock; that of condensed material has no natural zero
      do p = low, high
         q = before + p
         if (excess(p)*mean > 0.0_wp) steepest = max(steepest, soft(p)*excess(p)*mean &
            /(mass(q)*max(energy(q) + relaxation%reserve, tiny(mean))))
      end do
      if (share*steepest > most) share = most/steepest
      do p = low, high
         q = before + p
         change = share*soft(p)*excess(p)
         volume(q) = volume(q) + change
         energy(q) = energy(q) - mean*change/mass(q)
         stress(q, 1:3) = stress(q, 1:3) + share*excess(p)
      end do
   end subroutine relax_cell
end module step_pressure_relaxation
