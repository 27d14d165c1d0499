! SPDX-License-Identifier: BSD-3-Clause
!> Pressure of concrete whose pores are crushed (T. J. Holmquist, G. R. Johnson, W. H. Cook, "A
!! computational constitutive model for concrete subjected to large strains, high strain rates, and
!! high pressures", 14th International Symposium on Ballistics, Quebec, 1993), see law_hjc.
!!
!! With mu = rho/rho0 - 1 and its greatest value so far, mu_m, there are three regions: elastic up
!! to mu_crush; a line to the pressure P_lock, on which pores are crushed; and the solid without
!! pores. Equations (F.21) to (F.24) of doc/theory/failure.md.
module eos_hjc
   use base_kinds, only: wp
   use deck_group_values, only: group_t
   use deck_schema, only: schema_t
   use material_effects, only: in_order
   use material_eos, only: eos_t
   use material_field_requests, only: field_requests_t
   use material_state, only: deformation_t, material_state_t
   implicit none
   private

   public :: eos_hjc_t

   character(len=*), parameter :: keys(7) = [character(len=11) :: "hjc_pcrush", "hjc_mucrush", &
      "hjc_plock", "hjc_mulock", "hjc_k1", "hjc_k2", "hjc_k3"]

   !> Equation of state of three regions. Its bulk modulus is that of the elastic one.
   type, extends(eos_t) :: eos_hjc_t
      real(wp) :: crush_pressure = 0.0_wp            !! P_crush, pores begin to be crushed [Pa]
      real(wp) :: crush = 0.0_wp                     !! mu_crush, compression there [1]
      real(wp) :: lock_pressure = 0.0_wp             !! P_lock, all pores are closed [Pa]
      real(wp) :: lock = 0.0_wp                      !! mu_lock, of the unloaded solid [1]
      real(wp) :: solid = 0.0_wp                     !! K1 [Pa]
      real(wp) :: square = 0.0_wp                    !! K2 [Pa]
      real(wp) :: cube = 0.0_wp                      !! K3 [Pa]
      real(wp) :: full = 0.0_wp                      !! mu_plock, compression at P_lock [1]
   contains
      procedure :: declare => hjc_declare            !! Declares its keys
      procedure :: fault => hjc_fault                !! Keys that do not fit each other
      procedure :: read => hjc_read                  !! Reads its keys
      procedure :: complete => hjc_complete          !! Finds what follows from the constants
      procedure :: has_pores => hjc_has_pores        !! Returns true
      procedure :: request => hjc_request            !! Requests energy and compaction
      procedure :: update => hjc_update              !! Pressure and square of the sound speed
      procedure :: keep_state => hjc_keep_state      !! Keeps the compaction
      procedure :: crushed => hjc_crushed            !! Compression that remains after unloading
   end type eos_hjc_t

contains

   !> Declare the keys of the equation of state.
   subroutine hjc_declare(self, schema)
      class(eos_hjc_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema
      character(len=*), parameter :: owner = "effects.eos & eos_model = hjc"

      call schema%real("material", "hjc_pcrush", "HJC Pcrush, pressure at which pores begin to "// &
         "be crushed", unit="Pa", range="> 0", owner=owner)
      call schema%real("material", "hjc_mucrush", "HJC mu_crush, compression rho/rho0 - 1 at "// &
         "hjc_pcrush", range="> 0", owner=owner)
      call schema%real("material", "hjc_plock", "HJC Plock, pressure at which all pores are "// &
         "closed", unit="Pa", range="> 0", owner=owner)
      call schema%real("material", "hjc_mulock", "HJC mu_lock, compression of the solid "// &
         "without pores and pressure: its density over density, less 1", range="> 0", owner=owner)
      call schema%real("material", "hjc_k1", "HJC K1, bulk modulus of the solid without pores", &
         unit="Pa", range="> 0", owner=owner)
      call schema%real("material", "hjc_k2", "HJC K2, coefficient of the square of compression", &
         unit="Pa", default="0", owner=owner)
      call schema%real("material", "hjc_k3", "HJC K3, coefficient of the cube of compression", &
         unit="Pa", default="0", range=">= 0", owner=owner)
      call schema%require("material", "hjc_pcrush hjc_mucrush hjc_plock hjc_mulock hjc_k1")
   end subroutine hjc_declare

   !> The pressure must increase with the density, and no path must give more work than it takes:
   !! material unloads on lines that are not less steep than that on which pores are crushed.
   pure function hjc_fault(self, group) result(text)
      class(eos_hjc_t), intent(in) :: self
      type(group_t), intent(in) :: group             !! &material
      character(len=:), allocatable :: text
      type(eos_hjc_t) :: chosen
      real(wp) :: slope
      integer :: i

      text = ""
      do i = 1, size(keys)
         if (.not. group%known(trim(keys(i)))) return
         if (i <= 5 .and. .not. group%given(trim(keys(i)))) return
      end do
      if (.not. in_order(group, "hjc_pcrush", "hjc_plock")) then
         text = "hjc_plock must be above hjc_pcrush [D363]"
         return
      end if
      call read_constants(chosen, group)
      if (chosen%square < 0.0_wp .and. chosen%square**2 >= 3.0_wp*chosen%solid*chosen%cube) then
         text = "the pressure of hjc_k1, hjc_k2 and hjc_k3 decreases with the density in some "// &
            "range [D363]"
         return
      end if
      call chosen%complete()
      slope = (chosen%lock_pressure - chosen%crush_pressure)/(chosen%full - chosen%crush)
      if (.not. chosen%full > chosen%crush) then
         text = "hjc_mucrush must be below the compression at hjc_plock; choose a greater "// &
            "hjc_mulock [D363]"
      else if (slope > min(chosen%bulk, chosen%solid)) then
         text = "crushing from hjc_pcrush to hjc_plock must not be stiffer than hjc_pcrush/"// &
            "hjc_mucrush and hjc_k1, by which it unloads; choose a greater hjc_mulock or a "// &
            "lower hjc_plock [D363]"
      end if
   end function hjc_fault

   !> Read the keys of the equation of state.
   pure subroutine hjc_read(self, group)
      class(eos_hjc_t), intent(inout) :: self
      type(group_t), intent(in) :: group             !! &material

      call read_constants(self, group)
      call self%complete()
   end subroutine hjc_read

   !> Read the constants.
   pure subroutine read_constants(eos, group)
      class(eos_hjc_t), intent(inout) :: eos
      type(group_t), intent(in) :: group             !! &material

      call group%get("hjc_pcrush", eos%crush_pressure)
      call group%get("hjc_mucrush", eos%crush)
      call group%get("hjc_plock", eos%lock_pressure)
      call group%get("hjc_mulock", eos%lock)
      call group%get("hjc_k1", eos%solid)
      call group%get("hjc_k2", eos%square)
      call group%get("hjc_k3", eos%cube)
   end subroutine read_constants

   !> Find the elastic bulk modulus, and the compression at which the solid has the pressure P_lock,
   !! by halving an interval to the last bit.
   pure subroutine hjc_complete(self)
      class(eos_hjc_t), intent(inout) :: self
      integer, parameter :: most_halvings = 200, most_doublings = 60
      real(wp) :: low, high, middle
      integer :: round

      ! The checks of single keys follow those of the model.
      if (self%crush > 0.0_wp) self%bulk = self%crush_pressure/self%crush
      low = 0.0_wp
      high = 1.0_wp
      do round = 1, most_doublings
         if (solid_pressure(self, high) >= self%lock_pressure) exit
         high = 2.0_wp*high
      end do
      do round = 1, most_halvings
         middle = 0.5_wp*(low + high)
         if (.not. (middle > low .and. middle < high)) exit
         if (solid_pressure(self, middle) < self%lock_pressure) then
            low = middle
         else
            high = middle
         end if
      end do
      self%full = self%lock + (1.0_wp + self%lock)*high
   end subroutine hjc_complete

   !> Its material is porous.
   pure logical function hjc_has_pores(self) result(has)
      class(eos_hjc_t), intent(in) :: self

      has = .true.
   end function hjc_has_pores

   !> The pressure depends on the crushing so far, so particles carry their energy.
   pure subroutine hjc_request(self, requests)
      class(eos_hjc_t), intent(in) :: self
      class(field_requests_t), intent(inout) :: requests

      call requests%add("energy", "equation of state hjc", 1)
      call requests%add_own("compaction", "1", "greatest compression rho/rho0 - 1 so far", &
         "equation of state hjc")
   end subroutine hjc_request

   !> Pressure, the slope of unloading as the square of the sound speed, and what the step crushes.
   pure subroutine hjc_update(self, state, deformation, first, last)
      class(eos_hjc_t), intent(in) :: self
      type(material_state_t), intent(in) :: state          !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp) :: compression, greatest, modulus
      integer :: i, k, own

      own = state%own_index("compaction")
      do i = 1, last - first + 1
         k = first - 1 + i
         compression = (state%mass(k) - self%density*state%volume(k)) &
            /(self%density*state%volume(k))
         greatest = max(compression, state%own(own)%values(k))
         deformation%distension(i) = greatest
         deformation%damage%crushing(i) = 0.0_wp
         if (compression > state%own(own)%values(k) .and. compression > self%crush) &
            deformation%damage%crushing(i) = max(0.0_wp, self%crushed(compression) &
            - self%crushed(state%own(own)%values(k)))
         call find_pressure(self, compression, greatest, deformation%pressure(i), modulus)
         deformation%wave_speed(i) = modulus/self%density
      end do
   end subroutine hjc_update

   !> Pressure, and bulk modulus dp/dmu of unloading, which is never below that of loading.
   !! Equations (F.21) and (F.22).
   pure subroutine find_pressure(eos, compression, greatest, pressure, modulus)
      class(eos_hjc_t), intent(in) :: eos
      real(wp), intent(in) :: compression            !! mu [1]
      real(wp), intent(in) :: greatest               !! mu_m, of all times up to now [1]
      real(wp), intent(out) :: pressure              !! [Pa]
      real(wp), intent(out) :: modulus               !! [Pa]
      real(wp) :: excess

      if (greatest <= eos%crush) then
         modulus = eos%bulk
         pressure = modulus*compression
      else if (greatest < eos%full) then
         modulus = unloading(eos, greatest)
         pressure = crush_line(eos, greatest) + modulus*(compression - greatest)
      else
         excess = (compression - eos%lock)/(1.0_wp + eos%lock)
         pressure = solid_pressure(eos, excess)
         excess = max(0.0_wp, excess)
         modulus = (eos%solid + excess*(2.0_wp*eos%square + 3.0_wp*eos%cube*excess)) &
            /(1.0_wp + eos%lock)
      end if
   end subroutine find_pressure

   !> Pressure of the solid without pores [Pa]: a cubic polynomial, linear in tension.
   pure real(wp) function solid_pressure(eos, excess) result(pressure)
      class(eos_hjc_t), intent(in) :: eos
      real(wp), intent(in) :: excess                 !! Compression of the solid [1]
      real(wp) :: positive

      positive = max(0.0_wp, excess)
      pressure = eos%solid*excess + positive**2*(eos%square + eos%cube*positive)
   end function solid_pressure

   !> Pressure at which pores are being crushed [Pa].
   pure real(wp) function crush_line(eos, compression) result(pressure)
      class(eos_hjc_t), intent(in) :: eos
      real(wp), intent(in) :: compression            !! mu, from mu_crush to mu_plock [1]

      pressure = eos%crush_pressure + (eos%lock_pressure - eos%crush_pressure) &
         *(compression - eos%crush)/(eos%full - eos%crush)
   end function crush_line

   !> Modulus of unloading, interpolated between elastic and solid [Pa]. Equation (F.23).
   pure real(wp) function unloading(eos, greatest) result(modulus)
      class(eos_hjc_t), intent(in) :: eos
      real(wp), intent(in) :: greatest               !! mu_m, from mu_crush to mu_plock [1]

      modulus = eos%bulk + (eos%solid - eos%bulk)*(greatest - eos%crush)/(eos%full - eos%crush)
   end function unloading

   !> Compression mu_p that remains if material unloads from the crush line [1]. Equation (F.24).
   pure real(wp) function hjc_crushed(self, greatest) result(left)
      class(eos_hjc_t), intent(in) :: self
      real(wp), intent(in) :: greatest               !! mu_m, of all times up to now [1]
      real(wp) :: reached

      left = 0.0_wp
      reached = min(greatest, self%full)
      if (reached > self%crush) left = reached - crush_line(self, reached)/unloading(self, reached)
   end function hjc_crushed

   !> Keep the greatest compression.
   pure subroutine hjc_keep_state(self, state, deformation, first, last)
      class(eos_hjc_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state       !! State of the store
      type(deformation_t), intent(in) :: deformation       !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range

      state%own(state%own_index("compaction"))%values(first:last) = &
         deformation%distension(:last - first + 1)
   end subroutine hjc_keep_state
end module eos_hjc
