# SPDX-License-Identifier: BSD-3-Clause
# Keys of a valid material of each model, for tests that take all models of the catalogue.
#
#   scree_material_samples(scree_unit_samples folder test.pf ...)
#
# makes a library with the module material_samples from lines
#   ! sample: shear = 3.0e7 strength_model = 'von_mises' &
#   ! sample: yield = 2.0e5
# of the tests: one sample a model, on as many lines as it needs. The template is in the folder.

function(scree_material_samples target folder)
   foreach(test IN LISTS ARGN)
      set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${test}")
      file(STRINGS "${test}" lines REGEX "^! sample: ")
      list(TRANSFORM lines REPLACE "^! sample: " "")
      list(JOIN lines "\n" text)
      string(REPLACE " &\n" " " text "${text}")
      string(REPLACE "\n" ";" samples "${text}")
      foreach(sample IN LISTS samples)
         if(NOT sample MATCHES "(strength_model|eos_model|damage_model) = '")
            message(FATAL_ERROR "${test}: a sample without strength_model, eos_model or damage_model: ${sample}")
         endif()
         set(kind ${CMAKE_MATCH_1})
         # A long text has several lines of at most 80 columns.
         string(REGEX REPLACE "(................................................................[^ ]*) "
            "\\1 \"// &\n      \"" broken "${sample}")
         list(APPEND ${kind} "      \"${broken}\"")
      endforeach()
   endforeach()
   foreach(kind strength_model eos_model damage_model)
      list(JOIN ${kind} ", &\n" samples_${kind})
   endforeach()
   set(source "${PROJECT_BINARY_DIR}/generated/test/material_samples.f90")
   configure_file("${folder}/material_samples.f90.in" "${source}" @ONLY)
   add_library(${target} STATIC "${source}")
   set_target_properties(${target} PROPERTIES Fortran_MODULE_DIRECTORY "${PROJECT_BINARY_DIR}/modules/test")
   target_include_directories(${target} INTERFACE "${PROJECT_BINARY_DIR}/modules/test")
   target_link_libraries(${target} PRIVATE scree_unit_options)
endfunction()
