#!/usr/bin/env bash
# Synthesises arithmetic that the cost model prices - fp32 operators, a ray box, a ray transform, a checkpoint lane - with
# Yosys and the OSU 180 nm library, and compares gate equivalents (area over that of the library's NAND2X1) with the
# model's. Exit code 1: a unit is off by more than 20 % from the model with its synthesised coefficients.
#   scripts/synthesis_check.sh [GRTX]      default build/release/grtx; takes some minutes
# Needs yosys and qflow-tech-osu018; with iverilog the operators are first checked against exact arithmetic.
#   apt-get install yosys qflow-tech-osu018 iverilog python3
# UNITS="fp_add ray_box" chooses units. VECTORS=60000 operands for the check of the operators.
set -euo pipefail
cd "$(dirname "$0")/.."
grtx=${1:-build/release/grtx}
library=${OSU018:-/usr/share/qflow/tech/osu018/osu018_stdcells.lib}
units=${UNITS:-fp_add fp_mul fp_min ray_box ray_transform checkpoint_lane}
for needed in "$library" "$grtx"; do
  [[ -e "$needed" ]] || { echo "synthesis_check.sh: $needed is missing (see the head of this script)" >&2; exit 2; }
done
command -v yosys > /dev/null || { echo "synthesis_check.sh: yosys is needed (apt-get install yosys)" >&2; exit 2; }
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

if command -v iverilog > /dev/null && command -v python3 > /dev/null; then
  synthesis/vectors.py "${VECTORS:-60000}" > "$folder/vectors.hex"
  iverilog -g2005 -o "$folder/bench" synthesis/operators_bench.v synthesis/operators.v synthesis/fp32.v
  (cd "$folder" && ./bench) | tee "$folder/checked"
  grep -q ', 0 wrong' "$folder/checked" || { echo "synthesis_check.sh: the operators are wrong" >&2; exit 1; }
fi

# What the model counts in each unit: operator, bits, how often; and flip-flop bits.
counts() {
  case $1 in
    fp_add) echo "fp_add 32 1" ;;
    fp_mul) echo "fp_mul 32 1" ;;
    fp_min) echo "fp_compare 32 1" ;;
    ray_box) echo "fp_add 32 6 fp_mul 32 6 fp_compare 32 10 flip-flop 1 1089" ;;
    ray_transform) echo "fp_add 32 15 fp_mul 32 18 flip-flop 1 1248" ;;
    checkpoint_lane) echo "fp_compare 32 2 mul_constant 16 2 int_add 64 2 increment 16 2 int_compare 16 2" ;;
  esac
}

"$grtx" cost --coefficients > "$folder/coefficients"
nand=$(awk '/cell *\(NAND2X1\)/ { inside = 1 } inside && /area/ { gsub(/[^0-9.]/, ""); print; exit }' "$library")
printf '%-16s %10s %8s | %11s %7s | %9s %7s | %s\n' unit 'GE (yosys)' 'FF bits' 'synthesised' 'ratio' 'central' 'ratio' \
  'low to high'
failed=0
for unit in $units; do
  yosys -q -p "read_verilog synthesis/fp32.v synthesis/ray_box.v synthesis/ray_transform.v synthesis/checkpoint_lane.v; synth -flatten -top $unit; dfflibmap -liberty $library;
               abc -liberty $library; opt_clean; tee -q -o $folder/$unit.stat stat -liberty $library" > "$folder/$unit.log" ||
    { cat "$folder/$unit.log" >&2; exit 2; }
  area=$(awk '/Chip area/ { print $NF }' "$folder/$unit.stat")
  bits=$(awk '/DFF/ { sum += $2 } END { print sum + 0 }' "$folder/$unit.stat")
  # Columns of the table of coefficients: name, bits (", scales" when per bit), low / central / high, synthesised.
  awk -F '|' -v unit="$unit" -v counts="$(counts "$unit")" -v area="$area" -v nand="$nand" -v bits="$bits" '
    { gsub(/ /, "", $2); split($4, range, "/"); known[$2] = 1; width[$2] = $3 + 0
      low[$2] = range[1]; central[$2] = range[2]; high[$2] = range[3]; own[$2] = $5 ~ /[0-9]/ ? $5 + 0 : range[2] + 0 }
    END {
      known["flip-flop"] = 1; width["flip-flop"] = 1; own["flip-flop"] = own["flip-flopbit"]
      low["flip-flop"] = low["flip-flopbit"]; central["flip-flop"] = central["flip-flopbit"]
      high["flip-flop"] = high["flip-flopbit"]
      n = split(counts, part, " ")
      for (i = 1; i < n; i += 3) {
        name = part[i]
        if (!(name in known)) { print "no coefficient of " name > "/dev/stderr"; exit 2 }
        factor = part[i + 2] * part[i + 1] / width[name]
        sum_own += factor * own[name]; sum_low += factor * low[name]
        sum_central += factor * central[name]; sum_high += factor * high[name]
      }
      ge = area / nand
      printf "%-16s %10.0f %8d | %11.0f %7.2f | %9.0f %7.2f | %.0f to %.0f\n", unit, ge, bits, sum_own, ge / sum_own,
        sum_central, ge / sum_central, sum_low, sum_high
      exit (ge / sum_own < 0.8 || ge / sum_own > 1.2)
    }' "$folder/coefficients" || failed=1
done
exit $failed
