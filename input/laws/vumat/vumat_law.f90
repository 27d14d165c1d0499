! SPDX-License-Identifier: BSD-3-Clause
!> Makes a library with a strength law of a subroutine VUMAT, as Abaqus/Explicit calls it.
!!
!!     gfortran -O2 -ffp-contract=off -fPIC -shared -I FOLDER scree_law.f90 my_names.f90 \
!!        vumat_law.f90 my_vumat.for -o my_vumat.so
!!
!! `my_names.f90` is a module vumat_names with two texts: `cmname`, the name of the material, and
!! `names`, lines 'constant NAME [UNIT] : meaning' for props and 'field NAME [UNIT] : meaning' for
!! the state variables, in their order.
!!
!! The subroutine gets components in a frame that turns with each particle: its rotation is stored
!! as a quaternion, and follows the spin (Jaumann), not the polar decomposition that Abaqus uses.
!! Tensors in the state variables and anisotropy turn with it. Always three direct and three shear
!! components, 11, 22, 33, 12, 23, 31, the order of Scree. The time is that of the particle.
!! stretchOld, stretchNew, defgradOld, defgradNew and coordMp are NaN, there are no field variables,
!! and charLength is the cube root of the volume.
module vumat_law
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use, intrinsic :: iso_c_binding, only: c_double, c_int32_t, c_int64_t, c_loc, c_null_char, c_ptr
   use scree_law, only: scree_column, scree_history, scree_law_version, scree_rows_t
   use vumat_names, only: cmname, names
   implicit none
   private

   integer, parameter :: wp = c_double
   integer, parameter :: most_rows = 136             !! maxblk of vaba_param.inc
   character(len=*), parameter :: line = new_line("a")
   !> Fields of the adapter, in front of the state variables.
   character(len=*), parameter :: head = line//"stress whole"//line// &
      "field vumat_q0 [1] start 1 : rotation of the frame, quaternion"//line// &
      "field vumat_q1 [1] : rotation of the frame, quaternion"//line// &
      "field vumat_q2 [1] : rotation of the frame, quaternion"//line// &
      "field vumat_q3 [1] : rotation of the frame, quaternion"//line// &
      "field vumat_time [s] : time of the particle"//line// &
      "field vumat_energy [J/kg] : enerInternNew"//line// &
      "field vumat_inelastic [J/kg] : enerInelasNew"//line
   integer, parameter :: adapter_fields = 7
   !> Written once, when the library is loaded.
   character(len=65536), target, save :: declaration
   integer, save :: nprops = 0, nstatev = 0

   external :: vumat

contains

   !> Version of the interface.
   function law_interface() bind(c, name="scree_law_interface") result(version)
      integer(c_int32_t) :: version

      version = scree_law_version
   end function law_interface

   !> Constants and fields.
   function law_declaration() bind(c, name="scree_law_declaration") result(text)
      type(c_ptr) :: text

      declaration = "law "//trim(cmname)//head//trim(names)//line//c_null_char
      nprops = lines("constant ")
      nstatev = lines("field ")
      text = c_loc(declaration)
   end function law_declaration

   !> Lines of the names that begin with a word.
   function lines(word) result(count)
      character(len=*), intent(in) :: word
      integer :: count
      integer :: at, place

      count = 0
      at = 1
      do
         place = index(line//names(at:), line//word)
         if (place == 0) return
         count = count + 1
         at = at + place - 1 + len(word)
      end do
   end function lines

   !> Call the subroutine for the rows, in blocks.
   subroutine law_update(rows) bind(c, name="scree_law_update")
      type(scree_rows_t), intent(inout) :: rows
      integer :: first

      do first = 1, int(rows%count), most_rows
         call update_block(rows, first - 1, min(most_rows, int(rows%count) - first + 1))
      end do
   end subroutine law_update

   !> Call the subroutine for some rows.
   subroutine update_block(rows, before, n)
      type(scree_rows_t), intent(inout) :: rows
      integer, intent(in) :: before                  !! Rows before the block
      integer, intent(in) :: n                       !! Rows of the block
      real(wp), dimension(n) :: length, density, warm, inner, inelastic, inner_new, inelastic_new
      real(wp) :: strain(n, 6), old(n, 6), new(n, 6), state(n, nstatev), state_new(n, nstatev)
      real(wp) :: turn(3, 3, n), none(n, 9), spin(n, 3), field(n, 1)
      real(wp), pointer :: volume(:), mass(:), temperature(:), time(:), values(:), props(:)
      integer :: i, k

      call turn_frames(rows, before, n, turn)
      volume => scree_column(rows%volume, rows%count)
      mass => scree_column(rows%mass, rows%count)
      temperature => scree_column(rows%temperature, rows%count)
      props => scree_column(rows%constants, int(nprops, c_int64_t))
      time => scree_history(rows, 5)
      call read_rows(rows, before, n, turn, strain, old)
      do i = 1, n
         length(i) = volume(before + i)**(1.0_wp/3.0_wp)
         density(i) = mass(before + i)/volume(before + i)
         time(before + i) = time(before + i) + rows%dt
      end do
      warm = 0.0_wp
      if (associated(temperature)) warm = temperature(before + 1:before + n)
      values => scree_history(rows, 6)
      inner = values(before + 1:before + n)
      values => scree_history(rows, 7)
      inelastic = values(before + 1:before + n)
      do k = 1, nstatev
         values => scree_history(rows, adapter_fields + k)
         state(:, k) = values(before + 1:before + n)
      end do
      none = ieee_value(1.0_wp, ieee_quiet_nan)
      spin = 0.0_wp
      field = 0.0_wp
      new = old
      state_new = state
      inner_new = inner
      inelastic_new = inelastic
      call vumat(n, 3, 3, nstatev, 0, nprops, 0, time(before + 1), time(before + 1), rows%dt, &
         padded(cmname), none, length, props, density, strain, spin, warm, none, none, field, old, &
         state, inner, inelastic, warm, none, none, field, new, state_new, inner_new, &
         inelastic_new)
      call write_stress(rows, before, n, turn, new)
      values => scree_history(rows, 6)
      values(before + 1:before + n) = inner_new
      values => scree_history(rows, 7)
      values(before + 1:before + n) = inelastic_new
      do k = 1, nstatev
         values => scree_history(rows, adapter_fields + k)
         values(before + 1:before + n) = state_new(:, k)
      end do
   end subroutine update_block

   !> Turn the frames by the spin of the step, and give their rotations.
   subroutine turn_frames(rows, before, n, turn)
      type(scree_rows_t), intent(in) :: rows
      integer, intent(in) :: before, n
      real(wp), intent(out) :: turn(3, 3, n)         !! Columns are the axes of the frame
      real(wp), pointer :: q0(:), q1(:), q2(:), q3(:), zy(:), yz(:), xz(:), zx(:), yx(:), xy(:)
      real(wp) :: q(4), w(3), a, b, c, d
      integer :: i, k

      q0 => scree_history(rows, 1)
      q1 => scree_history(rows, 2)
      q2 => scree_history(rows, 3)
      q3 => scree_history(rows, 4)
      yx => scree_column(rows%gradient(2), rows%count)
      zx => scree_column(rows%gradient(3), rows%count)
      xy => scree_column(rows%gradient(4), rows%count)
      zy => scree_column(rows%gradient(6), rows%count)
      xz => scree_column(rows%gradient(7), rows%count)
      yz => scree_column(rows%gradient(8), rows%count)
      do i = 1, n
         k = before + i
         ! quaternion (1, w/2) of the rotation of the step with the spin w
         w = 0.25_wp*[zy(k) - yz(k), xz(k) - zx(k), yx(k) - xy(k)]
         a = q0(k)
         b = q1(k)
         c = q2(k)
         d = q3(k)
         q = [a - w(1)*b - w(2)*c - w(3)*d, b + w(1)*a + w(2)*d - w(3)*c, &
            c + w(2)*a + w(3)*b - w(1)*d, d + w(3)*a + w(1)*c - w(2)*b]
         q = q/sqrt(q(1)*q(1) + q(2)*q(2) + q(3)*q(3) + q(4)*q(4))
         q0(k) = q(1)
         q1(k) = q(2)
         q2(k) = q(3)
         q3(k) = q(4)
         turn(:, 1, i) = [1.0_wp - 2.0_wp*(q(3)*q(3) + q(4)*q(4)), &
            2.0_wp*(q(2)*q(3) + q(1)*q(4)), 2.0_wp*(q(2)*q(4) - q(1)*q(3))]
         turn(:, 2, i) = [2.0_wp*(q(2)*q(3) - q(1)*q(4)), &
            1.0_wp - 2.0_wp*(q(2)*q(2) + q(4)*q(4)), 2.0_wp*(q(3)*q(4) + q(1)*q(2))]
         turn(:, 3, i) = [2.0_wp*(q(2)*q(4) + q(1)*q(3)), 2.0_wp*(q(3)*q(4) - q(1)*q(2)), &
            1.0_wp - 2.0_wp*(q(2)*q(2) + q(3)*q(3))]
      end do
   end subroutine turn_frames

   !> Strain increments and stresses in the frames.
   subroutine read_rows(rows, before, n, turn, strain, stress)
      type(scree_rows_t), intent(in) :: rows
      integer, intent(in) :: before, n
      real(wp), intent(in) :: turn(3, 3, n)
      real(wp), intent(out) :: strain(n, 6), stress(n, 6)
      real(wp), pointer :: values(:)
      real(wp) :: g(n, 9), s(n, 6), whole(3, 3)
      integer :: i, k

      do k = 1, 9
         values => scree_column(rows%gradient(k), rows%count)
         g(:, k) = values(before + 1:before + n)
      end do
      do k = 1, 6
         values => scree_column(rows%stress(k), rows%count)
         s(:, k) = values(before + 1:before + n)
      end do
      do i = 1, n
         whole = reshape(g(i, :), [3, 3])
         whole = 0.5_wp*(whole + transpose(whole))
         strain(i, :) = components(matmul(transpose(turn(:, :, i)), matmul(whole, turn(:, :, i))))
         stress(i, :) = components(matmul(transpose(turn(:, :, i)), matmul(full(s(i, :)), &
            turn(:, :, i))))
      end do
   end subroutine read_rows

   !> Stresses of the frames to the rows.
   subroutine write_stress(rows, before, n, turn, stress)
      type(scree_rows_t), intent(in) :: rows
      integer, intent(in) :: before, n
      real(wp), intent(in) :: turn(3, 3, n)
      real(wp), intent(in) :: stress(n, 6)
      real(wp), pointer :: values(:)
      real(wp) :: s(n, 6)
      integer :: i, k

      do i = 1, n
         s(i, :) = components(matmul(turn(:, :, i), matmul(full(stress(i, :)), &
            transpose(turn(:, :, i)))))
      end do
      do k = 1, 6
         values => scree_column(rows%stress(k), rows%count)
         values(before + 1:before + n) = s(:, k)
      end do
   end subroutine write_stress

   !> Components 11, 22, 33, 12, 23, 31 of a symmetric matrix.
   pure function components(matrix) result(tensor)
      real(wp), intent(in) :: matrix(3, 3)
      real(wp) :: tensor(6)

      tensor = [matrix(1, 1), matrix(2, 2), matrix(3, 3), matrix(1, 2), matrix(2, 3), matrix(1, 3)]
   end function components

   !> The matrix of components.
   pure function full(tensor) result(matrix)
      real(wp), intent(in) :: tensor(6)
      real(wp) :: matrix(3, 3)

      matrix = reshape([tensor(1), tensor(4), tensor(6), tensor(4), tensor(2), tensor(5), &
         tensor(6), tensor(5), tensor(3)], [3, 3])
   end function full

   !> A name in the 80 letters that the subroutine expects.
   pure function padded(name) result(text)
      character(len=*), intent(in) :: name
      character(len=80) :: text

      text = name
   end function padded
end module vumat_law
