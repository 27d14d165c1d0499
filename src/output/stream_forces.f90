! SPDX-License-Identifier: BSD-3-Clause
!> Output of forces: a table of the forces of the material on boundaries, their parts and rigid
!! regions, and of contact forces between bodies. Equation (O.2) of doc/theory/instruments.md and
!! equation (C.16) of doc/theory/contact.md.
module stream_forces
   use base_error, only: error_t
   use base_exact_sum, only: exact_sum_t
   use base_exact_totals, only: totals_over_ranks
   use base_kinds, only: int64, wp
   use base_text, only: append, closest, text_t
   use deck_reader, only: deck_t, group_t
   use deck_schema, only: schema_t
   use mesh_boundary_walls, only: face_names
   use mesh_wall, only: wall_t
   use mesh_wall_sums, only: wall_entries
   use output_table_stream, only: heading_length, table_stream_t
   use scene_regions, only: named_shape_t
   use step_simulation, only: simulation_t
   use step_walls, only: pair_row
   implicit none
   private

   public :: stream_forces_t

   integer, parameter :: label_length = heading_length - 16 !! Longest name in a heading
   integer, parameter :: columns_of(2) = [7, 6]      !! Force, impulse, and of walls the work
   integer, parameter :: of_wall = 1, of_pair = 2

   !> Forces on walls, and between bodies.
   type, extends(table_stream_t) :: stream_forces_t
      type(text_t), allocatable :: name(:)           !! (shown) Walls and pairs that are shown
      integer, allocatable :: kind(:)                !! (shown) `of_wall` or `of_pair`
      real(wp), allocatable :: weight(:, :)          !! (row, shown) Sign of each row of the ledger
      real(wp), allocatable :: last(:, :)            !! (entry, shown) Sums at the last row
      real(wp) :: last_time = -1.0_wp                !! Time of that row, < 0 = none [s]
   contains
      procedure :: about => forces_about             !! For the help
      procedure :: ending => forces_ending           !! Suffix of file names
      procedure :: declare => forces_declare         !! Keys
      procedure :: read => forces_read               !! Read the keys
      procedure :: request_sums => forces_request_sums !! Sum the forces in the ledger
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

      text = "a table of forces on boundaries and rigid regions, and between bodies"
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
         "rigid regions (by the names of their regions) whose forces are written; default: "// &
         "all, none if contacts is given", owner="kind = "//kind)
      call schema%text("output", "contacts(:20)", "bodies whose contact forces are written, "// &
         "for each pair of them: the force of the first of the pair on the second", &
         owner="kind = "//kind)
      call schema%refer("output", "contacts", "body")
   end subroutine forces_declare

   !> Read the keys of the kind.
   subroutine forces_read(self, group, deck, simulation, shapes)
      class(stream_forces_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! Group &output
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(simulation_t), intent(in) :: simulation
      type(named_shape_t), intent(in) :: shapes(:)   !! Unused
      type(text_t), allocatable :: wanted(:), known(:), bodies(:)
      integer, allocatable :: place(:)
      integer :: n, k, m

      call list_walls(simulation, known, place)
      call group%list("walls", wanted)
      call group%list("contacts", bodies)
      if (size(wanted) + size(bodies) == 0) then
         wanted = known
         if (size(known) == 0) call deck%add_error(group, "there is no wall whose force could "// &
            "be shown; add a &boundary, give contacts, or remove this output [D358]", "kind")
      end if
      allocate (self%name(0), self%kind(0), self%weight(number_of_rows(simulation), 0))
      do n = 1, size(wanted)
         do k = 1, size(known)
            if (known(k)%text == wanted(n)%text) exit
         end do
         if (k > size(known)) then
            call deck%add_error(group, "'"//wanted(n)%text//"' is not a wall"// &
               listed(wanted(n)%text, &
               known)//" [D358]", "walls")
            cycle
         end if
         ! the sums are those of the impulse on the material
         call show(self, of_wall, wanted(n)%text, [(merge(-1.0_wp, 0.0_wp, m == place(k)), &
            m=1, size(self%weight, 1))])
      end do
      if (size(bodies) > 0) call read_contacts(self, group, deck, simulation, bodies)
      allocate (self%last(wall_entries, size(self%name)), source=0.0_wp)
   end subroutine forces_read

   !> Let the ledger sum the forces from now on.
   subroutine forces_request_sums(self, simulation)
      class(stream_forces_t), intent(in) :: self
      type(simulation_t), intent(inout) :: simulation

      call simulation%balance%ledger%walls%start(size(self%weight, 1))
   end subroutine forces_request_sums

   !> Rows of the sums of forces: walls, and pairs of velocity fields.
   pure integer function number_of_rows(simulation) result(rows)
      type(simulation_t), intent(in) :: simulation

      rows = pair_row(simulation%space, 0, 1)
      if (allocated(simulation%effects%contact)) &
         rows = pair_row(simulation%space, 0, size(simulation%fields) + 1)
   end function number_of_rows

   !> Show the force of a wall or a pair of bodies.
   pure subroutine show(self, kind, name, weight)
      class(stream_forces_t), intent(inout) :: self
      integer, intent(in) :: kind                    !! `of_wall` or `of_pair`
      character(len=*), intent(in) :: name           !! For the headings
      real(wp), intent(in) :: weight(:)              !! (row) 1, -1 or 0

      call append(self%name, name(:min(len(name), label_length)))
      self%kind = [self%kind, kind]
      self%weight = reshape([self%weight, weight], [size(weight), size(self%name)])
   end subroutine show

   !> Read the bodies whose contact forces are shown: one force for each pair.
   subroutine read_contacts(self, group, deck, simulation, bodies)
      class(stream_forces_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! Group &output
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(simulation_t), intent(in) :: simulation
      type(text_t), intent(in) :: bodies(:)          !! Names
      type(group_t) :: effects
      logical :: acts
      integer :: place(size(bodies)), a, b, n

      effects = deck%group("effects", 1)
      call effects%get("contact", acts)
      if (.not. acts) call deck%add_error(group, "contacts needs &effects contact = .true.; "// &
         "without it all bodies share one velocity field and there is no contact force; the "// &
         "momentum of a body over time is in an output of kind = 'history' with bodies [D368]", &
         "contacts")
      if (size(bodies) < 2) call deck%add_error(group, "contacts has one body; name two or "// &
         "more [D368]", "contacts")
      do n = 1, size(bodies)
         place(n) = deck%named("body", bodies(n)%text)
      end do
      if (any(place == 0) .or. .not. allocated(simulation%effects%contact)) return
      do b = 2, size(bodies)
         do a = 1, b - 1
            associate (one => simulation%effects%contact%field_of_body(place(a)), &
               other => simulation%effects%contact%field_of_body(place(b)))
               if (one == other) then
                  call deck%add_error(group, "'"//bodies(a)%text//"' and '"//bodies(b)%text// &
                     "' share a velocity field, so no contact force acts between them; give "// &
                     "them different values of field in &body [D368]", "contacts")
               else
                  call show(self, of_pair, bodies(a)%text//"_"//bodies(b)%text, &
                     weight_of_pair(simulation, one, other))
               end if
            end associate
         end do
      end do
   end subroutine read_contacts

   !> Signs of the rows that are the force of one body on another: between their velocity fields and
   !! the second sides of these. A row is the impulse on the field with the greater number.
   pure function weight_of_pair(simulation, one, other) result(weight)
      type(simulation_t), intent(in) :: simulation
      integer, intent(in) :: one, other              !! Velocity fields of the bodies
      real(wp) :: weight(number_of_rows(simulation))
      integer :: a(2), b(2), n, k

      weight = 0.0_wp
      a = [one, simulation%fields(one)%other]
      b = [other, simulation%fields(other)%other]
      do n = 1, 2
         do k = 1, 2
            if (a(n) > 0 .and. b(k) > 0) weight(pair_row(simulation%space, min(a(n), b(k)), &
               max(a(n), b(k)))) = merge(1.0_wp, -1.0_wp, a(n) < b(k))
         end do
      end do
   end function weight_of_pair

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
      character(len=heading_length) :: more(columns_of(of_wall))
      integer :: n

      columns = [character(len=heading_length) :: "time [s]", "step"]
      do n = 1, size(self%name)
         associate (name => self%name(n)%text)
            more = [character(len=heading_length) :: name//"_force_x [N]", name//"_force_y [N]", &
               name//"_force_z [N]", name//"_impulse_x [N s]", name//"_impulse_y [N s]", &
               name//"_impulse_z [N s]", name//"_work [J]"]
         end associate
         columns = [columns, more(:columns_of(self%kind(n)))]
      end do
   end subroutine forces_list_columns

   !> Write the row of the present time. Forces are means over the time since the last row.
   !! Collective.
   subroutine forces_write_rows(self, simulation, error)
      class(stream_forces_t), intent(inout) :: self
      type(simulation_t), intent(inout) :: simulation
      type(error_t), allocatable, intent(out) :: error !! The file cannot be written
      type(exact_sum_t) :: total(wall_entries*size(self%weight, 1))
      real(wp) :: sums(wall_entries*size(self%weight, 1)), row(sum(columns_of(self%kind)))
      real(wp) :: now(wall_entries, size(self%name)), period
      integer :: first, m, n

      total = reshape(simulation%balance%ledger%walls%total, shape(total))
      call totals_over_ranks(simulation%machine%communicator, total, sums)
      now = 0.0_wp
      do n = 1, size(self%name)
         do m = 1, size(self%weight, 1)
            now(:, n) = now(:, n) + self%weight(m, n)*sums((m - 1)*wall_entries + 1:m*wall_entries)
         end do
      end do
      do n = 1, 3
         if (simulation%space%grid%active(n) .and. .not. (simulation%space%grid%axisymmetric &
            .and. n == 1)) cycle
         now(n, :) = 0.0_wp
      end do
      period = simulation%clock%time - self%last_time
      row = 0.0_wp
      first = 1
      do n = 1, size(self%name)
         associate (part => row(first:first + columns_of(self%kind(n)) - 1))
            if (self%last_time >= 0.0_wp .and. period > 0.0_wp) &
               part(1:3) = (now(1:3, n) - self%last(1:3, n))/period
            part(4:) = now(:size(part) - 3, n)
         end associate
         first = first + columns_of(self%kind(n))
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
