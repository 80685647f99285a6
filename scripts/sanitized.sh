#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# AddressSanitizer and UndefinedBehaviorSanitizer over what reads files and knows no SystemC, with the tests that damage them:
# scripts/sanitized.sh [BUILD_FOLDER]. Three minutes on two cores without ccache; everything else under sanitizers: scripts/nightly.sh.
set -euo pipefail
# GCC 12's sanitizers die where the kernel randomises more than 28 bits of addresses: there, everything runs without.
[ "$(cat /proc/sys/vm/mmap_rnd_bits 2>/dev/null || echo 28)" -le 28 ] || ((0x$(cat /proc/self/personality) & 0x40000)) ||
  ! setarch -R true 2>/dev/null || exec setarch -R "$0" "$@"
cd "$(dirname "$0")/.."
build=${1:-build/sanitized}
programs=(base_tests traces_tests reader_tests)
log=$(mktemp)
trap 'rm -f "$log"' EXIT
cmake --preset asan -B "$build" -DGRTX_BUILD_MODULES=OFF >"$log" 2>&1 || { cat "$log" >&2; exit 1; }
cmake --build "$build" --target "${programs[@]}"
for program in "${programs[@]}"; do "$build/tests/$program" --gtest_brief=1; done
