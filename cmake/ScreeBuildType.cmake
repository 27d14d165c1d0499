# SPDX-License-Identifier: BSD-3-Clause
# Release unless the user asks for something else, and the options that users may set.

set(scree_build_types Release Debug Sanitize)
if(NOT CMAKE_BUILD_TYPE)
   set(CMAKE_BUILD_TYPE Release CACHE STRING "Release, Debug or Sanitize" FORCE)
endif()
set_property(CACHE CMAKE_BUILD_TYPE PROPERTY STRINGS ${scree_build_types})
if(NOT CMAKE_BUILD_TYPE IN_LIST scree_build_types)
   message(FATAL_ERROR "CMAKE_BUILD_TYPE=${CMAKE_BUILD_TYPE} is none of: ${scree_build_types}")
endif()

set(SCREE_ARCH native CACHE STRING
   "Processor to compile for (-march=); empty: the common one; dispatch: all x86-64, chosen at start")
option(SCREE_MPI "Several ranks, with MPI and parallel HDF5; OFF: one rank, without MPI" ON)
option(SCREE_WERROR "Warnings stop the build" ON)

# All options are on scree_options, so CMake's own flags of a build type begin empty. No source needs
# a preprocessor.
foreach(type RELEASE DEBUG SANITIZE)
   set(CMAKE_Fortran_FLAGS_${type} "" CACHE STRING "Additional flags of the user")
endforeach()
set(CMAKE_Fortran_PREPROCESS OFF)
