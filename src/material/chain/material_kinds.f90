! SPDX-License-Identifier: BSD-3-Clause
!> Kinds of material that choose defaults of the method.
module material_kinds
   use base_kinds, only: wp
   use material_type, only: material_t
   implicit none
   private

   public :: is_fluid, is_gas, is_loose, kinds_of, kinds_t, may_lock, stores_work, &
      supports_any_shear

   !> What kinds of material a deck has, as far as defaults of the method depend on it.
   type :: kinds_t
      logical :: stored = .false.                    !! All materials store work reversibly
      logical :: keeps = .false.                     !! The method must keep their energy
      logical :: gases = .false.                     !! All material is a gas
      logical, allocatable :: gas(:)                 !! (material) Is it a gas or an explosive?
      logical :: condensed = .false.                 !! Some that is no gas has an internal energy
   contains
      procedure :: some_gas => kinds_some_gas        !! Is some material a gas or an explosive?
   end type kinds_t

   !> Poisson's ratio from which on particles keep their volume, so that few cells lock [1]
   real(wp), parameter :: nearly_incompressible = 0.45_wp

contains

   !> Kinds of the materials of a deck.
   pure function kinds_of(materials) result(kinds)
      type(material_t), intent(in) :: materials(:)   !! Materials of the deck
      type(kinds_t) :: kinds
      integer :: index

      kinds%stored = stores_work(materials)
      kinds%keeps = must_keep_energy(materials)
      kinds%gases = all_gases(materials)
      allocate (kinds%gas, source=[(is_gas(materials(index)), index=1, size(materials))])
      kinds%condensed = any_condensed(materials)
   end function kinds_of

   !> Is some material a gas or an explosive?
   pure logical function kinds_some_gas(self) result(yes)
      class(kinds_t), intent(in) :: self

      yes = .false.
      if (allocated(self%gas)) yes = any(self%gas)
   end function kinds_some_gas

   !> Is a material without strength? Loose grains have strength.
   pure logical function is_fluid(material) result(yes)
      type(material_t), intent(in) :: material

      yes = .true.
      if (allocated(material%law)) yes = .not. (material%law%has_shear() .or. &
         material%law%has_grains() .or. material%law%gives_whole_stress())
   end function is_fluid

   !> May few cells lock: does a material with shear strength keep its volume, because it is nearly
   !! incompressible, or because it flows plastically with a strength that no pressure changes?
   !! Section "Locking: B-bar" of doc/theory/method.md.
   pure logical function may_lock(material) result(yes)
      type(material_t), intent(in) :: material

      yes = .false.
      if (.not. allocated(material%law)) return
      if (.not. material%law%has_shear()) return
      associate (bulk => material%bulk, shear => material%shear)
         yes = 3.0_wp*bulk - 2.0_wp*shear >= 2.0_wp*nearly_incompressible*(3.0_wp*bulk + shear)
      end associate
      ! flow that depends on the pressure has an apex, a least pressure
      if (.not. yes) yes = material%law%is_plastic() .and. .not. material%law%grows_pores() .and. &
         material%law%least_pressure() <= -0.5_wp*huge(1.0_wp)
   end function may_lock

   !> Does a material support any shear: without flow, failure or a law for large strains?
   pure logical function supports_any_shear(material) result(yes)
      type(material_t), intent(in) :: material

      yes = .false.
      if (.not. allocated(material%law) .or. allocated(material%damage) .or. &
         allocated(material%failure%fracture)) return
      yes = material%law%has_shear() .and. .not. (material%law%is_plastic() .or. &
         material%law%gives_whole_stress() &
         .or. material%law%has_grains())
   end function supports_any_shear

   !> True if all materials are gases: without strength, with an internal energy, and without
   !! cohesion at zero energy.
   pure logical function all_gases(materials) result(yes)
      type(material_t), intent(in) :: materials(:)   !! Materials of the deck
      integer :: index

      yes = size(materials) > 0 .and. all([(is_gas(materials(index)) .and. .not. &
         allocated(materials(index)%burn), index=1, size(materials))])
   end function all_gases

   !> True if some material has an internal energy and is no gas: metals, and rocks and liquids at
   !! high pressure.
   pure logical function any_condensed(materials) result(yes)
      type(material_t), intent(in) :: materials(:)   !! Materials of the deck
      integer :: index

      yes = any([(materials(index)%carries_energy() .and. .not. is_gas(materials(index)), &
         index=1, size(materials))])
   end function any_condensed

   !> Is a material a gas, or an explosive whose products are one: without strength, with an
   !! internal energy, and without cohesion at zero energy?
   pure logical function is_gas(material) result(yes)
      type(material_t), intent(in) :: material

      yes = is_fluid(material) .and. material%carries_energy()
      if (.not. yes .or. allocated(material%burn)) return
      yes = allocated(material%eos)
      if (yes) yes = material%eos%is_gas()
   end function is_gas

   !> True if all materials store the work of strain reversibly: no flow, failure or heat.
   pure logical function stores_work(materials) result(stored)
      type(material_t), intent(in) :: materials(:)   !! Materials of the deck
      integer :: index

      stored = size(materials) > 0
      do index = 1, size(materials)
         associate (material => materials(index))
            stored = stored .and. allocated(material%law) .and. .not. &
               (allocated(material%damage) .or. allocated(material%failure%fracture))
            if (.not. stored) return
            stored = .not. (material%law%is_plastic() .or. material%carries_energy())
         end associate
      end do
   end function stores_work

   !> True if some material carries no internal energy, so that nothing records the energy that the
   !! method dissipates in it. Loose grains at rest and in slow flow are more accurate with a method
   !! that damps, and so are gases.
   pure logical function must_keep_energy(materials) result(must)
      type(material_t), intent(in) :: materials(:)   !! Materials of the deck
      integer :: index

      must = .false.
      do index = 1, size(materials)
         if (is_loose(materials(index)) .or. is_gas(materials(index))) then
            must = .false.
            return
         end if
         must = must .or. .not. materials(index)%carries_energy()
      end do
   end function must_keep_energy

   !> True if a material is loose grains.
   pure logical function is_loose(material) result(loose)
      type(material_t), intent(in) :: material

      loose = .false.
      if (allocated(material%law)) loose = material%law%is_loose()
   end function is_loose
end module material_kinds
