#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Usage: scripts/test.sh [--full | --long] [options] [options of ctest]
#
# Builds the program and runs the tests of one tier. Packages of the system are only installed with
# --setup; without it a message names those that are missing.
#
#   scripts/test.sh                smoke: every part of the program, at most 4 minutes on 2 cores
#   scripts/test.sh --full         all default tests, at most 25 minutes
#   scripts/test.sh --long         studies that take many minutes each
#   scripts/test.sh -R deck        tests of --full with deck in their names
#   scripts/test.sh -L unit       unit, verify, invariance, input, hard, random, gate or bench
#
#   --long-share [K]  also run a group of long tests that end in the remaining time; K is
#                     the number of the group (default: the next one every day)
#   --minutes N       time limit for all tests with --long-share (default 32)
#   --debug           build and test the Debug build, with bounds and floating point checks
#   --setup           install missing packages of the system, as root or with sudo
#   --no-setup        do not look for missing packages, and leave build/venv as it is
#   --record          write the processor time of the tests to test/costs.csv
#   --jobs N          number of cores (default: all, or TEST_JOBS of the environment)
#   --help            print this text (ctest --help: all options)
#
# The last lines list known misses, skipped parts and failures, and the duration of the next tier.
set -euo pipefail
# shellcheck source=scripts/common.sh
source "$(dirname -- "${BASH_SOURCE[0]}")/common.sh"

type=Release
folder="${root}/build"
setup=(--no-install)
arguments=()
for argument in "$@"; do
   case "${argument}" in
      --debug)
         type=Debug
         folder="${root}/build/debug"
         ;;
      --setup) setup=() ;;
      --no-setup) setup=no ;;
      -h | --help)
         show_help "$0"
         exit 0
         ;;
      *) arguments+=("${argument}") ;;
   esac
done

if [[ "${setup[*]}" != no ]]; then
   "${scripts}/setup.sh" "${setup[@]}"
fi
"${scripts}/build.sh" "${type}"
exec python3 "${scripts}/run_tests.py" --folder "${folder}" "${arguments[@]}"
