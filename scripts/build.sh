#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Configures and builds a preset (release unless named): scripts/build.sh [PRESET] [TARGET...]
# Without npm the reports get tables only.
set -euo pipefail
cd "$(dirname "$0")/.."
preset=${1:-release}
shift || true
log=$(mktemp)
trap 'rm -f "$log"' EXIT
charts=()
command -v npm >/dev/null || charts=(-DGRTX_REPORT_CHARTS=OFF)
cmake --preset "$preset" "${charts[@]}" >"$log" 2>&1 || { cat "$log" >&2; exit 1; }
cmake --build --preset "$preset" ${@:+--target "$@"}
