# SPDX-License-Identifier: BSD-3-Clause
# Module base_version, written anew at each build and changed only if the commit has changed.

# Fortran lines are short: cut a text into pieces that are joined in the source.
function(scree_fortran_text text result)
   string(REPLACE "\"" "\"\"" text "${text}")
   set(pieces)
   string(LENGTH "${text}" length)
   while(length GREATER 70)
      string(SUBSTRING "${text}" 0 70 piece)
      string(SUBSTRING "${text}" 70 -1 text)
      list(APPEND pieces "\"${piece}\"")
      string(LENGTH "${text}" length)
   endwhile()
   list(APPEND pieces "\"${text}\"")
   list(JOIN pieces " // &\n      " joined)
   set(${result} "${joined}" PARENT_SCOPE)
endfunction()

# One file for each processor: the flags differ.
set(scree_version_file "${PROJECT_BINARY_DIR}/generated/base@processor@/base_version.f90")
set(git_commit "@git_commit@") # filled in at build time
scree_fortran_text("${PROJECT_VERSION}" version_text)
scree_fortran_text("${scree_compiler}" compiler)
scree_fortran_text("${CMAKE_Fortran_COMPILER_VERSION}" compiler_version)
scree_fortran_text("${CMAKE_SYSTEM_PROCESSOR}" processor_family)
scree_fortran_text("${CMAKE_BUILD_TYPE}" build_type)
file(RELATIVE_PATH share_folder "${CMAKE_INSTALL_FULL_BINDIR}" "${CMAKE_INSTALL_FULL_DATADIR}/scree")
scree_fortran_text("${share_folder}" share_folder)
set(scree_has_ranks false)
if(SCREE_MPI)
   set(scree_has_ranks true)
endif()

set(scree_version_files)
set(write_versions)
foreach(processor IN ITEMS "" LISTS scree_processors)
   set(suffix)
   set(processor_flags "${scree_flags}")
   if(processor)
      set(suffix _${processor})
      string(REPLACE "-march=${scree_processor}" "-march=${processor}" processor_flags "${scree_flags}")
   endif()
   scree_fortran_text("${processor_flags}" flags)
   string(REPLACE "@processor@" "${suffix}" file "${scree_version_file}")
   configure_file(base_version.f90.in "${file}.in" @ONLY)
   set(write_version "${CMAKE_COMMAND}"
      "-Dsource=${PROJECT_SOURCE_DIR}" "-Dtemplate=${file}.in" "-Dresult=${file}"
      -P "${PROJECT_SOURCE_DIR}/cmake/write_version.cmake")
   execute_process(COMMAND ${write_version})
   list(APPEND scree_version_files "${file}")
   list(APPEND write_versions COMMAND ${write_version})
endforeach()
add_custom_target(scree_version ALL
   ${write_versions}
   BYPRODUCTS ${scree_version_files}
   COMMENT "Asking git for the commit" VERBATIM)
