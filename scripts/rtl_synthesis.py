#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Storage and gates of the checkpoint unit's RTL (rtl_tlm/rtl/checkpoint_unit.sv) beside the cost model's.

    rtl_synthesis.py [--storage] [--lanes 1,4,8,32] [--machine M] [--set KEY=VALUE ...] [--sized] [GRTX]      default build/release/grtx

Yosys 0.23 reads the RTL with the straps tied to the configuration. Storage: its memories must have the bits that the inventory names
(queues, sector buffers, the paper's 1,074 B), its other flip-flops too (control, and what is there for the clock). Gates: what is left
beside memories, mapped to the OSU 180 nm library (apt-get install yosys qflow-tech-osu018), in gate equivalents (area over that
of the library's NAND2X1). --storage: without the gates, in seconds. --sized: as of rtl_gates.py. --set: keys of rt.checkpoint and rt.warp_buffer.entries.
Exit code 1: the storage is not the inventory's.
"""
import argparse
import json
import os
import re
import subprocess
import sys
import tempfile

import rtl_gates

TOP, LIBRARY = rtl_gates.TOP, rtl_gates.LIBRARY
# What the model's item is called in the RTL.
MEMORIES = {"write_queue": ["write_address", "write_mask", "write_data"], "submitted": ["submitted"], "reads": ["reads"],
            "open_sectors": ["open_sectors"], "read_sectors": ["read_sectors"], "replay_flag": ["replay_flag"],
            "source_offset": ["source_offset"], "destination_offset": ["destination_offset"]}
REGISTERS = {"source_base": 64, "destination_base": 64, "maximum_size": 16}  # of the paper's table
# What the RTL has beside the inventory: the number of the sector that the read in front asks for next, and whether
# no other follows, known an edge ahead for the sake of the clock (docs/results/rtl.md).
AHEAD = 43 + 1


def node_of(tree, name):
    if tree.get("name") == name:
        return tree
    for child in tree.get("children", []):
        found = node_of(child, name)
        if found:
            return found
    return None


def model(grtx, settings, machine="paper"):
    """The configuration, the inventory's bits by item, and gate equivalents of the unit's operators."""
    command = [grtx, "cost", "--json", "--items", "--quiet", "--machine", machine] + [a for s in settings for a in ("--set", s)]
    document = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    unit, buffer = node_of(document["tree"], "checkpoint_unit"), node_of(document["tree"], "warp_buffer")
    bits = {item["name"]: item["bits"] for item in unit["items"] if item.get("bits")}
    bits.update({item["name"]: item["bits"] for item in buffer["items"] if item.get("added_by_grtx")})
    gates = {}
    for item in unit["items"]:
        if not item.get("bits"):
            gates[item["name"]] = gates.get(item["name"], 0) + item["gate_equivalents"]["central"]
    return document["config"], bits, gates


def yosys(config, gates):
    """Memories of the RTL by name: bits, words, read and write ports; other flip-flop bits; area of the rest and its longest path."""
    lanes, places = config["rt.checkpoint.lanes"], config["rt.checkpoint.write_queue"]
    rays = 32 * config["rt.warp_buffer.entries"]
    straps = {"cfg_lanes": (7, lanes), "cfg_write_queue": (places.bit_length(), places),
              "cfg_write_combine": (1, int(config["rt.checkpoint.write_combine"])),
              "cfg_read_buffer": (1, int(config["rt.checkpoint.read_buffer"])),
              "cfg_entry_bytes": (5, config["rt.checkpoint.entry_bytes"])}
    unit, chparam = "checkpoint_unit", f"-chparam LANES {lanes} -chparam WRITE_QUEUE {places} -chparam RAYS {rays}"
    with tempfile.TemporaryDirectory() as folder:
        netlist, stat, log = (os.path.join(folder, name) for name in ("netlist.json", "stat", "log"))
        script = (f"read_verilog -sv -Irtl_tlm/rtl rtl_tlm/rtl/{unit}.sv; hierarchy -top {unit} {chparam}; "
                  f"rename -top top; proc; flatten; delete -input {' '.join('w:' + s for s in straps)}; cd top; "
                  + "".join(f"connect -set {name} {bits}'d{value}; " for name, (bits, value) in straps.items())
                  + f"cd ..; opt -full; opt_clean -purge; memory_collect; opt_clean; write_json {netlist}; ")
        if gates:
            script += (f"wreduce; peepopt; opt_clean; alumacc; opt; techmap; opt -fast; dfflibmap -liberty {LIBRARY}; "
                       f"tee -q -o {log} abc -liberty {LIBRARY} -script {rtl_gates.ABC}; opt_clean; "
                       f"tee -q -o {stat} stat -liberty {LIBRARY}; ")
        run = subprocess.run(["yosys", "-q", "-p", script], cwd=TOP, capture_output=True, text=True)
        if run.returncode != 0:
            sys.exit(f"rtl_synthesis.py: yosys: {run.stderr.strip() or run.stdout[-500:]}")
        memories, flip_flops = {}, 0
        with open(netlist, encoding="utf-8") as stream:
            cells = json.load(stream)["modules"]["top"]["cells"].values()
        for cell in cells:
            of = cell["parameters"]
            if cell["type"].startswith("$mem"):
                size, width, reads, writes = (int(of[k], 2) for k in ("SIZE", "WIDTH", "RD_PORTS", "WR_PORTS"))
                memories[of["MEMID"].lstrip("\\")] = (size * width, size, reads, writes)
            elif "dff" in cell["type"]:
                flip_flops += int(of["WIDTH"], 2)
        area = path = None
        if gates:
            with open(stat, encoding="utf-8") as stream:
                area = float(re.search(r"Chip area.*: +([\d.]+)", stream.read()).group(1))
            with open(log, encoding="utf-8") as stream:
                path = rtl_gates.longest_path(stream.read())
        return memories, flip_flops, area and (area, path)


def check_storage(config, bits, memories, flip_flops):
    """Lines that say what differs."""
    faults = []
    expected = {}
    control = bits["control"] + AHEAD
    for item, amount in bits.items():
        if item in REGISTERS or item == "control":  # flip-flops
            continue
        parts = MEMORIES.get(item)
        if parts is None:
            faults.append(f"{item}: the RTL has no such memory")
            continue
        expected.update(dict.fromkeys(parts))
        have = sum(memories.get(part, (0,))[0] for part in parts)
        if have != amount:
            faults.append(f"{item}: {have} bits in the RTL, {amount} in the inventory")
    faults += [f"{name}: {memories[name][0]} bits in the RTL, none in the inventory" for name in memories if name not in expected]
    paper = sum(bits[name] for name in REGISTERS)
    if flip_flops != paper + control:
        faults.append(f"flip-flops: {flip_flops} in the RTL, {paper} + {control} expected")
    return faults


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("grtx", nargs="?", default=os.path.join(TOP, "build/release/grtx"))
    parser.add_argument("--storage", action="store_true")
    parser.add_argument("--lanes", default="1,4,8,32")
    parser.add_argument("--machine", default="paper")
    parser.add_argument("--set", action="append", default=[], dest="settings")
    parser.add_argument("--sized", action="store_true")
    options = parser.parse_args()
    if options.sized:
        rtl_gates.ABC = rtl_gates.ABC_SIZED
    if not options.storage and not os.path.exists(LIBRARY):
        sys.exit(f"rtl_synthesis.py: {LIBRARY} is missing (apt-get install qflow-tech-osu018), or give --storage")
    failed = False
    flip_flop = rtl_gates.coefficients(options.grtx)["flip-flop bit"][1]
    for lanes in options.lanes.split(","):
        config, bits, operators = model(options.grtx, options.settings + [f"rt.checkpoint.lanes={lanes}"], options.machine)
        memories, flip_flops, area = yosys(config, not options.storage)
        faults = check_storage(config, bits, memories, flip_flops)
        failed |= bool(faults)
        for fault in faults:
            print(f"lanes {lanes}: {fault}")
        total = sum(memory[0] for memory in memories.values())
        paper = sum(amount for name, amount in bits.items() if name in REGISTERS or name.endswith(("_offset", "_flag")))
        print(f"lanes {lanes}: {total} bits in memories, {flip_flops} flip-flops; inventory {sum(bits.values())} bits, of which the "
              f"paper's {paper // 8} B; control {flip_flops - sum(REGISTERS.values())}")
        print("  ports (read, write): " + ", ".join(f"{name} {m[2]}, {m[3]}" for name, m in sorted(memories.items())))
        if area is not None:
            counted = flip_flops - AHEAD
            print(f"  gates: {area[0] / rtl_gates.nand_area():.0f} GE in the RTL, longest path {area[1]:.1f} ns; {sum(operators.values()):.0f} GE of operators in the model, "
                  f"{sum(operators.values()) + counted * flip_flop:.0f} with its flip-flops "
                  f"({', '.join(f'{name} {ge:.0f}' for name, ge in operators.items())})", flush=True)
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
