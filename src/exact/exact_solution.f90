! SPDX-License-Identifier: BSD-3-Clause
!> Base type of exact solutions: position, velocity and deformation gradient of each material point
!! at any time, and the body force of a manufactured solution.
!!
!! A material point is identified by its reference position. Solutions are evaluated for one point
!! per call; the call costs far less than the sines in it.
module exact_solution
   use base_kinds, only: int64, wp
   use base_matrix, only: determinant, inverse
   use deck_group_values, only: group_t
   use deck_schema, only: schema_t
   implicit none
   private

   public :: exact_case_t, exact_holder_t, exact_t

   !> An exact solution in one material.
   type, abstract :: exact_t
      real(wp) :: density = 1.0_wp                   !! Density of the material at rest [kg/m3]
      real(wp) :: lambda = 0.0_wp                    !! First constant of Lame [Pa]
      real(wp) :: shear = 0.0_wp                     !! Second constant of Lame [Pa]
      real(wp) :: origin(3) = 0.0_wp !! Origin of the coordinates of the solution [m]
      integer :: dimensions = 3                      !! 1, 2 (x and z) or 3
      logical :: hyperelastic = .false. !! Is the material neo-Hookean, else hypoelastic?
   contains
      procedure :: declare => exact_declare          !! Declares its keys of &exact
      procedure :: read => exact_read                !! Reads the keys
      procedure :: law => exact_law                  !! Strength model of the solution
      procedure :: fault => exact_fault              !! Reason why the scene does not allow it
      procedure(place_i), deferred :: place          !! Position and velocity of a point
      procedure(gradient_i), deferred :: gradient    !! Deformation gradient of a point
      procedure :: forced => exact_forced            !! Is it a manufactured solution?
      procedure :: body_force => exact_body_force    !! Body force of the solution
      procedure :: young => exact_young              !! Young's modulus of the material
      procedure :: stress => exact_stress            !! Cauchy stress of a deformation gradient
   end type exact_t

   !> An optional solution.
   type :: exact_holder_t
      class(exact_t), allocatable :: solution        !! Not allocated: none
   end type exact_holder_t

   !> The exact solutions of a run and the errors of the run.
   type :: exact_case_t
      type(exact_holder_t), allocatable :: material(:) !! (material)
      logical :: forced = .false.                    !! Has some material a body force?
      real(wp) :: force_time = 0.0_wp                !! Time of evaluation [s]
      real(wp) :: error(3) = 0.0_wp !! Last errors of displacement [m], velocity [m/s], stress [Pa]
      real(wp) :: greatest_error = 0.0_wp            !! Greatest displacement error so far [m]
      real(wp) :: greatest_motion = 0.0_wp           !! Greatest displacement so far [m]
      integer(int64) :: seen = -1                    !! Step of the last errors
   end type exact_case_t

   abstract interface
      !> Position and velocity of a material point.
      pure subroutine place_i(self, point, time, position, velocity)
         import :: exact_t, wp
         implicit none
         class(exact_t), intent(in) :: self
         real(wp), intent(in) :: point(3)             !! Reference position [m]
         real(wp), intent(in) :: time                 !! [s]
         real(wp), intent(out) :: position(3)         !! [m]
         real(wp), intent(out) :: velocity(3)         !! [m/s]
      end subroutine place_i

      !> Derivative of the position by the reference position.
      pure subroutine gradient_i(self, point, time, gradient)
         import :: exact_t, wp
         implicit none
         class(exact_t), intent(in) :: self
         real(wp), intent(in) :: point(3)             !! Reference position [m]
         real(wp), intent(in) :: time                 !! [s]
         real(wp), intent(out) :: gradient(3, 3)      !! (position, reference) [1]
      end subroutine gradient_i
   end interface

contains

   !> Declare the keys of &exact that belong to the solution. Most override this.
   subroutine exact_declare(self, schema)
      class(exact_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema        !! Keys of the deck
   end subroutine exact_declare

   !> Read the keys that belong to the solution, after material, origin and dimensions are set.
   subroutine exact_read(self, group)
      class(exact_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! &exact
   end subroutine exact_read

   !> The `strength_model` of the solution, empty for any elastic one.
   pure function exact_law(self) result(law)
      class(exact_t), intent(in) :: self
      character(len=:), allocatable :: law

      law = ""
   end function exact_law

   !> Reason why the solution does not suit the scene, and the remedy; empty if it does.
   pure function exact_fault(self) result(text)
      class(exact_t), intent(in) :: self
      character(len=:), allocatable :: text

      text = ""
   end function exact_fault

   !> True for a manufactured solution, which needs a body force.
   pure logical function exact_forced(self) result(forced)
      class(exact_t), intent(in) :: self
      forced = .false.
   end function exact_forced

   !> Body force on a material point.
   pure subroutine exact_body_force(self, point, time, force)
      class(exact_t), intent(in) :: self
      real(wp), intent(in) :: point(3)               !! Reference position [m]
      real(wp), intent(in) :: time                   !! [s]
      real(wp), intent(out) :: force(3)              !! Per mass [m/s2]

      force = 0.0_wp
   end subroutine exact_body_force

   !> Young's modulus of the material [Pa].
   pure real(wp) function exact_young(self) result(young)
      class(exact_t), intent(in) :: self
      young = self%shear*(3.0_wp*self%lambda + 2.0_wp*self%shear)/(self%lambda + self%shear)
   end function exact_young

   !> Cauchy stress of a deformation gradient F, zero for F = 1.
   !!
   !! Neo-Hooke: sigma = lambda ln J/J 1 + mu/J (F F^T - 1). Hypoelastic laws with fixed principal
   !! axes of strain: sigma = lambda tr(e) 1 + 2 mu e with e = ln(F F^T)/2, here approximated to
   !! third order in strain by e = (B - 1)(B + 1)^-1 with B = F F^T.
   pure subroutine exact_stress(self, gradient, stress)
      class(exact_t), intent(in) :: self
      real(wp), intent(in) :: gradient(3, 3)         !! Deformation gradient [1]
      real(wp), intent(out) :: stress(6)             !! xx, yy, zz, xy, yz, xz [Pa]
      real(wp) :: left(3, 3), strain(3, 3), unity(3, 3), volume
      real(wp) :: difference(3, 3), reciprocal(3, 3)
      integer :: k

      unity = 0.0_wp
      do k = 1, 3
         unity(k, k) = 1.0_wp
      end do
      left = matmul(gradient, transpose(gradient))
      if (self%hyperelastic) then
         volume = sqrt(determinant(left))
         strain = (self%lambda*log(volume)*unity + self%shear*(left - unity))/volume
      else
         difference = left - unity
         reciprocal = inverse(left + unity)
         strain = matmul(difference, reciprocal)
         volume = strain(1, 1) + strain(2, 2) + strain(3, 3)
         strain = self%lambda*volume*unity + 2.0_wp*self%shear*strain
      end if
      stress = [strain(1, 1), strain(2, 2), strain(3, 3), strain(1, 2), strain(2, 3), strain(1, 3)]
   end subroutine exact_stress
end module exact_solution
