! SPDX-License-Identifier: BSD-3-Clause
!> Node fields of bodies that move with one velocity, in families: each is one type, whose `words`
!> names every field once, so that no field is missing where memory is counted.
!!
!! All are patches of tiles: (component, node, tile). Fields that the method does not need are not
!! allocated.
module step_node_fields
   use base_kinds, only: int64, wp
   use mesh_packed_patch, only: node_boxes_t, packed_patch_t
   use omp_lib, only: omp_get_thread_num
   implicit none
   private

   public :: array_words, nodes_t

   !> Nodes with less mass or volume than this are empty: below any fraction of any mass, and what
   !> it divides stays finite.
   real(wp), parameter, public :: empty_mass = 1.0e-290_wp

   !> Sums over the particles, and how the nodes move.
   type :: motion_nodes_t
      type(node_boxes_t) :: touched                  !! Nodes to which the particles of tiles add
      !> Packed patches of mass, momentum, force, with the dual gradient volume; and of stress times
      !! volume
      type(packed_patch_t) :: packed(2)
      !> Are the sums and velocities of a tile kept only while a thread works on it? Then packed
      !! patches keep what the particles see: velocity and acceleration
      logical :: lean = .false.
      type(packed_patch_t) :: seen(2)
      real(wp) :: acting = 0.0_wp                    !! Time that the forces acted to move them [s]
      real(wp), allocatable :: mass(:, :, :)         !! (1) Sum of the masses [kg]
      real(wp), allocatable :: velocity(:, :, :)     !! (3) Before the step [m/s]
      real(wp), allocatable :: acceleration(:, :, :) !! (3) [m/s2]
      real(wp), allocatable :: strain(:, :, :)       !! (3) Velocity of the strain increment [m/s]
   contains
      procedure :: words => motion_words             !! Reals in all fields
   end type motion_nodes_t

   !> Dual gradient.
   type :: dual_nodes_t
      type(node_boxes_t) :: weighted                 !! Nodes of cells with a weight
      real(wp), allocatable :: weight(:, :)          !! (cell, tile) Weights of cells
      type(packed_patch_t) :: share                  !! (1) Volume of the dual gradient [m3]
      real(wp), allocatable :: volume(:, :, :)       !! (1) Its sum [m3]
      real(wp), allocatable :: filled(:, :, :)       !! (1) Volume of particles, if requested [m3]
      type(packed_patch_t) :: force                  !! (3) Force of the node stress [N]
      !> (9) Node gradient of strain, of the mid-step velocity, and, where the strain is the average
      !! of two, of the velocity before the step [m3/s]
      type(packed_patch_t) :: gradient, middle, earlier
   contains
      procedure :: words => dual_words               !! Reals in all fields
   end type dual_nodes_t

   !> Series of velocities that filters them, and momentum that is mapped a second time.
   type :: series_nodes_t
      !> Patch (3): momentum mapped a second time [kg m/s]; (4): with the mass in front
      real(wp), allocatable :: extra(:, :, :)
      real(wp), allocatable :: filtered(:, :, :)     !! (3) Sum of the series of velocities [m/s]
      real(wp), allocatable :: term(:, :, :)         !! (3) Its last term [m/s]
      real(wp), allocatable :: loss(:, :, :)         !! (1) Kinetic energy that it loses [J/kg]
   contains
      procedure :: words => series_words             !! Reals in all fields
   end type series_nodes_t

   !> Corrections of the stress: mean stress, local stress difference.
   type :: stress_nodes_t
      !> Patch (7): volume, stress times volume; (20) for stress differences: the same and the force
      !! of unit stress
      real(wp), allocatable :: mean(:, :, :)
      real(wp), allocatable :: star(:, :, :)         !! (6) Mean stress [Pa]
      real(wp), allocatable :: unit(:, :, :)         !! Patch (3): wrong force of unit stress [m2]
      real(wp), allocatable :: difference(:, :, :)   !! (3) Change of the force for that [N]
   contains
      procedure :: words => stress_words             !! Reals in all fields
   end type stress_nodes_t

   !> Normalised sums.
   type :: normalised_nodes_t
      !> Patch (5 or 6): mass, volume, volume times 1 - alpha of three directions, volume beyond the
      !! scope
      real(wp), allocatable :: counted(:, :, :)
      real(wp), allocatable :: covered(:, :, :)      !! Patch (1): volume of full cells [m3]
      !> (7) Factors of the three directions [1/m3], how far cells around are full [1], and of the
      !! three directions those of the plain sums [1]
      real(wp), allocatable :: normal(:, :, :)
      real(wp), allocatable :: present(:, :, :)      !! (1) Of all cells, with rigid regions [m3]
      real(wp), allocatable :: factor(:, :, :)       !! (edge, cell, own tile) Of edges [1]
   contains
      procedure :: words => normalised_words         !! Reals in all fields
   end type normalised_nodes_t

   !> Work of walls, gravity and contact that is recorded after the nodes have moved.
   type :: work_nodes_t
      real(wp), allocatable :: push(:, :, :) !! (3) What walls and gravity add to velocities [m/s]
      real(wp), allocatable :: taken(:, :, :) !! (3) What walls take of those before the step [m/s]
      real(wp), allocatable :: rubbed(:, :, :)       !! (1) Heat of contact [J/kg]
   contains
      procedure :: words => work_words               !! Reals in all fields
   end type work_nodes_t

   !> Node fields of one velocity field.
   type :: nodes_t
      type(motion_nodes_t) :: motion
      type(dual_nodes_t) :: dual
      type(series_nodes_t) :: series
      type(stress_nodes_t) :: stress
      type(normalised_nodes_t) :: sums
      type(work_nodes_t) :: work
   contains
      procedure :: slot => nodes_slot                !! Index of the fields of a tile
      procedure :: words => nodes_words              !! Reals in all fields
   end type nodes_t

contains

   !> Index of the fields of a tile: its own, or that of the thread that works on it.
   integer function nodes_slot(self, tile) result(slot)
      class(nodes_t), intent(in) :: self
      integer, intent(in) :: tile

      slot = tile
      if (self%motion%lean) slot = 1 + omp_get_thread_num()
   end function nodes_slot

   !> Reals in all node fields of the velocity field.
   pure integer(int64) function nodes_words(self) result(words)
      class(nodes_t), intent(in) :: self

      words = self%motion%words() + self%dual%words() + self%series%words() + self%stress%words() &
         + self%sums%words() + self%work%words()
   end function nodes_words

   !> Reals in the fields of the motion.
   pure integer(int64) function motion_words(self) result(words)
      class(motion_nodes_t), intent(in) :: self

      words = box_words(self%touched) + sum(self%packed%length()) + sum(self%seen%length()) &
         + array_words(self%mass) + array_words(self%velocity) + array_words(self%acceleration) &
         + array_words(self%strain)
   end function motion_words

   !> Reals in the fields of the dual gradient.
   pure integer(int64) function dual_words(self) result(words)
      class(dual_nodes_t), intent(in) :: self

      words = box_words(self%weighted) + self%share%length() + array_words(self%volume) &
         + array_words(self%filled) + self%force%length() + self%gradient%length() &
         + self%middle%length() + self%earlier%length()
      if (allocated(self%weight)) words = words + size(self%weight, kind=int64)
   end function dual_words

   !> Reals in the fields of the series.
   pure integer(int64) function series_words(self) result(words)
      class(series_nodes_t), intent(in) :: self

      words = array_words(self%extra) + array_words(self%filtered) + array_words(self%term) &
         + array_words(self%loss)
   end function series_words

   !> Reals in the fields of corrected stress.
   pure integer(int64) function stress_words(self) result(words)
      class(stress_nodes_t), intent(in) :: self

      words = array_words(self%mean) + array_words(self%star) + array_words(self%unit) &
         + array_words(self%difference)
   end function stress_words

   !> Reals in the fields of normalised sums.
   pure integer(int64) function normalised_words(self) result(words)
      class(normalised_nodes_t), intent(in) :: self

      words = array_words(self%counted) + array_words(self%covered) + array_words(self%normal) &
         + array_words(self%present) + array_words(self%factor)
   end function normalised_words

   !> Reals in the fields of the work.
   pure integer(int64) function work_words(self) result(words)
      class(work_nodes_t), intent(in) :: self

      words = array_words(self%push) + array_words(self%taken) + array_words(self%rubbed)
   end function work_words

   !> Reals in an array that may not be allocated.
   pure integer(int64) function array_words(array) result(words)
      real(wp), allocatable, intent(in) :: array(:, :, :) !! (component, node, tile)

      words = 0
      if (allocated(array)) words = size(array, kind=int64)
   end function array_words

   !> Boxes of nodes, 28 bytes a tile, counted as reals.
   pure integer(int64) function box_words(boxes) result(words)
      type(node_boxes_t), intent(in) :: boxes

      words = 0
      if (allocated(boxes%box)) words = (28_int64*size(boxes%box, 3) + 7)/8
   end function box_words
end module step_node_fields
