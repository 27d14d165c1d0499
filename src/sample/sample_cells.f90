! SPDX-License-Identifier: BSD-3-Clause
!> The grid cells that contain the particles of an output, and sums over them.
!!
!! A cell is on one tile and therefore on one rank, and its particles have a fixed order, so its
!! sums do not depend on ranks or threads.
module sample_cells
   use base_kinds, only: int64, wp
   use mesh_grid, only: grid_t
   use particle_store, only: store_t
   use sample_fields, only: picks_t
   implicit none
   private

   public :: cells_t, find_cells

   !> Cells of this rank with particles in them.
   type :: cells_t
      integer :: count = 0                               !! Number of cells
      integer, allocatable :: place(:, :)                !! (3, cell) Coordinate in the grid, from 0
      integer, allocatable :: group(:)                   !! (cell) Group of its particles, from 0
      integer, allocatable :: of_row(:)                  !! (row) Cell of a particle
   contains
      procedure :: sum => cells_sum                      !! Sums over particles
      procedure :: key => cells_key                      !! Number of a cell in the grid, from 0
   end type cells_t

contains

   !> Find the cells of particles. Rows are particles, store after store. A cell with particles of
   !! several groups is there once for each.
   subroutine find_cells(grid, tiles, stores, picks, cells, group)
      type(grid_t), intent(in) :: grid
      integer, contiguous, intent(in) :: tiles(:, :)     !! (3, tile) Tiles of this rank, from 0
      type(store_t), intent(in) :: stores(:)
      type(picks_t), intent(in) :: picks(:)              !! (store) Selected particles
      type(cells_t), intent(out) :: cells
      integer, allocatable, intent(in), optional :: group(:) !! (store) From 0; default: one
      integer, allocatable :: number(:, :, :), row_tile(:)
      integer :: cell, filled, row, store, tile, of_store(size(stores))

      of_store = 0
      if (present(group)) then
         if (allocated(group)) of_store = group
      end if
      filled = 0
      do store = 1, size(stores)
         filled = filled + size(picks(store)%order)
      end do
      allocate (cells%of_row(filled), row_tile(filled))
      allocate (number(0:grid%tile_cells - 1, size(tiles, 2), 0:maxval([of_store, 0])), source=0)
      filled = 0
      do store = 1, size(stores)
         tile = 1
         do row = 1, size(picks(store)%order)
            associate (p => picks(store)%order(row))
               do while (p >= stores(store)%first(tile) + stores(store)%count(tile) &
                  .or. p < stores(store)%first(tile))
                  tile = tile + 1
               end do
               row_tile(filled + row) = tile
               cells%of_row(filled + row) = stores(store)%home(p)
               number(stores(store)%home(p), tile, of_store(store)) = 1
            end associate
         end do
         filled = filled + size(picks(store)%order)
      end do
      cells%count = sum(number)
      allocate (cells%place(3, cells%count), cells%group(cells%count))
      filled = 0
      do store = 0, ubound(number, 3)
         do tile = 1, size(tiles, 2)
            do cell = 0, grid%tile_cells - 1
               if (number(cell, tile, store) == 0) cycle
               filled = filled + 1
               number(cell, tile, store) = filled
               cells%group(filled) = store
               cells%place(:, filled) = tiles(:, tile)*grid%width + grid%cell_position(:, cell)
            end do
         end do
      end do
      filled = 0
      do store = 1, size(stores)
         do row = filled + 1, filled + size(picks(store)%order)
            cells%of_row(row) = number(cells%of_row(row), row_tile(row), of_store(store))
         end do
         filled = filled + size(picks(store)%order)
      end do
   end subroutine find_cells

   !> Sums over the particles of each cell, in their order.
   pure subroutine cells_sum(self, values, weight, sums)
      class(cells_t), intent(in) :: self
      real(wp), intent(in) :: values(:, :)               !! (component, row)
      real(wp), intent(in) :: weight(:)                  !! (row) Factor of each particle
      real(wp), intent(out) :: sums(:, :)                !! (component, cell)
      integer :: component, row

      sums = 0.0_wp
      do row = 1, size(self%of_row)
         do component = 1, size(values, 1)
            associate (total => sums(component, self%of_row(row)))
               total = total + weight(row)*values(component, row)
            end associate
         end do
      end do
   end subroutine cells_sum

   !> Number of a cell in the grid, from 0, x fastest; those of each group follow each other.
   pure integer(int64) function cells_key(self, grid, cell) result(key)
      class(cells_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      integer, intent(in) :: cell                        !! Index among these

      associate (place => self%place(:, cell))
         key = place(1) + grid%cells(1)*(place(2) + int(grid%cells(2), int64)*(place(3) &
            + int(grid%cells(3), int64)*self%group(cell)))
      end associate
   end function cells_key
end module sample_cells
