#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Usage: scripts/run.sh [DECK.nml] [options of scree]
#
# Installs missing packages, builds the program, runs a deck and makes its pictures. The default
# deck is the debris cloud, input/debris_cloud/scene.nml. Results are written to out/CASE/, where
# CASE is the `case` of the deck or, if that is not set, the name of the deck file (of its folder if
# the file is named scene.nml).
#
#   --no-setup    do not check for or install missing packages
#   --help        print this text (scree --help: options of the program)
#
# Environment: RANKS (MPI ranks, default 1), OMP_NUM_THREADS (threads per rank, default: the cores
# divided by the ranks, or fewer if the scene cannot use them). Options after the deck are passed to
# the program: scripts/run.sh deck.nml --check. Results of an earlier run are kept unless --restart
# or --overwrite is given.
set -euo pipefail
# shellcheck source=scripts/common.sh
source "$(dirname -- "${BASH_SOURCE[0]}")/common.sh"

setup=yes
deck=""
case_name=""
options=()
while (($# > 0)); do
   case "$1" in
      --no-setup) setup=no ;;
      -h | --help)
         show_help "$0"
         exit 0
         ;;
      --case=*) case_name="${1#--case=}" ;;
      -c | --case)
         (($# > 1)) || stop_with 2 "$1 needs a name"
         case_name="$2"
         shift
         ;;
      -s | --set | -o | --outdir)
         (($# > 1)) || stop_with 2 "$1 needs a value"
         options+=("$1" "$2")
         shift
         ;;
      -*) options+=("$1") ;;
      *)
         [[ -z "${deck}" ]] || stop_with 2 "two decks, '${deck}' and '$1'; see --help"
         deck="$1"
         ;;
   esac
   shift
done

deck="${deck:-${root}/input/debris_cloud/scene.nml}"
[[ -r "${deck}" ]] || stop_with 3 "cannot read the deck '${deck}'"
deck="$(cd -- "$(dirname -- "${deck}")" && pwd -P)/$(basename -- "${deck}")"

# Name of the case: the key `case` of the deck, or else from the path of the deck.
if [[ -z "${case_name}" ]]; then
   case_name="$(sed -n "s/^[^!]*\bcase *= *[\"']\([^\"']*\)[\"'].*/\1/Ip" "${deck}" | head -n 1)"
fi
if [[ -z "${case_name}" ]]; then
   case_name="$(basename -- "${deck}" .nml)"
   if [[ "${case_name}" == scene ]]; then
      case_name="$(basename -- "$(dirname -- "${deck}")")"
   fi
fi

# Folder of the results: an --outdir of the user comes last and takes precedence.
folder="${root}/out/${case_name}"
for ((i = 0; i < ${#options[@]}; i++)); do
   case "${options[i]}" in
      --outdir=*) folder="${options[i]#--outdir=}" ;;
      -o | --outdir) folder="${options[i + 1]}" ;;
      *) ;;
   esac
done

ranks="${RANKS:-1}"
[[ "${ranks}" =~ ^[1-9][0-9]*$ ]] || stop_with 2 "RANKS='${ranks}' is not a positive number"

if [[ "${setup}" == yes ]]; then
   "${scripts}/setup.sh"
fi
"${scripts}/build.sh" --no-tests Release

command=("${root}/build/bin/scree")
if ((ranks > 1)); then
   command=(mpiexec -n "${ranks}" "${command[@]}")
fi
mkdir -p "$(dirname -- "${folder}")"
code=0
"${command[@]}" --case "${case_name}" --outdir "${folder}" "${options[@]}" "${deck}" || code=$?
((code == 0)) || exit "${code}"

# Draw a picture of a result: picture COMMAND INPUT PICTURE
pictures=()
picture() {
   [[ -f "$2" ]] || return 0
   if [[ ! -x "${python}" ]]; then
      say "No pictures: scripts/setup.sh makes the Python environment that they need."
      return 0
   fi
   PYTHONPATH="${root}/python/src" "${python}" -m scree_post "$1" "$2" --out "$3"
   pictures+=("$3")
}

started="${folder}/${case_name}"
picture radiograph "${started}_p.hdf.series" "${started}_radiograph.png"
picture plot "${started}_history.csv" "${started}_history.png"
for path in "${pictures[@]}"; do
   say "picture  ${path}"
done
