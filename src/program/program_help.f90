! SPDX-License-Identifier: BSD-3-Clause
!> The text of `scree --help`.
module program_help
   use program_job_templates, only: scheduler_list
   implicit none
   private

   public :: help_text

contains

   !> Options, exit codes and examples on one screen of 80 columns.
   function help_text() result(text)
      character(len=:), allocatable :: text
      character(len=*), parameter :: newline = new_line("a")

      text = "usage: scree [options] DECK.nml"//newline//newline// &
         "  -n, --check            check the deck and its cost; --no-estimate: faster"//newline// &
         "  -p, --preview          draw the initial state and walls to OUTDIR_preview"// &
         newline// &
         "      --echo             print the deck with the values of all keys in SI"//newline// &
         "  -s, --set G.K=VALUE    replace a value of the deck; --unset G.K removes it"// &
         newline// &
         "  -c, --case NAME        prefix of all output files"//newline// &
         "  -o, --outdir DIR       folder of all output files, default out/CASE"//newline// &
         "  -r, --restart [FILE]   continue from FILE.h5 or the newest valid checkpoint"// &
         newline// &
         "      --overwrite        remove the results of a previous run of this case"//newline// &
         "  -q, --quiet            print only warnings and errors"//newline// &
         "      --force            override limits on particles, memory, output, dt_fixed"// &
         newline// &
         "      --template         print a deck with all keys and defaults"//newline// &
         "      --explain WHAT     explain a key, a group or a message (code or text)"// &
         newline// &
         "      --point            drive one material point, write CASE_point.csv"// &
         newline// &
         "      --grains           run a periodic cell of grains along its &stage groups"// &
         newline// &
         "      --list [WHAT]      materials, fields, shapes, units, examples, messages"// &
         newline// &
         "      --new EXAMPLE DIR  copy an example into a new folder"//newline// &
         "      --job SCHEDULER    print a job script for "//scheduler_list("or")//", with"// &
         newline// &
         "                         --nodes N, --ranks N, --threads N, --time D-HH:MM:SS"// &
         newline// &
         "      --digest FILE      digest of the state in a checkpoint"//newline// &
         "      --self-test        run small scenes and compare their digests"//newline// &
         "  -h, --help; -V, --version  this text; version, compiler and libraries"//newline//newline
      text = text//"exit codes: 0 finished, 2 error in deck or command line, 3 file error or"// &
         newline//"  existing results, 4 physics error, 5 internal error, 75 "// &
         "stopped: run again"//newline//newline//"examples:"//newline// &
         "  mpirun -n 4 scree scene.nml --restart --set 'material[sheet].poisson=0.3'"
   end function help_text
end module program_help
