#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# From a fresh Debian 12 or 13 to simulated GPUs: installs what is missing, builds, makes a scene and a picture, runs six
# designs on three machines and says what the numbers mean.
# Usage: scripts/demo.sh [--count GAUSSIANS] [-o FOLDER] [--program GRTX]
#   --count    Gaussians of the scene (default 400000)
#   -o         where pictures, results and the report go (default out/demo)
#   --program  this grtx: nothing is installed or built
set -euo pipefail
here=$(cd "$(dirname "$0")/.." && pwd)
count=400000
out=
grtx=
while [ $# -gt 0 ]; do
  case "$1:${2:+value}" in
    --count:value) count=$2 ;;
    -o:value) out=$2 ;;
    --program:value) grtx=$2 ;;
    *) echo "demo.sh: $1: must be --count N, -o FOLDER or --program GRTX" >&2; exit 2 ;;
  esac
  shift 2
done
case "$count" in
  *[!0-9]* | 0*) echo "demo.sh: --count $count: must be a number of Gaussians" >&2; exit 2 ;;
esac
[ -z "$grtx" ] || command -v "$grtx" >/dev/null || { echo "demo.sh: --program $grtx: no such program" >&2; exit 2; }
mkdir -p "${out:=$here/out/demo}"
out=$(cd "$out" && pwd)
begin=$SECONDS
step() { printf '\n== %s (%d:%02d)\n' "$1" $(((SECONDS - begin) / 60)) $(((SECONDS - begin) % 60)); }

if [ -z "$grtx" ]; then
  step "1/5 Debian packages"
  "$here/scripts/install_dependencies.sh" --minimal
  step "2/5 Build"
  "$here/scripts/build.sh" release grtx
  grtx=$here/build/release/grtx
fi

step "3/5 A scene of $count Gaussians, and its picture"
"$grtx" synth --preset hall --count "$count" --seed 1 -o "$out/hall.ply"
view=(--scene "$out/hall.ply" --cameras "$out/hall.cameras.json" --view 0)
"$grtx" trace "${view[@]}" --width 512 --height 512 --accel tlas-sphere --tracing single --k 64 --no-trace --image "$out/hall.png" --quiet >"$out/hall.txt"
echo "picture, 512 x 512: $out/hall.png"

results=()
# One SM each, with its share of L2 and DRAM: 4,096 rays would leave eight SMs half empty, and say little of a GPU at work.
for machine in paper-1sm charged-1sm rdna4-1sm; do
  step "4/5 Six designs on the machine $machine, 64 x 64 rays"
  "$grtx" run "${view[@]}" --width 64 --height 64 --mode cycle \
    --machine "$here/configs/demo/$machine.toml" -o "$out/$machine" >"$out/$machine.txt"
  results+=("$out/$machine/results.json")
done

step "5/5 Results"
"$grtx" report "${results[@]}" --image "$out/hall.png" --title "GRTX-TLM: the demo" -o "$out/report.html"
python3 "$here/scripts/demo_table.py" "$(basename "$grtx")" "${results[@]}"
echo "Report, open it in a browser: $out/report.html"
