! SPDX-License-Identifier: BSD-3-Clause
!> Command lines that print a text and start no run: help, version, template, explanations, lists,
!! digests.
module program_information
   use base_communicator, only: communicator_t
   use base_error, only: error_t
   use base_file, only: print_text
   use deck_schema, only: schema_t
   use deck_schema_text, only: explain, template
   use io_digest, only: file_digest
   use program_command, only: information_request_t
   use program_examples, only: examples_text
   use program_help, only: help_text
   use program_lists, only: list_text
   use run_log_files, only: version_line
   use run_messages, only: explain_message, is_message
   implicit none
   private

   public :: print_information

contains

   !> Print the text that the command line requests. Needs no message passing.
   subroutine print_information(request, schema, error)
      type(information_request_t), intent(in) :: request !! One of them is set
      type(schema_t), intent(in) :: schema           !! All keys of a deck
      type(error_t), allocatable, intent(out) :: error !! No such key, list or file
      type(communicator_t) :: communicator
      character(len=:), allocatable :: text
      character(len=16) :: digest

      if (request%help) then
         text = help_text()
      else if (request%version) then
         text = version_line()
      else if (request%template) then
         text = template(schema)
      else if (allocated(request%explain)) then
         if (is_message(request%explain)) then
            call explain_message(request%explain, text, error)
         else
            call explain(schema, request%explain, text, error)
         end if
      else if (allocated(request%list)) then
         if (request%list == "examples") then
            call examples_text(text, error)
         else
            text = list_text(request%list, schema)
         end if
      else
         call file_digest(communicator, request%digest, digest, error)
         text = digest
      end if
      if (allocated(error)) return
      if (text(max(len(text), 1):) == new_line("a")) text = text(:len(text) - 1)
      call print_text(text//new_line("a"), error)
   end subroutine print_information
end module program_information
