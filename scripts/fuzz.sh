#!/bin/sh
# Two ways to damage the inputs of every reader for long:
#   scripts/fuzz.sh [MINUTES [BUILD_FOLDER [FIRST_SEED]]]    the seeded mutations of the tests, seed after seed (also the traces
#                                                          that are simulated afterwards)
#   scripts/fuzz.sh --guided [RUNS [SECONDS [READER...]]]   libFuzzer under ASan and UBSan, RUNS executions a reader or SECONDS,
#                                                          whichever comes first; builds preset fuzz (clang)
# A find ends the script with its command; the input lies in the temporary folder as grtx_find_* or in build/fuzz/finds.
set -eu
cd "$(dirname "$0")/.."
if [ "${1:-}" = --guided ]; then
  shift
  runs=${1:-1000000}
  seconds=${2:-3600}
  [ $# -gt 0 ] && shift
  [ $# -gt 0 ] && shift
  fuzzer=build/fuzz/tests/fuzz_readers
  [ -n "${GRTX_FUZZ_BUILT:-}" ] || scripts/build.sh fuzz fuzz_readers
  export ASAN_OPTIONS=detect_leaks=0:allocator_may_return_null=1
  code=0
  for reader in ${@:-$($fuzzer)}; do
    corpus=build/fuzz/corpus/$reader
    mkdir -p "$corpus" build/fuzz/finds
    GRTX_FUZZ_READER=$reader GRTX_FUZZ_SEEDS=$corpus $fuzzer >/dev/null 2>&1
    log=build/fuzz/finds/$reader.log
    # A reader that asks for more than 1 GB for an input of 4 KB has believed what the input claims.
    if GRTX_FUZZ_READER=$reader $fuzzer "$corpus" -runs="$runs" -max_total_time="$seconds" -max_len=8192 -timeout=20 \
      -rss_limit_mb=2048 -malloc_limit_mb=1024 -artifact_prefix="build/fuzz/finds/$reader-" >"$log" 2>&1; then
      echo "| $reader | $(sed -n 's/^Done \([0-9]*\) runs in \([0-9]*\) second.*/\1 | \2/p' "$log") | none |"
    else
      code=1
      echo "| $reader | $(grep -c '^#' "$log") | | $(grep -m1 -E 'ERROR: |runtime error|what\(\)' "$log") |"
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
  "$build/tests/explore_tests" --gtest_brief=1 --gtest_filter='*InputFuzz.*'
  "$build/tests/rtl_tlm_tests" --gtest_brief=1 --gtest_filter='TraceFuzz.*'
  seed=$((seed + 1))
done
