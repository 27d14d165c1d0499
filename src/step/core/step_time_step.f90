! SPDX-License-Identifier: BSD-3-Clause
!> The end of a step: the sums of the threads, and the length of the next step.
module step_time_step
   use base_error, only: error_t, exit_physics, fail
   use base_kinds, only: int64, wp
   use particle_store, only: store_t
   use material_type, only: material_t
   use step_agreement, only: agree_with_ranks, extremes_t
   use step_bounds, only: guard_t, rule_conduction, rule_growth, rule_signal, rule_strain
   use step_conduction, only: bulk_volume, conducts_heat
   use step_method, only: method_t
   use step_offending_particle, only: name_offending_particle
   use step_remove_particles, only: check_retired
   use step_simulation, only: clock_t, scratch_t, simulation_t, space_t
   use step_wall_contact, only: approaches_walls
   implicit none
   private

   public :: finish_step, conduction_step, find_stable_step, greatest_diffusivity

contains

   !> Collect the results of the threads: the ledger, the next time step, NaN.
   subroutine finish_step(simulation, began, error)
      type(simulation_t), intent(inout) :: simulation
      real(wp), intent(in) :: began                  !! Begin of the step [s]
      type(error_t), allocatable, intent(out) :: error !! If a value is NaN
      type(extremes_t) :: extremes
      character(len=:), allocatable :: text
      logical :: sound
      integer :: thread

      associate (balance => simulation%balance)
         sound = .true.
         call find_rate(simulation%clock%guard, simulation%scratch, extremes%rate)
         do thread = 0, ubound(simulation%scratch, 1)
            associate (scratch => simulation%scratch(thread))
               extremes%fastest = max(extremes%fastest, scratch%fastest)
               extremes%load_work = max(extremes%load_work, scratch%load_work)
               sound = sound .and. scratch%sound
               extremes%retired = extremes%retired .or. scratch%retired
               call balance%ledger%merge(scratch%ledger)
               call scratch%ledger%clear()
               scratch%fastest = 0.0_wp
               scratch%load_work = 0.0_wp
               scratch%sound = .true.
               scratch%retired = .false.
            end associate
         end do
         ! a NaN on one rank must stop all: it travels as an infinite speed
         if (.not. sound .or. .not. extremes%fastest <= huge(1.0_wp)) &
            extremes%fastest = huge(1.0_wp)
         if (allocated(simulation%effects%conduction)) extremes%diffusivity = &
            greatest_diffusivity(simulation%materials, simulation%stores)
         extremes%approached = approaches_walls(simulation)
         call agree_with_ranks(simulation, began, extremes)
         simulation%space%approached = extremes%approached
         ! a bound on the work that any particle has received: (L.10) of doc/theory/ledger.md
         balance%trust%load_work = balance%trust%load_work + extremes%load_work
         if (.not. extremes%sound()) then
            call name_offending_particle(simulation, text)
            call fail(error, exit_physics, text)
            return
         end if
         if (extremes%retired) call check_retired(simulation%clock, balance%ledger, &
            simulation%machine%communicator, error)
         if (allocated(error)) return
         call set_next_step(simulation%space, simulation%scheme%method, simulation%clock, &
            extremes%fastest, extremes%diffusivity, extremes%rate)
      end associate
   end subroutine finish_step

   !> Steepest velocity gradient of all threads, and the identity of its particle.
   subroutine find_rate(guard, scratches, rate)
      type(guard_t), intent(inout) :: guard
      type(scratch_t), intent(inout) :: scratches(0:)
      real(wp), intent(out) :: rate                  !! Rate on this rank [1/s]
      integer :: thread
      real(wp) :: most

      most = 0.0_wp
      associate (who => guard%steepest)
         who = huge(who)
         do thread = 0, ubound(scratches, 1)
            associate (scratch => scratches(thread))
               if (scratch%steepest > most) who = huge(who)
               if (scratch%steepest >= most) who = min(who, scratch%steepest_identity)
               most = max(most, scratch%steepest)
               scratch%steepest = 0.0_wp
               scratch%steepest_identity = huge(who)
            end associate
         end do
      end associate
      rate = sqrt(most)
   end subroutine find_rate

   !> Stable time step for the fastest signal and the steepest gradient, not growing too fast.
   !! Equation (S.3) of doc/theory/time_step.md.
   pure subroutine set_next_step(space, method, clock, fastest, diffusivity, rate)
      type(space_t), intent(in) :: space
      type(method_t), intent(in) :: method
      type(clock_t), intent(inout) :: clock
      real(wp), intent(in) :: fastest                !! Fastest signal and motion [m/s]
      real(wp), intent(in) :: diffusivity            !! Greatest of all particles [m2/s]
      real(wp), intent(in) :: rate                   !! Steepest velocity gradient [1/s]
      real(wp) :: dt, grown

      associate (guard => clock%guard)
         guard%rate = rate
         call find_stable_step(space, method%cfl, fastest, diffusivity, dt, guard%rule)
         if (rate*dt > guard%bounds%strain_max) then
            dt = guard%bounds%strain_max/rate
            guard%rule = rule_strain
         end if
         grown = method%step_growth*clock%dt_next
         if (grown < dt) guard%rule = rule_growth
         clock%dt_next = min(dt, grown)
      end associate
   end subroutine set_next_step

   !> Stable time step for the fastest signal on the mesh, and for conduction of heat: that of the
   !! first step, of all later ones, and of `--check`. Equation (S.1) of doc/theory/time_step.md.
   pure subroutine find_stable_step(space, courant, fastest, diffusivity, dt, rule)
      type(space_t), intent(in) :: space
      real(wp), intent(in) :: courant                !! Courant number of the signal
      real(wp), intent(in) :: fastest                !! Fastest signal and motion [m/s]
      real(wp), intent(in) :: diffusivity            !! Greatest of all particles [m2/s]
      real(wp), intent(out) :: dt                    !! [s]
      integer, intent(out) :: rule                   !! What limits it
      real(wp) :: longest

      dt = huge(dt)
      rule = rule_signal
      if (fastest > 0.0_wp) dt = courant*space%grid%spacing/space%mesh_time(fastest)
      longest = conduction_step(space%grid%spacing, space%grid%dimensions, diffusivity)
      if (.not. longest < dt) return
      dt = longest
      rule = rule_conduction
   end subroutine find_stable_step

   !> Greatest time step that conduction allows [s]: half of the square of the spacing over the
   !! diffusivity and the number of directions. Equation (A.17) of
   !! doc/theory/matter.md.
   pure real(wp) function conduction_step(spacing, dimensions, diffusivity) result(dt)
      real(wp), intent(in) :: spacing                !! Spacing of the grid [m]
      integer, intent(in) :: dimensions              !! Number of dimensions of the grid
      real(wp), intent(in) :: diffusivity            !! Greatest of all particles [m2/s]

      dt = huge(dt)
      if (diffusivity > 0.0_wp) dt = spacing**2/(2.0_wp*real(dimensions, wp)*diffusivity)
   end function conduction_step

   !> Greatest diffusivity [m2/s] of the particles of this rank.
   real(wp) function greatest_diffusivity(materials, stores) result(greatest)
      type(material_t), intent(in) :: materials(:)
      type(store_t), intent(in) :: stores(:)
      real(wp) :: conductivity, specific_heat
      integer :: index, tile, p

      greatest = 0.0_wp
      do index = 1, size(stores)
         if (.not. conducts_heat(materials(index))) cycle
         conductivity = materials(index)%heat%conductivity
         specific_heat = materials(index)%heat%specific_heat
         !$omp parallel do default(none) private(tile, p) reduction(max:greatest) &
         !$omp shared(stores, index, conductivity, specific_heat) schedule(static)
         do tile = 1, size(stores(index)%count)
            associate (store => stores(index))
               do p = store%first(tile), store%first(tile) + store%count(tile) - 1
                  greatest = max(greatest, conductivity*bulk_volume(store, p) &
                     /(store%state%mass(p)*specific_heat))
               end do
            end associate
         end do
      end do
   end function greatest_diffusivity
end module step_time_step
