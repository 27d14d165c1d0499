! SPDX-License-Identifier: BSD-3-Clause
!> The domain: a box of cubic cells in one, two or three dimensions, in the plane or axisymmetric.
module mesh_domain
   use base_kinds, only: int64, wp
   implicit none
   private

   public :: domain_t

   !> In two dimensions the active directions are x and z; in axisymmetry they are radius and axis.
   type :: domain_t
      integer :: dimensions = 3                      !! Active directions
      logical :: axisymmetric = .false.              !! x is the radius, z the axis
      logical :: active(3) = .true.                  !! Active directions
      logical :: periodic(3) = .false.               !! Periodic directions
      logical :: wall(6) = .false.                   !! (face) No shape function crosses it
      real(wp) :: lower(3) = 0.0_wp                  !! Lower corner [m]
      real(wp) :: upper(3) = 0.0_wp                  !! Upper corner [m]
      real(wp) :: spacing = 0.0_wp                   !! Edge of a cell [m]
      real(wp) :: depth = 1.0_wp                     !! Extent of inactive directions [m, m2, rad]
      integer :: cells(3) = 1                        !! Cells along each direction
   contains
      procedure :: line_weight => domain_line_weight !! Integrals of the two functions of a line
      procedure :: mass_weight => domain_mass_weight !! Integrals of their products
      procedure :: cell_count => domain_cell_count   !! Cells of the domain
   end type domain_t

contains

   !> Integrals over one cell of the lower and upper function of a direction [m], with the radius
   !! as weight along x in axisymmetry [m2]. An inactive direction has one function, 1.
   pure function domain_line_weight(self, direction, cell) result(weight)
      class(domain_t), intent(in) :: self
      integer, intent(in) :: direction               !! 1 to 3
      integer, intent(in) :: cell                    !! Cell along it, from 0
      real(wp) :: weight(0:1)
      real(wp) :: radius

      if (.not. self%active(direction)) then
         weight = [1.0_wp, 0.0_wp]
      else if (self%axisymmetric .and. direction == 1) then
         radius = self%lower(1) + real(cell, wp)*self%spacing
         weight = self%spacing*(0.5_wp*radius + self%spacing*[1.0_wp/6.0_wp, 1.0_wp/3.0_wp])
      else
         weight = 0.5_wp*self%spacing
      end if
   end function domain_line_weight

   !> Integrals over one cell of the products of the functions of a direction, weights as above.
   pure function domain_mass_weight(self, direction, cell) result(weight)
      class(domain_t), intent(in) :: self
      integer, intent(in) :: direction               !! 1 to 3
      integer, intent(in) :: cell                    !! Cell along it, from 0
      real(wp) :: weight(0:1, 0:1)
      real(wp) :: radius

      weight = 0.0_wp
      if (.not. self%active(direction)) then
         weight(0, 0) = 1.0_wp
      else if (self%axisymmetric .and. direction == 1) then
         radius = self%lower(1) + real(cell, wp)*self%spacing
         weight(0, 0) = self%spacing*(radius/3.0_wp + self%spacing/12.0_wp)
         weight(1, 1) = self%spacing*(radius/3.0_wp + self%spacing/4.0_wp)
         weight(0, 1) = self%spacing*(radius/6.0_wp + self%spacing/12.0_wp)
         weight(1, 0) = weight(0, 1)
      else
         weight(0, 0) = self%spacing/3.0_wp
         weight(1, 1) = weight(0, 0)
         weight(0, 1) = self%spacing/6.0_wp
         weight(1, 0) = weight(0, 1)
      end if
   end function domain_mass_weight

   !> Cells of the domain.
   pure integer(int64) function domain_cell_count(self) result(cells)
      class(domain_t), intent(in) :: self

      cells = product(int(self%cells, int64))
   end function domain_cell_count
end module mesh_domain
