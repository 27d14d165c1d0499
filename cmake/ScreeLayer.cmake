# SPDX-License-Identifier: BSD-3-Clause
# One static library a folder of src/, each with its own module directory.
#
#   scree_layer(particle USES base mesh material [LINKS scree_mpi] [EXTRA file])
#
# All links are private, so a folder sees the modules of the folders it names and of no other,
# and a forbidden `use` does not compile. An installed library, scree::FOLDER, gives the modules of
# its folder and of those that it uses.

function(scree_layer folder)
   cmake_parse_arguments(layer "" "" "USES;LINKS;EXTRA" ${ARGN})
   file(GLOB sources CONFIGURE_DEPENDS "${CMAKE_CURRENT_SOURCE_DIR}/*.f90")
   list(REMOVE_ITEM sources "${CMAKE_CURRENT_SOURCE_DIR}/main.f90")
   list(APPEND sources ${layer_EXTRA})
   set(target scree_${folder})
   add_library(${target} STATIC ${sources})
   add_library(scree::${folder} ALIAS ${target})
   set_target_properties(${target} PROPERTIES
      EXPORT_NAME ${folder}
      Fortran_MODULE_DIRECTORY "${PROJECT_BINARY_DIR}/modules/${folder}"
      POSITION_INDEPENDENT_CODE OFF)
   target_include_directories(${target} INTERFACE
      "$<BUILD_INTERFACE:${PROJECT_BINARY_DIR}/modules/${folder}>")
   set(modules "${CMAKE_INSTALL_LIBDIR}/scree/modules")
   foreach(seen IN LISTS folder layer_USES)
      target_include_directories(${target} INTERFACE "$<INSTALL_INTERFACE:${modules}/${seen}>")
   endforeach()
   target_link_libraries(${target} PRIVATE
      $<BUILD_INTERFACE:scree_options> OpenMP::OpenMP_Fortran ${layer_LINKS})
   target_compile_options(${target} PRIVATE -fPIE)
   foreach(lower IN LISTS layer_USES)
      target_link_libraries(${target} PRIVATE scree_${lower})
   endforeach()
   set_property(GLOBAL APPEND PROPERTY scree_layers ${target})
endfunction()

function(scree_uses_foreign_variables)
   set_property(SOURCE ${ARGN} APPEND PROPERTY COMPILE_OPTIONS -fPIC)
endfunction()
