#!/usr/bin/env bash
# From a fresh Debian 12 to a simulated GPU: installs what is missing, builds, makes a scene, runs the four designs.
# Usage: scripts/demo.sh [GAUSSIANS]   (default 60000)
set -euo pipefail
cd "$(dirname "$0")/.."
count=${1:-60000}
scripts/install_dependencies.sh
scripts/build.sh release grtx
grtx=build/release/grtx
out=out/demo
mkdir -p "$out"
"$grtx" synth --preset indoor --count "$count" --seed 1 -o "$out/indoor.ply"
"$grtx" info "$out/indoor.ply"
view=(--scene "$out/indoor.ply" --cameras "$out/indoor.cameras.json" --view 0)
"$grtx" trace "${view[@]}" --width 256 --height 256 --accel tlas-tri20 --checkpoint on --no-trace --image "$out/room.png"
"$grtx" run "${view[@]}" --width 64 --height 64 -o "$out/run"
echo
echo "Pictures: $PWD/$out/room.png (256x256), $PWD/$out/run/image.png (as simulated, 64x64)"
echo "Results:   $PWD/$out/run/results.json; charts and tables: $PWD/$out/run/report.html"
