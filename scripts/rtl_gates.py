#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Gates and longest paths of the RTL of the intersection units and of its fp32 operators, beside the cost model's.

    rtl_gates.py [--units fp_add,fp_mul,...] [--set KEY=VALUE ...] [--stages N,N,...] [--sized] [GRTX]   default build/release/grtx

Yosys 0.23 reads rtl_tlm/rtl, maps it to the OSU 180 nm library (apt-get install yosys qflow-tech-osu018) and adds up area, in
gate equivalents (area over that of the library's NAND2X1). The queue's memory is not among the gates. Longest path: abc, without
wires and without sizing of cells, of logic between two registers, at 180 nm. --set: keys of the configuration (rt.box.count; rt.box.latency:
the registers of a pipeline). --stages: flip-flops of pipelines of other depths. --sized: mapped for speed, with buffers and cells that
drive their loads; the path is that of a clock, the gates are more.
Exit code 1: a unit is off by more than 20 % from the model's central value.
"""
import argparse
import json
import os
import re
import subprocess
import sys
import tempfile

TOP = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
LIBRARY = os.environ.get("OSU018", "/usr/share/qflow/tech/osu018/osu018_stdcells.lib")
# As yosys runs it for a library, then the longest path.
ABC = "+strash;ifraig;scorr;dc2;dretime;strash;&get,-n;&nf;&put;topo;stime,-p"
# For speed, with buffers behind whatever drives many, and cells of a size that drives their load.
ABC_SIZED = "+strash;ifraig;scorr;dch,-f;map,-B,0.9;buffer,-c,-N,8;topo;upsize;dnsize;stime,-p"
WORD = "input logic [31:0] a, input logic [31:0] b, output logic [31:0] y"
# Operators of the cost model as this RTL has them.
OPERATORS = {
    "fp_add": (WORD, "fp_add(a, b)"),
    "fp_mul": (WORD, "fp_mul(a, b)"),
    "fp_compare": (WORD, "fp_less(a, b) ? a : b"),
    "fp_scale": (WORD, "fp_mul(a, 32'h3f800003)"),
    "fp_reciprocal": (WORD, "fp_reciprocal(a, fp_divide(a, fp_divide_begin(a)))"),
    "exchange": ("input logic [35:0] a, input logic [35:0] b, output logic [71:0] y", "a > b ? {a, b} : {b, a}"),
}
UNITS = {"ray_box": ("rt.box", ["ray_box_child", "ray_box_pipeline"]),
         "ray_transform": ("rt.transform", ["ray_transform_pipeline"])}


def node_of(tree, name):
    if tree.get("name") == name:
        return tree
    return next(filter(None, (node_of(child, name) for child in tree.get("children", []))), None)


def model(grtx, settings):
    command = [grtx, "cost", "--json", "--items", "--quiet"] + [a for s in settings for a in ("--set", s)]
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def coefficients(grtx, column=3):
    """{operator: (low, central and high of that column of the table (3: GE), its synthesised GE, or central where there is none)}."""
    text = subprocess.run([grtx, "cost", "--coefficients"], check=True, capture_output=True, text=True).stdout
    known = {}
    for line in text.splitlines():
        cells = [cell.strip() for cell in line.split("|")]
        if len(cells) > 6 and re.match(r"[\d.]+ / ", cells[column]) and not re.match(r"\d", cells[1]):
            low, central, high = (float(part) for part in cells[column].split("/"))
            own = float(cells[4]) if re.match(r"[\d.]+$", cells[4]) else central
            known[cells[1]] = (low, central, high, own)
    return known


def yosys(script, text=""):
    """Runs a script in a folder with `text` as file operator.sv; returns the log and the area by module."""
    with tempfile.TemporaryDirectory() as folder:
        with open(os.path.join(folder, "operator.sv"), "w", encoding="utf-8") as stream:
            stream.write(text)
        script = script.replace("ABC", f"tee -q -o abc.log abc -liberty {LIBRARY} -script {ABC}")
        run = subprocess.run(["yosys", "-q", "-p", script], cwd=folder, capture_output=True, text=True)
        if run.returncode != 0:
            sys.exit(f"rtl_gates.py: yosys: {run.stderr.strip() or run.stdout[-500:]}")
        read = lambda name: open(os.path.join(folder, name), encoding="utf-8").read() if os.path.exists(os.path.join(folder, name)) else ""
        return read("abc.log"), read("stat"), read("netlist.json")


def nand_area():
    with open(LIBRARY, encoding="utf-8") as stream:
        return float(re.search(r"cell *\(NAND2X1\).*?area *: *([\d.]+)", stream.read(), re.S).group(1))


def longest_path(log):
    """ns, the longest of all modules that abc mapped."""
    return max((float(ps) / 1e3 for ps in re.findall(r"Delay *= *([\d.]+) *ps", log)), default=0.0)


def operator(name):
    """Gate equivalents, longest path in ns and netlist of an operator by itself."""
    ports, expression = OPERATORS[name]
    text = f"module operator({ports});\n`include \"fp32.svh\"\nassign y = {expression};\nendmodule\n"
    log, stat, netlist = yosys(f"read_verilog -sv -I{TOP}/rtl_tlm/rtl operator.sv; hierarchy -top operator; proc; opt -full; wreduce; "
                         f"alumacc; opt; techmap; opt -fast; ABC; opt_clean; write_json netlist.json; tee -q -o stat stat -liberty {LIBRARY}", text)
    return float(re.search(r"Chip area.*: +([\d.]+)", stat).group(1)) / nand_area(), longest_path(log), netlist


def read_unit(unit, parameters):
    """Yosys commands up to a netlist of registers and words; pipelines and children stay modules of their own."""
    kept = UNITS[unit][1]
    keep = "".join(f"setattr -mod -set keep_hierarchy 1 *{module}*; " for module in kept)
    chparam = "".join(f" -chparam {name} {value}" for name, value in parameters.items())
    return (f"read_verilog -sv -I{TOP}/rtl_tlm/rtl {TOP}/rtl_tlm/rtl/intersection_queue.sv {TOP}/rtl_tlm/rtl/{unit}_unit.sv; "
            f"hierarchy -top {unit}_unit{chparam}; proc; {keep}flatten; memory_collect; "
            "delete -input */w:fault; setundef -undriven -zero; opt -full; opt_clean -purge; ")


def flip_flops(netlist):
    """Bits of registers and of memories, in the whole hierarchy."""
    modules = json.loads(netlist)["modules"]
    top = next(name for name, module in modules.items() if int(module["attributes"].get("top", "0"), 2))

    def of(name):
        registers = memory = 0
        for cell in modules[name]["cells"].values():
            kind, parameters = cell["type"], cell["parameters"]
            if kind in modules:
                inside = of(kind)
                registers, memory = registers + inside[0], memory + inside[1]
            elif kind.startswith("$mem"):
                memory += int(parameters["SIZE"], 2) * int(parameters["WIDTH"], 2)
            elif "dff" in kind:
                registers += int(parameters["WIDTH"], 2)
        return registers, memory
    return of(top)


def unit_gates(unit, parameters):
    log, stat, netlist = yosys(read_unit(unit, parameters) + "opt_clean; write_json netlist.json; alumacc; opt; techmap; "
                               f"opt -fast; dfflibmap -liberty {LIBRARY}; ABC; opt_clean; tee -q -o stat stat -liberty {LIBRARY}")
    registers, memory = flip_flops(netlist)
    own = dict(re.findall(r"Chip area for module '\\?(.*?)': +([\d.]+)", stat))
    area = float(re.search(r"Chip area for top module .*: +([\d.]+)", stat).group(1))
    return area / nand_area(), registers, memory, longest_path(log), {k: float(v) / nand_area() for k, v in own.items()}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("grtx", nargs="?", default=os.path.join(TOP, "build/release/grtx"))
    parser.add_argument("--units", default=",".join(list(OPERATORS) + list(UNITS)))
    parser.add_argument("--set", action="append", default=[], dest="settings")
    parser.add_argument("--stages", default="")
    parser.add_argument("--sized", action="store_true")
    options = parser.parse_args()
    if options.sized:
        global ABC
        ABC = ABC_SIZED
    if not os.path.exists(LIBRARY):
        sys.exit(f"rtl_gates.py: {LIBRARY} is missing (apt-get install qflow-tech-osu018)")
    known = coefficients(options.grtx)
    failed = False
    print(f"{'unit':15} {'GE (RTL)':>9} {'synthesised':>12} {'ratio':>6} {'central':>9} {'ratio':>6} {'low to high':>17} {'path, ns':>9}")

    def row(name, gates, values, path, note=""):
        low, central, high, own = values
        print(f"{name:15} {gates:9.0f} {own:12.0f} {gates / own:6.2f} {central:9.0f} {gates / central:6.2f} {low:8.0f} to {high:<6.0f} "
              f"{path:8.2f}{note}", flush=True)
        return not 0.8 <= gates / central <= 1.2

    for name in options.units.split(","):
        if name in OPERATORS:
            gates, path, _ = operator(name)
            row(name, gates, known[name], path) if name in known else print(f"{name:15} {gates:9.0f} {path:66.2f}", flush=True)
            continue
        document = model(options.grtx, options.settings)
        key = UNITS[name][0]
        node = node_of(document["tree"], name)
        config = document["config"]
        steps = 12 if name == "ray_box" else 6
        parameters = {"COUNT": config[f"{key}.count"], "STAGES": min(config[f"{key}.latency"], steps),
                      "RAYS": 32 * config["rt.warp_buffer.entries"]}
        gates, registers, memory, path, modules = unit_gates(name, parameters)
        items = [item for item in node["items"] if item["name"] != "queue"]
        values = [sum(item["gate_equivalents"][band] for item in items) for band in ("low", "central", "high")]
        own = 0.0
        for item in items:
            if item.get("bits"):
                own += item["bits"] * known["flip-flop bit"][3]
            else:
                operator_of = known[re.sub(r"\d+$", "", item["name"].split(" ")[0])]
                own += item["gate_equivalents"]["central"] * operator_of[3] / operator_of[1]
        failed |= row(name, gates, values + [own], path, f"  {registers} flip-flops, {memory} bits in the queue")
        for module, ge in modules.items():
            print(f"    {module[-60:]:60} {ge:9.0f} GE")
        for stages in filter(None, options.stages.split(",")):
            if int(stages) <= steps:
                _, _, netlist = yosys(read_unit(name, parameters | {"STAGES": stages}) + "opt_clean; write_json netlist.json")
                print(f"    {stages} registers deep: {flip_flops(netlist)[0]} flip-flops")
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
