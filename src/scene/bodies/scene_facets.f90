! SPDX-License-Identifier: BSD-3-Clause
!> Regions whose surface is read from a file of facets, and warnings about that surface.
module scene_facets
   use base_agreement, only: agree
   use base_communicator, only: communicator_t
   use base_error, only: error_t
   use base_file, only: read_file
   use base_kinds, only: wp
   use base_text, only: number
   use deck_reader, only: deck_t, group_t
   use deck_units, only: unit_of, unit_t
   use io_stl, only: read_stl
   use particle_facets, only: facets_t, set_facets
   use particle_shape, only: shape_holder_t
   use scene_file_paths, only: path_in_deck
   implicit none
   private

   public :: read_facets

contains

   !> Read the facets of a region. Lengths in the file are in the unit of the deck. Collective.
   subroutine read_facets(communicator, deck, group, holder)
      type(communicator_t), intent(in) :: communicator !! The first rank reads
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(group_t), intent(in) :: group
      type(shape_holder_t), intent(inout) :: holder  !! Receives the shape
      character(len=:), allocatable :: path, text
      type(error_t), allocatable :: error
      real(wp), allocatable :: corner(:, :, :)
      type(facets_t) :: facets
      type(unit_t) :: length
      logical :: known
      integer :: open_edges, turned_edges, crowded_edges, flat

      path = path_in_deck(group, "file")
      if (communicator%rank == 0) call read_file(path, text, error)
      call agree(communicator, error)
      if (.not. allocated(error)) then
         call communicator%broadcast(text)
         call read_stl(text, path, corner, error)
      end if
      if (allocated(error)) then
         call deck%add_error(group, error%message, "file")
         return
      end if
      call unit_of("m", length, known)
      corner(:, :, :) = corner*10.0_wp**nint(length%exponent(deck%system))
      call set_facets(facets, corner)
      ! the surface must close
      call facets%faults(open_edges, turned_edges, crowded_edges, flat)
      if (open_edges > 0) call deck%warn(group, "the surface has "//number(open_edges)// &
         " open edges, so points above a hole count as outside; close the surface [D411]", "file")
      if (turned_edges > 0) call deck%warn(group, number(turned_edges)//" edges have facets "// &
         "with opposite orientations; reverse those that face inwards [D446]", "file")
      if (crowded_edges > 0) call deck%warn(group, number(crowded_edges)//" edges have more "// &
         "than two facets: duplicate facets, or solids that touch [D446]", "file")
      if (flat > 0) call deck%warn(group, number(flat)//" facets have no area and are left "// &
         "out [D446]", "file")
      if (open_edges == 0 .and. facets%volume() < 0.0_wp) call deck%warn(group, &
         "all facets face inwards; the enclosed volume is used [D446]", "file")
      call holder%set(facets)
   end subroutine read_facets
end module scene_facets
