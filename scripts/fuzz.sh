#!/bin/sh
# Mutates the inputs of every reader for long, seed after seed, until a find or the end of the time:
#   scripts/fuzz.sh [MINUTES [BUILD_FOLDER [FIRST_SEED]]]
# What a test finds it writes to the temporary folder as grtx_find_*; the seed and the mutation are in the message.
set -eu
minutes=${1:-10}
build=${2:-build/release}
seed=${3:-$(date +%s)}
end=$(($(date +%s) + minutes * 60))
while [ "$(date +%s)" -lt "$end" ]; do
  echo "seed $seed"
  export GRTX_FUZZ="${GRTX_FUZZ:-3000}" GRTX_FUZZ_SEED="$seed"
  "$build/tests/frontend_tests" --gtest_brief=1 --gtest_filter='ReaderFuzz.*'
  "$build/tests/explore_tests" --gtest_brief=1 --gtest_filter='ExploreFuzz.*'
  "$build/tests/rtl_tlm_tests" --gtest_brief=1 --gtest_filter='TraceFuzz.*'
  seed=$((seed + 1))
done
