! SPDX-License-Identifier: BSD-3-Clause
!> Quantities that a caller may change between steps: velocities of walls and rigid regions, factors
!! of loads, gravity. A change is linear over the next step.
module library_controls
   use base_error, only: error_t, exit_input, fail
   use base_kinds, only: wp
   use base_text, only: number
   use mesh_boundary_walls, only: face_names
   use mesh_motion, only: motion_t
   use mesh_surface_load, only: surface_load_t
   use mesh_wall, only: wall_t
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: control_names, get_control, set_control

   character(len=*), parameter :: of_gravity = "gravity"

contains

   !> Names of the controls of a simulation, one per line with its number of components.
   function control_names(simulation) result(text)
      type(simulation_t), intent(in) :: simulation
      character(len=:), allocatable :: text
      integer :: n

      text = ""
      associate (boundary => simulation%space%boundary, effects => simulation%effects)
         if (allocated(boundary%wall)) then
            do n = 1, size(boundary%wall)
               if (is_steered(boundary%wall(n))) text = text//wall_name(boundary%wall(n))//" 3"// &
                  new_line("a")
            end do
         end if
         if (allocated(simulation%space%rigid)) then
            do n = 1, size(simulation%space%rigid%wall)
               if (is_steered(simulation%space%rigid%wall(n))) text = text// &
                  wall_name(simulation%space%rigid%wall(n))//" 3"//new_line("a")
            end do
         end if
         if (allocated(effects%loads)) then
            do n = 1, size(effects%loads)
               text = text//load_name(n)//" 1"//new_line("a")
            end do
         end if
         if (is_constant_gravity(simulation)) text = text//of_gravity//" 3"//new_line("a")
      end associate
   end function control_names

   !> True if the velocity of a wall can be changed. That of a wall without motion, of an
   !! inflow, and of a region that turns or that forces move cannot.
   pure logical function is_steered(wall) result(steered)
      type(wall_t), intent(in) :: wall

      steered = .not. (wall%stays .or. allocated(wall%body))
      if (wall%face > 0) steered = wall%condition%moves()
   end function is_steered

   !> True if gravity is constant, not a table over time.
   pure logical function is_constant_gravity(simulation) result(constant)
      type(simulation_t), intent(in) :: simulation

      constant = allocated(simulation%effects%gravity) .and. .not. &
         allocated(simulation%effects%shaking)
   end function is_constant_gravity

   !> Name of a wall: its boundary, with the region of a part; or the name of a rigid region.
   pure function wall_name(wall) result(name)
      type(wall_t), intent(in) :: wall
      character(len=:), allocatable :: name

      if (wall%face == 0) then
         name = trim(wall%name)
      else
         name = face_names(wall%face)
         if (allocated(wall%region)) name = name//"["//trim(wall%name)//"]"
      end if
   end function wall_name

   !> Name of a load, by its position in the deck.
   pure function load_name(place) result(name)
      integer, intent(in) :: place                   !! From 1
      character(len=:), allocatable :: name

      name = "load["//number(place)//"]"
   end function load_name

   !> Present value of a control: velocity [m/s], factor [1] in the first component, or gravity
   !! [m/s2].
   subroutine get_control(simulation, name, values, error)
      type(simulation_t), intent(in) :: simulation
      character(len=*), intent(in) :: name           !! From `control_names`
      real(wp), intent(out) :: values(3)             !! Velocity, factor or gravity
      type(error_t), allocatable, intent(out) :: error !! No such control
      integer :: n

      values = 0.0_wp
      associate (space => simulation%space, effects => simulation%effects, &
         time => simulation%clock%time)
         if (allocated(space%boundary%wall)) then
            n = place_of(space%boundary%wall, name)
            if (n > 0) values = space%boundary%wall(n)%motion%velocity(time)
            if (n > 0) return
         end if
         if (allocated(space%rigid)) then
            n = place_of(space%rigid%wall, name)
            if (n > 0) values = space%rigid%wall(n)%motion%velocity(time)
            if (n > 0) return
         end if
         n = load_of(simulation, name)
         if (n > 0) then
            values(1) = effects%loads(n)%factor
            if (allocated(effects%loads(n)%course)) values = effects%loads(n)%course%velocity(time)
         else if (name == of_gravity .and. is_constant_gravity(simulation)) then
            values = effects%gravity
         else
            call refuse(name, error)
         end if
      end associate
   end subroutine get_control

   !> Change a control. The same call on all ranks.
   subroutine set_control(simulation, name, values, error)
      type(simulation_t), intent(inout) :: simulation
      character(len=*), intent(in) :: name           !! From `control_names`
      real(wp), intent(in) :: values(3)              !! As those of `get_control`
      type(error_t), allocatable, intent(out) :: error !! No such control, or not finite
      integer :: n

      if (.not. all(abs(values) <= huge(values))) then
         call fail(error, exit_input, "a value of the control '"//name//"' is not finite [R128]")
         return
      end if
      associate (space => simulation%space, effects => simulation%effects, clock => &
         simulation%clock)
         if (allocated(space%boundary%wall)) then
            n = place_of(space%boundary%wall, name)
            if (n > 0) call space%boundary%wall(n)%motion%steer(clock%time, clock%dt_next, values)
            if (n > 0) return
         end if
         if (allocated(space%rigid)) then
            n = place_of(space%rigid%wall, name)
            if (n > 0) call space%rigid%wall(n)%motion%steer(clock%time, clock%dt_next, values)
            if (n > 0) return
         end if
         n = load_of(simulation, name)
         if (n > 0) then
            call steer_load(effects%loads(n), clock%time, clock%dt_next, values)
         else if (name == of_gravity .and. is_constant_gravity(simulation)) then
            effects%gravity = merge(values, 0.0_wp, space%grid%active)
         else
            call refuse(name, error)
         end if
      end associate
   end subroutine set_control

   !> Change the factor of a load. A load without a table gets one.
   subroutine steer_load(load, from, over, values)
      type(surface_load_t), intent(inout) :: load
      real(wp), intent(in) :: from                   !! Present time [s]
      real(wp), intent(in) :: over                   !! Length of the change [s]
      real(wp), intent(in) :: values(3)              !! Factor in the first component [1]
      type(motion_t) :: course

      if (.not. allocated(load%course)) then
         course%steady = [load%factor, 0.0_wp, 0.0_wp]
         allocate (load%course, source=course)
      end if
      call load%course%steer(from, over, values)
   end subroutine steer_load

   !> Index of a wall with this name whose velocity can be changed; 0 = none.
   pure integer function place_of(walls, name) result(place)
      type(wall_t), intent(in) :: walls(:)
      character(len=*), intent(in) :: name

      do place = 1, size(walls)
         if (is_steered(walls(place)) .and. wall_name(walls(place)) == name) return
      end do
      place = 0
   end function place_of

   !> Index of a load by its name; 0 = none.
   pure integer function load_of(simulation, name) result(place)
      type(simulation_t), intent(in) :: simulation
      character(len=*), intent(in) :: name

      if (allocated(simulation%effects%loads)) then
         do place = 1, size(simulation%effects%loads)
            if (load_name(place) == name) return
         end do
      end if
      place = 0
   end function load_of

   !> The error for a name that is not that of a control.
   subroutine refuse(name, error)
      character(len=*), intent(in) :: name
      type(error_t), allocatable, intent(out) :: error

      call fail(error, exit_input, "no control '"//name//"' in this simulation; only "// &
         "boundaries that move, rigid regions, loads and constant gravity have one [R128]")
   end subroutine refuse
end module library_controls
