#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Usage: scripts/site.sh [--release FOLDER]
#
# Builds the manual as a site in build/site; open build/site/index.html. Pages, pictures, formulas and
# the search are read from disk: nothing is fetched when the site is viewed. A link that leads nowhere
# stops the build.
#
#   --release FOLDER   build into FOLDER/VERSION instead, name the version in FOLDER/versions.json, from
#                      which the pages offer all versions where a web server shows FOLDER, and pack the
#                      site into FOLDER/scree-manual-VERSION.tar.gz, to be attached to the release
#   --help             this text
#
# Environment: SCREE_REPOSITORY, the address of a public repository to which links to sources lead; without
# it linked sources are part of the site.
#
# Exit codes: 0 built, 1 a page or a link is wrong, 2 wrong option, 3 MkDocs is missing (scripts/setup.sh).
set -euo pipefail
# shellcheck source=scripts/common.sh
source "$(dirname -- "${BASH_SOURCE[0]}")/common.sh"

release=""
while (($# > 0)); do
   case "$1" in
      --release)
         (($# > 1)) || stop_with 2 "--release needs a folder"
         release="$2"
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

"${python}" -c 'import material, mathjax, mkdocs, mkdocstrings' 2> /dev/null \
   || stop_with 3 "MkDocs is not installed in build/venv; scripts/setup.sh installs it"
export NO_MKDOCS_2_WARNING=1
cd "${root}"
if [[ -z "${release}" ]]; then
   "${python}" -m mkdocs build --quiet --strict
   say "site     ${root}/build/site/index.html"
   exit 0
fi

version="$(sed -n 's/^project(scree VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt)"
mkdir -p "${release}"
release="$(cd -- "${release}" && pwd -P)"
SCREE_SITE_RELEASE="${version}" "${python}" -m mkdocs build --quiet --strict --site-dir "${release}/${version}"
"${python}" - "${release}" << 'END'
import json
import pathlib
import re
import sys

folder = pathlib.Path(sys.argv[1])
names = [path.parent.name for path in folder.glob("*/index.html") if re.fullmatch(r"[\d.]+", path.parent.name)]
names.sort(key=lambda name: [int(part) for part in name.split(".")], reverse=True)
rows = [{"version": name, "title": name, "aliases": ["latest"] if name == names[0] else []} for name in names]
(folder / "versions.json").write_text(json.dumps(rows, indent=2) + "\n", encoding="utf-8")
(folder / "index.html").write_text(
    f'<!doctype html><meta http-equiv="refresh" content="0; url={names[0]}/index.html"><title>Scree</title>\n',
    encoding="utf-8")
END
tar -C "${release}" -czf "${release}/scree-manual-${version}.tar.gz" \
   --transform "s,^${version},scree-manual-${version}," "${version}"
say "site     ${release}/${version}/index.html"
say "archive  ${release}/scree-manual-${version}.tar.gz"
