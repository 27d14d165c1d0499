#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Usage: scripts/test.sh [--debug] [--no-setup] [options of ctest]
#
# Installs what is missing, builds and runs the tests: unit, verification, invariance, input,
# hard cases and gates. Tests with the label long or bench run only if that label is named:
#
#   scripts/test.sh                all but the long ones
#   scripts/test.sh -L unit        one label
#   scripts/test.sh -L long        the long ones
#   scripts/test.sh -R deck        tests with deck in their names
#
#   --debug       build and test the Debug build, with bounds and floating point checks
#   --no-setup    neither look for nor install missing packages
#   --help        this text (ctest --help: all options)
#
# Environment: TEST_JOBS (tests at a time, default 2).
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

selection=()
if [[ " ${arguments[*]} " != *long* && " ${arguments[*]} " != *bench* ]]; then
   selection=(-LE '^(long|bench)$')
   if [[ " ${arguments[*]} " != *" -L "* && " ${arguments[*]} " != *" -R "* ]]; then
      selection+=(-L '^(unit|verify|invariance|input|hard|regress|gate)$')
   fi
fi

if [[ "${setup}" == yes ]]; then
   "${scripts}/setup.sh"
fi
"${scripts}/build.sh" "${type}"
cd "${folder}"
exec ctest --output-on-failure --no-tests=error -j "${TEST_JOBS:-2}" "${selection[@]}" \
   "${arguments[@]}"
