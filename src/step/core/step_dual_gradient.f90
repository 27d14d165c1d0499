! SPDX-License-Identifier: BSD-3-Clause
!> The dual gradient on the nodes: weights of cells, volumes, forces of the node stress, and node
!! gradients of velocities. Every tile adds the contribution of its cells, kept as packed patches.
module step_dual_gradient
   use base_kinds, only: wp
   use ddmp_dual, only: dual_t
   use mesh_grid, only: grid_t
   use mesh_packed_patch, only: packed_patch_t
   use mesh_patch, only: clear_patch, empty_box, ensure_patch, ensure_weights, extent_of, &
      widen_box
   use mesh_tiles, only: neighbors, shift_to
   use step_bounds, only: are_nodes_slow
   use step_method, only: method_t, stress_after
   use step_node_fields, only: dual_nodes_t, empty_mass, motion_nodes_t, nodes_t, stress_rows, &
      tensor_rows, vector_rows, whole_tiles
   use step_node_sums, only: divide_nodes, ensure_sums, keep_sums, count_slots
   use step_particles_to_nodes, only: nodes_seen
   use step_simulation, only: machine_t, scheme_t, scratch_t, space_t, velocity_field_t
   use step_tile_cost, only: start_cost, stop_cost
   implicit none
   private

   public :: apply_dual_gradient, ensure_dual, find_volumes, limit_tile_gains, node_gradient, &
      share_cells, store_gradient, widen_weighted

   real(wp), parameter :: small = 3.0e-3_wp          !! Ignored cell fraction

contains

   !> Weights and volumes of the dual gradient, and the force of the stress on the nodes.
   subroutine apply_dual_gradient(space, fields, scheme, machine, scratches, field)
      type(space_t), intent(in) :: space
      type(velocity_field_t), intent(in) :: fields(:)
      type(scheme_t), intent(in) :: scheme
      type(machine_t), intent(inout) :: machine
      type(scratch_t), intent(inout) :: scratches(0:)
      type(velocity_field_t), intent(inout) :: field
      integer :: tile

      call machine%timer%start(machine%phase%grid)
      call ensure_dual(space, scheme, scratches, field%nodes)
      !$omp parallel do default(none) shared(space, fields, scheme, machine, field) private(tile) &
      !$omp schedule(static)
      do tile = 1, space%tiles%all
         call start_cost(machine, tile)
         call weigh_tile(space, fields, scheme, field, tile)
         call stop_cost(machine, tile)
      end do
      !$omp end parallel do
      ! with a mean stress weights and volumes are known
      if (.not. scheme%method%controlled()) call share_cells(space, scheme%dual, machine, &
         field%nodes%dual)
      call field%nodes%dual%force%ensure(field%nodes%dual%weighted%nodes())
      !$omp parallel do default(none) shared(space, scheme, machine, field) private(tile) &
      !$omp schedule(static)
      do tile = 1, space%tiles%all
         call start_cost(machine, tile)
         call force_tile(space, scheme, field%nodes, tile)
         call stop_cost(machine, tile)
      end do
      !$omp end parallel do
      call machine%timer%stop(machine%phase%grid)
   end subroutine apply_dual_gradient

   !> Contributions of the cells of all tiles to the volumes of the nodes, whose weights are known.
   subroutine share_cells(space, dual, machine, dual_nodes)
      type(space_t), intent(in) :: space
      type(dual_t), intent(in) :: dual
      type(machine_t), intent(inout) :: machine
      type(dual_nodes_t), intent(inout) :: dual_nodes
      integer :: tile

      call dual_nodes%weighted%line_up(space%grid, space%tiles)
      call dual_nodes%share%ensure(dual_nodes%weighted%nodes())
      !$omp parallel do default(none) shared(space, dual, machine, dual_nodes) private(tile) &
      !$omp schedule(static)
      do tile = 1, space%tiles%all
         call start_cost(machine, tile)
         call share_tile(space, dual, dual_nodes, tile)
         call stop_cost(machine, tile)
      end do
      !$omp end parallel do
   end subroutine share_cells

   !> Allocate the fields of the dual gradient, except packed patches whose bounds are not known
   !! yet.
   pure subroutine ensure_dual(space, scheme, scratches, nodes)
      type(space_t), intent(in) :: space
      type(scheme_t), intent(in) :: scheme
      type(scratch_t), intent(inout) :: scratches(0:)
      type(nodes_t), intent(inout) :: nodes

      associate (dual => nodes%dual, grid => space%grid, all => space%tiles%all)
         call ensure_sums(space, scratches, nodes%motion)
         call ensure_weights(dual%weight, grid%tile_cells, all)
         call dual%weighted%ensure(all)
         call ensure_patch(dual%volume, 1, grid%tile_nodes, count_slots(space%tiles, scratches, &
            nodes%motion))
         if (scheme%repacks) call ensure_patch(dual%filled, 1, grid%tile_nodes, all)
         if (allocated(dual%share%row)) return
         call dual%share%keep(1, [.true.])
         call dual%force%keep(3, vector_rows(grid))
         call dual%gradient%keep(9, tensor_rows(grid))
         call dual%middle_gradient%keep(9, tensor_rows(grid))
         call dual%gradient_before%keep(9, tensor_rows(grid))
      end associate
   end subroutine ensure_dual

   !> Weights of the cells of a tile.
   subroutine weigh_tile(space, fields, scheme, field, tile)
      type(space_t), intent(in) :: space
      type(velocity_field_t), intent(in) :: fields(:)
      type(scheme_t), intent(in) :: scheme
      type(velocity_field_t), intent(inout) :: field
      integer, intent(in) :: tile
      integer, parameter :: filled = 8               ! row of the patch
      real(wp) :: around(space%grid%tile_nodes)
      real(wp) :: sums(filled, space%grid%tile_nodes)

      associate (motion => field%nodes%motion, dual => field%nodes%dual, grid => space%grid, &
         nodes => field%nodes, coordinate => space%tiles%coordinate(:, tile))
         call motion%packed(1)%assemble(grid, space%tiles, motion%touched, tile, sums)
         if (.not. motion%lean) call keep_sums(motion, tile, sums)
         if (scheme%repacks) dual%filled(1, :, tile) = sums(filled, :)
         if (scheme%method%controlled()) return
         call grid%node_volume(coordinate, around)
         ! with normalised sums the weights are known
         if (field%other > 0 .and. .not. allocated(field%sides)) then
            call weigh_cells(fields(field%other)%nodes%motion)
            call fields(field%other)%sides%drop_cells(grid, tile, dual%weight(:, tile))
         else
            call weigh_cells(motion)
            if (allocated(field%sides)) call field%sides%drop_cells(grid, tile, &
               dual%weight(:, tile))
         end if
         if (tile > space%tiles%own) call keep_cells(grid, motion%touched%box(:, :, tile), &
            dual%weight(:, tile))
         call widen_weighted(grid, dual, tile)
      end associate

   contains

      !> Weights by the sums on the nodes and the particles of both sides.
      subroutine weigh_cells(both)
         type(motion_nodes_t), intent(in) :: both    !! The first side has the particles of both

         ! with normalised sums the weights are known
         if (scheme%weighs()) call scheme%dual%cell_weights(space%grid, sums, filled, around, &
            field%nodes%dual%weight(:, tile), both%covered(:, tile))
      end subroutine weigh_cells
   end subroutine weigh_tile

   !> Cells of a tile of another rank outside of the box of nodes whose sums are known count with
   !! weight 0: no own tile needs them.
   pure subroutine keep_cells(grid, box, weight)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: box(3, 2)               !! Lowest and highest node, from 0
      real(wp), intent(inout) :: weight(0:)          !! (cell)
      integer :: cell, upper(3)

      upper = merge(1, 0, grid%active)
      do cell = 0, grid%tile_cells - 1
         if (any(grid%cell_position(:, cell) < box(:, 1)) .or. &
            any(grid%cell_position(:, cell) + upper > box(:, 2))) weight(cell) = 0.0_wp
      end do
   end subroutine keep_cells

   !> The box of the nodes of the cells of a tile that have a weight.
   pure subroutine widen_weighted(grid, dual, tile)
      type(grid_t), intent(in) :: grid
      type(dual_nodes_t), intent(inout) :: dual
      integer, intent(in) :: tile
      logical :: weighs(grid%tile_cells)

      call empty_box(dual%weighted%box(:, :, tile))
      weighs = dual%weight(:, tile) > 0.0_wp
      call widen_box(grid, weighs, dual%weighted%box(:, :, tile))
   end subroutine widen_weighted

   !> Contribution of the cells of a tile to the volumes of the nodes.
   subroutine share_tile(space, dual, dual_nodes, tile)
      type(space_t), intent(in) :: space
      type(dual_t), intent(in) :: dual
      type(dual_nodes_t), intent(inout) :: dual_nodes
      integer, intent(in) :: tile
      real(wp) :: patch(1, space%grid%tile_nodes)

      associate (grid => space%grid)
         call clear_patch(patch)
         call dual%add_volume(grid, space%tiles%coordinate(:, tile), dual_nodes%weight(:, tile), &
            patch)
         call dual_nodes%share%put(grid, dual_nodes%weighted, tile, 1, patch)
      end associate
   end subroutine share_tile

   !> Volumes of the nodes of a tile.
   pure subroutine find_volumes(space, dual_nodes, tile, slot)
      type(space_t), intent(in) :: space
      type(dual_nodes_t), intent(inout) :: dual_nodes
      integer, intent(in) :: tile
      integer, intent(in) :: slot                    !! Index of its fields

      call dual_nodes%share%assemble(space%grid, space%tiles, dual_nodes%weighted, tile, &
         dual_nodes%volume(:, :, slot))
   end subroutine find_volumes

   !> Weights of the cells of a tile; zero for those of a tile of another rank whose contributions
   !! no own tile needs, because they are too far from it.
   pure subroutine near_weights(space, nodes, tile, less, weight)
      type(space_t), intent(in) :: space
      type(nodes_t), intent(in) :: nodes
      integer, intent(in) :: tile
      integer, intent(in) :: less     !! How many of the layers that are known are not needed
      real(wp), intent(out) :: weight(0:)            !! (cell)
      integer :: place, shift(3), extent(3), low(3), high(3), cell, layers, y, z
      logical :: near(0:size(weight) - 1)

      weight = nodes%dual%weight(:, tile)
      if (tile <= space%tiles%own .or. nodes%motion%layers == whole_tiles) return
      layers = nodes%motion%layers - less
      extent = max(extent_of(space%grid, space%tiles, tile), 1)
      near = .false.
      do place = 1, neighbors
         associate (other => space%tiles%neighbor(place, tile))
            if (other == 0 .or. other > space%tiles%own) cycle
         end associate
         shift = shift_to(:, place)
         low = merge(max(extent - layers, 0), 0, shift > 0)
         high = merge(min(layers, extent), extent, shift < 0) - 1
         do z = low(3), high(3)
            do y = low(2), high(2)
               cell = space%grid%width(1)*(y + space%grid%width(2)*z)
               near(cell + low(1):cell + high(1)) = .true.
            end do
         end do
      end do
      where (.not. near) weight = 0.0_wp
   end subroutine near_weights

   !> Force of the node stress of the cells of a tile.
   subroutine force_tile(space, scheme, nodes, tile)
      type(space_t), intent(in) :: space
      type(scheme_t), intent(in) :: scheme
      type(nodes_t), intent(inout) :: nodes
      integer, intent(in) :: tile
      real(wp) :: stress(9, space%grid%tile_nodes), force(3, space%grid%tile_nodes)
      real(wp) :: weight(space%grid%tile_cells)
      integer :: slot, node, k, at(9)
      integer, parameter :: component(9) = [1, 4, 6, 4, 2, 5, 6, 5, 3]

      associate (motion => nodes%motion, dual => nodes%dual, grid => space%grid, &
         coordinate => space%tiles%coordinate(:, tile))
         slot = motion%slot(tile)
         if (.not. scheme%method%controlled()) call find_volumes(space, dual, tile, slot)
         call motion%packed(2)%assemble(grid, space%tiles, motion%touched, tile, stress)
         if (allocated(nodes%sums%normal)) then
            call normalise_directions(dual%volume(:, :, slot), nodes%sums%normal(:, :, tile), &
               stress)
         else
            call divide_nodes(dual%volume(:, :, slot), 1, stress)
         end if
         if (scheme%method%controlled()) then
            ! add on the nodes the mean stress that was subtracted from the particles
            at = 0
            at(stress_rows(grid)) = [(k, k=1, size(nodes%stress%star, 1))]
            at = at(component)
            do node = 1, size(stress, 2)
               do k = 1, 9
                  if (at(k) > 0) stress(k, node) = stress(k, node) &
                     + nodes%stress%star(at(k), node, tile)
               end do
            end do
         end if
         call space%boundary%mirror(grid, coordinate, stress)
         call clear_patch(force)
         call near_weights(space, nodes, tile, 1, weight)
         call scheme%dual%add_force(grid, coordinate, weight, stress, force)
         if (scheme%dual%hoops) call scheme%dual%add_hoop_force(grid, weight, stress, force)
         call dual%force%put(grid, dual%weighted, tile, 1, force)
      end associate
   end subroutine force_tile

   !> Divide by the volumes of the nodes, or by the sums of their particles, direction by direction.
   !! Equation (Q.8) of doc/theory/quadratures.md.
   pure subroutine normalise_directions(volume, normal, values)
      real(wp), contiguous, intent(in) :: volume(:, :)     !! (1, node) Of the dual gradient [m3]
      real(wp), contiguous, intent(in) :: normal(:, :)     !! (7, node) Over sums; plain weight
      real(wp), contiguous, intent(inout) :: values(:, :)  !! (9, node) (k, l) in row k + 3 (l - 1)
      real(wp) :: inverse
      integer :: node, l

      do node = 1, size(volume, 2)
         inverse = 0.0_wp
         if (volume(1, node) > empty_mass) inverse = 1.0_wp/volume(1, node)
         do l = 1, 3
            values(3*l - 2:3*l, node) = values(3*l - 2:3*l, node) &
               *(normal(4 + l, node)*inverse + normal(l, node))
         end do
      end do
   end subroutine normalise_directions

   !> Bound the gain of nodes of small mass of a tile in the velocity that strains.
   pure subroutine limit_tile_gains(space, method, nodes, tile, slot, dt)
      type(space_t), intent(in) :: space
      type(method_t), intent(in) :: method
      type(nodes_t), intent(inout) :: nodes
      integer, intent(in) :: tile
      integer, intent(in) :: slot                    !! Index of its fields
      real(wp), intent(in) :: dt                     !! Time over which the forces act [s]

      if (.not. (method%dual .and. method%stress == stress_after)) return
      ! in most tiles the gain of no node can exceed the bound (M.17), which needs the volume of the
      ! node. Each component is compared with a bound that is independent of the others
      if (are_nodes_slow(3*space%grid%tile_nodes, nodes%motion%acceleration(:, :, slot), &
         small*space%grid%spacing/(sqrt(3.0_wp)*dt**2))) return
      if (nodes%motion%lean) call find_volumes(space, nodes%dual, tile, slot)
      call limit_node_gains(space%grid, space%tiles%coordinate(:, tile), &
         nodes%dual%volume(1, :, slot), dt, nodes%motion%velocity(:, :, slot), &
         nodes%motion%acceleration(:, :, slot), nodes%motion%strain(:, :, slot))
   end subroutine limit_tile_gains

   !> Contribution of the cells of a tile to the node gradient of a velocity.
   pure subroutine store_gradient(space, dual, nodes, tile, velocity, gradient)
      type(space_t), intent(in) :: space
      type(dual_t), intent(in) :: dual
      type(nodes_t), intent(in) :: nodes
      integer, intent(in) :: tile
      real(wp), contiguous, intent(in) :: velocity(:, :) !! (3, node) [m/s]
      type(packed_patch_t), intent(inout) :: gradient      !! Gets the gradient [m3/s]
      real(wp) :: patch(9, space%grid%tile_nodes), weight(space%grid%tile_cells)

      call clear_patch(patch)
      call near_weights(space, nodes, tile, 2, weight)
      call dual%add_gradient(space%grid, space%tiles%coordinate(:, tile), weight, velocity, patch)
      if (dual%hoops) call dual%add_hoop_rate(space%grid, weight, velocity, patch)
      call gradient%put(space%grid, nodes%dual%weighted, tile, 1, patch)
   end subroutine store_gradient

   !> Sum of the packed patches of a node gradient, divided by the volumes of the nodes. Equation
   !! (M.6) of doc/theory/method.md.
   subroutine node_gradient(space, nodes, tile, shares, gradient)
      type(space_t), intent(in) :: space
      type(nodes_t), intent(in) :: nodes
      integer, intent(in) :: tile
      type(packed_patch_t), intent(in) :: shares           !! Contributions of cells [m3/s]
      !> (9, node) [1/s]; only at nodes that the particles of the tile use
      real(wp), allocatable, intent(inout) :: gradient(:, :)
      integer :: low, high

      if (.not. allocated(gradient)) allocate (gradient(9, space%grid%tile_nodes))
      call shares%assemble(space%grid, space%tiles, nodes%dual%weighted, tile, gradient)
      call nodes_seen(space%grid, nodes%motion, tile, low, high)
      if (allocated(nodes%sums%normal)) then
         call normalise_directions(nodes%dual%volume(:, low:high, nodes%motion%slot(tile)), &
            nodes%sums%normal(:, low:high, tile), gradient(:, low:high))
      else
         call divide_nodes(nodes%dual%volume(:, low:high, nodes%motion%slot(tile)), 1, &
            gradient(:, low:high))
      end if
      call space%boundary%mirror(space%grid, space%tiles%coordinate(:, tile), gradient)
   end subroutine node_gradient

   !> Bound the gain of a node of small mass in the step in the velocity that strains: its force
   !! over its mass has no bound, while particles near it gain only a fraction of the force. Node
   !! volumes count with the weights of cells, so they measure the small mass of a node and its
   !! cells. Gains that move a node by less than a small fraction of a cell are not changed.
   !! Equation (M.17) of doc/theory/method.md.
   pure subroutine limit_node_gains(grid, coordinate, volume, dt, velocity, acceleration, strain)
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: coordinate(3)           !! The tile, counted from 0
      real(wp), intent(in) :: volume(:)              !! (node) With the weights of cells [m3]
      real(wp), intent(in) :: dt                     !! Time over which the forces act [s]
      real(wp), contiguous, intent(in) :: velocity(:, :) !! (3, node) Before the step [m/s]
      real(wp), contiguous, intent(in) :: acceleration(:, :) !! (3, node) [m/s2]
      real(wp), contiguous, intent(inout) :: strain(:, :) !! (3, node) Velocity that strains [m/s]
      real(wp), parameter :: light = 0.125_wp        !! Below this fraction of the volume around
      real(wp) :: around(size(volume)), share, gain
      integer :: node

      call grid%node_volume(coordinate, around)
      do node = 1, size(volume)
         if (.not. volume(node) < light*around(node)) cycle
         gain = dt**2*sqrt(acceleration(1, node)**2 + acceleration(2, node)**2 &
            + acceleration(3, node)**2)
         if (.not. gain > small*grid%spacing) cycle
         share = max(volume(node)/(light*around(node)), small*grid%spacing/gain)
         if (share < 1.0_wp) strain(:, node) = velocity(:, node) + share*dt*acceleration(:, node)
      end do
   end subroutine limit_node_gains
end module step_dual_gradient
