! SPDX-License-Identifier: BSD-3-Clause
!> A table from keys to indices, for tiles that exist only where particles are.
module mesh_hash_table
   use base_kinds, only: int64
   implicit none
   private

   public :: key_table_t

   integer(int64), parameter :: empty = -1           !! Key of a slot that holds nothing
   integer(int64), parameter :: least_slots = 16     !! A power of two
   integer(int64), parameter :: half_word = 2_int64**31 - 1
   !> Odd multipliers below 2^30, so that no product or sum exceeds 63 bits.
   integer(int64), parameter :: low_factor = 1013904223, high_factor = 668265263, &
      last_factor = 374761393

   !> Hash table with open addressing: linear probes, at most half full. The order of insertion of
   !! keys does not change a result. Reading from several threads is safe.
   type :: key_table_t
      private
      integer(int64) :: used = 0                     !! Number of keys
      integer(int64) :: mask = -1                    !! Number of slots - 1
      integer(int64), allocatable :: key(:)          !! (0:mask) Key in a slot
      integer, allocatable :: value(:)               !! (0:mask) Value in a slot
   contains
      procedure :: clear => table_clear              !! Empty it and set its capacity
      procedure :: count => table_count              !! Number of keys
      procedure :: find => table_find                !! Value of a key
      procedure :: insert => table_insert            !! Add a key or change its value
   end type key_table_t

contains

   !> Delete all keys and set the capacity.
   pure subroutine table_clear(self, capacity)
      class(key_table_t), intent(inout) :: self
      integer, intent(in) :: capacity                !! Keys to expect; more make the table grow
      integer(int64) :: slots

      slots = least_slots
      do while (slots < 2*int(capacity, int64))
         slots = 2*slots
      end do
      call reserve(self, slots)
   end subroutine table_clear

   !> Number of different keys in the table.
   pure integer function table_count(self) result(keys)
      class(key_table_t), intent(in) :: self

      keys = int(self%used)
   end function table_count

   !> Value of a key, 0 if the table does not have it.
   pure integer function table_find(self, key) result(value)
      class(key_table_t), intent(in) :: self
      integer(int64), intent(in) :: key              !! 0 or more

      value = 0
      if (self%used == 0 .or. key < 0) return
      value = self%value(slot_of(self%key, self%mask, key))
   end function table_find

   !> Add a key, or change its value if the table has it. A negative key is not stored.
   pure subroutine table_insert(self, key, value)
      class(key_table_t), intent(inout) :: self
      integer(int64), intent(in) :: key              !! 0 or more
      integer, intent(in) :: value                   !! Not 0, which means absent
      integer(int64) :: slot

      if (key < 0) return
      if (2*(self%used + 1) > self%mask + 1) call grow(self)
      slot = slot_of(self%key, self%mask, key)
      if (self%key(slot) == empty) self%used = self%used + 1
      self%key(slot) = key
      self%value(slot) = value
   end subroutine table_insert

   !> Empty the table and give it a number of slots.
   pure subroutine reserve(self, slots)
      class(key_table_t), intent(inout) :: self
      integer(int64), intent(in) :: slots            !! A power of two

      if (allocated(self%key)) then
         if (slots /= self%mask + 1) deallocate (self%key, self%value)
      end if
      if (.not. allocated(self%key)) allocate (self%key(0:slots - 1), self%value(0:slots - 1))
      self%used = 0
      self%mask = slots - 1
      self%key = empty
      self%value = 0
   end subroutine reserve

   !> Double the number of slots and keep their content.
   pure subroutine grow(self)
      class(key_table_t), intent(inout) :: self
      integer(int64), allocatable :: key(:)
      integer, allocatable :: value(:)
      integer(int64) :: used, old, slot

      used = self%used
      call move_alloc(self%key, key)
      call move_alloc(self%value, value)
      call reserve(self, max(2*(self%mask + 1), least_slots))
      self%used = used
      if (used == 0) return
      do old = lbound(key, 1, int64), ubound(key, 1, int64)
         if (key(old) == empty) cycle
         slot = slot_of(self%key, self%mask, key(old))
         self%key(slot) = key(old)
         self%value(slot) = value(old)
      end do
   end subroutine grow

   !> The slot of a key, or the empty slot for its insertion.
   pure integer(int64) function slot_of(keys, mask, key) result(slot)
      integer(int64), intent(in) :: mask             !! Number of slots - 1
      integer(int64), intent(in) :: keys(0:mask)     !! Keys of the slots, at least one empty
      integer(int64), intent(in) :: key              !! 0 or more

      slot = iand(scrambled(key), mask)
      do while (keys(slot) /= key .and. keys(slot) /= empty)
         slot = iand(slot + 1, mask)
      end do
   end function slot_of

   !> A number of 62 bits or less whose low bits depend on all bits of the key.
   pure integer(int64) function scrambled(key) result(bits)
      integer(int64), intent(in) :: key              !! 0 or more

      bits = iand(key, half_word)*low_factor + shiftr(key, 31)*high_factor
      bits = iand(ieor(bits, shiftr(bits, 29)), half_word)*last_factor
      bits = ieor(bits, shiftr(bits, 31))
   end function scrambled
end module mesh_hash_table
