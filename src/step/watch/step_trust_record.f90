! SPDX-License-Identifier: BSD-3-Clause
!> Indicators of how far results can be trusted: their values so far, means over time, limits, and
!! the text of the report. doc/theory/ledger.md has the limits and their reasons.
module step_trust_record
   use base_error, only: error_t
   use base_kinds, only: int64, wp
   use io_state, only: state_t
   use io_summary, only: json_t
   use particle_neighbours, only: lattice_t
   implicit none
   private

   public :: add_trust, load_trust, save_trust, trust_mean, trust_t, trust_text, verdict_of

   integer, parameter, public :: trust_energy = 1    !! Error of the energy balance at the end
   integer, parameter, public :: trust_volume = 2    !! Particle volume above the available volume
   integer, parameter, public :: trust_stretch = 3   !! Mass of particles far from their neighbours
   integer, parameter, public :: trust_noise = 4     !! Pressure that nodes do not resolve
   integer, parameter, public :: trust_speed = 5     !! Energy of particles that are too fast
   integer, parameter, public :: trust_heat = 6      !! Energy of particles that are too hot or cold
   integer, parameter, public :: trust_retired = 7   !! Mass of particles removed out of bounds
   integer, parameter, public :: trust_damped = 8 !! Energy dissipated by transfers and strain
   integer, parameter, public :: trust_momentum = 9  !! Error of the momentum balance at the end
   integer, parameter, public :: trust_angular = 10  !! Error of the balance of angular momentum
   integer, parameter, public :: trust_entries = 10  !! Number of these
   !> Entries with a mean over time, in this order
   integer, parameter, public :: trust_means(5) = &
      [trust_volume, trust_stretch, trust_speed, trust_heat, trust_noise]
   character(len=8), parameter, public :: trust_names(trust_entries) = [character(len=8) :: &
      "energy", "volume", "stretch", "noise", "speed", "heat", "retired", &
      "damped", "momentum", "angular"]
   integer, parameter, public :: trust_ok = 1, trust_suspect = 2, trust_bad = 3
   character(len=5), parameter, public :: trust_words(3) = [character(len=5) :: "ok", "check", &
      "bad"]
   !> Values up to these limits are ok, values beyond the next limits are bad
   real(wp), parameter :: ok_until(trust_entries) = &
      [0.02_wp, 0.1_wp, 0.01_wp, 1.0_wp, 0.02_wp, 0.02_wp, 0.0_wp, 0.05_wp, 1.0e-9_wp, 0.01_wp]
   real(wp), parameter :: bad_beyond(trust_entries) = &
      [0.1_wp, 0.25_wp, 0.1_wp, 3.0_wp, 0.1_wp, 0.1_wp, 0.01_wp, 0.5_wp, 0.01_wp, 0.05_wp]
   !> Distance of separated neighbours [cells]: one in ten pairs at this distance has no common node
   real(wp), parameter, public :: apart = 1.1_wp

   !> The record, kept from step to step. The same on all ranks.
   type :: trust_t
      real(wp) :: worst(trust_entries) = 0.0_wp      !! Values that are rated
      !> Greatest of single particles: distance of neighbours [cells], speed and energy over the
      !! explained ones; of noise: at one time
      real(wp) :: greatest(trust_entries) = 0.0_wp
      !> Integrals over time of the entries `trust_means`, and of what they are relative to; noise
      !! is a square. Of speed and heat: sums over the steps of energies, and of that of all
      real(wp) :: integral(size(trust_means)) = 0.0_wp, whole(size(trust_means)) = 0.0_wp
      real(wp) :: checked = 0.0_wp                   !! End of the integrals [s]
      real(wp) :: start_speed = 0.0_wp               !! Greatest speed at the start [m/s]
      real(wp) :: start_energy = 0.0_wp              !! Greatest energy per mass then [J/kg]
      real(wp) :: least_energy = 0.0_wp              !! Least internal energy [J/kg]
      real(wp) :: work = 0.0_wp                      !! Greatest work of walls and gravity [J]
      real(wp) :: load_work = 0.0_wp !! Bound on the work of loads on a particle [J/kg]
      logical :: begun = .false.                     !! Is the start known?
      logical :: failed = .false.                    !! Did the run have to end?
      logical :: warned(trust_entries) = .false.     !! Has a warning been given?
      !> (body) Lattices of the bodies, from the deck
      type(lattice_t), allocatable :: lattices(:)
   end type trust_t

contains

   !> Is a value ok, to be checked, or bad?
   pure integer function verdict_of(entry, value) result(verdict)
      integer, intent(in) :: entry                   !! Index of the value
      real(wp), intent(in) :: value                  !! In its unit

      verdict = trust_bad
      if (abs(value) <= bad_beyond(entry)) verdict = trust_suspect
      if (abs(value) <= ok_until(entry)) verdict = trust_ok
   end function verdict_of

   !> Mean over time of an entry of `trust_means`.
   pure real(wp) function trust_mean(trust, n) result(mean)
      type(trust_t), intent(in) :: trust             !! The values so far
      integer, intent(in) :: n                       !! Index in `trust_means`

      mean = 0.0_wp
      if (trust%whole(n) > 0.0_wp) mean = trust%integral(n)/trust%whole(n)
      if (trust_means(n) == trust_noise) mean = sqrt(mean)
   end function trust_mean

   !> The line at the end of a run.
   function trust_text(trust) result(text)
      type(trust_t), intent(in) :: trust             !! The values at the end
      character(len=:), allocatable :: text
      character(len=40) :: part
      integer :: entry, worst

      worst = merge(trust_bad, trust_ok, trust%failed)
      text = ""
      do entry = 1, trust_entries
         associate (verdict => verdict_of(entry, trust%worst(entry)))
            worst = max(worst, verdict)
            write (part, "(a,es9.1,a)") trim(trust_names(entry)), trust%worst(entry), &
               " "//trim(trust_words(verdict))
         end associate
         if (entry > 1) text = text//", "
         text = text//trim(part)
      end do
      write (part, "(f0.2)") trust%greatest(trust_stretch)
      if (part(1:1) == ".") part = "0"//trim(part)
      text = "trust     "//trim(trust_words(worst))//": "//text//"; neighbours at most "// &
         trim(part)//" cells apart"
   end function trust_text

   !> The same for scripts.
   subroutine add_trust(json, trust)
      type(json_t), intent(inout) :: json
      type(trust_t), intent(in) :: trust             !! The values at the end
      integer :: entry, worst

      call json%begin("trust")
      worst = merge(trust_bad, trust_ok, trust%failed)
      do entry = 1, trust_entries
         associate (verdict => verdict_of(entry, trust%worst(entry)))
            worst = max(worst, verdict)
            call json%begin(trim(trust_names(entry)))
            call json%add("value", trust%worst(entry))
            if (any(trust_means == entry)) then
               call json%add("mean", trust_mean(trust, findloc(trust_means, entry, dim=1)))
               if (entry /= trust_volume) call json%add("greatest", trust%greatest(entry))
            end if
            call json%add("verdict", trim(trust_words(verdict)))
            call json%end()
         end associate
      end do
      call json%add("verdict", trim(trust_words(worst)))
      call json%end()
   end subroutine add_trust

   !> Write the record to the state of a checkpoint.
   subroutine save_trust(trust, state)
      type(trust_t), intent(in) :: trust             !! Measures of trust
      type(state_t), intent(inout) :: state          !! State of the checkpoint

      call state%set("trust", [trust%worst, trust%greatest, trust%integral, trust%whole, &
         trust%checked, trust%start_speed, trust%start_energy, trust%least_energy, trust%work, &
         trust%load_work])
      call state%set("trust_flags", [merge(1_int64, 0_int64, trust%warned), &
         merge(1_int64, 0_int64, trust%begun)])
   end subroutine save_trust

   !> Read it from a checkpoint. If the checkpoint lacks it, the record starts empty.
   subroutine load_trust(trust, state)
      type(trust_t), intent(inout) :: trust          !! Measures of trust
      type(state_t), intent(in) :: state             !! State of the checkpoint
      integer, parameter :: means = size(trust_means), before = 2*trust_entries + 2*means
      real(wp), allocatable :: values(:)
      integer(int64), allocatable :: flags(:)
      type(error_t), allocatable :: error

      if (.not. (state%has("trust") .and. state%has("trust_flags"))) return
      call state%get("trust", values, error)
      if (allocated(error)) return
      call state%get("trust_flags", flags, error)
      if (allocated(error)) return
      if (size(values) /= before + 6 .or. size(flags) /= trust_entries + 1) return
      trust%worst = values(:trust_entries)
      trust%greatest = values(trust_entries + 1:2*trust_entries)
      trust%integral = values(2*trust_entries + 1:before - means)
      trust%whole = values(before - means + 1:before)
      associate (rest => values(before + 1:))
         trust%checked = rest(1)
         trust%start_speed = rest(2)
         trust%start_energy = rest(3)
         trust%least_energy = rest(4)
         trust%work = rest(5)
         trust%load_work = rest(6)
      end associate
      trust%warned = flags(:trust_entries) /= 0
      trust%begun = flags(trust_entries + 1) /= 0
   end subroutine load_trust
end module step_trust_record
