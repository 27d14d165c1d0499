! SPDX-License-Identifier: BSD-3-Clause
!> State of the material of particles, which laws read and write: arrays over particles, without
!! particles or grid.
module material_state
   use base_field_worker, only: field_worker_t
   use base_kinds, only: int64, wp
   implicit none
   private

   public :: deformation_t, has_energy, material_state_t, void_scratch_t

   !> A field that one model requests and describes, see `add_own` of the requests.
   type :: own_field_t
      character(len=32) :: name = ""                 !! Name in files
      character(len=16) :: unit = "1"                !! SI unit
      real(wp) :: start = 0.0_wp                     !! Value of new particles
      real(wp), allocatable :: values(:)             !! (particle)
   end type own_field_t

   !> State of brittle failure.
   type :: brittle_state_t
      real(wp), allocatable :: scatter(:)            !! Random strength of each particle [1]
      real(wp), allocatable :: overload(:)           !! Load over strength, less one [1]
      real(wp), allocatable :: bulking(:)            !! Pressure gained by fracture [Pa]
   end type brittle_state_t

   !> Fields for outputs only.
   type :: recorded_state_t
      real(wp), allocatable :: equivalent_strain(:)  !! Sum of sqrt(2/3 e:e) [1]
      real(wp), allocatable :: inertial_number(:)    !! Inertial number of granular flow [1]
   end type recorded_state_t

   !> State carried by the particles of one material. A field is allocated if and only if a law, an
   !! effect or an output requests it.
   type :: material_state_t
      real(wp), allocatable :: mass(:)               !! [kg] (axisymmetric: of the whole ring)
      real(wp), allocatable :: volume(:)             !! Current volume [m3]
      real(wp), allocatable :: stress(:, :)          !! Cauchy stress with viscous part (:, 6) [Pa]
      real(wp), allocatable :: viscous_pressure(:)   !! Artificial viscosity, part of stress [Pa]
      real(wp), allocatable :: energy(:)             !! Internal energy per mass [J/kg]
      real(wp), allocatable :: burn_time(:)          !! Arrival time of the detonation [s]
      real(wp), allocatable :: temperature(:)        !! [K]
      real(wp), allocatable :: plastic_strain(:)     !! Equivalent plastic strain [1]
      real(wp), allocatable :: plastic_dilation(:)   !! Logarithm of volume gained by shear [1]
      real(wp), allocatable :: damage(:)             !! 0 intact to 1 failed [1]
      real(wp), allocatable :: solid_fraction(:)     !! Fraction of the volume without voids [1]
      !> dx_k/dX_l of current to initial position, column k + 3 (l - 1) (:, 9) [1]
      real(wp), allocatable :: deformation_gradient(:, :)
      integer(int64), allocatable :: failed(:)       !! Failure flag, 0 or 1, never averaged
      real(wp), allocatable :: porosity(:)           !! Volume of pores over the whole [1]
      type(own_field_t), allocatable :: own(:)       !! Fields of single models
      type(brittle_state_t) :: brittle               !! Brittle failure
      type(recorded_state_t) :: recorded             !! For outputs
   contains
      procedure :: walk => material_walk             !! Shows each allocated field to a worker
      procedure :: own_index => material_own_index   !! Index of a field of a single model
   end type material_state_t

   !> Scratch of the laws of strength.
   type :: strength_scratch_t
      real(wp), allocatable :: homologous(:)         !! Temperature, 0 reference to 1 melted [1]
      real(wp), allocatable :: old_damage(:)         !! Damage before the step [1]
      real(wp), allocatable :: strain_rate(:)        !! Equivalent rate of strain [1/s]
      real(wp), allocatable :: dilation(:)           !! Relative volume gained by shear [1]
      real(wp), allocatable :: tangent(:)            !! dp/drho with dilation [m2/s2]
      real(wp), allocatable :: shear_ratio(:)        !! Shear modulus over that at reference [1]
   end type strength_scratch_t

   !> Scratch of the damage models.
   type :: damage_scratch_t
      real(wp), allocatable :: bound(:)              !! Bound of the principal deviators [Pa]
      real(wp), allocatable :: load(:)               !! Load over strength [1]
      real(wp), allocatable :: work(:)               !! Work on particles with cracks [J]
      real(wp), allocatable :: crushing(:)           !! Plastic compression of the step [1]
      real(wp), allocatable :: mean(:) !! Mean stress without the cracks, before the step [Pa]
   end type damage_scratch_t

   !> Scratch of the voids.
   type :: void_scratch_t
      real(wp), allocatable :: alpha(:) !! Fraction of the dilatation in the material [1]
      real(wp), allocatable :: loose(:)              !! 1 if voids can open, else 0 [1]
      real(wp), allocatable :: old_pressure(:)       !! Before the step [Pa]
      real(wp), allocatable :: old_temperature(:)    !! Before the step [K]
      real(wp), allocatable :: total_volume(:)       !! Volume with voids [m3]
   end type void_scratch_t

   !> Changes of the particles of one tile in one time step; scratch space. The transfer sets the
   !! gradient, the material the other arrays. Index 1 is the first particle of the range, not of
   !! the store.
   type :: deformation_t
      !> Plane motion: gradients and stresses with one index y are zero.
      logical :: plane = .false.
      real(wp), allocatable :: gradient(:, :)        !! dt du_k/dx_l, column k + 3 (l - 1) [1]
      real(wp), allocatable :: old_volume(:)         !! Volume before the step [m3]
      real(wp), allocatable :: dilatation(:)         !! Trace of the strain increment [1]
      real(wp), allocatable :: jump(:) !! The part of it that viscosity resists, if limited [1]
      real(wp), allocatable :: pressure(:)           !! Mean pressure of the material [Pa]
      real(wp), allocatable :: pressure_floor(:)     !! Least pressure that it supports [Pa]
      real(wp), allocatable :: plastic_increment(:)  !! Equivalent plastic strain of the step [1]
      real(wp), allocatable :: distension(:)         !! After the step [1]
      real(wp), allocatable :: gruneisen(:)          !! Grueneisen number times density [kg/m3]
      real(wp), allocatable :: wave_speed(:)         !! Limits the next time step (out) [m/s]
      real(wp), allocatable :: plastic_work(:)       !! Work into plastic flow in the step (out) [J]
      real(wp), allocatable :: viscous_work(:)       !! Work into artificial viscosity (out) [J]
      type(strength_scratch_t) :: strength           !! State of the strength model
      type(damage_scratch_t) :: damage               !! State of the damage model, if there is one
      type(void_scratch_t) :: voids                  !! State of the voids, if there are any
   contains
      procedure :: reserve => deformation_reserve    !! Allocates it for the particles of a tile
   end type deformation_t

contains

   !> True if a particle of a range has an internal energy.
   pure logical function has_energy(state, first, last) result(has)
      type(material_state_t), intent(in) :: state
      integer, intent(in) :: first, last             !! Particles of the range

      has = .false.
      if (allocated(state%energy)) has = any(abs(state%energy(first:last)) > 0.0_wp)
   end function has_energy

   !> Pass every allocated field to a worker, always in the same order.
   subroutine material_walk(self, worker)
      class(material_state_t), intent(inout) :: self
      class(field_worker_t), intent(inout) :: worker !! Work on each field
      integer :: i

      call worker%scalar("mass", "kg", self%mass)
      call worker%scalar("volume", "m3", self%volume)
      call worker%vector("stress", "Pa", self%stress)
      if (allocated(self%viscous_pressure)) &
         call worker%scalar("viscous_pressure", "Pa", self%viscous_pressure)
      if (allocated(self%energy)) call worker%scalar("energy", "J/kg", self%energy)
      if (allocated(self%burn_time)) call worker%scalar("burn_time", "s", self%burn_time)
      if (allocated(self%temperature)) call worker%scalar("temperature", "K", self%temperature)
      if (allocated(self%plastic_strain)) &
         call worker%scalar("plastic_strain", "1", self%plastic_strain)
      if (allocated(self%plastic_dilation)) &
         call worker%scalar("plastic_dilation", "1", self%plastic_dilation)
      if (allocated(self%own)) then
         do i = 1, size(self%own)
            call worker%scalar(trim(self%own(i)%name), trim(self%own(i)%unit), self%own(i)%values)
         end do
      end if
      if (allocated(self%porosity)) call worker%scalar("porosity", "1", self%porosity)
      if (allocated(self%damage)) call worker%scalar("damage", "1", self%damage)
      associate (brittle => self%brittle, recorded => self%recorded)
         if (allocated(brittle%scatter)) call worker%scalar("scatter", "1", brittle%scatter)
         if (allocated(brittle%overload)) call worker%scalar("overload", "1", brittle%overload)
         if (allocated(brittle%bulking)) call worker%scalar("bulking", "Pa", brittle%bulking)
         if (allocated(self%solid_fraction)) &
            call worker%scalar("solid_fraction", "1", self%solid_fraction)
         if (allocated(self%deformation_gradient)) &
            call worker%vector("deformation_gradient", "1", self%deformation_gradient)
         if (allocated(recorded%equivalent_strain)) &
            call worker%scalar("equivalent_strain", "1", recorded%equivalent_strain)
         if (allocated(recorded%inertial_number)) &
            call worker%scalar("inertial_number", "1", recorded%inertial_number)
      end associate
      if (allocated(self%failed)) call worker%whole("failed", "1", self%failed)
   end subroutine material_walk

   !> Index in `own` of the field of a single model; 0 if there is none of this name.
   pure integer function material_own_index(self, name) result(index)
      class(material_state_t), intent(in) :: self
      character(len=*), intent(in) :: name           !! Name of the field

      do index = size(self%own), 1, -1
         if (self%own(index)%name == name) return
      end do
   end function material_own_index

   !> Allocate the scratch for a number of particles. Its contents are lost.
   pure subroutine deformation_reserve(self, particles)
      class(deformation_t), intent(inout) :: self
      integer, intent(in) :: particles               !! Most particles in a tile
      integer :: n

      if (allocated(self%dilatation)) then
         if (size(self%dilatation) >= particles) return
         deallocate (self%gradient, self%old_volume, self%dilatation, self%jump, self%pressure, &
            self%pressure_floor, self%plastic_increment, self%distension, self%gruneisen, &
            self%wave_speed, self%plastic_work, self%viscous_work, self%strength%homologous, &
            self%strength%old_damage, self%strength%strain_rate, self%strength%dilation, &
            self%strength%tangent, self%strength%shear_ratio, self%damage%bound, &
            self%damage%load, self%damage%crushing, self%damage%work, self%damage%mean, &
            self%voids%alpha, &
            self%voids%loose, self%voids%old_pressure, self%voids%old_temperature, &
            self%voids%total_volume)
      end if
      ! Greater than the number, because columns whose length is a power of two would map to few
      ! cache sets.
      n = 64*((particles + 63)/64) + 8
      allocate (self%gradient(n, 9), self%old_volume(n), self%dilatation(n), self%jump(n), &
         self%pressure(n), self%pressure_floor(n), self%plastic_increment(n), self%distension(n), &
         self%gruneisen(n), self%wave_speed(n), self%plastic_work(n), self%viscous_work(n), &
         self%strength%homologous(n), self%strength%old_damage(n), self%strength%strain_rate(n), &
         self%strength%dilation(n), self%strength%tangent(n), self%strength%shear_ratio(n), &
         self%damage%bound(n), self%damage%load(n), self%damage%crushing(n), &
         self%damage%work(n), self%damage%mean(n), self%voids%alpha(n), self%voids%loose(n), &
         self%voids%old_pressure(n), self%voids%old_temperature(n), self%voids%total_volume(n))
   end subroutine deformation_reserve
end module material_state
