# SPDX-License-Identifier: BSD-3-Clause
# Compile options, on an interface target that all Fortran targets link to, never in global flags:
# language, warnings, optimisation and checks.
include(ScreeCompiler)

function(scree_option_library name processor)
   string(REPLACE "-march=${scree_processor}" "-march=${processor}" flags "${scree_release_flags}")
   add_library(${name} INTERFACE)
   target_compile_options(${name} INTERFACE
      ${scree_language_flags}
      ${scree_warning_flags}
      "$<$<CONFIG:Release>:${flags}>"
      "$<$<CONFIG:Debug>:${scree_debug_flags}>"
      "$<$<CONFIG:Sanitize>:${scree_sanitize_flags}>")
   target_link_options(${name} INTERFACE "$<$<CONFIG:Sanitize>:-fsanitize=address,undefined>")
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
