! SPDX-License-Identifier: BSD-3-Clause
!> Output of a gauge: a table of the signal of an instrument at one position, one row per time.
module stream_gauge
   use base_error, only: error_t
   use base_kinds, only: int64, wp
   use base_text, only: brief
   use deck_reader, only: deck_t, group_t
   use deck_schema, only: schema_t
   use output_field_names, only: declare_fields, read_fields
   use output_selection, only: declare_selection, read_selection
   use output_stream, only: field_length
   use output_table_stream, only: heading_length, table_stream_t
   use particle_store, only: store_t
   use sample_gauge, only: at_point, find_nearest, gauge_row, gauge_t, on_particle, on_surface, &
      over_selection
   use sample_means, only: at_gauges, choose_means, mean_t
   use sample_profile, only: field_columns
   use scene_regions, only: named_shape_t
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: stream_gauge_t

   !> Words of the key `gauge`, in the order of the constants of sample_gauge.
   character(len=*), parameter :: words = "point particle surface mean"
   !> Words of the key `side`: axis 1 to 3, lower side first.
   character(len=2), parameter :: sides(6) = ["-x", "+x", "-y", "+y", "-z", "+z"]

   !> A gauge.
   type, extends(table_stream_t) :: stream_gauge_t
      type(gauge_t) :: gauge                         !! Position and quantity
   contains
      procedure :: about => gauge_about              !! For the help
      procedure :: ending => gauge_ending            !! Suffix of file names
      procedure :: declare => gauge_declare          !! Keys
      procedure :: read => gauge_read                !! Read the keys
      procedure :: try_field => gauge_try_field      !! Check a name
      procedure :: list_columns => gauge_list_columns !! Names of columns
      procedure :: prepare => gauge_prepare          !! Find the particle
      procedure :: write_rows => gauge_write_rows    !! Write a row
      procedure :: counters => gauge_counters        !! With the particle
      procedure :: set_counters => gauge_set_counters !! With the particle
   end type stream_gauge_t

contains

   !> For the help of `kind`.
   pure function gauge_about(self) result(text)
      class(stream_gauge_t), intent(in) :: self
      character(len=:), allocatable :: text

      text = "a table of values at a point, a particle or a surface, or of means"
   end function gauge_about

   !> Suffix of the file name, after the case.
   pure function gauge_ending(self) result(text)
      class(stream_gauge_t), intent(in) :: self
      character(len=:), allocatable :: text

      text = "_gauge.csv"
   end function gauge_ending

   !> Declare the keys of the kind.
   subroutine gauge_declare(self, schema, kind)
      class(stream_gauge_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema        !! Schema that receives the keys
      character(len=*), intent(in) :: kind           !! Word of the kind in the catalogue

      call declare_fields(schema, kind)
      call declare_selection(schema, kind)
      call schema%text("output", "gauge", "what is measured: point, the material around a "// &
         "fixed point; particle, the particle nearest to the point at the start; surface, the "// &
         "surface of the material where a beam along an axis through the point meets it; mean, "// &
         "means over bodies and region", default="point", words=words, owner="kind = "//kind)
      call schema%real("output", "point(3)", "position of the gauge", unit="m", &
         owner="kind = "//kind//" & gauge = point particle surface")
      call schema%real("output", "radius", &
         "radius of the measured material, or of the beam on a surface; default: 1.5 cells", &
         unit="m", range="> 0", owner="kind = "//kind//" & gauge = point surface")
      call schema%real("output", "depth", &
         "depth below the surface over which material is measured; default: two cells", unit="m", &
         range="> 0", owner="kind = "//kind//" & gauge = surface")
      call schema%text("output", "side", "side from which the beam comes", &
         words="-x +x -y +y -z +z", owner="kind = "//kind//" & gauge = surface")
   end subroutine gauge_declare

   !> Read the keys of the kind.
   subroutine gauge_read(self, group, deck, simulation, shapes)
      class(stream_gauge_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! Group &output
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(simulation_t), intent(in) :: simulation   !! Read for the names of fields
      type(named_shape_t), intent(in) :: shapes(:)
      character(len=field_length), allocatable :: fields(:)
      type(error_t), allocatable :: error
      character(len=:), allocatable :: word

      call read_fields(group, deck, simulation, self, fields)
      ! read_fields has removed each invalid name
      call choose_means(simulation%stores, fields, at_gauges, self%gauge%means, error)
      call read_selection(group, deck, shapes, self%gauge%rule)
      call group%get("gauge", word)
      select case (word)
      case ("particle")
         self%gauge%kind = on_particle
      case ("surface")
         self%gauge%kind = on_surface
      case ("mean")
         self%gauge%kind = over_selection
         return
      case default
         self%gauge%kind = at_point
      end select
      call read_place(self%gauge, group, deck, simulation)
      if (self%gauge%kind == on_surface) call read_side(self%gauge, group, deck, simulation)
   end subroutine gauge_read

   !> Read point and radius.
   subroutine read_place(gauge, group, deck, simulation)
      type(gauge_t), intent(inout) :: gauge          !! Receives them
      type(group_t), intent(in) :: group             !! The &output
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(simulation_t), intent(in) :: simulation   !! For the grid

      associate (grid => simulation%space%grid)
         gauge%radius = 1.5_wp*grid%spacing
         gauge%depth = 2.0_wp*grid%spacing
         if (group%given("radius")) call group%get("radius", gauge%radius)
         if (group%given("depth")) call group%get("depth", gauge%depth)
         if (.not. group%given("point")) then
            call deck%add_error(group, "a gauge needs a point = x, y, z; or use gauge = "// &
               "'mean' for means over bodies and region [D359]", "point")
            return
         end if
         if (.not. group%valid(["point"])) return
         call group%get("point", gauge%point)
         if (any(grid%active .and. (gauge%point < grid%lower .or. gauge%point > grid%upper))) &
            call deck%add_error(group, "the point lies outside of the grid, whose corners are "// &
            corner(deck, grid%lower)//" and "//corner(deck, grid%upper)//" [D409]", "point")
      end associate
   end subroutine read_place

   !> A corner in the units of the deck.
   function corner(deck, place) result(text)
      type(deck_t), intent(in) :: deck
      real(wp), intent(in) :: place(3)               !! [m]
      character(len=:), allocatable :: text

      text = deck%shown(place(1), "m")//", "//deck%shown(place(2), "m")//", "// &
         deck%shown(place(3), "m")
   end function corner

   !> Read the side of a surface, along an active direction of the scene.
   subroutine read_side(gauge, group, deck, simulation)
      type(gauge_t), intent(inout) :: gauge          !! Gets axis and side
      type(group_t), intent(in) :: group             !! The &output
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(simulation_t), intent(in) :: simulation   !! For the grid
      character(len=:), allocatable :: word
      integer :: n

      if (.not. group%given("side")) then
         call deck%add_error(group, "a gauge of a surface needs the side from which the beam "// &
            "comes, such as side = '+x' [D359]", "side")
         return
      end if
      call group%get("side", word)
      do n = 1, size(sides)
         if (sides(n) == word) exit
      end do
      if (n > size(sides)) return
      gauge%axis = (n + 1)/2
      gauge%side = merge(1.0_wp, -1.0_wp, mod(n, 2) == 0)
      if (.not. simulation%space%grid%active(gauge%axis)) call deck%add_error(group, &
         "side = '"//word//"' is along a direction that the scene does not have; use another "// &
         "one [D435]", "side")
   end subroutine read_side

   !> Try one name of the key `fields`.
   subroutine gauge_try_field(self, field, simulation, stores, error)
      class(stream_gauge_t), intent(in) :: self
      character(len=*), intent(in) :: field          !! Name of the field
      type(simulation_t), intent(in) :: simulation   !! Unused
      type(store_t), intent(in) :: stores(:)         !! Particles
      type(error_t), allocatable, intent(out) :: error !! The field has no mean
      type(mean_t), allocatable :: means(:)

      call choose_means(stores, [field], at_gauges, means, error)
   end subroutine gauge_try_field

   !> Names of the columns with units.
   subroutine gauge_list_columns(self, columns)
      class(stream_gauge_t), intent(in) :: self
      character(len=heading_length), allocatable, intent(out) :: columns(:) !! Headings

      columns = [character(len=heading_length) :: "time [s]", "step", "x [m]", "y [m]", "z [m]", &
         "particles"]
      columns = [character(len=heading_length) :: columns, field_columns(self%gauge%means)]
   end subroutine gauge_list_columns

   !> Find the observed particle, at the first row. Collective.
   subroutine gauge_prepare(self, simulation, note)
      class(stream_gauge_t), intent(inout) :: self
      type(simulation_t), intent(inout) :: simulation
      character(len=:), allocatable, intent(inout) :: note !! Lines for the log
      real(wp) :: distance

      if (self%gauge%kind /= on_particle .or. self%gauge%identity >= 0) return
      associate (grid => simulation%space%grid)
         call find_nearest(simulation%machine%communicator, grid, simulation%stores, self%gauge, &
            distance)
         if (distance <= grid%spacing) return
         if (len(note) > 0) note = note//new_line("a")
         if (self%gauge%identity == huge(self%gauge%identity)) then
            note = note//"  "//self%file//": there is no particle that it could follow"
         else
            note = note//"  "//self%file//": the nearest particle is "// &
               brief(distance/grid%spacing)//" cells from the point"
         end if
      end associate
   end subroutine gauge_prepare

   !> Write the row of the present time. Collective.
   subroutine gauge_write_rows(self, simulation, error)
      class(stream_gauge_t), intent(inout) :: self
      type(simulation_t), intent(inout) :: simulation
      type(error_t), allocatable, intent(out) :: error !! The file cannot be written
      real(wp), allocatable :: row(:)

      call gauge_row(simulation%machine%communicator, simulation%space%grid, &
         simulation%space%tiles%coordinate, simulation%stores, self%gauge, row)
      call self%table%row(simulation%machine%communicator, [simulation%clock%time, &
         real(simulation%clock%step, wp), row], error)
   end subroutine gauge_write_rows

   !> State of the stream for a checkpoint.
   pure function gauge_counters(self) result(counters)
      class(stream_gauge_t), intent(in) :: self
      integer(int64), allocatable :: counters(:)

      counters = [self%last_step, self%gauge%identity]
   end function gauge_counters

   !> Set the state from a checkpoint.
   pure subroutine gauge_set_counters(self, counters)
      class(stream_gauge_t), intent(inout) :: self
      integer(int64), intent(in) :: counters(:)      !! From gauge_counters

      self%last_step = counters(1)
      if (size(counters) > 1) self%gauge%identity = counters(2)
   end subroutine gauge_set_counters
end module stream_gauge
