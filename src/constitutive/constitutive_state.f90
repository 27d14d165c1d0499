! SPDX-License-Identifier: BSD-3-Clause
!> The state of matter that laws may read and write: arrays over particles, no particles, no grid.
module constitutive_state
   use base_field_worker, only: field_worker_t
   use base_kinds, only: int64, wp
   implicit none
   private

   public :: deformation_t, material_state_t

   !> State carried by the particles of one material. A field is allocated if and only if a law, an
   !! effect or an output of the scene asked for it; `allocated` is the one truth about that.
   type :: material_state_t
      real(wp), allocatable :: mass(:)               !! [kg] (in axisymmetry of the whole ring)
      real(wp), allocatable :: volume(:)             !! Present volume [m3]
      real(wp), allocatable :: stress(:, :)          !! Cauchy stress with viscous part (:, 6) [Pa]
      real(wp), allocatable :: viscous_pressure(:)   !! Artificial viscosity, part of stress [Pa]
      real(wp), allocatable :: energy(:)             !! Internal energy per mass [J/kg]
      real(wp), allocatable :: temperature(:)        !! [K]
      real(wp), allocatable :: plastic_strain(:)     !! Equivalent plastic strain [1]
      real(wp), allocatable :: plastic_rate(:)       !! Its rate [1/s]
      real(wp), allocatable :: plastic_dilation(:)   !! Logarithm of volume gained by shear [1]
      real(wp), allocatable :: distension(:)         !! Of porous matter, solid over density [1]
      real(wp), allocatable :: damage(:)             !! 0 intact to 1 failed [1]
      real(wp), allocatable :: scatter(:)            !! Random strength of its own [1]
      real(wp), allocatable :: overload(:)           !! Load over strength, less one [1]
      real(wp), allocatable :: bulking(:)            !! Pressure gained by fracture [Pa]
      real(wp), allocatable :: solid_fraction(:)     !! Share of the volume without voids [1]
      !> Gradient of place now to place at the start, dx_k/dX_l, column k + 3 (l - 1) (:, 9) [1].
      real(wp), allocatable :: deformation_gradient(:, :)
      real(wp), allocatable :: equivalent_strain(:)  !! Sum of sqrt(2/3 e:e), only for outputs [1]
      real(wp), allocatable :: inertial_number(:)    !! Of flowing grains, only for outputs [1]
      integer(int64), allocatable :: failed(:)       !! Failure flag, 0 or 1, never averaged
   contains
      procedure :: walk => matter_walk               !! Shows each allocated field to a worker
   end type material_state_t

   !> What one time step does to the particles of one tile; scratch space. The gradient is filled
   !! by the transfer, all else by the material. Index 1 belongs to the first particle of the range,
   !! not of the store.
   type :: deformation_t
      !> Is y a direction of its own? Then gradients and stresses with one index y are zero.
      logical :: plane = .false.
      real(wp), allocatable :: gradient(:, :)        !! dt du_k/dx_l, column k + 3 (l - 1) [1]
      real(wp), allocatable :: old_volume(:)         !! Volume before the step [m3]
      real(wp), allocatable :: dilatation(:)         !! Trace of the strain increment [1]
      real(wp), allocatable :: jump(:) !! Part of it that viscosity resists, if that is less [1]
      real(wp), allocatable :: pressure(:)           !! Mean pressure of the material [Pa]
      real(wp), allocatable :: pressure_floor(:)     !! Least pressure the material can bear [Pa]
      real(wp), allocatable :: homologous(:)         !! Temperature, 0 reference to 1 melted [1]
      real(wp), allocatable :: plastic_increment(:)  !! Equivalent plastic strain of the step [1]
      real(wp), allocatable :: loosening(:)          !! Logarithm of volume gained by shear [1]
      real(wp), allocatable :: distension(:)         !! Of porous matter after the step [1]
      real(wp), allocatable :: modulus(:)            !! Shear modulus over that at reference [1]
      real(wp), allocatable :: share(:)              !! Of the dilatation, of matter itself [1]
      real(wp), allocatable :: gruneisen(:)          !! Grueneisen number times density [kg/m3]
      real(wp), allocatable :: whole_volume(:)       !! Volume with its voids [m3]
      real(wp), allocatable :: wave_speed(:)         !! Limits the next time step (out) [m/s]
      real(wp), allocatable :: plastic_work(:)       !! Work into plastic flow in the step (out) [J]
      real(wp), allocatable :: viscous_work(:)       !! Work into artificial viscosity (out) [J]
   contains
      procedure :: reserve => deformation_reserve    !! Makes room for the particles of a tile
   end type deformation_t

contains

   !> Show every allocated field to a worker, always in the same order.
   subroutine matter_walk(self, worker)
      class(material_state_t), intent(inout) :: self         !! The state
      class(field_worker_t), intent(inout) :: worker !! What is to be done

      call worker%scalar("mass", "kg", self%mass)
      call worker%scalar("volume", "m3", self%volume)
      call worker%vector("stress", "Pa", self%stress)
      if (allocated(self%viscous_pressure)) &
         call worker%scalar("viscous_pressure", "Pa", self%viscous_pressure)
      if (allocated(self%energy)) call worker%scalar("energy", "J/kg", self%energy)
      if (allocated(self%temperature)) call worker%scalar("temperature", "K", self%temperature)
      if (allocated(self%plastic_strain)) &
         call worker%scalar("plastic_strain", "1", self%plastic_strain)
      if (allocated(self%plastic_rate)) call worker%scalar("plastic_rate", "1/s", self%plastic_rate)
      if (allocated(self%plastic_dilation)) &
         call worker%scalar("plastic_dilation", "1", self%plastic_dilation)
      if (allocated(self%distension)) call worker%scalar("distension", "1", self%distension)
      if (allocated(self%damage)) call worker%scalar("damage", "1", self%damage)
      if (allocated(self%scatter)) call worker%scalar("scatter", "1", self%scatter)
      if (allocated(self%overload)) call worker%scalar("overload", "1", self%overload)
      if (allocated(self%bulking)) call worker%scalar("bulking", "Pa", self%bulking)
      if (allocated(self%solid_fraction)) &
         call worker%scalar("solid_fraction", "1", self%solid_fraction)
      if (allocated(self%deformation_gradient)) &
         call worker%vector("deformation_gradient", "1", self%deformation_gradient)
      if (allocated(self%equivalent_strain)) &
         call worker%scalar("equivalent_strain", "1", self%equivalent_strain)
      if (allocated(self%inertial_number)) &
         call worker%scalar("inertial_number", "1", self%inertial_number)
      if (allocated(self%failed)) call worker%whole("failed", "1", self%failed)
   end subroutine matter_walk

   !> Make room for a number of particles. What was there is lost.
   !!
   !! The columns are not as long as the particles are many: a length that is a power of two would
   !! put all of them into the same few places of the cache.
   pure subroutine deformation_reserve(self, particles)
      class(deformation_t), intent(inout) :: self    !! The scratch space
      integer, intent(in) :: particles               !! Most particles in a tile
      integer :: n

      if (allocated(self%dilatation)) then
         if (size(self%dilatation) >= particles) return
         deallocate (self%gradient, self%old_volume, self%dilatation, self%pressure, &
            self%pressure_floor, self%homologous, self%plastic_increment, self%loosening, &
            self%distension, self%modulus, self%share, self%gruneisen, self%whole_volume, &
            self%wave_speed, self%plastic_work, self%viscous_work, self%jump)
      end if
      n = 64*((particles + 63)/64) + 8
      allocate (self%gradient(n, 9), self%old_volume(n), self%dilatation(n), self%pressure(n), &
         self%pressure_floor(n), self%homologous(n), self%plastic_increment(n), &
         self%loosening(n), self%distension(n), self%modulus(n), self%wave_speed(n), &
         self%share(n), self%gruneisen(n), self%whole_volume(n), &
         self%plastic_work(n), self%viscous_work(n), self%jump(n))
   end subroutine deformation_reserve
end module constitutive_state
