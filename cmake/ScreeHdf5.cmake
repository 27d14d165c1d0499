# SPDX-License-Identifier: BSD-3-Clause
# Target scree_hdf5: the Fortran interface of HDF5, as the compiler wrapper h5pfc (without MPI: h5fc)
# knows it.
# CMake's own FindHDF5 compiles through the wrapper, which fails in folders with blanks in their
# names; it is asked only if there is no wrapper.

# A system may have an HDF5 for each MPI: in a folder the wrapper of the MPI at hand is the first.
set(scree_wrappers h5pfc h5pfc.openmpi h5pfc.mpich)
set(scree_other_mpi "no other")
set(scree_hdf5_package libhdf5-openmpi-dev)
if(NOT SCREE_MPI)
   set(scree_wrappers h5fc)
   set(scree_hdf5_package libhdf5-dev)
   set(scree_other_mpi "openmpi|mpich")
elseif("${MPI_Fortran_LIBRARIES}" MATCHES "mpich")
   set(scree_hdf5_package libhdf5-mpich-dev)
   set(scree_wrappers h5pfc.mpich h5pfc)
   set(scree_other_mpi "openmpi")
elseif("${MPI_Fortran_LIBRARIES}" MATCHES "openmpi|usempif08")
   set(scree_wrappers h5pfc.openmpi h5pfc)
   set(scree_other_mpi "mpich")
endif()
find_program(SCREE_H5PFC NAMES ${scree_wrappers} NAMES_PER_DIR
   HINTS "${HDF5_ROOT}" ENV HDF5_ROOT PATH_SUFFIXES bin
   DOC "Compiler wrapper of HDF5")

function(scree_ask_wrapper)
   execute_process(COMMAND "${SCREE_H5PFC}" -show WORKING_DIRECTORY /
      RESULT_VARIABLE status OUTPUT_VARIABLE line ERROR_QUIET OUTPUT_STRIP_TRAILING_WHITESPACE)
   if(NOT status EQUAL 0)
      return()
   endif()
   separate_arguments(words UNIX_COMMAND "${line}")
   set(include_folders)
   set(library_folders)
   # From version 2 on the library of an MPI has a name of its own on Debian, in a folder of the system.
   set(library hdf5)
   foreach(word IN LISTS words)
      if(word MATCHES "^-I(.+)$")
         list(APPEND include_folders "${CMAKE_MATCH_1}")
      elseif(word MATCHES "^-L(.+)$")
         list(APPEND library_folders "${CMAKE_MATCH_1}")
      elseif(NOT word MATCHES "_hl_" AND word MATCHES "^-l(hdf5.*)_fortran$")
         set(library "${CMAKE_MATCH_1}")
      elseif(word MATCHES "^(/.*)/lib[^/]*$")
         list(APPEND library_folders "${CMAKE_MATCH_1}")
      endif()
   endforeach()
   find_path(SCREE_HDF5_MODULES hdf5.mod HINTS ${include_folders} NO_DEFAULT_PATH)
   find_path(SCREE_HDF5_HEADERS H5pubconf.h HINTS ${include_folders} NO_DEFAULT_PATH)
   foreach(search "NO_DEFAULT_PATH" "")
      find_library(SCREE_HDF5_FORTRAN ${library}_fortran HINTS ${library_folders} ${search})
      find_library(SCREE_HDF5_C ${library} HINTS ${library_folders} ${search})
   endforeach()
   mark_as_advanced(SCREE_H5PFC SCREE_HDF5_MODULES SCREE_HDF5_HEADERS SCREE_HDF5_FORTRAN
      SCREE_HDF5_C)
endfunction()

# True if the library was built with MPI, as its own header says.
function(scree_hdf5_is_parallel result)
   set(${result} FALSE PARENT_SCOPE)
   file(GLOB headers "${SCREE_HDF5_HEADERS}/H5pubconf*.h")
   foreach(header IN LISTS headers)
      file(STRINGS "${header}" found REGEX "^#define H5_HAVE_PARALLEL 1")
      if(found)
         set(${result} TRUE PARENT_SCOPE)
      endif()
   endforeach()
endfunction()

if(SCREE_H5PFC)
   scree_ask_wrapper()
endif()
if(SCREE_HDF5_MODULES AND SCREE_HDF5_FORTRAN AND SCREE_HDF5_C)
   scree_hdf5_is_parallel(scree_parallel)
   set(scree_hdf5_includes "${SCREE_HDF5_MODULES}")
   set(scree_hdf5_libraries "${SCREE_HDF5_FORTRAN}" "${SCREE_HDF5_C}")
else()
   set(HDF5_PREFER_PARALLEL ${SCREE_MPI})
   find_package(HDF5 COMPONENTS Fortran)
   if(NOT HDF5_FOUND)
      message(FATAL_ERROR "No HDF5 with Fortran was found; "
         "on Debian and Ubuntu: apt-get install ${scree_hdf5_package}")
   endif()
   set(scree_parallel "${HDF5_IS_PARALLEL}")
   set(scree_hdf5_includes ${HDF5_Fortran_INCLUDE_DIRS})
   set(scree_hdf5_libraries ${HDF5_Fortran_LIBRARIES})
endif()
if(SCREE_MPI AND NOT scree_parallel)
   message(FATAL_ERROR "HDF5 was found, but not a parallel one; "
      "on Debian and Ubuntu: apt-get install ${scree_hdf5_package}; "
      "-DSCREE_MPI=OFF builds a program for one rank without MPI.")
elseif(scree_parallel AND NOT SCREE_MPI)
   message(FATAL_ERROR "A build without MPI needs a serial HDF5, and ${scree_hdf5_libraries} is a "
      "parallel one; on Debian and Ubuntu: apt-get install ${scree_hdf5_package}, elsewhere give "
      "the wrapper: -DSCREE_H5PFC=/path/to/h5fc, in a new build folder.")
endif()
if("${scree_hdf5_libraries}" MATCHES "${scree_other_mpi}")
   message(FATAL_ERROR "HDF5 and MPI do not fit: ${scree_hdf5_libraries} was built with "
      "${scree_other_mpi}, and MPI is ${MPI_Fortran_LIBRARIES}. Give the wrapper of an HDF5 that was "
      "built with this MPI: -DSCREE_H5PFC=/path/to/h5pfc, in a new build folder.")
endif()
message(STATUS "Found ${scree_variant} HDF5: ${scree_hdf5_libraries}")

# Chunks are compressed in threads, with the zlib that HDF5 itself uses.
get_filename_component(scree_hdf5_folder "${SCREE_HDF5_C}" DIRECTORY)
find_library(SCREE_ZLIB NAMES z HINTS "${scree_hdf5_folder}" DOC "Library zlib")
mark_as_advanced(SCREE_ZLIB)
if(NOT SCREE_ZLIB)
   message(FATAL_ERROR "No zlib was found; on Debian and Ubuntu: apt-get install zlib1g-dev")
endif()
list(APPEND scree_hdf5_libraries "${SCREE_ZLIB}")

add_library(scree_hdf5 INTERFACE)
set_target_properties(scree_hdf5 PROPERTIES EXPORT_NAME hdf5)
target_include_directories(scree_hdf5 SYSTEM INTERFACE ${scree_hdf5_includes})
target_link_libraries(scree_hdf5 INTERFACE ${scree_hdf5_libraries})
