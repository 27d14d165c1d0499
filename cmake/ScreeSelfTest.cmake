# SPDX-License-Identifier: BSD-3-Clause
# Decks of the self-test and their digests as Fortran arrays.
#
#   scree_self_test(OUTPUT file TEMPLATE file)
#
# The scenes are self_test/NAME.nml; self_test/digests.csv has lines KIND,NAME,DIGEST.

function(scree_self_test)
   cmake_parse_arguments(test "" "OUTPUT;TEMPLATE" "" ${ARGN})
   set(folder "${CMAKE_CURRENT_SOURCE_DIR}/self_test")
   file(GLOB decks CONFIGURE_DEPENDS "${folder}/*.nml")
   set(names)
   set(name_length 0)
   foreach(deck IN LISTS decks)
      set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${deck}")
      get_filename_component(name "${deck}" NAME_WE)
      list(APPEND names "\"${name}\"")
      string(LENGTH "${name}" length)
      if(length GREATER name_length)
         set(name_length ${length})
      endif()
      file(READ "${deck}" text)
      if(text MATCHES "[][;\"]")
         message(FATAL_ERROR "${deck} must not contain brackets, semicolons and double quotes")
      endif()
      string(REGEX REPLACE "\n+$" "" text "${text}")
      string(REPLACE "\n" "\", &\n      \"" text "${text}")
      string(APPEND scene_arrays
         "   character(len=*), parameter :: deck_${name}(*) = [character(len=deck_line_length) :: &\n"
         "      \"${text}\"]\n")
      string(APPEND scene_cases "      case (\"${name}\")\n         lines = deck_${name}\n")
   endforeach()
   list(JOIN names ", " scene_names)
   set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${folder}/digests.csv")
   file(STRINGS "${folder}/digests.csv" lines REGEX "^[^#].*,.*,[0-9a-f]+$")
   foreach(line IN LISTS lines)
      string(REGEX MATCH "^(.*),(.*),([0-9a-f]+)$" line "${line}")
      string(APPEND digest_cases
         "      case (\"${CMAKE_MATCH_1} ${CMAKE_MATCH_2}\")\n         digest = \"${CMAKE_MATCH_3}\"\n")
   endforeach()
   configure_file("${test_TEMPLATE}" "${test_OUTPUT}" @ONLY)
   # The texts need no optimisation, and doubled quotes can make lines long.
   set_property(SOURCE "${test_OUTPUT}" PROPERTY COMPILE_OPTIONS ${scree_line_flags} -O0)
endfunction()
