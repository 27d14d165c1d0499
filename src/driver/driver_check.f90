! SPDX-License-Identifier: BSD-3-Clause
!> What a run will cost, said before it starts.
module driver_check
   use base_kinds, only: int64, wp
   use base_text, only: number, size_text
   use driver_contact_deck, only: contact_columns, contact_text
   use driver_heat, only: conduction_step
   use driver_output, only: snapshot_bytes
   use driver_run, only: limits_t
   use driver_simulation, only: simulation_t
   use driver_solid_volumes, only: solid_volumes_text
   use driver_start, only: survey_t
   use material_matter, only: matter_t
   use material_type, only: material_t
   use material_wishes, only: wishes_t
   use mesh_boundary, only: face_friction, face_slip, face_stick, face_symmetry
   use mesh_tiles, only: neighbors
   use particle_fill, only: body_t
   use transfer_scatter, only: dual_columns
   implicit none
   private

   public :: cost_text, expected_steps

contains

   !> The table of costs.
   function cost_text(simulation, bodies, survey, limits, snapshots) result(text)
      type(simulation_t), intent(in) :: simulation   !! The run without particles
      type(body_t), intent(in) :: bodies(:)          !! The bodies
      type(survey_t), intent(in) :: survey           !! The counts
      type(limits_t), intent(in) :: limits           !! End of the run
      integer(int64), intent(in) :: snapshots        !! Snapshots that will be written
      character(len=:), allocatable :: text
      character(len=:), allocatable :: cause
      real(wp) :: dt, steps, bytes

      call first_step(simulation, bodies, limits, dt, cause)
      steps = expected_steps(simulation, bodies, limits)
      bytes = memory(simulation, survey)
      text = grid_line(simulation, survey)//new_line("a")//points_text(bodies, survey) &
         //solid_volumes_text(simulation%grid, bodies, survey%body) &
         //fields_text(simulation, survey)
      if (allocated(simulation%contact)) text = text//contact_text(simulation, bodies)
      text = text &
         //"step       first dt "//short(dt)//" s"//cause//"; about "// &
         number(nint(steps, int64))//" steps"// &
         new_line("a")// &
         "memory     "//size_text(bytes)//" for particle and node fields, on all ranks together"// &
         new_line("a")// &
         "output     "//number(snapshots)//" snapshots, about "//size_text(real(snapshots, wp) &
         *real(survey%particles, wp)*snapshot_bytes)//"; a checkpoint "// &
         size_text(real(survey%particles, wp)*carried(simulation, survey))//new_line("a")
   end function cost_text

   !> Steps of the whole run if all are as long as the first one, or as those of the first impact.
   real(wp) function expected_steps(simulation, bodies, limits) result(steps)
      type(simulation_t), intent(in) :: simulation   !! The run without particles
      type(body_t), intent(in) :: bodies(:)          !! The bodies
      type(limits_t), intent(in) :: limits           !! End of the run
      real(wp), parameter :: countless = 1.0e18_wp   ! still a long whole number
      character(len=:), allocatable :: cause
      real(wp) :: dt

      call first_step(simulation, bodies, limits, dt, cause)
      if (.not. limits%dt_fixed > 0.0_wp) dt = min(dt, impact_step(simulation, bodies))
      steps = 0.0_wp
      if (dt > 0.0_wp .and. dt < huge(dt)) steps = min(limits%time_end/dt, countless)
      if (limits%max_steps < huge(1_int64)) steps = min(steps, real(limits%max_steps, wp))
   end function expected_steps

   !> Time step in the shock where two bodies that come nearer meet, or one meets a wall. Equation
   !! (S.4) of doc/theory/time_step.md.
   real(wp) function impact_step(simulation, bodies) result(dt)
      type(simulation_t), intent(in) :: simulation   !! The run without particles
      type(body_t), intent(in) :: bodies(:)          !! The bodies
      real(wp) :: low(3, size(bodies)), high(3, size(bodies)), apart(3), coming(3), fastest, moving
      real(wp) :: stiff(2), jump
      integer :: one, other

      do one = 1, size(bodies)
         call bodies(one)%shape%bounds(low(:, one), high(:, one))
         low(:, one) = max(low(:, one), simulation%grid%lower)
         high(:, one) = min(high(:, one), simulation%grid%upper)
      end do
      fastest = 0.0_wp
      do one = 1, size(bodies)
         associate (body => bodies(one), here => simulation%materials(bodies(one)%store))
            moving = norm2(body%velocity)
            stiff(1) = here%density*here%reference_speed()
            do other = 1, size(bodies)
               if (other == one) cycle
               associate (there => simulation%materials(bodies(other)%store))
                  coming = body%velocity - bodies(other)%velocity
                  apart = 0.5_wp*(low(:, other) + high(:, other) - low(:, one) - high(:, one))
                  if (.not. dot_product(coming, apart) > 0.0_wp) cycle
                  stiff(2) = there%density*there%reference_speed()
                  jump = norm2(coming)*stiff(2)/max(sum(stiff), tiny(jump))
                  ! in the middle of the shock half of the jump is done
                  fastest = max(fastest, shock_signal(here, jump) + norm2(body%velocity &
                     - 0.5_wp*jump/norm2(coming)*coming))
               end associate
            end do
            if (meets_wall(simulation, body%velocity)) &
               fastest = max(fastest, shock_signal(here, moving) + 0.5_wp*moving)
         end associate
      end do
      dt = huge(dt)
      if (fastest > 0.0_wp) dt = simulation%method%cfl*simulation%grid%spacing/fastest
   end function impact_step

   !> Is there a closed face that a body flies to, or a rigid region?
   pure logical function meets_wall(simulation, velocity) result(meets)
      type(simulation_t), intent(in) :: simulation   !! The run
      real(wp), intent(in) :: velocity(3)            !! Of the body [m/s]
      integer :: direction

      meets = allocated(simulation%rigid) .and. norm2(velocity) > 0.0_wp
      do direction = 1, 3
         if (.not. simulation%grid%active(direction)) cycle
         if (velocity(direction) < 0.0_wp) &
            meets = meets .or. closed(simulation%boundary%kind(2*direction - 1))
         if (velocity(direction) > 0.0_wp) &
            meets = meets .or. closed(simulation%boundary%kind(2*direction))
      end do
   end function meets_wall

   !> Do nodes of a face stop what comes?
   elemental function closed(kind) result(stops)
      integer, intent(in) :: kind                    !! Of the face
      logical :: stops

      stops = kind == face_symmetry .or. kind == face_slip .or. kind == face_stick &
         .or. kind == face_friction
   end function closed

   !> Wave speed with artificial viscosity in the middle of a shock [m/s]. Equation (S.4).
   pure real(wp) function shock_signal(material, jump) result(speed)
      type(material_t), intent(in) :: material       !! Its material
      real(wp), intent(in) :: jump                   !! Of the velocity of matter [m/s]
      real(wp), parameter :: slope = 1.5_wp          !! Of shock speed over jump, common to metals
      real(wp) :: damping, sound

      sound = material%reference_speed() + (slope - 0.5_wp)*jump
      speed = sound
      if (.not. allocated(material%viscosity)) return
      associate (q1 => material%viscosity%linear, q2 => material%viscosity%quadratic)
         if (.not. q1 + q2 > 0.0_wp) return
         ! 2 q2 h D of the steady profile, whose q has its maximum slope jump^2/4 in the middle
         damping = sqrt((q1*sound)**2 + q2*slope*jump**2)
      end associate
      speed = damping + sqrt(damping**2 + sound**2)
   end function shock_signal

   !> The first time step.
   subroutine first_step(simulation, bodies, limits, dt, cause)
      type(simulation_t), intent(in) :: simulation   !! The run without particles
      type(body_t), intent(in) :: bodies(:)          !! The bodies
      type(limits_t), intent(in) :: limits           !! Bounds of the step
      real(wp), intent(out) :: dt                    !! [s]
      character(len=:), allocatable, intent(out) :: cause !! If not the fastest signal

      call least_step(simulation, bodies, dt, cause)
      if (limits%dt_fixed > 0.0_wp) dt = limits%dt_fixed
      dt = min(dt, limits%dt_max)
   end subroutine first_step

   !> The grid in one line.
   function grid_line(simulation, survey) result(text)
      type(simulation_t), intent(in) :: simulation   !! The run
      type(survey_t), intent(in) :: survey           !! The counts
      character(len=:), allocatable :: text

      associate (grid => simulation%grid)
         text = "grid       "//number(grid%cells(1))//" x " &
            //number(grid%cells(2))//" x "//number(grid%cells(3))//" = " &
            //number(grid%cell_count())//" cells of "//short(grid%spacing)//" m; tiles of " &
            //number(grid%tile_cells)//" cells, "//number(size(survey%key, kind=int64)) &
            //" of "//number(product(int(grid%tiles, int64)))//" hold particles"
      end associate
   end function grid_line

   !> The particles, a line a body.
   function points_text(bodies, survey) result(text)
      type(body_t), intent(in) :: bodies(:)          !! The bodies
      type(survey_t), intent(in) :: survey           !! The counts
      character(len=:), allocatable :: text
      integer :: n

      text = "points     "//number(survey%particles)//" in "//number(size(bodies)) &
         //" bodies"
      do n = 1, size(bodies)
         text = text//merge(": ", ", ", n == 1)//bodies(n)%name//" "//number(survey%body(n))
      end do
      text = text//new_line("a")
   end function points_text

   !> The fields that particles carry, a block a material.
   function fields_text(simulation, survey) result(text)
      type(simulation_t), intent(in) :: simulation   !! The run
      type(survey_t), intent(in) :: survey           !! The counts
      character(len=:), allocatable :: text, lines
      type(wishes_t) :: wishes
      integer :: n, first, last

      text = "fields     "//number(base_bytes(simulation))// &
         " bytes a particle for identity, position, velocity, cell"
      if (allocated(simulation%stores(1)%body)) text = text//", body (there are several)"
      if (allocated(simulation%exact)) text = text//", reference (exact solution)"
      text = text//new_line("a")
      do n = 1, size(simulation%materials)
         text = text//"  "//simulation%stores(n)%name//new_line("a")
         wishes = simulation%materials(n)%wishes()
         lines = wishes%report()
         first = 1
         do while (first <= len(lines))
            last = index(lines(first:), new_line("a")) + first - 1
            if (last < first) last = len(lines)
            text = text//"    "//lines(first:last)
            first = last + 1
         end do
      end do
      text = text//"           "//number(nint(carried(simulation, survey), int64))// &
         " bytes a particle carried, "//number(nint(memory(simulation, survey) &
         /real(max(survey%particles, 1_int64), wp), &
         int64))//" with node fields and room to move"// &
         new_line("a")
   end function fields_text

   !> Bytes of what every particle carries beside its matter.
   pure integer function base_bytes(simulation) result(bytes)
      type(simulation_t), intent(in) :: simulation   !! The run

      bytes = 8*7 + 4
      associate (store => simulation%stores(1))
         if (allocated(store%body)) bytes = bytes + 8
         if (allocated(store%extent)) bytes = bytes + 24
         if (allocated(store%domain)) bytes = bytes + 72
         if (allocated(store%affine)) bytes = bytes + 72
         if (allocated(store%spin)) bytes = bytes + 24
         if (allocated(store%ahead)) bytes = bytes + 72
         if (allocated(store%bond)) bytes = bytes + 8
      end associate
      if (allocated(simulation%exact)) bytes = bytes + 24
   end function base_bytes

   !> Bytes a particle, of the material that carries most.
   real(wp) function carried(simulation, survey) result(bytes)
      type(simulation_t), intent(in) :: simulation   !! The run
      type(survey_t), intent(in) :: survey           !! The counts
      type(wishes_t) :: wishes
      integer :: n

      bytes = 0.0_wp
      if (survey%particles == 0) return
      do n = 1, size(simulation%materials)
         wishes = simulation%materials(n)%wishes()
         bytes = max(bytes, real(base_bytes(simulation) + wishes%bytes(), wp))
      end do
   end function carried

   !> Bytes of particle and node fields of the whole run at its start.
   real(wp) function memory(simulation, survey) result(bytes)
      type(simulation_t), intent(in) :: simulation   !! The run
      type(survey_t), intent(in) :: survey           !! The counts
      real(wp), &
         parameter :: room = 1.07_wp          ! ranges and arrays have some to spare
      ! mass, velocity, acceleration, velocity of the strain of all nodes
      integer, parameter :: whole = 10
      real(wp) :: columns
      integer :: d

      ! pieces hold the components along the directions of the scene
      d = simulation%grid%dimensions
      columns = real(whole + 1 + 2*d, wp)
      if (simulation%method%dual) columns = columns + real(4 + d + d*d, wp)
      if (simulation%method%dual .and. simulation%carries_energy) columns = columns + real(d*d, wp)
      if (simulation%method%controlled()) columns = columns + real(7 + 6, wp)
      if (simulation%method%differing()) columns = columns + real(dual_columns + 3 + 6 + 3 + 3, wp)
      if (allocated(simulation%contact)) columns = real(contact_columns(simulation%contact), wp) &
         + real(size(simulation%contact%field), wp)*columns
      if (allocated(simulation%conduction)) columns = columns &
         + merge(26.0_wp, 7.0_wp, simulation%method%dual)
      if (simulation%repacks) columns = columns + 1.0_wp
      if (simulation%method%heat_flux > 0.0_wp) columns = columns + 5.0_wp
      bytes = room*real(survey%particles, wp)*carried(simulation, survey) &
         + real(size(survey%key), wp)*(8.0_wp*columns &
         *real(simulation%grid%tile_nodes, wp) &
         + 4.0_wp*real(simulation%grid%tile_cells + neighbors + 12, wp))
   end function memory

   !> Stable time step for bodies as they begin.
   pure subroutine least_step(simulation, bodies, dt, cause)
      type(simulation_t), intent(in) :: simulation   !! The run
      type(body_t), intent(in) :: bodies(:)          !! The bodies
      real(wp), intent(out) :: dt                    !! [s]
      character(len=:), allocatable, intent(out) :: cause !! If not the fastest signal
      type(matter_t) :: matter
      real(wp) :: fastest, diffusivity, longest
      integer :: n

      fastest = 0.0_wp
      diffusivity = 0.0_wp
      do n = 1, size(bodies)
         associate (material => simulation%materials(bodies(n)%store))
            call material%request(matter, 1)
            matter%mass = material%density
            matter%volume = 1.0_wp
            call material%start(matter, 1, 1, bodies(n)%temperature)
            if (allocated(matter%energy)) matter%energy = bodies(n)%energy
            fastest = max(fastest, material%signal_speed(matter, 1, 1) + norm2(bodies(n)%velocity))
            if (allocated(material%heat)) diffusivity = max(diffusivity, &
               material%heat%conductivity/(material%density*material%heat%specific_heat))
         end associate
      end do
      dt = huge(dt)
      if (fastest > 0.0_wp) dt = simulation%method%cfl*simulation%grid%spacing/fastest
      longest = conduction_step(simulation%grid%spacing, simulation%grid%dimensions, diffusivity)
      cause = ""
      if (longest < dt) cause = " (heat conduction)"
      dt = min(dt, longest)
   end subroutine least_step

   !> A number as short text.
   pure function short(value) result(text)
      real(wp), intent(in) :: value                  !! Any
      character(len=:), allocatable :: text
      character(len=24) :: line

      write (line, "(es10.3)") value
      text = trim(adjustl(line))
   end function short
end module driver_check
