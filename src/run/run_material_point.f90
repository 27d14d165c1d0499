! SPDX-License-Identifier: BSD-3-Clause
!> scree --point: drives one material of a deck along a strain path and writes its states.
module run_material_point
   use base_communicator, only: communicator_t
   use base_error, only: error_t, exit_physics, fail, without_code
   use base_file, only: make_folder, write_file
   use base_kinds, only: wp
   use base_text, only: brief, buffer_t, number
   use deck_reader, only: deck_t, group_t
   use deck_schema, only: changes_nothing, schema_t
   use material_point, only: point_t
   use material_state, only: material_state_t
   use material_type, only: material_t
   use scene_material, only: read_material
   implicit none
   private

   public :: declare_point, drive_point, make_scene_optional

contains

   !> Declare the keys of &point.
   subroutine declare_point(schema)
      type(schema_t), intent(inout) :: schema        !! Keys of the deck

      call schema%group("point", &
         "path of one material point, for scree --point; simulations ignore it")
      call schema%text("point", "material", "name of the material; default: the first one")
      call schema%text("point", "path", "uniaxial_strain along x, shear of x along y, "// &
         "triaxial with a lateral pressure, hydrostatic, hugoniot: states behind "// &
         "shocks, free: any velocity gradient", default="uniaxial_strain", &
            words="uniaxial_strain "// &
         "shear triaxial hydrostatic hugoniot free")
      call schema%real("point", "rate", "strain rate", unit="1/s", default="1", range="> 0", &
         owner="path = uniaxial_strain shear triaxial hydrostatic free")
      call schema%real("point", "strain", &
         "final strain: logarithmic, volumetric or shear strain; negative in compression", &
         default="-0.1", owner="path = uniaxial_strain shear triaxial hydrostatic free")
      call schema%logical("point", "returns", &
         "return to the initial state in the same number of steps", default=".false.", &
         owner="path = uniaxial_strain shear triaxial hydrostatic free")
      call schema%integer("point", "steps", "number of steps from the start to the end", &
         default="1000", range="> 0 <= 100000000")
      call schema%real("point", "confinement", "lateral pressure", unit="Pa", &
         default="0", range=">= 0", owner="path = triaxial")
      call schema%real("point", "velocity_gradient(9)", "du_x/dx du_y/dx du_z/dx du_x/dy ... "// &
         "divided by rate", owner="path = free")
      call schema%real("point", "speed", "greatest particle speed", unit="m/s", range="> 0", &
         owner="path = hugoniot")
      call schema%real("point", "temperature", "initial temperature; default: t_ref", &
         unit="K", range="> 0")
      call schema%real("point", "volume", &
         "initial volume, for the number of flaws in brittle materials", unit="m3", &
         default="1.0e-9", range="> 0")
      call schema%require("point", "velocity_gradient speed")
      call schema%allow_change("point", "*", changes_nothing)
   end subroutine declare_point

   !> Make the keys of the scene optional: a deck for --point needs only &material and
   !! &point, one for --grains only &grains, &cell and &stage.
   subroutine make_scene_optional(schema)
      type(schema_t), intent(inout) :: schema        !! Keys of the deck
      integer :: i

      do i = 1, size(schema%groups)
         select case (schema%groups(i)%name)
         case ("material", "point", "grains", "cell", "stage")
            cycle
         case default
            schema%groups(i)%keys%required = .false.
         end select
      end do
   end subroutine make_scene_optional

   !> Drive the point and write CASE_point.csv.
   subroutine drive_point(deck, folder, note, error)
      type(deck_t), intent(inout) :: deck            !! The deck, collects complaints
      character(len=:), allocatable, intent(in) :: folder !! Output folder of the command line
      character(len=:), allocatable, intent(out) :: note  !! Line for the screen
      type(error_t), allocatable, intent(out) :: error    !! Errors in the deck or of a file
      type(communicator_t) :: communicator
      type(material_t) :: material
      type(point_t) :: point
      type(group_t) :: group
      character(len=:), allocatable :: place, name
      real(wp), allocatable :: table(:, :)
      integer :: index, rows

      group = deck%group("point")
      call group%get("material", name)
      index = 1
      if (group%given("material")) index = deck%named("material", name)
      if (deck%count("material") == 0) then
         call deck%add_error(group, "there is no &material [D227]")
      else if (index == 0) then
         call deck%add_error(group, "no material '"//name//"' [D227]", "material")
      else
         call read_material(deck, communicator, index, material)
      end if
      call deck%verdict(error)
      if (allocated(error)) return
      ! there is no shock front in a single point, so no artificial viscosity
      if (allocated(material%viscosity)) deallocate (material%viscosity)
      if (allocated(material%heat)) point%temperature = material%heat%reference
      call read_point(group, point)
      call point%run(material, table)
      group = deck%group("run")
      call group%get("case", name)
      place = "out/"//name
      if (allocated(folder)) place = folder
      call make_folder(place, error)
      if (allocated(error)) return
      name = place//"/"//name//"_point.csv"
      rows = valid_rows(table)
      call write_file(name, csv(point%header(), table(:, :rows)), error)
      if (allocated(error)) return
      if (rows < size(table, 2)) call fail(error, exit_physics, "the state of the material "// &
         "point is not finite in row "//number(rows + 1)//" of "//number(size(table, 2))//", "// &
         trim(merge("particle_speed", "strain        ", point%path == "hugoniot"))//" = "// &
         brief(table(merge(1, 2, point%path == "hugoniot"), rows + 1))//"; "//name// &
         " has the rows before it: reduce strain, rate or speed in &point, or check the "// &
         "constants"//reason_of(material, point%state)//" [R136]")
      note = "point     "//material%name//"  "//point%path//"  "//name
   end subroutine drive_point

   !> Reason that the law gives for a stress that is not finite; empty if there is none.
   function reason_of(material, state) result(text)
      type(material_t), intent(in) :: material
      type(material_state_t), intent(in) :: state    !! State at the end of the path
      character(len=:), allocatable :: text

      text = ""
      if (allocated(material%law)) text = material%law%fault_of_state(state, 1)
      if (len(text) > 0) text = "; "//without_code(text)
   end function reason_of

   !> Rows before the first one with a number that is not finite.
   pure integer function valid_rows(table) result(rows)
      real(wp), intent(in) :: table(:, :)            !! (column, row)

      do rows = 0, size(table, 2) - 1
         if (.not. all(abs(table(:, rows + 1)) <= huge(1.0_wp))) return
      end do
   end function valid_rows

   !> Read the path.
   subroutine read_point(group, point)
      type(group_t), intent(in) :: group             !! &point
      type(point_t), intent(inout) :: point          !! Gets the path

      call group%get("path", point%path)
      call group%get("rate", point%rate)
      call group%get("strain", point%strain)
      call group%get("returns", point%returns)
      call group%get("steps", point%steps)
      call group%get("confinement", point%confinement)
      if (group%given("velocity_gradient")) call group%get("velocity_gradient", point%direction)
      if (group%given("speed")) call group%get("speed", point%speed)
      if (group%given("temperature")) call group%get("temperature", point%temperature)
      call group%get("volume", point%volume)
   end subroutine read_point

   !> A table as comma separated values with all digits.
   function csv(header, table) result(text)
      character(len=*), intent(in) :: header         !! Names of the columns
      real(wp), intent(in) :: table(:, :)            !! (column, row)
      character(len=:), allocatable :: text
      type(buffer_t) :: buffer
      character(len=25) :: digits
      integer :: row, column

      call buffer%line(header)
      do row = 1, size(table, 2)
         do column = 1, size(table, 1)
            write (digits, "(es24.16)") table(column, row)
            if (column > 1) call buffer%add(",")
            call buffer%add(trim(adjustl(digits)))
         end do
         call buffer%line("")
      end do
      text = buffer%content()
   end function csv
end module run_material_point
