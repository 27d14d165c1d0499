# SPDX-License-Identifier: BSD-3-Clause
#   scree_script_tests(verify [folder])
# registers test_*.py of a folder of test/, and of the folders in it, with the name of the folder as
# label, as   python FILE --scree PROGRAM --work FOLDER   with SCREE and WORK in the environment too.

function(scree_script_tests label)
   set(folder "${PROJECT_SOURCE_DIR}/test/${label}")
   file(GLOB scripts CONFIGURE_DEPENDS "${folder}/test_*.py" "${folder}/*/test_*.py")
   foreach(script IN LISTS scripts)
      scree_script_test("${script}" ${label})
   endforeach()
endfunction()

function(scree_script_test script label)
   file(RELATIVE_PATH name "${PROJECT_SOURCE_DIR}/test" "${script}")
   string(REGEX REPLACE "\\.py$" "" name "${name}")
   set(work "${PROJECT_BINARY_DIR}/test/${name}")
   set(program "${PROJECT_BINARY_DIR}/bin/scree")
   set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${script}")
   file(STRINGS "${script}" marks REGEX "^# (label|timeout): ")
   set(labels ${label})
   set(timeout 300)
   foreach(mark IN LISTS marks)
      if(mark MATCHES "^# label: *(.*)$")
         string(REGEX REPLACE "[ ,]+" ";" more "${CMAKE_MATCH_1}")
         list(APPEND labels ${more})
      elseif(mark MATCHES "^# timeout: *([0-9]+)")
         set(timeout ${CMAKE_MATCH_1})
      endif()
   endforeach()
   add_test(NAME ${name}
      COMMAND "${scree_python}" "${script}" --scree "${program}" --work "${work}"
      WORKING_DIRECTORY "${PROJECT_SOURCE_DIR}")
   set(processors 2)
   if(label STREQUAL "gate")
      set(processors 1)
   endif()
   set(environment ${scree_test_environment} "SCREE=${program}" "WORK=${work}"
      "PYTHONPATH=${PROJECT_SOURCE_DIR}/test/support" PYTHONDONTWRITEBYTECODE=1)
   set_tests_properties(${name} PROPERTIES
      LABELS "${labels}" TIMEOUT ${timeout} PROCESSORS ${processors} SKIP_RETURN_CODE 77
      ENVIRONMENT "${environment}")
endfunction()
