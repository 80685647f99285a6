#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Manual pages by help2man: man_pages.sh GRTX FOLDER writes grtx.1 and grtx-COMMAND.1 from what --help prints. Their date is
# that of CITATION.cff, or SOURCE_DATE_EPOCH where it is set: two builds write the same bytes.
set -euo pipefail
released=$(sed -n 's/^date-released: //p' "$(dirname "$0")/../CITATION.cff")
export SOURCE_DATE_EPOCH="${SOURCE_DATE_EPOCH:-$(date -ud "$released" +%s)}" LC_ALL=C
version=$("$1" --version | cut -d, -f1)
mkdir -p "$2"
PATH=$(cd "$(dirname "$1")" && pwd):$PATH
page() { # COMMAND SUMMARY
  local command=${1:+-$1}
  help2man --no-info --version-string="$version" --name="$2" "grtx${1:+ $1}" |
    sed -e "s/^\.TH GRTX/&${command^^}/" -e "s/^grtx \\\\-/grtx$command \\\\-/"
}
page "" "$("$1" --help | head -1)" >"$2/grtx.1"
"$1" --help | sed -n '/^Subcommands:/,$ s/^  \([a-z-]*\) *\(.*\)/\1 \2/p' | while read -r name summary; do
  page "$name" "$summary" >"$2/grtx-$name.1"
done
