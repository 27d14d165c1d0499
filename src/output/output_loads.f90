! SPDX-License-Identifier: BSD-3-Clause
!> The resultants of the loads on surfaces, for the log and the summary.
module output_loads
   use base_elementary, only: cross
   use base_exact_sum, only: exact_sum_t
   use base_kinds, only: wp
   use base_log, only: log_t
   use base_text, only: number
   use io_summary, only: json_t
   use mesh_surface_load, only: add_loads, surface_load_t
   use particle_store, only: store_t
   use step_simulation, only: simulation_t, space_t
   implicit none
   private

   public :: report_loads

   character(len=8), parameter :: names(6) = [character(len=8) :: "force_x", "force_y", "force_z", &
      "moment_x", "moment_y", "moment_z"]

contains

   !> Write the resultants of the loads to the log, and at the end to the summary. Collective.
   subroutine report_loads(simulation, log, json)
      type(simulation_t), intent(in) :: simulation
      type(log_t), intent(inout) :: log
      type(json_t), intent(inout), optional :: json  !! Of the summary
      real(wp), allocatable :: resultant(:, :)

      if (.not. allocated(simulation%effects%loads)) return
      resultant = resultants_of(simulation)
      call log%info(loads_text(simulation%effects%loads, resultant))
      if (present(json)) call add_to_summary(simulation%effects%loads, resultant, json)
   end subroutine report_loads

   !> Force and moment about the origin that each load exerts at a factor of 1 in the present state.
   !! Collective.
   function resultants_of(simulation) result(resultant)
      type(simulation_t), intent(in) :: simulation   !! With loads
      real(wp), allocatable :: resultant(:, :)       !! (component, load) [N], then [N m]
      type(surface_load_t) :: load(1)
      type(exact_sum_t) :: sums(6)
      integer :: n, k

      allocate (resultant(6, size(simulation%effects%loads)))
      do n = 1, size(simulation%effects%loads)
         load = simulation%effects%loads(n:n)
         load%factor = 1.0_wp
         do k = 1, 6
            call sums(k)%clear()
         end do
         call add_resultant(simulation, load, sums)
         do k = 1, 6
            call sums(k)%over_ranks(simulation%machine%communicator)
            resultant(k, n) = sums(k)%value()
         end do
      end do
   end function resultants_of

   !> Add force and moment of a load on the particles of this rank.
   subroutine add_resultant(simulation, load, sums)
      type(simulation_t), intent(in) :: simulation
      type(surface_load_t), intent(in) :: load(1)
      type(exact_sum_t), intent(inout) :: sums(6)
      integer :: index, tile

      do index = 1, size(simulation%stores)
         do tile = 1, size(simulation%stores(index)%count)
            call add_tile(simulation%space, load, simulation%stores(index), tile, sums)
         end do
      end do
   end subroutine add_resultant

   !> Those of a tile.
   subroutine add_tile(space, load, store, tile, sums)
      type(space_t), intent(in) :: space
      type(surface_load_t), intent(in) :: load(1)
      type(store_t), intent(in) :: store
      integer, intent(in) :: tile
      type(exact_sum_t), intent(inout) :: sums(6)
      real(wp) :: stress(store%count(tile), 6), density(store%count(tile), 3)
      real(wp) :: force(3), place(3), both(6)
      integer :: p, q, k

      call add_loads(load, space%grid, space%tiles%coordinate(:, tile), store%first(tile), &
         store%count(tile), store%position, store%body, store%origin%marks, stress, density)
      do p = 1, store%count(tile)
         if (all(abs(density(p, :)) <= 0.0_wp)) cycle
         q = store%first(tile) + p - 1
         force = store%state%volume(q)*density(p, :)
         place = store%position(q, :)
         both = [force, cross(place, force)]
         ! the radial forces of a ring cancel
         if (space%grid%axisymmetric) both([1, 2, 4, 5, 6]) = 0.0_wp
         do k = 1, 6
            call sums(k)%add(both(k))
         end do
      end do
   end subroutine add_tile

   !> A line for each load.
   function loads_text(loads, resultant) result(text)
      type(surface_load_t), intent(in) :: loads(:)
      real(wp), intent(in) :: resultant(:, :)        !! (component, load) [N], then [N m]
      character(len=:), allocatable :: text
      character(len=120) :: line
      integer :: n

      text = ""
      do n = 1, size(loads)
         write (line, "(2(a,3es11.3))") " force", resultant(:3, n), " N, moment", resultant(4:, n)
         if (n > 1) text = text//new_line("a")
         text = text//"load      "//name_of(loads(n), n)//":"//trim(line)//" N m at a factor of 1"
      end do
   end function loads_text

   !> Name of a load for messages.
   function name_of(load, place) result(name)
      type(surface_load_t), intent(in) :: load
      integer, intent(in) :: place                   !! Its number in the deck
      character(len=:), allocatable :: name

      name = ""
      if (allocated(load%name)) name = trim(load%name)
      if (len(name) == 0) name = number(place)
   end function name_of

   !> The resultants for scripts.
   subroutine add_to_summary(loads, resultant, json)
      type(surface_load_t), intent(in) :: loads(:)
      real(wp), intent(in) :: resultant(:, :)        !! (component, load) [N], then [N m]
      type(json_t), intent(inout) :: json
      integer :: n, k

      call json%begin("loads")
      do n = 1, size(loads)
         call json%begin("load["//number(n)//"]")
         call json%add("name", name_of(loads(n), n))
         do k = 1, size(names)
            call json%add(trim(names(k)), resultant(k, n))
         end do
         call json%end()
      end do
      call json%end()
   end subroutine add_to_summary
end module output_loads
