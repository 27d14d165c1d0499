# SPDX-License-Identifier: BSD-3-Clause
# OpenMP, MPI and parallel HDF5, for Fortran only: no C compiler is asked for.

find_package(OpenMP REQUIRED COMPONENTS Fortran)
find_package(MPI REQUIRED COMPONENTS Fortran)
if(NOT MPI_Fortran_HAVE_F08_MODULE)
   message(FATAL_ERROR "The MPI library has no module mpi_f08 for this compiler.")
endif()

set(HDF5_PREFER_PARALLEL TRUE)
find_package(HDF5 REQUIRED COMPONENTS Fortran)
if(NOT HDF5_IS_PARALLEL)
   message(FATAL_ERROR "HDF5 was found, but not a parallel one; "
      "on Debian and Ubuntu: apt-get install libhdf5-openmpi-dev")
endif()

add_library(scree_hdf5 INTERFACE)
target_include_directories(scree_hdf5 SYSTEM INTERFACE ${HDF5_Fortran_INCLUDE_DIRS})
target_link_libraries(scree_hdf5 INTERFACE ${HDF5_Fortran_LIBRARIES})
