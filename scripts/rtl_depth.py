#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Longest path of a step of the intersection units when it has several registers, which synthesis moves into the operators.

    rtl_depth.py [--units fp_add,fp_mul,...] [--depths 1,2,3,...]

An operator of rtl_tlm/rtl/fp32.svh with N - 1 registers behind it takes N cycles: between the registers before and behind a step lie
N pieces. Yosys 0.23 and abc map it to the OSU 180 nm library (apt-get install yosys qflow-tech-osu018) and move the registers
(retime -M 5) for the shortest longest path, without wires and without sizing of cells. MHz: at 45 nm (x 0.175, and 0.10 ns for the
register), and at 12 nm with the two ends of the node table of docs/model/cost.md.
"""
import argparse
import json
import os
import subprocess
import sys
import tempfile

import rtl_gates

TO_45 = 3.37 / 19.21  # the model's adder at 45 nm over this one at 180 nm
REGISTER = 0.10       # ns at 45 nm
TO_12 = (0.34, 0.82)
# The longest step of each kind; a third of a division with its rounding is the longest of the transform.
STEPS = {"fp_add": "fp_add(a, b)", "fp_mul": "fp_mul(a, b)", "fp_scale": "fp_mul(a, 32'h3f800003)",
         "fp_compare": "fp_less(a, b) ? a : b", "fp_divide_begin": "fp_divide_begin(a)", "fp_divide": "fp_divide(a, {a[16:0], b})",
         "fp_reciprocal": "fp_reciprocal(a, {a[16:0], b})", "exchange": "a > b ? {a, b} : {b, a}"}


def path(name, depth):
    """Longest path in ns at 180 nm, and flip-flops."""
    width = 36 if name == "exchange" else 32
    text = (f"module operator(input logic clk, input logic [{width - 1}:0] a, input logic [{width - 1}:0] b, output logic [71:0] y);\n"
            f"`include \"fp32.svh\"\n  logic [71:0] p0;\n  always_comb p0 = {STEPS[name]};\n"
            + "".join(f"  logic [71:0] p{i};\n  always_ff @(posedge clk) p{i} <= p{i - 1};\n" for i in range(1, depth))
            + f"  assign y = p{depth - 1};\nendmodule\n")
    retime = "retime,-M,5;strash;" if depth > 1 else ""
    script = (f"read_verilog -sv -I{rtl_gates.TOP}/rtl_tlm/rtl operator.sv; hierarchy -top operator; proc; flatten; "
              "opt -nodffe -nosdff -full; wreduce; alumacc; opt -nodffe -nosdff; techmap; opt -nodffe -nosdff -fast; "
              "dfflegalize -cell $_DFF_P_ x; opt_clean; "
              f"tee -q -o abc.log abc {'-dff ' if depth > 1 else ''}-liberty {rtl_gates.LIBRARY} "
              f"-script +strash;ifraig;scorr;dc2;{retime}&get,-n;&nf;&put;topo;stime,-p; opt_clean; write_json netlist.json")
    with tempfile.TemporaryDirectory() as folder:
        with open(os.path.join(folder, "operator.sv"), "w", encoding="utf-8") as stream:
            stream.write(text)
        run = subprocess.run(["yosys", "-q", "-p", script], cwd=folder, capture_output=True, text=True)
        if run.returncode != 0:
            sys.exit(f"rtl_depth.py: yosys: {run.stderr.strip() or run.stdout[-500:]}")
        with open(os.path.join(folder, "abc.log"), encoding="utf-8") as stream:
            longest = rtl_gates.longest_path(stream.read())
        with open(os.path.join(folder, "netlist.json"), encoding="utf-8") as stream:
            cells = next(iter(json.load(stream)["modules"].values()))["cells"].values()
        return longest, sum(1 for cell in cells if "DFF" in cell["type"])


def megahertz(ns):
    """At 45 nm, and the two ends at 12 nm."""
    period = ns * TO_45 + REGISTER
    return 1e3 / period, 1e3 / (period * TO_12[1]), 1e3 / (period * TO_12[0])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--units", default=",".join(STEPS))
    parser.add_argument("--depths", default="1,2,3,4,5,6,8,10")
    options = parser.parse_args()
    if not os.path.exists(rtl_gates.LIBRARY):
        sys.exit(f"rtl_depth.py: {rtl_gates.LIBRARY} is missing (apt-get install qflow-tech-osu018)")
    print(f"{'step':14} {'depth':>5} {'180 nm, ns':>10} {'flip-flops':>10} {'45 nm':>9}   12 nm, MHz")
    for name in options.units.split(","):
        for depth in (int(d) for d in options.depths.split(",")):
            ns, registers = path(name, depth)
            at_45, low, high = megahertz(ns)
            print(f"{name:14} {depth:5} {ns:10.2f} {registers:10} {at_45:5.0f} MHz   {low:.0f} to {high:.0f}", flush=True)


if __name__ == "__main__":
    main()
