! SPDX-License-Identifier: BSD-3-Clause
!> What a run will cost, said before it starts.
module program_cost
   use base_kinds, only: int64, wp
   use base_text, only: number, size_text
   use constitutive_field_requests, only: field_requests_t
   use mesh_tiles, only: neighbors
   use output_streams, only: snapshot_bytes
   use particle_fill, only: body_t
   use program_solid_volumes, only: solid_volumes_text
   use program_step_count, only: expected_steps, first_step
   use program_stiffness_advice, only: stiffness_text
   use program_time_loop, only: limits_t
   use scene_contact, only: contact_columns, contact_text
   use scene_particles, only: survey_t
   use step_simulation, only: simulation_t
   use transfer_scatter, only: dual_columns
   implicit none
   private

   public :: cost_text

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
         //solid_volumes_text(simulation%space%grid, bodies, survey%body) &
         //fields_text(simulation, survey)
      if (allocated(simulation%effects%contact)) text = text//contact_text(simulation, bodies)
      text = text &
         //"step       first dt "//short(dt)//" s"//cause//"; about "// &
         number(nint(steps, int64))//" steps"// &
         new_line("a")//stiffness_text(simulation, bodies, limits)// &
         "memory     "//size_text(bytes)//" for particle and node fields, on all ranks together"// &
         new_line("a")// &
         "output     "//number(snapshots)//" snapshots, about "//size_text(real(snapshots, wp) &
         *real(survey%particles, wp)*snapshot_bytes)//"; a checkpoint "// &
         size_text(real(survey%particles, wp)*carried(simulation, survey))//new_line("a")
   end function cost_text

   !> The grid in one line.
   function grid_line(simulation, survey) result(text)
      type(simulation_t), intent(in) :: simulation   !! The run
      type(survey_t), intent(in) :: survey           !! The counts
      character(len=:), allocatable :: text

      associate (grid => simulation%space%grid)
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
      type(field_requests_t) :: wishes
      integer :: n, first, last

      text = "fields     "//number(base_bytes(simulation))// &
         " bytes a particle for identity, position, velocity, cell"
      if (allocated(simulation%stores(1)%body)) text = text//", body (there are several)"
      if (allocated(simulation%effects%exact)) text = text//", reference (exact solution)"
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
      if (allocated(simulation%effects%exact)) bytes = bytes + 24
   end function base_bytes

   !> Bytes a particle, of the material that carries most.
   real(wp) function carried(simulation, survey) result(bytes)
      type(simulation_t), intent(in) :: simulation   !! The run
      type(survey_t), intent(in) :: survey           !! The counts
      type(field_requests_t) :: wishes
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
      d = simulation%space%grid%dimensions
      columns = real(whole + 1 + 2*d, wp)
      if (simulation%scheme%method%dual) columns = columns + real(4 + d + d*d, wp)
      if (simulation%scheme%method%dual .and. simulation%scheme%carries_energy) columns = columns &
         + real(d*d, wp)
      if (simulation%scheme%method%controlled()) columns = columns + real(7 + 6, wp)
      if (simulation%scheme%method%differing()) columns = columns + real(dual_columns + 3 + 6 + 3 &
         + 3, wp)
      if (allocated(simulation%effects%contact)) columns = &
         real(contact_columns(simulation%effects%contact), wp) &
         + real(size(simulation%fields), wp)*columns
      if (allocated(simulation%effects%conduction)) columns = columns &
         + merge(26.0_wp, 7.0_wp, simulation%scheme%method%dual)
      if (simulation%scheme%repacks) columns = columns + 1.0_wp
      if (simulation%scheme%method%heat_flux > 0.0_wp) columns = columns + 5.0_wp
      bytes = room*real(survey%particles, wp)*carried(simulation, survey) &
         + real(size(survey%key), wp)*(8.0_wp*columns &
         *real(simulation%space%grid%tile_nodes, wp) &
         + 4.0_wp*real(simulation%space%grid%tile_cells + neighbors + 12, wp))
   end function memory

   !> A number as short text.
   pure function short(value) result(text)
      real(wp), intent(in) :: value                  !! Any
      character(len=:), allocatable :: text
      character(len=24) :: line

      write (line, "(es10.3)") value
      text = trim(adjustl(line))
   end function short
end module program_cost
