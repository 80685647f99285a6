#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The documentation as a site, with search and the reference of the public headers: scripts/site.sh [--install] [-o FOLDER]
#   --install       installs what it takes from Debian's packages first (root or sudo); --install-only: nothing else
#   -o              where the site goes (default build/site); what lies there goes
# After the packages nothing is fetched. The site works from the disk: open build/site/index.html. Exit code 1: a link of
# it leads nowhere.
set -euo pipefail
here=$(cd "$(dirname "$0")/.." && pwd)
packages=(mkdocs mkdocs-material doxygen python3)
out=$here/build/site
while [ $# -gt 0 ]; do
  case "$1:${2:+value}" in
    --install:* | --install-only:*)
      as_root=()
      [ "$(id -u)" -eq 0 ] || as_root=(sudo)
      "${as_root[@]}" apt-get update -q
      "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends "${packages[@]}"
      [ "$1" = --install ] || exit 0
      shift ;;
    -o:value) out=$(mkdir -p "$2" && cd "$2" && pwd); shift 2 ;;
    *) echo "site.sh: $1: must be --install, --install-only or -o FOLDER" >&2; exit 2 ;;
  esac
done
for program in mkdocs doxygen; do
  command -v $program >/dev/null || { echo "site.sh: $program is missing: scripts/site.sh --install" >&2; exit 2; }
done
# Debian's Python: mkdocs and its theme are its packages.
exec /usr/bin/python3 -B "$here/scripts/build_site.py" "$out"
