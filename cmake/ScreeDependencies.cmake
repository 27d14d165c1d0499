# SPDX-License-Identifier: BSD-3-Clause
# OpenMP, MPI and HDF5, for Fortran only: no C compiler is asked for. Without MPI a module with the
# interface of mpi_f08 for one rank is compiled, and HDF5 is the serial one.

find_package(OpenMP REQUIRED COMPONENTS Fortran)
add_library(scree_mpi INTERFACE)
set_target_properties(scree_mpi PROPERTIES EXPORT_NAME mpi)
if(SCREE_MPI)
   set(scree_variant parallel)
   # Beside a wrapper with the name of its MPI, such as mpifort.mpich of Debian, is a command that starts its ranks.
   if(MPI_Fortran_COMPILER MATCHES "[.](mpich|openmpi)$")
      find_program(MPIEXEC_EXECUTABLE mpiexec.${CMAKE_MATCH_1} DOC "Command that starts the ranks")
   endif()
   find_package(MPI REQUIRED COMPONENTS Fortran)
   if(NOT MPI_Fortran_HAVE_F08_MODULE)
      message(FATAL_ERROR "The MPI library has no module mpi_f08 for this compiler; "
         "-DSCREE_MPI=OFF builds a program for one rank without MPI.")
   endif()
   target_link_libraries(scree_mpi INTERFACE MPI::MPI_Fortran)
else()
   set(scree_variant serial)
endif()
include(ScreeHdf5)
