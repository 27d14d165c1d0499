# SPDX-License-Identifier: BSD-3-Clause
# Compile options, on an interface target that all Fortran targets link to, never in global flags:
# language, warnings, optimisation and checks.
include(ScreeCompiler)

# Kernels marked with `declare target` are compiled for a GPU when a program is linked, if the compiler
# has a second one for it. Only programs with the property scree_offloads ask for that. Otherwise the
# marks must not change a single instruction, which needs the option already where they are compiled.
set(scree_compile_options)
if(scree_id STREQUAL "GNU" AND NOT SCREE_OFFLOAD)
   set(scree_compile_options -foffload=disable)
endif()
set(scree_offload_flags -fopenmp -foffload=nvptx-none -foffload-options=nvptx-none=-O3
   -foffload-options=nvptx-none=-ffp-contract=off -foffload-options=nvptx-none=-lgfortran
   -foffload-options=nvptx-none=-lm -no-pie)
set(scree_link_options)
if(scree_id STREQUAL "GNU")
   set(scree_link_options
      "$<IF:$<BOOL:$<TARGET_PROPERTY:scree_offloads>>,${scree_offload_flags},-foffload=disable>")
endif()

function(scree_option_library name processor)
   string(REPLACE "-march=${scree_processor}" "-march=${processor}" flags "${scree_release_flags}")
   add_library(${name} INTERFACE)
   target_compile_options(${name} INTERFACE
      ${scree_language_flags}
      ${scree_warning_flags}
      ${scree_compile_options}
      "$<$<CONFIG:Release>:${flags}>"
      "$<$<CONFIG:Debug>:${scree_debug_flags}>"
      "$<$<CONFIG:Sanitize>:${scree_sanitize_flags}>")
   target_link_options(${name} INTERFACE
      "${scree_link_options}"
      "$<$<CONFIG:Sanitize>:-fsanitize=address,undefined>")
endfunction()
scree_option_library(scree_options "${scree_processor}")
foreach(processor IN LISTS scree_processors)
   scree_option_library(scree_options_${processor} ${processor})
endforeach()

# For the report of --version and the provenance in files.
string(TOUPPER "${CMAKE_BUILD_TYPE}" scree_type)
string(TOLOWER "scree_${CMAKE_BUILD_TYPE}_flags" scree_type_flags)
list(JOIN scree_language_flags " " scree_flags)
list(JOIN ${scree_type_flags} " " scree_more_flags)
# Options that map paths, as of Debian's builds, contain the folder of the build and change no result.
string(REGEX REPLACE "-f[a-z]+-prefix-map=[^ ]*" "" scree_user_flags "${CMAKE_Fortran_FLAGS}")
string(REGEX REPLACE " +" " " scree_user_flags "${scree_user_flags}")
string(STRIP "${scree_flags} ${scree_more_flags} ${scree_user_flags}" scree_flags)
