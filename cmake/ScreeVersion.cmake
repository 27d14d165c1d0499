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

set(scree_version_file "${PROJECT_BINARY_DIR}/generated/base/base_version.f90")
set(half_done "${PROJECT_BINARY_DIR}/generated/base/base_version.f90.in")
set(git_commit "@git_commit@") # filled in at build time
scree_fortran_text("${PROJECT_VERSION}" version_text)
scree_fortran_text("${scree_compiler}" compiler)
scree_fortran_text("${CMAKE_Fortran_COMPILER_VERSION}" compiler_version)
scree_fortran_text("${CMAKE_SYSTEM_PROCESSOR}" processor_family)
scree_fortran_text("${scree_flags}" flags)
scree_fortran_text("${CMAKE_BUILD_TYPE}" build_type)
file(RELATIVE_PATH share_folder "${CMAKE_INSTALL_FULL_BINDIR}" "${CMAKE_INSTALL_FULL_DATADIR}/scree")
scree_fortran_text("${share_folder}" share_folder)
set(scree_has_ranks false)
if(SCREE_MPI)
   set(scree_has_ranks true)
endif()
configure_file(base_version.f90.in "${half_done}" @ONLY)

set(write_version "${CMAKE_COMMAND}"
   "-Dsource=${PROJECT_SOURCE_DIR}" "-Dtemplate=${half_done}" "-Dresult=${scree_version_file}"
   -P "${PROJECT_SOURCE_DIR}/cmake/write_version.cmake")
execute_process(COMMAND ${write_version})
add_custom_target(scree_version ALL
   COMMAND ${write_version}
   BYPRODUCTS "${scree_version_file}"
   COMMENT "Asking git for the commit" VERBATIM)
