! SPDX-License-Identifier: BSD-3-Clause
!> Rows and lattices of equal bodies, `repeat = 4, 3, 1  repeat_step = 2, 2, 0`.
!!
!! Each copy becomes a body with a region of its own, displaced by `translate`. No later code
!! depends on the repetition, and the echo of the deck lists all copies.
module deck_repeat
   use base_kinds, only: wp
   use base_text, only: number
   use deck_check, only: label_of
   use deck_group_values, only: group_t
   use deck_problems, only: problems_t
   use deck_schema, only: schema_t
   use deck_value, only: read_default
   implicit none
   private

   public :: repeat_groups

   integer, parameter :: most_copies = 10000             !! More are an error

contains

   !> Add the copies of repeated bodies and of their regions to the list of groups.
   subroutine repeat_groups(schema, problems, groups)
      type(schema_t), intent(in) :: schema               !! Keys that are allowed
      type(problems_t), intent(inout) :: problems        !! Collects errors
      type(group_t), allocatable, intent(inout) :: groups(:) !! All groups, defaults filled
      type(group_t), allocatable :: longer(:)
      integer, allocatable :: copies(:)
      integer :: filled, i, region, bodies, regions

      if (.not. any([(groups(i)%group == "body" .and. groups(i)%given("repeat"), &
         i=1, size(groups))])) return
      allocate (copies(size(groups)), source=1)
      do i = 1, size(groups)
         if (groups(i)%group /= "body") cycle
         if (.not. groups(i)%given("repeat")) cycle
         call count_copies(groups(i), problems, copies(i))
         if (region_of(groups, groups(i)) == 0) copies(i) = 1
      end do
      ! a copy needs a body and a region
      allocate (longer(size(groups) + 2*sum(copies - 1)))
      filled = 0
      do i = 1, size(groups)
         filled = filled + 1
         longer(filled) = groups(i)
         if (copies(i) == 1) cycle
         region = region_of(groups, groups(i))
         call problems%repeat(groups(i)%title, groups(region)%title, copies(i))
         call add_copies(schema, groups(i), groups(region), longer, filled)
      end do
      call move_alloc(longer, groups)
      ! bodies and regions are numbered in the order of the list
      bodies = 0
      regions = 0
      do i = 1, size(groups)
         if (groups(i)%group == "body") then
            bodies = bodies + 1
            groups(i)%place = bodies
         else if (groups(i)%group == "region") then
            regions = regions + 1
            groups(i)%place = regions
         end if
      end do
   end subroutine repeat_groups

   !> Number of copies of a body, 1 after an error.
   subroutine count_copies(body, problems, copies)
      type(group_t), intent(in) :: body
      type(problems_t), intent(inout) :: problems        !! Collects errors
      integer, intent(out) :: copies                     !! Number of bodies
      character(len=1), parameter :: axes(3) = ["x", "y", "z"]
      real(wp) :: step(3)
      integer :: k, times(3)

      copies = 1
      if (.not. body%valid([character(len=11) :: "repeat", "repeat_step"])) return
      call body%get("repeat", times)
      call body%get("repeat_step", step)
      do k = 1, 3
         if (times(k) == 1 .or. abs(step(k)) > 0.0_wp) cycle
         call problems%error(body%file("repeat"), body%line("repeat"), label_of(body)// &
            ": repeat along "//axes(k)//" needs a repeat_step along "//axes(k)// &
            " that is not 0, the distance from one copy to the next [D205]")
         return
      end do
      if (product(real(times, wp)) > real(most_copies, wp)) then
         call problems%error(body%file("repeat"), body%line("repeat"), label_of(body)// &
            ": repeat makes more than "//number(most_copies)//" bodies; reduce it [D205]")
         return
      end if
      copies = product(times)
   end subroutine count_copies

   !> Index of the region of a body, 0 if there is none.
   pure integer function region_of(groups, body) result(which)
      type(group_t), intent(in) :: groups(:)             !! All groups
      type(group_t), intent(in) :: body
      character(len=:), allocatable :: name

      call body%get("region", name)
      do which = size(groups), 1, -1
         if (groups(which)%group == "region" .and. groups(which)%title == name) return
      end do
   end function region_of

   !> Replace a body by its first copy, and append the others with their regions.
   subroutine add_copies(schema, body, region, groups, filled)
      type(schema_t), intent(in) :: schema               !! Keys that are allowed
      type(group_t), intent(in) :: body
      type(group_t), intent(in) :: region                !! Its region
      type(group_t), intent(inout) :: groups(:)          !! All groups
      integer, intent(inout) :: filled                   !! Number of groups
      character(len=:), allocatable :: name
      real(wp) :: start(3), step(3)
      integer :: k, n(3), times(3), x, y, z, place

      call body%get("repeat", times)
      call body%get("repeat_step", step)
      call region%get("translate", start)
      do z = 1, times(3)
         do y = 1, times(2)
            do x = 1, times(1)
               n = [x, y, z]
               name = body%title
               do k = 1, 3
                  if (times(k) > 1) name = name//"_"//number(n(k))
               end do
               if (all(n == 1)) then
                  call name_copy(schema, name, groups(filled))
                  cycle
               end if
               groups(filled + 1) = region
               call put_text(groups(filled + 1), "name", name)
               groups(filled + 1)%title = name
               ! its displacement
               associate (copy => groups(filled + 1))
                  place = copy%find("translate")
                  copy%values(place)%given = .true.
                  copy%values(place)%numbers = start + real(n - 1, wp)*step
                  copy%values(place)%line = copy%first_line
                  copy%values(place)%file = copy%path
               end associate
               groups(filled + 2) = body
               call name_copy(schema, name, groups(filled + 2))
               call put_text(groups(filled + 2), "region", name)
               filled = filled + 2
            end do
         end do
      end do
   end subroutine add_copies

   !> Name a copy, and remove its repetition.
   subroutine name_copy(schema, name, body)
      type(schema_t), intent(in) :: schema               !! Keys that are allowed
      character(len=*), intent(in) :: name               !! Name
      type(group_t), intent(inout) :: body
      character(len=11), parameter :: keys(2) = ["repeat     ", "repeat_step"]
      character(len=:), allocatable :: problem
      integer :: k, place, rule

      call put_text(body, "name", name)
      body%title = name
      rule = schema%find(body%group)
      do k = 1, size(keys)
         place = body%find(trim(keys(k)))
         call read_default(schema%groups(rule)%keys(place), body%values(place), problem)
      end do
   end subroutine name_copy

   !> Replace the text of a key.
   subroutine put_text(group, key, text)
      type(group_t), intent(inout) :: group
      character(len=*), intent(in) :: key
      character(len=*), intent(in) :: text               !! Its new text
      integer :: place

      place = group%find(key)
      group%values(place)%texts(1)%text = text
   end subroutine put_text
end module deck_repeat
