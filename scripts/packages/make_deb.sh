#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Usage: scripts/packages/make_deb.sh [--source] [--commit COMMIT] FOLDER
#
# Makes the Debian packages of a commit in FOLDER: the source archive scree_VERSION.orig.tar.gz, the
# source package and scree_VERSION-1_ARCHITECTURE.deb. The sources come from git, so changes that
# are not committed are left out. doc/developer/packaging.md explains the package.
#
#   --source          prepare FOLDER/scree-VERSION and the source archive, build nothing
#   --commit COMMIT   commit of the package, default HEAD
#   --help            print this text
#
# Environment: DEBFULLNAME and DEBEMAIL, the maintainer; default: the author of the commit.
#
# Exit codes: 0 made, 2 wrong option, 3 git or dpkg-buildpackage is missing, 1 it fails.
set -euo pipefail
here="$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")" && pwd -P)"
# shellcheck source=scripts/common.sh
source "${here}/../common.sh"

build=yes
commit=HEAD
folder=""
while (($# > 0)); do
   case "$1" in
      --source) build=no ;;
      --commit)
         (($# > 1)) || stop_with 2 "--commit needs a commit"
         commit="$2"
         shift
         ;;
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
command -v git > /dev/null 2>&1 || stop_with 3 "git was not found"
if [[ "${build}" == yes ]]; then
   command -v dpkg-buildpackage > /dev/null 2>&1 \
      || stop_with 3 "dpkg-buildpackage was not found; it is in the Debian package dpkg-dev"
fi

version="$(git -C "${root}" show "${commit}:CMakeLists.txt" | find_version)"
[[ -n "${version}" ]] || stop_with 1 "CMakeLists.txt of ${commit} has no version"
maintainer="${DEBFULLNAME:-$(git -C "${root}" log -1 --format=%an "${commit}")}"
maintainer+=" <${DEBEMAIL:-$(git -C "${root}" log -1 --format=%ae "${commit}")}>"
date="$(git -C "${root}" log -1 --format=%cD "${commit}")"
mkdir -p "${folder}"
folder="$(cd -- "${folder}" && pwd -P)"
sources="${folder}/scree-${version}"
rm -rf "${sources}"
archive_commit "${commit}" "scree-${version}" > "${folder}/scree_${version}.orig.tar.gz"
tar -C "${folder}" -xzf "${folder}/scree_${version}.orig.tar.gz"
cp -r "${sources}/scripts/packages/debian" "${sources}/debian"
for file in control changelog; do
   sed -i -e "s|@VERSION@|${version}|g" -e "s|@MAINTAINER@|${maintainer}|g" \
      -e "s|@DATE@|${date}|g" "${sources}/debian/${file}"
done
# the terms after the heading and the copyright of LICENSE, as a Debian paragraph
sed '1,/^Copyright/d' "${sources}/LICENSE" | sed -e '/./,$!d' -e 's/^$/./' -e 's/^/ /' \
   > "${folder}/licence.part"
sed -i -e "/@LICENSE@/{r ${folder}/licence.part" -e 'd}' "${sources}/debian/copyright"
rm "${folder}/licence.part"
say "sources  ${sources}"
[[ "${build}" == yes ]] || exit 0
cd "${sources}"
dpkg-buildpackage -us -uc
say "package  $(ls "${folder}"/scree_"${version}"-1_*.deb)"
