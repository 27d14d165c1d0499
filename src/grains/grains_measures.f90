! SPDX-License-Identifier: BSD-3-Clause
!> Measures of a cell of grains: energies, contacts, fabric, and the row of its history.
!!
!! Equations of doc/theory/grains.md.
module grains_measures
   use base_communicator, only: communicator_t
   use base_exact_sum, only: exact_sum_t
   use base_kinds, only: int64, wp
   use grains_cell, only: cell_t, losses
   use grains_histories, only: is_own_pair
   use grains_pairs, only: dashpot_loss, factor, overlap, pairs_t, push_branch, slips, tangent
   use grains_state, only: grains_t
   implicit none
   private

   public :: contact_counts_t, count_contacts, energy_t, find_contacts, find_energy, &
      history_columns, &
      history_values

   integer, parameter :: column_length = 32          !! Longest heading of a column

   !> Energies of the cell, (G.5) [J]. With the kinetic energy of half steps the sum of all but
   !! `work` is `work` plus a constant, to rounding.
   type :: energy_t
      real(wp) :: kinetic = 0.0_wp                   !! Relative to the cell, with spins
      real(wp) :: springs = 0.0_wp                   !! Stored along the lines of centres
      real(wp) :: shear = 0.0_wp                     !! Stored tangentially
      real(wp) :: lost(losses) = 0.0_wp              !! By dashpots, friction, time step
      real(wp) :: work = 0.0_wp                      !! Work of the stress on the cell
      real(wp) :: total = 0.0_wp !! Sum of all energies except work, with half steps
   end type energy_t

   !> Counts and means of contacts. A rattler has fewer contacts than a grain needs for equilibrium:
   !! two for discs, three for spheres.
   type :: contact_counts_t
      integer(int64) :: contacts = 0
      integer(int64) :: sliding = 0                  !! Contacts that slipped in the last step
      integer(int64) :: rattlers = 0                 !! Grains with too few contacts
      integer(int64) :: held = 0                     !! Contacts of non-rattlers, each end
      real(wp) :: fabric(6) = 0.0_wp                 !! Mean n n, xx yy zz xy xz yz [1]
      real(wp) :: deepest = 0.0_wp                   !! Greatest overlap over mean diameter [1]
   end type contact_counts_t

contains

   !> Find the energies. Collective.
   subroutine find_energy(cell, energy)
      type(cell_t), intent(in) :: cell
      type(energy_t), intent(out) :: energy
      type(exact_sum_t) :: terms(4 + losses)
      real(wp) :: values(4 + losses), q, half
      integer :: row, pair, loss

      do loss = 1, losses
         terms(4 + loss) = cell%lost(loss)
      end do
      associate (grains => cell%grains, pairs => cell%pairs)
         half = cell%dt**2/8.0_wp
         do row = grains%first, grains%last
            call terms(1)%add(0.5_wp*(grains%mass(row)*sum(grains%velocity(:, row)**2) &
               + grains%inertia(row)*sum(grains%spin(:, row)**2)))
            call terms(2)%add(half*(sum(grains%force(:, row)**2)/grains%mass(row) &
               + sum(grains%torque(:, row)**2)/grains%inertia(row)))
         end do
         do pair = 1, pairs%count
            if (.not. is_own_pair(grains, pairs, pair)) cycle
            do loss = 1, losses
               call terms(4 + loss)%add(pairs%history(dashpot_loss + loss - 1, pair))
            end do
            if (.not. pairs%touches(pair)) cycle
            q = pairs%history(factor, pair)
            call terms(3)%add(cell%law%stored*cell%law%normal*q*pairs%history(overlap, pair)**2)
            call terms(4)%add(0.5_wp*sum(pairs%history(tangent:tangent + 2, pair)**2) &
               /(cell%law%tangential*q))
         end do
      end associate
      call values_of(cell%communicator, terms, values)
      energy%kinetic = values(1)
      energy%springs = values(3)
      energy%shear = values(4)
      energy%lost = values(5:) - cell%lost_before
      energy%work = cell%work
      energy%total = values(1) - values(2) + values(3) + values(4) + sum(energy%lost)
   end subroutine find_energy

   !> Sums over the ranks, rounded. Collective.
   subroutine values_of(communicator, terms, values)
      type(communicator_t), intent(in) :: communicator
      type(exact_sum_t), intent(inout) :: terms(:)
      real(wp), intent(out) :: values(:)
      integer :: n

      do n = 1, size(terms)
         if (communicator%size > 1) call terms(n)%over_ranks(communicator)
         values(n) = terms(n)%value()
      end do
   end subroutine values_of

   !> Contacts of each own grain.
   pure subroutine count_contacts(grains, pairs, contacts)
      type(grains_t), intent(in) :: grains
      type(pairs_t), intent(in) :: pairs
      integer, allocatable, intent(out) :: contacts(:) !! (own row)
      integer :: row, n

      allocate (contacts(grains%last - grains%first + 1))
      contacts = 0
      do row = 1, size(contacts)
         do n = pairs%start(row), pairs%start(row + 1) - 1
            if (pairs%touches(abs(pairs%incident(n)))) contacts(row) = contacts(row) + 1
         end do
      end do
   end subroutine count_contacts

   !> Count the contacts and find their fabric. Collective.
   subroutine find_contacts(cell, found)
      type(cell_t), intent(in) :: cell
      type(contact_counts_t), intent(out) :: found
      type(exact_sum_t) :: terms(6)
      integer, allocatable :: contacts(:)
      integer(int64) :: counts(4)
      real(wp) :: n(3)
      integer :: pair

      call count_contacts(cell%grains, cell%pairs, contacts)
      counts = 0
      associate (pairs => cell%pairs)
         do pair = 1, pairs%count
            if (.not. (pairs%touches(pair) .and. is_own_pair(cell%grains, pairs, pair))) cycle
            counts(1) = counts(1) + 1
            if (pairs%history(slips, pair) > 0.5_wp) counts(2) = counts(2) + 1
            found%deepest = max(found%deepest, pairs%history(overlap, pair))
            n = pairs%push(push_branch:push_branch + 2, pair)
            if (cell%box%dimension == 2) n(3) = 0.0_wp
            n = n/norm2(n)
            call terms(1)%add(n(1)*n(1))
            call terms(2)%add(n(2)*n(2))
            call terms(3)%add(n(3)*n(3))
            call terms(4)%add(n(1)*n(2))
            call terms(5)%add(n(1)*n(3))
            call terms(6)%add(n(2)*n(3))
         end do
      end associate
      counts(3) = count(contacts < cell%box%dimension)
      counts(4) = sum(contacts, mask=contacts >= cell%box%dimension)
      call cell%communicator%total(counts)
      call values_of(cell%communicator, terms, found%fabric)
      found%fabric = found%fabric/real(max(counts(1), 1_int64), wp)
      found%contacts = counts(1)
      found%sliding = counts(2)
      found%rattlers = counts(3)
      found%held = counts(4)
      found%deepest = cell%communicator%maximum(found%deepest)/cell%diameter
   end subroutine find_contacts

   !> Headings of the columns of the history.
   pure function history_columns() result(columns)
      character(len=column_length), allocatable :: columns(:)

      columns = [character(len=column_length) :: "step", "stage", "time [s]", "strain [1]", &
         "rate_xx [1/s]", "rate_yy [1/s]", "rate_zz [1/s]", "rate_xy [1/s]", &
         "volume_fraction [1]", "height [m]", "tilt [1]", &
         "stress_xx [Pa]", "stress_yy [Pa]", "stress_zz [Pa]", "stress_xy [Pa]", &
         "stress_yx [Pa]", "stress_xz [Pa]", "stress_yz [Pa]", "pressure [Pa]", &
         "kinetic_pressure [Pa]", "friction [1]", "inertial_number [1]", &
         "coordination [1]", "coordination_held [1]", "rattlers [1]", "sliding [1]", &
         "fabric_xx [1]", "fabric_yy [1]", "fabric_zz [1]", "fabric_xy [1]", &
         "fabric_xz [1]", "fabric_yz [1]", "overlap_max [1]", &
         "kinetic [J]", "springs [J]", "shear [J]", "dashpots [J]", "slip [J]", &
         "step_error [J]", "work [J]", "energy_error [J]"]
   end function history_columns

   !> A row of the history; stresses are means over the time since the last row. Collective.
   subroutine history_values(cell, stage, energy_at_start, values)
      type(cell_t), intent(in) :: cell
      integer, intent(in) :: stage                   !! Number
      real(wp), intent(in) :: energy_at_start        !! Total at the start [J]
      real(wp), allocatable, intent(out) :: values(:) !! (column)
      type(energy_t) :: energy
      type(contact_counts_t) :: found
      real(wp) :: stress(3, 3), agitation(3, 3), pressure, kinetic, friction, g(3, 3), count
      integer :: axis, d

      d = cell%box%dimension
      call find_energy(cell, energy)
      call find_contacts(cell, found)
      call mean_stress(cell, stress, agitation)
      pressure = 0.0_wp
      kinetic = 0.0_wp
      do axis = 1, d
         pressure = pressure - stress(axis, axis)/real(d, wp)
         kinetic = kinetic - agitation(axis, axis)/real(d, wp)
      end do
      friction = 0.0_wp
      if (abs(stress(2, 2)) > 0.0_wp) friction = -stress(1, 2)/stress(2, 2)
      g = cell%box%gradient
      count = real(cell%grains%count, wp)
      values = [real(cell%step, wp), real(stage, wp), cell%time, cell%box%strain, &
         g(1, 1), g(2, 2), g(3, 3), g(1, 2), cell%volume_fraction(), cell%box%edges(2, 2), &
         cell%box%edges(1, 2)/cell%box%edges(1, 1), &
         stress(1, 1), stress(2, 2), stress(3, 3), stress(1, 2), stress(2, 1), stress(1, 3), &
         stress(2, 3), pressure, kinetic, friction, cell%inertial_number(-stress(2, 2)), &
         2.0_wp*real(found%contacts, wp)/count, &
         real(found%held, wp)/max(count - real(found%rattlers, wp), 1.0_wp), &
         real(found%rattlers, wp)/count, &
         real(found%sliding, wp)/real(max(found%contacts, 1_int64), wp), found%fabric, &
         found%deepest, energy%kinetic, energy%springs, energy%shear, energy%lost, energy%work, &
         energy%total - energy_at_start - energy%work]
   end subroutine history_values

   !> Mean stress since the last row, or that now if no step was made, and its kinetic part [Pa].
   pure subroutine mean_stress(cell, stress, agitation)
      type(cell_t), intent(in) :: cell
      real(wp), intent(out) :: stress(3, 3)
      real(wp), intent(out) :: agitation(3, 3)       !! Stress from m u u only
      real(wp), parameter :: none(9) = 0.0_wp

      associate (mean => cell%mean)
         if (mean%time > 0.0_wp) then
            stress = cell%stress(mean%contact/mean%time, mean%kinetic/mean%time)
            agitation = cell%stress(none, mean%kinetic/mean%time)
         else
            stress = cell%stress(cell%contact, cell%kinetic)
            agitation = cell%stress(none, cell%kinetic)
         end if
      end associate
   end subroutine mean_stress
end module grains_measures
