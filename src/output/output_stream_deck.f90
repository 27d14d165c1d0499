! SPDX-License-Identifier: BSD-3-Clause
!> What the streams of output hold and when they are written, as the deck says.
module output_stream_deck
   use base_constants, only: unset
   use base_deck, only: deck_t, group_t
   use base_error, only: error_t
   use base_kinds, only: int64, wp
   use base_text, only: text_t
   use io_fields, only: choose_columns, column_t
   use io_fragments, only: fragments_t
   use io_history, only: history_t
   use io_means, only: choose_means, highest, mean_t
   use io_pick, only: pick_rule_t
   use io_profile, only: profile_t
   use io_snapshot, only: snapshot_format_t
   use io_stream_names, only: of_bins, of_cells, of_fragments, of_ledger, of_particles, &
      of_slices, stream_file, stream_kind, stream_kinds
   use io_xdmf, only: series_t
   use mesh_grid, only: grid_t
   use output_field_names, only: read_fields
   use output_history, only: choose_history, history_columns_t
   use output_schedule, only: read_schedule, schedule_t
   use particle_shape, only: shape_holder_t
   use scene_shapes, only: named_shape_t
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: plan_streams, snapshots_t, tables_t

   !> One stream of files, a file a time.
   type :: snapshots_t
      integer :: place = 0                           !! Number of its &output, 0 = none
      integer :: kind = of_particles                 !! A constant of io_stream_names
      character(len=:), allocatable :: prefix        !! CASE_p, or CASE_NAME_p for further streams
      character(len=64), allocatable :: fields(:)    !! Names, or "default"
      type(mean_t), allocatable :: means(:)          !! On grids: what is averaged
      type(fragments_t) :: fragments                 !! What the field fragment numbers
      type(snapshot_format_t) :: format              !! Precision, compression, which particles
      real(wp) :: cells = 0.0_wp                     !! On grids: most cells of a file
      type(schedule_t) :: schedule                   !! When
      type(series_t) :: series                       !! Index files
      integer :: next = 0                            !! Number of the next snapshot
      integer(int64) :: last_step = -1               !! Step of the last snapshot
   end type snapshots_t

   !> One table that grows.
   type :: tables_t
      integer :: place = 0                           !! Number of its &output, 0 = none
      integer :: kind = of_ledger                    !! A constant of io_stream_names
      character(len=:), allocatable :: name          !! CASE_history.csv
      type(history_columns_t) :: columns             !! Of histories: what they show
      type(profile_t) :: profile                     !! Of profiles: what they show
      type(fragments_t) :: fragments                 !! Of fragments: what is looked for
      type(schedule_t) :: schedule                   !! When
      type(history_t) :: file                        !! The file
      integer(int64) :: last_step = -1               !! Step of the last row
   end type tables_t

contains

   !> Read all streams.
   subroutine plan_streams(deck, simulation, shapes, time_end, case, snapshots, tables)
      type(deck_t), intent(inout) :: deck            !! The deck, collects complaints
      type(simulation_t), intent(inout) :: simulation !! With fields, for the names; not changed
      type(named_shape_t), intent(in) :: shapes(:)   !! The regions
      real(wp), intent(in) :: time_end               !! End of the run [s]
      character(len=*), intent(in) :: case           !! Prefix of all files
      type(snapshots_t), allocatable, intent(out) :: snapshots(:) !! Files, a file a time
      type(tables_t), allocatable, intent(out) :: tables(:) !! Tables
      type(group_t) :: group
      character(len=:), allocatable :: name, word
      integer :: index, kind(deck%count("output")), seen(stream_kinds), files, rows

      do index = 1, size(kind)
         group = deck%group("output", index)
         call group%get("kind", word)
         kind(index) = stream_kind(word)
      end do
      allocate (snapshots(count(kind >= of_particles .and. kind <= of_cells)), &
         tables(count(kind >= of_ledger)))
      seen = 0
      files = 0
      rows = 0
      do index = 1, size(kind)
         if (kind(index) == 0) cycle
         group = deck%group("output", index)
         seen(kind(index)) = seen(kind(index)) + 1
         call group%get("name", name)
         name = stream_file(case, name, kind(index), seen(kind(index)))
         if (kind(index) <= of_cells) then
            files = files + 1
            snapshots(files)%place = index
            snapshots(files)%kind = kind(index)
            snapshots(files)%prefix = name
            call plan_snapshots(group, deck, simulation, shapes, snapshots(files))
            call read_schedule(group, time_end, snapshots(files)%schedule)
         else
            rows = rows + 1
            tables(rows)%place = index
            tables(rows)%kind = kind(index)
            tables(rows)%name = name
            call plan_table(group, deck, simulation, shapes, tables(rows))
            call read_schedule(group, time_end, tables(rows)%schedule)
         end if
      end do
      call share_fragments(tables, snapshots)
   end subroutine plan_streams

   !> The field `fragment` of snapshots numbers what the first table of fragments lists; without a
   !! table all matter, parted by gaps alone.
   subroutine share_fragments(tables, snapshots)
      type(tables_t), intent(in) :: tables(:)        !! Tables
      type(snapshots_t), intent(inout) :: snapshots(:) !! Gets the definition
      integer :: n, table

      do table = 1, size(tables)
         if (tables(table)%kind == of_fragments) exit
      end do
      if (table > size(tables)) return
      do n = 1, size(snapshots)
         snapshots(n)%fragments = tables(table)%fragments
      end do
   end subroutine share_fragments

   !> Fields and format of one stream of files.
   subroutine plan_snapshots(group, deck, simulation, shapes, stream)
      type(group_t), intent(in) :: group             !! The &output
      type(deck_t), intent(inout) :: deck            !! The deck, for bodies and complaints
      type(simulation_t), intent(inout) :: simulation !! With fields, for the names; not changed
      type(named_shape_t), intent(in) :: shapes(:)   !! The regions
      type(snapshots_t), intent(inout) :: stream     !! The stream
      character(len=:), allocatable :: word
      type(column_t), allocatable :: columns(:)
      type(error_t), allocatable :: error

      ! a name that cannot be chosen is left out by read_fields, so the errors below are never set
      call read_fields(group, deck, simulation, stream%kind, stream%fields)
      if (stream%kind == of_cells) then
         call choose_means(simulation%stores, stream%fields, .true., stream%means, error)
      else
         call choose_columns(simulation%stores, stream%fields, columns, error)
      end if
      call group%get("precision", word)
      stream%format%single = word == "single"
      call group%get("compress", stream%format%compress)
      call read_rule(group, deck, shapes, stream%format%pick_rule_t)
      if (stream%kind /= of_cells) call group%get("stride", stream%format%stride)
      if (stream%kind == of_slices) call read_plane(group, deck, simulation%space%grid, &
         stream%format)
      if (stream%kind == of_cells) stream%cells = most_cells_of(simulation%space%grid, &
         stream%format)
   end subroutine plan_snapshots

   !> What a table shows.
   subroutine plan_table(group, deck, simulation, shapes, table)
      type(group_t), intent(in) :: group             !! The &output
      type(deck_t), intent(inout) :: deck            !! The deck, for bodies and complaints
      type(simulation_t), intent(inout) :: simulation !! With fields, for the names; not changed
      type(named_shape_t), intent(in) :: shapes(:)   !! The regions
      type(tables_t), intent(inout) :: table         !! The table
      character(len=64), allocatable :: fields(:)
      character(len=:), allocatable :: word
      type(error_t), allocatable :: error
      real(wp) :: limit

      select case (table%kind)
      case (of_bins)
         call read_fields(group, deck, simulation, table%kind, fields)
         call choose_means(simulation%stores, fields, .false., table%profile%means, error)
         call read_rule(group, deck, shapes, table%profile%rule)
         table%profile%axis = axis_of(group, deck, simulation%space%grid)
         table%profile%lower = simulation%space%grid%lower(table%profile%axis)
         table%profile%upper = simulation%space%grid%upper(table%profile%axis)
         call group%get("bins", table%profile%bins)
         if (any(table%profile%means%weight == highest) .and. (table%profile%axis == 3 .or. &
            .not. simulation%space%grid%active(3))) call deck%complain(group, &
               "surface_height is a "// &
            "height along z and needs bins along x or y in a scene that has a z", "fields")
      case (of_fragments)
         call read_rule(group, deck, shapes, table%fragments%rule)
         call group%get("matter", word)
         table%fragments%rule%intact = word == "intact"
         call group%get("velocity_cut", limit)
         if (limit > unset) table%fragments%velocity_cut = limit
      case default
         call read_fields(group, deck, simulation, table%kind, fields)
         call choose_history(fields, allocated(simulation%effects%exact), simulation%space%grid, &
            allocated(simulation%effects%gravity), table%columns, error)
      end select
   end subroutine plan_table

   !> Bodies and region that particles must be of.
   subroutine read_rule(group, deck, shapes, rule)
      type(group_t), intent(in) :: group             !! The &output
      type(deck_t), intent(inout) :: deck            !! The deck, for bodies
      type(named_shape_t), intent(in) :: shapes(:)   !! The regions
      type(pick_rule_t), intent(inout) :: rule       !! Gets what is asked
      type(text_t), allocatable :: names(:)
      character(len=:), allocatable :: region
      integer :: n, place

      call group%get("region", region)
      do n = 1, size(shapes)
         if (region == "" .or. shapes(n)%name /= region) cycle
         if (allocated(shapes(n)%points)) call deck%complain(group, "'"//region// &
            "' is a list of points, which has no inside; name another region", "region")
         rule%region = shapes(n)%shape
      end do
      call group%list("bodies", names)
      if (size(names) == 0) return
      allocate (rule%bodies(0))
      do n = 1, size(names)
         place = deck%named("body", names(n)%text)
         if (place > 0) rule%bodies = [rule%bodies, int(place, int64)]
      end do
   end subroutine read_rule

   !> Number of the axis, which the scene must have.
   integer function axis_of(group, deck, grid) result(axis)
      type(group_t), intent(in) :: group             !! The &output
      type(deck_t), intent(inout) :: deck            !! Collects complaints
      type(grid_t), intent(in) :: grid               !! The grid
      character(len=:), allocatable :: word

      call group%get("axis", word)
      axis = max(index("xyz", word(:1)), 1)
      if (.not. grid%active(axis)) call deck%complain(group, &
         "axis = '"//word//"' is a direction that the scene lacks; take one that it has", "axis")
   end function axis_of

   !> A plane, as what lies less than half a cell from it.
   subroutine read_plane(group, deck, grid, rule)
      type(group_t), intent(in) :: group             !! The &output
      type(deck_t), intent(inout) :: deck            !! Collects complaints
      type(grid_t), intent(in) :: grid               !! The grid
      class(pick_rule_t), intent(inout) :: rule      !! Gets the plane
      real(wp) :: at

      rule%axis = axis_of(group, deck, grid)
      call group%get("at", at)
      if (at <= unset) return
      rule%lower = at - 0.5_wp*grid%spacing
      rule%upper = at + 0.5_wp*grid%spacing
      if (at < grid%lower(rule%axis) .or. at > grid%upper(rule%axis)) call deck%complain(group, &
         "the plane lies outside of the grid, from "//deck%shown(grid%lower(rule%axis), "m")// &
         " to "//deck%shown(grid%upper(rule%axis), "m"), "at")
   end subroutine read_plane

   !> Cells of the grid, in the region if there is one: more no file can get.
   pure real(wp) function most_cells_of(grid, rule) result(cells)
      type(grid_t), intent(in) :: grid               !! The grid
      class(pick_rule_t), intent(in) :: rule         !! Which particles
      real(wp) :: lower(3), upper(3)

      lower = grid%lower
      upper = grid%upper
      if (allocated(rule%region)) call rule%region%bounds(lower, upper)
      lower = max(lower, grid%lower)
      upper = min(upper, grid%upper)
      cells = product(max((upper - lower)/grid%spacing, 1.0_wp), mask=grid%active)
   end function most_cells_of
end module output_stream_deck
