#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Clock at which fp32 operators of rtl_tlm/rtl close, placed and routed on an iCE40 HX8K (40 nm), each between two registers.
# The units themselves have more logic than that device. Seed 1.
#   scripts/rtl_fmax.sh [OPERATOR...]      default: all; apt-get install yosys nextpnr-ice40
# DEPTH=N in the environment: N registers behind the operator, which Yosys moves into it, with those around it.
set -euo pipefail
depth=${DEPTH:-1}
cd "$(dirname "$0")/.."
declare -A expression=(
  [fp_add]='fp_add(a, b)' [fp_mul]='fp_mul(a, b)' [fp_min]='fp_less(a, b) ? a : b' [fp_scale]="fp_mul(a, 32'h3f800003)"
  [fp_divide]='fp_divide(a, {a[16:0], b})')
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
synthesis="synth_ice40 -top top"
if [ "$depth" != 1 ]; then  # without carry chains, which registers cannot be moved across
  synthesis="synth_ice40 -nocarry -top top -run begin:map_ffs; dfflegalize -cell \$_DFF_P_ x; \
    abc -dff -g AND,XOR,MUX -script +strash;ifraig;scorr;dc2;retime,-M,5;strash;map; opt_clean; \
    synth_ice40 -nocarry -run map_ffs:"
fi
for operator in "${@:-fp_add fp_mul fp_min fp_scale fp_divide}"; do
  for name in $operator; do
    cat > "$folder/top.sv" <<VERILOG
module top(input logic clk, input logic in, output logic out);
\`include "fp32.svh"
  logic [31:0] a, b;
  logic [48:0] $(seq -s ', ' -f 'y%g' 1 "$depth");
  always_ff @(posedge clk) begin
    {a, b} <= {a[30:0], b, in};
    y1 <= ${expression[$name]};
$(for i in $(seq 2 "$depth"); do echo "    y$i <= y$((i - 1));"; done)
    out <= ^y$depth;
  end
endmodule
VERILOG
    yosys -q -p "read_verilog -sv -Irtl_tlm/rtl $folder/top.sv; $synthesis; write_json $folder/top.json" > /dev/null
    nextpnr-ice40 --hx8k --package ct256 --seed 1 --json "$folder/top.json" > "$folder/log" 2>&1
    cells=$(grep -oE 'ICESTORM_LC: +[0-9]+' "$folder/log" | tail -1 | grep -oE '[0-9]+')
    mhz=$(grep -oE 'Max frequency for clock[^:]*: [0-9.]+' "$folder/log" | tail -1 | grep -oE '[0-9.]+$')
    printf '%-10s depth %s %6s logic cells %8s MHz\n' "$name" "$depth" "$cells" "$mhz"
  done
done
