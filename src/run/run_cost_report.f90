! SPDX-License-Identifier: BSD-3-Clause
!> Report of `--check` and of the log on the size of a run: grid, particles, fields, steps, memory,
!! output.
module run_cost_report
   use base_kinds, only: int64, wp
   use base_text, only: brief, number, size_text
   use material_field_requests, only: field_requests_t
   use mesh_tiles, only: neighbors
   use particle_body, only: body_t
   use particle_disks, only: disks_t
   use particle_joined, only: find_joined, joined_t
   use run_expected_steps, only: expected_steps, find_first_step
   use run_limits, only: limits_t
   use scene_contact, only: contact_text
   use scene_particles, only: survey_t
   use step_contact, only: dissipation_after_remap
   use step_move_nodes, only: records_later
   use step_node_fields, only: gradient_rows, mean_before, node_needs_t, node_tally_t, &
      stress_rows, tensor_rows, vector_rows
   use step_normalised_sums, only: counted_columns, normal_columns
   use step_particles_to_nodes, only: may_be_lean
   use step_simulation, only: simulation_t
   use stream_particles, only: snapshot_bytes
   implicit none
   private

   public :: cost_report, memory_bytes

contains

   !> The report, one subject a line.
   function cost_report(simulation, bodies, survey, limits, snapshots) result(text)
      type(simulation_t), intent(in) :: simulation   !! Without particles
      type(body_t), intent(in) :: bodies(:)
      type(survey_t), intent(in) :: survey
      type(limits_t), intent(in) :: limits           !! End of the run
      integer(int64), intent(in) :: snapshots        !! Expected number of snapshots
      character(len=:), allocatable :: text
      character(len=:), allocatable :: cause
      real(wp) :: dt, steps, bytes

      call find_first_step(simulation, bodies, limits, dt, cause)
      steps = expected_steps(simulation, bodies, limits)
      bytes = memory_bytes(simulation, survey)
      text = grid_line(simulation, survey)//new_line("a")//particles_text(bodies, survey) &
         //disks_text(simulation, bodies, survey)//fields_text(simulation, survey)
      if (allocated(simulation%effects%contact)) text = text//contact_text(simulation, bodies)
      text = text//rigid_text(simulation)//joined_text(simulation, bodies)
      text = text//sticking_text(simulation, bodies)
      text = text &
         //"step       first dt "//four_digits(dt)//" s"//cause//"; "// &
         number(nint(steps, int64))//" steps of this length"//new_line("a")// &
         "memory     "//size_text(bytes)//" for particle and node fields, total of all ranks"// &
         new_line("a")// &
         "output     "//number(snapshots)//" snapshots, about "//size_text(real(snapshots, wp) &
         *real(survey%particles, wp)*snapshot_bytes)//"; a checkpoint "// &
         size_text(checkpoint_bytes(simulation, survey))//new_line("a")
   end function cost_report

   !> A line for each body whose particles are random with a least distance.
   function disks_text(simulation, bodies, survey) result(text)
      type(simulation_t), intent(in) :: simulation
      type(body_t), intent(in) :: bodies(:)
      type(survey_t), intent(in) :: survey
      character(len=:), allocatable :: text
      integer :: n

      text = ""
      do n = 1, size(bodies)
         if (.not. allocated(bodies(n)%given)) cycle
         select type (given => bodies(n)%given)
         type is (disks_t)
            text = text//"disks      "//bodies(n)%name//": "//number(survey%body(n))// &
               " points at least "//brief(given%distance*simulation%space%grid%spacing)//" m apart"
            if (.not. simulation%space%grid%axisymmetric) &
               text = text//", "//brief(bodies(n)%share)//" m3 each"
            text = text//new_line("a")
         end select
      end do
   end function disks_text

   !> Size of a checkpoint [byte].
   real(wp) function checkpoint_bytes(simulation, survey) result(bytes)
      type(simulation_t), intent(in) :: simulation
      type(survey_t), intent(in) :: survey

      bytes = real(survey%particles, wp)*particle_bytes(simulation, survey)
   end function checkpoint_bytes

   !> The grid in one line.
   function grid_line(simulation, survey) result(text)
      type(simulation_t), intent(in) :: simulation
      type(survey_t), intent(in) :: survey
      character(len=:), allocatable :: text

      associate (grid => simulation%space%grid)
         text = "grid       "//number(grid%cells(1))//" x " &
            //number(grid%cells(2))//" x "//number(grid%cells(3))//" = " &
            //number(grid%cell_count())//" cells of "//four_digits(grid%spacing)//" m; tiles of " &
            //number(grid%tile_cells)//" cells, "//number(survey%tiles) &
            //" of "//number(product(int(grid%tiles, int64)))//" hold particles"
      end associate
   end function grid_line

   !> The number of particles of each body, and their mass, which is that of the first state.
   function particles_text(bodies, survey) result(text)
      type(body_t), intent(in) :: bodies(:)
      type(survey_t), intent(in) :: survey
      character(len=:), allocatable :: text
      integer, parameter :: most_named = 12
      character(len=:), allocatable :: counts, masses, comma
      integer :: n

      counts = ""
      masses = ""
      do n = 1, min(size(bodies), most_named)
         comma = trim(merge(":", ",", n == 1))//" "//bodies(n)%name//" "
         counts = counts//comma//number(survey%body(n))
         masses = masses//comma//brief(bodies(n)%density*survey%volume(n))
      end do
      if (size(bodies) > most_named) then
         comma = ", and "//number(size(bodies) - most_named)//" more bodies"
         counts = counts//comma
         masses = masses//comma
      end if
      text = "particles  "//number(survey%particles)//" in "//number(size(bodies)) &
         //" bodies"//counts//new_line("a")//"mass       "// &
         brief(sum(bodies%density*survey%volume))//" kg"
      if (size(bodies) > 1) text = text//masses
      if (any(bodies%lateral >= 0.0_wp)) text = text// &
         "; initial_stress = 'lithostatic' makes it denser"
      text = text//new_line("a")
   end function particles_text

   !> A line for each rigid region that forces move: its mass, centre and moments of inertia.
   function rigid_text(simulation) result(text)
      type(simulation_t), intent(in) :: simulation
      character(len=:), allocatable :: text
      integer :: k, n

      text = ""
      if (.not. allocated(simulation%space%rigid)) return
      do n = 1, size(simulation%space%rigid%wall)
         associate (wall => simulation%space%rigid%wall(n))
            if (.not. allocated(wall%body)) cycle
            if (.not. wall%body%mass > 0.0_wp) cycle
            text = text//"rigid      "//trim(wall%name)//": "//four_digits(wall%body%mass)// &
               " kg, centre"
            do k = 1, 3
               text = text//" "//four_digits(wall%body%home(k))
            end do
            text = text//" m"
            if (wall%body%free_spin) then
               text = text//trim(merge(", moment of inertia ", ", moments of inertia", &
                  wall%body%plane))
               do k = 1, 3
                  if (wall%body%plane .and. k /= 2) cycle
                  text = text//" "//four_digits(wall%body%inertia(k, k))
               end do
               text = text//" kg m2"
            end if
            text = text//new_line("a")
         end associate
      end do
   end function rigid_text

   !> Bodies that are joined at the start, because no contact separates them.
   function joined_text(simulation, bodies) result(text)
      type(simulation_t), intent(in) :: simulation
      type(body_t), intent(in) :: bodies(:)
      character(len=:), allocatable :: text
      integer, parameter :: most_lines = 5
      type(joined_t), allocatable :: joined(:)
      integer :: field(size(bodies)), n

      field = 1
      if (allocated(simulation%effects%contact)) &
         field = simulation%effects%contact%field_of_body
      call find_joined(simulation%space%grid, bodies, field, 1, joined)
      text = ""
      do n = 1, size(joined)
         if (n > most_lines) then
            text = text//"           and "//number(size(joined) - most_lines)//" more pairs"// &
               new_line("a")
            return
         end if
         text = text//"joined     bodies '"//bodies(joined(n)%one)%name//"' and '"// &
            bodies(joined(n)%other)%name//"' share nodes: they cannot slide or separate there"// &
            " unless &contact gives them separate velocity fields"//new_line("a")
      end do
   end function joined_text

   !> Two bodies that move slowly against each other have one velocity field without contact, so
   !! they stick where they meet. In an impact near the speed of sound this has little effect.
   function sticking_text(simulation, bodies) result(text)
      type(simulation_t), intent(in) :: simulation
      type(body_t), intent(in) :: bodies(:)
      character(len=:), allocatable :: text
      real(wp), parameter :: slow = 0.5_wp           ! fraction of the speed of sound
      real(wp) :: speed, sound
      integer :: one, other

      text = ""
      if (allocated(simulation%effects%contact)) return
      do other = 2, size(bodies)
         do one = 1, other - 1
            speed = norm2(bodies(one)%velocity - bodies(other)%velocity)
            sound = min(simulation%materials(bodies(one)%store)%reference_speed(), &
               simulation%materials(bodies(other)%store)%reference_speed())
            if (.not. (speed > 0.0_wp .and. speed <= slow*sound)) cycle
            text = "contact    '"//bodies(one)%name//"' and '"//bodies(other)%name// &
               "' stick together if they meet; with &effects contact = .true. they can slide "// &
               "and separate"//new_line("a")
            return
         end do
      end do
   end function sticking_text

   !> The fields of particles and their reasons, for each material.
   function fields_text(simulation, survey) result(text)
      type(simulation_t), intent(in) :: simulation
      type(survey_t), intent(in) :: survey
      character(len=:), allocatable :: text, lines
      type(field_requests_t) :: requests
      integer :: n, first, last

      text = "fields     "//number(base_bytes(simulation))// &
         " bytes per particle for identity, position, velocity, cell"
      if (allocated(simulation%stores(1)%body)) text = text//", body (several bodies)"
      if (allocated(simulation%effects%exact)) text = text//", reference (exact solution)"
      if (allocated(simulation%stores(1)%origin%marks)) text = text//", functions of loads"
      text = text//new_line("a")
      do n = 1, size(simulation%materials)
         text = text//"  "//simulation%stores(n)%name//new_line("a")
         if (allocated(simulation%materials(n)%eos)) then
            lines = simulation%materials(n)%eos%report()
            if (len(lines) > 0) text = text//"    equation of state: "//lines//new_line("a")
         end if
         if (allocated(simulation%materials(n)%law)) then
            lines = simulation%materials(n)%law%report()
            if (len(lines) > 0) text = text//"    law: "//lines//new_line("a")
         end if
         requests = simulation%materials(n)%field_requests()
         lines = requests%report()
         first = 1
         do while (first <= len(lines))
            last = index(lines(first:), new_line("a")) + first - 1
            if (last < first) last = len(lines)
            text = text//"    "//lines(first:last)
            first = last + 1
         end do
      end do
      text = text//"           "//number(nint(particle_bytes(simulation, survey), int64))// &
         " bytes per particle, "//number(nint(memory_bytes(simulation, survey) &
         /real(max(survey%particles, 1_int64), wp), &
         int64))//" with node fields and spare capacity"// &
         new_line("a")
   end function fields_text

   !> Bytes of a particle for the fields that do not depend on its material.
   integer function base_bytes(simulation) result(bytes)
      type(simulation_t), intent(in) :: simulation
      type(field_requests_t) :: requests

      requests = simulation%materials(1)%field_requests()
      bytes = simulation%stores(1)%bytes() - requests%bytes()
   end function base_bytes

   !> Bytes of a particle of the material with the most fields.
   real(wp) function particle_bytes(simulation, survey) result(bytes)
      type(simulation_t), intent(in) :: simulation
      type(survey_t), intent(in) :: survey
      integer :: n

      bytes = 0.0_wp
      if (survey%particles == 0) return
      do n = 1, size(simulation%stores)
         bytes = max(bytes, real(simulation%stores(n)%bytes(), wp))
      end do
   end function particle_bytes

   !> Bytes of all particle and node fields of the first state.
   real(wp) function memory_bytes(simulation, survey) result(bytes)
      type(simulation_t), intent(in) :: simulation
      type(survey_t), intent(in) :: survey
      real(wp), parameter :: spare = 1.07_wp         ! spare capacity of arrays
      type(node_needs_t) :: needs
      type(node_tally_t) :: tally
      integer :: n

      associate (grid => simulation%space%grid)
         needs = node_needs(simulation, survey)
         tally%nodes = grid%tile_nodes
         tally%cells = grid%tile_cells
         do n = 1, size(simulation%fields)
            call simulation%fields(n)%count(needs, tally)
         end do
         call simulation%effects%count(simulation%scheme%method, tally)
         bytes = spare*real(survey%particles, wp)*particle_bytes(simulation, survey) &
            + real(survey%tiles, wp)*(8.0_wp*real(tally%needed, wp) &
            + 4.0_wp*real(grid%tile_cells + neighbors + 12, wp))
      end associate
   end function memory_bytes

   !> Node fields of each velocity field.
   function node_needs(simulation, survey) result(needs)
      type(simulation_t), intent(in) :: simulation
      type(survey_t), intent(in) :: survey
      type(node_needs_t) :: needs

      associate (space => simulation%space, scheme => simulation%scheme, &
         method => simulation%scheme%method, effects => simulation%effects)
         needs%vector = count(vector_rows(space%grid))
         needs%tensor = count(tensor_rows(space%grid))
         needs%lean = may_be_lean(scheme, effects) .and. &
            survey%tiles*space%grid%tile_nodes > survey%particles
         needs%dual = method%dual
         needs%energy = scheme%works
         needs%averages = method%averages()
         needs%repacks = scheme%repacks
         if (allocated(effects%contact)) &
            needs%contact = merge(4, 1, dissipation_after_remap(scheme))
         needs%later = records_later(space, scheme, effects)
         if (method%remaps()) needs%extra = merge(4, 3, &
            method%transfer%affine() .and. .not. method%averages())
         if (method%controlled()) then
            needs%mean = mean_before + size(stress_rows(space%grid)) + 1
            needs%strain = size(gradient_rows(space%grid))*scheme%gradients()
         end if
         needs%rigid = allocated(space%rigid)
         if (allocated(scheme%normalises)) then
            needs%counted = counted_columns(scheme)
            needs%normal = normal_columns
         end if
      end associate
   end function node_needs

   !> A number with four digits.
   pure function four_digits(value) result(text)
      real(wp), intent(in) :: value                  !! Value
      character(len=:), allocatable :: text
      character(len=24) :: line

      write (line, "(es10.3)") value
      text = trim(adjustl(line))
   end function four_digits
end module run_cost_report
