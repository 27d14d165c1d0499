! SPDX-License-Identifier: BSD-3-Clause
!> Forces between spheres: the loops over pairs and over grains in three dimensions.
!!
!! Equations of doc/theory/grains.md.
module grains_spheres
   use base_kinds, only: wp
   use grains_law, only: contact_law_t
   use grains_pairs, only: birth_strain, birth_time, dashpot, dashpot_loss, factor, history_words, &
      overlap, pairs_t, push_arm, push_branch, push_force, push_moment, push_words, slip_loss, &
      slips, step_loss, tangent
   use grains_state, only: block_rows, grains_t
   use mesh_box, only: box_t
   implicit none
   private

   public :: push_spheres, sum_spheres

contains

   !> Forces of all pairs, and the change of their histories over the last time step.
   subroutine push_spheres(grains, box, law, time, dt, pairs)
      type(grains_t), intent(in) :: grains !! Velocities at half step, forces before the step
      type(box_t), intent(in) :: box                 !! With the velocity gradient of the step
      type(contact_law_t), intent(in) :: law
      real(wp), intent(in) :: time                   !! At the end of the step [s]
      real(wp), intent(in) :: dt                     !! Length of the step [s]
      type(pairs_t), intent(inout) :: pairs
      real(wp) :: branch(3), reach
      integer :: pair, i, j

      !$omp parallel do default(none) shared(grains, box, law, time, dt, pairs) &
      !$omp private(pair, i, j, branch, reach) schedule(static)
      do pair = 1, pairs%count
         associate (h => box%edges, shift => pairs%shift)
            i = pairs%first(pair)
            j = pairs%second(pair)
            branch(1) = grains%position(1, j) - grains%position(1, i) + shift(1, pair)*h(1, 1) &
               + shift(2, pair)*h(1, 2) + shift(3, pair)*h(1, 3)
            branch(2) = grains%position(2, j) - grains%position(2, i) + shift(2, pair)*h(2, 2) &
               + shift(3, pair)*h(2, 3)
            branch(3) = grains%position(3, j) - grains%position(3, i) + shift(3, pair)*h(3, 3)
            reach = grains%radius(i) + grains%radius(j)
            if (branch(1)**2 + branch(2)**2 + branch(3)**2 >= reach*reach .and. &
               .not. pairs%touches(pair)) cycle
            call push_pair(grains, box, law, time, dt, i, j, branch, pairs%history(:, pair), &
               pairs%push(:, pair))
         end associate
      end do
      !$omp end parallel do
   end subroutine push_spheres

   !> Force of one pair that touches or touched in the previous step.
   ! One procedure, because all steps from overlap to force use the same intermediate values.
   pure subroutine push_pair(grains, box, law, time, dt, i, j, branch, history, push)
      type(grains_t), intent(in) :: grains
      type(box_t), intent(in) :: box
      type(contact_law_t), intent(in) :: law
      real(wp), intent(in) :: time, dt               !! [s]
      integer, intent(in) :: i, j                    !! Rows
      real(wp), intent(in) :: branch(3)              !! From i to j [m]
      real(wp), intent(inout) :: history(history_words) !! (word)
      real(wp), intent(inout) :: push(push_words)    !! (word)
      real(wp) :: distance, n(3), depth, former, arm_i, arm_j, w(3), apart, slide(3), mass, at_end
      real(wp) :: q, spring, damper, normal, across(3), kept, trial, former_spring, stiff
      real(wp) :: former_stiff, turn(3), lever(3), drift(3), way(3), from(3), force(3)
      real(wp) :: rubbed
      logical :: touches

      distance = sqrt(branch(1)**2 + branch(2)**2 + branch(3)**2)
      n = branch/distance
      depth = grains%radius(i) + grains%radius(j) - distance
      touches = depth > 0.0_wp
      arm_i = grains%radius(i) - 0.5_wp*depth
      arm_j = grains%radius(j) - 0.5_wp*depth
      associate (g => box%gradient)
         w = grains%velocity(:, j) - grains%velocity(:, i)
         w(1) = w(1) + g(1, 1)*branch(1) + g(1, 2)*branch(2) + g(1, 3)*branch(3)
         w(2) = w(2) + g(2, 2)*branch(2) + g(2, 3)*branch(3)
         w(3) = w(3) + g(3, 3)*branch(3)
         ! twice the difference between the branch moved by the cell to the end and to the middle of
         ! the step
         drift(1) = dt**2*(g(1, 1)*w(1) + g(1, 2)*w(2) + g(1, 3)*w(3))
         drift(2) = dt**2*(g(2, 2)*w(2) + g(2, 3)*w(3))
         drift(3) = dt**2*g(3, 3)*w(3)
      end associate
      way = dt*w - 0.5_wp*drift
      apart = w(1)*n(1) + w(2)*n(2) + w(3)*n(3)
      lever = grains%spin(:, i)*arm_i + grains%spin(:, j)*arm_j
      slide = dt*(w - apart*n - cross(lever, n))
      ! velocities are at the middle of the step: with the forces at its start they lead to its end
      w = w + 0.5_wp*dt*(grains%force(:, j)/grains%mass(j) - grains%force(:, i)/grains%mass(i))
      at_end = w(1)*n(1) + w(2)*n(2) + w(3)*n(3)
      former = history(overlap)
      if (.not. former > 0.0_wp) then
         former = dot_product(way, n)
         former = depth + former - 0.5_wp*(dot_product(way, way) - former**2)/distance
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
      ! the tangential force turns with the normal and about it, and keeps its length
      across = history(tangent:tangent + 2)
      kept = across(1)**2 + across(2)**2 + across(3)**2
      across = across - (across(1)*n(1) + across(2)*n(2) + across(3)*n(3))*n
      turn = grains%spin(:, i) + grains%spin(:, j)
      across = across + 0.5_wp*dt*(turn(1)*n(1) + turn(2)*n(2) + turn(3)*n(3))*cross(n, across)
      trial = across(1)**2 + across(2)**2 + across(3)**2
      if (trial > 0.0_wp) across = across*sqrt(kept/trial)
      stiff = law%tangential*q
      former_stiff = law%tangential*history(factor)
      if (former_stiff > 0.0_wp) history(slip_loss) = history(slip_loss) &
         + 0.5_wp*kept/former_stiff
      rubbed = 0.5_wp*dot_product(across, slide)
      history(step_loss) = history(step_loss) + rubbed
      ! unloading scales the force with the stiffness
      if (q < history(factor)) across = across*(q/history(factor))
      across = across - stiff*slide
      trial = sqrt(across(1)**2 + across(2)**2 + across(3)**2)
      history(slips) = 0.0_wp
      if (trial > law%friction*abs(normal)) then
         across = across*(law%friction*abs(normal)/trial)
         history(slips) = 1.0_wp
      end if
      if (.not. touches) across = 0.0_wp
      rubbed = rubbed + 0.5_wp*dot_product(across, slide)
      history(slip_loss) = history(slip_loss) - rubbed
      if (stiff > 0.0_wp .and. touches) history(slip_loss) = history(slip_loss) &
         - 0.5_wp*(across(1)**2 + across(2)**2 + across(3)**2)/stiff
      ! the remaining work of both forces over the displacement of the step, (G.6); the work of the
      ! final tangential force is its sliding, which is recorded
      from = (distance*n - way)*(1.0_wp/(distance + depth - former))
      force = (former_spring + history(dashpot))*from + history(tangent:tangent + 2)
      lever = dt*(lever - 0.5_wp*(former - depth)*turn)
      history(step_loss) = history(step_loss) - law%stored*(spring*max(depth, 0.0_wp) &
         - former_spring*max(former, 0.0_wp)) + 0.5_wp*((history(dashpot) + damper)*(former &
         - depth) - dt*normal*apart - dot_product(force, way - 0.5_wp*drift) &
         + dot_product(history(tangent:tangent + 2), cross(lever, from)))
      history(tangent:tangent + 2) = across
      history(overlap) = max(depth, 0.0_wp)
      history(dashpot) = damper
      history(factor) = merge(q, 0.0_wp, touches)
      push(push_force:push_force + 2) = normal*n + across
      push(push_moment:push_moment + 2) = cross(n, across)
      push(push_arm) = arm_i
      push(push_arm + 1) = arm_j
      push(push_branch:push_branch + 2) = branch
   end subroutine push_pair

   !> Vector product.
   pure function cross(a, b) result(c)
      real(wp), intent(in) :: a(3), b(3)
      real(wp) :: c(3)

      c(1) = a(2)*b(3) - a(3)*b(2)
      c(2) = a(3)*b(1) - a(1)*b(3)
      c(3) = a(1)*b(2) - a(2)*b(1)
   end function cross

   !> Sum of the forces on each own grain, in the order of the identities of the others, and of
   !! forces times branches over the pairs that belong to a block of rows.
   subroutine sum_spheres(pairs, grains, virial)
      type(pairs_t), intent(in) :: pairs
      type(grains_t), intent(inout) :: grains        !! Gets forces and torques
      real(wp), intent(inout) :: virial(:, :)        !! (3 (l - 1) + k, own block) F_k r_l [J]
      real(wp) :: force(3), torque(3), sums(9)
      integer :: block, row, n, pair, l

      !$omp parallel do default(none) shared(pairs, grains, virial) &
      !$omp private(block, row, n, pair, force, torque, sums, l) schedule(static)
      do block = 1, size(virial, 2)
         sums = 0.0_wp
         do row = (block - 1)*block_rows + 1, min(block*block_rows, grains%last - grains%first + 1)
            force = 0.0_wp
            torque = 0.0_wp
            do n = pairs%start(row), pairs%start(row + 1) - 1
               pair = pairs%incident(n)
               if (pair > 0) then
                  associate (push => pairs%push(:, pair))
                     force = force - push(push_force:push_force + 2)
                     torque = torque - push(push_arm)*push(push_moment:push_moment + 2)
                     do l = 1, 3
                        sums(3*l - 2:3*l) = sums(3*l - 2:3*l) &
                           + push(push_force:push_force + 2)*push(push_branch + l - 1)
                     end do
                  end associate
               else
                  associate (push => pairs%push(:, -pair))
                     force = force + push(push_force:push_force + 2)
                     torque = torque - push(push_arm + 1)*push(push_moment:push_moment + 2)
                  end associate
               end if
            end do
            grains%force(:, grains%first + row - 1) = force
            grains%torque(:, grains%first + row - 1) = torque
         end do
         virial(:, block) = sums
      end do
      !$omp end parallel do
   end subroutine sum_spheres
end module grains_spheres
