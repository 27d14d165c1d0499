! SPDX-License-Identifier: BSD-3-Clause
!> Reads a material, with the file of its equation of state if that is a table, and the library of
!! its law if that is in one.
module scene_material
   use base_agreement, only: agree
   use base_communicator, only: communicator_t
   use base_error, only: error_t
   use base_file, only: read_file
   use deck_reader, only: deck_t, group_t
   use material_library, only: library_t, open_library
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
      type(library_t), allocatable :: library
      type(error_t), allocatable :: error

      group = deck%group("material", place)
      call load_library(deck, communicator, group, library)
      if (.not. (group%given("eos_table") .and. group%known("eos_table"))) then
         call material%read(deck, place, library=library)
         return
      end if
      path = path_in_deck(group, "eos_table")
      if (communicator%rank == 0) call read_file(path, text, error)
      call agree(communicator, error)
      if (allocated(error)) then
         call deck%add_error(group, "eos_table: "//error%message, "eos_table")
         call material%read(deck, place, library=library)
         return
      end if
      call communicator%broadcast(text)
      call material%read(deck, place, text, path, library)
   end subroutine read_material

   !> Load the library of the law, if it is in one, on all ranks. Collective.
   subroutine load_library(deck, communicator, group, library)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(communicator_t), intent(in) :: communicator
      type(group_t), intent(in) :: group             !! &material
      type(library_t), allocatable, intent(out) :: library !! Not allocated: there is none
      type(error_t), allocatable :: error

      if (.not. (group%given("library") .and. group%known("library"))) return
      allocate (library)
      call open_library(path_in_deck(group, "library"), library, error)
      call agree(communicator, error)
      if (.not. allocated(error)) return
      call deck%add_error(group, "library: "//error%message, "library")
      deallocate (library)
   end subroutine load_library
end module scene_material
