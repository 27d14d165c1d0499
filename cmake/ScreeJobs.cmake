# SPDX-License-Identifier: BSD-3-Clause
# Templates of job scripts as Fortran arrays.
#
#   scree_jobs(OUTPUT file TEMPLATE file SCHEDULERS slurm pbs ...)
#
# Each scheduler is a text file, job/NAME.txt: a script with names in double braces, which
# program_batch_job replaces. Lines before `#!/bin/bash` are comments on the template.

function(scree_jobs)
   cmake_parse_arguments(jobs "" "OUTPUT;TEMPLATE" "SCHEDULERS" ${ARGN})
   set(job_arrays)
   set(job_cases)
   set(job_names)
   foreach(name IN LISTS jobs_SCHEDULERS)
      set(source "${CMAKE_CURRENT_SOURCE_DIR}/job/${name}.txt")
      set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${source}")
      file(READ "${source}" text)
      string(FIND "${text}" "#!/bin/bash" start)
      if(start EQUAL -1)
         message(FATAL_ERROR "${source} has no line #!/bin/bash")
      endif()
      string(SUBSTRING "${text}" ${start} -1 text)
      string(REGEX REPLACE "\n+$" "" text "${text}")
      string(REPLACE "\"" "\"\"" text "${text}")
      string(REPLACE "\n" "\", &\n      \"" text "${text}")
      string(APPEND job_arrays "   character(len=*), parameter :: job_${name}(*) = "
         "[character(len=line_length) :: &\n      \"${text}\"]\n")
      string(APPEND job_cases "      case (\"${name}\")\n         lines = job_${name}\n")
      list(APPEND job_names "\"${name}\"")
   endforeach()
   list(JOIN job_names ", " job_names)
   configure_file("${jobs_TEMPLATE}" "${jobs_OUTPUT}" @ONLY)
   # Doubled quotes can make lines long; the texts need no optimisation.
   set_property(SOURCE "${jobs_OUTPUT}" PROPERTY COMPILE_OPTIONS ${scree_line_flags} -O0)
endfunction()
