# SPDX-License-Identifier: BSD-3-Clause
# shellcheck shell=bash disable=SC2034
# Shared by the scripts in this folder; not to be run.

root="$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.." && pwd -P)"
scripts="${root}/scripts"
python="${root}/build/venv/bin/python"

# Open MPI refuses root and more ranks than cores unless told otherwise; on a laptop or in a
# container both are normal. Bound ranks would share one core between all their threads.
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
export OMPI_MCA_rmaps_base_oversubscribe="${OMPI_MCA_rmaps_base_oversubscribe:-1}"
export OMPI_MCA_hwloc_base_binding_policy="${OMPI_MCA_hwloc_base_binding_policy:-none}"
export OMPI_MCA_btl_vader_single_copy_mechanism="${OMPI_MCA_btl_vader_single_copy_mechanism:-none}"

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

# A gfortran of version 12 or newer, or nothing.
find_compiler() {
   local candidate version
   for candidate in ${FC:+"${FC}"} gfortran gfortran-12 gfortran-13 gfortran-14; do
      command -v "${candidate}" > /dev/null 2>&1 || continue
      version="$("${candidate}" -dumpversion 2> /dev/null | cut -d. -f1)" || continue
      if [[ "${version}" =~ ^[0-9]+$ ]] && ((version >= 12)); then
         printf '%s\n' "${candidate}"
         return
      fi
   done
}
