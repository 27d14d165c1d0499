! SPDX-License-Identifier: BSD-3-Clause
!> Output of the particles near a plane: a file for each time.
module stream_slice
   use base_kinds, only: wp
   use deck_reader, only: deck_t, group_t
   use deck_schema, only: schema_t
   use output_selection, only: declare_axis, read_plane
   use scene_regions, only: named_shape_t
   use step_simulation, only: simulation_t
   use stream_particles, only: stream_particles_t
   implicit none
   private

   public :: stream_slice_t

   !> Snapshots of the particles near a plane.
   type, extends(stream_particles_t) :: stream_slice_t
   contains
      procedure :: about => slice_about              !! For the help
      procedure :: ending => slice_ending            !! End of file names
      procedure :: declare => slice_declare          !! Keys
      procedure :: read => slice_read                !! Read the keys
      procedure :: default_count => slice_default_count !! Not without &output
      procedure :: full_snapshots => slice_full_snapshots !! None
   end type stream_slice_t

contains

   !> For the help of `kind`.
   pure function slice_about(self) result(text)
      class(stream_slice_t), intent(in) :: self
      character(len=:), allocatable :: text

      text = "particles near a plane"
   end function slice_about

   !> Suffix of file names, after the case.
   pure function slice_ending(self) result(text)
      class(stream_slice_t), intent(in) :: self
      character(len=:), allocatable :: text

      text = "_s"
   end function slice_ending

   !> Declare the keys of the kind.
   subroutine slice_declare(self, schema, kind)
      class(stream_slice_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema        !! Schema that receives the keys
      character(len=*), intent(in) :: kind           !! Word of the kind in the catalogue

      call self%stream_particles_t%declare(schema, kind)
      call declare_axis(schema, kind)
      call schema%real("output", "at", &
         "position of the slice; particles within half a cell of it are written", unit="m", &
         owner="kind = "//kind)
      call schema%require("output", "at")
   end subroutine slice_declare

   !> Read the keys of the kind.
   subroutine slice_read(self, group, deck, simulation, shapes)
      class(stream_slice_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! Group &output
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(simulation_t), intent(in) :: simulation   !! Read for the names of fields
      type(named_shape_t), intent(in) :: shapes(:)

      call self%stream_particles_t%read(group, deck, simulation, shapes)
      call read_plane(group, deck, simulation%space%grid, self%format%pick_rule_t)
   end subroutine slice_read

   !> A run without &output writes no slices.
   pure integer function slice_default_count(self) result(number)
      class(stream_slice_t), intent(in) :: self

      number = 0
   end function slice_default_count

   !> No file holds all particles.
   pure real(wp) function slice_full_snapshots(self, time_end) result(number)
      class(stream_slice_t), intent(in) :: self
      real(wp), intent(in) :: time_end               !! End of the run [s]

      number = 0.0_wp
   end function slice_full_snapshots
end module stream_slice
