#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The RTL of the checkpoint, the ray-box and the ray-transform unit against the SystemC units: of each 1,000 random traces,
# each with a configuration of its own, every second one with disturbances at the pins.
#   bench/rtl_random.sh [CASES]      needs the tests of the release build; minutes
set -euo pipefail
cd "$(dirname "$0")/.."
GRTX_RTL_CASES=${1:-1000} build/release/tests/rtl_tlm_tests --gtest_filter='*Rtl.*Agree*ToTheCycle*'
