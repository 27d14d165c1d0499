! SPDX-License-Identifier: BSD-3-Clause
!> Warnings of values that suggest forgotten or mistaken units. The values are allowed.
module scene_unit_warnings
   use base_constants, only: pi
   use base_kinds, only: wp
   use base_text, only: brief
   use deck_reader, only: deck_t, group_t
   implicit none
   private

   public :: check_angles, check_friction, check_kelvin, check_material_units

   !> A key of &material, its plausible range, and the warnings outside this range.
   type :: usual_t
      character(len=14) :: key                           !! Key of &material
      real(wp) :: least                                  !! [SI]
      real(wp) :: most                                   !! [SI]
      character(len=8) :: unit                           !! Of the key
      character(len=53) :: light                         !! Warning below the range
      character(len=53) :: heavy                         !! Warning above the range
   end type usual_t

   !> Limits are the density of foam and osmium; sound speed of rubber foam and diamond; heat
   !! capacity of lead and hydrogen; the shear modulus of metals increases by a few per cent per
   !! gigapascal (D. J. Steinberg, S. G. Cochran, M. W. Guinan, J. Appl. Phys. 51 (1980) 1498).
   type(usual_t), parameter :: usual(4) = [ &
      usual_t("density       ", 15.0_wp, 2.5e4_wp, "kg/m3   ", &
      "is lighter than polystyrene [D501]", &
      "is heavier than osmium [D502]"), &
      usual_t("mg_c0         ", 20.0_wp, 5.0e4_wp, "m/s     ", &
      "is slower than a wave in soft foam [D504]", &
      "is faster than any wave in a material [D504]"), &
      usual_t("specific_heat ", 20.0_wp, 2.0e4_wp, "J/(kg K)", &
      "is less than that of any material [D504]", &
      "is more than that of hydrogen [D504]"), &
      usual_t("scg_gp        ", 0.0_wp, 1.0e-7_wp, "1/Pa    ", "", &
      "is that of a table per Mbar (6.52 is 6.52e-11) [D505]")]
   real(wp), parameter :: slowest = 0.3_wp, fastest = 5.0e4_wp !! Waves in materials [m/s]

contains

   !> Warn of implausible values of a material.
   subroutine check_material_units(deck, material)
      type(deck_t), intent(inout) :: deck
      type(group_t), intent(in) :: material              !! One material
      type(group_t) :: units
      type(usual_t) :: it
      real(wp) :: value
      character(len=:), allocatable :: what
      integer :: i

      units = deck%group("units")
      if (.not. units%valid(["system"])) return
      do i = 1, size(usual)
         it = usual(i)
         if (.not. (material%given(trim(it%key)) .and. material%known(trim(it%key)))) cycle
         call material%get(trim(it%key), value)
         what = ""
         if (value < it%least) what = trim(it%light)
         if (value < it%least .and. it%key == "density" .and. is_gas(material)) what = ""
         if (value > it%most) what = trim(it%heavy)
         if (what == "") cycle
         call deck%warn(material, trim(it%key)//" = "//brief(value)//" "//trim(it%unit)// &
            " "//what//question(deck), trim(it%key))
         if (it%key == "density") return
      end do
      call check_wave(deck, material)
      call check_kelvin(deck, material, "t_ref")
   end subroutine check_material_units

   !> True for a gas, whose density has no lower limit: by its equation of state, or as a fluid with
   !! the wave speed of a gas.
   logical function is_gas(material) result(yes)
      type(group_t), intent(in) :: material              !! One material
      real(wp), parameter :: slow = 80.0_wp, fast = 1.5e3_wp !! Waves in gases: SF6, hydrogen [m/s]
      character(len=:), allocatable :: elastic, word
      real(wp) :: bulk, density, speed

      call material%get("eos_model", word)
      yes = word == "ideal_gas"
      call material%get("elastic", elastic)
      call material%get("strength_model", word)
      if (yes .or. .not. (elastic == "none" .or. word == "newtonian")) return
      speed = 0.0_wp
      if (material%given("bulk") .and. material%known("bulk")) then
         call material%get("bulk", bulk)
         call material%get("density", density)
         speed = sqrt(bulk/density)
      end if
      yes = speed > slow .and. speed < fast
   end function is_gas

   !> Hint about units, which depends on whether the deck sets them.
   function question(deck) result(text)
      type(deck_t), intent(in) :: deck
      character(len=:), allocatable :: text, system
      type(group_t) :: units

      units = deck%group("units")
      text = "; is &units missing?"
      if (.not. units%given("system")) return
      call units%get("system", system)
      text = "; is &units system = '"//system//"' right?"
   end function question

   !> Warn of an implausible wave speed from modulus and density: a modulus in GPa, kbar or Mbar
   !! gives one.
   subroutine check_wave(deck, material)
      type(deck_t), intent(inout) :: deck
      type(group_t), intent(in) :: material              !! One material
      character(len=5), parameter :: moduli(2) = ["young", "bulk "]
      real(wp) :: density, speed, stiffness
      integer :: i

      if (.not. material%known("density")) return
      call material%get("density", density)
      do i = 1, size(moduli)
         if (.not. (material%given(trim(moduli(i))) .and. material%known(trim(moduli(i))))) cycle
         call material%get(trim(moduli(i)), stiffness)
         speed = sqrt(stiffness/density)
         if (speed >= slowest .and. speed <= fastest) cycle
         call deck%warn(material, trim(moduli(i))//" = "//brief(stiffness)// &
            " Pa with density = "//brief(density)//" kg/m3 gives a wave speed of "//brief(speed)// &
            " m/s"//question(deck)//" [D503]", trim(moduli(i)))
      end do
   end subroutine check_wave

   !> Warn of a temperature that is probably in degrees Celsius.
   subroutine check_kelvin(deck, group, key)
      type(deck_t), intent(inout) :: deck
      type(group_t), intent(in) :: group                 !! A body or material
      character(len=*), intent(in) :: key                !! Temperature
      real(wp) :: temperature

      if (.not. (group%given(key) .and. group%known(key))) return
      call group%get(key, temperature)
      if (temperature > 0.0_wp .and. temperature < 50.0_wp) call deck%warn(group, &
         key//" = "//brief(temperature)//" K: did you mean degrees Celsius ("// &
         brief(temperature + 273.15_wp)//" K)? [D507]", key)
   end subroutine check_kelvin

   !> Warn of a coefficient of friction that is probably an angle in degrees.
   subroutine check_friction(deck, group)
      type(deck_t), intent(inout) :: deck
      type(group_t), intent(in) :: group                 !! A contact or boundary
      real(wp), parameter :: most = 10.0_wp              ! coefficients of rubber reach 4
      real(wp) :: friction

      if (.not. (group%given("friction") .and. group%known("friction"))) return
      call group%get("friction", friction)
      if (friction > most .and. friction < 90.0_wp) call deck%warn(group, "friction = "// &
         brief(friction)//" is a coefficient: did you mean an angle in degrees (friction = "// &
         brief(tan(friction*pi/180.0_wp))//")? [D506]", "friction")
   end subroutine check_friction

   !> Warn of angles that are simple fractions of a turn in radians.
   subroutine check_angles(deck, region)
      type(deck_t), intent(inout) :: deck
      type(group_t), intent(in) :: region                !! One region
      real(wp), parameter :: near = 1.0e-4_wp
      real(wp) :: parts, rotate(3)
      integer :: k

      if (.not. (region%given("rotate") .and. region%known("rotate"))) return
      call region%get("rotate", rotate)
      do k = 1, 3
         if (abs(rotate(k)) <= 0.0_wp .or. abs(rotate(k)) > 7.0_wp) cycle
         parts = rotate(k)*12.0_wp/pi
         if (abs(parts - anint(parts)) > near) cycle
         call deck%warn(region, "rotate = "//brief(rotate(k))//" deg: did you mean radians ("// &
            brief(anint(parts)*15.0_wp)//" deg)? [D506]", "rotate")
         return
      end do
   end subroutine check_angles
end module scene_unit_warnings
