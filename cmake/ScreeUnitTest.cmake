# SPDX-License-Identifier: BSD-3-Clause
#   scree_unit_test(path/to/test_name.pf LABEL unit [LAYER material | ALONE])
# builds one .pf file into one program that sees the modules of a folder of src/ and of those below
# it (ALONE: of none), and registers it with CTest on as many ranks as its greatest npes. With the
# label none it is only built. A test waits for the libraries that it sees and no others, so tests of
# lower layers are compiled beside the upper ones. A test that needs an upper layer says so in a line
# `! layer: io`.

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

function(scree_unit_test file)
   cmake_parse_arguments(unit "ALONE" "LABEL;LAYER" "" ${ARGN})
   get_filename_component(name "${file}" NAME_WE)
   set(layers)
   file(STRINGS "${file}" marks REGEX "^! layer: ")
   if(marks MATCHES "^! layer: *([a-z]+)")
      set(unit_LAYER "${CMAKE_MATCH_1}")
   endif()
   if(NOT unit_ALONE)
      get_property(all_layers GLOBAL PROPERTY scree_layers)
      foreach(layer IN LISTS all_layers)
         list(APPEND layers ${layer})
         if(layer STREQUAL "scree_${unit_LAYER}")
            break()
         endif()
      endforeach()
   endif()
   scree_ranks_of("${file}" ranks)
   if(PFUNIT_FOUND)
      scree_with_pfunit(${name} "${file}" ${ranks})
   else()
      scree_with_translator(${name} "${file}" ${ranks} ${unit_LABEL})
   endif()
   target_link_libraries(${name} ${layers} OpenMP::OpenMP_Fortran)
   if(TEST ${name})
      scree_cost_of(${name} cost)
      set_tests_properties(${name} PROPERTIES LABELS "${unit_LABEL};smoke;full" TIMEOUT 120
         COST ${cost} ENVIRONMENT "${scree_test_environment}")
      if(ranks GREATER 1)
         set_tests_properties(${name} PROPERTIES PROCESSORS ${ranks})
      endif()
   endif()
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

function(scree_with_translator name file ranks label)
   set(folder "${CMAKE_CURRENT_BINARY_DIR}/${name}")
   set(translator "${PROJECT_SOURCE_DIR}/test/pfunit/translate.py")
   file(MAKE_DIRECTORY "${folder}")
   add_custom_command(
      OUTPUT "${folder}/${name}.f90" "${folder}/run_${name}.f90"
      COMMAND "${scree_python}" "${translator}" "${file}" "${folder}/${name}.f90"
         "${folder}/run_${name}.f90"
      DEPENDS "${file}" "${translator}"
      COMMENT "Translating ${name}.pf" VERBATIM)
   add_executable(${name} "${folder}/${name}.f90" "${folder}/run_${name}.f90")
   set_target_properties(${name} PROPERTIES
      Fortran_MODULE_DIRECTORY "${folder}" RUNTIME_OUTPUT_DIRECTORY "${folder}")
   target_compile_options(${name} PRIVATE ${scree_line_flags})
   target_link_libraries(${name} scree_unit_options scree_pfunit)
   if(label STREQUAL "none")
      return()
   endif()
   if(NOT SCREE_MPI)
      if(ranks LESS 2)
         add_test(NAME ${name} COMMAND ${name})
      endif()
   elseif(ranks GREATER 0)
      add_test(NAME ${name} COMMAND ${scree_mpiexec} ${ranks} $<TARGET_FILE:${name}>)
   else()
      add_test(NAME ${name} COMMAND ${name})
   endif()
endfunction()
