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
"$grtx" run --scene "$out/indoor.ply" --cameras "$out/indoor.cameras.json" --view 0 -o "$out/run"
echo
echo "Picture:  $PWD/$out/run/image.png"
echo "Results:  $PWD/$out/run/results.json"
