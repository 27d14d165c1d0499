! SPDX-License-Identifier: BSD-3-Clause
!> Reads a material, and the file of its equation of state if that is a table.
module scene_material
   use base_agreement, only: agree
   use base_communicator, only: communicator_t
   use base_error, only: error_t
   use base_file, only: read_file
   use deck_reader, only: deck_t, group_t
   use material_type, only: material_t
   use scene_file_paths, only: path_in_deck
   implicit none
   private

   public :: read_material

contains

   !> Read a material from its &material. The first rank alone reads the file. Collective.
   subroutine read_material(deck, communicator, place, material)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(communicator_t), intent(in) :: communicator !! The first rank reads
      integer, intent(in) :: place                   !! Number among the &material of the deck
      type(material_t), intent(inout) :: material
      type(group_t) :: group
      character(len=:), allocatable :: path, text
      type(error_t), allocatable :: error

      group = deck%group("material", place)
      if (.not. (group%given("eos_table") .and. group%known("eos_table"))) then
         call material%read(deck, place)
         return
      end if
      path = path_in_deck(group, "eos_table")
      if (communicator%rank == 0) call read_file(path, text, error)
      call agree(communicator, error)
      if (allocated(error)) then
         call deck%add_error(group, "eos_table: "//error%message, "eos_table")
         call material%read(deck, place)
         return
      end if
      call communicator%broadcast(text)
      call material%read(deck, place, text, path)
   end subroutine read_material
end module scene_material
