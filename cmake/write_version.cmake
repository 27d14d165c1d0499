# SPDX-License-Identifier: BSD-3-Clause
# Run at build time: puts the commit into a source file. An archive of git has it in commit.txt
# (.gitattributes). Without git, and in any other unpacked folder (even one that lies inside another
# repository), the commit is "unknown".

set(git_commit "unknown")
file(STRINGS "${CMAKE_CURRENT_LIST_DIR}/commit.txt" archived REGEX "^commit: [0-9a-f]+$")
if(archived)
   string(SUBSTRING "${archived}" 8 12 git_commit)
endif()
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
