# SPDX-License-Identifier: BSD-3-Clause
# shellcheck shell=bash disable=SC2034
# Functions shared by the scripts in this folder; do not run this file.

root="$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.." && pwd -P)"
scripts="${root}/scripts"
python="${root}/build/venv/bin/python"

# By default Open MPI refuses to run as root and to start more ranks than cores; both are normal on
# a laptop or in a container. With bound ranks all threads of a rank would share one core.
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
export OMPI_MCA_rmaps_base_oversubscribe="${OMPI_MCA_rmaps_base_oversubscribe:-1}"
export OMPI_MCA_hwloc_base_binding_policy="${OMPI_MCA_hwloc_base_binding_policy:-none}"
export OMPI_MCA_btl_vader_single_copy_mechanism="${OMPI_MCA_btl_vader_single_copy_mechanism:-none}"
# The same settings for Open MPI 5.
: "${PRTE_MCA_rmaps_default_mapping_policy:=:oversubscribe}"
: "${PRTE_MCA_hwloc_default_binding_policy:=none}"
export PRTE_MCA_rmaps_default_mapping_policy PRTE_MCA_hwloc_default_binding_policy

# Print the comment block at the head of a script, without its first two lines.
show_help() {
   awk 'NR > 2 { if ($0 !~ /^#/) exit; sub(/^# ?/, ""); print }' "$1"
}

say() {
   printf '%s\n' "$*"
}

# Stop with a message: stop_with CODE TEXT
stop_with() {
   local code="$1"
   shift
   printf '%s: %s\n' "$(basename -- "$0")" "$*" >&2
   exit "${code}"
}

# The major version of a Fortran compiler; nothing if it is unknown.
generation_of() {
   local told
   command -v "$1" > /dev/null 2>&1 || return 0
   told="$("$1" --version 2> /dev/null)" || return 0
   if [[ "${told}" =~ flang[^[:digit:]]*\ version\ ([0-9]+) ]]; then
      printf '%s\n' "${BASH_REMATCH[1]}"
   else
      "$1" -dumpversion 2> /dev/null | cut -d. -f1
   fi
}

# The version in the text of CMakeLists.txt on standard input, the only file that defines it.
find_version() {
   sed -n 's/^project(scree VERSION \([0-9.]*\).*/\1/p'
}

# Write the sources of a commit as a .tar.gz in which all names begin with PREFIX/. The same commit
# gives the same bytes: archive_commit COMMIT PREFIX
archive_commit() {
   git -C "${root}" archive --format=tar --prefix="$2/" "$1" | gzip --no-name --best
}

# The compiler in FC, or else the first gfortran of version 12 or newer; nothing if there is none.
find_compiler() {
   local candidate version
   for candidate in ${FC:+"${FC}"} gfortran gfortran-12 gfortran-13 gfortran-14 gfortran-15; do
      version="$(generation_of "${candidate}")" || continue
      if [[ "${version}" =~ ^[0-9]+$ ]] && ((version >= 12)); then
         printf '%s\n' "${candidate}"
         return
      fi
   done
}

# Install the packages of the folder python in editable mode, so that changes of the sources need no
# new installation.
link_packages() {
   # up to version 0.1 scree-post was a distribution of its own
   if compgen -G "${root}/build/venv/lib/python3*/site-packages/scree_post-*" > /dev/null; then
      "${python}" -m pip uninstall --quiet --yes scree-post || return 1
   fi
   # and the distribution of the folder python was called scree
   if compgen -G "${root}/build/venv/lib/python3*/site-packages/scree-*.dist-info" > /dev/null; then
      "${python}" -m pip uninstall --quiet --yes scree || return 1
   fi
   "${python}" -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation \
      --editable "${root}/python"
}

# After a folder was copied or moved, its Python environment contains the former path: in the first
# line of commands, and in links to the folder python. This function replaces the paths; nothing is
# downloaded.
renew_python() {
   local place="${root}/build/venv/place.stamp" bin="${root}/build/venv/bin"
   [[ -x "${python}" ]] || return 0
   [[ "$(cat -- "${place}" 2> /dev/null)" == "${root}" ]] && return 0
   say "Bringing the Python environment in build/venv to this folder"
   "${python}" -m venv --without-pip "${root}/build/venv" \
      || return 1
   "${python}" - "${bin}" "${python}" << 'END' || return 1
import pathlib
import sys

folder, python = pathlib.Path(sys.argv[1]), sys.argv[2]
# same form as pip: the kernel accepts neither blanks nor a long path after "#!"
head = f"#!{python}\n" if len(python.encode()) < 120 and " " not in python else (
    f"#!/bin/sh\n'''exec' \"{python}\" \"$0\" \"$@\"\n' '''\n")
for path in folder.iterdir():
    if path.is_symlink() or not path.is_file():
        continue
    data = path.read_bytes()
    lines = data.split(b"\n")
    if data.startswith(b"#!") and b"python" in lines[0]:
        rest = lines[1:]
    elif data.startswith(b"#!/bin/sh\n'''exec'"):
        rest = lines[3:]
    else:
        continue
    path.write_bytes(head.encode() + b"\n".join(rest))
END
   # an older environment may lack the packages for the build; the caller then creates a new one
   link_packages > /dev/null 2>&1 || return 1
   printf '%s\n' "${root}" > "${place}"
}
