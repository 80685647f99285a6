#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The program with profile-guided optimisation (GCC), in build/pgo: scripts/build_pgo.sh
# Builds with counters, simulates three generated scenes, and builds again with what they counted. Results are the same.
set -euo pipefail
cd "$(dirname "$0")/.."
folder=build/pgo
flags="-fprofile-update=single -fprofile-partial-training"
runs=$(mktemp -d)
trap 'rm -rf "$runs"' EXIT

build() {  # WAY OPTIONS: counters or their use
  cmake --preset release -B "$folder" -DGRTX_BUILD_TESTS=OFF -DCMAKE_CXX_COMPILER_LAUNCHER= -DCMAKE_CXX_FLAGS="$flags $1" >/dev/null
  cmake --build "$folder" --target grtx
}

rm -rf "$folder"
build "-fprofile-generate"
grtx=$folder/grtx
for shape in hall object garden; do
  "$grtx" synth --preset "$shape" --count 20000 --seed 7 -o "$runs/$shape.ply" --quiet
  "$grtx" run --scene "$runs/$shape.ply" --cameras "$runs/$shape.cameras.json" --width 32 --height 32 \
    --machine paper-charged -o "$runs/$shape" --quiet
done
build "-fprofile-use -Wno-missing-profile -Wno-coverage-mismatch"
echo "$grtx"
