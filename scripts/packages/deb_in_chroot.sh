#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Usage: scripts/packages/deb_in_chroot.sh build|test FOLDER [SUITE]
#
# build   builds the Debian package of FOLDER (scripts/packages/make_deb.sh --source FOLDER) in a
#         minimal Debian system that has its build dependencies alone, checks it with lintian and
#         puts the packages into FOLDER
# test    installs the package of FOLDER in another minimal system and runs debian/tests there
#
# SUITE is a release of Debian, default bookworm. Needs mmdebstrap, and root or user namespaces. The
# systems are temporary.
#
# Exit codes: 0 passed, 1 a step failed, 2 wrong option, 3 mmdebstrap is missing.
set -euo pipefail
here="$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")" && pwd -P)"
# shellcheck source=scripts/common.sh
source "${here}/../common.sh"

case "${1:-}" in
   build | test) step="$1" ;;
   -h | --help)
      show_help "$0"
      exit 0
      ;;
   *) stop_with 2 "the first word is build or test; see --help" ;;
esac
[[ -d "${2:-}" ]] || stop_with 2 "'${2:-}' is no folder; see --help"
folder="$(cd -- "$2" && pwd -P)"
suite="${3:-bookworm}"
command -v mmdebstrap > /dev/null 2>&1 || stop_with 3 "mmdebstrap was not found"
version="$(find_version < "$(echo "${folder}"/scree-*/CMakeLists.txt)")"

# Run commands in the system: in_system TEXT
in_system() {
   local inside="env HOME=/root LC_ALL=C.UTF-8 sh -ec '$1'"
   printf '%s' "--customize-hook=chroot \"\$1\" ${inside}"
}

if [[ "${step}" == build ]]; then
   mmdebstrap --variant=buildd --include=lintian,ca-certificates \
      --customize-hook="mkdir -p \"\$1/build\"" \
      --customize-hook="copy-in ${folder}/scree-${version} ${folder}/scree_${version}.orig.tar.gz \
/build" \
      "$(in_system "cd /build/scree-${version} && apt-get --yes --quiet --no-install-recommends \
build-dep . > /dev/null")" \
      "$(in_system "cd /build/scree-${version} && \
export DEB_BUILD_OPTIONS=parallel=${JOBS:-2} && \
dpkg-buildpackage -us -uc > ../build.log 2>&1 || { tail -n 40 ../build.log; false; }")" \
      "$(in_system "cd /build && \
lintian --allow-root --fail-on error,warning --info --display-info \
*.changes > lintian.log || { cat lintian.log; touch lintian.failed; }")" \
      --customize-hook="cp \"\$1\"/build/*.log \"\$1\"/build/*.deb \"\$1\"/build/*.dsc \
\"\$1\"/build/*.changes \"\$1\"/build/*.buildinfo \"\$1\"/build/*.debian.tar.* '${folder}'" \
      --customize-hook="test ! -e \"\$1/build/lintian.failed\"" \
      "${suite}" - > /dev/null
   say "packages $(echo "${folder}"/scree*.deb)"
else
   mmdebstrap --variant=minbase --include=ca-certificates,openssh-client \
      --customize-hook="copy-in ${folder}/scree_${version}-1_$(dpkg --print-architecture).deb \
${folder}/scree-${version}/debian/tests /opt" \
      "$(in_system "apt-get --yes --quiet --no-install-recommends install /opt/scree_*.deb \
> /dev/null")" \
      "$(in_system "scree --version && scree --self-test")" \
      "$(in_system "OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 \
mpirun -n 2 --oversubscribe scree --self-test")" \
      "$(in_system "test \"$(dpkg --print-architecture)\" != amd64 || /opt/tests/processors")" \
      "$(in_system "/opt/tests/example && test -z \"\$(ls -A /tmp | grep scree_self_test)\"")" \
      "${suite}" - > /dev/null
   say "the installed package works"
fi
