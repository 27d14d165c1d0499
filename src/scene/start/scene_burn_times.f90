! SPDX-License-Identifier: BSD-3-Clause
!> Times at which the particles of explosives begin to burn, from the cells that hold explosive at
!! the start. All ranks use the cells of all ranks, so the times do not depend on ranks.
module scene_burn_times
   use base_kinds, only: int64, wp
   use material_burn, only: never_burns
   use material_burn_paths, only: detonation_paths_t
   use material_burn_sight, only: cell_empty, cell_explosive, cell_other, sight_map_t
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: light_explosives

contains

   !> Set the burn times of the particles of explosives, and their stress before burning.
   !! Collective.
   subroutine light_explosives(simulation)
      type(simulation_t), intent(inout) :: simulation !! The run with particles
      type(sight_map_t) :: map
      integer :: index, tile
      logical :: burns

      burns = .false.
      do index = 1, size(simulation%materials)
         burns = burns .or. allocated(simulation%materials(index)%burn)
      end do
      if (.not. burns) return
      call draw_map(simulation, map)
      do index = 1, size(simulation%materials)
         if (.not. allocated(simulation%materials(index)%burn)) cycle
         call find_times(simulation, index, map)
         associate (store => simulation%stores(index))
            do tile = 1, size(store%count)
               call simulation%materials(index)%find_rest_stress(store%state, &
                  store%first(tile), store%first(tile) + store%count(tile) - 1)
            end do
         end associate
      end do
   end subroutine light_explosives

   !> The cells of the box around all explosives, and which of them are open.
   subroutine draw_map(simulation, map)
      type(simulation_t), intent(inout) :: simulation
      type(sight_map_t), intent(out) :: map
      integer(int64), allocatable :: content(:)
      real(wp) :: bounds(6)
      integer :: index, tile, k, n, p, place(3)

      bounds = -huge(1.0_wp)
      do index = 1, size(simulation%stores)
         if (.not. allocated(simulation%materials(index)%burn)) cycle
         do tile = 1, size(simulation%stores(index)%count)
            ! the box around all particles of explosives
            associate (store => simulation%stores(index))
               do p = store%first(tile), store%first(tile) + store%count(tile) - 1
                  bounds = max(bounds, [-store%position(p, :), store%position(p, :)])
               end do
            end associate
         end do
      end do
      call simulation%machine%communicator%maxima(bounds)
      associate (grid => simulation%space%grid)
         map%active = grid%active
         map%spacing = grid%spacing
         map%lower = grid%lower
         do k = 1, 3
            if (.not. grid%active(k)) cycle
            n = floor((-bounds(k) - grid%lower(k))/grid%spacing)
            map%lower(k) = grid%lower(k) + real(n, wp)*grid%spacing
            map%cells(k) = floor((bounds(3 + k) - grid%lower(k))/grid%spacing) - n + 1
         end do
      end associate
      allocate (content(0:product(map%cells) - 1))
      content = cell_empty
      do index = 1, size(simulation%stores)
         do tile = 1, size(simulation%stores(index)%count)
            ! explosive takes precedence over inert material
            associate (store => simulation%stores(index))
               do p = store%first(tile), store%first(tile) + store%count(tile) - 1
                  place = map%cell_of([store%position(p, 1), store%position(p, 2), &
                     store%position(p, 3)])
                  if (any(place < 0 .or. place >= map%cells)) cycle
                  n = place(1) + map%cells(1)*(place(2) + map%cells(2)*place(3))
                  content(n) = min(content(n), merge(cell_explosive, cell_other, &
                     allocated(simulation%materials(index)%burn)))
               end do
            end associate
         end do
      end do
      call simulation%machine%communicator%least(content)
      call map%start(content)
   end subroutine draw_map

   !> Burn times of the particles of one store: along straight lines of sight to the first
   !! detonator, and around obstacles elsewhere.
   subroutine find_times(simulation, index, map)
      type(simulation_t), intent(inout) :: simulation
      integer, intent(in) :: index                   !! Index of the store
      type(sight_map_t), intent(in) :: map
      type(detonation_paths_t) :: paths
      integer, allocatable :: behind(:)
      integer :: tile, p, n, found
      logical :: hidden
      real(wp) :: time

      associate (store => simulation%stores(index), &
         detonators => simulation%materials(index)%burn%detonators)
         allocate (behind(sum(store%count)))
         found = 0
         do tile = 1, size(store%count)
            do p = store%first(tile), store%first(tile) + store%count(tile) - 1
               call paths%straight(map, detonators, place_of(p), time, hidden)
               store%state%burn_time(p) = time
               if (.not. hidden) cycle
               found = found + 1
               behind(found) = p
            end do
         end do
         if (.not. simulation%machine%communicator%any(found > 0)) return
         call paths%find(map, detonators)
         do n = 1, found
            p = behind(n)
            store%state%burn_time(p) = min(store%state%burn_time(p), &
               paths%arrival(map, place_of(p)), never_burns)
         end do
      end associate

   contains

      !> Position of a particle, 0 in inactive directions [m].
      pure function place_of(p) result(place)
         integer, intent(in) :: p                    !! Index in the store
         real(wp) :: place(3)

         place = merge(simulation%stores(index)%position(p, :), 0.0_wp, map%active)
      end function place_of
   end subroutine find_times
end module scene_burn_times
