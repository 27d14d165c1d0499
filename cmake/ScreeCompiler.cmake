# SPDX-License-Identifier: BSD-3-Clause
# Flags of the compiler, as lists:
#   scree_language_flags   the standard, and no contraction of a*b + c
#   scree_warning_flags    warnings
#   scree_release_flags    of the build type; as well debug and sanitize
#   scree_wrap_flags       integers that wrap round (hashes, random numbers)
#   scree_inline_flags     long functions are inlined into loops
#   scree_stack_flags      arrays of variable size lie on the stack
#   scree_line_flags       lines of any length, for tests that a program wrote
# and scree_compiler, its name in reports, and scree_layer_scope: PRIVATE if the file of a module holds
# all that its users need, PUBLIC if the compiler also reads the files of the modules that it uses.
# doc/developer/platforms.md says which compilers were tried.
include(CheckFortranCompilerFlag)

set(scree_id "${CMAKE_Fortran_COMPILER_ID}")
set(scree_generation "${CMAKE_Fortran_COMPILER_VERSION}")
foreach(kind language warning release debug sanitize wrap inline stack line)
   set(scree_${kind}_flags)
endforeach()
set(scree_layer_scope PUBLIC)

if(scree_id STREQUAL "GNU")
   set(scree_compiler "gfortran")
   if(scree_generation VERSION_LESS 12)
      message(WARNING "gfortran ${scree_generation} is older than 12 and untried.")
   endif()
   # Without contraction of a*b + c a loop gives the same bits in its vector body and in its remainder,
   # so a result does not depend on where a particle stands in its range; it costs little, because
   # the kernels wait for memory.
   set(scree_language_flags -std=f2008 -ffp-contract=off)
   # An override that ignores an argument is legal design, hence no warning about those; gfortran
   # sees uninitialised array descriptors where there are none, hence no maybe-uninitialized.
   set(scree_warning_flags -Wall -Wextra -pedantic -Wno-unused-dummy-argument -Wno-maybe-uninitialized)
   # gfortran 14 says the same of descriptors with certainty; gfortran 12 still looks for real cases.
   if(scree_generation VERSION_GREATER_EQUAL 13)
      list(APPEND scree_warning_flags -Wno-uninitialized)
   endif()
   # Nobody looks at floating-point exceptions in a Release build, so a choice between two numbers need
   # not keep a loop from becoming a vector. No bit depends on it.
   set(scree_release_flags -O3 -fno-trapping-math)
   set(scree_debug_flags -Og -g -fcheck=all -finit-real=snan -ffpe-trap=invalid,zero,overflow -fbacktrace)
   set(scree_sanitize_flags -O1 -g -fsanitize=address,undefined -fno-omit-frame-pointer -fbacktrace)
   set(scree_wrap_flags -fwrapv)
   set(scree_inline_flags --param=max-inline-insns-auto=2000)
   set(scree_stack_flags -fstack-arrays)
   set(scree_line_flags -ffree-line-length-none)
   set(scree_layer_scope PRIVATE)
elseif(scree_id STREQUAL "LLVMFlang")
   set(scree_compiler "flang")
   # flang knows no older standard by name, and takes lines of any length.
   set(scree_language_flags -std=f2018 -ffp-contract=off)
   set(scree_warning_flags -pedantic)
   set(scree_release_flags -O3)
   set(scree_debug_flags -O0 -g)
   set(scree_stack_flags -fstack-arrays)
   # Before flang 20 integers always wrap round, and there is no such option.
   check_fortran_compiler_flag(-fwrapv SCREE_HAS_WRAPV)
   if(SCREE_HAS_WRAPV)
      set(scree_wrap_flags -fwrapv)
   endif()
else()
   # Flags for arithmetic without contraction, untried.
   set(scree_compiler "${scree_id}")
   set(scree_release_flags -O3)
   set(scree_debug_flags -O0 -g)
   if(scree_id MATCHES "^Intel")
      set(scree_language_flags -stand f18 -fp-model=precise -no-fma -assume protect_parens)
   elseif(scree_id STREQUAL "NVHPC")
      set(scree_language_flags -Kieee -Mnofma)
   elseif(scree_id STREQUAL "Cray")
      set(scree_language_flags -hfp0)
   endif()
endif()

if(NOT scree_id MATCHES "^(GNU|LLVMFlang)$")
   message(WARNING "Scree is tested with gfortran and LLVM flang; ${scree_compiler} ${scree_generation} is untried. "
      "FC=gfortran and a new build folder choose gfortran.")
endif()
if(CMAKE_BUILD_TYPE STREQUAL "Sanitize" AND NOT scree_sanitize_flags)
   message(FATAL_ERROR "The build type Sanitize needs gfortran, and this compiler is ${scree_compiler}.")
endif()
set(scree_processor "${SCREE_ARCH}")
set(scree_processors)
if(SCREE_ARCH STREQUAL "dispatch")
   if(NOT CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64" OR NOT CMAKE_BUILD_TYPE STREQUAL "Release"
      OR NOT scree_id STREQUAL "GNU")
      message(FATAL_ERROR "-DSCREE_ARCH=dispatch is for Release builds on x86-64 with gfortran")
   endif()
   # The first library runs on each x86-64. The loader of the C library prefers one of these,
   # if the processor has AVX2, or AVX-512.
   set(scree_processor x86-64)
   set(scree_processors x86-64-v3 x86-64-v4)
endif()
if(scree_processor AND scree_id MATCHES "^(GNU|LLVMFlang)$")
   list(APPEND scree_release_flags -march=${scree_processor})
endif()
if(scree_id STREQUAL "GNU")
   if(SCREE_WERROR)
      list(APPEND scree_warning_flags -Werror)
   endif()
   if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
      # Eight nodes of a cell are eight lanes: one vector where the machine has such. Measured on the
      # scatter kernel: 9.7 ns a particle without, 7.6 ns with it. No effect on other machines.
      list(APPEND scree_release_flags -mprefer-vector-width=512)
   endif()
endif()
