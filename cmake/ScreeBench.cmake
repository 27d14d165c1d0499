# SPDX-License-Identifier: BSD-3-Clause
# The command scree-bench: bin/scree-bench, the Python package scripts/scree_bench, and the program
# libexec/scree/memory_copy that measures the memory.

get_property(layers GLOBAL PROPERTY scree_layers)
add_executable(memory_copy "${PROJECT_SOURCE_DIR}/scripts/scree_bench/memory_copy.f90")
target_link_libraries(memory_copy PRIVATE scree_options OpenMP::OpenMP_Fortran ${layers})
set_target_properties(memory_copy PROPERTIES
   RUNTIME_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/libexec/scree"
   Fortran_MODULE_DIRECTORY "${PROJECT_BINARY_DIR}/modules/main")
# A build of the program alone can be measured too.
if(TARGET scree)
   add_dependencies(scree memory_copy)
endif()

# In the build tree the package is a link below share/scree, as in an installation.
file(MAKE_DIRECTORY "${PROJECT_BINARY_DIR}/share/scree")
file(CREATE_LINK "${PROJECT_SOURCE_DIR}/scripts" "${PROJECT_BINARY_DIR}/share/scree/scripts" SYMBOLIC)
set(scripts_folder "../share/scree/scripts")
set(copy_folder "../libexec/scree")
configure_file("${CMAKE_CURRENT_LIST_DIR}/scree-bench.in" "${PROJECT_BINARY_DIR}/bin/scree-bench" @ONLY)

file(RELATIVE_PATH scripts_folder "${CMAKE_INSTALL_FULL_BINDIR}" "${CMAKE_INSTALL_FULL_DATADIR}/scree/scripts")
file(RELATIVE_PATH copy_folder "${CMAKE_INSTALL_FULL_BINDIR}" "${CMAKE_INSTALL_FULL_LIBEXECDIR}/scree")
configure_file("${CMAKE_CURRENT_LIST_DIR}/scree-bench.in" "${PROJECT_BINARY_DIR}/cmake/scree-bench" @ONLY)
install(PROGRAMS "${PROJECT_BINARY_DIR}/cmake/scree-bench" DESTINATION "${CMAKE_INSTALL_BINDIR}")
install(TARGETS memory_copy RUNTIME DESTINATION "${CMAKE_INSTALL_LIBEXECDIR}/scree")
