# SPDX-License-Identifier: BSD-3-Clause
# Compile options, on an interface target that all Fortran targets link to, never in global flags:
# language, warnings, optimisation and checks.

if(NOT CMAKE_Fortran_COMPILER_ID STREQUAL "GNU")
   message(FATAL_ERROR "Scree is built with gfortran 12 or newer, not with "
      "${CMAKE_Fortran_COMPILER_ID}; set FC=gfortran and use a new build folder.")
endif()
if(CMAKE_Fortran_COMPILER_VERSION VERSION_LESS 12)
   message(WARNING "gfortran ${CMAKE_Fortran_COMPILER_VERSION} is older than 12 and untested.")
endif()

# Without contraction of a*b + c a loop gives the same bits in its vector body and in its remainder,
# so a result does not depend on where a particle stands in its range; it costs little, because
# the kernels wait for memory.
set(scree_language_flags -std=f2008 -ffp-contract=off)
# An override that ignores an argument is legal design, hence no warning about those; gfortran
# sees uninitialised array descriptors where there are none, hence no maybe-uninitialized.
set(scree_warning_flags -Wall -Wextra -pedantic -Wno-unused-dummy-argument
   -Wno-maybe-uninitialized)
if(SCREE_WERROR)
   list(APPEND scree_warning_flags -Werror)
endif()
# Nobody looks at floating-point exceptions in a Release build, so a choice between two numbers need
# not keep a loop from becoming a vector. No bit depends on it.
set(scree_release_flags -O3 -fno-trapping-math)
if(SCREE_ARCH)
   list(APPEND scree_release_flags -march=${SCREE_ARCH})
endif()
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
   # Eight nodes of a cell are eight lanes: one vector where the machine has such. Measured on the
   # scatter kernel: 9.7 ns a particle without, 7.6 ns with it. No effect on other machines.
   list(APPEND scree_release_flags -mprefer-vector-width=512)
endif()
set(scree_debug_flags -Og -g -fcheck=all -finit-real=snan -ffpe-trap=invalid,zero,overflow
   -fbacktrace)
set(scree_sanitize_flags -O1 -g -fsanitize=address,undefined -fno-omit-frame-pointer -fbacktrace)

add_library(scree_options INTERFACE)
target_compile_options(scree_options INTERFACE
   ${scree_language_flags}
   ${scree_warning_flags}
   "$<$<CONFIG:Release>:${scree_release_flags}>"
   "$<$<CONFIG:Debug>:${scree_debug_flags}>"
   "$<$<CONFIG:Sanitize>:${scree_sanitize_flags}>")
target_link_options(scree_options INTERFACE
   "$<$<CONFIG:Sanitize>:-fsanitize=address,undefined>")

# For the report of --version and the provenance in files.
string(TOUPPER "${CMAKE_BUILD_TYPE}" scree_type)
string(TOLOWER "scree_${CMAKE_BUILD_TYPE}_flags" scree_type_flags)
list(JOIN scree_language_flags " " scree_flags)
list(JOIN ${scree_type_flags} " " scree_more_flags)
string(STRIP "${scree_flags} ${scree_more_flags} ${CMAKE_Fortran_FLAGS}" scree_flags)
