! SPDX-License-Identifier: BSD-3-Clause
!> Output of means over the particles of each cell: a file for each time.
module stream_grid
   use base_error, only: error_t
   use base_kinds, only: int64, wp
   use base_text, only: brief
   use deck_reader, only: deck_t, group_t
   use deck_schema, only: schema_t
   use io_grid, only: grid_write
   use io_snapshot, only: snapshot_header_t
   use mesh_grid, only: grid_t
   use output_field_names, only: declare_fields, read_fields
   use output_selection, only: declare_selection, read_selection
   use output_snapshot_stream, only: limit_files, snapshot_stream_t
   use particle_store, only: store_t
   use sample_means, only: choose_means, in_cells, mean_t
   use sample_pick, only: pick_rule_t
   use scene_regions, only: named_shape_t
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: stream_grid_t

   real(wp), parameter :: most_cells = 1.0e9_wp      !! A file with more needs --force
   real(wp), parameter :: cell_bytes = 0.5_wp        !! A number of a cell, most of them empty

   !> Fields on the grid.
   type, extends(snapshot_stream_t) :: stream_grid_t
      type(mean_t), allocatable :: means(:)          !! Averaged quantities
      real(wp) :: cells = 0.0_wp                     !! Most cells of a file
   contains
      procedure :: about => grid_about               !! For the help
      procedure :: ending => grid_ending             !! End of file names
      procedure :: declare => grid_declare           !! Keys
      procedure :: read => grid_read                 !! Read the keys
      procedure :: try_field => grid_try_field       !! Check a name
      procedure :: limit => grid_limit               !! Refuse implausible sizes
      procedure :: write_file => grid_write_file     !! Write a file
      procedure :: bytes_of_file => grid_bytes_of_file !! Expected size
   end type stream_grid_t

contains

   !> For the help of `kind`.
   pure function grid_about(self) result(text)
      class(stream_grid_t), intent(in) :: self
      character(len=:), allocatable :: text

      text = "means over the particles of each cell"
   end function grid_about

   !> Suffix of file names, after the case.
   pure function grid_ending(self) result(text)
      class(stream_grid_t), intent(in) :: self
      character(len=:), allocatable :: text

      text = "_g"
   end function grid_ending

   !> Declare the keys of the kind.
   subroutine grid_declare(self, schema, kind)
      class(stream_grid_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema        !! Schema that receives the keys
      character(len=*), intent(in) :: kind           !! Word of the kind in the catalogue

      call declare_fields(schema, kind)
      call declare_selection(schema, kind)
      call self%declare_format(schema, kind)
   end subroutine grid_declare

   !> Read the keys of the kind.
   subroutine grid_read(self, group, deck, simulation, shapes)
      class(stream_grid_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! Group &output
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(simulation_t), intent(in) :: simulation   !! Read for the names of fields
      type(named_shape_t), intent(in) :: shapes(:)
      type(error_t), allocatable :: error

      call read_fields(group, deck, simulation, self, self%fields)
      ! read_fields has removed each invalid name
      call choose_means(simulation%stores, self%fields, in_cells, self%means, error)
      call self%read_format(group)
      call read_selection(group, deck, shapes, self%format%pick_rule_t)
      self%cells = cells_in(simulation%space%grid, self%format%pick_rule_t)
      self%series%of_grids = .true.
   end subroutine grid_read

   !> Try one name of the key `fields`.
   subroutine grid_try_field(self, field, simulation, stores, error)
      class(stream_grid_t), intent(in) :: self
      character(len=*), intent(in) :: field          !! Name of the field
      type(simulation_t), intent(in) :: simulation   !! Unused
      type(store_t), intent(in) :: stores(:)         !! Particles
      type(error_t), allocatable, intent(out) :: error !! The field has no mean
      type(mean_t), allocatable :: means(:)

      call choose_means(stores, [field], in_cells, means, error)
   end subroutine grid_try_field

   !> Cells of the grid or of the region: an upper bound for a file.
   pure real(wp) function cells_in(grid, rule) result(cells)
      type(grid_t), intent(in) :: grid
      type(pick_rule_t), intent(in) :: rule
      real(wp) :: lower(3), upper(3)

      lower = grid%lower
      upper = grid%upper
      if (allocated(rule%region)) call rule%region%bounds(lower, upper)
      lower = max(lower, grid%lower)
      upper = min(upper, grid%upper)
      cells = product(max((upper - lower)/grid%spacing, 1.0_wp), mask=grid%active)
   end function cells_in

   !> Refuse implausible sizes.
   subroutine grid_limit(self, deck, particles, time_end, steps)
      class(stream_grid_t), intent(in) :: self
      type(deck_t), intent(inout) :: deck            !! Collects errors
      integer(int64), intent(in) :: particles        !! Number of particles in all bodies
      real(wp), intent(in) :: time_end               !! End of the run [s]
      real(wp), intent(in) :: steps                  !! Expected number of steps

      if (self%cells > most_cells) call deck%add_error("output", self%place, "would write up to "&
         //brief(self%cells)//" cells per output time; give a region, or continue with "// &
         "--force [D431]")
      call limit_files(deck, self%place, self%schedule%expected(time_end, steps), &
         self%bytes_of_file(particles))
   end subroutine grid_limit

   !> Write a file. Collective.
   subroutine grid_write_file(self, simulation, path, header, error)
      class(stream_grid_t), intent(inout) :: self
      type(simulation_t), intent(inout) :: simulation
      character(len=*), intent(in) :: path
      type(snapshot_header_t), intent(in) :: header  !! Text and time for the file
      type(error_t), allocatable, intent(out) :: error !! If the file cannot be written

      call grid_write(simulation%machine%communicator, path, simulation%space%grid, &
         simulation%space%tiles%coordinate(:, :simulation%space%tiles%own), simulation%stores, &
         self%means, self%format, header, error)
   end subroutine grid_write_file

   !> Expected size of a file [byte].
   pure real(wp) function grid_bytes_of_file(self, particles) result(bytes)
      class(stream_grid_t), intent(in) :: self
      integer(int64), intent(in) :: particles        !! Unused

      bytes = self%cells*real(sum(self%means%column%components), wp)*cell_bytes
   end function grid_bytes_of_file
end module stream_grid
