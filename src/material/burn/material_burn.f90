! SPDX-License-Identifier: BSD-3-Clause
!> Programmed burn: the pressure of an explosive is that of its products times the fraction that
!! has burnt, which grows from the time at which a detonation reaches it. Equations (X.7),
!! (X.8) and (X.9) of doc/theory/explosives.md.
module material_burn
   use base_kinds, only: wp
   use deck_group_values, only: group_t
   use material_eos, only: eos_t
   use material_state, only: deformation_t, material_state_t
   implicit none
   private

   public :: burn_t, detonator_t

   real(wp), parameter, public :: burnt_before = -1.0e30_wp !! Burn time of products [s]
   real(wp), parameter, public :: never_burns = 1.0e30_wp !! Burn time of unreached material [s]

   integer, parameter, public :: detonator_point = 1, detonator_line = 2, detonator_plane = 3

   !> Where and when detonations begin.
   type :: detonator_t
      integer :: shape = detonator_point             !! One of the shapes above
      real(wp) :: point(3) = 0.0_wp                  !! The point, or one of line or plane [m]
      real(wp) :: other(3) = 0.0_wp                  !! End of the line, or normal of the plane
      real(wp) :: time = 0.0_wp                      !! [s]
      real(wp) :: speed = 0.0_wp                     !! [m/s]
   contains
      procedure :: foot => detonator_foot            !! Point of the detonator nearest to a position
   end type detonator_t

   !> Burn of an explosive.
   type :: burn_t
      real(wp) :: time = 0.0_wp                      !! At the end of the step [s]
      real(wp) :: rate = 0.0_wp                      !! Growth rate of the burn fraction [1/s]
      real(wp) :: speed = 0.0_wp                     !! Detonation speed [m/s]
      real(wp) :: cells = 0.0_wp                     !! Width of the front over that of a cell [1]
      real(wp) :: density = 0.0_wp                   !! Density of the explosive [kg/m3]
      real(wp) :: detonated = 1.0_wp                 !! Relative volume behind the front [1]
      logical :: compressed = .false.                !! Does compression also burn the explosive?
      type(detonator_t), allocatable :: detonators(:) !! Detonators that can reach it
   contains
      procedure :: read => burn_read                 !! Read the keys of &material
      procedure :: apply => burn_apply               !! Pressure times the fraction
   end type burn_t

contains

   !> Point of a detonator nearest to a position [m]. Inactive directions are 0.
   pure function detonator_foot(self, place) result(foot)
      class(detonator_t), intent(in) :: self
      real(wp), intent(in) :: place(3)               !! [m]
      real(wp) :: foot(3), along(3), share

      foot = self%point
      select case (self%shape)
      case (detonator_line)
         along = self%other - self%point
         share = dot_product(along, along)
         if (.not. share > 0.0_wp) return
         share = max(0.0_wp, min(1.0_wp, dot_product(place - self%point, along)/share))
         foot = self%point + share*along
      case (detonator_plane)
         share = dot_product(place - self%point, self%other)/dot_product(self%other, self%other)
         foot = place - share*self%other
      case default
      end select
   end function detonator_foot

   !> Read how an explosive burns; its equation of state is complete.
   pure subroutine burn_read(self, group, eos)
      class(burn_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! &material
      class(eos_t), intent(in) :: eos                !! Equation of state of its products
      character(len=:), allocatable :: word

      call group%get("burn_cells", self%cells)
      call group%get("burn_rule", word)
      self%compressed = word == "both"
      self%density = eos%density
      call eos%detonation(self%speed, self%detonated)
   end subroutine burn_read

   !> Multiply the pressure of the products with the burn fraction. The square of the sound speed is
   !! not reduced, because it is the bound for the next step.
   pure subroutine burn_apply(self, state, deformation, first, last)
      class(burn_t), intent(in) :: self
      type(material_state_t), intent(in) :: state          !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp) :: slope, most
      integer :: i, k

      most = 0.0_wp
      if (self%compressed) most = 1.0_wp/(1.0_wp - self%detonated)
      slope = self%density*most
      do concurrent (i=1:last - first + 1)
         k = first - 1 + i
         deformation%pressure(i) = deformation%pressure(i)*max(0.0_wp, min(1.0_wp, &
            max((self%time - state%burn_time(k))*self%rate, &
            most - slope*state%volume(k)/state%mass(k))))
      end do
   end subroutine burn_apply
end module material_burn
