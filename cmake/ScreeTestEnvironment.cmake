# SPDX-License-Identifier: BSD-3-Clause
# With what tests run: environment, mpiexec, Python.

# More ranks than cores, root in a container and no network are the normal case of a test machine; as in
# test/support/case.py. Ranks and threads that wait release their cores to other tests. Runs without mpiexec would all
# use one session folder of Open MPI and fail if two create it at once; only mpiexec needs it.
set(scree_test_environment
   OMP_NUM_THREADS=2 OMP_PROC_BIND=false OMP_WAIT_POLICY=passive OMPI_MCA_mpi_yield_when_idle=1
   OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
   OMPI_MCA_rmaps_base_oversubscribe=1 OMPI_MCA_btl=self,vader OMPI_MCA_pml=ob1
   OMPI_MCA_ess_singleton_isolated=1 OMPI_MCA_orte_create_session_dirs=0 OMPI_MCA_btl_vader_single_copy_mechanism=none
   OMPI_MCA_hwloc_base_binding_policy=none
   PRTE_MCA_rmaps_default_mapping_policy=:oversubscribe PRTE_MCA_hwloc_default_binding_policy=none)
set(scree_mpiexec ${CMAKE_COMMAND} -E env OMPI_MCA_orte_create_session_dirs=1 "${MPIEXEC_EXECUTABLE}"
   ${MPIEXEC_PREFLAGS} ${MPIEXEC_NUMPROC_FLAG})
# Tests in Python call mpiexec and mpirun: that of the MPI of this build comes first in their path.
if(SCREE_MPI)
   set(scree_starters "${PROJECT_BINARY_DIR}/test/starters")
   foreach(name mpiexec mpirun)
      file(WRITE "${PROJECT_BINARY_DIR}/CMakeFiles/${name}"
         "#!/bin/sh\nOMPI_MCA_orte_create_session_dirs=1 exec '${MPIEXEC_EXECUTABLE}' \"$@\"\n")
      file(COPY "${PROJECT_BINARY_DIR}/CMakeFiles/${name}" DESTINATION "${scree_starters}"
         FILE_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
   endforeach()
   list(APPEND scree_test_environment "PATH=${scree_starters}:$ENV{PATH}")
endif()

# Tests in Python need pytest, and those of whole runs numpy and h5py, which scripts/setup.sh puts in build/venv; the
# translator of unit tests needs the standard library only.
unset(scree_python)
foreach(candidate "${PROJECT_BINARY_DIR}/venv/bin/python" "${PROJECT_SOURCE_DIR}/build/venv/bin/python")
   if(EXISTS "${candidate}" AND NOT scree_python)
      set(scree_python "${candidate}")
   endif()
endforeach()
if(NOT scree_python)
   find_program(SCREE_PYTHON3 python3)
   if(NOT SCREE_PYTHON3)
      message(FATAL_ERROR "The tests need python3; or configure with -DBUILD_TESTING=OFF.")
   endif()
   set(scree_python "${SCREE_PYTHON3}")
endif()
execute_process(COMMAND "${scree_python}" -c "import pytest"
   RESULT_VARIABLE scree_without_pytest OUTPUT_QUIET ERROR_QUIET)
if(scree_without_pytest)
   message(WARNING "${scree_python} has no pytest: tests in Python are left out; scripts/setup.sh installs it.")
endif()

# Commands behind these words print their processor time for the list of costs.
set(scree_costing "${scree_python}" -S -E "${PROJECT_SOURCE_DIR}/test/support/cost.py")

# Recorded processor time of the tests (scripts/run_tests.py --record), so that the longest start first and the
# tiers can say how long they take.
set(scree_costs_file "${PROJECT_SOURCE_DIR}/test/costs.csv")
set_property(DIRECTORY "${PROJECT_SOURCE_DIR}" APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${scree_costs_file}")
file(STRINGS "${scree_costs_file}" scree_costs)

# Processor time of a test [s]; 0 if it was never recorded.
function(scree_cost_of name result)
   set(${result} 0 PARENT_SCOPE)
   list(FIND scree_cost_names "${name}" at)
   if(NOT at EQUAL -1)
      list(GET scree_cost_seconds ${at} seconds)
      set(${result} ${seconds} PARENT_SCOPE)
   endif()
endfunction()

foreach(line IN LISTS scree_costs)
   if(line MATCHES "^([^,#]+),([0-9.]+)$")
      list(APPEND scree_cost_names "${CMAKE_MATCH_1}")
      list(APPEND scree_cost_seconds "${CMAKE_MATCH_2}")
   endif()
endforeach()
