! SPDX-License-Identifier: BSD-3-Clause
!> Regions of voxels from a file.
module scene_voxels
   use base_agreement, only: agree
   use base_communicator, only: communicator_t
   use base_error, only: error_t
   use base_kinds, only: wp
   use base_text, only: number
   use deck_reader, only: deck_t, group_t
   use deck_units, only: unit_of, unit_t
   use io_voxels, only: read_voxels, voxel_file_t
   use mesh_grid, only: grid_t
   use particle_shape, only: shape_holder_t
   use particle_voxels, only: set_voxels, voxels_t
   use scene_dimension, only: axis_names
   use scene_file_paths, only: path_in_deck
   implicit none
   private

   public :: read_voxel_region

contains

   !> Read the voxels of a region: the first rank reads and broadcasts. Lengths in the file
   !! are in the unit of the deck. Collective.
   subroutine read_voxel_region(communicator, deck, grid, group, holder)
      type(communicator_t), intent(in) :: communicator !! The first rank reads
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(grid_t), intent(in) :: grid               !! Gives the active directions
      type(group_t), intent(in) :: group
      type(shape_holder_t), intent(inout) :: holder  !! Receives the shape
      character(len=:), allocatable :: dataset
      type(error_t), allocatable :: error
      type(voxel_file_t) :: file
      type(voxels_t) :: voxels
      integer :: value

      call group%get("dataset", dataset)
      call group%get("voxel_value", value)
      if (communicator%rank == 0) &
         call read_voxels(path_in_deck(group, "file"), dataset, value, file, error)
      call agree(communicator, error)
      if (allocated(error)) then
         call deck%add_error(group, error%message, "file")
         return
      end if
      call share(communicator, file)
      call fit(deck, grid, group, file)
      if (.not. deck%sound("region", group%place)) return
      call set_voxels(voxels, file%extent, file%edge, file%corner, file%mask)
      call holder%set(voxels)
   end subroutine read_voxel_region

   !> Broadcast the data of the file to all ranks.
   subroutine share(communicator, file)
      type(communicator_t), intent(in) :: communicator
      type(voxel_file_t), intent(inout) :: file      !! Known to the first rank
      character(len=:), allocatable :: text
      real(wp) :: numbers(10)

      if (communicator%size == 1) return
      numbers = [real(file%dimensions, wp), real(file%extent, wp), file%edge, file%corner]
      text = transfer(numbers, repeat(" ", storage_size(numbers)/8*size(numbers)))
      call communicator%broadcast(text)
      numbers = transfer(text, numbers)
      file%dimensions = nint(numbers(1))
      file%extent = nint(numbers(2:4))
      file%edge = numbers(5:7)
      file%corner = numbers(8:10)
      if (.not. allocated(file%mask)) file%mask = ""
      call communicator%broadcast(file%mask)
   end subroutine share

   !> Convert voxels to the scene: lengths from the unit of the deck, and a single layer without
   !! bounds along missing directions.
   subroutine fit(deck, grid, group, file)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(grid_t), intent(in) :: grid               !! Gives the active directions
      type(group_t), intent(in) :: group
      type(voxel_file_t), intent(inout) :: file      !! Changed
      real(wp), parameter :: far = 1.0e6_wp          ! extents of the box
      type(unit_t) :: length
      real(wp) :: factor, reach
      integer :: k
      logical :: known

      if (file%dimensions < grid%dimensions) call deck%add_error(group, "the voxels have "// &
         number(file%dimensions)//" directions, the scene "//number(grid%dimensions)// &
         "; write as many layers as the body is thick [D360]", "file")
      call unit_of("m", length, known)
      factor = 10.0_wp**nint(length%exponent(deck%system))
      file%edge = factor*file%edge
      file%corner = factor*file%corner
      reach = far*maxval(grid%upper - grid%lower)
      do k = 1, 3
         if (grid%active(k)) cycle
         if (file%extent(k) > 1) call deck%add_error(group, "the scene has no direction "// &
            axis_names(k)//", but there are "//number(file%extent(k))// &
            " voxels along it; write one layer [D360]", "file")
         file%edge(k) = 2.0_wp*reach
         file%corner(k) = -reach
      end do
   end subroutine fit
end module scene_voxels
