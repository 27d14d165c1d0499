! SPDX-License-Identifier: BSD-3-Clause
!> A periodic cell of particles whose edges follow a uniform velocity gradient, while the mesh keeps
!! its initial geometry.
!!
!! Positions of particles are those on the mesh, X = F^-1 r with F = h h0^-1 of the edges h now and
!! h0 at the start; velocities are those relative to the uniform flow, v = L r + u. Equation
!! (B.1) of doc/theory/moving_cell.md.
module mesh_moving_cell
   use base_kinds, only: wp
   use base_matrix, only: inverse
   use mesh_box, only: box_t
   use mesh_drive, only: drive_t
   implicit none
   private

   public :: moving_cell_t, stretch_t

   integer, parameter :: row_of(6) = [1, 2, 3, 1, 2, 1] !! Rows of xx yy zz xy yz xz
   integer, parameter :: column_of(6) = [1, 2, 3, 2, 3, 3]
   integer, parameter :: sums = 18                   !! Number of sums of stress and motion
   integer, parameter :: packed = 23 + sums          !! Numbers of a checkpoint

   !> A stage.
   type :: leg_t
      character(len=:), allocatable :: name          !! For the log
      type(drive_t) :: drive                         !! Velocity gradient and held stresses
      real(wp) :: ends = 0.0_wp                      !! Time [s]
   end type leg_t

   !> Mesh and cell at the start of a step, in its middle and at its end.
   type :: stretch_t
      real(wp) :: before(3, 3) = 0.0_wp              !! F at the begin [1]
      real(wp) :: back(3, 3) = 0.0_wp                !! Inverse of F at the begin [1]
      real(wp) :: volume = 1.0_wp                    !! Determinant of F at the begin [1]
      real(wp) :: middle(3, 3) = 0.0_wp              !! Inverse of F in the middle of the step [1]
      real(wp) :: ahead(3, 3) = 0.0_wp               !! F at the end times `middle` [1]
      real(wp) :: strain(3, 3) = 0.0_wp !! Strain of the cell in the step, F1 F0^-1 - 1 [1]
      real(wp) :: dt = 0.0_wp                        !! [s]
   end type stretch_t

   !> Sums over the particles.
   type :: sums_t
      !> Stress times volume of material that carries internal energy, of other material, and mass
      !! times the squares of velocities, xx yy zz xy yz xz [J]
      real(wp) :: now(sums) = 0.0_wp
      real(wp) :: former(sums) = 0.0_wp              !! Value of the previous step [J]
   end type sums_t

   !> The cell.
   type :: moving_cell_t
      type(box_t) :: box
      real(wp) :: mesh(3) = 1.0_wp                   !! Edges of the mesh [m]
      logical :: active(3) = .true.                  !! Directions that the scene has
      type(leg_t), allocatable :: legs(:)            !! Stages of the deck
      integer :: now = 1                             !! Stage
      integer :: logged = 0                          !! Stage that the log has
      type(stretch_t) :: stretch                     !! Deformation of the step
      type(sums_t) :: sums                           !! At the end of the last step
      real(wp) :: mass = 0.0_wp                      !! Mass of all material [kg]
      real(wp) :: speed = 0.0_wp                     !! Speed of the fastest wave at the start [m/s]
      real(wp) :: work = 0.0_wp                      !! Work of the stress on the cell so far [J]
      real(wp) :: steps(3, 3) = 0.0_wp               !! Whole edges subtracted in the step
   contains
      procedure :: tilt => cell_tilt                 !! Edges at the start
      procedure :: renew => cell_renew               !! Quantities that depend on the edges
      procedure :: prepare => cell_prepare           !! Edges after a step
      procedure :: complete => cell_complete         !! New edges, equivalent ones
      procedure :: begin => cell_begin               !! Velocity gradient of the first step
      procedure :: steer => cell_steer               !! Velocity gradient of the next step
      procedure :: step_work => cell_step_work       !! Work of the stress in the step
      procedure :: stress => cell_stress             !! Mean stress
      procedure :: greatest => cell_greatest         !! Greatest stretch of a velocity
      procedure :: longest_step => cell_longest_step !! Step for the velocity gradient
      procedure :: pack => cell_pack                 !! Numbers for a checkpoint
      procedure :: unpack => cell_unpack             !! From a checkpoint
      procedure :: next_end => cell_next_end         !! End of the present stage
      procedure :: pull_back => cell_pull_back       !! Stress and volume on the mesh
      procedure :: turn_nodes => cell_turn_nodes     !! Acceleration of nodes
      procedure :: place_strain => cell_place_strain !! Velocity gradients of a step
      procedure :: place_work => cell_place_work     !! Those that do the work
      procedure :: carry => cell_carry               !! Positions on the mesh
      procedure :: shift => cell_shift               !! Positions on the mesh of equivalent edges
   end type moving_cell_t

contains

   !> Edges at the start, h0 tilted.
   pure subroutine cell_tilt(self, mesh, active, tilt)
      class(moving_cell_t), intent(inout) :: self
      real(wp), intent(in) :: mesh(3)                !! Edges of the mesh [m]
      logical, intent(in) :: active(3)               !! Directions that the scene has
      real(wp), intent(in) :: tilt !! x of the second edge over x of the first
      integer :: axis

      self%mesh = mesh
      self%active = active
      self%box%edges = 0.0_wp
      do axis = 1, 3
         self%box%edges(axis, axis) = mesh(axis)
      end do
      self%box%normal = merge(2, 3, active(2))
      self%box%edges(1, self%box%normal) = tilt*mesh(1)
      call self%box%reduce(self%steps)
      self%steps = 0.0_wp
      call self%renew()
   end subroutine cell_tilt

   !> F, its inverse and its determinant for the current edges.
   pure subroutine cell_renew(self)
      class(moving_cell_t), intent(inout) :: self
      integer :: axis

      do axis = 1, 3
         self%stretch%before(:, axis) = self%box%edges(:, axis)/self%mesh(axis)
      end do
      self%stretch%back = inverse(self%stretch%before)
      self%stretch%volume = self%stretch%before(1, 1)*self%stretch%before(2, 2) &
         *self%stretch%before(3, 3)
   end subroutine cell_renew

   !> Edges at the end of the step, once its length is known, and quantities that follow from them.
   !! In between the mean of F at both ends is used, (B.6).
   pure subroutine cell_prepare(self, dt)
      class(moving_cell_t), intent(inout) :: self
      real(wp), intent(in) :: dt                     !! [s]
      type(box_t) :: next
      real(wp) :: after(3, 3), middle(3, 3), mean_dual(3, 3)
      integer :: axis

      next = self%box
      call next%advance(dt, mean_dual)
      do axis = 1, 3
         after(:, axis) = next%edges(:, axis)/self%mesh(axis)
      end do
      associate (stretch => self%stretch)
         middle = 0.5_wp*(stretch%before + after)
         stretch%dt = dt
         stretch%middle = inverse(middle)
         stretch%ahead = matmul(after, stretch%middle)
         stretch%strain = dt*matmul(self%box%gradient, matmul(middle, stretch%back))
      end associate
   end subroutine cell_prepare

   !> The edges at the end of the step; those that tilt too far are replaced by equivalent ones.
   pure subroutine cell_complete(self, time)
      class(moving_cell_t), intent(inout) :: self
      real(wp), intent(in) :: time                   !! At the end of the step [s]
      real(wp), parameter :: grain = 1.0e-9_wp       ! rounding, of a step
      real(wp) :: mean_dual(3, 3)

      call self%box%advance(self%stretch%dt, mean_dual)
      call self%box%reduce(self%steps)
      call self%renew()
      do while (self%now <= size(self%legs))
         if (time + grain*self%stretch%dt < self%legs(self%now)%ends) exit
         self%now = self%now + 1
      end do
   end subroutine cell_complete

   !> Velocity gradient of the first step, and the length of this step.
   pure subroutine cell_begin(self, strain, dt)
      class(moving_cell_t), intent(inout) :: self    !! With mass, fastest wave and sums
      real(wp), intent(in) :: strain                 !! Greatest strain of a step [1]
      real(wp), intent(inout) :: dt                  !! Stable step in, that of the cell out [s]

      call self%steer(dt)
      dt = min(dt, self%longest_step(strain))
   end subroutine cell_begin

   !> Velocity gradient of the next step by the present stage; after the last stage it is zero.
   pure subroutine cell_steer(self, dt)
      class(moving_cell_t), intent(inout) :: self
      real(wp), intent(in) :: dt                     !! Next time step, about [s]
      real(wp) :: height(3)

      if (self%now > size(self%legs)) then
         self%box%gradient = 0.0_wp
         return
      end if
      height = self%box%heights()
      associate (drive => self%legs(self%now)%drive)
         if (any(drive%servo)) call drive%set_rate(self%mass/self%box%volume(), self%speed, &
            maxval(height, mask=self%active), dt)
         call drive%steer(self%stress(), self%box)
      end associate
   end subroutine cell_steer

   !> Work of the stress of particles on the cell in the step, (B.8) [J]. Material with internal
   !! energy contributes the work of the stress at the start, over the time that forces act; other
   !! material contributes the mean of both ends.
   pure real(wp) function cell_step_work(self, gradient, kick) result(work)
      class(moving_cell_t), intent(in) :: self       !! With the sums at both ends of the step
      real(wp), intent(in) :: gradient(3, 3)         !! L in the step [1/s]
      real(wp), intent(in) :: kick                   !! Time over which the forces act [s]
      real(wp) :: rate
      integer :: k

      work = 0.0_wp
      do k = 1, 6
         rate = gradient(row_of(k), column_of(k))
         if (k > 3) rate = rate + gradient(column_of(k), row_of(k))
         work = work + rate*(kick*self%sums%former(k) &
            + 0.5_wp*self%stretch%dt*(self%sums%former(6 + k) + self%sums%now(6 + k)))
      end do
   end function cell_step_work

   !> Mean stress of the cell, tension positive, with that of the motion, (B.7) [Pa].
   pure function cell_stress(self) result(stress)
      class(moving_cell_t), intent(in) :: self
      real(wp) :: stress(3, 3)
      integer :: k

      do k = 1, 6
         stress(row_of(k), column_of(k)) = (self%sums%now(k) + self%sums%now(6 + k) &
            - self%sums%now(12 + k))/self%box%volume()
         stress(column_of(k), row_of(k)) = stress(row_of(k), column_of(k))
      end do
   end function cell_stress

   !> Greatest ratio of a velocity on the mesh to that in space [1].
   pure real(wp) function cell_greatest(self) result(ratio)
      class(moving_cell_t), intent(in) :: self
      integer :: axis

      ratio = 0.0_wp
      do axis = 1, 3
         if (self%active(axis)) ratio = max(ratio, norm2(self%stretch%back(axis, :)))
      end do
   end function cell_greatest

   !> Longest step with at most a given strain of the cell [s].
   pure real(wp) function cell_longest_step(self, strain) result(dt)
      class(moving_cell_t), intent(in) :: self
      real(wp), intent(in) :: strain                 !! [1]
      real(wp) :: rate

      rate = norm2(self%box%gradient)
      dt = huge(dt)
      if (rate > strain/huge(dt)) dt = strain/rate
   end function cell_longest_step

   !> State for a restart: edges, velocity gradient, strain, sums, work, mass, speed, stage.
   pure function cell_pack(self) result(values)
      class(moving_cell_t), intent(in) :: self
      real(wp) :: values(packed)

      values = [reshape(self%box%edges, [9]), reshape(self%box%gradient, [9]), self%sums%now, &
         self%box%strain, self%work, self%mass, self%speed, real(self%now, wp)]
   end function cell_pack

   !> The same from a checkpoint.
   pure subroutine cell_unpack(self, values)
      class(moving_cell_t), intent(inout) :: self    !! With mesh and stages
      real(wp), intent(in) :: values(:)              !! As packed

      self%box%edges = reshape(values(1:9), [3, 3])
      self%box%gradient = reshape(values(10:18), [3, 3])
      self%sums%now = values(19:18 + sums)
      self%box%strain = values(19 + sums)
      self%work = values(20 + sums)
      self%mass = values(21 + sums)
      self%speed = values(22 + sums)
      self%now = nint(values(23 + sums))
      call self%renew()
   end subroutine cell_unpack

   !> End of the present stage, after the last one huge [s].
   pure real(wp) function cell_next_end(self) result(time)
      class(moving_cell_t), intent(in) :: self

      time = huge(1.0_wp)
      if (self%now <= size(self%legs)) time = self%legs(self%now)%ends
   end function cell_next_end

   !> Volume and stress of particles on the mesh, V/det F and det F F^-1 sigma F^-T, (B.3).
   pure subroutine cell_pull_back(self, count, volume, stress)
      class(moving_cell_t), intent(in) :: self
      integer, intent(in) :: count                   !! Particles
      real(wp), contiguous, intent(inout) :: volume(:)    !! (particle) [m3]
      real(wp), contiguous, intent(inout) :: stress(:, :) !! (particle, 6) xx yy zz xy yz xz [Pa]
      real(wp) :: b(3, 3), j, inverse_j, xx, yy, zz, xy, yz, xz, t(3, 3)
      integer :: p

      b = self%stretch%back
      j = self%stretch%volume
      inverse_j = 1.0_wp/j
      !$omp simd private(xx, yy, zz, xy, yz, xz, t)
      do p = 1, count
         volume(p) = volume(p)*inverse_j
         xx = j*stress(p, 1)
         yy = j*stress(p, 2)
         zz = j*stress(p, 3)
         xy = j*stress(p, 4)
         yz = j*stress(p, 5)
         xz = j*stress(p, 6)
         ! F is upper triangular, and so is its inverse
         t(1, 1) = b(1, 1)*xx + b(1, 2)*xy + b(1, 3)*xz
         t(1, 2) = b(1, 1)*xy + b(1, 2)*yy + b(1, 3)*yz
         t(1, 3) = b(1, 1)*xz + b(1, 2)*yz + b(1, 3)*zz
         t(2, 2) = b(2, 2)*yy + b(2, 3)*yz
         t(2, 3) = b(2, 2)*yz + b(2, 3)*zz
         stress(p, 1) = t(1, 1)*b(1, 1) + t(1, 2)*b(1, 2) + t(1, 3)*b(1, 3)
         stress(p, 2) = t(2, 2)*b(2, 2) + t(2, 3)*b(2, 3)
         stress(p, 3) = b(3, 3)*zz*b(3, 3)
         stress(p, 4) = t(1, 2)*b(2, 2) + t(1, 3)*b(2, 3)
         stress(p, 5) = t(2, 3)*b(3, 3)
         stress(p, 6) = t(1, 3)*b(3, 3)
      end do
   end subroutine cell_pull_back

   !> Acceleration of nodes: f = F f_mesh (B.2), and - L u of the uniform flow with the mean
   !! velocity of the step, (B.4).
   pure subroutine cell_turn_nodes(self, dt, velocity, acceleration, push, centre)
      class(moving_cell_t), intent(in) :: self
      real(wp), intent(in) :: dt                     !! Time over which the forces act [s]
      real(wp), contiguous, intent(in) :: velocity(:, :)        !! (3, node) [m/s]
      real(wp), contiguous, intent(inout) :: acceleration(:, :) !! (3, node) [m/s2]
      real(wp), contiguous, intent(out) :: push(:, :)   !! (3, node) Gain by the flow [m/s]
      real(wp), contiguous, intent(out) :: centre(:, :) !! (3, node) Mean velocity [m/s]
      real(wp) :: half(3, 3), dual(3, 3), a(3), b(3), u(3)
      integer :: node, axis

      half = 0.5_wp*dt*self%box%gradient
      dual = half
      do axis = 1, 3
         dual(axis, axis) = 1.0_wp + dual(axis, axis)
      end do
      dual = inverse(dual)
      associate (f => self%stretch%before, l => self%box%gradient)
         do node = 1, size(velocity, 2)
            a(1) = f(1, 1)*acceleration(1, node) + f(1, 2)*acceleration(2, node) &
               + f(1, 3)*acceleration(3, node)
            a(2) = f(2, 2)*acceleration(2, node) + f(2, 3)*acceleration(3, node)
            a(3) = f(3, 3)*acceleration(3, node)
            u(1) = velocity(1, node)
            u(2) = velocity(2, node)
            u(3) = velocity(3, node)
            b(1) = a(1) - (l(1, 1)*u(1) + l(1, 2)*u(2) + l(1, 3)*u(3))
            b(2) = a(2) - (l(2, 2)*u(2) + l(2, 3)*u(3))
            b(3) = a(3) - l(3, 3)*u(3)
            acceleration(1, node) = dual(1, 1)*b(1) + dual(1, 2)*b(2) + dual(1, 3)*b(3)
            acceleration(2, node) = dual(2, 2)*b(2) + dual(2, 3)*b(3)
            acceleration(3, node) = dual(3, 3)*b(3)
            do axis = 1, 3
               push(axis, node) = dt*(acceleration(axis, node) - a(axis))
               centre(axis, node) = u(axis) + 0.5_wp*dt*acceleration(axis, node)
            end do
         end do
      end associate
   end subroutine cell_turn_nodes

   !> Gradients of a step, F1 Fm^-1 g F0^-1 + F1 F0^-1 - 1 of gradients g on the mesh times the time
   !! step: positions after the step are r + G r, (B.5).
   pure subroutine cell_place_strain(self, count, gradient)
      class(moving_cell_t), intent(in) :: self
      integer, intent(in) :: count                   !! Particles
      real(wp), contiguous, intent(inout) :: gradient(:, :) !! (particle, 9) (k, l) in k + 3 (l - 1)

      call place(count, self%stretch%ahead, self%stretch%back, self%stretch%strain, gradient)
   end subroutine cell_place_strain

   !> Gradients that do the work of the step, g F0^-1 + L dt: forces act in the configuration at its
   !! start, (B.8).
   pure subroutine cell_place_work(self, count, dt, gradient)
      class(moving_cell_t), intent(in) :: self
      integer, intent(in) :: count                   !! Particles
      real(wp), intent(in) :: dt                     !! Time over which the forces act [s]
      real(wp), contiguous, intent(inout) :: gradient(:, :) !! (particle, 9) (k, l) in k + 3 (l - 1)
      real(wp) :: unit(3, 3)
      integer :: axis

      unit = 0.0_wp
      do axis = 1, 3
         unit(axis, axis) = 1.0_wp
      end do
      call place(count, unit, self%stretch%back, dt*self%box%gradient, gradient)
   end subroutine cell_place_work

   !> a g b + c with upper triangular a, b, c.
   pure subroutine place(count, a, b, c, gradient)
      integer, intent(in) :: count                   !! Particles
      real(wp), intent(in) :: a(3, 3), b(3, 3), c(3, 3) !! Upper triangular
      real(wp), contiguous, intent(inout) :: gradient(:, :) !! (particle, 9) (k, l) in k + 3 (l - 1)
      real(wp) :: g(9), t(9)
      integer :: p

      !$omp simd private(g, t)
      do p = 1, count
         g(1) = gradient(p, 1)
         g(2) = gradient(p, 2)
         g(3) = gradient(p, 3)
         g(4) = gradient(p, 4)
         g(5) = gradient(p, 5)
         g(6) = gradient(p, 6)
         g(7) = gradient(p, 7)
         g(8) = gradient(p, 8)
         g(9) = gradient(p, 9)
         t(1) = g(1)*b(1, 1)
         t(2) = g(2)*b(1, 1)
         t(3) = g(3)*b(1, 1)
         t(4) = g(1)*b(1, 2) + g(4)*b(2, 2)
         t(5) = g(2)*b(1, 2) + g(5)*b(2, 2)
         t(6) = g(3)*b(1, 2) + g(6)*b(2, 2)
         t(7) = g(1)*b(1, 3) + g(4)*b(2, 3) + g(7)*b(3, 3)
         t(8) = g(2)*b(1, 3) + g(5)*b(2, 3) + g(8)*b(3, 3)
         t(9) = g(3)*b(1, 3) + g(6)*b(2, 3) + g(9)*b(3, 3)
         gradient(p, 1) = a(1, 1)*t(1) + a(1, 2)*t(2) + a(1, 3)*t(3) + c(1, 1)
         gradient(p, 2) = a(2, 2)*t(2) + a(2, 3)*t(3)
         gradient(p, 3) = a(3, 3)*t(3)
         gradient(p, 4) = a(1, 1)*t(4) + a(1, 2)*t(5) + a(1, 3)*t(6) + c(1, 2)
         gradient(p, 5) = a(2, 2)*t(5) + a(2, 3)*t(6) + c(2, 2)
         gradient(p, 6) = a(3, 3)*t(6)
         gradient(p, 7) = a(1, 1)*t(7) + a(1, 2)*t(8) + a(1, 3)*t(9) + c(1, 3)
         gradient(p, 8) = a(2, 2)*t(8) + a(2, 3)*t(9) + c(2, 3)
         gradient(p, 9) = a(3, 3)*t(9) + c(3, 3)
      end do
   end subroutine place

   !> Positions on the mesh after the step, dX/dt = F^-1 u, where they have moved by dt u already.
   pure subroutine cell_carry(self, first, count, dt, way, position)
      class(moving_cell_t), intent(in) :: self
      integer, intent(in) :: first                   !! First particle
      integer, intent(in) :: count                   !! Particles
      real(wp), intent(in) :: dt                     !! Time step [s]
      real(wp), contiguous, intent(in) :: way(:, :)  !! (particle of the tile, 3) u [m/s]
      real(wp), contiguous, intent(inout) :: position(:, :) !! (particle, 3) [m]
      real(wp) :: more(3, 3)
      integer :: p, axis

      more = self%stretch%middle
      do axis = 1, 3
         more(axis, axis) = more(axis, axis) - 1.0_wp
      end do
      more = dt*more
      do axis = 1, 3
         if (.not. self%active(axis)) cycle
         do p = 1, count
            position(first + p - 1, axis) = position(first + p - 1, axis) + (more(axis, 1) &
               *way(p, 1) + more(axis, 2)*way(p, 2) + more(axis, 3)*way(p, 3))
         end do
      end do
   end subroutine cell_carry

   !> Positions on the mesh of the equivalent edges, wrapped to the mesh.
   pure subroutine cell_shift(self, lower, first, last, position)
      class(moving_cell_t), intent(in) :: self
      real(wp), intent(in) :: lower(3)               !! Corner of the mesh [m]
      integer, intent(in) :: first                   !! First particle
      integer, intent(in) :: last                    !! Last index
      real(wp), contiguous, intent(inout) :: position(:, :) !! (particle, 3) [m]
      real(wp) :: ratio, x
      integer :: p, high, low

      do high = 3, 2, -1
         do low = high - 1, 1, -1
            if (.not. abs(self%steps(low, high)) > 0.0_wp) cycle
            ratio = self%steps(low, high)*self%mesh(low)/self%mesh(high)
            do p = first, last
               x = position(p, low) - lower(low) + ratio*(position(p, high) - lower(high))
               x = x - self%mesh(low)*floor(x/self%mesh(low))
               position(p, low) = lower(low) + x
            end do
         end do
      end do
   end subroutine cell_shift
end module mesh_moving_cell
