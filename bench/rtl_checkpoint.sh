#!/usr/bin/env bash
# The checkpoint unit's RTL against the SystemC unit: 1,000 random traces, each with a configuration of its own, every
# second one with disturbances at the pins.
#   bench/rtl_checkpoint.sh [CASES]      needs the tests of the release build; half a minute
set -euo pipefail
cd "$(dirname "$0")/.."
GRTX_RTL_CASES=${1:-1000} build/release/tests/rtl_tlm_tests --gtest_filter='CheckpointRtl.AgreesToTheCycle*'
