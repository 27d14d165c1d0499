! SPDX-License-Identifier: BSD-3-Clause
!> Index of the groups of a deck by kind, name and line. With it the time to read a deck grows only
!! a little faster than the number of groups.
module deck_index
   use base_hash, only: hash_text
   use base_kinds, only: int64
   use base_sort, only: sort_order
   use deck_group_values, only: group_t
   use deck_schema, only: schema_t
   implicit none
   private

   public :: deck_index_t

   !> Index of a list of groups. A kind is the index of its rule in the schema.
   type :: deck_index_t
      integer, allocatable :: last_line(:)               !! (group) Last line before the next group
      integer, allocatable, private :: before(:) !! (kind) Number of groups of all kinds before it
      integer, allocatable, private :: member(:)         !! Groups, sorted by kind
      integer, allocatable, private :: nameless(:)       !! (kind) Groups without a name
      integer(int64), allocatable, private :: key(:)     !! Hashes of kinds and names, sorted
      integer, allocatable, private :: owner(:)          !! Groups of these hashes
   contains
      procedure :: build => index_build                  !! Sort the groups
      procedure :: count => index_count                  !! Number of groups of a kind
      procedure :: at => index_at                        !! Index of a group of a kind
      procedure :: named => index_named                  !! Index of the first group of a name
      procedure :: all_named => index_all_named          !! Has each group of a kind a name?
   end type deck_index_t

contains

   !> Sort the groups. Their number, order, kinds, names and lines must not change afterwards.
   subroutine index_build(self, schema, groups)
      class(deck_index_t), intent(out) :: self
      type(schema_t), intent(in) :: schema               !! Declares all kinds
      type(group_t), intent(in) :: groups(:)             !! All groups
      integer(int64) :: key(size(groups))
      integer :: kind(size(groups)), i, order(size(groups)), last, next

      do i = 1, size(groups)
         kind(i) = schema%find(groups(i)%group)
         key(i) = key_of(groups(i)%group, groups(i)%title)
      end do
      allocate (self%before(size(schema%groups) + 1), self%nameless(size(schema%groups)), source=0)
      do i = 1, size(groups)
         self%before(kind(i) + 1) = self%before(kind(i) + 1) + 1
         if (groups(i)%title == "") self%nameless(kind(i)) = self%nameless(kind(i)) + 1
      end do
      do i = 2, size(self%before)
         self%before(i) = self%before(i) + self%before(i - 1)
      end do
      self%member = sort_order(int(kind, int64))
      self%owner = sort_order(key)
      self%key = key(self%owner)
      ! the last line of each group is that before the next group of the same file
      do i = 1, size(groups)
         key(i) = hash_text(groups(i)%path)
      end do
      order = sort_order(int(groups%first_line, int64))
      order = order(sort_order(key(order)))
      allocate (self%last_line(size(groups)))
      do i = size(groups), 1, -1
         associate (group => groups(order(i)))
            last = huge(last)
            if (i < size(groups)) then
               next = order(i + 1)
               if (groups(next)%path == group%path) then
                  ! several groups may be on one line
                  last = self%last_line(next)
                  if (groups(next)%first_line > group%first_line) last = groups(next)%first_line - 1
               end if
            end if
            self%last_line(order(i)) = last
         end associate
      end do
   end subroutine index_build

   !> Hash of a kind and a name.
   pure integer(int64) function key_of(group, title) result(key)
      character(len=*), intent(in) :: group              !! Kind, without &
      character(len=*), intent(in) :: title              !! Name

      key = hash_text(trim(group)//" "//trim(title))
   end function key_of

   !> Number of groups of a kind.
   pure integer function index_count(self, kind) result(count)
      class(deck_index_t), intent(in) :: self
      integer, intent(in) :: kind                        !! The kind, 0 = none

      count = 0
      if (kind > 0) count = self%before(kind + 1) - self%before(kind)
   end function index_count

   !> Index of a group in the list, 0 if there is none.
   pure integer function index_at(self, kind, place) result(which)
      class(deck_index_t), intent(in) :: self
      integer, intent(in) :: kind                        !! The kind, 0 = none
      integer, intent(in) :: place                       !! Index among the groups of its kind

      which = 0
      if (place < 1 .or. place > self%count(kind)) return
      which = self%member(self%before(kind) + place)
   end function index_at

   !> Index of the first group of a kind that has a name, 0 if there is none.
   pure integer function index_named(self, groups, group, title) result(which)
      class(deck_index_t), intent(in) :: self
      type(group_t), intent(in) :: groups(:)             !! The groups that it was built from
      character(len=*), intent(in) :: group              !! Kind, without &
      character(len=*), intent(in) :: title              !! Name
      integer(int64) :: key
      integer :: low, high, middle

      key = key_of(group, title)
      low = 1
      high = size(self%key) + 1
      do while (low < high)
         middle = (low + high)/2
         if (self%key(middle) < key) then
            low = middle + 1
         else
            high = middle
         end if
      end do
      do low = low, size(self%key)
         if (self%key(low) /= key) exit
         which = self%owner(low)
         if (groups(which)%group == group .and. groups(which)%title == title) return
      end do
      which = 0
   end function index_named

   !> Has each group of a kind a name?
   pure logical function index_all_named(self, kind) result(named)
      class(deck_index_t), intent(in) :: self
      integer, intent(in) :: kind                        !! Index of the kind

      named = self%nameless(kind) == 0
   end function index_all_named
end module deck_index
