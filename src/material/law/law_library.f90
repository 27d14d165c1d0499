! SPDX-License-Identifier: BSD-3-Clause
!> Strength law of the user in a shared library. It gets the rotated stress with the elastic trial,
!! or for a whole stress without it, and returns the stress after the step. Equations (Y.9) and
!! (Y.10) of doc/theory/strength.md.
module law_library
   use base_kinds, only: int64, wp
   use base_text, only: append, brief, number, text_t
   use deck_group_values, only: group_t
   use deck_schema, only: changes_physics, schema_t
   use, intrinsic :: iso_c_binding, only: c_char, c_double, c_int32_t, c_int64_t, c_loc, &
      c_null_char, c_null_ptr, c_ptr
   use base_libc, only: text_at
   use material_effects, only: effects_t
   use material_field_requests, only: field_requests_t
   use material_kinematics, only: corotate_strain, predict_deviator
   use material_law, only: law_add_wave_speed, law_stored_energy, law_t
   use material_library, only: library_rows_t, library_t, longest_message
   use material_library_constants, only: read_library_constants
   use material_library_text, only: most_constants, most_law_fields
   use material_state, only: deformation_t, material_state_t
   implicit none
   private

   public :: law_library_t

   integer, parameter :: most_rows = 256             !! Rows of a call
   !> A NaN whose lower half is the error of a library.
   integer(int64), parameter :: error_bits = int(z"7FF85C4E00000000", int64)
   integer(int64), parameter :: lower_half = int(z"00000000FFFFFFFF", int64)

   !> Law of a library. Without a library, after an error in the deck, it is elastic.
   type, extends(law_t) :: law_library_t
      type(library_t) :: library                     !! Procedures and declaration
      real(wp), allocatable :: constants(:)          !! In the order of the declaration [SI]
   contains
      procedure :: declare => library_declare        !! Declares its keys
      procedure :: take_library => library_take      !! Gets the library and reads the constants
      procedure :: is_in_library => library_is_in_library !! Returns true
      procedure :: report => library_report          !! Name, constants and digest of the file
      procedure :: gives_whole_stress => library_gives_whole_stress !! As declared
      procedure :: is_plastic => library_is_plastic  !! As declared
      procedure :: request => library_request        !! Requests the history fields
      procedure :: predict_trial => library_predict_trial !! Trial, or the rotated stress alone
      procedure :: update => library_update          !! Calls the library
      procedure :: add_wave_speed => library_add_wave_speed !! With the bulk modulus, if whole
      procedure :: stored_energy => library_stored_energy !! With that of the volume, if whole
      procedure :: fault_of_state => library_fault_of_state !! Error that the library reported
   end type law_library_t

contains

   !> Declare the keys of the law.
   subroutine library_declare(self, schema)
      class(law_library_t), intent(in) :: self
      type(schema_t), intent(inout) :: schema
      character(len=*), parameter :: owner = "effects.strength & strength_model = library"

      call schema%text("material", "library", "shared library with a strength law, see "// &
         "scree_law.h; path relative to the deck", owner=owner)
      call schema%text("material", "library_constants(:64)", "constants of the law in the "// &
         "library, each 'NAME = NUMBER UNIT'; without a unit in SI", owner=owner)
      call schema%text("material", "library_fields", "fields of the law in the library as "// &
         "'NAME [UNIT], ...'; the library gives them, and a deck that states others is refused", &
         default="none", owner=owner)
      call schema%require("material", "library")
      call schema%forbid_change("material", "library_fields", "the particles of the checkpoint "// &
         "have the fields that its library declared")
      call schema%allow_change("material", "library library_constants", changes_physics)
   end subroutine library_declare

   !> Get the library of the deck and read its constants.
   subroutine library_take(self, library, group, system, faults)
      class(law_library_t), intent(inout) :: self
      type(library_t), intent(in) :: library         !! As loaded
      type(group_t), intent(in) :: group             !! &material
      integer, intent(in) :: system                  !! Units of the deck
      type(text_t), allocatable, intent(out) :: faults(:) !! Errors in library_constants
      character(kind=c_char) :: message(longest_message)
      character(len=:), allocatable :: text
      integer :: i

      allocate (faults(0))
      self%library = library
      call read_library_constants(library%declared%constants, group, system, self%constants, faults)
      if (size(faults) > 0 .or. .not. associated(library%check)) return
      message = c_null_char
      if (library%check(self%constants, message, size(message, kind=c_int64_t)) == 0) return
      text = ""
      do i = 1, size(message)
         if (message(i) == c_null_char) exit
         text = text//message(i)
      end do
      call append(faults, "library_constants: the library rejects them: "//text//" [D376]")
   end subroutine library_take

   !> True, unless the library could not be loaded.
   pure logical function library_is_in_library(self) result(is_in)
      class(law_library_t), intent(in) :: self

      is_in = associated(self%library%update)
   end function library_is_in_library

   !> Name of the law, digest of its file, and all constants, also those that the deck leaves out.
   function library_report(self) result(text)
      class(law_library_t), intent(in) :: self
      character(len=:), allocatable :: text
      integer :: n

      text = ""
      if (.not. self%is_in_library()) return
      associate (declared => self%library%declared)
         text = declared%name//" of "//self%library%path//", digest "//self%library%digest
         do n = 1, size(declared%constants)
            text = text//trim(merge("; ", ", ", n == 1))//" "//trim(declared%constants(n)%name// &
               " = "//brief(self%constants(n))//" "//declared%constants(n)%unit_text)
         end do
      end associate
   end function library_report

   !> True if the library declares `stress whole`.
   pure logical function library_gives_whole_stress(self) result(whole)
      class(law_library_t), intent(in) :: self

      whole = self%library%declared%whole
   end function library_gives_whole_stress

   !> False if the library declares `flow none`.
   pure logical function library_is_plastic(self) result(plastic)
      class(law_library_t), intent(in) :: self

      plastic = self%library%declared%plastic
   end function library_is_plastic

   !> Request the fields that the library declares.
   pure subroutine library_request(self, requests)
      class(law_library_t), intent(in) :: self
      class(field_requests_t), intent(inout) :: requests
      integer :: i

      if (.not. allocated(self%library%declared%fields)) return
      associate (declared => self%library%declared)
         if (declared%needs_temperature) call requests%add("temperature", "law "//declared%name, 1)
         if (declared%needs_energy) call requests%add("energy", "law "//declared%name, 1)
         do i = 1, size(declared%fields)
            associate (field => declared%fields(i))
               if (field%name == "plastic_strain") then
                  call requests%add(field%name, "law "//declared%name, 1)
               else
                  call requests%add_own(field%name, field%unit, field%meaning, &
                     "law "//declared%name, field%start)
               end if
            end associate
         end do
      end associate
   end subroutine library_request

   !> Elastic trial; for a whole stress the rotated stress and the strain of the rotated frame.
   pure subroutine library_predict_trial(self, state, deformation, first, last)
      class(law_library_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state       !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range

      if (self%library%declared%whole) then
         call predict_deviator(0.0_wp, state, deformation, first, last)
         call corotate_strain(deformation, last - first + 1)
      else
         call predict_deviator(self%shear, state, deformation, first, last)
      end if
   end subroutine library_predict_trial

   !> Call the library, block by block.
   pure subroutine library_update(self, state, deformation, first, last, dt)
      class(law_library_t), intent(in) :: self
      type(material_state_t), intent(inout) :: state       !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      real(wp), intent(in) :: dt                           !! Time step [s]
      integer :: before

      if (.not. associated(self%library%update)) return
      do before = first - 1, last - 1, most_rows
         call update_rows(self, before, before - (first - 1), min(most_rows, last - before), dt, &
            state, deformation)
      end do
   end subroutine library_update

   !> Call the library for some rows.
   pure subroutine update_rows(law, before, offset, count, dt, state, deformation)
      class(law_library_t), intent(in) :: law
      integer, intent(in) :: before                  !! Index offset in the store
      integer, intent(in) :: offset                  !! Index offset in the range
      integer, intent(in) :: count                   !! Rows
      real(wp), intent(in) :: dt                     !! Time step [s]
      type(material_state_t), intent(inout) :: state       !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      type(library_rows_t), target :: rows
      type(c_ptr), target :: history(most_law_fields)
      real(wp), target :: constants(most_constants)
      real(wp) :: entry(most_rows, 6)
      integer :: component, first, last, n
      logical :: find_work

      first = before + 1
      last = before + count
      associate (declared => law%library%declared)
         find_work = declared%plastic .and. .not. declared%own_work
         if (declared%whole) call join_pressure(before, offset, count, state, deformation)
         if (find_work) then
            do component = 1, 6
               entry(:count, component) = state%stress(first:last, component)
            end do
         end if
         n = size(law%constants)
         constants(:n) = law%constants
         rows%count = int(count, c_int64_t)
         rows%dt = dt
         rows%shear = law%shear
         rows%bulk = law%bulk
         rows%density = law%density
         rows%constants = c_loc(constants)
         rows%history = c_loc(history)
         rows%tools = c_loc(law%library%tools)
         call point_rows(first, offset + 1, declared%whole, state, deformation, rows)
         call point_history(law, first, state, history)
         call law%library%update(c_loc(rows))
         if (rows%error /= 0_c_int32_t) call mark_error(rows, before, state)
         if (declared%whole) call split_pressure(before, offset, count, state, deformation)
         if (find_work) call find_plastic_work(law, before, offset, count, entry, state, &
            deformation)
      end associate
   end subroutine update_rows

   !> Addresses of the rows.
   pure subroutine point_rows(first, begin, whole, state, deformation, rows)
      integer, intent(in) :: first                   !! First particle
      integer, intent(in) :: begin                   !! Its index in the range
      logical, intent(in) :: whole                   !! The pressure is a part of the stress
      type(material_state_t), intent(inout) :: state       !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      type(library_rows_t), intent(inout) :: rows
      integer :: n

      do n = 1, 6
         call point_to(state%stress(first, n), rows%stress(n))
      end do
      do n = 1, 9
         call point_to(deformation%gradient(begin, n), rows%gradient(n))
      end do
      rows%pressure = c_null_ptr
      rows%energy = c_null_ptr
      rows%temperature = c_null_ptr
      rows%damage = c_null_ptr
      if (.not. whole) call point_to(deformation%pressure(begin), rows%pressure)
      if (allocated(state%energy)) call point_to(state%energy(first), rows%energy)
      if (allocated(state%temperature)) call point_to(state%temperature(first), rows%temperature)
      if (allocated(state%damage)) call point_to(state%damage(first), rows%damage)
      call point_to(state%volume(first), rows%volume)
      call point_to(state%mass(first), rows%mass)
      call point_to(deformation%old_volume(begin), rows%old_volume)
      call point_to(deformation%plastic_increment(begin), rows%plastic_increment)
      call point_to(deformation%plastic_work(begin), rows%plastic_work)
      rows%error_row = -1_c_int64_t
      rows%error = 0_c_int32_t
      rows%unused = 0_c_int32_t
   end subroutine point_rows

   !> Addresses of the history fields.
   pure subroutine point_history(law, first, state, history)
      class(law_library_t), intent(in) :: law
      integer, intent(in) :: first                   !! First particle
      type(material_state_t), intent(inout) :: state !! State of the store
      type(c_ptr), intent(inout) :: history(most_law_fields) !! In the order of the declaration
      integer :: n, own

      do n = 1, size(law%library%declared%fields)
         if (law%library%declared%fields(n)%name == "plastic_strain") then
            call point_to(state%plastic_strain(first), history(n))
         else
            own = state%own_index(law%library%declared%fields(n)%name)
            call point_to(state%own(own)%values(first), history(n))
         end if
      end do
   end subroutine point_history

   !> Address of an array element and of those behind it.
   pure subroutine point_to(value, address)
      real(wp), intent(inout), target :: value       !! First of several
      type(c_ptr), intent(out) :: address

      address = c_loc(value)
   end subroutine point_to

   !> Add the mean stress before the step, without its viscous part, to the rotated deviators.
   pure subroutine join_pressure(before, offset, count, state, deformation)
      integer, intent(in) :: before                  !! Index offset in the store
      integer, intent(in) :: offset                  !! Index offset in the range
      integer, intent(in) :: count                   !! Rows
      type(material_state_t), intent(inout) :: state       !! State of the store
      type(deformation_t), intent(in) :: deformation !! With the pressure before the step
      real(wp) :: pressure
      integer :: i, k

      do i = 1, count
         k = before + i
         pressure = deformation%pressure(offset + i)
         if (allocated(state%viscous_pressure)) pressure = pressure - state%viscous_pressure(k)
         state%stress(k, 1) = state%stress(k, 1) - pressure
         state%stress(k, 2) = state%stress(k, 2) - pressure
         state%stress(k, 3) = state%stress(k, 3) - pressure
      end do
   end subroutine join_pressure

   !> Split whole stresses into pressure and deviator.
   pure subroutine split_pressure(before, offset, count, state, deformation)
      integer, intent(in) :: before                  !! Index offset in the store
      integer, intent(in) :: offset                  !! Index offset in the range
      integer, intent(in) :: count                   !! Rows
      type(material_state_t), intent(inout) :: state       !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Gets the pressure
      real(wp) :: mean
      integer :: i, k

      do i = 1, count
         k = before + i
         mean = (state%stress(k, 1) + state%stress(k, 2) + state%stress(k, 3))/3.0_wp
         deformation%pressure(offset + i) = -mean
         state%stress(k, 1) = state%stress(k, 1) - mean
         state%stress(k, 2) = state%stress(k, 2) - mean
         state%stress(k, 3) = state%stress(k, 3) - mean
      end do
   end subroutine split_pressure

   !> Plastic increment and work from the deviators before and after the call: the plastic strain is
   !! the part of the strain increment that the change of stress does not explain elastically, and
   !! its work is that of the mean of the stresses before and after the step. Equations (Y.9) and
   !! (Y.10).
   pure subroutine find_plastic_work(law, before, offset, count, entry, state, deformation)
      class(law_library_t), intent(in) :: law
      integer, intent(in) :: before                  !! Index offset in the store
      integer, intent(in) :: offset                  !! Index offset in the range
      integer, intent(in) :: count                   !! Rows
      real(wp), intent(in) :: entry(most_rows, 6)    !! Stress that the library got [Pa]
      type(material_state_t), intent(in) :: state    !! With the deviators after the step
      type(deformation_t), intent(inout) :: deformation !! Gets increment and work
      real(wp), parameter :: weight(6) = [1.0_wp, 1.0_wp, 1.0_wp, 2.0_wp, 2.0_wp, 2.0_wp]
      real(wp) :: flow(6), mean(6), old(6), strain(6)
      integer :: i, k

      do i = 1, count
         k = before + i
         call strain_deviator(deformation%gradient(offset + i, :), strain)
         old = entry(i, :)
         old(1:3) = old(1:3) - (old(1) + old(2) + old(3))/3.0_wp
         ! the trial is not a part of a whole stress
         if (.not. law%library%declared%whole) old = old - 2.0_wp*law%shear*strain
         flow = strain - (state%stress(k, 1:6) - old)/(2.0_wp*law%shear)
         mean = 0.5_wp*(state%stress(k, 1:6) + old)
         deformation%plastic_increment(offset + i) = sqrt(2.0_wp/3.0_wp*sum(weight*flow**2))
         deformation%plastic_work(offset + i) = state%volume(k)*max(0.0_wp, sum(weight*mean*flow))
      end do
   end subroutine find_plastic_work

   !> Deviator of the strain increment of a gradient.
   pure subroutine strain_deviator(g, strain)
      real(wp), intent(in) :: g(:)                   !! Of k + 3 (l - 1) [1]
      real(wp), intent(out) :: strain(6)             !! xx, yy, zz, xy, yz, xz [1]
      real(wp) :: mean

      mean = (g(1) + g(5) + g(9))/3.0_wp
      strain = [g(1) - mean, g(5) - mean, g(9) - mean, 0.5_wp*(g(4) + g(2)), &
         0.5_wp*(g(8) + g(6)), 0.5_wp*(g(7) + g(3))]
   end subroutine strain_deviator

   !> Store the error of a library in the stress of its row, or of all rows of the call: a NaN,
   !! which stops the run, with the number of the error.
   pure subroutine mark_error(rows, before, state)
      type(library_rows_t), intent(in) :: rows
      integer, intent(in) :: before                  !! Index offset in the store
      type(material_state_t), intent(inout) :: state !! State of the store
      integer :: first, last

      first = before + 1
      last = before + int(rows%count)
      if (rows%error_row >= 0 .and. rows%error_row < rows%count) then
         first = before + 1 + int(rows%error_row)
         last = first
      end if
      state%stress(first:last, :) = transfer(ior(error_bits, iand(int(rows%error, int64), &
         lower_half)), 0.0_wp)
   end subroutine mark_error

   !> Add the contribution to the square of the wave speed; for a whole stress also that of the bulk
   !! modulus.
   pure subroutine library_add_wave_speed(self, state, deformation, first, last)
      class(law_library_t), intent(in) :: self
      type(material_state_t), intent(in) :: state          !! State of the store
      type(deformation_t), intent(inout) :: deformation    !! Step of the range
      integer, intent(in) :: first, last                   !! Particles of the range
      integer :: count

      count = last - first + 1
      if (self%library%declared%whole) deformation%wave_speed(:count) = &
         deformation%wave_speed(:count) + self%bulk*state%volume(first:last)/state%mass(first:last)
      call law_add_wave_speed(self, state, deformation, first, last)
   end subroutine library_add_wave_speed

   !> Energy [J] stored in the stress of a particle; a whole stress has a part of the volume.
   pure real(wp) function library_stored_energy(self, state, particle) result(energy)
      class(law_library_t), intent(in) :: self
      type(material_state_t), intent(in) :: state    !! State of the store
      integer, intent(in) :: particle                !! Index in the store
      real(wp) :: pressure

      energy = law_stored_energy(self, state, particle)
      if (.not. self%library%declared%whole) return
      pressure = -sum(state%stress(particle, 1:3))/3.0_wp
      if (allocated(state%viscous_pressure)) pressure = pressure - state%viscous_pressure(particle)
      energy = energy + state%volume(particle)*pressure**2/(2.0_wp*self%bulk)
   end function library_stored_energy

   !> Error that the library reported for a particle; empty if there is none.
   function library_fault_of_state(self, state, particle) result(text)
      class(law_library_t), intent(in) :: self
      type(material_state_t), intent(in) :: state    !! State of the store
      integer, intent(in) :: particle                !! Index in the store
      character(len=:), allocatable :: text
      character(len=:), allocatable :: meaning
      integer(int64) :: bits
      integer(c_int32_t) :: error

      text = ""
      if (.not. associated(self%library%update)) return
      bits = transfer(state%stress(particle, 1), bits)
      if (iand(bits, not(lower_half)) /= error_bits) return
      error = transfer(iand(bits, lower_half), error)
      text = "the library '"//self%library%path//"' of its law reports error "// &
         number(int(error))//" [R104]"
      if (.not. associated(self%library%explain)) return
      meaning = text_at(self%library%explain(error), longest_message)
      if (meaning /= "") text = text//": "//meaning
   end function library_fault_of_state
end module law_library
