# SPDX-License-Identifier: BSD-3-Clause
# cmake --install build --prefix PLACE: program, man pages, completion, libraries, modules, CMake
# package, post-processing and scenes. scree-bench: ScreeBench.cmake.

include(CMakePackageConfigHelpers)

get_property(layers GLOBAL PROPERTY scree_layers)
install(TARGETS ${layers} scree_mpi scree_hdf5 EXPORT scree
   ARCHIVE DESTINATION "${CMAKE_INSTALL_LIBDIR}/scree")
set(scree_package "${CMAKE_INSTALL_LIBDIR}/cmake/scree")
install(EXPORT scree NAMESPACE scree:: FILE scree-targets.cmake DESTINATION "${scree_package}")
string(REGEX MATCH "^[0-9]+" scree_compiler_generation "${CMAKE_Fortran_COMPILER_VERSION}")
configure_file("${CMAKE_CURRENT_LIST_DIR}/scree-config.cmake.in"
   "${PROJECT_BINARY_DIR}/cmake/scree-config.cmake" @ONLY)
write_basic_package_version_file("${PROJECT_BINARY_DIR}/cmake/scree-config-version.cmake"
   COMPATIBILITY SameMinorVersion)
install(FILES "${PROJECT_BINARY_DIR}/cmake/scree-config.cmake"
   "${PROJECT_BINARY_DIR}/cmake/scree-config-version.cmake" DESTINATION "${scree_package}")
if(TARGET scree)
   install(TARGETS scree RUNTIME DESTINATION "${CMAKE_INSTALL_BINDIR}")
endif()
if(TARGET scree_shared)
   install(TARGETS scree_shared LIBRARY DESTINATION "${CMAKE_INSTALL_LIBDIR}")
   foreach(processor IN LISTS scree_processors)
      install(TARGETS scree_shared_${processor}
         LIBRARY DESTINATION "${CMAKE_INSTALL_LIBDIR}/glibc-hwcaps/${processor}")
   endforeach()
endif()
foreach(name scree scree-bench)
   install(FILES "${PROJECT_SOURCE_DIR}/doc/man/${name}.1" DESTINATION "${CMAKE_INSTALL_MANDIR}/man1")
   install(FILES "${PROJECT_SOURCE_DIR}/scripts/completion/${name}.bash"
      DESTINATION "${CMAKE_INSTALL_DATADIR}/bash-completion/completions" RENAME "${name}")
   install(FILES "${PROJECT_SOURCE_DIR}/scripts/completion/_${name}"
      DESTINATION "${CMAKE_INSTALL_DATADIR}/zsh/site-functions")
endforeach()
# Modules fit one compiler, hence beside the libraries.
install(DIRECTORY "${PROJECT_BINARY_DIR}/modules/" DESTINATION "${CMAKE_INSTALL_LIBDIR}/scree/modules"
   FILES_MATCHING PATTERN "*.mod"
   PATTERN pfunit EXCLUDE PATTERN main EXCLUDE)
install(DIRECTORY "${PROJECT_SOURCE_DIR}/scripts/" DESTINATION "${CMAKE_INSTALL_DATADIR}/scree/scripts"
   USE_SOURCE_PERMISSIONS FILES_MATCHING PATTERN "*.py"
   PATTERN __pycache__ EXCLUDE)
install(DIRECTORY "${PROJECT_SOURCE_DIR}/python/" DESTINATION "${CMAKE_INSTALL_DATADIR}/scree/python"
   FILES_MATCHING PATTERN "*.py" PATTERN py.typed PATTERN pyproject.toml PATTERN README.md PATTERN LICENSE
   PATTERN __pycache__ EXCLUDE PATTERN tests EXCLUDE)
install(DIRECTORY "${PROJECT_SOURCE_DIR}/input/" DESTINATION "${CMAKE_INSTALL_DATADIR}/scree/input"
   FILES_MATCHING PATTERN "*.nml" PATTERN "*.md" PATTERN "*.csv" PATTERN "*.png" PATTERN "*.py"
   PATTERN "*.stl" PATTERN "*.c" PATTERN "*.h" PATTERN "*.f90" PATTERN "*.inc")
# The header of strength laws in libraries. Commands of the manual work in the build tree too.
set(scree_law_interface scree_law.h scree_law.f90)
file(MAKE_DIRECTORY "${PROJECT_BINARY_DIR}/include")
foreach(file IN LISTS scree_law_interface)
   install(FILES "${PROJECT_SOURCE_DIR}/input/laws/${file}" DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}")
   file(CREATE_LINK "${PROJECT_SOURCE_DIR}/input/laws/${file}" "${PROJECT_BINARY_DIR}/include/${file}" SYMBOLIC)
endforeach()
# The program looks for the scenes at the same place in the build tree.
file(MAKE_DIRECTORY "${PROJECT_BINARY_DIR}/share/scree")
file(CREATE_LINK "${PROJECT_SOURCE_DIR}/input" "${PROJECT_BINARY_DIR}/share/scree/input" SYMBOLIC)
install(FILES "${PROJECT_SOURCE_DIR}/LICENSE" DESTINATION "${CMAKE_INSTALL_DOCDIR}")
