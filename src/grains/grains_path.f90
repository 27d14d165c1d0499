! SPDX-License-Identifier: BSD-3-Clause
!> The path of a cell: stages, each with a velocity gradient, prescribed stresses and an end.
module grains_path
   use base_kinds, only: int64, wp
   use base_text, only: brief
   use deck_reader, only: deck_t, group_t
   use deck_schema, only: changes_end, changes_physics, schema_t
   use grains_cell, only: cell_t
   use mesh_drive, only: drive_t, read_drive, stage_duration
   implicit none
   private

   public :: check_lengths, check_stages, declare_stages, path_t, read_stages, stage_t

   !> One stage.
   type :: stage_t
      character(len=:), allocatable :: name
      type(drive_t) :: drive                         !! Velocity gradient and held stresses
      real(wp) :: friction = 0.0_wp                  !! [1]
      real(wp) :: duration = 0.0_wp                  !! [s]
      real(wp) :: fraction = 0.0_wp                  !! Volume fraction at its end; 0: no condition
      real(wp) :: quiet = 0.0_wp                     !! Energy ratio at its end; 0: no condition
      integer :: rows = 0                            !! Rows of the history
      integer :: snapshots = 0                       !! Number of them, evenly over the stage
      logical :: probe = .false.                     !! Are moduli measured at its end?
   end type stage_t

   !> All stages, and the current one.
   type :: path_t
      type(stage_t), allocatable :: stages(:)
      integer :: now = 1                             !! Index of the current stage
      integer(int64) :: start = 0                    !! Step at its start
      real(wp) :: from_fraction = 0.0_wp             !! Volume fraction at its start
      real(wp) :: from_height = 0.0_wp               !! Greatest distance of faces at its start [m]
   contains
      procedure :: steps => path_steps               !! Steps of a stage
      procedure :: is_row => path_is_row             !! Is a row of the history due?
      procedure :: is_snapshot => path_is_snapshot   !! Is a snapshot due?
   end type path_t

contains

   !> Declare &stage.
   subroutine declare_stages(schema)
      type(schema_t), intent(inout) :: schema        !! Keys of the deck

      call schema%group("stage", "one stage of the deformation of a cell: of grains for scree "// &
         "--grains, or of the scene with &cell", many=.true.)
      call schema%text("stage", "name", "name of the stage, for the log")
      call schema%real("stage", "rate(6)", &
         "velocity gradient du_x/dx du_y/dy du_z/dz du_x/dy du_x/dz du_y/dz", unit="1/s", &
         default="0 0 0 0 0 0")
      call schema%real("stage", "inertial_number", "grains: shear of x along y at this "// &
         "inertial number I of `pressure`, rate = I sqrt(pressure/density)/diameter; negative: "// &
         "reversed")
      call schema%text("stage", "servo", "axes along which the stress is held at `pressure`: "// &
         "each axis by itself; isotropic: the mean stress", default="none", &
         words="none isotropic x y z xy xz yz xyz")
      call schema%real("stage", "pressure", "stress held by the servo; default: that of &cell", &
         unit="Pa", range="> 0")
      call schema%real("stage", "friction", &
         "grains: friction coefficient between grains in this stage; default: that of &grains", &
         range=">= 0")
      call schema%real("stage", "strain", "end of the stage: greatest rate times duration", &
         range="> 0")
      call schema%real("stage", "duration", "end of the stage: duration", unit="s", range="> 0")
      call schema%real("stage", "volume_fraction", &
         "grains: the stage ends early when this volume fraction is passed", range="> 0 < 1")
      call schema%real("stage", "quiet", "grains: the stage ends early when the kinetic energy "// &
         "over the energy of the springs falls below this", range="> 0")
      call schema%integer("stage", "rows", "grains: rows of the history, means over equal times", &
         default="100", range=">= 1 <= 100000000")
      call schema%integer("stage", "snapshots", &
         "grains: number of snapshots of grains and contacts, evenly spaced", default="1", &
         range=">= 0 <= 1000000")
      call schema%logical("stage", "probe", &
         "grains: measure the elastic moduli at the end by small strains", default=".false.")
      call schema%allow_change("stage", "*", changes_physics)
      call schema%allow_change("stage", "+", changes_end)
      call schema%forbid_change("stage", "-", "the checkpoint counts the stages")
   end subroutine declare_stages

   !> Check that each stage has an end and that its fixed quantities are defined.
   subroutine check_stages(deck)
      type(deck_t), intent(inout) :: deck
      type(group_t) :: stage, cell
      character(len=:), allocatable :: servo, shape
      integer :: n
      logical :: has_rate

      cell = deck%group("cell")
      stage = deck%group("grains")
      call stage%get("shape", shape)
      if (deck%count("stage") == 0) call deck%add_error(stage, &
         "there is no &stage: give at least one, such as servo = 'isotropic'   duration = "// &
         "1.0 [D347]")
      do n = 1, deck%count("stage")
         stage = deck%group("stage", n)
         call stage%get("servo", servo)
         if (.not. (stage%given("strain") .or. stage%given("duration"))) &
            call deck%add_error(stage, "the stage has no end: give strain or duration [D347]")
         if (stage%given("strain") .and. .not. (stage%given("rate") .or. &
            stage%given("inertial_number"))) call deck%add_error(stage, &
            "strain needs a rate or an inertial_number; without them give duration [D347]", &
            "strain")
         has_rate = deck%departs(stage, "rate")
         if (has_rate .and. stage%given("inertial_number")) call deck%add_error(stage, &
            "rate and inertial_number are both given; keep one [D307]", "inertial_number")
         if ((servo /= "none" .or. stage%given("inertial_number")) .and. .not. &
            (stage%given("pressure") .or. cell%given("pressure"))) call deck%add_error(stage, &
            "servo and inertial_number need a pressure, here or in &cell [D347]")
         if (shape == "discs" .and. index(servo, "z") > 0) call deck%add_error(stage, &
            "discs have no direction z: use 'isotropic', 'x', 'y' or 'xy' [D347]", "servo")
      end do
   end subroutine check_stages

   !> Refuse stages of more time steps than integers count.
   subroutine check_lengths(deck, path, dt)
      type(deck_t), intent(inout) :: deck
      type(path_t), intent(in) :: path
      real(wp), intent(in) :: dt                     !! Time step [s]
      type(group_t) :: group
      real(wp), parameter :: most_strain = 0.1_wp    ! grains would pass through each other
      real(wp) :: most, steps, strain
      integer :: n

      if (.not. (dt > 0.0_wp .and. dt < huge(dt))) then
         call deck%add_error(deck%group("grains", 1), "diameter, density and stiffness give a "// &
            "time step that is not a positive number; correct their units [D449]", "diameter")
         return
      end if
      do n = 1, size(path%stages)
         strain = dt*maxval(abs(path%stages(n)%drive%gradient))
         if (.not. strain <= most_strain) call deck%add_error("stage", n, "the cell would be "// &
            "strained by "//brief(strain)//" in each time step of "//deck%shown(dt, "s")// &
            "; at most "//brief(most_strain)//": reduce rate or inertial_number [D449]", "rate")
         associate (stage => path%stages(n))
            ! rows are spaced by products of steps and rows
            most = real(huge(1_int64), wp)/(2.0_wp*real(max(stage%rows, stage%snapshots, 1), wp))
            steps = stage%duration/dt
         end associate
         if (steps <= most) cycle
         group = deck%group("stage", n)
         call deck%add_error(group, "the stage would take "//brief(steps)//" time steps of "// &
            deck%shown(dt, "s")//"; at most "//brief(most)//" can be counted: shorten it [D449]", &
            trim(merge("duration", "strain  ", group%given("duration"))))
      end do
   end subroutine check_lengths

   !> Read the stages.
   subroutine read_stages(deck, cell, friction, path)
      type(deck_t), intent(in) :: deck
      type(cell_t), intent(in) :: cell               !! With grains; its edges may change later
      real(wp), intent(in) :: friction               !! Key `friction` of &grains
      type(path_t), intent(out) :: path
      integer :: n

      allocate (path%stages(deck%count("stage")))
      do n = 1, size(path%stages)
         call read_stage(deck, n, cell, friction, path%stages(n))
      end do
   end subroutine read_stages

   !> Read one stage.
   subroutine read_stage(deck, n, cell, friction, stage)
      type(deck_t), intent(in) :: deck
      integer, intent(in) :: n                       !! Number
      type(cell_t), intent(in) :: cell
      real(wp), intent(in) :: friction               !! Key `friction` of &grains
      type(stage_t), intent(out) :: stage
      type(group_t) :: group
      real(wp) :: number
      integer :: axis

      group = deck%group("stage", n)
      call group%get("name", stage%name)
      call read_drive(deck, group, [(axis <= cell%box%dimension, axis=1, 3)], stage%drive)
      if (group%given("inertial_number")) then
         call group%get("inertial_number", number)
         stage%drive%gradient(1, 2) = number*sqrt(stage%drive%pressure/cell%density)/cell%diameter
      end if
      stage%friction = friction
      if (group%given("friction")) call group%get("friction", stage%friction)
      stage%duration = stage_duration(group, stage%drive)
      if (group%given("volume_fraction")) call group%get("volume_fraction", stage%fraction)
      if (group%given("quiet")) call group%get("quiet", stage%quiet)
      call group%get("rows", stage%rows)
      call group%get("snapshots", stage%snapshots)
      call group%get("probe", stage%probe)
   end subroutine read_stage

   !> Steps of a stage, unless it ends early.
   pure integer(int64) function path_steps(self, dt) result(steps)
      class(path_t), intent(in) :: self
      real(wp), intent(in) :: dt                     !! [s]

      steps = max(1_int64, ceiling(self%stages(self%now)%duration/dt, int64))
   end function path_steps

   !> True if a row of the history is due after a step.
   pure logical function path_is_row(self, step, dt) result(due)
      class(path_t), intent(in) :: self
      integer(int64), intent(in) :: step             !! Step of the run
      real(wp), intent(in) :: dt                     !! [s]

      due = is_due(step - self%start, self%steps(dt), self%stages(self%now)%rows)
   end function path_is_row

   !> True if a snapshot is due after a step.
   pure logical function path_is_snapshot(self, step, dt) result(due)
      class(path_t), intent(in) :: self
      integer(int64), intent(in) :: step             !! Step of the run
      real(wp), intent(in) :: dt                     !! [s]

      due = is_due(step - self%start, self%steps(dt), self%stages(self%now)%snapshots)
   end function path_is_snapshot

   !> True for `count` steps that are evenly spaced among `steps` and include the last one.
   pure logical function is_due(step, steps, count) result(due)
      integer(int64), intent(in) :: step             !! From 1
      integer(int64), intent(in) :: steps
      integer, intent(in) :: count

      due = .false.
      if (count > 0) due = (step*count)/steps > ((step - 1)*count)/steps
   end function is_due
end module grains_path
