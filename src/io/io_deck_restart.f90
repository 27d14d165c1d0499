! SPDX-License-Identifier: BSD-3-Clause
!> Table of the deck keys that may change on a restart from a checkpoint, and the consequences of a
!! change.
module io_deck_restart
   use base_text, only: append, split, text_t
   implicit none
   private

   public :: change_class, table_keys

   integer, parameter, public :: may_not_change = 1      !! The state depends on the key
   integer, parameter, public :: changes_physics = 2     !! Physics of the rest of the run
   integer, parameter, public :: changes_end = 3         !! End of the run
   integer, parameter, public :: changes_extent = 4      !! Output and limits
   integer, parameter, public :: changes_nothing = 5     !! No result depends on it

   !> A group that only one of the two decks has.
   character(len=*), parameter, public :: group_added = "+", group_removed = "-"
   !> The kind of a `&boundary` that is a rigid region. Its position follows from its motion since
   !! the start, so a change of the motion would move it within one step.
   character(len=*), parameter, public :: rigid_region = "rigid"

   !> Keys of a group whose change has the same consequences.
   type :: rule_t
      character(len=10) :: group                         !! As in the deck without &
      integer :: meaning                                 !! One of the constants above
      character(len=200) :: keys                         !! Blanks between; * for all
   end type rule_t

   !> Keys that are not listed may not change: grid, dimension, bodies, material models,
   !! equations of state, keys that decide which fields particles have, and future keys.
   type(rule_t), parameter :: rules(33) = [ &
      rule_t("run", changes_nothing, "title case deck_version"), &
      rule_t("units", changes_extent, "output_units"), &
      rule_t("time", changes_end, "t_end max_steps stop_when stop_value"), &
      rule_t("time", changes_extent, "dt_min dt_collapse speed_max volume_ratio_min "// &
         "volume_ratio_max on_bad retire_max"), &
      rule_t("time", changes_physics, "cfl dt_max dt_fixed strain_max retry"), &
      rule_t("time", changes_nothing, "wall_limit"), &
      rule_t("method", changes_physics, "transfer flip order_k alpha alpha_0 blend "// &
         "free_surface normalise unseen_strain turn_from antilock"), &
      rule_t("method", changes_physics, "viscosity_limiter heat_flux split split_at split_max "// &
         "bulk_q1 bulk_q2"), &
      rule_t("effects", changes_physics, "gravity gravity_vector artificial_viscosity erosion"), &
      rule_t("material", changes_nothing, "preset"), &
      rule_t("material", changes_physics, "young poisson bulk shear viscosity spall "// &
         "conductivity t_ref t_melt yield hardening jc_a jc_b jc_n jc_c jc_m jc_rate"), &
      rule_t("material", changes_physics, "gr_tau gr_gamma_c friction_angle cohesion "// &
         "dilation_angle mu_s mu_2 mu_i0 grain_diameter grain_density"), &
      rule_t("material", changes_physics, "scg_y0 scg_ymax scg_beta scg_n scg_gp scg_gt "// &
         "scg_tm scg_a scg_gamma"), &
      rule_t("material", changes_physics, "jh2_a jh2_n jh2_b jh2_m jh2_fmax jh2_c jh2_rate "// &
         "jh2_t jh2_d1 jh2_d2 jh2_beta jcd"), &
      rule_t("material", changes_physics, "failure_stress failure_shear failure_strain "// &
         "failure_delay failure_delay_power fracture_energy softening crack_speed"), &
      rule_t("material", changes_physics, "failed_friction_angle failed_tau failed_gamma_c "// &
         "b_shear b_thermal"), &
      ! a region has an effect only through the group that uses it, and that group has its own rules
      rule_t("region", changes_nothing, group_added//" "//group_removed), &
      rule_t("region", changes_physics, "file"), &
      rule_t("boundary", changes_physics, "face region type velocity table friction t_on t_off "// &
         "temperature "//group_added//" "//group_removed), &
      rule_t(rigid_region, changes_physics, "friction t_off temperature "// &
         group_added//" "//group_removed), &
      rule_t("contact", changes_physics, "friction bond_strength"), &
      rule_t("inflow", changes_physics, "t_off"), &
      rule_t("grains", changes_physics, "friction restitution"), &
      rule_t("cell", changes_physics, "pressure skin"), &
      rule_t("stage", changes_physics, "*"), &
      rule_t("stage", changes_end, group_added), &
      rule_t("output", changes_extent, "* "//group_added//" "//group_removed), &
      rule_t("checkpoint", changes_nothing, "*"), &
      rule_t("parallel", changes_nothing, "*"), &
      rule_t("log", changes_nothing, "*"), &
      rule_t("point", changes_nothing, "*"), &
      ! always 'si' in the echo
      rule_t("units", changes_nothing, "system"), &
      rule_t("grid", may_not_change, "*")]

contains

   !> Meaning of a change of a key on a restart.
   pure integer function change_class(group, key) result(meaning)
      character(len=*), intent(in) :: group              !! Kind of group, or `rigid_region`
      character(len=*), intent(in) :: key                !! Key, `group_added` or `group_removed`
      integer :: n

      meaning = may_not_change
      do n = 1, size(rules)
         if (rules(n)%group /= group) cycle
         if (index(" "//rules(n)%keys, " "//key//" ") > 0 .or. rules(n)%keys(:1) == "*") &
            meaning = rules(n)%meaning
      end do
   end function change_class

   !> All names in the table as group.key, for a test that the schema has them.
   subroutine table_keys(names)
      type(text_t), allocatable, intent(out) :: names(:) !! Without *, + and -
      type(text_t), allocatable :: keys(:)
      integer :: k, n

      allocate (names(0))
      do n = 1, size(rules)
         call split(trim(rules(n)%keys), keys)
         do k = 1, size(keys)
            if (scan(keys(k)%text, "*+-") > 0) cycle
            if (rules(n)%group == rigid_region) then
               call append(names, "boundary."//keys(k)%text)
            else
               call append(names, trim(rules(n)%group)//"."//keys(k)%text)
            end if
         end do
      end do
   end subroutine table_keys
end module io_deck_restart
