! SPDX-License-Identifier: BSD-3-Clause
!> Files that a deck names.
module scene_file_paths
   use base_file, only: folder_of, join_path
   use deck_reader, only: group_t
   implicit none
   private

   public :: path_in_deck

contains

   !> Path of a file that a key names, relative to the file of the deck that holds the key.
   function path_in_deck(group, key) result(path)
      type(group_t), intent(in) :: group
      character(len=*), intent(in) :: key            !! Key that names the file
      character(len=:), allocatable :: path
      character(len=:), allocatable :: name

      call group%get(key, name)
      path = name
      if (index(name, "/") /= 1) path = join_path(folder_of(group%file(key)), name)
   end function path_in_deck
end module scene_file_paths
