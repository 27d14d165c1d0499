! SPDX-License-Identifier: BSD-3-Clause
!> Output of rigid bodies: place, rotation, velocities, and the force and torque of the material on
!! rigid regions that turn, or that forces move. Equations (R.8) to (R.10) of doc/theory/rigid.md.
module stream_rigid
   use base_error, only: error_t
   use base_kinds, only: int64, wp
   use base_text, only: append, text_t
   use deck_reader, only: deck_t, group_t
   use deck_schema, only: schema_t
   use output_table_stream, only: heading_length, table_stream_t
   use scene_regions, only: named_shape_t
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: stream_rigid_t

   integer, parameter :: columns_each = 22           !! Columns of a body
   integer, parameter :: kept = 6                    !! Impulse and moment at the last row

   !> A table of rigid bodies.
   type, extends(table_stream_t) :: stream_rigid_t
      type(text_t), allocatable :: name(:)           !! (body) Names of their regions
      integer, allocatable :: wall(:)                !! (body) Indices of the regions
      real(wp), allocatable :: last(:, :)            !! (6, body) Impulse and moment at the last row
      real(wp) :: last_time = -1.0_wp                !! Time of that row, < 0 = none [s]
   contains
      procedure :: about => rigid_about              !! For the help
      procedure :: ending => rigid_ending            !! Suffix of file names
      procedure :: declare => rigid_declare          !! No keys
      procedure :: read => rigid_read                !! List the bodies
      procedure :: list_columns => rigid_list_columns !! Names of columns
      procedure :: write_rows => rigid_write_rows    !! Write the row of a time
      procedure :: counters => rigid_counters        !! With the sums of the last row
      procedure :: set_counters => rigid_set_counters !! With the sums of the last row
   end type stream_rigid_t

contains

   !> For the help of `kind`.
   pure function rigid_about(self) result(text)
      class(stream_rigid_t), intent(in) :: self
      character(len=:), allocatable :: text

      text = "a table of place, rotation, velocities, force and torque of rigid regions that "// &
         "turn, or that forces move"
   end function rigid_about

   !> Suffix of the file name, after the case.
   pure function rigid_ending(self) result(text)
      class(stream_rigid_t), intent(in) :: self
      character(len=:), allocatable :: text

      text = "_rigid.csv"
   end function rigid_ending

   !> This kind of output has no keys.
   subroutine rigid_declare(self, schema, kind)
      class(stream_rigid_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema        !! Not changed
      character(len=*), intent(in) :: kind           !! Unused
   end subroutine rigid_declare

   !> List the bodies; there must be one.
   subroutine rigid_read(self, group, deck, simulation, shapes)
      class(stream_rigid_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! Group &output
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(simulation_t), intent(in) :: simulation
      type(named_shape_t), intent(in) :: shapes(:)   !! Unused
      integer :: n

      allocate (self%name(0), self%wall(0))
      if (allocated(simulation%space%rigid)) then
         do n = 1, size(simulation%space%rigid%wall)
            associate (wall => simulation%space%rigid%wall(n))
               if (.not. allocated(wall%body)) cycle
               call append(self%name, trim(wall%name))
               self%wall = [self%wall, n]
            end associate
         end do
      end if
      allocate (self%last(kept, size(self%wall)), source=0.0_wp)
      if (size(self%wall) == 0) call deck%add_error(group, "no rigid region turns, and forces "// &
         "move none; give mass, density or spin in a &boundary with a region, or remove this "// &
         "&output [D375]", "kind")
   end subroutine rigid_read

   !> Names of the columns with units.
   subroutine rigid_list_columns(self, columns)
      class(stream_rigid_t), intent(in) :: self
      character(len=heading_length), allocatable, intent(out) :: columns(:) !! Headings
      character(len=heading_length) :: more(columns_each)
      integer :: n

      columns = [character(len=heading_length) :: "time [s]", "step"]
      do n = 1, size(self%name)
         associate (name => self%name(n)%text)
            more = [character(len=heading_length) :: name//"_x [m]", name//"_y [m]", &
               name//"_z [m]", name//"_turn_1 [1]", name//"_turn_x [1]", name//"_turn_y [1]", &
               name//"_turn_z [1]", name//"_velocity_x [m/s]", name//"_velocity_y [m/s]", &
               name//"_velocity_z [m/s]", name//"_spin_x [1/s]", name//"_spin_y [1/s]", &
               name//"_spin_z [1/s]", name//"_force_x [N]", name//"_force_y [N]", &
               name//"_force_z [N]", name//"_torque_x [N m]", name//"_torque_y [N m]", &
               name//"_torque_z [N m]", name//"_kinetic [J]", name//"_work [J]", &
               name//"_weight_work [J]"]
         end associate
         columns = [columns, more]
      end do
   end subroutine rigid_list_columns

   !> Write the row of the present time. Forces and torques are means over the time since the last
   !! row. Collective.
   subroutine rigid_write_rows(self, simulation, error)
      class(stream_rigid_t), intent(inout) :: self
      type(simulation_t), intent(inout) :: simulation
      type(error_t), allocatable, intent(out) :: error !! The file cannot be written
      real(wp) :: row(columns_each, size(self%wall)), now(kept), period
      integer :: n

      period = simulation%clock%time - self%last_time
      do n = 1, size(self%wall)
         associate (body => simulation%space%rigid%wall(self%wall(n))%body)
            now = [body%impulse, body%moment]
            ! on a ring only the axial force has a meaning
            if (simulation%space%grid%axisymmetric) now([1, 2, 4, 5, 6]) = 0.0_wp
            row(:13, n) = [body%centre, body%turn, body%velocity, body%spin]
            row(14:19, n) = 0.0_wp
            if (self%last_time >= 0.0_wp .and. period > 0.0_wp) row(14:19, n) = &
               (now - self%last(:, n))/period
            row(20:, n) = [body%kinetic(), body%work, body%weight_work]
            self%last(:, n) = now
         end associate
      end do
      self%last_time = simulation%clock%time
      call self%table%row(simulation%machine%communicator, [simulation%clock%time, &
         real(simulation%clock%step, wp), row], error)
   end subroutine rigid_write_rows

   !> State of the stream for a checkpoint.
   pure function rigid_counters(self) result(counters)
      class(stream_rigid_t), intent(in) :: self
      integer(int64), allocatable :: counters(:)

      counters = [self%last_step, transfer([self%last_time, self%last], [0_int64])]
   end function rigid_counters

   !> Set the state from a checkpoint.
   pure subroutine rigid_set_counters(self, counters)
      class(stream_rigid_t), intent(inout) :: self
      integer(int64), intent(in) :: counters(:)      !! From rigid_counters
      real(wp), allocatable :: values(:)

      self%last_step = counters(1)
      if (size(counters) /= 2 + size(self%last)) return
      values = transfer(counters(2:), [0.0_wp])
      self%last_time = values(1)
      self%last = reshape(values(2:), shape(self%last))
   end subroutine rigid_set_counters
end module stream_rigid
