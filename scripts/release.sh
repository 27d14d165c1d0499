#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Usage: scripts/release.sh [--no-deb] [--no-site] FOLDER
#
# Makes the files of a release from the commit that is checked out, without changes:
#
#   scree-VERSION.tar.gz              the sources
#   scree_mpm-VERSION-py3-none-any.whl  the Python package
#   scree_VERSION-1_ARCHITECTURE.deb  the program for Debian 12 (not with --no-deb)
#   scree-manual-VERSION.tar.gz       the manual as a site (not with --no-site)
#   recipes/                          for Spack, conda, container images
#   SHA256SUMS                        checksums of all of them
#
# The version is that of project() in CMakeLists.txt. One commit gives the same bytes in any folder,
# with the same compiler, libraries and Python packages.
#
# Exit codes: 0 made, 1 a step failed, 2 wrong option, 3 something is missing or not committed.
set -euo pipefail
# shellcheck source=scripts/common.sh
source "$(dirname -- "${BASH_SOURCE[0]}")/common.sh"

deb=yes
site=yes
folder=""
while (($# > 0)); do
   case "$1" in
      --no-deb) deb=no ;;
      --no-site) site=no ;;
      -h | --help)
         show_help "$0"
         exit 0
         ;;
      -*) stop_with 2 "unknown option '$1'; see --help" ;;
      *) folder="$1" ;;
   esac
   shift
done
[[ -n "${folder}" ]] || stop_with 2 "no folder; see --help"
[[ -x "${python}" ]] || stop_with 3 "build/venv is missing; run scripts/setup.sh"
[[ -z "$(git -C "${root}" status --porcelain)" ]] || stop_with 3 "there are changes that are not \
committed; commit or remove them"
mkdir -p "${folder}"
folder="$(cd -- "${folder}" && pwd -P)"
[[ -z "$(ls -A "${folder}")" ]] || stop_with 3 "'${folder}' is not empty"

version="$(find_version < "${root}/CMakeLists.txt")"
SOURCE_DATE_EPOCH="$(git -C "${root}" log -1 --format=%ct)"
export SOURCE_DATE_EPOCH
umask 022
work="$(mktemp -d)"
trap 'rm -rf "${work}"' EXIT

archive_commit HEAD "scree-${version}" > "${folder}/scree-${version}.tar.gz"

tar -C "${work}" -xzf "${folder}/scree-${version}.tar.gz"
(
   cd "${work}/scree-${version}/python"
   "${python}" -m hatchling build -t wheel -d "${folder}" > /dev/null
)

if [[ "${site}" == yes ]]; then
   "${scripts}/site.sh" --release "${work}/site" > /dev/null
   cp "${work}/site/scree-manual-${version}.tar.gz" "${folder}"
fi

if [[ "${deb}" == yes ]]; then
   "${scripts}/packages/make_deb.sh" "${work}/deb" > "${work}/deb.log" 2>&1 \
      || { tail -n 40 "${work}/deb.log" >&2; stop_with 1 "the Debian package cannot be built"; }
   cp "${work}"/deb/scree_*.deb "${folder}"
fi

mkdir "${folder}/recipes"
sum="$(sha256sum "${folder}/scree-${version}.tar.gz" | cut -d ' ' -f 1)"
fill_in() {
   sed -e "s/@VERSION@/${version}/g" -e "s/@SHA256@/${sum}/g" "$1"
}
mkdir "${folder}/recipes/spack" "${folder}/recipes/conda"
fill_in "${scripts}/packages/spack/package.py.in" > "${folder}/recipes/spack/package.py"
fill_in "${scripts}/packages/conda/recipe.yaml.in" > "${folder}/recipes/conda/recipe.yaml"
cp "${scripts}/packages/conda/variants.yaml" "${folder}/recipes/conda"
cp "${scripts}/packages/Containerfile" "${scripts}/packages/scree.def" "${folder}/recipes"

(
   cd "${folder}"
   find . -type f ! -name SHA256SUMS -printf '%P\n' | LC_ALL=C sort | xargs -d '\n' sha256sum
) > "${work}/SHA256SUMS"
cp "${work}/SHA256SUMS" "${folder}"
say "release  ${folder}"
cat "${folder}/SHA256SUMS"
