! SPDX-License-Identifier: BSD-3-Clause
!> Relaxes pressure differences between the particles of a cell that nodes do not resolve.
!!
!! With normalised sums the total volume of a closed box is right, but each particle is strained by
!! more or less than the mean of its neighbours, depending on its position. Nodes do not resolve
!! differences between particles of a cell beyond a slope, so nothing restores them. In material
!! without strength, waves would do so within the time that a signal needs for a cell: particles of
!! higher pressure expand against those of lower pressure, with the same sums of volume and energy.
!! Entropy can only grow by this, and a linear pressure field does not change. Equations (Q.11) and
!! (Q.12) of doc/theory/quadratures.md.
module step_pressure_relaxation
   use base_elementary, only: exponential
   use base_kinds, only: wp
   use mesh_grid, only: grid_t
   use particle_store, only: store_t
   use step_node_fields, only: normalised_nodes_t
   use step_simulation, only: scheme_t
   use transfer_moments, only: cell_slope, moments
   implicit none
   private

   public :: relaxes_pressure, has_normalised_sums, relax_pressures

   real(wp), parameter :: most = 0.05_wp             !! Relative change in a step [1]
   !> Fraction of a difference that decays in the time that a signal needs for a cell [1]
   real(wp), parameter :: pace = 0.2_wp

contains

   !> Are the pressures of the particles of a material in a cell relaxed? They are if it is without
   !! strength, carries energy and has normalised sums.
   pure logical function relaxes_pressure(scheme, stores, index) result(yes)
      type(scheme_t), intent(in) :: scheme
      type(store_t), intent(in) :: stores(:)
      integer, intent(in) :: index                   !! Index of the material and of its store

      yes = .false.
      if (.not. allocated(scheme%flows)) return
      yes = scheme%flows(index) .and. allocated(stores(index)%state%energy)
   end function relaxes_pressure

   !> Are the sums of a material normalised?
   pure logical function has_normalised_sums(scheme, index) result(yes)
      type(scheme_t), intent(in) :: scheme
      integer, intent(in) :: index                   !! Index of the material and of its store

      yes = .false.
      if (allocated(scheme%normalises)) yes = scheme%normalises(index)
   end function has_normalised_sums

   !> Relax the pressures of the particles of a material in a tile towards the mean of their cell
   !! and the slope of the node values.
   subroutine relax_pressures(grid, stores, scheme, normalised, index, tile, local, speed, dt)
      type(grid_t), intent(in) :: grid
      type(store_t), intent(inout) :: stores(:)
      type(scheme_t), intent(in) :: scheme
      type(normalised_nodes_t), intent(in) :: normalised
      integer, intent(in) :: index                   !! Index of the material and of its store
      integer, intent(in) :: tile
      real(wp), contiguous, intent(in) :: local(:, :) !! (particle of the tile, 3) Local coordinates
      real(wp), contiguous, intent(in) :: speed(:)   !! (particle of the tile) Wave speed [m/s]
      real(wp), intent(in) :: dt                     !! Time step [s]
      real(wp) :: slope(3)
      integer :: cell, before, low, high, seen

      if (.not. relaxes_pressure(scheme, stores, index)) return
      associate (store => stores(index), normal => normalised%normal)
         before = store%first(tile) - 1
         seen = size(normal, 1) - moments + 2
         do cell = 0, grid%tile_cells - 1
            low = store%cell_start(cell, tile) + 1
            high = store%cell_start(cell + 1, tile)
            if (high <= low) cycle
            slope = cell_slope(grid, grid%first_node(cell), normal(seen:, :, tile))
            call relax_cell(before, low, high, local, speed, slope, pace*dt/grid%spacing, &
               store%state%mass, store%state%volume, store%state%energy, store%state%stress)
         end do
      end associate
   end subroutine relax_pressures

   !> The particles of one cell.
   pure subroutine relax_cell(before, low, high, local, speed, slope, rate, mass, volume, &
      energy, stress)
      integer, intent(in) :: before                  !! Particles before those of the tile
      integer, intent(in) :: low                     !! First particle of the cell, in the tile
      integer, intent(in) :: high                    !! Last index
      real(wp), contiguous, intent(in) :: local(:, :) !! (particle of the tile, 3) Local coordinates
      real(wp), contiguous, intent(in) :: speed(:)   !! (particle of the tile) Wave speed [m/s]
      real(wp), intent(in) :: slope(3)               !! Slope of the nodal pressure, per cell [Pa]
      real(wp), intent(in) :: rate                   !! Fraction of a step over that speed [s/m]
      real(wp), contiguous, intent(in) :: mass(:)    !! (particle) [kg]
      real(wp), contiguous, intent(inout) :: volume(:) !! (particle) [m3]
      real(wp), contiguous, intent(inout) :: energy(:) !! (particle) [J/kg]
      real(wp), contiguous, intent(inout) :: stress(:, :) !! (particle, 6) [Pa]
      real(wp) :: soft(low:high), excess(low:high), seen(low:high), mean, whole, share, change
      real(wp) :: steepest
      integer :: p, q

      ! volume over the stiffness against its change; material with zero wave speed has no pressure
      ! either
      if (.not. minval(speed(low:high)) > 0.0_wp) return
      do p = low, high
         q = before + p
         soft(p) = volume(q)**2/(mass(q)*speed(p)**2)
         excess(p) = -(stress(q, 1) + stress(q, 2) + stress(q, 3))/3.0_wp
         seen(p) = local(p, 1)*slope(1) + local(p, 2)*slope(2) + local(p, 3)*slope(3)
      end do
      whole = sum(soft)
      mean = sum(soft*excess)/whole
      excess = excess - mean
      seen = seen - sum(soft*seen)/whole
      ! the part of the node slope that the particles have
      share = sum(soft*seen**2)
      if (share > 0.0_wp) excess = excess &
         - seen*min(1.0_wp, max(0.0_wp, sum(soft*seen*excess)/share))
      share = 1.0_wp - exponential(-rate*maxval(speed(low:high)))
      steepest = maxval(soft*abs(excess)/volume(before + low:before + high))
      ! expansion work comes from the energy of the particle, which is small in thin gas near a
      ! shock
      do p = low, high
         q = before + p
         if (excess(p)*mean > 0.0_wp) steepest = max(steepest, soft(p)*excess(p)*mean &
            /(mass(q)*max(energy(q), tiny(mean))))
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
