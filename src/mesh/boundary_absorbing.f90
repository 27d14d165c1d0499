! SPDX-License-Identifier: BSD-3-Clause
!> Absorbing boundaries: open, and waves leave through them where material reaches the boundary at
!! the start.
module boundary_absorbing
   use base_kinds, only: wp
   use mesh_boundary_condition, only: boundary_condition_t, no, normal_direction, yes
   use mesh_grid, only: grid_t
   implicit none
   private

   public :: boundary_absorbing_t

   !> Dashpots on the nodes of a boundary. They are set once the materials are known.
   type, extends(boundary_condition_t) :: boundary_absorbing_t
      !> (normal or tangential, material) Rate at which a node is slowed [1/s]
      real(wp), allocatable :: decay(:, :)
      !> (x, y, z) Index of the material beyond each node of the boundary, counted from 0; 0 where
      !! no material continues and the boundary is open
      integer, allocatable :: beyond(:, :, :)
   contains
      procedure, nopass :: meaning => absorbing_meaning
      procedure, nopass :: lets_out => yes
      procedure, nopass :: absorbs_waves => yes
      procedure, nopass :: suits_part => no
      procedure :: add_forces => absorbing_add_forces
   end type boundary_absorbing_t

contains

   !> One line for the help on the key `type`.
   pure function absorbing_meaning() result(text)
      character(len=:), allocatable :: text

      text = "as outflow, but waves leave without reflection"
   end function absorbing_meaning

   !> Absorb waves at the nodes: dashpots after J. Lysmer, R. L. Kuhlemeyer (J. Eng. Mech. Div. ASCE
   !! 95 (1969) 859), whose force is that of the velocity in the middle of the step. Equation (R.7)
   !! of doc/theory/rigid.md.
   pure subroutine absorbing_add_forces(self, grid, coordinate, face, nodes, dt, velocity, &
      acceleration)
      class(boundary_absorbing_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      integer, intent(in) :: face                    !! 1 to 6
      integer, contiguous, intent(in) :: nodes(:)    !! Nodes of the tile on the boundary
      real(wp), intent(in) :: dt                     !! Time step [s]
      real(wp), contiguous, intent(in) :: velocity(:, :)        !! (3, node) [m/s]
      real(wp), contiguous, intent(inout) :: acceleration(:, :) !! (3, node) [m/s2]
      real(wp) :: decay(3)
      integer :: n, node, normal, material

      if (.not. allocated(self%beyond)) return
      normal = normal_direction(face)
      do n = 1, size(nodes)
         node = nodes(n)
         material = material_beyond(self, grid, coordinate, normal, node)
         if (material == 0) cycle
         decay = self%decay(2, material)
         decay(normal) = self%decay(1, material)
         acceleration(:, node) = (acceleration(:, node) - decay*velocity(:, node)) &
            /(1.0_wp + 0.5_wp*dt*decay)
      end do
   end subroutine absorbing_add_forces

   !> Index of the material beyond a node on the boundary, 0 = none; outside of the domain that of
   !! the next node on the boundary.
   pure integer function material_beyond(self, grid, coordinate, normal, node) result(material)
      class(boundary_absorbing_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coordinate(3)           !! Tile, counted from 0
      integer, intent(in) :: normal                  !! Direction of the normal
      integer, intent(in) :: node                    !! Node of the tile, counted from 1
      integer :: position(3)

      position = coordinate*grid%width + grid%node_position(node)
      position = min(max(position, 0), merge(grid%cells, 0, grid%active))
      position(normal) = 0
      material = self%beyond(position(1), position(2), position(3))
   end function material_beyond
end module boundary_absorbing
