! SPDX-License-Identifier: BSD-3-Clause
!> Defaults of &method that depend on other keys and on the material, and checks of incompatible
!! keys. All defaults come from measurements: see doc/theory/methods_compared.md.
module scene_method_defaults
   use base_kinds, only: wp
   use base_text, only: text_t
   use deck_reader, only: deck_t, group_t
   use ddmp_catalogue, only: choose_quadrature
   use ddmp_quadrature, only: quadrature_t
   use material_kinds, only: kinds_t
   use scene_cell, only: has_cell, set_cell_defaults
   use scene_dimension, only: is_axisymmetric, is_dual
   use step_method, only: stress_after, stress_average, stress_names, stress_remapped
   use transfer_catalogue, only: choose_velocity
   use transfer_velocity, only: velocity_t
   implicit none
   private

   public :: set_method_defaults

   real(wp), parameter :: weak = 0.06_wp             !! Linear viscosity in gases [1]

contains

   !> Set the defaults of &method that depend on other keys and on the material, and refuse
   !! incompatible keys.
   subroutine set_method_defaults(deck, kinds)
      type(deck_t), intent(inout) :: deck            !! The deck, gets defaults and complaints
      type(kinds_t), intent(in) :: kinds           !! Kinds of the materials
      logical :: averages, controls, axisymmetric, dual

      axisymmetric = is_axisymmetric(deck)
      dual = is_dual(deck)
      averages = .false.
      if (kinds%keeps) averages = may_average(deck)
      controls = .false.
      if (averages .and. kinds%stored .and. .not. axisymmetric) then
         controls = may_control(deck)
         averages = controls
      end if
      if (averages) call set_average_defaults(deck, controls)
      if (averages .and. .not. kinds%stored) then
         if (.not. requests_sums(deck%group("method", 1))) call set_viscosity(deck, 0.22_wp, &
            "smooth", kinds)
      else if (kinds%condensed .and. dual) then
         call set_viscosity(deck, 0.7_wp, "monotone", kinds)
      end if
      call set_dependent_defaults(deck, averages)
      call set_cell_defaults(deck)
      if (kinds%stored .and. .not. averages) call set_contact_default(deck)
      if (has_average(deck)) then
         if (kinds%stored .and. .not. axisymmetric) call set_elastic_defaults(deck)
         call set_axial_default(deck)
         call set_turn_default(deck)
      end if
      call check_normalise(deck)
      if (kinds%some_gas()) call set_split_default(deck, kinds%gases)
   end subroutine set_method_defaults

   !> Solids and liquids without internal energy keep their energy with the strain of two
   !! velocities (usavg). Other updates damp collisions and vibrations, and nothing records the
   !! loss. In elastic material the mean stress of the nodes (control) removes the noise that usavg
   !! does not damp; other material fails, flows or is too stiff for the strains of several percent
   !! that make it. In axisymmetry particles in the middle of their rings give the axis an eighth
   !! too much mass; the noise of that is damped (flip), not averaged.
   !! doc/theory/methods_compared.md
   subroutine set_average_defaults(deck, controls)
      type(deck_t), intent(inout) :: deck            !! The deck, gets the defaults
      logical, intent(in) :: controls                !! Is the mean stress of the nodes used?
      type(group_t) :: group

      group = deck%group("method", 1)
      if (.not. group%given("stress_update")) call deck%set_default("method", 1, "stress_update", &
         trim(stress_names(stress_average)))
      if (controls .and. .not. group%given("quadrature")) &
         call deck%set_default("method", 1, "quadrature", "control")
   end subroutine set_average_defaults

   !> Shocks overshoot and ring if the linear viscosity is weak: the quadratic one does not reach
   !! weak shocks, and the strain of two velocities does not damp. A strong linear viscosity that
   !! resists jumps alone prevents this, and damps smooth waves less than a weak one that resists
   !! all compression. Condensed material with an internal energy, which takes up its work, gets
   !! more of it, with a limiter that resists less of smooth waves; where the strain is that of two
   !! velocities that limiter lets weak shocks ring. Gases have strong shocks, and normalised sums
   !! with a limiter of their own. doc/theory/viscosity.md
   subroutine set_viscosity(deck, linear, limiter, kinds)
      type(deck_t), intent(inout) :: deck            !! The deck, gets the defaults
      real(wp), intent(in) :: linear                 !! Coefficient of the linear viscosity [1]
      character(len=*), intent(in) :: limiter        !! Limiter of the viscosity
      type(kinds_t), intent(in) :: kinds             !! Kinds of the materials
      integer :: n
      logical :: acts
      type(group_t) :: effects, group

      effects = deck%group("effects", 1)
      call effects%get("artificial_viscosity", acts)
      group = deck%group("method", 1)
      if (.not. acts .or. group%given("bulk_q1") .or. group%given("viscosity_limiter")) return
      call deck%set_default("method", 1, "bulk_q1", linear)
      call deck%set_default("method", 1, "viscosity_limiter", limiter)
      if (.not. kinds%some_gas()) return
      do n = 1, size(kinds%gas)
         group = deck%group("material", n)
         if (kinds%gas(n) .and. .not. group%given("bulk_q1")) call deck%set_default("material", n, &
            "bulk_q1", weak)
      end do
   end subroutine set_viscosity

   !> Is the strain that of two velocities, by the deck or by a default that is set?
   logical function has_average(deck) result(has)
      type(deck_t), intent(in) :: deck
      character(len=:), allocatable :: word
      type(group_t) :: group

      group = deck%group("method", 1)
      call group%get("stress_update", word)
      has = word == stress_names(stress_average)
   end function has_average

   !> Do the keys of the deck allow the strain of two velocities?
   logical function may_average(deck) result(may)
      type(deck_t), intent(in) :: deck
      class(velocity_t), allocatable :: transfer
      character(len=:), allocatable :: word
      logical :: paper, parts, cell
      type(group_t) :: group

      group = deck%group("method", 1)
      call group%get("paper", paper)
      call find_transfer(group, transfer)
      parts = has_self_contact(deck)
      cell = has_cell(deck)
      may = .false.
      if (.not. is_dual(deck) .or. paper .or. parts .or. cell .or. transfer%filters()) return
      if (transfer%affine() .and. .not. transfer%turning()) return
      call group%get("turn_from", word)
      if (group%given("turn_from") .and. word /= "tiles") return
      if (group%given("stress_update")) then
         call group%get("stress_update", word)
         if (word /= stress_names(stress_average)) return
      end if
      may = .true.
   end function may_average

   !> Do they allow a mean stress of the nodes?
   logical function may_control(deck) result(may)
      type(deck_t), intent(in) :: deck
      class(quadrature_t), allocatable :: rule
      character(len=:), allocatable :: word, surface
      type(group_t) :: group

      group = deck%group("method", 1)
      call group%get("free_surface", surface)
      may = .false.
      if (surface /= "fill") return
      if (requests_sums(group)) return
      if (group%given("quadrature")) then
         call group%get("quadrature", word)
         call choose_quadrature(word, rule)
         if (.not. allocated(rule)) return
         if (.not. rule%controlled()) return
      end if
      may = .true.
   end function may_control

   !> Does the deck itself request normalised sums?
   logical function requests_sums(group) result(yes)
      type(group_t), intent(in) :: group             !! &method
      character(len=:), allocatable :: word

      call group%get("normalise", word)
      yes = group%given("normalise") .and. word /= "none"
   end function requests_sums

   !> Has some body contact with itself? Its two velocities need the point rule.
   logical function has_self_contact(deck) result(has)
      type(deck_t), intent(in) :: deck
      type(text_t), allocatable :: names(:)
      type(group_t) :: group
      integer :: n

      has = .false.
      do n = 1, deck%count("contact")
         group = deck%group("contact", n)
         call group%list("bodies", names)
         if (size(names) == 2) has = has .or. names(1)%text == names(2)%text
      end do
   end function has_self_contact

   !> Set the defaults that depend on other keys.
   subroutine set_dependent_defaults(deck, averages)
      type(deck_t), intent(inout) :: deck
      logical, intent(in) :: averages                !! Is the update of the stress known?
      character(len=:), allocatable :: alpha
      class(velocity_t), allocatable :: transfer
      logical :: axisymmetric, paper, may, limits
      type(group_t) :: group

      group = deck%group("method", 1)
      call group%get("paper", paper)
      if (.not. is_dual(deck)) then
         if (.not. group%given("transfer")) call deck%set_default("method", 1, "transfer", "flip")
         if (.not. group%given("stress_update")) &
            call deck%set_default("method", 1, "stress_update", trim(stress_names(stress_remapped)))
         return
      end if
      may = may_normalise(deck)
      limits = limits_all(deck, averages)
      if (.not. group%given("normalise") .and. (limits .or. .not. may)) &
         call deck%set_default("method", 1, "normalise", "none")
      if (paper) then
         call set_paper_defaults(deck, group)
         return
      end if
      call group%get("alpha", alpha)
      axisymmetric = is_axisymmetric(deck)
      if (.not. group%given("blend")) call deck%set_default("method", 1, "blend", &
         trim(merge("smooth", "linear", alpha == "split" .and. .not. axisymmetric)))
      call find_transfer(group, transfer)
      ! a whole linear velocity field of the particles gains energy without bound with usl
      if (averages .or. group%given("stress_update")) return
      call deck%set_default("method", 1, "stress_update", &
         trim(stress_names(merge(stress_remapped, stress_after, &
         transfer%affine() .and. .not. transfer%turning()))))
   end subroutine set_dependent_defaults

   !> The transfer that the deck names; that of FLIP if the word is wrong.
   subroutine find_transfer(group, transfer)
      type(group_t), intent(in) :: group             !! &method
      class(velocity_t), allocatable, intent(out) :: transfer
      character(len=:), allocatable :: word

      call group%get("transfer", word)
      call choose_velocity(word, transfer)
      if (.not. allocated(transfer)) call choose_velocity("flip", transfer)
   end subroutine find_transfer

   !> In contact, elastic bodies are strained with the velocities of their particles (musl):
   !! straining with the node velocities dissipates 3 to 5 % of their energy in a collision.
   !! Transfers that filter the velocities dissipate more with musl. Equation (C.8) of
   !! doc/theory/contact.md.
   subroutine set_contact_default(deck)
      type(deck_t), intent(inout) :: deck            !! The deck, gets the default
      class(velocity_t), allocatable :: transfer
      logical :: acts, paper
      type(group_t) :: effects, group

      group = deck%group("method", 1)
      call group%get("paper", paper)
      if (paper .or. group%given("stress_update") .or. deck%count("body") < 2) return
      call find_transfer(group, transfer)
      if (transfer%filters()) return
      effects = deck%group("effects", 1)
      call effects%get("contact", acts)
      if (acts) call deck%set_default("method", 1, "stress_update", &
         trim(stress_names(stress_remapped)))
   end subroutine set_contact_default

   !> With two velocities (usavg) elastic material conserves all of its energy by default: it needs
   !! no filter of the velocities. In material that flows the filter removes motion of particles
   !! that nodes do not resolve, and the ledger records its energy; without it the run-out of
   !! columns of grains depends on the cells.
   subroutine set_elastic_defaults(deck)
      type(deck_t), intent(inout) :: deck
      type(group_t) :: group

      group = deck%group("method", 1)
      if (.not. group%given("flip")) call deck%set_default("method", 1, "flip", 1.0_wp)
   end subroutine set_elastic_defaults

   !> In axisymmetry with two velocities (usavg) particles have no rotation by default: a rotation
   !! in the plane of axis and radius turns rings inside out, which is no motion without strain, and
   !! its mean over a tile creates energy in bodies of few cells.
   subroutine set_axial_default(deck)
      type(deck_t), intent(inout) :: deck
      type(group_t) :: group

      group = deck%group("method", 1)
      if (group%given("transfer")) return
      if (is_axisymmetric(deck)) call deck%set_default("method", 1, "transfer", "flip")
   end subroutine set_axial_default

   !> With two velocities the default rotation is that of the surroundings, because the rotation of
   !! single particles creates energy: the stress works with the velocities of their linear fields,
   !! which the kinetic energy of particles does not include. A whole linear field has no smooth
   !! part that could replace it, so transfers with such fields are refused.
   subroutine set_turn_default(deck)
      type(deck_t), intent(inout) :: deck
      character(len=:), allocatable :: word, turn
      class(velocity_t), allocatable :: transfer
      type(group_t) :: group

      group = deck%group("method", 1)
      call group%get("transfer", word)
      call find_transfer(group, transfer)
      if (.not. transfer%affine()) return
      if (.not. transfer%turning()) call deck%add_error(group, "stress_update = "// &
         "'usavg' generates energy without bound with transfer = '"//word//"'; write "// &
         "transfer = 'rflip' or remove stress_update [D355]", "stress_update")
      if (.not. transfer%turning()) return
      if (.not. group%given("turn_from")) then
         call deck%set_default("method", 1, "turn_from", "tiles")
         return
      end if
      call group%get("turn_from", turn)
      if (turn /= "tiles") call deck%add_error(group, "stress_update = 'usavg' generates "// &
         "energy with turn_from = '"//turn//"'; write 'tiles' or remove turn_from [D355]", &
         "turn_from")
   end subroutine set_turn_default

   !> Long particles of a gas are split, because it expands without bound and cells without
   !! particles have no volume. An exact solution needs undivided particles.
   subroutine set_split_default(deck, gases)
      type(deck_t), intent(inout) :: deck            !! The deck, gets the default
      logical, intent(in) :: gases                   !! Is all material a gas?
      character(len=:), allocatable :: normalise, solution
      type(group_t) :: group, exact

      group = deck%group("method", 1)
      if (group%given("split")) return
      call group%get("normalise", normalise)
      exact = deck%group("exact")
      call exact%get("solution", solution)
      if (normalise == "none" .or. solution /= "none") return
      call deck%set_default("method", 1, "split", .true.)
      if (.not. gases) call deck%set_default("method", 1, "split_what", "gases")
   end subroutine set_split_default

   !> Refuse normalised sums where the rule of the dual gradient does not allow them.
   subroutine check_normalise(deck)
      type(deck_t), intent(inout) :: deck            !! Collects errors
      character(len=:), allocatable :: word
      logical :: may
      type(group_t) :: group

      if (.not. is_dual(deck)) return
      group = deck%group("method", 1)
      call group%get("normalise", word)
      may = may_normalise(deck)
      if (word /= "none" .and. .not. may) call deck%add_error(group, &
         "normalise = '"//word//"' needs quadrature = 'point' and free_surface = 'fill', and "// &
         "no paper = .true.; write 'none' [D355]", "normalise")
   end subroutine check_normalise

   !> Does the limiter of smooth flow replace normalised sums, unless the deck requests both? It
   !! does where the deck gives it, and beside the strain of two velocities. Set for metals, it
   !! does not: materials with normalised sums keep their own.
   logical function limits_all(deck, averages) result(limits)
      type(deck_t), intent(in) :: deck
      logical, intent(in) :: averages                !! Is the strain that of two velocities?
      character(len=:), allocatable :: word
      type(group_t) :: group

      group = deck%group("method", 1)
      call group%get("viscosity_limiter", word)
      limits = word /= "none" .and. (averages .or. group%given("viscosity_limiter"))
   end function limits_all

   !> Does the rule of the dual gradient allow normalised sums?
   logical function may_normalise(deck) result(may)
      type(deck_t), intent(in) :: deck
      character(len=:), allocatable :: surface, word
      class(quadrature_t), allocatable :: quadrature
      logical :: paper
      type(group_t) :: group

      group = deck%group("method", 1)
      call group%get("quadrature", word)
      call choose_quadrature(word, quadrature)
      call group%get("free_surface", surface)
      call group%get("paper", paper)
      may = allocated(quadrature) .and. .not. paper .and. surface == "fill"
      if (may) may = quadrature%is_plain()
   end function may_normalise

   !> Set the keys that the scheme of LA-UR-11-06616 fixes, and refuse other values of them.
   subroutine set_paper_defaults(deck, group)
      type(deck_t), intent(inout) :: deck
      type(group_t), intent(in) :: group             !! &method
      character(len=13), parameter :: keys(6) = [character(len=13) :: "transfer", "alpha", &
         "blend", "free_surface", "quadrature", "stress_update"]
      character(len=7), parameter :: fixed(6) = [character(len=7) :: "flip", "product", "linear", &
         "none", "point", "usf"]
      character(len=:), allocatable :: word
      real(wp) :: number
      integer :: n

      do n = 1, size(keys)
         if (group%given(trim(keys(n)))) then
            call group%get(trim(keys(n)), word)
            if (word /= fixed(n)) call deck%add_error(group, "paper = .true. needs "// &
               trim(keys(n))//" = '"//trim(fixed(n))//"'; remove one of the two [D355]", &
               trim(keys(n)))
         else
            call deck%set_default("method", 1, trim(keys(n)), trim(fixed(n)))
         end if
      end do
      do n = 1, 2
         associate (key => merge("flip   ", "alpha_0", n == 1))
            if (.not. group%given(trim(key))) then
               call deck%set_default("method", 1, trim(key), 1.0_wp)
               cycle
            end if
            call group%get(trim(key), number)
            if (abs(number - 1.0_wp) > 0.0_wp) call deck%add_error(group, &
               "paper = .true. needs "//trim(key)//" = 1; remove one of the two [D355]", trim(key))
         end associate
      end do
   end subroutine set_paper_defaults
end module scene_method_defaults
