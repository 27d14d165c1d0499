# SPDX-License-Identifier: BSD-3-Clause
# One static library a folder of src/, each with its own module directory.
#
#   scree_layer(particle USES base mesh material [LINKS scree_mpi] [EXTRA file] [ONCE])
#
# With gfortran all links are private, so a folder sees the modules of the folders it names and of no
# other, and a forbidden `use` does not compile. An installed library, scree::FOLDER, gives the modules of
# its folder and of those that it uses.
#
# With SCREE_ARCH=dispatch a folder is compiled again for each processor of scree_processors, as
# scree_FOLDER_PROCESSOR, unless it has no loops that profit from it (ONCE). A file that differs
# between processors has @processor@ in its name, which is empty for the first library.

function(scree_layer folder)
   cmake_parse_arguments(layer "ONCE" "" "USES;LINKS;EXTRA" ${ARGN})
   # Subfolders divide a folder by subjects; `serial` and `parallel` are variants for different builds.
   file(GLOB sources CONFIGURE_DEPENDS "${CMAKE_CURRENT_SOURCE_DIR}/*.f90" "${CMAKE_CURRENT_SOURCE_DIR}/*/*.f90")
   list(FILTER sources EXCLUDE REGEX "/(serial|parallel)/[^/]*$")
   list(REMOVE_ITEM sources "${CMAKE_CURRENT_SOURCE_DIR}/main.f90")
   list(APPEND sources ${layer_EXTRA})
   set(target scree_${folder})
   set(modules "${PROJECT_BINARY_DIR}/modules/${folder}")
   scree_layer_library(${target} "" "${modules}")
   add_library(scree::${folder} ALIAS ${target})
   set_target_properties(${target} PROPERTIES EXPORT_NAME ${folder})
   set(installed "${CMAKE_INSTALL_LIBDIR}/scree/modules")
   foreach(seen IN LISTS folder layer_USES)
      target_include_directories(${target} INTERFACE "$<INSTALL_INTERFACE:${installed}/${seen}>")
   endforeach()
   set_property(GLOBAL APPEND PROPERTY scree_layers ${target})

   foreach(processor IN LISTS scree_processors)
      if(NOT layer_ONCE)
         set(target scree_${folder}_${processor})
         scree_layer_library(${target} _${processor}
            "${PROJECT_BINARY_DIR}/processors/${processor}/modules/${folder}")
      endif()
      set_property(GLOBAL APPEND PROPERTY scree_layers_${processor} ${target})
   endforeach()
endfunction()

# The library of a folder for one processor; uses `folder`, `sources` and `layer_...` of the caller.
function(scree_layer_library target suffix modules)
   string(REPLACE "@processor@" "${suffix}" sources "${sources}")
   add_library(${target} STATIC ${sources})
   set_target_properties(${target} PROPERTIES
      Fortran_MODULE_DIRECTORY "${modules}"
      POSITION_INDEPENDENT_CODE OFF)
   target_include_directories(${target} INTERFACE "$<BUILD_INTERFACE:${modules}>")
   target_link_libraries(${target} PRIVATE
      $<BUILD_INTERFACE:scree_options${suffix}> OpenMP::OpenMP_Fortran)
   target_link_libraries(${target} ${scree_layer_scope} ${layer_LINKS})
   target_compile_options(${target} PRIVATE -fPIE)
   foreach(lower IN LISTS layer_USES)
      if(TARGET scree_${lower}${suffix})
         target_link_libraries(${target} ${scree_layer_scope} scree_${lower}${suffix})
      else()
         target_link_libraries(${target} ${scree_layer_scope} scree_${lower})
      endif()
   endforeach()
endfunction()

function(scree_uses_foreign_variables)
   set_property(SOURCE ${ARGN} APPEND PROPERTY COMPILE_OPTIONS -fPIC)
endfunction()
