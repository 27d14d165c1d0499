# SPDX-License-Identifier: BSD-3-Clause
# Texts of messages as Fortran arrays.
#
#   scree_messages(OUTPUT file TEMPLATE file SECTIONS format values ... EXAMPLES examples)
#
# Each section is a text file, messages/NAME.txt, of records that begin with a line [CODE]. Each
# record becomes an array of lines, since a statement has at most 255 continuation lines.

# Appends the records of a text file to <kind>_codes, <kind>_arrays and <kind>_cases of the caller.
function(scree_message_records source kind)
   set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${source}")
   file(READ "${source}" text)
   # Semicolons and brackets mean something in lists of CMake, so they are put aside.
   string(REPLACE ";" "@semicolon@" text "\n${text}")
   string(REPLACE "[" "@open@" text "${text}")
   string(REPLACE "]" "@close@" text "${text}")
   string(REPLACE "\"" "\"\"" text "${text}")
   string(REGEX REPLACE "\n@open@([A-Z][0-9][0-9][0-9])@close@\n" "\n;\\1\n" records "${text}")
   foreach(record IN LISTS records)
      if(record MATCHES "^([A-Z][0-9][0-9][0-9])\n(.*)$")
         set(code "${CMAKE_MATCH_1}")
         string(REGEX REPLACE "\n+$" "" lines "${CMAKE_MATCH_2}")
         string(REPLACE "\n" "\", &\n      \"" lines "${lines}")
         string(REPLACE "@semicolon@" ";" lines "${lines}")
         string(REPLACE "@open@" "[" lines "${lines}")
         string(REPLACE "@close@" "]" lines "${lines}")
         string(APPEND ${kind}_arrays
            "   character(len=*), parameter :: ${kind}_${code}(*) = "
            "[character(len=line_length) :: &\n      \"${lines}\"]\n")
         string(APPEND ${kind}_cases
            "      case (\"${code}\")\n         lines = ${kind}_${code}\n")
         list(APPEND ${kind}_codes "\"${code}\"")
      endif()
   endforeach()
   foreach(part codes arrays cases)
      set(${kind}_${part} "${${kind}_${part}}" PARENT_SCOPE)
   endforeach()
endfunction()

function(scree_messages)
   cmake_parse_arguments(messages "" "OUTPUT;TEMPLATE;EXAMPLES" "SECTIONS" ${ARGN})
   set(folder "${CMAKE_CURRENT_SOURCE_DIR}/messages")
   foreach(section IN LISTS messages_SECTIONS)
      scree_message_records("${folder}/${section}.txt" message)
   endforeach()
   scree_message_records("${folder}/${messages_EXAMPLES}.txt" example)
   set(message_arrays "${message_arrays}${example_arrays}")
   list(JOIN message_codes ", " message_codes)
   string(REGEX REPLACE "(\"[A-Z0-9]+\", \"[A-Z0-9]+\", \"[A-Z0-9]+\", \"[A-Z0-9]+\", )" "      \\1&\n"
      message_codes "${message_codes}")
   configure_file("${messages_TEMPLATE}" "${messages_OUTPUT}" @ONLY)
   # Doubled quotes can make lines long; the texts need no optimisation.
   set_property(SOURCE "${messages_OUTPUT}" PROPERTY COMPILE_OPTIONS ${scree_line_flags} -O0)
endfunction()
