#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Builds grtx with g++ -O3, g++ -O0 and clang++ -O2, traces and simulates the same small scene with each, and compares
# traces, images and statistics byte for byte (host.* aside: wall time, memory). Exit code 1 at the first difference.
#   scripts/compare_builds.sh [FOLDER]      builds in FOLDER (default build/compare) and keeps it for the next time
# REFERENCE=PROGRAM uses a grtx that g++ -O3 has built already (build/release/grtx) in place of the first build.
# OTHERS="NAME=PROGRAM ..." compares those with it, and builds nothing else.
# Needs what scripts/install_dependencies.sh installs, and clang++ (Debian: apt-get install clang). CLANGXX names another.
set -euo pipefail
cd "$(dirname "$0")/.."
folder=${1:-build/compare}
clang=${CLANGXX:-$(command -v clang++ || command -v clang++-14 || true)}
if [[ -z "$clang" ]]; then
  echo "compare_builds.sh: clang++ is needed (apt-get install clang, or CLANGXX=path)" >&2
  exit 2
fi
mkdir -p "$folder"

build() {  # NAME COMPILER FLAGS
  cmake -S . -B "$folder/$1" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_COMPILER="$2" \
    -DCMAKE_CXX_FLAGS_RELEASE="$3" -DCMAKE_UNITY_BUILD=ON -DGRTX_BUILD_TESTS=OFF -DGRTX_REPORT_CHARTS=OFF > "$folder/$1.log"
  cmake --build "$folder/$1" --target grtx -j "${JOBS:-$(nproc)}" >> "$folder/$1.log" ||
    { tail -30 "$folder/$1.log" >&2; exit 2; }
}

builds=(gcc_O3 gcc_O0 clang_O2)
if [[ -n "${REFERENCE:-}" ]]; then
  mkdir -p "$folder/gcc_O3" && cp "$REFERENCE" "$folder/gcc_O3/grtx"
else
  build gcc_O3 g++ -O3
fi
if [[ -n "${OTHERS:-}" ]]; then
  builds=(gcc_O3)
  for other in $OTHERS; do
    builds+=("${other%%=*}")
    mkdir -p "$folder/${other%%=*}" && { [ "${other#*=}" -ef "$folder/${other%%=*}/grtx" ] || cp "${other#*=}" "$folder/${other%%=*}/grtx"; }
  done
else
  build gcc_O0 g++ -O0
  build clang_O2 "$clang" -O2
fi

# Everything of a statistics file but host.* (the last statistics) and the comma before it.
portable() { grep -v '"host\.' "$1" | sed 's/,$//'; }

# Each run: NAME, options of `grtx trace`, settings of `grtx sim`.
runs=(
  "baseline|--accel tri20 --checkpoint off|"
  "sw|--accel tlas-tri20 --checkpoint off|"
  "hw|--accel tri20 --checkpoint on|"
  "grtx|--accel tlas-tri20 --checkpoint on|"
  "sphere|--accel tlas-sphere --checkpoint on --warp-size 16|--set rt.warp_buffer.spill=true --set rt.warp_buffer.stack_entries=4"
  "single|--accel tri80 --checkpoint off --tracing single --k 64 --mapping linear|--set rt.memory.by_shader=true --set gpu.rt_units=2"
)
scene=$folder/scene.ply
"$folder/gcc_O3/grtx" synth --preset flat --count 2000 --seed 7 -o "$scene" --quiet
for run in "${runs[@]}"; do
  IFS='|' read -r name trace_options settings <<< "$run"
  for build in "${builds[@]}"; do
    out=$folder/$build.$name
    # shellcheck disable=SC2086  # several options in one string
    "$folder/$build/grtx" trace --quiet --machine configs/table1.toml --scene "$scene" --cameras "$folder/scene.cameras.json" --view 0 --width 32 \
      --height 32 $trace_options -o "$out.grtx" --image "$out.pfm"
    # shellcheck disable=SC2086
    "$folder/$build/grtx" sim --quiet "$out.grtx" --machine configs/table1.toml --config configs/small.toml $settings --stats "$out.json"
    for other in "$out.grtx" "$out.pfm"; do
      cmp "$folder/gcc_O3.$name.${other##*.}" "$other"
    done
    diff <(portable "$folder/gcc_O3.$name.json") <(portable "$out.json")
  done
  echo "$name: the same trace, image and $(portable "$folder/gcc_O3.$name.json" | grep -c '"value"') statistics with ${builds[*]}"
done
