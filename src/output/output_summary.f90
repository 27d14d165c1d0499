! SPDX-License-Identifier: BSD-3-Clause
!> Report at the end of a run: tables in the log and CASE.summary.json.
module output_summary
   use base_error, only: error_t
   use base_kinds, only: int64, wp
   use base_log, only: log_t
   use base_text, only: text_t
   use base_version, only: git_commit, version_text
   use io_digest, only: state_digest
   use io_state, only: state_t
   use io_summary, only: json_t
   use material_effect_timers, only: divide_phase_time
   use omp_lib, only: omp_get_max_threads
   use output_balance_warnings, only: warn_of_balance
   use output_checkpoint, only: describe_state
   use output_loads, only: report_loads
   use output_rank_counts, only: add_rank_counts, find_rank_counts, rank_counts_t
   use output_signal_limit, only: add_signal_limit, find_signal_limit, signal_limit_t
   use output_streams, only: outputs_t
   use output_summary_steps, only: add_rules, steps_text
   use step_exact_error, only: measure_errors
   use step_ledger, only: balance_t, ledger_entries, removed_mass, removed_particles, &
      rigid_momentum
   use step_node_fields, only: node_needs_t, node_tally_t
   use step_simulation, only: simulation_t
   use step_sort_particles, only: count_particles
   use step_trust, only: final_trust
   use step_trust_record, only: add_trust, trust_t, trust_text
   implicit none
   private

   public :: summarise

   integer, parameter :: extremes = 5                !! Number of extremes
   character(len=12), parameter :: extreme_names(extremes) = [character(len=12) :: "speed_max", &
      "pressure_min", "pressure_max", "density_min", "density_max"]
   real(wp), parameter :: nano = 1.0e-9_wp           !! Times are added as integers [ns]
   integer, parameter :: kinds = 6                   !! Kinds of messages and lists of ranks
   character(len=21), parameter :: kind_names(kinds) = [character(len=21) :: "patch_messages", &
      "patch_bytes", "moving_messages", "moving_bytes", "tiles_sent", "tiles_listed_at_start"]

contains

   !> Write the tables and the summary. Collective.
   subroutine summarise(simulation, outputs, log, wall, timing, code, reason, error)
      type(simulation_t), intent(inout) :: simulation !! The run at its end
      type(outputs_t), intent(in) :: outputs         !! For names of files
      type(log_t), intent(inout) :: log              !! Gets the tables
      real(wp), intent(in) :: wall                   !! Wall time of the whole run [s]
      logical, intent(in) :: timing                  !! Table of phases?
      integer, intent(in) :: code                    !! Exit code
      character(len=*), intent(in) :: reason         !! Reason of the end
      type(error_t), allocatable, intent(out) :: error !! The file cannot be written
      type(json_t) :: json
      type(balance_t) :: now
      type(trust_t) :: trust
      type(signal_limit_t) :: limit
      type(rank_counts_t) :: counted
      character(len=16) :: digest
      integer(int64) :: counts(4), traffic(kinds)
      real(wp) :: rate, bytes, range(extremes)
      real(wp), allocatable :: least(:), mean(:), greatest(:)

      call simulation%balance%ledger%balance(simulation%machine%communicator, &
         simulation%space%grid, simulation%stores, simulation%materials, now)
      digest = digest_of(simulation)
      counts = [count_particles(simulation%stores), simulation%clock%updates, &
         simulation%clock%halved, nint(simulation%machine%worked/nano, int64)]
      call simulation%machine%communicator%total(counts)
      call spread_timers(simulation, wall, least, mean, greatest)
      rate = step_rate(simulation, counts(2), greatest)
      bytes = bytes_per_particle(simulation, counts(1))
      if (timing) call log%info(simulation%machine%timer%table(simulation%machine%communicator, &
         wall))
      call log%info(steps_text(simulation, wall, nano*real(counts(4), wp)))
      call find_signal_limit(simulation, log, limit)
      call log%info(balance_text(now, rate, real(counts(2), wp)/max(wall, nano), bytes))
      call final_trust(simulation, code, now, trust)
      call log%info(trust_text(trust))
      call warn_of_balance(simulation, now, trust, log)
      call count_traffic(simulation, traffic)
      call find_rank_counts(simulation, counted)
      if (simulation%machine%communicator%size > 1) call log%info(ranks_text(simulation, traffic))
      call find_extremes(simulation, range)
      call report_loads(simulation, log, json)
      if (allocated(simulation%effects%exact)) call measure_errors(simulation)
      if (simulation%machine%communicator%rank /= 0) return
      call add_end(json, outputs%case, code, reason)
      call json%add("particles", counts(1))
      call json%add("wall_s", wall)
      call add_work(json, counts(2), nano*real(counts(4), wp), rate, bytes)
      call add_layout(json, simulation, counted)
      call json%add("digest", digest)
      call add_extremes(json, range)
      call add_rules(json, simulation%clock%guard)
      call add_signal_limit(json, limit)
      call json%add("particles_halved", counts(3))
      call add_timers(json, simulation, least, mean, greatest)
      call add_balance(json, simulation, now, trust)
      if (simulation%machine%communicator%size > 1) call add_ranks(json, simulation, traffic)
      if (allocated(simulation%effects%exact)) call add_exact(json, simulation)
      call add_files(json, outputs)
      call json%write(outputs%folder//"/"//outputs%case//".summary.json", error)
   end subroutine summarise

   !> Digest of the state of a run. Collective.
   function digest_of(simulation) result(digest)
      type(simulation_t), intent(inout) :: simulation
      character(len=16) :: digest
      type(state_t) :: state

      call describe_state(simulation, state)
      digest = state_digest(simulation%machine%communicator, simulation%stores, state)
   end function digest_of

   !> The program, the case, and why it ended.
   subroutine add_end(json, case, code, reason)
      type(json_t), intent(inout) :: json
      character(len=*), intent(in) :: case           !! Prefix of all files
      integer, intent(in) :: code                    !! Exit code
      character(len=*), intent(in) :: reason         !! Reason of the end

      call json%add("version", version_text)
      call json%add("git", git_commit)
      call json%add("case", case)
      call json%add("exit_code", code)
      call json%add("reason", reason)
   end subroutine add_end

   !> Particle updates in the steps, and their rate.
   subroutine add_work(json, updates, worked, rate, bytes)
      type(json_t), intent(inout) :: json
      integer(int64), intent(in) :: updates          !! Number of particle updates on all ranks
      real(wp), intent(in) :: worked                 !! Processor time of all ranks [s]
      real(wp), intent(in) :: rate                   !! Updates a second of wall time
      real(wp), intent(in) :: bytes                  !! A particle

      call json%add("processor_s", worked)
      call json%add("particle_updates", updates)
      call json%add("particle_updates_per_s", rate)
      call json%add("bytes_per_particle", bytes)
   end subroutine add_work

   !> Steps and time, ranks and threads, and work and communication of the ranks.
   subroutine add_layout(json, simulation, counted)
      type(json_t), intent(inout) :: json
      type(simulation_t), intent(in) :: simulation
      type(rank_counts_t), intent(in) :: counted     !! Counts of the ranks

      call json%add("steps", simulation%clock%step)
      call json%add("time", simulation%clock%time)
      call json%add("ranks", simulation%machine%communicator%size)
      call json%add("threads", omp_get_max_threads())
      call add_rank_counts(json, counted, simulation%machine%communicator%size)
   end subroutine add_layout

   !> Times of all phases over the ranks, those of effects among them. Collective.
   subroutine spread_timers(simulation, wall, least, mean, greatest)
      type(simulation_t), intent(inout) :: simulation !! The run at its end
      real(wp), intent(in) :: wall                   !! Wall time of the whole run [s]
      real(wp), allocatable, intent(out) :: least(:) !! (phase) [s]
      real(wp), allocatable, intent(out) :: mean(:)  !! (phase) [s]
      real(wp), allocatable, intent(out) :: greatest(:) !! (phase) [s]
      integer :: phases

      call divide_phase_time(simulation%scratch%laps, simulation%machine%phase%gather, &
         simulation%machine%phase%effect, &
         simulation%machine%timer)
      phases = simulation%machine%timer%count()
      allocate (least(phases), mean(phases), greatest(phases))
      call simulation%machine%timer%spread(simulation%machine%communicator, wall, least, mean, &
         greatest)
   end subroutine spread_timers

   !> Particle updates per second of wall time in the steps, without output and checkpoints.
   pure real(wp) function step_rate(simulation, updates, seconds) result(rate)
      type(simulation_t), intent(in) :: simulation   !! For the phases
      integer(int64), intent(in) :: updates          !! On all ranks
      real(wp), intent(in) :: seconds(:)             !! (phase) Time of the slowest rank [s]
      real(wp) :: total

      associate (phase => simulation%machine%phase)
         total = seconds(phase%sort) + seconds(phase%scatter) + seconds(phase%exchange) &
            + seconds(phase%wait) + seconds(phase%grid) + seconds(phase%gather)
         if (phase%conduction > 0) total = total + seconds(phase%conduction)
         if (phase%contact > 0) total = total + seconds(phase%contact)
         total = total + sum(seconds(pack(phase%effect, phase%effect > 0)))
      end associate
      rate = 0.0_wp
      if (total > 0.0_wp) rate = real(updates, wp)/total
   end function step_rate

   !> Memory of particle and node fields for each particle [byte].
   real(wp) function bytes_per_particle(simulation, particles) result(bytes)
      type(simulation_t), intent(inout) :: simulation
      integer(int64), intent(in) :: particles        !! Number of particles on all ranks
      type(node_tally_t) :: tally
      integer(int64) :: total(1)
      integer :: index

      total = 0
      do index = 1, size(simulation%stores)
         associate (store => simulation%stores(index))
            total = total + int(store%bytes(), int64)*size(store%identity) &
               + 4_int64*size(store%cell_start)
         end associate
      end do
      do index = 1, size(simulation%fields)
         call simulation%fields(index)%count(node_needs_t(), tally)
      end do
      call simulation%effects%count(simulation%scheme%method, tally)
      total = total + 8_int64*tally%used
      call simulation%machine%communicator%total(total)
      bytes = 0.0_wp
      if (particles > 0) bytes = real(total(1), wp)/real(particles, wp)
   end function bytes_per_particle

   !> The ledger as two lines of text.
   function balance_text(now, rate, whole_rate, bytes) result(text)
      type(balance_t), intent(in) :: now             !! Ledger entries and errors
      real(wp), intent(in) :: rate                   !! Particle updates a second of the steps
      real(wp), intent(in) :: whole_rate             !! Rate of the whole call, output included
      real(wp), intent(in) :: bytes                  !! A particle
      character(len=:), allocatable :: text
      character(len=200) :: line

      write (line, "(4(a,es10.2))") "balance   error of mass", now%mass_error, ", momentum", &
         now%momentum_error, ", angular momentum", now%angular_error, ", energy", now%energy_error
      text = trim(line)//new_line("a")
      if (now%entry(removed_particles) > 0.0_wp) then
         write (line, "(a,i0,a,es10.3,a)") "removed   ", &
            nint(now%entry(removed_particles), int64), &
            " particles that failed or exceeded a limit, with", now%entry(removed_mass), " kg"
         text = text//trim(line)//new_line("a")
      end if
      write (line, "(a,f8.2,a,f8.2,a,i0,a)") "speed     ", 1.0e-6_wp*rate, &
         " million particle updates/s in the steps,", 1.0e-6_wp*whole_rate, &
         " with start and output; ", nint(bytes, int64), " bytes/particle"
      text = text//trim(line)
   end function balance_text

   !> Communication counts in the order of the names, summed over the ranks. Patches are node
   !! fields; migration data are particles that change ranks and data distributed evenly for files.
   !! The last number is the length of the longest list of tiles that a rank had at the start.
   subroutine count_traffic(simulation, traffic)
      type(simulation_t), intent(in) :: simulation
      integer(int64), intent(out) :: traffic(kinds)  !! In the order of the names
      integer(int64) :: listed(1)

      associate (said => simulation%machine%communicator%traffic, halo => simulation%space%halo)
         traffic = [halo%messages, 8*halo%words, said%messages - halo%messages, &
            8*(said%words - halo%words), simulation%machine%load%sent, 0_int64]
      end associate
      call simulation%machine%communicator%total(traffic)
      listed = -simulation%machine%load%listed
      call simulation%machine%communicator%least(listed)
      traffic(kinds) = -listed(1)
   end subroutine count_traffic

   !> Load balance and communication of the ranks, as lines of text.
   function ranks_text(simulation, traffic) result(text)
      type(simulation_t), intent(in) :: simulation
      integer(int64), intent(in) :: traffic(kinds)   !! In the order of the names
      character(len=:), allocatable :: text
      character(len=160) :: line
      real(wp) :: each

      text = ""
      associate (load => simulation%machine%load)
         if (load%measured > 0) then
            write (line, "(a,f6.3,a,f6.3,a,f6.3,a,i0,a)") "load      busiest rank over mean", &
               load%total/real(load%measured, wp), " on average,", load%last, " at the end,", &
               load%greatest, " at most after step 100; rebalanced ", load%cuts, " times"
            text = trim(line)//new_line("a")
         end if
      end associate
      each = 1.0_wp/(real(simulation%machine%communicator%size, &
         wp)*real(max(simulation%clock%step, 1_int64), wp))
      write (line, "(a,2(f6.2,a,es9.2,a))") "messages  per step and rank:", &
         each*real(traffic(1), wp), " of patches,", each*real(traffic(2), wp), " bytes; ", &
         each*real(traffic(3), wp), " of particles,", each*real(traffic(4), wp), " bytes"
      text = text//trim(line)
   end function ranks_text

   !> The same for scripts.
   subroutine add_ranks(json, simulation, traffic)
      type(json_t), intent(inout) :: json
      type(simulation_t), intent(in) :: simulation
      integer(int64), intent(in) :: traffic(kinds)   !! In the order of the names
      integer :: n

      associate (load => simulation%machine%load)
         call json%begin("work_of_ranks")
         call json%add("measurements", load%measured)
         call json%add("rebalanced", load%cuts)
         call json%add("busiest_over_mean_last", load%last)
         if (load%measured > 0) call json%add("busiest_over_mean", &
            load%total/real(load%measured, wp))
         call json%add("busiest_over_mean_worst", load%greatest)
         call json%end()
      end associate
      call json%begin("traffic")
      do n = 1, kinds
         call json%add(trim(kind_names(n)), traffic(n))
      end do
      call json%end()
   end subroutine add_ranks

   !> Greatest speed, and the ranges of pressure and density, over all particles and ranks; zero
   !! without particles.
   subroutine find_extremes(simulation, range)
      type(simulation_t), intent(in) :: simulation
      real(wp), intent(out) :: range(extremes)       !! In the order of the names
      real(wp) :: speed, pressure, density
      integer :: index, tile, p

      range = -huge(1.0_wp)
      do index = 1, size(simulation%stores)
         associate (store => simulation%stores(index))
            do tile = 1, size(store%count)
               do p = store%first(tile), store%first(tile) + store%count(tile) - 1
                  speed = sqrt(store%velocity(p, 1)**2 + store%velocity(p, 2)**2 &
                     + store%velocity(p, 3)**2)
                  pressure = -(store%state%stress(p, 1) + store%state%stress(p, 2) &
                     + store%state%stress(p, 3))/3.0_wp
                  density = store%state%mass(p)/store%state%volume(p)
                  range = max(range, [speed, -pressure, pressure, -density, density])
               end do
            end do
         end associate
      end do
      do p = 1, extremes
         range(p) = simulation%machine%communicator%maximum(range(p))
      end do
      range([2, 4]) = -range([2, 4])
      if (range(1) < 0.0_wp) range = 0.0_wp
   end subroutine find_extremes

   !> Extremes of the final state.
   subroutine add_extremes(json, range)
      type(json_t), intent(inout) :: json
      real(wp), intent(in) :: range(extremes)        !! In the order of the names
      integer :: n

      call json%begin("extremes")
      do n = 1, extremes
         call json%add(trim(extreme_names(n)), range(n))
      end do
      call json%end()
   end subroutine add_extremes

   !> Wall time by phase.
   subroutine add_timers(json, simulation, least, mean, greatest)
      type(json_t), intent(inout) :: json
      type(simulation_t), intent(in) :: simulation   !! Names
      real(wp), intent(in) :: least(:)               !! (phase) [s]
      real(wp), intent(in) :: mean(:)                !! (phase) [s]
      real(wp), intent(in) :: greatest(:)            !! (phase) [s]
      integer :: n

      call json%begin("timers")
      do n = 1, simulation%machine%timer%count()
         call json%begin(trim(simulation%machine%timer%name(n)))
         call json%add("min", least(n))
         call json%add("avg", mean(n))
         call json%add("max", greatest(n))
         call json%add("calls", simulation%machine%timer%calls(n))
         call json%end()
      end do
      call json%end()
   end subroutine add_timers

   !> The ledger, and the trust indicators.
   subroutine add_balance(json, simulation, now, trust)
      type(json_t), intent(inout) :: json
      type(simulation_t), intent(in) :: simulation   !! With the start
      type(balance_t), intent(in) :: now
      type(trust_t), intent(in) :: trust             !! The values at the end

      call add_ledger(json, simulation, now)
      call add_trust(json, trust)
   end subroutine add_balance

   !> Every entry at the start and the end, and the errors.
   subroutine add_ledger(json, simulation, now)
      type(json_t), intent(inout) :: json
      type(simulation_t), intent(in) :: simulation   !! With the start
      type(balance_t), intent(in) :: now
      integer :: n

      call json%begin("ledger")
      call json%add("mass_error", now%mass_error)
      call json%add("momentum_error", now%momentum_error)
      call json%add("angular_momentum_error", now%angular_error)
      call json%add("energy_error", now%energy_error)
      call json%begin("start")
      do n = 1, size(ledger_entries)
         if (n >= rigid_momentum .and. .not. simulation%balance%ledger%has_bodies) exit
         call json%add(trim(ledger_entries(n)%name), simulation%balance%ledger%start%entry(n))
      end do
      call json%add("total", simulation%balance%ledger%start%total)
      call json%end()
      call json%begin("end")
      do n = 1, size(ledger_entries)
         if (n >= rigid_momentum .and. .not. simulation%balance%ledger%has_bodies) exit
         call json%add(trim(ledger_entries(n)%name), now%entry(n))
      end do
      call json%add("total", now%total)
      call json%end()
      call json%end()
   end subroutine add_ledger

   !> Errors against the exact solution: now, and the greatest of displacement in the histories,
   !! also over the greatest displacement of the solution.
   subroutine add_exact(json, simulation)
      type(json_t), intent(inout) :: json
      type(simulation_t), intent(in) :: simulation   !! With the errors

      associate (case => simulation%effects%exact)
         call json%begin("exact")
         call json%add("displacement_error", case%error(1))
         call json%add("velocity_error", case%error(2))
         call json%add("stress_error", case%error(3))
         call json%add("greatest_displacement_error", case%greatest_error)
         call json%add("greatest_displacement", case%greatest_motion)
         if (case%greatest_motion > 0.0_wp) call json%add("relative_displacement_error", &
            case%greatest_error/case%greatest_motion)
         call json%end()
      end associate
   end subroutine add_exact

   !> Names of the output files.
   subroutine add_files(json, outputs)
      type(json_t), intent(inout) :: json
      type(outputs_t), intent(in) :: outputs
      type(text_t), allocatable :: keys(:), files(:)
      integer :: n

      call outputs%list(keys, files)
      call json%begin("files")
      do n = 1, size(keys)
         call json%add(keys(n)%text, files(n)%text)
      end do
      call json%end()
   end subroutine add_files
end module output_summary
