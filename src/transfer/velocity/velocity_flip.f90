! SPDX-License-Identifier: BSD-3-Clause
!> In FLIP particles keep their velocity and receive the increments of the nodes (J. U. Brackbill,
!! H. M. Ruppel, J. Comput. Phys. 65 (1986) 314), with a PIC fraction. Equations (T.1) and (T.2) of
!! doc/theory/transfers.md.
module velocity_flip
   use base_kinds, only: wp
   use deck_reader, only: deck_t, group_t
   use deck_schema, only: schema_t
   use transfer_velocity, only: velocity_t
   implicit none
   private

   public :: velocity_flip_t

   !> Increments, blended with PIC.
   type, extends(velocity_t) :: velocity_flip_t
      real(wp) :: share = 1.0_wp                     !! FLIP fraction, the rest is PIC [1]
   contains
      procedure :: declare => flip_declare           !! Key of the FLIP fraction
      procedure :: read => flip_read                 !! Reads it
      procedure :: filters => flip_filters           !! Particles keep their velocity
      procedure :: flip_fraction => flip_flip_fraction
   end type velocity_flip_t

contains

   !> Declare the FLIP fraction, for all transfers that have one.
   subroutine flip_declare(self, schema)
      class(velocity_flip_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema

      call schema%real("method", "flip", "FLIP fraction; the rest is PIC; default: 1 "// &
         "with stress_update = 'usavg' where all material is elastic, except in axisymmetry", &
         default="0.999", range=">= 0 <= 1", owner="transfer = flip aflip rflip")
   end subroutine flip_declare

   !> Read the FLIP fraction.
   subroutine flip_read(self, deck, group)
      class(velocity_flip_t), intent(inout) :: self
      type(deck_t), intent(inout) :: deck
      type(group_t), intent(in) :: group

      call group%get("flip", self%share)
   end subroutine flip_read

   !> Particles keep their velocity and get the changes of the nodes.
   pure logical function flip_filters(self) result(yes)
      class(velocity_flip_t), intent(in) :: self

      yes = .false.
   end function flip_filters

   !> FLIP fraction: fraction of its old velocity that a particle keeps in a step.
   pure real(wp) function flip_flip_fraction(self) result(fraction)
      class(velocity_flip_t), intent(in) :: self

      fraction = self%share
   end function flip_flip_fraction
end module velocity_flip
