! SPDX-License-Identifier: BSD-3-Clause
!> Transfer of velocities from nodes to particles, and from particles to nodes.
!!
!! By default a transfer is PIC: v <- S (u + a dt), with u and a velocity and acceleration of the
!! nodes, dt the time that the forces act, and S the map from nodes to particles. Velocities are
!! defined midway between positions, so u + a dt also moves the particles through the whole step.
!! Each transfer overrides the procedures that differ.
!!
!! Some transfers use the series w = y_0 + y_1 + ... + y_n of node velocities with y_(s+1) = y_s -
!! S^+ S y_s, where S^+ is the map from particles to nodes, divided by the mass of nodes. With n + 1
!! = k it is the sum over l of (-1)**(l+1) binomial(k, l) (S^+ S)**(l-1) y_0, without its large
!! terms of alternating sign. Each y is one sweep from nodes to particles and back. Equations (T.1),
!! (T.2) and (T.5) of doc/theory/transfers.md.
module transfer_velocity
   use base_kinds, only: wp
   use deck_reader, only: deck_t, group_t
   use deck_schema, only: schema_t
   use mesh_grid, only: grid_t
   use mesh_patch, only: combine
   use transfer_basis, only: basis_t
   use transfer_shape_data, only: shape_data_t
   implicit none
   private

   public :: velocity_t

   !> A transfer of velocities.
   type, abstract :: velocity_t
   contains
      procedure :: declare => velocity_declare       !! Declares its keys, if it has any
      procedure :: read => velocity_read             !! Reads the keys
      procedure :: affine => velocity_affine         !! Do particles carry a linear velocity field?
      procedure :: turning => velocity_turning       !! True if particles carry the rotation only
      procedure :: filters => velocity_filters       !! Does it smooth velocities without forces?
      procedure :: flip_fraction => velocity_flip_fraction
      procedure :: sweeps => velocity_sweeps         !! Terms n of the series
      procedure :: first_term => velocity_first_term !! First term of the series
      procedure :: loss_weight => velocity_loss_weight !! Weight of its terms in the lost energy
      procedure :: velocity_increment => velocity_increment !! Velocity increment of particles
      procedure :: advection_velocity => velocity_advection !! Advection velocity of particles
      procedure :: heat_fields => velocity_heat_fields !! Node fields of the lost kinetic energy
      procedure :: heat => velocity_heat             !! Gives it to the particles
   end type velocity_t

contains

   !> Declare the keys of &method that belong to the transfer. Most have none.
   subroutine velocity_declare(self, schema)
      class(velocity_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema
   end subroutine velocity_declare

   !> Read them.
   subroutine velocity_read(self, deck, group)
      class(velocity_t), intent(inout) :: self
      type(deck_t), intent(inout) :: deck
      type(group_t), intent(in) :: group
   end subroutine velocity_read

   !> Do particles carry a linear velocity field around them?
   pure logical function velocity_affine(self) result(affine)
      class(velocity_t), intent(in) :: self

      affine = .false.
   end function velocity_affine

   !> True if particles carry only the rotation of the velocity around them.
   pure logical function velocity_turning(self) result(turning)
      class(velocity_t), intent(in) :: self

      turning = .false.
   end function velocity_turning

   !> Do particles take the velocity of the nodes, so that a step without forces smooths it?
   pure logical function velocity_filters(self) result(yes)
      class(velocity_t), intent(in) :: self

      yes = .true.
   end function velocity_filters

   !> FLIP fraction: fraction of its old velocity that a particle keeps in a step.
   pure real(wp) function velocity_flip_fraction(self) result(fraction)
      class(velocity_t), intent(in) :: self

      fraction = 0.0_wp
   end function velocity_flip_fraction

   !> Terms of the series after the first one, each a sweep over the particles.
   pure integer function velocity_sweeps(self) result(sweeps)
      class(velocity_t), intent(in) :: self

      sweeps = 0
   end function velocity_sweeps

   !> First term of the series: the velocity before the forces.
   pure subroutine velocity_first_term(self, dt, velocity, acceleration, term)
      class(velocity_t), intent(in) :: self
      real(wp), intent(in) :: dt                             !! Time step [s]
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (3, node) u [m/s]
      real(wp), contiguous, intent(in) :: acceleration(:, :) !! (3, node) a [m/s2]
      real(wp), contiguous, intent(inout) :: term(:, :)      !! (3, node) [m/s]

      term = velocity
   end subroutine velocity_first_term

   !> Factor of <y_0, A**power y_0>, A = 1 - S^+ S, in the part of the dissipated kinetic energy of
   !! the series that is summed over nodes, 2 to 2 n.
   pure real(wp) function velocity_loss_weight(self, power) result(weight)
      class(velocity_t), intent(in) :: self
      integer, intent(in) :: power                           !! Power of A

      weight = 0.0_wp
   end function velocity_loss_weight

   !> Velocity increment of particles: v <- f v + S increment. Equation (T.1).
   pure subroutine velocity_increment(self, dt, acceleration, filtered, increment)
      class(velocity_t), intent(in) :: self
      real(wp), intent(in) :: dt                             !! Time step [s]
      real(wp), contiguous, intent(in) :: acceleration(:, :) !! (3, node) a [m/s2]
      real(wp), contiguous, intent(in) :: filtered(:, :)     !! (3, node) Sum of the series w [m/s]
      real(wp), contiguous, intent(inout) :: increment(:, :) !! (3, node) [m/s]

      call combine(dt, acceleration, 1.0_wp - self%flip_fraction(), filtered, increment)
   end subroutine velocity_increment

   !> Advection velocity of particles: x <- x + S advection times the length of the step. Equation
   !! (T.2).
   pure subroutine velocity_advection(self, dt, velocity, acceleration, filtered, advection)
      class(velocity_t), intent(in) :: self
      real(wp), intent(in) :: dt                             !! Time step [s]
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (3, node) u [m/s]
      real(wp), contiguous, intent(in) :: acceleration(:, :) !! (3, node) a [m/s2]
      real(wp), contiguous, intent(in) :: filtered(:, :)     !! (3, node) Sum of the series w [m/s]
      real(wp), contiguous, intent(inout) :: advection(:, :) !! (3, node) [m/s]

      call combine(1.0_wp, velocity, dt, acceleration, advection)
   end subroutine velocity_advection

   !> Node fields that `heat` uses.
   pure subroutine velocity_heat_fields(self, dt, velocity, acceleration, filtered, last, loss, &
      fields, scalar)
      class(velocity_t), intent(in) :: self
      real(wp), intent(in) :: dt                             !! Time step [s]
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (3, node) u [m/s]
      real(wp), contiguous, intent(in) :: acceleration(:, :) !! (3, node) a [m/s2]
      real(wp), contiguous, intent(in) :: filtered(:, :)     !! (3, node) Sum of the series w [m/s]
      real(wp), contiguous, intent(in) :: last(:, :) !! (3, node) Last term y_n of the series [m/s]
      real(wp), contiguous, intent(in) :: loss(:, :)         !! (1, node) Dissipated energy [J/kg]
      real(wp), allocatable, intent(inout) :: fields(:, :) !! (column, node) At most nine columns
      real(wp), allocatable, intent(inout) :: scalar(:, :)   !! (1, node) A tenth one
      real(wp) :: given
      integer :: node

      if (.not. allocated(fields)) &
         allocate (fields(7, size(velocity, 2)), scalar(1, 0))
      given = 1.0_wp - self%flip_fraction()
      do node = 1, size(velocity, 2)
         associate (u => velocity(:, node), a => acceleration(:, node))
            fields(1:3, node) = dt*a + given*u
            fields(4:6, node) = u + 0.5_wp*dt*a
            fields(7, node) = 0.5_wp*dt**2*(a(1)**2 + a(2)**2 + a(3)**2) + given &
               *(u(1)*(u(1) + dt*a(1)) + u(2)*(u(2) + dt*a(2)) + u(3)*(u(3) + dt*a(3)))
         end associate
      end do
   end subroutine velocity_heat_fields

   !> Convert the kinetic energy that the transfer to the nodes and back dissipates to heat of the
   !! particles, before they get their new velocities.
   pure subroutine velocity_heat(self, grid, basis, shape, first, fields, scalar, velocity, energy)
      class(velocity_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      class(basis_t), intent(in) :: basis
      integer, intent(in) :: first                           !! First particle of the tile
      type(shape_data_t), intent(inout) :: shape
      real(wp), contiguous, intent(in) :: fields(:, :) !! (column, node) Fields as `heat_fields`
      real(wp), contiguous, intent(in) :: scalar(:, :)       !! (1, node) Scalar as in `heat_fields`
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (particle, 3) Before the step [m/s]
      real(wp), contiguous, intent(inout) :: energy(:)       !! (particle) [J/kg]

      call basis%gather_heat(grid, shape, first, fields, 1.0_wp - self%flip_fraction(), velocity, &
         energy)
   end subroutine velocity_heat
end module transfer_velocity
