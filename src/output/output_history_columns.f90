! SPDX-License-Identifier: BSD-3-Clause
!> Columns of a history: by default the whole ledger, else those that the deck names. Some are
!! computed only on request. A history of bodies or of a region has only sums over their particles.
module output_history_columns
   use base_error, only: error_t, exit_input, fail
   use base_exact_sum, only: exact_sum_t
   use base_exact_totals, only: totals_over_ranks
   use base_kinds, only: wp
   use base_text, only: append, closest, text_t
   use mesh_grid, only: grid_t
   use output_table_stream, only: heading_length
   use particle_store, only: store_t
   use sample_pick, only: pick_rule_t
   use sample_profile, only: half_size, profile_rows, profile_t
   use step_diagnostics, only: examine_shapes, shapes_sample_t
   use step_exact_error, only: error_columns, measure_errors
   use step_ledger, only: balance_t, clear_meaningless, ledger_entries, mass, momentum, &
      rigid_momentum, scale_count, sum_store
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: choose_history, history_columns_t, history_names, history_row

   integer, parameter :: before = 3                  !! Columns before the ledger
   integer, parameter :: sums = 5                    !! Columns after it: total and errors
   integer, parameter :: all_ledger = before + size(ledger_entries) + sums
   integer, parameter :: all_errors = size(error_columns) !! Columns of an exact solution
   !> Columns written only on request, with units; and their numbers.
   character(len=19), parameter :: further(19) = [character(len=19) :: "potential [J]", &
      "runout [m]", "height [m]", "front_x [m]", "front_y [m]", "front_z [m]", "tail_x [m]", &
      "tail_y [m]", "tail_z [m]", "centre_x [m]", "centre_y [m]", "centre_z [m]", &
      "velocity_x [m/s]", "velocity_y [m/s]", "velocity_z [m/s]", "stretch [1]", &
      "stretched_share [1]", "overlap [1]", "noise [Pa]"]
   integer, parameter :: potential = 1, runout = 2, height = 3, front = 4, tail = 7, &
      centre = 10, velocity = 13, stretch = 16
   character(len=*), parameter :: other_name = "mass_failed" !! Other name of failed_mass
   integer, parameter :: every = all_ledger + all_errors + size(further)
   real(wp), parameter :: runout_mass = 0.99_wp      !! Fraction of the mass within the run-out

   !> The columns of a history, by their numbers in the list of all columns.
   type :: history_columns_t
      integer, allocatable :: chosen(:)              !! In their order in the file
      logical :: further(size(further)) = .false.    !! Index among those not in the ledger
      type(pick_rule_t) :: rule                      !! Particles that count
   contains
      procedure :: headings => columns_headings      !! Names with units
   end type history_columns_t

contains

   !> Names of all columns without their units.
   pure function history_names() result(names)
      type(text_t), allocatable :: names(:)
      character(len=heading_length) :: list(every)
      integer :: n

      list = all_columns()
      allocate (names(0))
      do n = 1, size(list)
         call append(names, name_of(list(n)))
      end do
   end function history_names

   !> All possible columns: time, ledger, errors against an exact solution, further ones.
   pure function all_columns() result(columns)
      character(len=heading_length) :: columns(every)
      integer :: n

      columns(:before) = [character(len=heading_length) :: "time [s]", "step", "dt [s]"]
      do n = 1, size(ledger_entries)
         columns(before + n) = trim(ledger_entries(n)%name)//" ["//trim(ledger_entries(n)%unit)//"]"
      end do
      columns(before + size(ledger_entries) + 1:all_ledger) = [character(len=heading_length) :: &
         "total [J]", &
         "mass_error [1]", "momentum_error [1]", "angular_momentum_error [1]", "energy_error [1]"]
      columns(all_ledger + 1:all_ledger + all_errors) = error_columns
      columns(all_ledger + all_errors + 1:) = further
   end function all_columns

   !> The name in a heading.
   pure function name_of(heading) result(name)
      character(len=*), intent(in) :: heading        !! As "time [s]"
      character(len=:), allocatable :: name

      name = trim(heading)
      if (index(name, " [") > 0) name = name(:index(name, " [") - 1)
   end function name_of

   !> Choose columns by their names; "default" is the ledger, with the errors of an exact solution.
   !! For some of the particles "default" is the sums over them, with centre and mean velocity. Time
   !! and step are always included.
   subroutine choose_history(fields, with_exact, grid, with_gravity, columns, error, with_bodies)
      character(len=*), intent(in) :: fields(:)      !! Names, or "default"
      logical, intent(in) :: with_exact              !! Is there an exact solution?
      type(grid_t), intent(in) :: grid               !! The grid and its directions
      logical, intent(in) :: with_gravity            !! Is there gravity?
      type(history_columns_t), intent(inout) :: columns !! Definition of the history; has its rule
      type(error_t), allocatable, intent(out) :: error !! A name does not work
      logical, intent(in), optional :: with_bodies   !! Do forces move rigid regions? Default: no
      character(len=heading_length) :: list(every)
      character(len=:), allocatable :: fault
      logical :: chosen(every), rigid
      integer :: n, k

      list = all_columns()
      rigid = .false.
      if (present(with_bodies)) rigid = with_bodies
      if (allocated(columns%chosen)) deallocate (columns%chosen)
      allocate (columns%chosen(0))
      chosen = .false.
      call take(1, columns%chosen, chosen)
      call take(2, columns%chosen, chosen)
      do n = 1, size(fields)
         if (fields(n) == "default") then
            do k = 1, size(list)
               if (of_bodies(k) .and. .not. rigid) cycle
               if (is_usual(k, columns%rule%takes_all(), with_exact)) &
                  call take(k, columns%chosen, chosen)
            end do
            cycle
         end if
         do k = size(list), 1, -1
            if (name_of(list(k)) == fields(n)) exit
            if (fields(n) == other_name .and. name_of(list(k)) == "failed_mass") exit
         end do
         fault = find_fault(fields(n), k, with_exact, grid, with_gravity)
         if (fault == "" .and. .not. (columns%rule%takes_all() .or. of_particles(k))) &
            fault = "is known for all material only, not for bodies or a region; there are: "// &
            join_names(list)//" [D345]"
         if (fault /= "") then
            call fail(error, exit_input, "output field '"//trim(fields(n))//"' "//fault)
            return
         end if
         call take(k, columns%chosen, chosen)
      end do
      columns%further = chosen(all_ledger + all_errors + 1:)
   end subroutine choose_history

   !> True for the columns of rigid bodies.
   pure logical function of_bodies(number) result(of)
      integer, intent(in) :: number                  !! Number of the column

      of = number >= before + rigid_momentum .and. number <= before + size(ledger_entries)
   end function of_bodies

   !> True if "default" contains a column.
   pure logical function is_usual(number, all_particles, with_exact) result(usual)
      integer, intent(in) :: number                  !! Number of the column
      logical, intent(in) :: all_particles           !! Is the history that of all particles?
      logical, intent(in) :: with_exact              !! Is there an exact solution?

      if (all_particles) then
         usual = number <= merge(all_ledger + all_errors, all_ledger, with_exact)
      else
         usual = of_particles(number)
         associate (n => number - all_ledger - all_errors)
            if (n > 0) usual = n >= centre .and. n < stretch
         end associate
      end if
   end function is_usual

   !> True if a column is a time, or a property of particles that is known for some of them.
   pure logical function of_particles(number) result(known)
      integer, intent(in) :: number                  !! Number of the column

      known = number <= before
      if (number > before .and. number <= before + size(ledger_entries)) &
         known = .not. (ledger_entries(number - before)%accumulates .or. of_bodies(number))
      if (number > all_ledger + all_errors) known = number - all_ledger - all_errors < stretch
   end function of_particles

   !> Names of the columns that are known for some of the particles.
   pure function join_names(list) result(text)
      character(len=*), intent(in) :: list(:)        !! Headings of all columns
      character(len=:), allocatable :: text
      integer :: n

      text = "default"
      do n = 1, size(list)
         if (of_particles(n)) text = text//" "//name_of(list(n))
      end do
   end function join_names

   !> Select a column, unless it is already selected.
   pure subroutine take(number, list, chosen)
      integer, intent(in) :: number                  !! Index
      integer, allocatable, intent(inout) :: list(:) !! In their order
      logical, intent(inout) :: chosen(:)            !! Selected columns

      if (.not. chosen(number)) list = [list, number]
      chosen(number) = .true.
   end subroutine take

   !> Error message for a name; empty if it is valid.
   pure function find_fault(name, number, with_exact, grid, with_gravity) result(text)
      character(len=*), intent(in) :: name           !! Name as in the deck
      integer, intent(in) :: number                  !! Number of the column, 0 = none
      logical, intent(in) :: with_exact              !! Is there an exact solution?
      type(grid_t), intent(in) :: grid               !! The grid and its directions
      logical, intent(in) :: with_gravity            !! Is there gravity?
      character(len=:), allocatable :: text
      type(text_t), allocatable :: names(:)
      character(len=:), allocatable :: near
      logical :: lacks
      integer :: n

      text = ""
      if (number == 0) then
         text = "is unknown in a history; there are: default"
         names = history_names()
         do n = 1, size(names)
            text = text//" "//names(n)%text
         end do
         near = closest(trim(name), names)
         if (near /= "") text = text//"; did you mean '"//near//"'?"
         text = text//" [D221]"
         return
      end if
      if (number > all_ledger .and. number <= all_ledger + all_errors .and. .not. with_exact) &
         text = "needs &exact, a solution to compare with [D366]"
      n = number - all_ledger - all_errors
      if (n < 1) return
      if (n == potential .and. .not. with_gravity) text = "needs &effects gravity = .true. [D306]"
      lacks = n == height .and. .not. grid%active(3)
      if (n >= front .and. n < stretch) lacks = .not. grid%active(mod(n - front, 3) + 1)
      if (lacks) text = "is along a direction that the scene does not have; remove it [D435]"
   end function find_fault

   !> Names of the columns with units.
   pure function columns_headings(self) result(headings)
      class(history_columns_t), intent(in) :: self
      character(len=heading_length), allocatable :: headings(:)
      character(len=heading_length) :: list(every)

      list = all_columns()
      headings = list(self%chosen)
   end function columns_headings

   !> Values of a line. Collective.
   subroutine history_row(simulation, columns, row)
      type(simulation_t), intent(inout) :: simulation
      type(history_columns_t), intent(in) :: columns !! Columns of the history
      real(wp), allocatable, intent(out) :: row(:)   !! (column)
      real(wp) :: values(every)
      type(balance_t) :: now
      type(shapes_sample_t) :: sample
      real(wp) :: entry(size(ledger_entries))
      logical :: all_particles

      values = 0.0_wp
      all_particles = columns%rule%takes_all()
      if (all_particles) call simulation%balance%ledger%balance(simulation%machine%communicator, &
         simulation%space%grid, simulation%stores, simulation%materials, now)
      if (.not. all_particles .or. any(columns%further(centre:stretch - 1))) then
         call sum_selected(simulation, columns%rule, entry, &
            values(all_ledger + all_errors + centre:all_ledger + all_errors + stretch - 1))
         if (.not. all_particles) now%entry = entry
      end if
      values(:all_ledger) = [simulation%clock%time, real(simulation%clock%step, wp), &
         simulation%clock%dt, now%entry, &
         now%total, now%mass_error, now%momentum_error, now%angular_error, now%energy_error]
      if (allocated(simulation%effects%exact) .and. all_particles) then
         call measure_errors(simulation)
         values(all_ledger + 1:all_ledger + all_errors) = simulation%effects%exact%error
      end if
      associate (more => values(all_ledger + all_errors + 1:))
         if (columns%further(potential)) &
            more(potential) = potential_energy(simulation, columns%rule)
         if (columns%further(runout)) more(runout) = reach(simulation, columns%rule)
         if (any(columns%further(stretch:))) then
            call examine_shapes(simulation%space, simulation%materials, simulation%stores, &
               simulation%balance%trust, simulation%machine%communicator, sample)
            more(stretch:) = [sample%longest, sample%share, sample%overlap, sample%difference]
         end if
         if (any(columns%further(height:tail + 2))) call find_ends(simulation, columns%rule, &
            more(height), more(front:front + 2), more(tail:tail + 2))
      end associate
      row = values(columns%chosen)
   end subroutine history_row

   !> Sums over the selected particles, their centre of mass and mean velocity, in the directions
   !! in which the scene has a momentum. All are 0 without particles. Collective.
   subroutine sum_selected(simulation, rule, entry, means)
      type(simulation_t), intent(in) :: simulation
      type(pick_rule_t), intent(in) :: rule          !! Selects the particles
      real(wp), intent(out) :: entry(:)              !! Entries of the ledger of the state
      real(wp), intent(out) :: means(6)              !! Centre [m], velocity [m/s]
      type(exact_sum_t) :: sums(size(ledger_entries)), scales(scale_count)
      real(wp) :: scale(scale_count)
      integer :: index

      do index = 1, size(simulation%stores)
         call sum_store(simulation%stores(index), simulation%materials(index), sums, scales, rule)
      end do
      call totals_over_ranks(simulation%machine%communicator, sums, entry)
      call totals_over_ranks(simulation%machine%communicator, scales, scale)
      call clear_meaningless(simulation%space%grid, entry)
      means = 0.0_wp
      if (.not. entry(mass) > 0.0_wp) return
      means = [scale(3:5), entry(momentum:momentum + 2)]/entry(mass)
      if (simulation%space%grid%axisymmetric) means(1) = 0.0_wp
   end subroutine sum_selected

   !> Potential energy of particles in the field of gravity, 0 at the origin. Collective. [J]
   function potential_energy(simulation, rule) result(energy)
      type(simulation_t), intent(in) :: simulation
      type(pick_rule_t), intent(in) :: rule          !! Selects the particles
      real(wp) :: energy
      type(exact_sum_t) :: total
      integer :: index, p, tile

      do index = 1, size(simulation%stores)
         associate (store => simulation%stores(index))
            do tile = 1, size(store%count)
               do p = store%first(tile), store%first(tile) + store%count(tile) - 1
                  if (rule%takes(store, p)) call total%add(-store%state%mass(p) &
                     *dot_product(simulation%effects%gravity, store%position(p, :)))
               end do
            end do
         end associate
      end do
      call total%over_ranks(simulation%machine%communicator)
      energy = total%value()
   end function potential_energy

   !> Position along x below which 99 % of the mass is, found in columns of cells with uniform
   !! mass in each. Collective. [m]
   function reach(simulation, rule) result(place)
      type(simulation_t), intent(inout) :: simulation
      type(pick_rule_t), intent(in) :: rule          !! Selects the particles
      real(wp) :: place
      type(profile_t) :: columns
      real(wp), allocatable :: rows(:, :)
      real(wp) :: mass, width, wanted
      integer :: n

      associate (grid => simulation%space%grid)
         columns%axis = 1
         columns%rule = rule
         columns%lower = grid%lower(1)
         columns%upper = grid%upper(1)
         columns%bins = nint((columns%upper - columns%lower)/grid%spacing)
         width = (columns%upper - columns%lower)/real(columns%bins, wp)
         allocate (columns%means(0))
         call profile_rows(simulation%machine%communicator, grid, simulation%stores, columns, rows)
      end associate
      wanted = runout_mass*sum(rows(4, :))
      mass = 0.0_wp
      place = columns%lower
      do n = 1, columns%bins
         if (rows(4, n) <= 0.0_wp) cycle
         place = columns%lower + width*(real(n - 1, wp) + min((wanted - mass)/rows(4, n), 1.0_wp))
         mass = mass + rows(4, n)
         if (mass >= wanted) exit
      end do
   end function reach

   !> Greatest height of the material, with half the size of the particle, and the greatest and
   !! least positions of particles. Without particles a greatest one is the lower end of the grid, a
   !! least one its upper end. Collective.
   subroutine find_ends(simulation, rule, top, greatest, least)
      type(simulation_t), intent(inout) :: simulation
      type(pick_rule_t), intent(in) :: rule          !! Selects the particles
      real(wp), intent(out) :: top                   !! Along z [m]
      real(wp), intent(out) :: greatest(3)           !! Along x, y, z [m]
      real(wp), intent(out) :: least(3)              !! Along x, y, z [m]
      real(wp) :: ends(7)
      integer :: index, tile

      associate (grid => simulation%space%grid)
         ends = [grid%lower(3), grid%lower, -grid%upper]
         do index = 1, size(simulation%stores)
            associate (store => simulation%stores(index))
               do tile = 1, size(store%count)
                  call widen(grid, store, tile, rule, ends)
               end do
            end associate
         end do
         call simulation%machine%communicator%maxima(ends)
      end associate
      top = ends(1)
      greatest = ends(2:4)
      least = -ends(5:7)
   end subroutine find_ends

   !> Extend the ends to the particles of a tile.
   pure subroutine widen(grid, store, tile, rule, ends)
      type(grid_t), intent(in) :: grid               !! The grid and its directions
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile                    !! Index of the tile
      type(pick_rule_t), intent(in) :: rule          !! Selects the particles
      real(wp), intent(inout) :: ends(7)             !! Top, greatest positions, least ones negative
      integer :: p

      do p = store%first(tile), store%first(tile) + store%count(tile) - 1
         if (.not. rule%takes(store, p)) cycle
         ends(1) = max(ends(1), store%position(p, 3) + half_size(grid, store, p, 3))
         ends(2:4) = max(ends(2:4), store%position(p, :))
         ends(5:7) = max(ends(5:7), -store%position(p, :))
      end do
   end subroutine widen
end module output_history_columns
