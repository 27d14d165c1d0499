! SPDX-License-Identifier: BSD-3-Clause
!> Elastic moduli of a cell by small strains of a copy of it: with an affine motion of all grains
!! (unrelaxed), and after the grains are at rest again (relaxed).
module grains_probe
   use base_kinds, only: wp
   use grains_cell, only: cell_t
   use grains_measures, only: energy_t, find_energy
   use grains_pairs, only: dashpot
   use grains_step, only: advance_cell
   use mesh_drive, only: drive_t
   implicit none
   private

   public :: probe_cell, probe_columns

   integer, parameter :: column_length = 24          !! Longest heading of a column
   real(wp), parameter :: small = 1.0e-7_wp          !! Strain of a probe [1]
   integer, parameter :: strain_steps = 100          !! Steps in which a relaxed probe is strained
   !> Duration of the relaxation to rest, before the probes and after each strain, in units of the
   !! shortest collision time.
   real(wp), parameter :: rest_before = 400.0_wp, rest_after = 200.0_wp
   integer, parameter :: most_rests = 20             !! Most repetitions of this relaxation
   real(wp), parameter :: quiet = 1.0e-20_wp         !! Kinetic over spring energy at rest
   real(wp), parameter :: calming = 0.2_wp           !! Decay of velocities in a collision time [1]
   real(wp), parameter :: no_slip = 1.0e100_wp       !! Friction that no force overcomes
   !> Rows and columns of the components xx yy zz xy xz yz.
   integer, parameter :: row_of(6) = [1, 2, 3, 1, 1, 2], column_of(6) = [1, 2, 3, 2, 3, 3]

contains

   !> Headings of the table of moduli.
   pure function probe_columns() result(columns)
      character(len=column_length), allocatable :: columns(:)

      columns = [character(len=column_length) :: "step", "stage", "time [s]", "relaxed", &
         "component", "xx [Pa]", "yy [Pa]", "zz [Pa]", "xy [Pa]", "xz [Pa]", "yz [Pa]", &
         "pressure [Pa]"]
   end function probe_columns

   !> Measure moduli: a row for each strain component, unrelaxed and relaxed, with the change of the
   !! stress per strain. Shear is u_x along y. Collective.
   subroutine probe_cell(cell, rows)
      type(cell_t), intent(in) :: cell
      real(wp), allocatable, intent(out) :: rows(:, :) !! (relaxed, component, 6 stresses, p; row)
      type(cell_t) :: rest
      real(wp) :: stress(6), base(6)
      integer :: component, n

      allocate (rows(9, merge(6, 12, cell%box%dimension == 2)))
      n = 0
      do component = 1, 6
         if (cell%box%dimension == 2 .and. .not. any(component == [1, 2, 4])) cycle
         n = n + 1
         call strain_affine(cell, component, 0.0_wp, base)
         call strain_affine(cell, component, small, stress)
         rows(:, n) = [0.0_wp, real(component, wp), (stress - base)/small, cell%pressure()]
      end do
      call copy_at_rest(cell, rest)
      rest%law%damping = cell%law%damping
      call relax_to_rest(rest, rest_before)
      call strain_relaxed(rest, 1, 0.0_wp, base)
      do component = 1, 6
         if (cell%box%dimension == 2 .and. .not. any(component == [1, 2, 4])) cycle
         n = n + 1
         call strain_relaxed(rest, component, small, stress)
         rows(:, n) = [1.0_wp, real(component, wp), (stress - base)/small, rest%pressure()]
      end do
   end subroutine probe_cell

   !> A copy at rest, without dashpots, whose contacts cannot slip.
   subroutine copy_at_rest(cell, copy)
      type(cell_t), intent(in) :: cell
      type(cell_t), intent(out) :: copy

      copy = cell
      copy%drive = drive_t()
      copy%box%gradient = 0.0_wp
      copy%grains%velocity = 0.0_wp
      copy%grains%spin = 0.0_wp
      copy%grains%force = 0.0_wp
      copy%grains%torque = 0.0_wp
      copy%law%damping = 0.0_wp
      copy%law%friction = no_slip
      copy%pairs%history(dashpot, :) = 0.0_wp
   end subroutine copy_at_rest

   !> Stress after all grains have moved with the cell and turned with its rotation.
   subroutine strain_affine(cell, component, strain, stress)
      type(cell_t), intent(in) :: cell
      integer, intent(in) :: component               !! 1 to 6: xx yy zz xy xz yz
      real(wp), intent(in) :: strain                 !! [1]
      real(wp), intent(out) :: stress(6)             !! [Pa]
      type(cell_t) :: copy
      real(wp) :: g(3, 3)

      call copy_at_rest(cell, copy)
      copy%box%gradient(row_of(component), column_of(component)) = strain/copy%dt
      g = 0.5_wp*copy%box%gradient
      copy%grains%spin(1, :) = g(3, 2) - g(2, 3)
      copy%grains%spin(2, :) = g(1, 3) - g(3, 1)
      copy%grains%spin(3, :) = g(2, 1) - g(1, 2)
      call advance_cell(copy)
      call take_stress(copy, stress)
   end subroutine strain_affine

   !> Relax the grains of a cell to rest, with damping in addition to the dashpots. The relaxation
   !! is repeated up to `most_rests` times, until the remaining motion causes forces that are
   !! negligible for a probe: a grain that is not in equilibrium would move between two probes.
   !! Collective.
   subroutine relax_to_rest(cell, collisions)
      type(cell_t), intent(inout) :: cell
      real(wp), intent(in) :: collisions             !! Time in durations of a collision
      type(energy_t) :: energy
      real(wp) :: keep
      integer :: step, rest

      keep = 1.0_wp - min(0.5_wp, calming*cell%dt/cell%collision)
      do rest = 1, most_rests
         do step = 1, nint(collisions*cell%collision/cell%dt)
            call advance_cell(cell)
            cell%grains%velocity = keep*cell%grains%velocity
            cell%grains%spin = keep*cell%grains%spin
         end do
         call find_energy(cell, energy)
         if (energy%kinetic <= quiet*energy%springs) exit
      end do
   end subroutine relax_to_rest

   !> Stress after a cell at rest is strained in several steps and then relaxed to rest again.
   subroutine strain_relaxed(cell, component, strain, stress)
      type(cell_t), intent(in) :: cell               !! At rest; contacts do not slip
      integer, intent(in) :: component               !! 1 to 6: xx yy zz xy xz yz
      real(wp), intent(in) :: strain                 !! [1]
      real(wp), intent(out) :: stress(6)             !! [Pa]
      type(cell_t) :: copy
      integer :: step

      copy = cell
      copy%drive%gradient(row_of(component), column_of(component)) = &
         strain/(copy%dt*real(strain_steps, wp))
      copy%box%gradient = copy%drive%gradient
      do step = 1, strain_steps
         if (step == strain_steps) copy%drive%gradient = 0.0_wp
         call advance_cell(copy)
      end do
      call relax_to_rest(copy, rest_after)
      call take_stress(copy, stress)
   end subroutine strain_relaxed

   !> Stress of the contacts.
   pure subroutine take_stress(cell, stress)
      type(cell_t), intent(in) :: cell
      real(wp), intent(out) :: stress(6)             !! xx yy zz xy xz yz [Pa]
      real(wp), parameter :: none(9) = 0.0_wp
      real(wp) :: full(3, 3)
      integer :: n

      full = cell%stress(cell%contact, none)
      do n = 1, 6
         stress(n) = full(row_of(n), column_of(n))
      end do
   end subroutine take_stress
end module grains_probe
