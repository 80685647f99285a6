#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# AddressSanitizer and UndefinedBehaviorSanitizer over what reads files and knows no SystemC, with the tests that damage them:
# scripts/sanitized.sh [BUILD_FOLDER]. Three minutes on two cores without ccache; everything else under sanitizers: scripts/nightly.sh.
set -euo pipefail
cd "$(dirname "$0")/.."
build=${1:-build/sanitized}
programs=(base_tests traces_tests reader_tests)
log=$(mktemp)
trap 'rm -f "$log"' EXIT
cmake --preset asan -B "$build" -DGRTX_BUILD_MODULES=OFF >"$log" 2>&1 || { cat "$log" >&2; exit 1; }
cmake --build "$build" --target "${programs[@]}"
for program in "${programs[@]}"; do "$build/tests/$program" --gtest_brief=1; done
