! SPDX-License-Identifier: BSD-3-Clause
!> Transfer of velocities from nodes to particles, and from particles to nodes.
!!
!! By default a transfer is PIC: v <- S (u + a dt), with u and a velocity and acceleration of the
!! nodes, dt the time that the forces act, and S the map from nodes to particles. Velocities are
!! defined midway between positions, so u + a dt also moves the particles through the whole step.
!! Each transfer overrides the procedures that differ. Equations (T.1) and (T.2) of
!! doc/theory/transfers.md.
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
      procedure :: velocity_increment => velocity_increment !! Velocity increment of particles
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

   !> Velocity increment of particles: v <- f v + S increment. Equation (T.1).
   pure subroutine velocity_increment(self, dt, velocity, acceleration, increment)
      class(velocity_t), intent(in) :: self
      real(wp), intent(in) :: dt                             !! Time step [s]
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (3, node) u [m/s]
      real(wp), contiguous, intent(in) :: acceleration(:, :) !! (3, node) a [m/s2]
      real(wp), contiguous, intent(inout) :: increment(:, :) !! (3, node) [m/s]

      call combine(dt, acceleration, 1.0_wp - self%flip_fraction(), velocity, increment)
   end subroutine velocity_increment

   !> Node fields that `heat` uses.
   pure subroutine velocity_heat_fields(self, dt, velocity, acceleration, fields)
      class(velocity_t), intent(in) :: self
      real(wp), intent(in) :: dt                             !! Time step [s]
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (3, node) u [m/s]
      real(wp), contiguous, intent(in) :: acceleration(:, :) !! (3, node) a [m/s2]
      real(wp), allocatable, intent(inout) :: fields(:, :)   !! (7, node)
      real(wp) :: given
      integer :: node

      if (.not. allocated(fields)) allocate (fields(7, size(velocity, 2)))
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
   pure subroutine velocity_heat(self, grid, basis, shape, first, fields, velocity, energy)
      class(velocity_t), intent(in) :: self
      type(grid_t), intent(in) :: grid
      class(basis_t), intent(in) :: basis
      integer, intent(in) :: first                           !! First particle of the tile
      type(shape_data_t), intent(inout) :: shape
      real(wp), contiguous, intent(in) :: fields(:, :) !! (7, node) As in `heat_fields`
      real(wp), contiguous, intent(in) :: velocity(:, :)     !! (particle, 3) Before the step [m/s]
      real(wp), contiguous, intent(inout) :: energy(:)       !! (particle) [J/kg]

      call basis%gather_heat(grid, shape, first, fields, 1.0_wp - self%flip_fraction(), velocity, &
         energy)
   end subroutine velocity_heat
end module transfer_velocity
