#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Usage: scripts/setup.sh [--no-install] [--no-python] [--mpi openmpi|mpich|none]
#
# Installs the packages that are missing to build and run Scree on Debian 12, Ubuntu and similar
# systems: compiler, CMake, MPI and HDF5 from the system's packages (as root or with sudo), and a
# Python environment for tests and pictures in build/venv, with the package scree and the command
# scree-post in build/venv/bin. If no package is missing, nothing is downloaded.
#
#   --no-install  install no packages of the system: if some are missing, print the command
#                 that installs them and stop
#   --no-python   do not create the Python environment
#   --mpi NAME    openmpi (the default), mpich, or none: a serial HDF5 for a build with
#                 -DSCREE_MPI=OFF
#   --help        print this text
#
# Exit codes: 0 all packages are installed, 2 wrong option, 3 a package could not be installed.
set -euo pipefail
# shellcheck source=scripts/common.sh
source "$(dirname -- "${BASH_SOURCE[0]}")/common.sh"

may_install=yes
with_python=yes
mpi=openmpi
while (($# > 0)); do
   case "$1" in
      --no-install) may_install=no ;;
      --no-python) with_python=no ;;
      --mpi)
         mpi="${2:-}"
         [[ "${mpi}" =~ ^(openmpi|mpich|none)$ ]] \
            || stop_with 2 "--mpi takes openmpi, mpich or none, not '${mpi}'"
         shift
         ;;
      -h | --help)
         show_help "$0"
         exit 0
         ;;
      *) stop_with 2 "unknown option '$1'; see --help" ;;
   esac
   shift
done

missing=()
drawing=()

# Add a package to the list if a command is missing: need_command COMMAND PACKAGE
need_command() {
   command -v "$1" > /dev/null 2>&1 || missing+=("$2")
}

# A Python with the module venv: the first one in the search path, or that of the system.
find_python() {
   local candidate
   for candidate in python3 /usr/bin/python3; do
      if "${candidate}" -c 'import sys, venv, ensurepip; sys.exit(sys.version_info < (3, 9))' \
         2> /dev/null; then
         printf '%s\n' "${candidate}"
         return
      fi
   done
}

is_installed() {
   [[ "$(dpkg-query -W -f='${db:Status-Abbrev}' "$1" 2> /dev/null)" == ii* ]]
}

collect_missing() {
   missing=()
   if [[ -z "$(find_compiler)" ]]; then
      if command -v gfortran > /dev/null 2>&1; then
         missing+=(gfortran-12) # the default of this system is older
      else
         missing+=(gfortran)
      fi
   fi
   need_command cmake cmake
   if ! command -v make > /dev/null 2>&1; then
      need_command ninja ninja-build
   fi
   need_command git git
   collect_libraries
   # The generator of the unit tests works with any python3; the environment needs venv.
   need_command python3 python3
   if [[ "${with_python}" == yes && ! -x "${python}" && -z "$(find_python)" ]]; then
      missing+=(python3-venv)
   fi
}

# MPI, and the HDF5 library that was built with it.
collect_libraries() {
   local packages=(ca-certificates)
   case "${mpi}" in
      openmpi) packages+=(openmpi-bin libopenmpi-dev libhdf5-openmpi-dev) ;;
      mpich) packages+=(mpich libmpich-dev libhdf5-mpich-dev) ;;
      none) packages+=(libhdf5-dev) ;;
   esac
   if command -v dpkg-query > /dev/null 2>&1; then
      local package
      for package in "${packages[@]}"; do
         is_installed "${package}" || missing+=("${package}")
      done
   elif [[ "${mpi}" == none ]]; then
      need_command h5fc "${packages[-1]}"
   else
      need_command mpiexec "${packages[1]}"
      need_command mpifort "${packages[2]}"
      need_command h5pfc "${packages[3]}"
   fi
}

# VTK needs these libraries to draw without a screen. The pictures of scripts/run.sh do not need
# them, so they are installed where possible, and their absence is not an error.
collect_drawing() {
   local package
   drawing=()
   [[ "${with_python}" == yes ]] && command -v dpkg-query > /dev/null 2>&1 || return 0
   for package in libegl1 libgl1 libxrender1; do
      is_installed "${package}" || drawing+=("${package}")
   done
}

# Sudo is used if it needs no password, or if the user can type the password.
may_use_sudo() {
   command -v sudo > /dev/null 2>&1 || return 1
   [[ -t 0 ]] || sudo -n true 2> /dev/null
}

install_missing() {
   # Ninja is faster than make; it is installed only together with other packages.
   command -v ninja > /dev/null 2>&1 || drawing+=(ninja-build)
   local as_root=()
   if [[ "$(id -u)" != 0 ]]; then
      as_root=(sudo)
      if ! may_use_sudo; then
         stop_with 3 "packages are missing and can only be installed by root; please run
   apt-get install ${missing[*]}"
      fi
   fi
   if ! command -v apt-get > /dev/null 2>&1; then
      stop_with 3 "this system has no apt-get; please install what these Debian packages hold:
   ${missing[*]}"
   fi
   missing+=("${drawing[@]}")
   say "Installing: ${missing[*]}"
   "${as_root[@]}" apt-get update -qq || say "The list of packages could not be renewed."
   "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
      apt-get install -y -qq --no-install-recommends "${missing[@]}" \
      || stop_with 3 "apt-get could not install ${missing[*]}"
}

setup_python() {
   local requirements="${root}/python/pyproject.toml"
   local stamp="${root}/build/venv/requirements.stamp"
   local commands="${root}/build/venv/bin"
   # if the environment cannot be moved to this folder, a new one is created below
   renew_python || rm -rf "${root}/build/venv"
   if [[ -x "${python}" ]] && cmp -s "${requirements}" "${stamp}" \
      && "${commands}/scree-post" --version > /dev/null 2>&1; then
      return
   fi
   local creator
   creator="$(find_python)"
   if ! "${python}" -m pip --version > /dev/null 2>&1; then
      say "Making a Python environment in build/venv"
      mkdir -p "${root}/build"
      "${creator}" -m venv --clear "${root}/build/venv" \
         || stop_with 3 "the Python environment could not be made; is python3-venv installed?"
   fi
   say "Installing Python packages into build/venv"
   "${python}" -m pip install --quiet --disable-pip-version-check "${root}/python[develop]" \
      || stop_with 3 "pip could not install the packages of python/pyproject.toml"
   "${python}" -m pip install --quiet --disable-pip-version-check "${root}/python[mpi]" \
      || say "pip could not install mpi4py; python/pyproject.toml names the effect"
   link_packages || stop_with 3 "pip could not install the folder python"
   cp "${requirements}" "${stamp}"
   printf '%s\n' "${root}" > "${root}/build/venv/place.stamp"
}

collect_missing
if [[ "${may_install}" == yes ]]; then
   collect_drawing
elif ((${#missing[@]} > 0)); then
   stop_with 3 "packages are missing; install them with scripts/setup.sh, which uses sudo, or with
   apt-get install ${missing[*]}"
fi
if ((${#missing[@]} > 0)) || { ((${#drawing[@]} > 0)) && [[ "$(id -u)" == 0 ]]; }; then
   install_missing
   hash -r
   collect_missing
   ((${#missing[@]} == 0)) || stop_with 3 "still missing after installation: ${missing[*]}"
fi
if [[ "${with_python}" == yes ]]; then
   setup_python
fi
