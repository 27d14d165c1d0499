! SPDX-License-Identifier: BSD-3-Clause
!> Volumes of loose material from the fill of the nodes (`volume_from = 'grid'` of a material).
!!
!! The volume of a particle follows the velocity gradient. Where material separates and joins again,
!! the gradient jumps between particles. The volume that it adds while a gap opens differs from the
!! volume that it removes while the gap closes: gaps that support pressure remain, beside particles
!! that are too large. The fill of a node, the volume of the particles around it over its own, shows
!! both errors. Where it is below 1, compressed particles grow, at most to their volume without
!! pressure, and so the gap closes. Where it is above 1, loose particles shrink, at most to that
!! volume. Grains are never compressed by this. At the surface of bodies a fill below 1 has no
!! meaning, unless material thins out towards a closed boundary.
!!
!! Particles of a cell have one gradient, so a compressed particle keeps the voids of a loose
!! neighbour open. Volume is therefore exchanged between them, with the same sum.
!!
!! A volume with a history is the remedy of A. P. Tampubolon and others, ACM Trans. Graph. 36 (2017)
!! 105 for particles that carry an elastic strain; here the density gives the pressure, so the gaps
!! must be found.
module step_grid_volumes
   use base_elementary, only: take_exponentials
   use base_kinds, only: wp
   use material_type, only: material_t
   use mesh_boundary, only: boundary_t
   use mesh_grid, only: grid_t
   use particle_store, only: store_t
   use step_ledger, only: dissipated, ledger_t
   implicit none
   private

   public :: excess_fill, correct_volumes

   !> Irregular particle positions make the fill fluctuate. A fill this near to 1 counts as 1: with
   !! a smaller tolerance grains would be packed until the lowest fill is 1 and the mean above it.
   real(wp), parameter :: noise = 5.0e-2_wp

contains

   !> Fill of the nodes of a tile above 1, or below 1 where no surface is near, beyond the tolerance
   !! for noise. Equation (Y.31) of doc/theory/strength.md.
   pure subroutine excess_fill(grid, boundary, coordinate, tile, filled, counted, excess)
      type(grid_t), intent(in) :: grid
      type(boundary_t), intent(in) :: boundary       !! Faces of the domain
      integer, intent(in) :: coordinate(3)           !! The tile, counted from 0
      integer, intent(in) :: tile                    !! Its index
      real(wp), contiguous, intent(in) :: filled(:, :)  !! (1, node) Volume of particles [m3]
      real(wp), contiguous, intent(in) :: counted(:, :) !! (1, node) Volume of full cells [m3]
      real(wp), allocatable, intent(out) :: excess(:, :) !! (1, node) Fill less 1 [1]
      real(wp) :: around(size(filled, 2)), fill, inside
      integer :: node

      allocate (excess(1, size(filled, 2)))
      call grid%node_volume(coordinate, around)
      do node = 1, size(filled, 2)
         excess(1, node) = 0.0_wp
         if (.not. around(node) > 0.0_wp) cycle
         fill = filled(1, node)/around(node) - 1.0_wp
         inside = max(0.0_wp, 1.0_wp - 2.0_wp**grid%dimensions &
            *(1.0_wp - counted(1, node)/around(node)))
         excess(1, node) = max(0.0_wp, fill - noise) + inside*min(0.0_wp, fill + noise)
      end do
      call boundary%see_gaps(grid, coordinate, tile, noise, filled, around, excess)
   end subroutine excess_fill

   !> Let the particles of a tile grow and shrink. The elastic energy that compressed particles lose
   !! is recorded if they carry no internal energy to keep it. Equation (Y.32).
   pure subroutine correct_volumes(store, tile, material, excess, ledger)
      type(store_t), intent(inout) :: store
      integer, intent(in) :: tile
      type(material_t), intent(in) :: material       !! Material of the particles
      real(wp), contiguous, intent(in) :: excess(:, :) !! (particle of the tile, 1) Fill less 1 [1]
      type(ledger_t), intent(inout) :: ledger        !! Private to this thread
      real(wp) :: loose(store%count(tile)), before(store%count(tile)), after(store%count(tile))
      integer :: p, first, last

      first = store%first(tile)
      last = first + store%count(tile) - 1
      associate (state => store%state)
         loose = state%mass(first:last)/material%density
         if (allocated(state%plastic_dilation)) then
            before = state%plastic_dilation(first:last)
            call take_exponentials(size(before), before)
            do p = 1, size(loose)
               loose(p) = loose(p)*before(p)
            end do
         end if
         call material%stored_energy(state, first, last, before)
         do p = 1, size(loose)
            associate (volume => state%volume(first + p - 1))
               if (volume > loose(p)) then
                  volume = max(loose(p), volume/(1.0_wp + max(0.0_wp, excess(p, 1))))
               else
                  volume = min(loose(p), volume/(1.0_wp + min(0.0_wp, excess(p, 1))))
               end if
            end associate
         end do
         call exchange_volume(store%cell_start(:, tile), first, loose, state%volume)
      end associate
      call material%stored_energy(store%state, first, last, after)
      if (.not. allocated(store%state%energy)) &
         call ledger%sums(dissipated)%add(sum(before - after))
   end subroutine correct_volumes

   !> Move volume from loose to compressed particles of each cell, until no particle is loose or
   !! none is compressed. All particles take part in proportion to their excess or deficit.
   pure subroutine exchange_volume(start, first, loose, volume)
      integer, contiguous, intent(in) :: start(0:)   !! (0:cells) Particles before a cell
      integer, intent(in) :: first                   !! First particle of the tile
      real(wp), intent(in) :: loose(:)               !! (particle of the tile) Without pressure [m3]
      real(wp), contiguous, intent(inout) :: volume(:) !! (store) [m3]
      real(wp) :: spare, lack, moved
      integer :: cell, p

      do cell = 0, ubound(start, 1) - 1
         spare = 0.0_wp
         lack = 0.0_wp
         do p = start(cell) + 1, start(cell + 1)
            spare = spare + max(0.0_wp, volume(first + p - 1) - loose(p))
            lack = lack + max(0.0_wp, loose(p) - volume(first + p - 1))
         end do
         moved = min(spare, lack)
         if (.not. moved > 0.0_wp) cycle
         do p = start(cell) + 1, start(cell + 1)
            associate (v => volume(first + p - 1))
               v = v - merge(moved/spare, moved/lack, v > loose(p))*(v - loose(p))
            end associate
         end do
      end do
   end subroutine exchange_volume
end module step_grid_volumes
