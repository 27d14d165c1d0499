! SPDX-License-Identifier: BSD-3-Clause
!> A preset is a set of values for a group that a deck requests by name. It is written in SI as
!!
!!    preset NAME: title
!!    key = value | source | condition
!!
!! The condition is empty, `unless KEY KEY` for a value that other keys replace, or `with GROUP.KEY`
!! for a value that needs a switch.
module deck_preset
   use base_text, only: split, text_t
   implicit none
   private

   public :: preset_t, read_presets

   !> One value.
   type, public :: preset_entry_t
      character(len=:), allocatable :: key               !! Name of the key
      character(len=:), allocatable :: value             !! In SI, values with blanks between them
      character(len=:), allocatable :: source            !! Source
      type(text_t), allocatable :: unless(:)             !! Keys that replace it
      character(len=:), allocatable :: switch            !! GROUP.KEY it needs, or empty
   end type preset_entry_t

   !> One preset.
   type :: preset_t
      character(len=:), allocatable :: group             !! Group of the key
      character(len=:), allocatable :: name              !! Name
      character(len=:), allocatable :: title             !! Title
      type(preset_entry_t), allocatable :: entries(:)    !! In the order of applying
   end type preset_t

contains

   !> Read presets. The lines are a part of the program and are not checked here; a unit test reads
   !! all of them.
   subroutine read_presets(group, lines, presets)
      character(len=*), intent(in) :: group              !! Group they belong to
      character(len=*), intent(in) :: lines(:)           !! Text of the presets
      type(preset_t), allocatable, intent(out) :: presets(:)
      character(len=*), parameter :: head = "preset "
      integer :: i, n, m, equals, first, second, filled, k
      type(preset_entry_t), allocatable :: longer(:)
      type(text_t), allocatable :: words(:)

      n = 0
      do i = 1, size(lines)
         if (index(lines(i), head) == 1) n = n + 1
      end do
      allocate (presets(n))
      n = 0
      do i = 1, size(lines)
         if (index(lines(i), head) == 1) then
            n = n + 1
            m = index(lines(i), ":")
            presets(n)%group = group
            presets(n)%name = lines(i)(len(head) + 1:m - 1)
            presets(n)%title = trim(adjustl(lines(i)(m + 1:)))
            allocate (presets(n)%entries(0))
         else
            ! one value
            filled = size(presets(n)%entries)
            allocate (longer(filled + 1))
            do k = 1, filled
               longer(k) = presets(n)%entries(k)
            end do
            associate (entry => longer(filled + 1))
               equals = index(lines(i), "=")
               first = index(lines(i), "|")
               second = index(lines(i)(first + 1:), "|") + first
               if (second == first) second = len(lines(i)) + 1
               entry%key = trim(adjustl(lines(i)(:equals - 1)))
               entry%value = trim(adjustl(lines(i)(equals + 1:first - 1)))
               entry%source = trim(adjustl(lines(i)(first + 1:second - 1)))
               entry%switch = ""
               allocate (entry%unless(0))
               call split(lines(i)(min(second + 1, len(lines(i)) + 1):), words)
               if (size(words) > 1) then
                  if (words(1)%text == "with") entry%switch = words(2)%text
                  if (words(1)%text == "unless") entry%unless = words(2:)
               end if
            end associate
            call move_alloc(longer, presets(n)%entries)
         end if
      end do
   end subroutine read_presets
end module deck_preset
