! SPDX-License-Identifier: BSD-3-Clause
!> Tests of a strength law in a library on a few particles, before a run: finite stresses, the same
!! bits when repeated and for any division of the particles into calls, no change outside of the
!! rows of a call, and no dependence on the orientation.
module material_library_contract
   use base_constants, only: symmetric
   use base_error, only: without_code
   use base_kinds, only: int64, wp
   use base_text, only: brief, number
   use material_models, only: models_t
   use material_state, only: deformation_t, material_state_t
   implicit none
   private

   public :: test_library

   integer, parameter :: particles = 24              !! Of a test
   integer, parameter :: steps = 12                  !! Of a path
   real(wp), parameter :: smallest = 1.0e-6_wp       !! Gradient of the first particle in a step
   real(wp), parameter :: growth = 1.55_wp           !! From one particle to the next
   real(wp), parameter :: duration = 1.0e-6_wp       !! Time step [s]
   real(wp), parameter :: close_to = 1.0e-6_wp       !! Tolerance of turned stresses

contains

   !> Test the law of a material that is in a library.
   subroutine test_library(material, fails, remark)
      class(models_t), intent(in) :: material        !! With a law in a library
      character(len=:), allocatable, intent(out) :: fails !! Empty if the law passes
      character(len=:), allocatable, intent(out) :: remark !! Empty if there is none
      real(wp) :: paths(particles, 9, steps)
      type(material_state_t) :: first, other

      call make_paths(paths)
      remark = ""
      call drive(material, paths, particles, first, fails)
      if (fails == "") call check_finite(material, paths, first, fails)
      if (fails /= "") return
      call drive(material, paths, particles, other, fails)
      if (differ(first, other, 1, particles)) fails = "the same particles on the same path "// &
         "end in other stresses or fields the second time; the library must not keep anything "// &
         "between calls"
      if (fails /= "") return
      call drive(material, paths, 5, other, fails)
      if (fails /= "") return
      if (differ(first, other, 1, particles)) fails = "calls with 5 rows give other bits than "// &
         "one call with all; a row must not depend on other rows or on their number"
      if (fails /= "") return
      call drive(material, paths(particles:1:-1, :, :), particles, other, fails)
      call reverse(other)
      if (differ(first, other, 1, particles)) fails = "rows in reverse order have other bits; "// &
         "a row must not depend on the rows before it"
      if (fails == "") call check_turned(material, paths, first, remark)
   end subroutine test_library

   !> Velocity gradients times time steps that change direction and grow from particle to particle.
   pure subroutine make_paths(paths)
      real(wp), intent(out) :: paths(particles, 9, steps) !! Of k + 3 (l - 1) [1]
      real(wp), parameter :: golden = 0.61803398874989485_wp
      integer :: component, i, n

      do n = 1, steps
         do component = 1, 9
            do i = 1, particles
               ! the fractions of multiples of an irrational number are even and always the same
               paths(i, component, n) = 2.0_wp*modulo(golden*real(i + 7*component &
                  + 31*((n + 3)/4), wp), 1.0_wp) - 1.0_wp
               paths(i, component, n) = paths(i, component, n)*smallest*growth**(i - 1)
            end do
         end do
      end do
   end subroutine make_paths

   !> Drive particles along paths, in calls of some rows; a fails if a call changes other rows.
   subroutine drive(material, paths, rows, state, fails)
      class(models_t), intent(in) :: material
      real(wp), intent(in) :: paths(:, :, :)         !! (particle, 9, step) [1]
      integer, intent(in) :: rows                    !! Rows of a call
      type(material_state_t), intent(out) :: state   !! At the end
      character(len=:), allocatable, intent(out) :: fails !! Empty if there is none
      type(material_state_t) :: before
      type(deformation_t) :: deformation
      real(wp) :: temperature
      integer :: begin, final, n

      fails = ""
      temperature = 293.0_wp
      if (allocated(material%heat)) temperature = material%heat%reference
      call material%allocate_state(state, particles)
      state%volume = 1.0e-9_wp
      state%mass = material%density*state%volume
      call material%start(state, 1, particles, temperature)
      call deformation%reserve(rows)
      do n = 1, steps
         do begin = 1, particles, rows
            final = min(begin + rows - 1, particles)
            before = state
            deformation%gradient(:final - begin + 1, :) = paths(begin:final, :, n)
            call step_rows(material, begin, final, state, deformation)
            if (differ(before, state, 1, begin - 1) .or. differ(before, state, final + 1, &
               particles)) fails = "a call changes the stress or a field of particles that are "// &
               "not in its rows"
            if (fails /= "") return
         end do
      end do
   end subroutine drive

   !> One step of some particles, with a pressure in rate form.
   subroutine step_rows(material, first, last, state, deformation)
      class(models_t), intent(in) :: material
      integer, intent(in) :: first, last             !! Particles of the call
      type(material_state_t), intent(inout) :: state
      type(deformation_t), intent(inout) :: deformation !! With the gradient
      integer :: count, n

      count = last - first + 1
      deformation%plastic_work(:count) = 0.0_wp
      deformation%plastic_increment(:count) = 0.0_wp
      call material%law%predict_trial(state, deformation, first, last)
      deformation%pressure(:count) = deformation%pressure(:count) &
         - merge(0.0_wp, material%bulk, material%has_whole_stress())*deformation%dilatation(:count)
      if (allocated(state%viscous_pressure)) state%viscous_pressure(first:last) = 0.0_wp
      call material%law%update(state, deformation, first, last, duration)
      do n = 1, 3
         state%stress(first:last, n) = state%stress(first:last, n) - deformation%pressure(:count)
      end do
   end subroutine step_rows

   !> Check that all stresses and fields are finite.
   subroutine check_finite(material, paths, state, fails)
      class(models_t), intent(in) :: material
      real(wp), intent(in) :: paths(:, :, :)         !! (particle, 9, step) [1]
      type(material_state_t), intent(in) :: state    !! At the end
      character(len=:), allocatable, intent(inout) :: fails !! Empty if they are
      character(len=:), allocatable :: reason
      logical :: good
      integer :: i, n

      do i = 1, particles
         good = all(abs(state%stress(i, :)) <= huge(1.0_wp))
         do n = 1, size(state%own)
            good = good .and. abs(state%own(n)%values(i)) <= huge(1.0_wp)
         end do
         if (good) cycle
         fails = "after "//number(steps)//" steps with strains up to "// &
            brief(maxval(abs(paths(i, :, :))))//" a stress or a field is not a finite number"
         reason = without_code(material%law%fault_of_state(state, i))
         if (len(reason) > 0) fails = fails//"; "//reason
         return
      end do
   end subroutine check_finite

   !> True if some bits of stresses or fields differ between two states.
   logical function differ(one, other, first, last) result(yes)
      type(material_state_t), intent(in) :: one, other
      integer, intent(in) :: first, last             !! Particles
      integer :: n

      yes = .false.
      do n = 1, 6
         yes = yes .or. any(transfer(one%stress(first:last, n), [1_int64]) /= &
            transfer(other%stress(first:last, n), [1_int64]))
      end do
      do n = 1, size(one%own)
         yes = yes .or. any(transfer(one%own(n)%values(first:last), [1_int64]) /= &
            transfer(other%own(n)%values(first:last), [1_int64]))
      end do
      if (allocated(one%plastic_strain)) yes = yes .or. any(transfer(one%plastic_strain( &
         first:last), [1_int64]) /= transfer(other%plastic_strain(first:last), [1_int64]))
   end function differ

   !> Put particles in reverse order.
   subroutine reverse(state)
      type(material_state_t), intent(inout) :: state
      integer :: n

      do n = 1, 6
         call reverse_values(state%stress(:, n))
      end do
      do n = 1, size(state%own)
         call reverse_values(state%own(n)%values)
      end do
      if (allocated(state%plastic_strain)) call reverse_values(state%plastic_strain)
   end subroutine reverse

   !> Put values in reverse order.
   pure subroutine reverse_values(values)
      real(wp), contiguous, intent(inout) :: values(:)
      real(wp) :: kept
      integer :: i, last

      do i = 1, size(values)/2
         last = size(values) + 1 - i
         kept = values(i)
         values(i) = values(last)
         values(last) = kept
      end do
   end subroutine reverse_values

   !> Compare with the same paths in a turned frame: the stresses turn with it, unless the material
   !! is anisotropic.
   subroutine check_turned(material, paths, state, remark)
      class(models_t), intent(in) :: material
      real(wp), intent(in) :: paths(:, :, :)         !! (particle, 9, step) [1]
      type(material_state_t), intent(in) :: state    !! Their end
      character(len=:), allocatable, intent(inout) :: remark !! Empty if they do
      !> A rotation about the direction (1, 2, 2).
      real(wp), parameter :: turn(3, 3) = reshape([-7.0_wp, 4.0_wp, 4.0_wp, 4.0_wp, -1.0_wp, &
         8.0_wp, 4.0_wp, 8.0_wp, -1.0_wp]/9.0_wp, [3, 3])
      real(wp) :: turned(particles, 9, steps), whole(3, 3), other(3, 3)
      type(material_state_t) :: ended
      character(len=:), allocatable :: fails
      integer :: i, n

      do n = 1, steps
         do i = 1, particles
            turned(i, :, n) = reshape(matmul(turn, matmul(reshape(paths(i, :, n), [3, 3]), &
               transpose(turn))), [9])
         end do
      end do
      call drive(material, turned, particles, ended, fails)
      do i = 1, particles
         whole = full(state%stress(i, :))
         other = full(ended%stress(i, :))
         whole = matmul(turn, matmul(whole, transpose(turn)))
         if (maxval(abs(other - whole)) <= close_to*maxval(abs(whole))) cycle
         remark = "the stress depends on the orientation: on paths in a turned frame with "// &
            "strains up to "//brief(maxval(abs(paths(i, :, :))))//" it differs by "// &
            brief(maxval(abs(other - whole))/maxval(abs(whole)))//" of its largest component; "// &
            "only an anisotropic law may do so"
         return
      end do
   end subroutine check_turned

   !> A symmetric tensor as a matrix.
   pure function full(tensor) result(matrix)
      real(wp), intent(in) :: tensor(:)              !! xx, yy, zz, xy, yz, xz
      real(wp) :: matrix(3, 3)

      matrix = reshape(tensor(reshape(symmetric, [9])), [3, 3])
   end function full
end module material_library_contract
