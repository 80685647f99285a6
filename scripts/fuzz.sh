#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Two ways to damage the inputs of every reader for long:
#   scripts/fuzz.sh [MINUTES [BUILD_FOLDER [FIRST_SEED]]]    the seeded mutations of the tests, seed after seed (also the traces
#                                                          that are simulated afterwards)
#   scripts/fuzz.sh --guided [RUNS [SECONDS [READER...]]]   libFuzzer under ASan and UBSan, RUNS executions a reader or SECONDS,
#                                                          whichever comes first; builds preset fuzz (clang) but for
#                                                          GRTX_FUZZER=PROGRAM
# A find ends the script with its command; the input lies in the temporary folder as grtx_find_* or in build/fuzz/finds.
set -eu
cd "$(dirname "$0")/.."
if [ "${1:-}" = --guided ]; then
  shift
  runs=${1:-1000000}
  seconds=${2:-3600}
  [ $# -gt 0 ] && shift
  [ $# -gt 0 ] && shift
  fuzzer=${GRTX_FUZZER:-build/fuzz/tests/fuzz_readers}
  [ -n "${GRTX_FUZZER:-}" ] || scripts/build.sh fuzz fuzz_readers
  export ASAN_OPTIONS=detect_leaks=0:allocator_may_return_null=1
  # The archive's inputs and the sound files to begin with; LLVM_PROFILE_FILE: the build counts lines, too.
  export LLVM_PROFILE_FILE=/dev/null
  code=0
  readers=${*:-$("$fuzzer")}  # without a reader it prints their names
  for reader in $readers; do
    corpus=build/fuzz/corpus/$reader
    mkdir -p "$corpus" build/fuzz/finds
    GRTX_FUZZ_READER=$reader GRTX_FUZZ_SEEDS=$corpus "$fuzzer" >/dev/null 2>&1 || { echo "fuzz.sh: $fuzzer cannot write the seeds of $reader" >&2; exit 1; }
    if [ -f "tests/fuzz/corpus/$reader.tar.zst" ]; then zstd -dcq "tests/fuzz/corpus/$reader.tar.zst" | tar -xf - -C "$corpus"; fi
    log=build/fuzz/finds/$reader.log
    # As long as the longest file to begin with, which libFuzzer would cut, and a quarter.
    longest=$(find "$corpus" -type f -printf '%s\n' | sort -n | tail -1)
    longest=$((longest * 5 / 4 > 8192 ? longest * 5 / 4 : 8192))
    # A reader that asks for more than 1 GB for an input of some KB has believed what the input claims.
    if GRTX_FUZZ_READER=$reader "$fuzzer" "$corpus" -runs="$runs" -max_total_time="$seconds" -max_len="$longest" -timeout="${GRTX_FUZZ_TIMEOUT:-20}" \
      -rss_limit_mb=2048 -malloc_limit_mb=1024 -artifact_prefix="build/fuzz/finds/$reader-" >"$log" 2>&1; then
      echo "| $reader | $(sed -n 's/^Done \([0-9]*\) runs in \([0-9]*\) second.*/\1 | \2/p' "$log") | none |"
    else
      code=1
      echo "| $reader | $(sed -n 's/^#\([0-9]*\).*/\1/p' "$log" | tail -1) | | $(grep -m1 -E 'ERROR: |runtime error|what\(\)' "$log") |"
    fi
  done
  exit $code
fi
minutes=${1:-10}
build=${2:-build/release}
seed=${3:-$(date +%s)}
end=$(($(date +%s) + minutes * 60))
while [ "$(date +%s)" -lt "$end" ]; do
  echo "seed $seed"
  export GRTX_FUZZ="${GRTX_FUZZ:-3000}" GRTX_FUZZ_SEED="$seed"
  "$build/tests/reader_tests" --gtest_brief=1
  "$build/tests/explore_tests" --gtest_brief=1 --gtest_filter='*InputFuzz.*'
  "$build/tests/report_tests" --gtest_brief=1 --gtest_filter='*InputFuzz.*'
  "$build/tests/rtl_tlm_tests" --gtest_brief=1 --gtest_filter='TraceFuzz.*'
  seed=$((seed + 1))
done
