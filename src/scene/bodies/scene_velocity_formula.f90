! SPDX-License-Identifier: BSD-3-Clause
!> Initial velocities by a formula of the position (`velocity_formula` of &body).
module scene_velocity_formula
   use base_agreement, only: agree
   use base_error, only: error_t, exit_input, fail, without_code
   use base_kinds, only: int64, wp
   use base_text, only: brief
   use deck_formula, only: formula_t
   use deck_place_formula, only: compile_place_formula
   use deck_reader, only: deck_t
   use mesh_grid, only: grid_t
   use mesh_hilbert, only: hilbert_coordinate
   use particle_body, only: body_t
   use particle_fill, only: fill_bodies
   use particle_store, only: store_t
   use scene_particles, only: number_bodies
   use step_simulation, only: simulation_t
   implicit none
   private

   public :: add_formula_velocities, check_formulas

   character(len=1), parameter :: axes(3) = ["x", "y", "z"]

contains

   !> Add the velocities of formulas to those that the particles of their bodies have. Particles
   !! that carry a linear velocity field or a rotation get those of the formula. Collective.
   subroutine add_formula_velocities(simulation, bodies, error)
      type(simulation_t), intent(inout) :: simulation !! The run with particles
      type(body_t), intent(in) :: bodies(:)
      type(error_t), allocatable, intent(out) :: error !! A formula has no value at some particle
      character(len=:), allocatable :: fault
      type(formula_t) :: formula(3)
      integer :: body

      do body = 1, size(bodies)
         if (.not. allocated(bodies(body)%formula)) cycle
         call compile_formula(bodies(body), formula)
         call add_to_body(simulation%space%grid, bodies(body), formula, &
            simulation%stores(bodies(body)%store), fault)
         if (allocated(fault)) call fail(error, exit_input, "&body '"//bodies(body)%name// &
            "': velocity_formula: "//without_code(fault)//" [D226]")
         call agree(simulation%machine%communicator, error)
         if (allocated(error)) return
      end do
   end subroutine add_formula_velocities

   !> Report formulas without a value at a particle before the first state: the particles of one
   !! tile at a time are made and dropped again. Collective.
   subroutine check_formulas(deck, simulation, bodies, keys)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      type(simulation_t), intent(in) :: simulation   !! The run with empty stores
      type(body_t), intent(in) :: bodies(:)
      integer(int64), intent(in) :: keys(:)          !! Tiles with particles
      type(body_t), allocatable :: numbered(:)
      type(formula_t) :: formula(3)
      type(error_t), allocatable :: error
      integer :: body, n, tile(3, 1)
      character(len=:), allocatable :: fault
      type(store_t) :: store

      if (.not. any([(allocated(bodies(body)%formula), body=1, size(bodies))])) return
      allocate (numbered(size(bodies)))
      do body = 1, size(bodies)
         numbered(body) = bodies(body)
      end do
      call number_bodies(simulation%space%grid, numbered)
      do body = 1, size(bodies)
         if (.not. allocated(bodies(body)%formula)) cycle
         call compile_formula(bodies(body), formula)
         ! the first tile of this rank in which a formula has no value at a particle of the body
         if (allocated(error)) deallocate (error)
         do n = simulation%machine%communicator%rank + 1, size(keys), &
            simulation%machine%communicator%size
            tile(:, 1) = hilbert_coordinate(keys(n), simulation%space%grid%dimensions)
            store = simulation%stores(numbered(body)%store)
            call store%remap([0], simulation%space%grid%tile_cells)
            call fill_bodies(simulation%space%grid, numbered, tile, numbered(body)%store, store)
            call add_to_body(simulation%space%grid, numbered(body), formula, store, fault)
            if (.not. allocated(fault)) cycle
            call fail(error, exit_input, "velocity_formula: "//without_code(fault)//" [D226]")
            exit
         end do
         call agree(simulation%machine%communicator, error)
         if (allocated(error)) call deck%add_error("body", body, error%message, "velocity_formula")
      end do
   end subroutine check_formulas

   !> Make formulas of the texts of a body, which the check of the deck has accepted.
   subroutine compile_formula(body, formula)
      type(body_t), intent(in) :: body
      type(formula_t), intent(out) :: formula(3)     !! Formulas of the components
      character(len=:), allocatable :: fault
      integer :: k, place

      do k = 1, 3
         call compile_place_formula(body%formula(k)%text, formula(k), fault, place)
      end do
   end subroutine compile_formula

   !> Those of one body.
   subroutine add_to_body(grid, body, formula, store, fault)
      type(grid_t), intent(in) :: grid
      type(body_t), intent(in) :: body
      type(formula_t), intent(in) :: formula(3)      !! Formulas of the components
      type(store_t), intent(inout) :: store          !! The particles of its material
      character(len=:), allocatable, intent(out) :: fault !! Not allocated if all have values
      real(wp) :: point(3), velocity(3), slopes(9)
      integer(int64) :: last
      integer :: k, p, tile

      last = body%first_identity + product(body%sites(grid)) - 1
      do tile = 1, size(store%count)
         do p = store%first(tile), store%first(tile) + store%count(tile) - 1
            if (store%identity(p) < body%first_identity .or. store%identity(p) > last) cycle
            do k = 1, 3
               point(k) = store%position(p, k)
            end do
            call evaluate(formula, grid%active, point, velocity, fault)
            if (allocated(fault)) return
            do k = 1, 3
               store%velocity(p, k) = store%velocity(p, k) + velocity(k)
            end do
            if (.not. (allocated(store%affine) .or. allocated(store%spin))) cycle
            call find_slopes(formula, grid%active, point, 0.25_wp*grid%spacing, slopes, fault)
            if (allocated(fault)) return
            call add_slopes(slopes, p, store)
         end do
      end do
   end subroutine add_to_body

   !> The velocity at a position; 0 along missing directions.
   subroutine evaluate(formula, active, point, velocity, fault)
      type(formula_t), intent(in) :: formula(3)      !! Formulas of the components
      logical, intent(in) :: active(3)               !! Active directions
      real(wp), intent(in) :: point(3)               !! [m]
      real(wp), intent(out) :: velocity(3)           !! [m/s]
      character(len=:), allocatable, intent(out) :: fault !! Not allocated if there is a value
      integer :: k, place

      velocity = 0.0_wp
      do k = 1, 3
         if (.not. active(k)) cycle
         call formula(k)%evaluate(point, velocity(k), fault, place)
         if (.not. allocated(fault)) cycle
         fault = fault//" in its component "//axes(k)//" at x, y, z = "//brief(point(1))//", "// &
            brief(point(2))//", "//brief(point(3))//" m"
         return
      end do
   end subroutine evaluate

   !> Velocity gradient by differences over half a cell, component (k, l) at k + 3 (l - 1).
   subroutine find_slopes(formula, active, point, reach, slopes, fault)
      type(formula_t), intent(in) :: formula(3)      !! Formulas of the components
      logical, intent(in) :: active(3)               !! Active directions
      real(wp), intent(in) :: point(3)               !! [m]
      real(wp), intent(in) :: reach                  !! To either side [m]
      real(wp), intent(out) :: slopes(9)             !! [1/s]
      character(len=:), allocatable, intent(out) :: fault !! Not allocated if there is a value
      real(wp) :: after(3), before(3), step(3)
      integer :: l

      slopes = 0.0_wp
      do l = 1, 3
         if (.not. active(l)) cycle
         step = 0.0_wp
         step(l) = reach
         call evaluate(formula, active, point - step, before, fault)
         if (.not. allocated(fault)) call evaluate(formula, active, point + step, after, fault)
         if (allocated(fault)) return
         slopes(3*l - 2:3*l) = (after - before)/(2.0_wp*reach)
      end do
   end subroutine find_slopes

   !> Add a velocity gradient to the gradient stored at a particle.
   pure subroutine add_slopes(slopes, p, store)
      real(wp), intent(in) :: slopes(9)              !! [1/s]
      integer, intent(in) :: p
      type(store_t), intent(inout) :: store          !! Receives them

      real(wp) :: turn(3)
      integer :: k

      if (allocated(store%affine)) then
         do k = 1, 9
            store%affine(p, k) = store%affine(p, k) + slopes(k)
         end do
      end if
      if (.not. allocated(store%spin)) return
      turn = 0.5_wp*[slopes(6) - slopes(8), slopes(7) - slopes(3), slopes(2) - slopes(4)]
      do k = 1, 3
         store%spin(p, k) = store%spin(p, k) + turn(k)
      end do
   end subroutine add_slopes
end module scene_velocity_formula
