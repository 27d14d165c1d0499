! SPDX-License-Identifier: BSD-3-Clause
!> Reads a table of states from text: lines of a density, a temperature, a pressure and an energy in
!! SI units. The lines of a density follow each other with ascending temperatures, which are the
!! same for all densities; densities ascend.
module material_table_text
   use base_decimal, only: file_numbers, without_commas
   use base_error, only: error_t, exit_file, fail
   use base_kinds, only: wp
   use base_text, only: brief, line_end, number, shortened
   use material_table_states, only: state_table_t
   implicit none
   private

   public :: read_states

   integer, parameter :: columns = 4                 !! Numbers of a line
   integer, parameter :: shown = 40                  !! Characters of a wrong line in a message

   !> The numbers of the text.
   type :: listing_t
      integer :: count = 0                           !! Lines of numbers
      real(wp), allocatable :: value(:, :)           !! (4, entry)
      integer, allocatable :: line(:)                !! (entry) Line in the file
   end type listing_t

contains

   !> Parse a table and check it. Empty lines, lines that begin with # and a first line of words are
   !! skipped.
   subroutine read_states(text, path, table, error)
      character(len=*), intent(in) :: text           !! Content of the file
      character(len=*), intent(in) :: path           !! For messages
      type(state_table_t), intent(out) :: table
      type(error_t), allocatable, intent(out) :: error !! Line that is wrong
      type(listing_t) :: listing
      character(len=:), allocatable :: fault

      call read_listing(text, listing, fault)
      if (len(fault) == 0) call fill_table(listing, table, fault)
      if (len(fault) == 0) call check_slopes(listing, table, fault)
      if (len(fault) > 0) call fail(error, exit_file, "cannot use the table '"//path//"': "// &
         fault//" [F119]")
   end subroutine read_states

   !> The numbers of all lines.
   subroutine read_listing(text, listing, fault)
      character(len=*), intent(in) :: text           !! Content of the file
      type(listing_t), intent(out) :: listing
      character(len=:), allocatable, intent(out) :: fault !! Empty if there is none
      character(len=:), allocatable :: line
      logical :: sound
      integer :: first, last, row, lines

      lines = 1
      do first = 1, len(text)
         if (text(first:first) == new_line("a")) lines = lines + 1
      end do
      allocate (listing%value(columns, lines), listing%line(lines))
      fault = ""
      first = 1
      row = 0
      do while (first <= len(text))
         last = line_end(text, first)
         line = without_commas(text(first:last))
         first = last + 2
         row = row + 1
         if (len_trim(line) == 0 .or. index(adjustl(line), "#") == 1) cycle
         call file_numbers(line, listing%value(:, listing%count + 1), sound)
         if (.not. sound .and. listing%count == 0 .and. is_title(line)) cycle
         if (.not. sound) then
            fault = "line "//number(row)//": expected four numbers density, temperature, "// &
               "pressure, energy, not '"//shortened(trim(adjustl(line)), shown)//"'"
            return
         end if
         listing%count = listing%count + 1
         listing%line(listing%count) = row
      end do
   end subroutine read_listing

   !> True if a line has column names: its first word begins with a letter, but for NaN and Inf.
   pure logical function is_title(line) result(title)
      character(len=*), intent(in) :: line           !! Not empty
      character(len=3) :: first

      first = adjustl(line)
      title = scan(first, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ") == 1 .and. &
         scan(first, "nNiI") /= 1
   end function is_title

   !> Densities, temperatures and values of the nodes.
   subroutine fill_table(listing, table, fault)
      type(listing_t), intent(in) :: listing
      type(state_table_t), intent(inout) :: table
      character(len=:), allocatable, intent(out) :: fault !! Empty if there is none
      integer :: n, m

      fault = ""
      n = 1
      do while (n < listing%count)
         if (abs(listing%value(1, n + 1) - listing%value(1, 1)) > 0.0_wp) exit
         n = n + 1
      end do
      if (listing%count == 0 .or. n < 2 .or. listing%count == n) then
         fault = "it needs at least two densities, each with the same two or more temperatures"
         if (listing%count > 0) fault = "line "//number(listing%line(n))//": "//fault
         return
      end if
      call check_order(listing, n, fault)
      if (len(fault) > 0) return
      m = listing%count/n
      allocate (table%density(m), table%temperature(n))
      table%density = listing%value(1, :listing%count:n)
      table%temperature = listing%value(2, :n)
      table%pressure = listing%value(3, :listing%count)
      table%energy = listing%value(4, :listing%count)
   end subroutine fill_table

   !> Check that densities and temperatures ascend and that temperatures are the same.
   pure subroutine check_order(listing, n, fault)
      type(listing_t), intent(in) :: listing
      integer, intent(in) :: n                       !! Temperatures of the first density
      character(len=:), allocatable, intent(out) :: fault !! Empty if there is none
      integer :: k, first

      fault = ""
      do k = 1, listing%count
         first = 1 + mod(k - 1, n)
         associate (now => listing%value(:, k))
            if (.not. now(1) > 0.0_wp) then
               fault = "densities must be above 0, not "//number(now(1))
            else if (.not. now(2) >= 0.0_wp) then
               fault = "temperatures must not be below 0, not "//number(now(2))
            else if (first == 1 .and. k > 1) then
               if (now(1) <= listing%value(1, max(k - 1, 1))) fault = &
                  "densities must ascend; "//number(now(1))//" follows "// &
                  number(listing%value(1, k - 1))
            else if (k > 1) then
               if (abs(now(1) - listing%value(1, k - 1)) > 0.0_wp) fault = "density "// &
                  number(listing%value(1, k - 1))//" must have the "//number(n)// &
                  " temperatures of the first one, but "//number(now(1))//" follows"
            end if
            if (len(fault) == 0 .and. first > 1) then
               if (now(2) <= listing%value(2, k - 1)) fault = &
                  "the temperatures of a density must ascend; "//number(now(2))//" follows "// &
                  number(listing%value(2, k - 1))
            end if
            if (len(fault) == 0 .and. abs(now(2) - listing%value(2, first)) > 0.0_wp) fault = &
               "temperature "//number(now(2))//" must be "//number(listing%value(2, first))// &
               ", as all densities have the temperatures of the first one"
         end associate
         if (len(fault) == 0) cycle
         fault = "line "//number(listing%line(k))//": "//fault
         return
      end do
      if (mod(listing%count, n) /= 0) fault = "line "//number(listing%line(listing%count))// &
         ": density "//number(listing%value(1, listing%count))//" must have the "//number(n)// &
         " temperatures of the first one, but the file ends"
   end subroutine check_order

   !> Check that the energy grows with the temperature, and the pressure with the density at
   !! constant entropy.
   subroutine check_slopes(listing, table, fault)
      type(listing_t), intent(in) :: listing
      type(state_table_t), intent(inout) :: table    !! Gets its sound speeds
      character(len=:), allocatable, intent(out) :: fault !! Empty if there is none
      integer :: k

      fault = ""
      do k = 2, listing%count
         if (mod(k - 1, size(table%temperature)) == 0) cycle
         if (table%energy(k) > table%energy(k - 1)) cycle
         fault = "line "//number(listing%line(k))//": the energy must increase with the "// &
            "temperature; "//number(table%energy(k))//" follows "//number(table%energy(k - 1))
         return
      end do
      call table%complete()
      do k = 1, listing%count
         if (table%square(k) > 0.0_wp) cycle
         ! The sound speed of a gas without heat is 0.
         if (table%square(k) >= 0.0_wp .and. .not. listing%value(2, k) > 0.0_wp) cycle
         fault = "line "//number(listing%line(k))//": the pressure must increase with the "// &
            "density at constant entropy, but the square of the sound speed is "// &
            brief(table%square(k))//" m2/s2; omit states in which the material is unstable"
         return
      end do
   end subroutine check_slopes
end module material_table_text
