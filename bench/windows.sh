#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Windows mode against whole traces: statistics for bench/estimate_errors.py --windows FOLDER.
#   bench/windows.sh GRTX SCENES FOLDER
# SCENES holds the public rooms (scripts/scenes.sh) and the unpacked objects. Six scenes, three designs, four seeds:
# 192 x 144 pixels on one SM of eight warps are windows enough. What is there already is not run again.
set -euo pipefail
grtx=$1 scenes=$2 folder=$3
mkdir -p "$folder"
machine=(--machine paper-charged --set gpu.sms=1 --set gpu.resident_warps=8 --set l2.bytes=524288 --set l2.slices=1)
while read -r scene file cameras view; do
  for design in baseline:tri20:off sw:tlas-tri20:off grtx:tlas-tri20:on; do
    IFS=: read -r name accel checkpoint <<<"$design"
    case=$folder/$scene.$name
    [ -s "$case.4.json" ] && continue
    "$grtx" trace --scene "$scenes/$file.ply" --cameras "$scenes/$cameras.cameras.json" --view "$view" --width 192 --height 144 \
      --accel "$accel" --checkpoint "$checkpoint" -o "$case.grtx" --quiet
    "$grtx" sim "$case.grtx" "${machine[@]}" --stats "$case.whole.json" --quiet
    for seed in 1 2 3 4; do
      "$grtx" sim "$case.grtx" "${machine[@]}" --mode windows --seed "$seed" --stats "$case.$seed.json" --quiet
    done
    rm -f "$case.grtx"
  done
done <<'SCENES'
wang_sha wang_sha wang_sha 1
lacadiere lacadiere lacadiere 0
playbot playbot_500k_sh2 playbot 0
taebak taebak taebak 1
headquarter_garden headquarter_garden headquarter_garden 0
pizza pizza_161k_sh3 pizza 1
SCENES
