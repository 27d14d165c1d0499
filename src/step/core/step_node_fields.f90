! SPDX-License-Identifier: BSD-3-Clause
!> Node fields of bodies that move with one velocity, in families. Each family is one type, whose
!! `count` names every field once: for the memory in use (the summary) and for that which a run
!! needs (`--check`).
!!
!! All are patches of tiles: (component, node, tile). Fields that the method does not need are not
!! allocated.
module step_node_fields
   use base_kinds, only: int64, wp
   use mesh_grid, only: grid_t
   use mesh_node_boxes, only: node_boxes_t
   use mesh_packed_patch, only: packed_patch_t
   use omp_lib, only: omp_get_thread_num
   use transfer_edges, only: cell_edges
   implicit none
   private

   public :: dual_nodes_t, gradient_rows, motion_nodes_t, node_needs_t, node_tally_t, nodes_t, &
      normalised_nodes_t, stress_rows, tensor_rows, vector_rows

   integer, parameter, public :: mean_before = 2     !! Columns before those of the mean stress
   !> Layers of cells next to own tiles, if all cells of the tiles of other ranks there are needed
   integer, parameter, public :: whole_tiles = huge(1)
   integer, parameter, public :: dual_layers = 3     !! The same for the dual gradient

   !> Nodes with less mass or volume than this count as empty. The value is below the contribution
   !! of any particle, and its inverse is finite.
   real(wp), parameter, public :: empty_mass = 1.0e-290_wp

   !> Node fields that a run needs, with the components that they have.
   type :: node_needs_t
      integer :: vector = 3                          !! Components of a vector in packed patches
      integer :: tensor = 9                          !! Components of a tensor in packed patches
      logical :: lean = .false.                      !! Are most fields kept for threads only?
      logical :: dual = .false.                      !! Dual gradient
      logical :: energy = .false.                    !! Does some material carry internal energy?
      logical :: averages = .false.                  !! Strain of two velocities
      logical :: repacks = .false.                   !! Do nodes correct volumes?
      !> Columns of the work of contact: 0 without it, 1 of its heat, 3 more if contact forces are
      !! stored
      integer :: contact = 0
      logical :: later = .false.                     !! Is work recorded after the second mapping?
      integer :: extra = 0                           !! Columns of values that are mapped again
      integer :: mean = 0                            !! Columns of sums for the mean stress
      integer :: strain = 0                          !! Columns of sums for its strain
      integer :: counted = 0                         !! Columns of normalised sums
      integer :: normal = 0                          !! Columns of their factors
      logical :: rigid = .false.                     !! Rigid regions
   end type node_needs_t

   !> Memory of node fields.
   type :: node_tally_t
      integer :: nodes = 0                           !! Nodes of a tile
      integer :: cells = 0                           !! Cells of a tile
      integer(int64) :: used = 0                     !! Reals in memory
      integer(int64) :: needed = 0                   !! Reals per tile if all fields are used
   contains
      generic :: add => add_patches, add_packed, add_boxes, add_weights
      procedure, private :: add_patches => tally_patches
      procedure, private :: add_packed => tally_packed
      procedure, private :: add_boxes => tally_boxes
      procedure, private :: add_weights => tally_weights
   end type node_tally_t

   !> Sums over particles at the nodes, and the motion of the nodes.
   type :: motion_nodes_t
      type(node_boxes_t) :: touched                  !! Nodes to which the particles of tiles add
      !> Packed patches of mass, momentum, force, with the dual gradient volume; and of stress times
      !! volume
      type(packed_patch_t) :: packed(2)
      real(wp), allocatable :: covered(:, :)         !! (cell, tile) Part with particles [1]
      !> Are the sums and velocities of a tile kept only while a thread works on it? Then packed
      !! patches keep the velocity and acceleration that the particles need
      logical :: lean = .false.
      type(packed_patch_t) :: seen(2)
      !> Layers of cells beside own tiles that are needed of the tiles of other ranks
      integer :: layers = whole_tiles
      real(wp) :: acting = 0.0_wp                    !! Time that the forces acted to move them [s]
      real(wp), allocatable :: mass(:, :, :)         !! (1) Sum of the masses [kg]
      real(wp), allocatable :: velocity(:, :, :)     !! (3) Before the step [m/s]
      real(wp), allocatable :: acceleration(:, :, :) !! (3) [m/s2]
      real(wp), allocatable :: strain(:, :, :)       !! (3) Velocity of the strain increment [m/s]
   contains
      procedure :: count => count_motion
      procedure :: own_mass => motion_own_mass       !! Mass of the particles of a tile
      procedure :: slot => motion_slot               !! Index of the fields of a tile
   end type motion_nodes_t

   !> Dual gradient.
   type :: dual_nodes_t
      type(node_boxes_t) :: weighted                 !! Nodes of cells with a weight
      real(wp), allocatable :: weight(:, :)          !! (cell, tile) Weights of cells
      type(packed_patch_t) :: share                  !! (1) Volume of the dual gradient [m3]
      real(wp), allocatable :: volume(:, :, :)       !! (1) Sum of volumes [m3]
      real(wp), allocatable :: filled(:, :, :)       !! (1) Volume of particles, if requested [m3]
      type(packed_patch_t) :: force                  !! (3) Force of the node stress [N]
      !> (9) Node gradient of strain, of the mid-step velocity, and, where the strain is the average
      !! of two, of the velocity before the step [m3/s]
      type(packed_patch_t) :: gradient, middle_gradient, gradient_before
   contains
      procedure :: count => count_dual
   end type dual_nodes_t

   !> Mean stress, and the strain that belongs to it.
   type :: stress_nodes_t
      !> Mass, volume, stress times volume in the components of `stress_rows`, cover of cells
      real(wp), allocatable :: mean(:, :, :)
      real(wp), allocatable :: star(:, :, :)         !! Mean stress, the same components [Pa]
      real(wp), allocatable :: share(:, :, :)        !! (1) Factor of the sums of particles [1/m3]
      !> Velocity gradients times volume in the components of `gradient_rows`, of the strain, before
      !! the step, of the work [m3/s]
      real(wp), allocatable :: strain(:, :, :)
   contains
      procedure :: count => count_stress
   end type stress_nodes_t

   !> Normalised sums.
   type :: normalised_nodes_t
      !> Patch (5 or 6): mass, volume, volume times 1 - alpha for the three directions, volume of
      !! materials without normalised sums
      real(wp), allocatable :: counted(:, :, :)
      real(wp), allocatable :: covered(:, :, :)      !! Patch (1): volume of full cells [m3]
      !> (7) Factors of the three directions [1/m3], fill of the cells around [1], and of the three
      !! directions those of the plain sums [1]
      real(wp), allocatable :: normal(:, :, :)
      real(wp), allocatable :: present(:, :, :) !! (1) Volume of all cells, with rigid regions [m3]
      real(wp), allocatable :: factor(:, :, :) !! (edge, cell, own tile) Factor of each edge [1]
   contains
      procedure :: count => count_normalised
   end type normalised_nodes_t

   !> Work of walls, gravity and contact that is recorded after the nodes have moved.
   type :: work_nodes_t
      real(wp), allocatable :: velocity_change(:, :, :) !! (3) From walls and gravity [m/s]
      !> (3) Part of the velocity before the step that walls removed [m/s]
      real(wp), allocatable :: velocity_removed(:, :, :)
      real(wp), allocatable :: contact_heat(:, :, :) !! (1) Heat of contact [J/kg]
      real(wp), allocatable :: contact_impulse(:, :, :) !! (3) From other bodies [kg m/s]
   contains
      procedure :: count => count_work
   end type work_nodes_t

   !> Node fields of one velocity field.
   type :: nodes_t
      type(motion_nodes_t) :: motion
      type(dual_nodes_t) :: dual
      type(stress_nodes_t) :: stress
      type(normalised_nodes_t) :: sums
      type(work_nodes_t) :: work
      !> Patch (3): momentum mapped a second time [kg m/s]; (4): with the mass in front
      real(wp), allocatable :: remap(:, :, :)
   contains
      procedure :: count => count_nodes
   end type nodes_t

contains

   !> Components of a vector that can be nonzero.
   pure function vector_rows(grid) result(kept)
      type(grid_t), intent(in) :: grid
      logical :: kept(3)

      kept = grid%active
   end function vector_rows

   !> The same of a tensor whose component (k, l) is in row k + 3 (l - 1).
   pure function tensor_rows(grid) result(kept)
      type(grid_t), intent(in) :: grid
      logical :: kept(9)
      integer :: l

      do l = 1, 3
         kept(3*l - 2:3*l) = grid%active .and. grid%active(l)
      end do
      kept(5) = kept(5) .or. grid%axisymmetric
   end function tensor_rows

   !> Columns of those components of a velocity gradient that can be nonzero.
   pure function gradient_rows(grid) result(rows)
      type(grid_t), intent(in) :: grid
      integer, allocatable :: rows(:)
      integer :: k

      rows = pack([(k, k=1, 9)], tensor_rows(grid))
   end function gradient_rows

   !> Columns of those components of a stress that exert forces.
   pure function stress_rows(grid) result(rows)
      type(grid_t), intent(in) :: grid
      integer, allocatable :: rows(:)
      integer, parameter :: component(6) = [1, 5, 9, 4, 8, 7]
      logical :: kept(9)
      integer :: k

      kept = tensor_rows(grid)
      rows = pack([(k, k=1, 6)], kept(component))
   end function stress_rows

   !> Index of the fields of a tile: its own, or that of the thread that works on it.
   integer function motion_slot(self, tile) result(slot)
      class(motion_nodes_t), intent(in) :: self
      integer, intent(in) :: tile

      slot = tile
      if (self%lean) slot = 1 + omp_get_thread_num()
   end function motion_slot

   !> Mass that the particles of a tile give to its nodes.
   pure subroutine motion_own_mass(self, grid, tile, mass)
      class(motion_nodes_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: tile
      real(wp), intent(out) :: mass(:)               !! (node) [kg]
      real(wp) :: sums(self%packed(1)%rows, size(mass))

      call self%packed(1)%get(grid, self%touched, tile, sums)
      mass = sums(1, :)
   end subroutine motion_own_mass

   !> Count all node fields of the velocity field.
   pure subroutine count_nodes(self, needs, tally)
      class(nodes_t), intent(in) :: self
      type(node_needs_t), intent(in) :: needs
      type(node_tally_t), intent(inout) :: tally

      call self%motion%count(needs, tally)
      call self%dual%count(needs, tally)
      call tally%add(self%remap, needs%extra)
      call self%stress%count(needs, tally)
      call self%sums%count(needs, tally)
      call self%work%count(needs, tally)
   end subroutine count_nodes

   !> Count the fields of the motion. The second packed patch has the memory of the gradient.
   pure subroutine count_motion(self, needs, tally)
      class(motion_nodes_t), intent(in) :: self
      type(node_needs_t), intent(in) :: needs
      type(node_tally_t), intent(inout) :: tally
      integer :: n

      call tally%add(self%touched, .true.)
      call tally%add(self%packed(1), 1 + 2*needs%vector + merge(1, 0, needs%dual))
      call tally%add(self%packed(2), 0)
      call tally%add(self%covered, needs%dual .and. needs%counted == 0)
      do n = 1, size(self%seen)
         call tally%add(self%seen(n), merge(needs%vector, 0, needs%lean))
      end do
      call tally%add(self%mass, merge(0, 1, needs%lean))
      call tally%add(self%velocity, merge(0, 3, needs%lean))
      call tally%add(self%acceleration, merge(0, 3, needs%lean))
      call tally%add(self%strain, merge(0, 3, needs%lean))
   end subroutine count_motion

   !> Count the fields of the dual gradient. Normalised sums use its weights too.
   pure subroutine count_dual(self, needs, tally)
      class(dual_nodes_t), intent(in) :: self
      type(node_needs_t), intent(in) :: needs
      type(node_tally_t), intent(inout) :: tally

      call tally%add(self%weighted, needs%dual)
      call tally%add(self%weight, needs%dual .or. needs%counted > 0)
      call tally%add(self%share, merge(1, 0, needs%dual))
      call tally%add(self%volume, merge(1, 0, needs%dual .and. .not. needs%lean))
      call tally%add(self%filled, merge(1, 0, needs%dual .and. needs%repacks))
      call tally%add(self%force, merge(needs%vector, 0, needs%dual))
      call tally%add(self%gradient, merge(needs%tensor, 0, needs%dual))
      call tally%add(self%middle_gradient, merge(needs%tensor, 0, needs%dual .and. needs%energy))
      call tally%add(self%gradient_before, merge(needs%tensor, 0, needs%dual .and. needs%averages))
   end subroutine count_dual

   !> Count the fields of corrected stress.
   pure subroutine count_stress(self, needs, tally)
      class(stress_nodes_t), intent(in) :: self
      type(node_needs_t), intent(in) :: needs
      type(node_tally_t), intent(inout) :: tally

      call tally%add(self%mean, needs%mean)
      call tally%add(self%star, max(0, needs%mean - mean_before - 1))
      call tally%add(self%share, merge(1, 0, needs%mean > 0))
      call tally%add(self%strain, needs%strain)
   end subroutine count_stress

   !> Count the fields of normalised sums.
   pure subroutine count_normalised(self, needs, tally)
      class(normalised_nodes_t), intent(in) :: self
      type(node_needs_t), intent(in) :: needs
      type(node_tally_t), intent(inout) :: tally

      call tally%add(self%counted, needs%counted)
      call tally%add(self%covered, merge(1, 0, needs%counted > 0))
      call tally%add(self%normal, needs%normal)
      call tally%add(self%present, merge(1, 0, needs%counted > 0 .and. needs%rigid))
      call tally%add(self%factor, merge(cell_edges, 0, needs%counted > 0), tally%cells)
   end subroutine count_normalised

   !> Count the fields of the work.
   pure subroutine count_work(self, needs, tally)
      class(work_nodes_t), intent(in) :: self
      type(node_needs_t), intent(in) :: needs
      type(node_tally_t), intent(inout) :: tally

      call tally%add(self%velocity_change, merge(3, 0, needs%contact > 0 .or. needs%later))
      call tally%add(self%velocity_removed, merge(3, 0, needs%later))
      call tally%add(self%contact_heat, min(1, needs%contact))
      call tally%add(self%contact_impulse, max(0, needs%contact - 1))
   end subroutine count_work

   !> Add patches of all tiles.
   pure subroutine tally_patches(self, patch, needed, sites)
      class(node_tally_t), intent(inout) :: self
      real(wp), allocatable, intent(in) :: patch(:, :, :) !! (component, node, tile)
      integer, intent(in) :: needed                  !! Components, 0 = not needed
      integer, intent(in), optional :: sites         !! Sites of a tile, if they are not its nodes

      if (allocated(patch)) self%used = self%used + size(patch, kind=int64)
      if (present(sites)) then
         self%needed = self%needed + int(needed, int64)*sites
      else
         self%needed = self%needed + int(needed, int64)*self%nodes
      end if
   end subroutine tally_patches

   !> Add packed patches.
   pure subroutine tally_packed(self, patch, needed)
      class(node_tally_t), intent(inout) :: self
      type(packed_patch_t), intent(in) :: patch
      integer, intent(in) :: needed                  !! Components, 0 = not needed

      self%used = self%used + patch%length()
      self%needed = self%needed + int(needed, int64)*self%nodes
   end subroutine tally_packed

   !> Add boxes of nodes: 28 bytes a tile.
   pure subroutine tally_boxes(self, boxes, needed)
      class(node_tally_t), intent(inout) :: self
      type(node_boxes_t), intent(in) :: boxes
      logical, intent(in) :: needed                  !! Does the method have them?

      if (allocated(boxes%box)) self%used = self%used + (28_int64*size(boxes%box, 3) + 7)/8
      if (needed) self%needed = self%needed + 4
   end subroutine tally_boxes

   !> Add weights of cells.
   pure subroutine tally_weights(self, weight, needed)
      class(node_tally_t), intent(inout) :: self
      real(wp), allocatable, intent(in) :: weight(:, :) !! (cell, tile)
      logical, intent(in) :: needed                  !! Does the method have them?

      if (allocated(weight)) self%used = self%used + size(weight, kind=int64)
      if (needed) self%needed = self%needed + self%cells
   end subroutine tally_weights
end module step_node_fields
