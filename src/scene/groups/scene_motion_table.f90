! SPDX-License-Identifier: BSD-3-Clause
!> Tables of time that a deck names: velocities of walls, accelerations.
module scene_motion_table
   use base_agreement, only: agree
   use base_communicator, only: communicator_t
   use base_error, only: error_t
   use base_file, only: folder_of, join_path, read_file
   use base_kinds, only: wp
   use deck_reader, only: deck_t, group_t
   use deck_units, only: unit_of, unit_t
   use io_motion, only: meaning_t, read_motion
   use mesh_motion, only: motion_t
   implicit none
   private

   public :: read_motion_table

contains

   !> Read the table of a key into a motion; its file is relative to the deck. Collective.
   subroutine read_motion_table(deck, communicator, group, key, meaning, unit_text, motion)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(communicator_t), intent(in) :: communicator !! The first rank reads
      type(group_t), intent(in) :: group
      character(len=*), intent(in) :: key            !! Its key that names the file
      type(meaning_t), intent(in) :: meaning         !! Description of the table
      character(len=*), intent(in) :: unit_text      !! Unit of the components in SI
      type(motion_t), intent(inout) :: motion        !! Gets times and values in SI
      character(len=:), allocatable :: name, path, text
      type(error_t), allocatable :: error
      type(unit_t) :: unit
      logical :: known

      call group%get(key, name)
      path = name
      if (index(name, "/") /= 1) path = join_path(folder_of(group%file(key)), name)
      if (communicator%rank == 0) call read_file(path, text, error)
      call agree(communicator, error)
      if (.not. allocated(error)) then
         call communicator%broadcast(text)
         call read_motion(text, path, meaning, motion%time, motion%speed, error)
      end if
      if (allocated(error)) then
         call deck%add_error(group, key//": "//error%message, key)
         return
      end if
      call unit_of("s", unit, known)
      motion%time = motion%time*10.0_wp**nint(unit%exponent(deck%system))
      call unit_of(unit_text, unit, known)
      motion%speed = motion%speed*10.0_wp**nint(unit%exponent(deck%system))
   end subroutine read_motion_table
end module scene_motion_table
