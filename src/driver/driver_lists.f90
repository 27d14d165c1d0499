! SPDX-License-Identifier: BSD-3-Clause
!> What the program can list of itself: materials, fields, shapes.
module driver_lists
   use base_schema, only: schema_t
   use exact_catalogue, only: exact_names
   use io_fields, only: field_names
   use material_catalogue, only: damage_names, eos_names, law_names
   use material_type, only: declare_material_keys
   implicit none
   private

   public :: list_text

contains

   !> The list of a name that the command line allows.
   function list_text(name) result(text)
      character(len=*), intent(in) :: name           !! materials, fields or shapes
      character(len=:), allocatable :: text

      select case (name)
      case ("fields")
         text = joined(field_names)
      case ("shapes")
         text = joined([character(len=12) :: "box", "sphere", "cylinder", "cone", "ellipsoid", &
            "torus", "halfspace", "stl", "union", "difference", "intersection"])
      case default
         text = "strength_model: "//joined(law_names)//new_line("a")//"eos_model: " &
            //joined(eos_names)//new_line("a")//"damage_model: "//joined(damage_names) &
            //new_line("a")//"solution: "//joined(exact_names)//new_line("a")// &
            "preset:"//preset_lines()
      end select
   end function list_text

   !> One line a preset.
   function preset_lines() result(text)
      character(len=:), allocatable :: text
      type(schema_t) :: schema
      integer :: n

      call declare_material_keys(schema)
      text = ""
      do n = 1, size(schema%presets)
         text = text//new_line("a")//"   "//schema%presets(n)%name// &
            repeat(" ", max(20 - len(schema%presets(n)%name), 1))//schema%presets(n)%title
      end do
   end function preset_lines

   !> Words with blanks between them.
   pure function joined(words) result(text)
      character(len=*), intent(in) :: words(:)       !! The words
      character(len=:), allocatable :: text
      integer :: n

      text = ""
      do n = 1, size(words)
         if (n > 1) text = text//" "
         text = text//trim(words(n))
      end do
   end function joined
end module driver_lists
