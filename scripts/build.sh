#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Usage: scripts/build.sh [--no-tests] [Release|Debug|Sanitize] [CMake options]
#
# Builds the program and the tests; installs nothing. Release (the default) is built in build/,
# Debug in build/debug and Sanitize in build/sanitize; the program is bin/scree in that folder.
# Further arguments are passed to CMake, for example -DSCREE_ARCH=x86-64-v3 for a program that runs
# on another machine, or -DSCREE_ARCH=dispatch for one that is fast on all x86-64.
#
#   --no-tests    build only the program, in a third of the time; a later call adds the tests
#   --help        print this text
#
# Environment: FC (compiler), JOBS (number of parallel compilations; default: all cores).
set -euo pipefail
# shellcheck source=scripts/common.sh
source "$(dirname -- "${BASH_SOURCE[0]}")/common.sh"

type=Release
target=()
if [[ "${1:-}" == --no-tests ]]; then
   target=(--target scree)
   shift
fi
if (($# > 0)); then
   case "$1" in
      Release | Debug | Sanitize)
         type="$1"
         shift
         ;;
      -h | --help)
         show_help "$0"
         exit 0
         ;;
      -D*) ;;
      *) stop_with 2 "unknown option or build type '$1'; there are --no-tests, before all others, \
and Release, Debug, Sanitize" ;;
   esac
fi

folder="${root}/build"
if [[ "${type}" != Release ]]; then
   folder="${root}/build/${type,,}"
fi

compiler="$(find_compiler)"
[[ -n "${compiler}" ]] || stop_with 3 "no gfortran 12 or newer was found; run scripts/setup.sh"
command -v cmake > /dev/null 2>&1 || stop_with 3 "cmake was not found; run scripts/setup.sh"

# A build folder that was copied or moved contains absolute paths of its former location.
cache="${folder}/CMakeCache.txt"
if [[ -f "${cache}" ]] && ! grep -qxF "CMAKE_HOME_DIRECTORY:INTERNAL=${root}" "${cache}"; then
   rm -rf "${cache}" "${folder}/CMakeFiles"
fi

generator=()
if [[ ! -f "${cache}" ]] && command -v ninja > /dev/null 2>&1; then
   generator=(-G Ninja)
fi
if [[ ! -f "${cache}" ]]; then
   generator+=("-DCMAKE_Fortran_COMPILER=${compiler}")
fi

# Configures, or reads only the files of CMake again that have changed since. The latter misses new
# options and a new Python environment.
configure() {
   local rules="${folder}/build.ninja"
   if [[ -f "${cache}" && -f "${rules}" && $# -eq 0 \
      && ! "${root}/build/venv/requirements.stamp" -nt "${rules}" ]]; then
      cmake --build "${folder}" --target build.ninja
   else
      cmake -S "${root}" -B "${folder}" "${generator[@]}" "-DCMAKE_BUILD_TYPE=${type}" "$@"
   fi
}

log="${folder}/configure.log"
mkdir -p "${folder}"
if ! configure "$@" > "${log}" 2>&1; then
   cat "${log}" >&2
   stop_with 3 "CMake could not configure; is something missing that scripts/setup.sh installs?"
fi
# CMake 3.25 puts the name of the source where Ninja expects that of the result into the list of the
# files that a scan for modules reads, and Ninja would repeat all scans in each build. The lists are
# not needed: no source includes another file.
if [[ -f "${folder}/CMakeFiles/rules.ninja" ]]; then
   sed -i '/^rule Fortran_SCAN__/,/^$/{/^  depfile = /d}' "${folder}/CMakeFiles/rules.ninja"
fi
renew_python || say "The Python environment is that of another folder; run scripts/setup.sh"
cmake --build "${folder}" --parallel "${JOBS:-$(nproc)}" "${target[@]}"
