! SPDX-License-Identifier: BSD-3-Clause
!> The groups &cell and &stage of a scene: a periodic cell of particles that deforms along the
!! stages of the deck, their compatibility checks, and its first state. The keys are those of `scree
!! --grains`.
module scene_cell
   use base_kinds, only: wp
   use ddmp_catalogue, only: choose_quadrature, quadrature_names
   use ddmp_quadrature, only: quadrature_t
   use deck_reader, only: deck_t, group_t
   use mesh_drive, only: read_drive, stage_duration
   use mesh_moving_cell, only: moving_cell_t
   use particle_moving_cell, only: find_mass, measure_cell
   use scene_dimension, only: axis_names, is_dual
   use step_method, only: stress_after, stress_names
   use step_simulation, only: simulation_t
   use transfer_basis, only: basis_t
   use transfer_catalogue, only: basis_names, choose_basis, choose_velocity, velocity_names
   use transfer_velocity, only: velocity_t
   implicit none
   private

   public :: has_cell, read_cell, refuse_effects, set_cell_defaults, start_cell

contains

   !> True if the particles of the scene are in a cell that deforms: there are stages, and no grains
   !! that use them. The echo of a deck holds &cell and &grains with their defaults in any case.
   logical function has_cell(deck) result(has)
      type(deck_t), intent(in) :: deck
      type(group_t) :: grains

      grains = deck%group("grains")
      has = deck%count("stage") > 0 .and. .not. grains%given("diameter")
   end function has_cell

   !> Defaults and required values of &method in a cell that deforms. Transfers that need particle
   !! fields other than the velocity are refused, as these are not defined on a mesh that changes
   !! its shape.
   subroutine set_cell_defaults(deck)
      type(deck_t), intent(inout) :: deck            !! Gets defaults and errors
      class(basis_t), allocatable :: basis
      class(velocity_t), allocatable :: transfer
      class(quadrature_t), allocatable :: quadrature
      type(group_t) :: group
      logical :: paper, bases(size(basis_names)), transfers(size(velocity_names)), &
         quadratures(size(quadrature_names))
      integer :: n

      if (.not. has_cell(deck)) return
      group = deck%group("method")
      call group%get("paper", paper)
      if (paper) then
         call deck%add_error(group, "&cell cannot be combined with paper = .true.; remove "// &
            "it [D348]", "paper")
         return
      end if
      do n = 1, size(velocity_names)
         call choose_velocity(velocity_names(n), transfer)
         transfers(n) = .not. transfer%affine()
      end do
      call need(deck, "transfer", pack(velocity_names, transfers))
      call need(deck, "stress_update", [stress_names(stress_after)])
      do n = 1, size(basis_names)
         call choose_basis(basis_names(n), basis)
         bases(n) = basis%suits_cell()
      end do
      call need(deck, "basis", pack(basis_names, bases))
      if (.not. is_dual(deck)) return
      call need(deck, "normalise", ["none"])
      call need(deck, "viscosity_limiter", ["none"])
      do n = 1, size(quadrature_names)
         call choose_quadrature(quadrature_names(n), quadrature)
         quadratures(n) = quadrature%suits_cell()
      end do
      call need(deck, "quadrature", pack(quadrature_names, quadratures))
   end subroutine set_cell_defaults

   !> A key of &method needs one of some words, the first of which is its default.
   subroutine need(deck, key, words)
      type(deck_t), intent(inout) :: deck
      character(len=*), intent(in) :: key
      character(len=*), intent(in) :: words(:)
      character(len=:), allocatable :: word, list
      type(group_t) :: group
      integer :: n

      group = deck%group("method")
      if (.not. group%given(key)) then
         call deck%set_default("method", 1, key, trim(words(1)))
         return
      end if
      call group%get(key, word)
      if (any(words == word)) return
      list = "'"//trim(words(1))//"'"
      do n = 2, size(words)
         list = list//" or '"//trim(words(n))//"'"
      end do
      call deck%add_error(group, "&cell needs "//key//" = "//list//", not '"//word//"' [D348]", key)
   end subroutine need

   !> Read the cell and its stages. Grid, boundaries, method and effects are already read.
   subroutine read_cell(deck, simulation)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(simulation_t), intent(inout) :: simulation
      type(moving_cell_t), allocatable :: cell
      type(group_t) :: group
      real(wp) :: tilt, time
      integer :: n
      logical :: is_here

      is_here = has_cell(deck)
      if (.not. is_here) then
         call check_stages(deck)
         return
      end if
      call check_space(deck, simulation)
      call check_keys(deck)
      group = deck%group("cell")
      do n = 1, deck%count("stage")
         call check_stage(deck, n, simulation%space%grid%active)
      end do
      if (.not. (deck%sound("cell") .and. deck%sound("stage"))) return
      allocate (cell)
      call group%get("tilt", tilt)
      associate (grid => simulation%space%grid)
         call cell%tilt(grid%upper - grid%lower, grid%active, tilt)
      end associate
      allocate (cell%legs(deck%count("stage")))
      time = 0.0_wp
      do n = 1, size(cell%legs)
         group = deck%group("stage", n)
         call group%get("name", cell%legs(n)%name)
         call read_drive(deck, group, cell%active, cell%legs(n)%drive)
         cell%legs(n)%drive%haste = 1.0_wp
         time = time + stage_duration(group, cell%legs(n)%drive)
         cell%legs(n)%ends = time
      end do
      call check_end(deck, time)
      call move_alloc(cell, simulation%space%cell)
   end subroutine read_cell

   !> A cell without stages does nothing.
   subroutine check_stages(deck)
      type(deck_t), intent(inout) :: deck            !! Has no cell of particles
      type(group_t) :: cell, grains
      logical :: tilts

      cell = deck%group("cell")
      grains = deck%group("grains")
      if (grains%given("diameter")) return
      tilts = deck%departs(cell, "tilt")
      if (cell%given("pressure") .or. tilts) call deck%add_error(cell, "there is no &stage: "// &
         "give at least one, such as rate = 0, 0, 0, 0, 1, 0   duration = 1.0 [D347]")
   end subroutine check_stages

   !> Warn if the run ends before the last stage.
   subroutine check_end(deck, time)
      type(deck_t), intent(inout) :: deck            !! Gets a warning
      real(wp), intent(in) :: time                   !! End of the last stage [s]
      real(wp), parameter :: grain = 1.0e-9_wp       ! rounding
      type(group_t) :: group
      real(wp) :: end_of_run

      group = deck%group("time")
      if (.not. group%known("t_end")) return
      call group%get("t_end", end_of_run)
      if (time <= end_of_run*(1.0_wp + grain)) return
      call deck%warn("stage", deck%count("stage"), "ends at t = "//deck%shown(time, "s")// &
         ", after t_end; raise t_end to reach it [D348]")
   end subroutine check_end

   !> A cell is periodic in all its directions, and effects that use positions or directions in
   !! space do not account for the mesh.
   subroutine check_space(deck, simulation)
      type(deck_t), intent(inout) :: deck
      type(simulation_t), intent(in) :: simulation
      type(group_t) :: cell
      integer :: k

      cell = deck%group("cell")
      associate (grid => simulation%space%grid)
         if (grid%axisymmetric) call deck%add_error(cell, &
            "&cell needs dimension = '1d', 'plane_strain' or '3d' in &run; rings have no "// &
            "periodic cell [D348]")
         do k = 1, 3
            if (.not. grid%active(k) .or. grid%periodic(k)) cycle
            call deck%add_error(cell, "&cell needs periodic faces in all directions, and "// &
               axis_names(k)//" has none; write &boundary face = 'all' type = 'periodic' [D348]")
            exit
         end do
      end associate
      associate (method => simulation%scheme%method)
         if (allocated(method%splitting)) call deck%add_error(deck%group("method"), &
            "&cell cannot be combined with split = .true.; remove it [D348]", "split")
         if (method%heat_flux > 0.0_wp) call deck%add_error(deck%group("method"), &
            "&cell cannot be combined with heat_flux; remove it [D348]", "heat_flux")
      end associate
      do k = 1, size(simulation%materials)
         if (simulation%materials(k)%repacks) call deck%add_error(deck%group("material", k), &
            "&cell cannot be combined with volume_from = 'grid'; remove it [D348]", "volume_from")
      end do
      if (allocated(simulation%effects%gravity)) call deck%add_error(deck%group("effects"), &
         "&cell cannot be combined with gravity: a periodic cell has no bottom; remove "// &
         "it [D348]", "gravity")
   end subroutine check_space

   !> Keys that apply to grains only.
   subroutine check_keys(deck)
      type(deck_t), intent(inout) :: deck
      character(len=15), parameter :: of_cell(8) = [character(len=15) :: "packing", "cells", &
         "overlap", "volume_fraction", "aspect", "speed", "seed", "skin"]
      character(len=15), parameter :: of_stage(7) = [character(len=15) :: "inertial_number", &
         "friction", "volume_fraction", "quiet", "rows", "snapshots", "probe"]
      integer :: n, k

      do k = 1, size(of_cell)
         call refuse_key(deck, deck%group("cell"), trim(of_cell(k)))
      end do
      do n = 1, deck%count("stage")
         do k = 1, size(of_stage)
            call refuse_key(deck, deck%group("stage", n), trim(of_stage(k)))
         end do
      end do
   end subroutine check_keys

   !> Refuse a key that applies to grains only.
   subroutine refuse_key(deck, group, key)
      type(deck_t), intent(inout) :: deck
      type(group_t), intent(in) :: group
      character(len=*), intent(in) :: key
      logical :: departs

      departs = deck%departs(group, key)
      if (departs) call deck%add_error(group, key//" is for grains, with &grains and "// &
         "scree --grains; remove it [D348]", key)
   end subroutine refuse_key

   !> Check that a stage has an end, directions of the scene, and the pressure that it prescribes.
   subroutine check_stage(deck, n, active)
      type(deck_t), intent(inout) :: deck
      integer, intent(in) :: n                       !! Number
      logical, intent(in) :: active(3)               !! Active directions
      integer, parameter :: row(6) = [1, 2, 3, 1, 1, 2], column(6) = [1, 2, 3, 2, 3, 3]
      character(len=:), allocatable :: servo
      type(group_t) :: stage, cell
      real(wp) :: rate(6)
      integer :: k

      stage = deck%group("stage", n)
      cell = deck%group("cell")
      if (.not. stage%valid(["rate ", "servo"])) return
      call stage%get("rate", rate)
      call stage%get("servo", servo)
      if (.not. (stage%given("strain") .or. stage%given("duration"))) call deck%add_error(stage, &
         "the stage has no end: give strain or duration [D347]")
      if (stage%given("strain") .and. .not. any(abs(rate) > 0.0_wp)) call deck%add_error(stage, &
         "strain needs a rate; without it give duration [D348]", "strain")
      if (servo /= "none" .and. .not. (stage%given("pressure") .or. cell%given("pressure"))) &
         call deck%add_error(stage, "servo needs a pressure, here or in &cell [D348]", "servo")
      do k = 1, 6
         if ((active(row(k)) .and. active(column(k))) .or. .not. abs(rate(k)) > 0.0_wp) cycle
         call deck%add_error(stage, "rate has a component along a direction that the scene "// &
            "does not have; in a plane use the first, third and fifth [D348]", "rate")
         exit
      end do
      if (servo == "none" .or. servo == "isotropic") return
      do k = 1, 3
         if (active(k) .or. index(servo, axis_names(k)) == 0) cycle
         call deck%add_error(stage, "servo = '"//servo//"' holds a stress along "// &
            axis_names(k)//", a direction that the scene does not have [D348]", "servo")
         exit
      end do
   end subroutine check_stage

   !> Check groups that are read later and that a cell excludes: walls in space, contact, exact
   !! solutions, heat conduction.
   subroutine refuse_effects(deck, simulation)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(simulation_t), intent(in) :: simulation   !! All groups are read
      character(len=:), allocatable :: what
      integer :: k

      if (.not. allocated(simulation%space%cell)) return
      what = ""
      if (allocated(simulation%space%rigid)) what = "rigid regions"
      if (allocated(simulation%effects%contact)) what = "contact"
      if (allocated(simulation%effects%exact)) what = "&exact"
      if (allocated(simulation%effects%loads)) what = "&load"
      do k = 1, size(simulation%materials)
         if (.not. allocated(simulation%materials(k)%heat)) cycle
         if (simulation%materials(k)%heat%conductivity > 0.0_wp) what = "conductivity"
      end do
      if (what /= "") call deck%add_error(deck%group("cell"), "&cell cannot be combined "// &
         "with "//what//"; remove one of the two [D348]")
   end subroutine refuse_effects

   !> First stress and velocity gradient of the cell, and a first step that is short enough for it.
   !! Collective.
   subroutine start_cell(simulation, signal)
      type(simulation_t), intent(inout) :: simulation !! With particles and a first step
      real(wp), intent(in) :: signal                 !! Fastest wave of all ranks [m/s]

      associate (communicator => simulation%machine%communicator, cell => simulation%space%cell)
         cell%speed = signal
         cell%mass = find_mass(communicator, simulation%stores)
         call measure_cell(communicator, simulation%stores, cell)
         call cell%begin(simulation%clock%guard%bounds%strain_max, simulation%clock%dt_next)
      end associate
   end subroutine start_cell
end module scene_cell
