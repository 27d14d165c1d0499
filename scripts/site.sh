#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Usage: scripts/site.sh [--release FOLDER]
#
# Builds the manual as a website in build/site; open build/site/index.html. The site needs no
# network connection: pages, pictures, formulas and the search index are read from disk. A broken
# link stops the build.
#
#   --release FOLDER   build into FOLDER/VERSION instead, add the version to FOLDER/versions.json
#                      (a web server that serves FOLDER then shows a menu of all versions), and pack
#                      the site into FOLDER/scree-manual-VERSION.tar.gz for the release
#   --help             print this text
#
# Environment: SCREE_REPOSITORY, the address of a public repository, the target of links to sources;
# without it linked sources are part of the site.
#
# Exit codes: 0 built, 1 a page or a link is wrong, 2 wrong option, 3 MkDocs is missing.
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
cd "${root}"

# Build into a folder. The option --quiet is not used, because MkDocs would then not count warnings.
build_site() {
   local said
   export NO_MKDOCS_2_WARNING=1
   if ! said="$("${python}" -m mkdocs build --strict --site-dir "$1" 2>&1)"; then
      printf '%s\n' "${said}" | grep -v '^INFO' >&2
      exit 1
   fi
}

if [[ -z "${release}" ]]; then
   build_site build/site
   say "site     ${root}/build/site/index.html"
   exit 0
fi

version="$(find_version < CMakeLists.txt)"
mkdir -p "${release}"
release="$(cd -- "${release}" && pwd -P)"
export SCREE_SITE_RELEASE="${version}"
# the time of the commit, so that the same commit gives the same archive
SOURCE_DATE_EPOCH="${SOURCE_DATE_EPOCH:-$(git log -1 --format=%ct 2> /dev/null || date +%s)}"
export SOURCE_DATE_EPOCH
build_site "${release}/${version}"
"${python}" - "${release}" << 'END'
import json
import pathlib
import re
import sys

folder = pathlib.Path(sys.argv[1])
names = [path.parent.name for path in folder.glob("*/index.html")]
names = [name for name in names if re.fullmatch(r"[\d.]+", name)]
names.sort(key=lambda name: [int(part) for part in name.split(".")], reverse=True)
rows = [{"version": name, "title": name, "aliases": []} for name in names]
rows[0]["aliases"] = ["latest"]
(folder / "versions.json").write_text(json.dumps(rows, indent=2) + "\n", encoding="utf-8")
head = f'<meta http-equiv="refresh" content="0; url={names[0]}/index.html">'
(folder / "index.html").write_text(f"<!doctype html>{head}<title>Scree</title>\n", encoding="utf-8")
END
tar -C "${release}" --sort=name --mtime="@${SOURCE_DATE_EPOCH}" --owner=0 --group=0 \
   --numeric-owner --transform "s,^${version},scree-manual-${version}," -cf - "${version}" \
   | gzip --no-name --best > "${release}/scree-manual-${version}.tar.gz"
say "site     ${release}/${version}/index.html"
say "archive  ${release}/scree-manual-${version}.tar.gz"
