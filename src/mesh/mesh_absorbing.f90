! SPDX-License-Identifier: BSD-3-Clause
!> Faces through which waves leave, where matter reaches the face at the start.
module mesh_absorbing
   use base_kinds, only: wp
   use mesh_boundary, only: boundary_t, face_absorbing, face_nodes
   use mesh_grid, only: grid_t
   use mesh_wall, only: rule_t
   implicit none
   private

   public :: absorbing_t

   !> What a face takes from its nodes.
   type :: dashpots_t
      !> (along the normal or the face, material) Rate at which a node is slowed [1/s]
      real(wp), allocatable :: decay(:, :)
      !> (x, y, z) Number of the material that goes on beyond each node of the face, counted from 0;
      !! 0: none does, and the face is open
      integer, allocatable :: beyond(:, :, :)
   end type dashpots_t

   !> Those of all faces of a run; not allocated for faces of other types.
   type :: absorbing_t
      type(dashpots_t) :: face(6)                    !! (face)
   contains
      procedure :: absorb => absorbing_absorb        !! Let waves leave
   end type absorbing_t

contains

   !> Absorbing faces take from their nodes what waves carry to them: dashpots after J. Lysmer,
   !! R. L. Kuhlemeyer (J. Eng. Mech. Div. ASCE 95 (1969) 859), whose force is that of the velocity
   !! in the middle of the step. Equation (R.7) of doc/theory/rigid.md.
   pure subroutine absorbing_absorb(self, grid, boundary, coordinate, dt, velocity, acceleration)
      class(absorbing_t), intent(in) :: self         !! The faces
      type(grid_t), intent(in) :: grid               !! The grid
      type(boundary_t), intent(in) :: boundary       !! The conditions on its faces
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      real(wp), intent(in) :: dt                     !! Time step [s]
      real(wp), contiguous, intent(in) :: velocity(:, :)        !! (3, node) [m/s]
      real(wp), contiguous, intent(inout) :: acceleration(:, :) !! (3, node) [m/s2]
      type(rule_t) :: rule
      real(wp) :: decay(3)
      integer :: nodes(grid%tile_nodes), number, n, face, node, normal, state

      do face = 1, 6
         if (.not. allocated(self%face(face)%beyond)) cycle
         call face_nodes(grid, coordinate, face, nodes, number)
         normal = (face + 1)/2
         do n = 1, number
            node = nodes(n)
            state = matter_beyond(self%face(face), grid, coordinate, normal, node)
            if (state == 0) cycle
            rule = boundary%rule_at(grid, coordinate, face, node)
            if (rule%kind /= face_absorbing) cycle
            decay = self%face(face)%decay(2, state)
            decay(normal) = self%face(face)%decay(1, state)
            acceleration(:, node) = (acceleration(:, node) - decay*velocity(:, node)) &
               /(1.0_wp + 0.5_wp*dt*decay)
         end do
      end do
   end subroutine absorbing_absorb

   !> Number of the material beyond a node on a face, 0 = none; outside of the box that of the next
   !! node on the face.
   pure integer function matter_beyond(dashpots, grid, coordinate, normal, node) result(state)
      type(dashpots_t), intent(in) :: dashpots       !! Of the face
      type(grid_t), intent(in) :: grid               !! The grid
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      integer, intent(in) :: normal                  !! Direction across the face
      integer, intent(in) :: node                    !! Node of the tile, counted from 1
      integer :: place(3)

      place = coordinate*grid%width + grid%node_position(node)
      place = min(max(place, 0), merge(grid%cells, 0, grid%active))
      place(normal) = 0
      state = dashpots%beyond(place(1), place(2), place(3))
   end function matter_beyond
end module mesh_absorbing
