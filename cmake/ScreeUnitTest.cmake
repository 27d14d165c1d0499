# SPDX-License-Identifier: BSD-3-Clause
#   scree_unit_tests(unit_material FILES test_a.pf test_b.pf LABEL unit [LAYER material] [LINKS library])
# builds .pf files into one program that sees the modules of a folder of src/ and of those below it
# (without LAYER: of none), and registers each file with CTest under its own name. A program without
# arguments runs the tests of all files, with the name of a file those of this file, on as many ranks
# as the greatest npes of the file; files with and without ranks are in different programs. With the
# label none a program is only built. A program waits for the libraries that it sees and no others, so tests of lower
# layers are compiled beside the upper ones.
#
# pFUnit makes one program of each file.

# Tests are compiled once and run once: code that is not optimised is compiled in half the time.
add_library(scree_unit_options INTERFACE)
target_compile_options(scree_unit_options INTERFACE
   ${scree_language_flags}
   ${scree_warning_flags}
   "$<$<CONFIG:Release>:-O0>"
   "$<$<CONFIG:Debug>:${scree_debug_flags}>"
   "$<$<CONFIG:Sanitize>:${scree_sanitize_flags}>")
target_link_options(scree_unit_options INTERFACE
   "$<$<CONFIG:Sanitize>:-fsanitize=address,undefined>")

# Greatest number in npes=[...]; 0 for a test without ranks.
function(scree_ranks_of file result)
   set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${file}")
   file(STRINGS "${file}" marks REGEX "^[ \t]*@test.*npes")
   set(greatest 0)
   foreach(mark IN LISTS marks)
      string(REGEX MATCHALL "[0-9]+" numbers "${mark}")
      foreach(number IN LISTS numbers)
         if(number GREATER greatest)
            set(greatest ${number})
         endif()
      endforeach()
   endforeach()
   set(${result} ${greatest} PARENT_SCOPE)
endfunction()

function(scree_unit_tests program)
   cmake_parse_arguments(unit "" "LABEL;LAYER" "FILES;LINKS" ${ARGN})
   set(layers)
   if(unit_LAYER)
      get_property(all_layers GLOBAL PROPERTY scree_layers)
      foreach(layer IN LISTS all_layers)
         list(APPEND layers ${layer})
         if(layer STREQUAL "scree_${unit_LAYER}")
            break()
         endif()
      endforeach()
   endif()
   if(NOT PFUNIT_FOUND)
      scree_translated_program(${program} "${unit_FILES}")
      target_link_libraries(${program} ${unit_LINKS} ${layers} OpenMP::OpenMP_Fortran)
   endif()
   if(unit_LABEL STREQUAL "none")
      return()
   endif()
   foreach(file IN LISTS unit_FILES)
      get_filename_component(name "${file}" NAME_WE)
      scree_ranks_of("${file}" ranks)
      if(PFUNIT_FOUND)
         scree_with_pfunit(${name} "${file}" ${ranks})
         target_link_libraries(${name} ${unit_LINKS} ${layers} OpenMP::OpenMP_Fortran)
      elseif(NOT SCREE_MPI)
         if(ranks LESS 2)
            add_test(NAME ${name} COMMAND ${scree_costing} $<TARGET_FILE:${program}> ${name})
         endif()
      elseif(ranks GREATER 0)
         add_test(NAME ${name} COMMAND ${scree_costing} ${scree_mpiexec} ${ranks} $<TARGET_FILE:${program}> ${name})
      else()
         add_test(NAME ${name} COMMAND ${scree_costing} $<TARGET_FILE:${program}> ${name})
      endif()
      if(TEST ${name})
         scree_cost_of(${name} cost)
         set_tests_properties(${name} PROPERTIES LABELS "${unit_LABEL};smoke;full" TIMEOUT 120
            COST ${cost} ENVIRONMENT "${scree_test_environment}")
         if(ranks GREATER 1)
            set_tests_properties(${name} PROPERTIES PROCESSORS ${ranks})
         endif()
      endif()
   endforeach()
endfunction()

function(scree_with_pfunit name file ranks)
   # pFUnit puts what it makes of a relative path into the build folder.
   file(RELATIVE_PATH relative "${CMAKE_CURRENT_SOURCE_DIR}" "${file}")
   if(ranks GREATER 0)
      add_pfunit_ctest(${name} TEST_SOURCES "${relative}" MAX_PES ${ranks})
   else()
      add_pfunit_ctest(${name} TEST_SOURCES "${relative}")
   endif()
   set_target_properties(${name} PROPERTIES Fortran_PREPROCESS ON
      RUNTIME_OUTPUT_DIRECTORY "${CMAKE_CURRENT_BINARY_DIR}")
   target_link_libraries(${name} scree_mpi)
endfunction()

function(scree_translated_program program files)
   set(folder "${CMAKE_CURRENT_BINARY_DIR}/${program}")
   set(translator "${PROJECT_SOURCE_DIR}/test/pfunit/translate.py")
   file(MAKE_DIRECTORY "${folder}")
   set(sources "${folder}/${program}.f90")
   foreach(file IN LISTS files)
      get_filename_component(name "${file}" NAME_WE)
      list(APPEND sources "${folder}/${name}.f90")
   endforeach()
   add_custom_command(
      OUTPUT ${sources}
      COMMAND "${scree_python}" "${translator}" "${folder}" ${program} ${files}
      DEPENDS ${files} "${translator}"
      COMMENT "Translating the tests of ${program}" VERBATIM)
   add_executable(${program} ${sources})
   set_target_properties(${program} PROPERTIES
      Fortran_MODULE_DIRECTORY "${folder}" RUNTIME_OUTPUT_DIRECTORY "${folder}")
   target_compile_options(${program} PRIVATE ${scree_line_flags})
   target_link_libraries(${program} scree_unit_options scree_pfunit)
endfunction()
