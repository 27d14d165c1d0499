! SPDX-License-Identifier: BSD-3-Clause
!> Measures the particle updates per second of an elastic block in flight: whole steps with sorting,
!! without output.
!!
!! bench_block [CELLS] [ddmp|mpm|BASIS] [STEPS] [TRANSFER]   cells along each edge, 8 particles a
!! cell, flying at 0.1 of its sound speed along a diagonal, in a box a quarter larger that is
!! periodic.
program bench_block
   use base_communicator, only: communicator_t
   use base_error, only: error_t
   use base_kinds, only: int64, wp
   use eos_linear, only: eos_linear_t
   use law_elastic, only: law_elastic_t
   use particle_body, only: body_t
   use particle_shape, only: box
   use scene_particles, only: fill_simulation, first_step, make_stores, prepare_simulation, &
      survey_t, take_survey
   use step_advance, only: advance
   use step_simulation, only: simulation_t
   use transfer_catalogue, only: choose_velocity
   implicit none

   type(simulation_t) :: simulation
   type(body_t) :: bodies(1)
   type(survey_t) :: survey
   type(error_t), allocatable :: error
   integer :: cells, steps, step
   character(len=32) :: word, transfer
   integer(int64) :: before, after, rate, updates
   real(wp) :: seconds

   cells = 64
   steps = 60
   call get_command_argument(1, word)
   if (len_trim(word) > 0) read (word, *) cells
   call get_command_argument(3, word)
   if (len_trim(word) > 0) read (word, *) steps
   transfer = "flip"
   call get_command_argument(4, word)
   if (len_trim(word) > 0) transfer = word
   call get_command_argument(2, word)
   call simulation%machine%communicator%start()
   if (len_trim(word) == 0) word = "ddmp"
   call simulation%scheme%method%choose(word == "ddmp", trim(word), "point")
   call choose_velocity(trim(transfer), simulation%scheme%method%transfer)
   simulation%scheme%method%cfl = 0.4_wp
   simulation%clock%guard%bounds%strain_max = 0.3_wp
   simulation%space%grid%margin = simulation%scheme%method%margin()
   simulation%space%grid%spacing = 1.0_wp
   simulation%space%grid%upper = real(cells + max(cells/4, 4), wp)
   simulation%space%grid%periodic = .true.
   call simulation%space%boundary%impose("periodic", [1, 2, 3, 4, 5, 6])
   call simulation%space%grid%start(0)
   allocate (simulation%materials(1))
   associate (material => simulation%materials(1))
      material%name = "block"
      material%density = 1.0_wp
      material%bulk = 5.0_wp/9.0_wp
      material%shear = 1.0_wp/3.0_wp
      allocate (law_elastic_t :: material%law)
      allocate (eos_linear_t :: material%eos)
      material%law%shear = material%shear
      material%eos%density = material%density
      material%eos%bulk = material%bulk
   end associate
   call prepare_simulation(simulation)
   call make_stores(simulation, .false.)
   call bodies(1)%shape%set(box([2.0_wp, 2.0_wp, 2.0_wp], spread(2.0_wp + real(cells, wp), 1, 3)))
   bodies(1)%density = 1.0_wp
   bodies(1)%per_cell = 2
   bodies(1)%velocity = 0.1_wp/sqrt(3.0_wp)
   call take_survey(simulation, bodies, survey)
   call fill_simulation(simulation, bodies, survey)
   call first_step(simulation)
   do step = 1, 10
      call advance(simulation, simulation%clock%dt_next, error)
   end do
   updates = simulation%clock%updates
   call system_clock(before, rate)
   do step = 1, steps
      call advance(simulation, simulation%clock%dt_next, error)
      if (allocated(error)) exit
   end do
   call system_clock(after)
   seconds = real(after - before, wp)/real(rate, wp)
   updates = simulation%clock%updates - updates
   if (allocated(error)) print "(a)", error%message
   print "(a,i0,a,i0,a,f8.3,a,f8.2,a)", "particles ", survey%particles, "  steps ", steps, &
      "  seconds ", &
      seconds, "  million updates/s ", real(updates, &
         wp)*real(simulation%machine%communicator%size, wp) &
      /seconds*1.0e-6_wp, "  "//trim(word)
   print "(a)", simulation%machine%timer%table(simulation%machine%communicator, seconds)
   print "(a,i0)", "8-byte numbers a particle: ", simulation%stores(1)%words()
   call simulation%machine%communicator%finish()
end program bench_block
