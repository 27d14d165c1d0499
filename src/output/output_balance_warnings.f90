! SPDX-License-Identifier: BSD-3-Clause
!> Warnings at the end of a run of balances that do not close and of locking, with the remedy.
module output_balance_warnings
   use base_kinds, only: wp
   use base_log, only: log_t
   use ddmp_dual, only: surface_fill
   use material_kinds, only: stores_work
   use step_ledger, only: balance_t
   use step_method, only: method_t
   use step_simulation, only: simulation_t
   use step_trust_record, only: trust_angular, trust_damped, trust_energy, trust_momentum, &
      trust_noise, trust_ok, trust_t, verdict_of
   implicit none
   private

   public :: warn_of_balance

contains

   !> Report at the end which balances do not close, with the remedy. Collective.
   subroutine warn_of_balance(simulation, now, trust, log)
      type(simulation_t), intent(in) :: simulation   !! Method and fields are used
      type(balance_t), intent(in) :: now             !! Balance at this time
      type(trust_t), intent(in) :: trust             !! Measures at the end
      type(log_t), intent(inout) :: log              !! Gets the warnings
      logical :: parts
      integer :: n

      parts = any([(allocated(simulation%fields(n)%sides), n=1, size(simulation%fields))])
      call warn_of_energy(simulation, parts, now, trust, log)
      call warn_of_momentum(simulation%scheme%method, trust, log)
      call warn_of_turning(simulation%scheme%method, trust, log)
      call warn_of_noise(simulation, parts, trust, log)
   end subroutine warn_of_balance

   !> Report at the end that nodes do not resolve the pressure, as in material that locks, with the
   !! remedy that lowered it in all tests of doc/theory/ledger.md. Collective.
   subroutine warn_of_noise(simulation, parts, trust, log)
      type(simulation_t), intent(in) :: simulation   !! Method and materials are used
      logical, intent(in) :: parts                   !! Does a body touch itself?
      type(trust_t), intent(in) :: trust             !! Measures at the end
      type(log_t), intent(inout) :: log              !! Gets the warning
      character(len=:), allocatable :: remedy
      character(len=16) :: times

      if (trust%failed) return
      if (verdict_of(trust_noise, trust%worst(trust_noise)) == trust_ok) return
      remedy = "use finer cells"
      if (simulation%space%grid%dimensions > 1 .and. .not. (simulation%scheme%method%even .or. &
         parts)) remedy = "write antilock = 'bbar' in &method, or use finer cells"
      write (times, "(f0.1)") min(trust%worst(trust_noise), 1.0e6_wp)
      call log%warn("warning: pressures of neighbouring particles differ by "//trim(times)// &
         " times the shear stress: material that keeps its volume locks, and is too stiff; "// &
         remedy//" [R116]")
   end subroutine warn_of_noise

   !> Report at the end that energy is lost, with the numbers of the lines `balance` and `trust`,
   !! and the remedy that lowered the loss in all tests of doc/guide/choose.md. Collective.
   subroutine warn_of_energy(simulation, parts, now, trust, log)
      type(simulation_t), intent(in) :: simulation   !! Method and materials are used
      logical, intent(in) :: parts                   !! Does a body touch itself?
      type(balance_t), intent(in) :: now             !! Balance at this time
      type(trust_t), intent(in) :: trust             !! Measures at the end
      type(log_t), intent(inout) :: log              !! Gets the warning
      character(len=:), allocatable :: remedy

      if (trust%failed) return
      remedy = "use finer cells"
      associate (method => simulation%scheme%method)
         ! usavg is the default unless a key excludes it; a body that touches itself, a cell and the
         ! scheme of the paper are refused with it, and so are filters of all velocities; materials
         ! that flow may become unstable with it
         if (stores_work(simulation%materials) .and. .not. (method%averages() .or. parts .or. &
            allocated(simulation%space%cell) .or. (method%dual .and. .not. method%leapfrog))) then
            remedy = "write stress_update = 'usavg' in &method"
            if (.not. method%transfer%flip_fraction() > 0.0_wp .or. (method%transfer%affine() &
               .and. .not. method%transfer%turning())) &
               remedy = "write transfer = 'rflip', stress_update = 'usavg' in &method"
         end if
      end associate
      if (now%energy_error < 0.0_wp .and. verdict_of(trust_energy, now%energy_error) /= trust_ok) &
         call log%warn("warning: "//percent(-now%energy_error)//" % of the energy is lost: "// &
         "materials without internal energy do not store the energy that strain update and "// &
         "transfers dissipate; "//remedy//" [R117]")
      if (verdict_of(trust_damped, now%damped_share) /= trust_ok) &
         call log%warn("warning: the transfers, in scenes with loose grains also "// &
         "the strain update, damp "//percent(now%damped_share)//" % of the energy, motion "// &
         "that nodes or particles do not resolve; "//remedy//" [R117]")
   end subroutine warn_of_energy

   !> A fraction in percent.
   pure function percent(fraction) result(text)
      real(wp), intent(in) :: fraction               !! [1]
      character(len=:), allocatable :: text
      character(len=16) :: digits

      if (fraction < 1.0e6_wp) then
         write (digits, "(f0.1)") 100.0_wp*fraction
      else
         write (digits, "(es8.1)") 100.0_wp*fraction
      end if
      text = trim(adjustl(digits))
   end function percent

   !> Report at the end that momentum is not conserved, with the error. Collective.
   subroutine warn_of_momentum(method, trust, log)
      type(method_t), intent(in) :: method           !! Numerical method of the run
      type(trust_t), intent(in) :: trust             !! Measures at the end
      type(log_t), intent(inout) :: log              !! Gets the warning
      character(len=:), allocatable :: remedy
      character(len=16) :: share

      if (trust%failed) return
      if (verdict_of(trust_momentum, trust%worst(trust_momentum)) == trust_ok) return
      remedy = "find the step at which the error begins in the history"
      if (method%surface /= surface_fill) remedy = "a cell with an empty node exerts a force "// &
         "where there is no mass; write free_surface = 'fill' in &method"
      write (share, "(es8.1)") abs(trust%worst(trust_momentum))
      call log%warn("warning: momentum is not conserved, error"//trim(share)//" of the "// &
         "greatest sum of m |v|: "//remedy//" [R127]")
   end subroutine warn_of_momentum

   !> Report at the end that angular momentum is not conserved, with the remedy. Collective.
   subroutine warn_of_turning(method, trust, log)
      type(method_t), intent(in) :: method           !! Numerical method of the run
      type(trust_t), intent(in) :: trust             !! Measures at the end
      type(log_t), intent(inout) :: log              !! Gets the warning
      character(len=:), allocatable :: remedy

      if (trust%failed) return
      if (verdict_of(trust_angular, trust%worst(trust_angular)) == trust_ok) return
      remedy = "use finer cells"
      if (.not. method%transfer%affine()) remedy = "the transfer slows rotation down; write "// &
         "transfer = 'rflip' in &method"
      call log%warn("warning: angular momentum is not conserved, error "// &
         percent(trust%worst(trust_angular))//" % of the greatest turning motion: "//remedy// &
         " [R133]")
   end subroutine warn_of_turning
end module output_balance_warnings
