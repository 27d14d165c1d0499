! SPDX-License-Identifier: BSD-3-Clause
!> Names the particle for which a run has to stop: the same words for any ranks and threads.
module step_offending_particle
   use base_communicator, only: communicator_t
   use base_error, only: without_code
   use base_kinds, only: int64, wp
   use material_type, only: material_t
   use particle_split, only: generation_of, root_of
   use particle_store, only: moved_off, store_t
   use step_bounds, only: bounds_t, fault_fast, fault_inverted, fault_large, fault_none, &
      fault_small, fault_stress, fault_velocity, find_fault, guard_t, rule_conduction, rule_strain
   use step_method, only: method_t
   use step_simulation, only: clock_t, simulation_t
   implicit none
   private

   public :: fixed_step_text, name_offending_particle, name_limiting, name_particle, replay_text, &
      broadcast_text, step_text, tile_bounds

   !> A particle of this rank, or none.
   type :: found_t
      integer(int64) :: identity = huge(1_int64)     !! Lowest so far
      integer :: store = 0                           !! Store of the particle, 0 = none found
      integer :: tile = 0                            !! Tile of the particle
      integer :: particle = 0                        !! Index of the particle in the store
   end type found_t

contains

   !> Bounds for the particles of a material. Failed material without stress may have any volume.
   pure function tile_bounds(material, guard) result(bounds)
      type(material_t), intent(in) :: material
      type(guard_t), intent(in) :: guard
      type(bounds_t) :: bounds

      bounds = guard%bounds
      if (.not. allocated(material%failure%fracture)) return
      if (.not. material%failure%fracture%leaves_nothing) return
      bounds%ratio_min = 0.0_wp
      bounds%ratio_max = huge(1.0_wp)
   end function tile_bounds

   !> Text on the particle of lowest identity that is out of its bounds. Collective.
   subroutine name_offending_particle(simulation, text)
      type(simulation_t), intent(in) :: simulation   !! Just after the step
      character(len=:), allocatable, intent(out) :: text !! Step, time, particle, error
      type(found_t) :: found
      integer :: fault
      real(wp) :: value

      call find_bad(simulation%materials, simulation%stores, simulation%clock%guard, found)
      call keep_lowest(simulation%machine%communicator, found)
      text = ""
      if (found%store > 0) then
         associate (store => simulation%stores(found%store))
            call find_fault(store, found%particle, simulation%materials(found%store)%density, &
               tile_bounds(simulation%materials(found%store), simulation%clock%guard), fault, value)
         end associate
         text = particle_text(simulation, found)//": "//fault_text(simulation%clock%guard, fault, &
            value)//reason_text(simulation%materials, simulation%stores, found, fault)
      end if
      call broadcast_text(simulation%machine%communicator, text)
      if (len(text) == 0) text = "a wave speed is not a finite number [R104]"
      text = step_text(simulation%clock)//": "//text//fixed_step_text(simulation%scheme%method, &
         simulation%clock)//new_line("a")// replay_text(simulation%clock)
   end subroutine name_offending_particle

   !> If `dt_fixed` is longer than the stable step, a hint that it may be the cause.
   function fixed_step_text(method, clock) result(text)
      type(method_t), intent(in) :: method
      type(clock_t), intent(in) :: clock
      character(len=:), allocatable :: text
      character(len=240) :: line

      text = ""
      associate (fixed => clock%guard%bounds%dt_fixed, stable => clock%dt_next)
         if (.not. (fixed > stable .and. stable > 0.0_wp)) return
         write (line, "(a,es10.3,a,es9.2,a,es10.3,a,f5.2,a)") "dt_fixed =", fixed, " s is", &
            fixed/stable, " times the stable step before,", stable, " s with cfl =", method%cfl, &
            "; write that or less, or remove dt_fixed"
      end associate
      text = new_line("a")//trim(line)
   end function fixed_step_text

   !> How to get the state before the last step. The program does not store it, because this would
   !! double the memory; a repeated run gives the same bits.
   function replay_text(clock) result(text)
      type(clock_t), intent(in) :: clock
      character(len=:), allocatable :: text
      character(len=24) :: before

      write (before, "(i0)") clock%step - 1
      text = "this state is written to snapshots but not to a checkpoint; to get the state "// &
         "before this step run again with -s time.max_steps="//trim(before)// &
         ", and with --restart if there is a checkpoint [R110]"
   end function replay_text

   !> Text on the particle that limits the time step. Collective.
   subroutine name_limiting(simulation, text)
      type(simulation_t), intent(in) :: simulation   !! Between two steps
      character(len=:), allocatable, intent(out) :: text !! Step, time, particle, and its speeds
      type(found_t) :: found
      real(wp) :: signal, speed
      character(len=100) :: line

      associate (guard => simulation%clock%guard)
         if (guard%rule == rule_conduction) then
            text = step_text(simulation%clock)//": heat conduction limits it"
            return
         end if
         if (guard%rule == rule_strain) then
            found%identity = guard%steepest
            call find_identity(simulation%stores, found)
         else
            call find_fastest(simulation%materials, simulation%stores, &
               simulation%machine%communicator, found)
         end if
         call keep_lowest(simulation%machine%communicator, found)
         text = ""
         if (found%store > 0) then
            call find_speeds(simulation%materials(found%store), simulation%stores(found%store), &
               found%particle, signal, speed)
            write (line, "(a,es10.3,a,es10.3,a)") ": wave speed", signal, &
               " m/s, speed", speed, " m/s"
            text = particle_text(simulation, found)//trim(line)
         end if
         call broadcast_text(simulation%machine%communicator, text)
         if (len(text) == 0) text = "no particle is left"
         if (guard%rule == rule_strain) then
            write (line, "(a,es10.3,a)") ", velocity gradient", guard%rate, " 1/s"
            text = text//trim(line)
         end if
         text = step_text(simulation%clock)//": "//text
      end associate
   end subroutine name_limiting

   !> Text on a particle whose identity is known. Collective.
   subroutine name_particle(simulation, identity, text)
      type(simulation_t), intent(in) :: simulation   !! Between two steps
      integer(int64), intent(in) :: identity         !! Identity
      character(len=:), allocatable, intent(out) :: text !! Body, material and position
      type(found_t) :: found

      found%identity = identity
      call find_identity(simulation%stores, found)
      call keep_lowest(simulation%machine%communicator, found)
      text = ""
      if (found%store > 0) text = particle_text(simulation, found)
      call broadcast_text(simulation%machine%communicator, text)
   end subroutine name_particle

   !> Particle of lowest identity on this rank that is out of its bounds.
   pure subroutine find_bad(materials, stores, guard, found)
      type(material_t), intent(in) :: materials(:)
      type(store_t), intent(in) :: stores(:)
      type(guard_t), intent(in) :: guard
      type(found_t), intent(out) :: found
      type(bounds_t) :: bounds
      integer :: index, tile, p, fault
      real(wp) :: value

      do index = 1, size(stores)
         bounds = tile_bounds(materials(index), guard)
         associate (store => stores(index), &
            density => materials(index)%density)
            do tile = 1, size(store%count)
               do p = store%first(tile), store%first(tile) + store%count(tile) - 1
                  if (store%identity(p) > found%identity .or. store%home(p) == moved_off) cycle
                  call find_fault(store, p, density, bounds, fault, value)
                  if (fault /= fault_none) found = found_t(store%identity(p), index, tile, p)
               end do
            end do
         end associate
      end do
   end subroutine find_bad

   !> Find a particle by its identity.
   pure subroutine find_identity(stores, found)
      type(store_t), intent(in) :: stores(:)
      type(found_t), intent(inout) :: found
      integer :: index, tile, p

      do index = 1, size(stores)
         associate (store => stores(index))
            do tile = 1, size(store%count)
               do p = store%first(tile), store%first(tile) + store%count(tile) - 1
                  if (store%identity(p) == found%identity) &
                     found = found_t(store%identity(p), index, tile, p)
               end do
            end do
         end associate
      end do
   end subroutine find_identity

   !> Particle of lowest identity among those with the greatest sum of wave speed and speed.
   subroutine find_fastest(materials, stores, communicator, found)
      type(material_t), intent(in) :: materials(:)
      type(store_t), intent(in) :: stores(:)
      type(communicator_t), intent(in) :: communicator
      type(found_t), intent(out) :: found            !! The particle if this rank has it
      real(wp) :: fastest, signal, speed
      integer :: index, tile, p

      fastest = 0.0_wp
      do index = 1, size(stores)
         associate (store => stores(index))
            do tile = 1, size(store%count)
               do p = store%first(tile), store%first(tile) + store%count(tile) - 1
                  call find_speeds(materials(index), stores(index), p, signal, speed)
                  if (.not. (signal + speed > fastest .or. signal + speed >= fastest .and. &
                     store%identity(p) < found%identity)) cycle
                  fastest = signal + speed
                  found = found_t(store%identity(p), index, tile, p)
               end do
            end do
         end associate
      end do
      if (fastest < communicator%maximum(fastest)) found = found_t()
   end subroutine find_fastest

   !> Wave speed of a particle without artificial viscosity, and the speed of its motion.
   pure subroutine find_speeds(material, store, p, signal, speed)
      type(material_t), intent(in) :: material
      type(store_t), intent(in) :: store
      integer, intent(in) :: p
      real(wp), intent(out) :: signal                !! [m/s]
      real(wp), intent(out) :: speed                 !! [m/s]

      signal = material%signal_speed(store%state, p, p)
      speed = norm2([store%velocity(p, 1), store%velocity(p, 2), store%velocity(p, 3)])
   end subroutine find_speeds

   !> Leave only the particle of lowest identity of all ranks.
   subroutine keep_lowest(communicator, found)
      type(communicator_t), intent(in) :: communicator
      type(found_t), intent(inout) :: found          !! That of this rank in, none out if not lowest
      integer(int64) :: least(1)

      least = found%identity
      call communicator%least(least)
      if (found%identity /= least(1)) found = found_t()
   end subroutine keep_lowest

   !> Step and time.
   function step_text(clock) result(text)
      type(clock_t), intent(in) :: clock
      character(len=:), allocatable :: text
      character(len=80) :: line

      write (line, "(a,i0,a,es11.4,a,es11.4,a)") "step ", clock%step, ", time", &
         clock%time, " s, dt", clock%dt, " s"
      text = trim(line)
   end function step_text

   !> Identity, body and position of a particle as text.
   function particle_text(simulation, found) result(text)
      type(simulation_t), intent(in) :: simulation
      type(found_t), intent(in) :: found
      character(len=:), allocatable :: text
      character(len=100) :: line
      integer :: body

      associate (store => simulation%stores(found%store), p => found%particle)
         body = 1
         if (allocated(store%body)) body = int(store%body(p))
         if (generation_of(store%identity(p)) > 0) then
            write (line, "(a,i0,a,i0,a)") "particle ", store%identity(p), ", a part of ", &
               root_of(store%identity(p)), ", of body "
         else
            write (line, "(a,i0,a)") "particle ", store%identity(p), " of body "
         end if
         text = trim(line)//" "
         write (line, "(i0)") body
         if (allocated(simulation%body_names)) line = "'"//simulation%body_names(body)%text//"'"
         text = text//trim(line)//", material '"//simulation%materials(found%store)%name//"',"
         write (line, "(a,3es11.3,a)") " at", store%position(p, :), " m"
         text = text//trim(line)
      end associate
   end function particle_text

   !> Description of the error.
   function fault_text(guard, fault, value) result(text)
      type(guard_t), intent(in) :: guard
      integer, intent(in) :: fault                   !! Kind of fault
      real(wp), intent(in) :: value                  !! Quantity that shows the error
      character(len=:), allocatable :: text
      character(len=160) :: line

      associate (bounds => guard%bounds)
         select case (fault)
         case (fault_velocity)
            line = "its velocity is not a finite number [R104]"
         case (fault_stress)
            line = "its stress is not a finite number [R104]"
         case (fault_inverted)
            write (line, "(a,es10.3,a)") &
               "it is inverted: the determinant of its deformation is ", value, " [R105]"
         case (fault_small)
            write (line, "(a,es10.3,a,es10.3,a)") "its volume over the reference volume,", value, &
               ", is below volume_ratio_min =", bounds%ratio_min, " [R106]"
         case (fault_large)
            write (line, "(a,es10.3,a,es10.3,a)") "its volume over the reference volume,", value, &
               ", is above volume_ratio_max =", bounds%ratio_max, " [R107]"
         case (fault_fast)
            write (line, "(a,es10.3,a,es10.3,a)") "its speed", value, &
               " m/s is above speed_max =", bounds%speed_max, " m/s [R108]"
         case default
            line = "its volume is not a finite number [R104]"
         end select
      end associate
      text = trim(line)
   end function fault_text

   !> Reason why the material has no stress, if its equation of state or its law gives one.
   function reason_text(materials, stores, found, fault) result(text)
      type(material_t), intent(in) :: materials(:)
      type(store_t), intent(in) :: stores(:)
      type(found_t), intent(in) :: found             !! A particle of this rank
      integer, intent(in) :: fault                   !! Kind of fault
      character(len=:), allocatable :: text

      text = ""
      if (fault /= fault_stress) return
      associate (state => stores(found%store)%state, p => found%particle, &
         material => materials(found%store))
         if (allocated(material%eos) .and. allocated(state%energy)) &
            text = material%eos%fault_of_state(state%mass(p)/state%volume(p), state%energy(p))
         if (len(text) == 0 .and. allocated(material%law)) &
            text = material%law%fault_of_state(state, p)
      end associate
      if (len(text) > 0) text = "; "//without_code(text)
   end function reason_text

   !> Send the text of the one rank with a text to all ranks.
   subroutine broadcast_text(communicator, text)
      type(communicator_t), intent(in) :: communicator
      character(len=:), allocatable, intent(inout) :: text !! Own in, that of all out
      integer(int64), allocatable :: whole(:)
      integer :: n

      call communicator%gather([(int(iachar(text(n:n)), int64), n=1, len(text))], whole)
      text = repeat(" ", size(whole))
      do n = 1, size(whole)
         text(n:n) = achar(int(whole(n)))
      end do
   end subroutine broadcast_text
end module step_offending_particle
