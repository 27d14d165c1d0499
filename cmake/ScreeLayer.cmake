# SPDX-License-Identifier: BSD-3-Clause
# One static library a folder of src/, each with its own module directory.
#
#   scree_layer(particle USES base mesh material [LINKS MPI::MPI_Fortran] [EXTRA file])
#
# All links are private, so a folder sees the modules of the folders it names and of no other,
# and a forbidden `use` does not compile.

function(scree_layer folder)
   cmake_parse_arguments(layer "" "" "USES;LINKS;EXTRA" ${ARGN})
   file(GLOB sources CONFIGURE_DEPENDS "${CMAKE_CURRENT_SOURCE_DIR}/*.f90")
   list(REMOVE_ITEM sources "${CMAKE_CURRENT_SOURCE_DIR}/main.f90")
   list(APPEND sources ${layer_EXTRA})
   set(target scree_${folder})
   add_library(${target} STATIC ${sources})
   set_target_properties(${target} PROPERTIES
      Fortran_MODULE_DIRECTORY "${PROJECT_BINARY_DIR}/modules/${folder}"
      POSITION_INDEPENDENT_CODE OFF)
   target_include_directories(${target} INTERFACE
      "$<BUILD_INTERFACE:${PROJECT_BINARY_DIR}/modules/${folder}>")
   target_link_libraries(${target} PRIVATE
      scree_options OpenMP::OpenMP_Fortran ${layer_LINKS})
   foreach(lower IN LISTS layer_USES)
      target_link_libraries(${target} PRIVATE scree_${lower})
   endforeach()
   set_property(GLOBAL APPEND PROPERTY scree_layers ${target})
endfunction()
