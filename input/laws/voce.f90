! SPDX-License-Identifier: BSD-3-Clause
!> The law of voce.c in Fortran, with the same bits.
!!
!!     gfortran -O2 -ffp-contract=off -fPIC -shared scree_law.f90 voce.f90 -o voce.so
module voce
   use, intrinsic :: iso_c_binding, only: c_double, c_int32_t, c_int64_t, c_loc, c_null_char, c_ptr
   use scree_law, only: scree_column, scree_history, scree_law_version, scree_rows_t
   implicit none
   private

   character(len=*), parameter :: line = new_line("a")
   character(len=300), target, save :: declaration = "law voce"//line// &
      "constant Y0 [Pa] > 0 : yield stress at the start"//line// &
      "constant Q [Pa] >= 0 : greatest increase of the yield stress"//line// &
      "constant b [1] >= 0 default 10 : rate of its saturation"//line// &
      "field voce_r [Pa] : increase of the yield stress"//line//c_null_char

contains

   !> Version of the interface.
   function law_interface() bind(c, name="scree_law_interface") result(version)
      integer(c_int32_t) :: version

      version = scree_law_version
   end function law_interface

   !> Constants and fields.
   function law_declaration() bind(c, name="scree_law_declaration") result(text)
      type(c_ptr) :: text

      text = c_loc(declaration)
   end function law_declaration

   !> Radial return of the rows.
   subroutine law_update(rows) bind(c, name="scree_law_update")
      type(scree_rows_t), intent(inout) :: rows
      real(c_double), pointer :: constants(:), increase(:), xx(:), yy(:), zz(:), xy(:), yz(:), xz(:)
      real(c_double) :: flow, mises, scaling, slope, yield
      integer(c_int64_t) :: i

      constants => scree_column(rows%constants, 3_c_int64_t)
      increase => scree_history(rows, 1)
      xx => scree_column(rows%stress(1), rows%count)
      yy => scree_column(rows%stress(2), rows%count)
      zz => scree_column(rows%stress(3), rows%count)
      xy => scree_column(rows%stress(4), rows%count)
      yz => scree_column(rows%stress(5), rows%count)
      xz => scree_column(rows%stress(6), rows%count)
      do i = 1, rows%count
         mises = sqrt(1.5_c_double*(xx(i)*xx(i) + yy(i)*yy(i) + zz(i)*zz(i) &
            + 2.0_c_double*(xy(i)*xy(i) + yz(i)*yz(i) + xz(i)*xz(i))))
         yield = constants(1) + increase(i)
         if (mises <= yield) cycle
         slope = constants(3)*(constants(2) - increase(i))
         flow = (mises - yield)/(3.0_c_double*rows%shear + slope)
         scaling = (yield + slope*flow)/mises
         xx(i) = scaling*xx(i)
         yy(i) = scaling*yy(i)
         zz(i) = scaling*zz(i)
         xy(i) = scaling*xy(i)
         yz(i) = scaling*yz(i)
         xz(i) = scaling*xz(i)
         increase(i) = increase(i) + slope*flow
      end do
   end subroutine law_update
end module voce
