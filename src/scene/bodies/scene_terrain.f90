! SPDX-License-Identifier: BSD-3-Clause
!> Regions below a surface of heights, or between this surface and a layer on it, from rasters.
module scene_terrain
   use base_agreement, only: agree
   use base_communicator, only: communicator_t
   use base_error, only: error_t
   use base_file, only: read_file
   use base_kinds, only: wp
   use base_text, only: number
   use deck_reader, only: deck_t, group_t
   use deck_units, only: unit_of, unit_t
   use io_raster, only: read_raster
   use mesh_grid, only: grid_t
   use particle_raster, only: no_data, raster_t, row_of_raster
   use particle_shape, only: shape_holder_t
   use particle_terrain, only: set_terrain, terrain_t
   use scene_dimension, only: axis_names
   use scene_file_paths, only: path_in_deck
   implicit none
   private

   public :: check_terrain, read_terrain

contains

   !> Read the rasters of a region. Lengths in the files are in the unit of the deck. Collective.
   subroutine read_terrain(communicator, deck, grid, group, holder)
      type(communicator_t), intent(in) :: communicator !! The first rank reads
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(grid_t), intent(in) :: grid               !! Gives the active directions
      type(group_t), intent(in) :: group
      type(shape_holder_t), intent(inout) :: holder  !! Receives the shape
      type(raster_t) :: ground, layer
      type(terrain_t) :: terrain
      logical :: sound(2)

      if (grid%dimensions == 1) call deck%add_error(group, "a 1-D scene has no surface; use a "// &
         "box [D378]", "shape")
      if (grid%dimensions == 3 .and. group%given("section")) call deck%add_error(group, &
         "section is the y of the profile of a plane scene; remove it [D378]", "section")
      call read_one(communicator, deck, grid, group, "file", ground, sound(1))
      sound(2) = .true.
      if (group%given("thickness_file")) &
         call read_one(communicator, deck, grid, group, "thickness_file", layer, sound(2))
      if (.not. all(sound) .or. .not. deck%sound("region", group%place)) return
      if (group%given("thickness_file")) then
         call set_terrain(terrain, ground, layer)
      else
         call set_terrain(terrain, ground)
      end if
      call holder%set(terrain)
   end subroutine read_terrain

   !> Read a raster, in a plane scene a profile.
   subroutine read_one(communicator, deck, grid, group, key, raster, sound)
      type(communicator_t), intent(in) :: communicator !! The first rank reads
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(grid_t), intent(in) :: grid               !! Gives the active directions
      type(group_t), intent(in) :: group
      character(len=*), intent(in) :: key            !! Names the file
      type(raster_t), intent(out) :: raster          !! Lengths in m
      logical, intent(out) :: sound                  !! Has it been read?
      character(len=:), allocatable :: path, text
      type(error_t), allocatable :: error
      real(wp) :: factor

      path = path_in_deck(group, key)
      if (communicator%rank == 0) call read_file(path, text, error)
      call agree(communicator, error)
      if (.not. allocated(error)) then
         call communicator%broadcast(text)
         call read_raster(text, path, raster, error)
      end if
      sound = .not. allocated(error)
      if (.not. sound) then
         call deck%add_error(group, error%message, key)
         return
      end if
      factor = metres(deck)
      raster%corner = factor*raster%corner
      raster%edge = factor*raster%edge
      where (raster%value > no_data) raster%value = factor*raster%value
      if (grid%dimensions == 2) call take_profile(deck, group, key, raster, sound)
   end subroutine read_one

   !> A length of 1 in the deck and its files [m].
   real(wp) function metres(deck) result(factor)
      type(deck_t), intent(in) :: deck
      type(unit_t) :: length
      logical :: known

      call unit_of("m", length, known)
      factor = 10.0_wp**nint(length%exponent(deck%system))
   end function metres

   !> Reduce a raster to the profile of a plane scene: its only row, or a section.
   subroutine take_profile(deck, group, key, raster, sound)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(group_t), intent(in) :: group
      character(len=*), intent(in) :: key            !! Names the file
      type(raster_t), intent(inout) :: raster
      logical, intent(out) :: sound                  !! Is there a profile?
      real(wp) :: y, upper(2)

      upper = raster%upper()
      sound = .false.
      if (group%given("section")) then
         call group%get("section", y)
         sound = y >= raster%corner(2) .and. y <= upper(2)
         if (.not. sound) call deck%add_error(group, "section must be within the raster, which "// &
            "has y = "//range_text(deck, raster, raster%corner(2), upper(2))//" [D378]", key)
      else
         y = 0.5_wp*(raster%corner(2) + upper(2))
         sound = size(raster%value, 2) == 1
         if (.not. sound) call deck%add_error(group, "a plane scene needs one row of heights, "// &
            "and the raster has "//number(size(raster%value, 2))//"; write section = the y of "// &
            "the profile, from "//range_text(deck, raster, raster%corner(2), upper(2))// &
            " [D378]", key)
      end if
      if (sound) raster = row_of_raster(raster, y)
   end subroutine take_profile

   !> A range of the file, in its units, rounded to a thousandth of a cell.
   function range_text(deck, raster, low, high) result(text)
      type(deck_t), intent(in) :: deck
      type(raster_t), intent(in) :: raster
      real(wp), intent(in) :: low, high              !! [m]
      character(len=:), allocatable :: text

      text = place_text(deck, raster, low)//" to "//place_text(deck, raster, high)
   end function range_text

   !> A length of the file, in its units, rounded to a thousandth of a cell.
   function place_text(deck, raster, place) result(text)
      type(deck_t), intent(in) :: deck
      type(raster_t), intent(in) :: raster
      real(wp), intent(in) :: place                  !! [m]
      character(len=:), allocatable :: text
      real(wp) :: per

      per = metres(deck)
      per = 10.0_wp**max(0, 3 - floor(log10(raster%edge/per)))
      text = number(anint(place/metres(deck)*per)/per)
      if (index(text, ".0", back=.true.) == len(text) - 1) text = text(:len(text) - 2)
   end function place_text

   !> Check that a raster has ground where the grid needs it, once the region is placed.
   subroutine check_terrain(deck, grid, group, holder)
      type(deck_t), intent(inout) :: deck            !! Collects errors and warnings
      type(grid_t), intent(in) :: grid
      type(group_t), intent(in) :: group
      type(shape_holder_t), intent(in) :: holder     !! With the transformed terrain
      real(wp) :: low(3), high(3), corner(3)
      integer :: n, k

      if (.not. allocated(holder%shape)) return
      select type (terrain => holder%shape)
      type is (terrain_t)
         if (allocated(terrain%layer)) then
            call check_layer(deck, group, terrain)
            return
         end if
         ! the grid in the coordinates of the file
         low = huge(low)
         high = -huge(high)
         do n = 0, 7
            do k = 1, 3
               corner(k) = merge(grid%upper(k), grid%lower(k), btest(n, k - 1))
            end do
            corner = terrain%own_place(corner)
            low = min(low, corner)
            high = max(high, corner)
         end do
         call check_cover(deck, group, terrain%ground, low, high)
         if (deck%sound("region", group%place)) &
            call check_heights(deck, group, terrain%ground, low, high)
         if (deck%sound("region", group%place)) &
            call warn_of_gaps(deck, group, terrain%ground, low, high)
      end select
   end subroutine check_terrain

   !> The parts of a grid that a raster does not cover are errors.
   subroutine check_cover(deck, group, ground, low, high)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(group_t), intent(in) :: group
      type(raster_t), intent(in) :: ground
      real(wp), intent(in) :: low(3), high(3)        !! Bounds of the grid in the file [m]
      real(wp), parameter :: round_off = 1.0e-6_wp   ! of a cell
      character(len=:), allocatable :: has, needs, lacks
      real(wp) :: upper(2)
      integer :: k

      upper = ground%upper()
      has = ""
      needs = ""
      lacks = ""
      do k = 1, merge(1, 2, ground%profile)
         has = has//" and "//axis_names(k)//" = "//range_text(deck, ground, ground%corner(k), &
            upper(k))
         needs = needs//" and "//axis_names(k)//" = "//range_text(deck, ground, low(k), high(k))
         if (low(k) < ground%corner(k) - round_off*ground%edge) lacks = lacks//", "// &
            axis_names(k)//" = "//range_text(deck, ground, low(k), min(ground%corner(k), high(k)))
         if (high(k) > upper(k) + round_off*ground%edge) lacks = lacks//", "// &
            axis_names(k)//" = "//range_text(deck, ground, max(upper(k), low(k)), high(k))
      end do
      if (lacks /= "") call deck%add_error(group, "the raster has"//has(5:)//", but the grid "// &
         "needs"//needs(5:)//" of it: there is no ground at "//lacks(3:)//"; shift it with "// &
         "translate, take a larger raster or a smaller grid [D452]", "file")
   end subroutine check_cover

   !> A surface that is above or below the whole grid is an error.
   subroutine check_heights(deck, group, ground, low, high)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(group_t), intent(in) :: group
      type(raster_t), intent(in) :: ground
      real(wp), intent(in) :: low(3), high(3)        !! Bounds of the grid in the file [m]
      real(wp) :: least, greatest

      call ground%extremes(low(:2), high(:2), least, greatest)
      if (least > greatest) then
         call deck%add_error(group, "all cells of the raster in the grid are without data "// &
            "[D452]", "file")
      else if (least >= high(3) .or. greatest <= low(3)) then
         call deck%add_error(group, "the heights in the grid, "//range_text(deck, ground, least, &
            greatest)//", are all "//trim(merge("above", "below", least >= high(3)))//" it: it "// &
            "has z = "//range_text(deck, ground, low(3), high(3))//" of the raster; shift it "// &
            "with translate [D453]", "file")
      end if
   end subroutine check_heights

   !> Warn of cells without data in the grid.
   subroutine warn_of_gaps(deck, group, ground, low, high)
      type(deck_t), intent(inout) :: deck            !! Collects warnings
      type(group_t), intent(in) :: group
      type(raster_t), intent(in) :: ground
      real(wp), intent(in) :: low(3), high(3)        !! Bounds of the grid in the file [m]
      real(wp) :: place(2)
      integer :: i, j, gaps, first(2)
      logical :: aside(2)

      gaps = 0
      first = 0
      do j = size(ground%value, 2), 1, -1
         do i = 1, size(ground%value, 1)
            if (ground%value(i, j) > no_data) cycle
            place = ground%middle(i, j)
            aside = place <= low(:2) - ground%edge .or. place >= high(:2) + ground%edge
            if (aside(1) .or. (aside(2) .and. .not. ground%profile)) cycle
            gaps = gaps + 1
            if (gaps == 1) first = [i, j]
         end do
      end do
      if (gaps == 0) return
      place = ground%middle(first(1), first(2))
      call deck%warn(group, number(gaps)//" cells of the raster in the grid have no data, the "// &
         "first in row "//number(size(ground%value, 2) + 1 - first(2))//", column "// &
         number(first(1))//" at x = "//place_text(deck, ground, place(1))//", y = "// &
         place_text(deck, ground, place(2))//": there is no ground around them, and material "// &
         "falls through; fill them [D454]", "file")
   end subroutine warn_of_gaps

   !> A layer without material, or on cells that have no ground, is an error.
   subroutine check_layer(deck, group, terrain)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(group_t), intent(in) :: group
      type(terrain_t), intent(in) :: terrain
      real(wp) :: place(2), first(2), height
      integer :: i, j, bare
      logical :: known

      bare = 0
      first = 0.0_wp
      associate (layer => terrain%layer)
         if (.not. any(layer%value > 0.0_wp)) call deck%add_error(group, "no cell has a "// &
            "thickness above 0 [D452]", "thickness_file")
         do j = 1, size(layer%value, 2)
            do i = 1, size(layer%value, 1)
               if (.not. layer%value(i, j) > 0.0_wp) cycle
               place = layer%middle(i, j)
               call terrain%ground%find(place(1), place(2), height, known)
               if (known) cycle
               bare = bare + 1
               if (bare == 1) first = place
            end do
         end do
         if (bare > 0) call deck%add_error(group, number(bare)//" cells with a thickness have "// &
            "no ground, the first at x = "//place_text(deck, layer, first(1))//", y = "// &
            place_text(deck, layer, first(2))//"; both rasters must have the same origin [D452]", &
            "thickness_file")
      end associate
   end subroutine check_layer
end module scene_terrain
