! SPDX-License-Identifier: BSD-3-Clause
!> Forces between discs: the loops over pairs and over grains in two dimensions.
!!
!! Equations of doc/theory/grains.md.
module grains_discs
   use base_kinds, only: wp
   use grains_law, only: contact_law_t
   use grains_pairs, only: birth_strain, birth_time, dashpot, dashpot_loss, factor, history_words, &
      overlap, pairs_t, push_arm, push_branch, push_force, push_moment, push_words, slip_loss, &
      slips, step_loss, tangent
   use grains_state, only: block_rows, grains_t
   use mesh_box, only: box_t
   implicit none
   private

   public :: push_discs, sum_discs

contains

   !> Forces of all pairs, and the change of their histories over the last time step.
   subroutine push_discs(grains, box, law, time, dt, pairs)
      type(grains_t), intent(in) :: grains !! Velocities at half step, forces before the step
      type(box_t), intent(in) :: box                 !! With the velocity gradient of the step
      type(contact_law_t), intent(in) :: law
      real(wp), intent(in) :: time                   !! At the end of the step [s]
      real(wp), intent(in) :: dt                     !! Length of the step [s]
      type(pairs_t), intent(inout) :: pairs
      real(wp) :: dx, dy, reach
      integer :: pair, i, j

      !$omp parallel do default(none) shared(grains, box, law, time, dt, pairs) &
      !$omp private(pair, i, j, dx, dy, reach) schedule(static)
      do pair = 1, pairs%count
         associate (h => box%edges)
            i = pairs%first(pair)
            j = pairs%second(pair)
            dx = grains%position(1, j) - grains%position(1, i) + pairs%shift(1, pair)*h(1, 1) &
               + pairs%shift(2, pair)*h(1, 2)
            dy = grains%position(2, j) - grains%position(2, i) + pairs%shift(2, pair)*h(2, 2)
            reach = grains%radius(i) + grains%radius(j)
            if (dx*dx + dy*dy >= reach*reach .and. .not. pairs%touches(pair)) cycle
            call push_pair(grains, box, law, time, dt, i, j, dx, dy, pairs%history(:, pair), &
               pairs%push(:, pair))
         end associate
      end do
      !$omp end parallel do
   end subroutine push_discs

   !> Force of one pair that touches or touched in the previous step.
   ! One procedure, because all steps from overlap to force use the same intermediate values.
   pure subroutine push_pair(grains, box, law, time, dt, i, j, dx, dy, history, push)
      type(grains_t), intent(in) :: grains
      type(box_t), intent(in) :: box
      type(contact_law_t), intent(in) :: law
      real(wp), intent(in) :: time, dt               !! [s]
      integer, intent(in) :: i, j                    !! Rows
      real(wp), intent(in) :: dx, dy                 !! From i to j [m]
      real(wp), intent(inout) :: history(history_words) !! (word)
      real(wp), intent(inout) :: push(push_words)    !! (word)
      real(wp) :: distance, nx, ny, depth, former, arm_i, arm_j, wx, wy, apart, slide, mass, at_end
      real(wp) :: q, spring, damper, normal, across, trial, former_spring, stiff, former_stiff
      real(wp) :: drift_x, drift_y, way_x, way_y, from_x, from_y
      logical :: touches

      distance = sqrt(dx*dx + dy*dy)
      nx = dx/distance
      ny = dy/distance
      depth = grains%radius(i) + grains%radius(j) - distance
      touches = depth > 0.0_wp
      arm_i = grains%radius(i) - 0.5_wp*depth
      arm_j = grains%radius(j) - 0.5_wp*depth
      associate (g => box%gradient, v => grains%velocity)
         wx = v(1, j) - v(1, i) + g(1, 1)*dx + g(1, 2)*dy
         wy = v(2, j) - v(2, i) + g(2, 2)*dy
         ! twice the difference between the branch moved by the cell to the end and to the middle of
         ! the step
         drift_x = dt**2*(g(1, 1)*wx + g(1, 2)*wy)
         drift_y = dt**2*g(2, 2)*wy
      end associate
      way_x = dt*wx - 0.5_wp*drift_x
      way_y = dt*wy - 0.5_wp*drift_y
      apart = wx*nx + wy*ny
      ! velocities are at the middle of the step: with the forces at its start they lead to its end
      associate (f => grains%force, m => grains%mass)
         at_end = apart + 0.5_wp*dt*((f(1, j)*nx + f(2, j)*ny)/m(j) &
            - (f(1, i)*nx + f(2, i)*ny)/m(i))
      end associate
      slide = dt*(wy*nx - wx*ny - grains%spin(3, i)*arm_i - grains%spin(3, j)*arm_j)
      former = history(overlap)
      if (.not. former > 0.0_wp) then
         former = way_x*nx + way_y*ny
         former = depth + former - 0.5_wp*(way_x**2 + way_y**2 - former**2)/distance
         history(birth_time) = time
         history(birth_strain) = box%strain
      end if
      mass = grains%mass(i)*grains%mass(j)/(grains%mass(i) + grains%mass(j))
      q = 1.0_wp
      if (law%hertz) q = sqrt(max(depth, 0.0_wp)*grains%radius(i)*grains%radius(j) &
         /(grains%radius(i) + grains%radius(j)))
      spring = 0.0_wp
      damper = 0.0_wp
      if (touches) spring = law%normal*q*depth
      if (touches) damper = -law%damping*sqrt(q*mass)*at_end
      normal = spring + damper
      former_spring = law%normal*history(factor)*max(former, 0.0_wp)
      history(dashpot_loss) = history(dashpot_loss) &
         + 0.5_wp*(history(dashpot) + damper)*(depth - former)
      ! tangential force; unloading scales it with the stiffness
      stiff = law%tangential*q
      former_stiff = law%tangential*history(factor)
      across = history(tangent)
      if (q < history(factor)) across = across*(q/history(factor))
      trial = across - stiff*slide
      history(slips) = 0.0_wp
      if (abs(trial) > law%friction*abs(normal)) then
         trial = sign(law%friction*abs(normal), trial)
         history(slips) = 1.0_wp
      end if
      if (.not. touches) trial = 0.0_wp
      history(slip_loss) = history(slip_loss) - 0.5_wp*(history(tangent) + trial)*slide
      if (stiff > 0.0_wp .and. touches) history(slip_loss) = history(slip_loss) &
         - 0.5_wp*trial**2/stiff
      if (former_stiff > 0.0_wp) history(slip_loss) = history(slip_loss) &
         + 0.5_wp*history(tangent)**2/former_stiff
      ! the remaining work of both forces over the displacement of the step, (G.6); the work of the
      ! final tangential force is its sliding, which is recorded
      across = former_spring + history(dashpot)
      stiff = 1.0_wp/(distance + depth - former)
      from_x = (distance*nx - way_x)*stiff
      from_y = (distance*ny - way_y)*stiff
      history(step_loss) = history(step_loss) - law%stored*(spring*max(depth, 0.0_wp) &
         - former_spring*max(former, 0.0_wp)) + 0.5_wp*((history(dashpot) + damper)*(former &
         - depth) - dt*normal*apart + history(tangent)*(dt*(wy*nx - wx*ny) &
         - 0.5_wp*dt*(former - depth)*(grains%spin(3, i) + grains%spin(3, j))) &
         - (across*from_x - history(tangent)*from_y)*(way_x - 0.5_wp*drift_x) &
         - (across*from_y + history(tangent)*from_x)*(way_y - 0.5_wp*drift_y))
      history(tangent) = trial
      history(overlap) = max(depth, 0.0_wp)
      history(dashpot) = damper
      history(factor) = merge(q, 0.0_wp, touches)
      push(push_force) = normal*nx - trial*ny
      push(push_force + 1) = normal*ny + trial*nx
      push(push_moment) = trial
      push(push_arm) = arm_i
      push(push_arm + 1) = arm_j
      push(push_branch) = dx
      push(push_branch + 1) = dy
   end subroutine push_pair

   !> Sum of the forces on each own grain, in the order of the identities of the others, and of
   !! forces times branches over the pairs that belong to a block of rows.
   subroutine sum_discs(pairs, grains, virial)
      type(pairs_t), intent(in) :: pairs
      type(grains_t), intent(inout) :: grains        !! Gets forces and torques
      real(wp), intent(inout) :: virial(:, :)        !! (3 (l - 1) + k, own block) F_k r_l [J]
      real(wp) :: fx, fy, moment, sums(9)
      integer :: block, row, n, pair

      !$omp parallel do default(none) shared(pairs, grains, virial) &
      !$omp private(block, row, n, pair, fx, fy, moment, sums) schedule(static)
      do block = 1, size(virial, 2)
         sums = 0.0_wp
         do row = (block - 1)*block_rows + 1, min(block*block_rows, grains%last - grains%first + 1)
            fx = 0.0_wp
            fy = 0.0_wp
            moment = 0.0_wp
            do n = pairs%start(row), pairs%start(row + 1) - 1
               pair = pairs%incident(n)
               if (pair > 0) then
                  associate (push => pairs%push(:, pair))
                     fx = fx - push(push_force)
                     fy = fy - push(push_force + 1)
                     moment = moment - push(push_arm)*push(push_moment)
                     sums(1) = sums(1) + push(push_force)*push(push_branch)
                     sums(2) = sums(2) + push(push_force + 1)*push(push_branch)
                     sums(4) = sums(4) + push(push_force)*push(push_branch + 1)
                     sums(5) = sums(5) + push(push_force + 1)*push(push_branch + 1)
                  end associate
               else
                  associate (push => pairs%push(:, -pair))
                     fx = fx + push(push_force)
                     fy = fy + push(push_force + 1)
                     moment = moment - push(push_arm + 1)*push(push_moment)
                  end associate
               end if
            end do
            grains%force(1, grains%first + row - 1) = fx
            grains%force(2, grains%first + row - 1) = fy
            grains%torque(3, grains%first + row - 1) = moment
         end do
         virial(:, block) = sums
      end do
      !$omp end parallel do
   end subroutine sum_discs
end module grains_discs
