#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Usage: scripts/test.sh [--full | --long] [options] [options of ctest]
#
# Installs what is missing, builds, and runs the tests of one tier:
#
#   scripts/test.sh                smoke: every part of the program, at most 4 minutes on 2 cores
#   scripts/test.sh --full         all that is verified by default
#   scripts/test.sh --long         studies that take many minutes each
#   scripts/test.sh -R deck        tests of --full with deck in their names
#   scripts/test.sh -L unit       unit, verify, invariance, input, hard, random, gate or bench
#
#   --long-share [K]  besides, a third of the long tests: K = 0, 1, 2, or by the day; those whose
#                     length is not recorded are begun last, and what does not end in time is named
#   --minutes N       time for all tests with --long-share (default 70)
#   --debug           build and test the Debug build, with bounds and floating point checks
#   --no-setup        neither look for nor install missing packages
#   --record          write how long the tests took into test/costs.csv
#   --jobs N          cores to use (default: all, or TEST_JOBS of the environment)
#   --help            this text (ctest --help: all options)
#
# The last lines list known misses, skipped parts and failures, and how long the next tier takes.
set -euo pipefail
# shellcheck source=scripts/common.sh
source "$(dirname -- "${BASH_SOURCE[0]}")/common.sh"

type=Release
folder="${root}/build"
setup=yes
arguments=()
for argument in "$@"; do
   case "${argument}" in
      --debug)
         type=Debug
         folder="${root}/build/debug"
         ;;
      --no-setup) setup=no ;;
      -h | --help)
         show_help "$0"
         exit 0
         ;;
      *) arguments+=("${argument}") ;;
   esac
done

if [[ "${setup}" == yes ]]; then
   "${scripts}/setup.sh"
fi
"${scripts}/build.sh" "${type}"
exec python3 "${scripts}/run_tests.py" --folder "${folder}" "${arguments[@]}"
