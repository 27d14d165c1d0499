# SPDX-License-Identifier: BSD-3-Clause
# Run at build time: puts the commit into a source file. Without git, and in an unpacked archive
# (even one that lies inside another repository), the commit is "unknown".

set(git_commit "unknown")
find_program(git git)
if(git AND EXISTS "${source}/.git")
   execute_process(COMMAND "${git}" describe --always --tags --dirty --abbrev=12
      WORKING_DIRECTORY "${source}" RESULT_VARIABLE status OUTPUT_VARIABLE answer ERROR_QUIET
      OUTPUT_STRIP_TRAILING_WHITESPACE)
   if(status EQUAL 0 AND answer)
      set(git_commit "${answer}")
   endif()
endif()
configure_file("${template}" "${result}" @ONLY)
