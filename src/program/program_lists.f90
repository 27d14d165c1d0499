! SPDX-License-Identifier: BSD-3-Clause
!> Lists of `scree --list`: models of materials, fields, shapes, units, messages.
module program_lists
   use base_text, only: join
   use deck_schema, only: schema_t
   use deck_units, only: unit_list
   use exact_catalogue, only: exact_names
   use material_catalogue, only: damage_names, eos_names, law_names
   use material_field_requests, only: field_requests_t
   use material_own_fields, only: own_fields
   use output_history_columns, only: history_names
   use run_messages, only: message_list
   use sample_fields, only: field_names
   use sample_means, only: profile_names
   implicit none
   private

   public :: list_text

contains

   !> The list of a name.
   function list_text(name, schema) result(text)
      !> Accepted by the command line; empty for the names of the lists
      character(len=*), intent(in) :: name
      type(schema_t), intent(in) :: schema           !! All keys of a deck
      character(len=:), allocatable :: text

      select case (name)
      case ("")
         text = lists_text()
      case ("fields")
         text = joined(field_names())//new_line("a")//"profile: "//joined(profile_names) &
            //new_line("a")//"history: "//join(history_names(), " ") &
            //own_field_lines()
      case ("shapes")
         associate (region => schema%groups(schema%find("region")))
            text = join(region%keys(region%find("shape"))%words, " ")
         end associate
      case ("messages")
         text = message_list()
      case ("units")
         text = unit_list()
      case default
         text = "strength_model: "//joined(law_names)//new_line("a")//"eos_model: " &
            //joined(eos_names)//new_line("a")//"damage_model: "//joined(damage_names) &
            //new_line("a")//"solution: "//joined(exact_names)//new_line("a")// &
            "preset:"//preset_lines(schema)
      end select
   end function list_text

   !> Names of the lists.
   pure function lists_text() result(text)
      character(len=:), allocatable :: text
      character(len=*), parameter :: newline = new_line("a")

      text = "scree --list WHAT, where WHAT is one of"//newline// &
         "   materials   models of materials, exact solutions and presets"//newline// &
         "   fields      fields of outputs, columns of histories"//newline// &
         "   shapes      shapes of regions"//newline// &
         "   units       units and systems of units"//newline// &
         "   examples    scenes that scree --new copies"//newline// &
         "   messages    errors and warnings with their codes"
   end function lists_text

   !> One line for each preset.
   pure function preset_lines(schema) result(text)
      type(schema_t), intent(in) :: schema
      character(len=:), allocatable :: text
      integer :: n

      text = ""
      do n = 1, size(schema%presets)
         text = text//new_line("a")//"   "//schema%presets(n)%name// &
            repeat(" ", max(20 - len(schema%presets(n)%name), 1))//schema%presets(n)%title
      end do
   end function preset_lines

   !> One line for each field that single models describe: name, unit, meaning, models.
   function own_field_lines() result(text)
      character(len=:), allocatable :: text
      type(field_requests_t) :: own
      integer :: i

      own = own_fields()
      text = ""
      do i = 1, size(own%entries)
         associate (entry => own%entries(i))
            text = text//new_line("a")//"   "//entry%field//" ["//entry%unit//"]  "// &
               entry%meaning//"; "//entry%reason
         end associate
      end do
   end function own_field_lines

   !> Words with blanks between them.
   pure function joined(words) result(text)
      character(len=*), intent(in) :: words(:)       !! With trailing blanks
      character(len=:), allocatable :: text
      integer :: n

      text = ""
      do n = 1, size(words)
         if (n > 1) text = text//" "
         text = text//trim(words(n))
      end do
   end function joined
end module program_lists
