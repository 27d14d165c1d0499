# SPDX-License-Identifier: BSD-3-Clause
#   scree_script_tests(label [folder])
# registers test_*.py of test/LABEL, or of another folder of test/, and of the folders in it, with this
# label, as   pytest FILE --scree PROGRAM --work FOLDER --tier TIER   with the fixtures of test/conftest.py.
#
# Lines in the head of a test file:
#   # tiers: smoke, full, long    in which tiers it does something of its own (default: full)
#   # timeout: 300                seconds; `# timeout long: 3600` for one tier
#   # cores: 2                    how many it keeps busy for most of its time (default: 1)
# A file is registered once for each of its tiers: as NAME for full,
# NAME.smoke and NAME.long for the others. A test whose only mark is `smoke` is the same in smoke and
# full and is registered once, with both labels; so is one whose only mark is `long`, as NAME.

function(scree_script_tests label)
   if(scree_without_pytest)
      return()
   endif()
   set(folder "${PROJECT_SOURCE_DIR}/test/${label}")
   if(ARGC GREATER 1)
      set(folder "${PROJECT_SOURCE_DIR}/test/${ARGV1}")
   endif()
   file(GLOB scripts CONFIGURE_DEPENDS "${folder}/test_*.py" "${folder}/*/test_*.py")
   foreach(script IN LISTS scripts)
      scree_script_test("${script}" ${label})
   endforeach()
endfunction()

# First value of a mark in the head of a file, or the default.
function(scree_mark marks key default result)
   set(${result} "${default}" PARENT_SCOPE)
   foreach(mark IN LISTS marks)
      if(mark MATCHES "^# ${key}: *(.*)$")
         set(${result} "${CMAKE_MATCH_1}" PARENT_SCOPE)
         return()
      endif()
   endforeach()
endfunction()

function(scree_script_test script label)
   file(RELATIVE_PATH name "${PROJECT_SOURCE_DIR}/test" "${script}")
   string(REGEX REPLACE "\\.py$" "" name "${name}")
   set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${script}")
   file(STRINGS "${script}" marks REGEX "^# (tiers|cores|timeout|timeout (smoke|full|long)): ")
   scree_mark("${marks}" tiers full tiers)
   string(REGEX REPLACE "[ ,]+" ";" tiers "${tiers}")
   foreach(tier IN LISTS tiers)
      if(NOT tier MATCHES "^(smoke|full|long)$")
         message(FATAL_ERROR "${script}: # tiers: ${tier} is none of smoke, full, long")
      endif()
   endforeach()
   if(label STREQUAL "bench")
      scree_register("${script}" ${name} full "bench" "${marks}")
   elseif(tiers STREQUAL "smoke")
      scree_register("${script}" ${name} full "${label};smoke;full" "${marks}")
   elseif(tiers STREQUAL "long")
      scree_register("${script}" ${name} long "${label};long" "${marks}")
   else()
      foreach(tier IN LISTS tiers)
         set(suffix ".${tier}")
         if(tier STREQUAL "full")
            set(suffix "")
         endif()
         scree_register("${script}" ${name}${suffix} ${tier} "${label};${tier}" "${marks}")
      endforeach()
   endif()
endfunction()

function(scree_register script name tier labels marks)
   set(work "${PROJECT_BINARY_DIR}/test/${name}")
   set(program "${PROJECT_BINARY_DIR}/bin/scree")
   scree_mark("${marks}" cores 1 cores)
   scree_mark("${marks}" timeout 300 timeout)
   scree_mark("${marks}" "timeout ${tier}" ${timeout} timeout)
   add_test(NAME ${name}
      COMMAND "${scree_python}" -m pytest "${script}" --scree "${program}" --work "${work}" --tier ${tier}
      WORKING_DIRECTORY "${PROJECT_SOURCE_DIR}")
   # plugins of other packages take time and are not needed
   set(environment ${scree_test_environment} PYTEST_DISABLE_PLUGIN_AUTOLOAD=1 PYTHONDONTWRITEBYTECODE=1)
   scree_cost_of(${name} cost)
   set_tests_properties(${name} PROPERTIES
      LABELS "${labels}" TIMEOUT ${timeout} PROCESSORS ${cores} SKIP_RETURN_CODE 77 COST ${cost}
      ENVIRONMENT "${environment}")
endfunction()
