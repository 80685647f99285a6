#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The documentation as a site, with search and the reference of the public headers: scripts/site.sh [--install] [-o FOLDER]
#   --install       installs what it takes from Debian's packages first (root or sudo); --install-only: nothing else
#   -o              where the site goes (default build/site): a new or empty folder, or an earlier site, which goes
# After the packages nothing is fetched. Pages open from the disk (build/site/index.html); the search wants a server: python3 -m
# http.server -d build/site. Links to sources lead to GRTX_FORGE (docs/site/links.py). Exit code 1: a link leads nowhere.
set -euo pipefail
here=$(cd "$(dirname "$0")/.." && pwd)
packages=(mkdocs mkdocs-material doxygen python3)
out=
install=
fail() { echo "site.sh: $1" >&2; exit 2; }
while [ $# -gt 0 ]; do
  case "$1:${2:+value}" in
    --install:* | --install-only:*) install=$1; shift ;;
    -o:value) out=$2; shift 2 ;;
    *) fail "$1: must be --install, --install-only or -o FOLDER" ;;
  esac
done
# mkdocs empties the folder: nobody's files but those of a site.
if [ -n "$out" ] && [ -n "$(ls -A "$out" 2>/dev/null)" ] && [ ! -d "$out/assets/javascripts" ]; then
  fail "-o $out: must be a new or empty folder, or an earlier site"
fi
if [ -n "$install" ]; then
  as_root=()
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || fail "run as root or install sudo; needed: ${packages[*]}"
    as_root=(sudo)
  fi
  "${as_root[@]}" apt-get update -q
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends "${packages[@]}"
  [ "$install" = --install ] || exit 0
fi
for program in mkdocs doxygen; do
  command -v $program >/dev/null || fail "$program is missing: scripts/site.sh --install"
done
mkdir -p "${out:=$here/build/site}"
out=$(cd "$out" && pwd)
cd "$here"
PYTHONDONTWRITEBYTECODE=1 mkdocs build --strict -d "$out" 2> >(grep -v INFO >&2)
version=$(sed -n 's/^project(grtx_tlm VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt)
{ cat docs/api/Doxyfile && printf '%s\n' "INPUT = $(scripts/public_headers.py --list | tr '\n' ' ')" "PROJECT_NUMBER = $version" \
  "OUTPUT_DIRECTORY = \"$out\"" "HTML_OUTPUT = api"; } | doxygen - >/dev/null
echo "site: $out/index.html" >&2
