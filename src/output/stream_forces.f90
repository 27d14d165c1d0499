! SPDX-License-Identifier: BSD-3-Clause
!> Output of forces: a table of the forces of the material on boundaries, their parts and rigid
!! regions. Equation (O.2) of doc/theory/instruments.md.
module stream_forces
   use base_deck, only: deck_t, group_t
   use base_error, only: error_t
   use base_exact_sum, only: exact_sum_t
   use base_kinds, only: int64, wp
   use base_schema, only: schema_t
   use base_text, only: append, closest, text_t
   use io_exact_totals, only: totals_over_ranks
   use mesh_boundary, only: face_names
   use mesh_wall, only: wall_t
   use mesh_wall_sums, only: wall_entries
   use output_table_stream, only: heading_length, table_stream_t
   use scene_regions, only: named_shape_t
   use step_simulation, only: simulation_t
   use step_walls, only: number_of_walls
   implicit none
   private

   public :: stream_forces_t

   integer, parameter :: label_length = 24           !! Longest name of a wall in a heading
   integer, parameter :: columns_of_wall = 7         !! Force, impulse, work

   !> Forces on walls.
   type, extends(table_stream_t) :: stream_forces_t
      type(text_t), allocatable :: name(:)           !! (shown) Names of the walls that are shown
      integer, allocatable :: wall(:)                !! (shown) Their indices
      real(wp), allocatable :: last(:, :)            !! (entry, shown) Sums at the last row
      real(wp) :: last_time = -1.0_wp                !! Time of that row, < 0 = none [s]
   contains
      procedure :: about => forces_about             !! For the help
      procedure :: ending => forces_ending           !! Suffix of file names
      procedure :: declare => forces_declare         !! Keys
      procedure :: read => forces_read               !! Read the keys
      procedure :: list_columns => forces_list_columns !! Names of columns
      procedure :: write_rows => forces_write_rows   !! Write a row
      procedure :: counters => forces_counters       !! With the sums of the last row
      procedure :: set_counters => forces_set_counters !! With the sums of the last row
   end type stream_forces_t

contains

   !> For the help of `kind`.
   pure function forces_about(self) result(text)
      class(stream_forces_t), intent(in) :: self
      character(len=:), allocatable :: text

      text = "a table of forces on boundaries and rigid regions"
   end function forces_about

   !> Suffix of the file name, after the case.
   pure function forces_ending(self) result(text)
      class(stream_forces_t), intent(in) :: self
      character(len=:), allocatable :: text

      text = "_forces.csv"
   end function forces_ending

   !> Declare the keys of the kind.
   subroutine forces_declare(self, schema, kind)
      class(stream_forces_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema        !! Schema that receives the keys
      character(len=*), intent(in) :: kind           !! Word of the kind in the catalogue

      call schema%text("output", "walls(:20)", "boundaries (zlo), parts of boundaries and "// &
         "rigid regions (by the names of their regions) whose forces are written; default: all", &
         owner="kind = "//kind)
   end subroutine forces_declare

   !> Read the keys of the kind. Wall forces are summed from now on.
   subroutine forces_read(self, group, deck, simulation, shapes)
      class(stream_forces_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! Group &output
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(simulation_t), intent(inout) :: simulation !! Its ledger gets the sums
      type(named_shape_t), intent(in) :: shapes(:)   !! Unused
      type(text_t), allocatable :: wanted(:), known(:)
      integer, allocatable :: place(:)
      integer :: n, k

      call list_walls(simulation, known, place)
      call group%list("walls", wanted)
      if (size(wanted) == 0) wanted = known
      allocate (self%name(0), self%wall(0))
      do n = 1, size(wanted)
         do k = 1, size(known)
            if (known(k)%text == wanted(n)%text) exit
         end do
         if (k > size(known)) then
            call deck%add_error(group, "'"//wanted(n)%text//"' is not a wall"// &
               listed(wanted(n)%text, &
               known), "walls")
            cycle
         end if
         call append(self%name, wanted(n)%text(:min(len(wanted(n)%text), label_length)))
         self%wall = [self%wall, place(k)]
      end do
      if (size(known) == 0) call deck%add_error(group, "there is no wall whose force could be "// &
         "shown; add a &boundary or remove this output", "kind")
      allocate (self%last(wall_entries, size(self%wall)), source=0.0_wp)
      call simulation%balance%ledger%walls%start(number_of_walls(simulation%space))
   end subroutine forces_read

   !> Names of the existing walls, for a message.
   function listed(name, known) result(text)
      character(len=*), intent(in) :: name           !! Name as in the deck
      type(text_t), intent(in) :: known(:)           !! Names of the walls
      character(len=:), allocatable :: text
      character(len=:), allocatable :: near
      integer :: n

      text = "; there are:"
      do n = 1, size(known)
         text = text//" "//known(n)%text
      end do
      near = closest(name, known)
      if (near /= "") text = text//"; did you mean '"//near//"'?"
   end function listed

   !> Names of the walls that can have a force, and their indices among the sums.
   pure subroutine list_walls(simulation, names, place)
      type(simulation_t), intent(in) :: simulation
      type(text_t), allocatable, intent(out) :: names(:) !! (wall)
      integer, allocatable, intent(out) :: place(:)  !! (wall)
      integer :: before, n

      allocate (names(0), place(0))
      before = 0
      if (allocated(simulation%space%boundary%wall)) then
         before = size(simulation%space%boundary%wall)
         do n = 1, before
            if (.not. simulation%space%boundary%wall(n)%condition%acts_on_nodes()) cycle
            call append(names, name_of(simulation%space%boundary%wall(n)))
            place = [place, n]
         end do
      end if
      if (.not. allocated(simulation%space%rigid)) return
      do n = 1, size(simulation%space%rigid%wall)
         call append(names, name_of(simulation%space%rigid%wall(n)))
         place = [place, before + n]
      end do
   end subroutine list_walls

   !> Name of a wall: that of its region, else of its boundary.
   pure function name_of(wall) result(name)
      type(wall_t), intent(in) :: wall
      character(len=:), allocatable :: name

      name = trim(wall%name)
      if (name == "" .and. wall%face > 0) name = face_names(wall%face)
   end function name_of

   !> Names of the columns with units.
   subroutine forces_list_columns(self, columns)
      class(stream_forces_t), intent(in) :: self
      character(len=heading_length), allocatable, intent(out) :: columns(:) !! Headings
      character(len=heading_length) :: more(columns_of_wall)
      integer :: n

      columns = [character(len=heading_length) :: "time [s]", "step"]
      do n = 1, size(self%name)
         associate (name => self%name(n)%text)
            more = [character(len=heading_length) :: name//"_force_x [N]", name//"_force_y [N]", &
               name//"_force_z [N]", name//"_impulse_x [N s]", name//"_impulse_y [N s]", &
               name//"_impulse_z [N s]", name//"_work [J]"]
         end associate
         columns = [columns, more]
      end do
   end subroutine forces_list_columns

   !> Write the row of the present time. Forces are means over the time since the last row.
   !! Collective.
   subroutine forces_write_rows(self, simulation, error)
      class(stream_forces_t), intent(inout) :: self
      type(simulation_t), intent(inout) :: simulation
      type(error_t), allocatable, intent(out) :: error !! The file cannot be written
      type(exact_sum_t) :: total(wall_entries*size(self%wall))
      real(wp) :: sums(wall_entries*size(self%wall)), row(columns_of_wall*size(self%wall))
      real(wp) :: now(wall_entries, size(self%wall)), period
      integer :: n

      do n = 1, size(self%wall)
         total(wall_entries*(n - 1) + 1:wall_entries*n) = &
            simulation%balance%ledger%walls%total(:, self%wall(n))
      end do
      call totals_over_ranks(simulation%machine%communicator, total, sums)
      ! the sums are those of the impulse on the material
      now = -reshape(sums, shape(now))
      do n = 1, 3
         if (simulation%space%grid%active(n) .and. .not. (simulation%space%grid%axisymmetric &
            .and. n == 1)) cycle
         now(n, :) = 0.0_wp
      end do
      period = simulation%clock%time - self%last_time
      row = 0.0_wp
      do n = 1, size(self%wall)
         associate (part => row(columns_of_wall*(n - 1) + 1:columns_of_wall*n))
            if (self%last_time >= 0.0_wp .and. period > 0.0_wp) &
               part(1:3) = (now(1:3, n) - self%last(1:3, n))/period
            part(4:columns_of_wall) = now(:, n)
         end associate
      end do
      self%last = now
      self%last_time = simulation%clock%time
      call self%table%row(simulation%machine%communicator, [simulation%clock%time, &
         real(simulation%clock%step, wp), row], error)
   end subroutine forces_write_rows

   !> State of the stream for a checkpoint.
   pure function forces_counters(self) result(counters)
      class(stream_forces_t), intent(in) :: self
      integer(int64), allocatable :: counters(:)

      counters = [self%last_step, transfer([self%last_time, self%last], [0_int64])]
   end function forces_counters

   !> Set the state from a checkpoint; sums of unknown walls are ignored.
   pure subroutine forces_set_counters(self, counters)
      class(stream_forces_t), intent(inout) :: self
      integer(int64), intent(in) :: counters(:)      !! From forces_counters
      real(wp), allocatable :: values(:)

      self%last_step = counters(1)
      if (size(counters) /= 2 + size(self%last)) return
      values = transfer(counters(2:), [0.0_wp])
      self%last_time = values(1)
      self%last = reshape(values(2:), shape(self%last))
   end subroutine forces_set_counters
end module stream_forces
