# SPDX-License-Identifier: BSD-3-Clause
# OpenMP, MPI and parallel HDF5, for Fortran only: no C compiler is asked for.

find_package(OpenMP REQUIRED COMPONENTS Fortran)
find_package(MPI REQUIRED COMPONENTS Fortran)
if(NOT MPI_Fortran_HAVE_F08_MODULE)
   message(FATAL_ERROR "The MPI library has no module mpi_f08 for this compiler.")
endif()
include(ScreeHdf5)
