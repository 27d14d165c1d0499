! SPDX-License-Identifier: BSD-3-Clause
!> Output of a periodic cell that deforms: its stress, strain and edges over time.
module stream_cell
   use base_error, only: error_t
   use base_kinds, only: wp
   use deck_reader, only: deck_t, group_t
   use deck_schema, only: schema_t
   use output_table_stream, only: heading_length, table_stream_t
   use scene_regions, only: named_shape_t
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: stream_cell_t

   !> A table of the cell.
   type, extends(table_stream_t) :: stream_cell_t
   contains
      procedure :: about => cell_about               !! For the help
      procedure :: ending => cell_ending             !! Suffix of file names
      procedure :: declare => cell_declare           !! No keys
      procedure :: read => cell_read                 !! Check that there is a cell
      procedure :: list_columns => cell_list_columns !! Names of columns
      procedure :: write_rows => cell_write_rows     !! Write the row of a time
   end type stream_cell_t

contains

   !> For the help of `kind`.
   pure function cell_about(self) result(text)
      class(stream_cell_t), intent(in) :: self
      character(len=:), allocatable :: text

      text = "a table of stress, strain and edges of &cell"
   end function cell_about

   !> Suffix of the file name, after the case.
   pure function cell_ending(self) result(text)
      class(stream_cell_t), intent(in) :: self
      character(len=:), allocatable :: text

      text = "_cell.csv"
   end function cell_ending

   !> This kind of output has no keys.
   subroutine cell_declare(self, schema, kind)
      class(stream_cell_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema        !! Not changed
      character(len=*), intent(in) :: kind           !! Unused
   end subroutine cell_declare

   !> A table of a cell needs one.
   subroutine cell_read(self, group, deck, simulation, shapes)
      class(stream_cell_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! Group &output
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(simulation_t), intent(in) :: simulation
      type(named_shape_t), intent(in) :: shapes(:)   !! Unused

      if (.not. allocated(simulation%space%cell)) call deck%add_error(group, &
         "kind = 'cell' needs &cell and &stage; add them or remove this &output [D348]", "kind")
   end subroutine cell_read

   !> Names of the columns with units, as in the history of grains. Edges are upper triangular: a
   !! component, then the edge.
   subroutine cell_list_columns(self, columns)
      class(stream_cell_t), intent(in) :: self
      character(len=heading_length), allocatable, intent(out) :: columns(:) !! Headings

      columns = [character(len=heading_length) :: "time [s]", "step", "stage", "strain [1]", &
         "rate_xx [1/s]", "rate_yy [1/s]", "rate_zz [1/s]", "rate_xy [1/s]", "rate_xz [1/s]", &
         "rate_yz [1/s]", "volume [m3]", "density [kg/m3]", &
         "edge_xx [m]", "edge_yy [m]", "edge_zz [m]", "edge_xy [m]", "edge_xz [m]", "edge_yz [m]", &
         "stress_xx [Pa]", "stress_yy [Pa]", "stress_zz [Pa]", "stress_xy [Pa]", &
         "stress_xz [Pa]", "stress_yz [Pa]", "pressure [Pa]", "kinetic_pressure [Pa]", "work [J]"]
   end subroutine cell_list_columns

   !> Write the row of the present time. Collective.
   subroutine cell_write_rows(self, simulation, error)
      class(stream_cell_t), intent(inout) :: self
      type(simulation_t), intent(inout) :: simulation
      type(error_t), allocatable, intent(out) :: error !! The file cannot be written
      real(wp) :: s(3, 3), pressure, kinetic
      integer :: axis

      associate (cell => simulation%space%cell)
         s = cell%stress()
         pressure = 0.0_wp
         kinetic = 0.0_wp
         do axis = 1, 3
            pressure = pressure - s(axis, axis)/3.0_wp
            kinetic = kinetic + cell%sums%now(12 + axis)/(3.0_wp*cell%box%volume())
         end do
         associate (l => cell%box%gradient, h => cell%box%edges)
            call self%table%row(simulation%machine%communicator, [simulation%clock%time, &
               real(simulation%clock%step, wp), real(cell%now, wp), cell%box%strain, &
               l(1, 1), l(2, 2), l(3, 3), l(1, 2), l(1, 3), l(2, 3), cell%box%volume(), &
               cell%mass/cell%box%volume(), &
               h(1, 1), h(2, 2), h(3, 3), h(1, 2), h(1, 3), h(2, 3), &
               s(1, 1), s(2, 2), s(3, 3), s(1, 2), s(1, 3), s(2, 3), pressure, kinetic, &
               cell%work], error)
         end associate
      end associate
   end subroutine cell_write_rows
end module stream_cell
