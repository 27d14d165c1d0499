! SPDX-License-Identifier: BSD-3-Clause
!> What failed matter is: rubble, which has no deviator and bears no tension; nothing; or matter
!! that follows a law of its own.
!!
!! A law of its own is called for the failed particles of a range only. Their state is gathered,
!! which leaves loops over neighbouring particles, and a range without any costs a look at its
!! flags. The stress at failure is the first one of that law, which returns it to what the law
!! allows.
module material_failed
   use base_constants, only: pi
   use base_deck_group, only: group_t
   use base_kinds, only: int64, wp
   use base_schema, only: schema_t
   use constitutive_friction, only: angles_t
   use constitutive_law, only: law_t
   use constitutive_state, only: deformation_t, material_state_t
   use law_drucker_prager, only: law_drucker_prager_t
   use law_granular, only: law_granular_t
   implicit none
   private

   public :: choose_failed_law, declare_failed_law, failed_law_t, share_t, vanish

   !> The law of failed matter.
   type :: failed_law_t
      class(law_t), allocatable :: law               !! The law
   contains
      procedure :: collect => remains_collect        !! Gathers the failed particles of a range
      procedure :: follow => remains_follow          !! Lets them follow the law
      procedure :: give_back => remains_give_back    !! Puts them back
   end type failed_law_t

   !> The failed particles of a range.
   type :: share_t
      integer :: count = 0                           !! How many
      integer, allocatable :: place(:)               !! Their places in the range
      real(wp), allocatable :: released(:)           !! Work that loosening them sets free [J]
      type(material_state_t) :: state                       !! Their state
      type(deformation_t) :: deformation             !! Their step
   end type share_t

contains

   !> Declare the keys.
   subroutine declare_failed_law(schema)
      type(schema_t), intent(inout) :: schema        !! Keys of the deck
      character(len=*), parameter :: owner = "effects.damage & failed_as = "

      call schema%text("material", "failed_as", "what failed matter is: rubble has neither "// &
         "deviator nor tension, nothing has no stress at all, the others follow that law; "// &
         "default: rubble, with damage_model = 'jh2' its fractured strength", &
         words="rubble nothing granular drucker_prager", owner="effects.damage")
      call schema%real("material", "failed_friction_angle", "angle of friction of failed matter", &
         unit="deg", range="> 0 < 90", owner=owner//"drucker_prager")
      call schema%require("material", "failed_friction_angle")
      call schema%real("material", "failed_tau", "time in which the stress of failed matter "// &
         "relaxes at rest", unit="s", range="> 0", owner=owner//"granular")
      call schema%real("material", "failed_gamma_c", "strain that a contact of failed matter "// &
         "survives", range="> 0", owner=owner//"granular")
   end subroutine declare_failed_law

   !> The law of failed matter, if it has one of its own.
   subroutine choose_failed_law(group, shear, bulk, density, remains)
      type(group_t), intent(in) :: group             !! &material
      real(wp), intent(in) :: shear                  !! Shear modulus [Pa]
      real(wp), intent(in) :: bulk                   !! Bulk modulus [Pa]
      real(wp), intent(in) :: density                !! Of the reference state [kg/m3]
      type(failed_law_t), allocatable, intent(out) :: remains !! Not allocated: no such law
      type(law_granular_t) :: granular
      type(law_drucker_prager_t) :: frictional
      type(angles_t) :: angles
      character(len=:), allocatable :: word
      real(wp) :: number

      call group%get("failed_as", word)
      select case (word)
      case ("granular")
         if (group%given("failed_tau")) then
            call group%get("failed_tau", number)
            granular%slowness = 1.0_wp/number
         end if
         if (group%given("failed_gamma_c")) then
            call group%get("failed_gamma_c", number)
            granular%fragility = 1.0_wp/number
         end if
         allocate (remains)
         allocate (remains%law, source=granular)
      case ("drucker_prager")
         call group%get("failed_friction_angle", angles%friction)
         angles%friction = angles%friction*pi/180.0_wp
         call frictional%set(angles, "compression")
         allocate (remains)
         allocate (remains%law, source=frictional)
      case default
         return
      end select
      remains%law%shear = shear
      remains%law%bulk = bulk
      remains%law%density = density
   end subroutine choose_failed_law

   !> Gather the failed particles of a range before the step, and make the elastic trial of their
   !! law.
   pure subroutine remains_collect(self, state, deformation, first, last, share)
      class(failed_law_t), intent(in) :: self                 !! The law
      type(material_state_t), intent(in) :: state                 !! State of the store
      type(deformation_t), intent(in) :: deformation       !! Step of the range
      integer, intent(in) :: first                         !! First particle of the range
      integer, intent(in) :: last                          !! Last particle of the range
      type(share_t), intent(out) :: share                  !! The failed ones
      integer :: i, k, n, column

      n = 0
      do k = first, last
         n = n + int(state%failed(k))
      end do
      share%count = n
      if (n == 0) return
      allocate (share%place(n), share%released(n), share%state%mass(n), share%state%volume(n), &
         share%state%stress(n, 6))
      call share%deformation%reserve(n)
      n = 0
      do i = 1, last - first + 1
         if (state%failed(first - 1 + i) == 0) cycle
         n = n + 1
         share%place(n) = i
      end do
      do i = 1, n
         share%state%mass(i) = state%mass(first - 1 + share%place(i))
         share%state%volume(i) = state%volume(first - 1 + share%place(i))
      end do
      do column = 1, 6
         do i = 1, n
            share%state%stress(i, column) = state%stress(first - 1 + share%place(i), column)
         end do
      end do
      do column = 1, 9
         do i = 1, n
            share%deformation%gradient(i, column) = deformation%gradient(share%place(i), column)
         end do
      end do
      call find_release(n, self%law%shear, share%state%volume, share%state%stress, &
         share%deformation%gradient, share%released)
      call self%law%predict(share%state, share%deformation, 1, n)
   end subroutine remains_collect

   !> Energy that a deviator of stress releases which ends in the step: what it stores, and the work
   !! that the mean of it and of 0 does. The elastic trial of the step does none.
   pure subroutine find_release(count, shear, volume, stress, gradient, released)
      integer, intent(in) :: count                   !! Particles
      real(wp), intent(in) :: shear                  !! Shear modulus [Pa]
      real(wp), intent(in) :: volume(:)              !! [m3]
      real(wp), intent(in) :: stress(:, :)           !! (particle, 6) Before the step [Pa]
      real(wp), intent(in) :: gradient(:, :)         !! (particle, 9) dt du_k/dx_l [1]
      real(wp), intent(out) :: released(:)           !! [J]
      real(wp) :: s(6), mean, work
      integer :: i, k

      do i = 1, count
         mean = (stress(i, 1) + stress(i, 2) + stress(i, 3))/3.0_wp
         do k = 1, 3
            s(k) = stress(i, k) - mean
            s(k + 3) = stress(i, k + 3)
         end do
         work = s(1)*gradient(i, 1) + s(2)*gradient(i, 5) + s(3)*gradient(i, 9) &
            + s(4)*(gradient(i, 2) + gradient(i, 4)) + s(5)*(gradient(i, 6) + gradient(i, 8)) &
            + s(6)*(gradient(i, 3) + gradient(i, 7))
         released(i) = volume(i)*max(0.0_wp, 0.5_wp*work + 0.25_wp/shear*(s(1)**2 + s(2)**2 &
            + s(3)**2 + 2.0_wp*(s(4)**2 + s(5)**2 + s(6)**2)))
      end do
   end subroutine find_release

   !> Let the failed particles follow their law, with volume, pressure and wave speed after the
   !! step.
   pure subroutine remains_follow(self, state, deformation, first, dt, share)
      class(failed_law_t), intent(in) :: self                 !! The law
      type(material_state_t), intent(in) :: state                 !! State of the store
      type(deformation_t), intent(in) :: deformation       !! Step of the range
      integer, intent(in) :: first                         !! First particle of the range
      real(wp), intent(in) :: dt                           !! Time step [s]
      type(share_t), intent(inout) :: share                !! The failed ones
      integer :: i

      if (share%count == 0) return
      do i = 1, share%count
         share%state%volume(i) = state%volume(first - 1 + share%place(i))
         share%deformation%pressure(i) = max(0.0_wp, deformation%pressure(share%place(i)))
         share%deformation%wave_speed(i) = deformation%wave_speed(share%place(i))
         share%deformation%plastic_increment(i) = 0.0_wp
         share%deformation%plastic_work(i) = 0.0_wp
      end do
      call self%law%update(share%state, share%deformation, 1, share%count, dt)
      call loosen(share%count, share%released, share%deformation%pressure, share%state%stress, &
         share%deformation%plastic_work)
      call self%law%stiffen(share%state, share%deformation, 1, share%count)
   end subroutine remains_follow

   !> Failed material that is not pressed has separated and supports no shear. The energy of the
   !! deviator that it had is recorded as plastic work.
   pure subroutine loosen(count, released, pressure, stress, plastic_work)
      integer, intent(in) :: count                   !! Particles
      real(wp), contiguous, intent(in) :: released(:)          !! Energy of the deviator [J]
      real(wp), contiguous, intent(in) :: pressure(:)          !! [Pa]
      real(wp), contiguous, intent(inout) :: stress(:, :)      !! Deviator (:, 6) [Pa]
      real(wp), contiguous, intent(inout) :: plastic_work(:)   !! In the step [J]
      integer :: i, column

      do i = 1, count
         if (pressure(i) > 0.0_wp) cycle
         plastic_work(i) = released(i)
         do column = 1, 6
            stress(i, column) = 0.0_wp
         end do
      end do
   end subroutine loosen

   !> Put the failed particles back into their range.
   pure subroutine remains_give_back(self, share, state, deformation, first)
      class(failed_law_t), intent(in) :: self                 !! The law
      type(share_t), intent(in) :: share                   !! The failed ones
      type(material_state_t), intent(inout) :: state              !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first                         !! First particle of the range
      integer :: i, column

      do column = 1, 6
         do i = 1, share%count
            state%stress(first - 1 + share%place(i), column) = share%state%stress(i, column)
         end do
      end do
      do i = 1, share%count
         deformation%pressure(share%place(i)) = share%deformation%pressure(i)
         deformation%wave_speed(share%place(i)) = share%deformation%wave_speed(i)
         deformation%plastic_increment(share%place(i)) = share%deformation%plastic_increment(i)
         deformation%plastic_work(share%place(i)) = share%deformation%plastic_work(i)
      end do
   end subroutine remains_give_back

   !> Take all stress from failed particles.
   pure subroutine vanish(first, last, failed, stress, wave_speed)
      integer, intent(in) :: first                   !! First particle of the range
      integer, intent(in) :: last                    !! Last particle of the range
      integer(int64), contiguous, intent(in) :: failed(:)    !! Flag of failure (store)
      real(wp), contiguous, intent(inout) :: stress(:, :)    !! (store, 6) [Pa]
      real(wp), contiguous, intent(inout) :: wave_speed(:)   !! (range) [m/s]
      integer :: i, k, column

      do column = 1, 6
         do concurrent (k=first:last)
            stress(k, column) = merge(0.0_wp, stress(k, column), failed(k) /= 0)
         end do
      end do
      do concurrent (i=1:last - first + 1)
         wave_speed(i) = merge(0.0_wp, wave_speed(i), failed(first - 1 + i) /= 0)
      end do
   end subroutine vanish
end module material_failed
