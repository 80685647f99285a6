#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Synthesis of rtl_tlm/rtl beside the cost model (docs/results/rtl.md); GRTX is build/release/grtx unless given.

    rtl.py checkpoint [--storage] [--lanes 1,4,8,32] [--machine M] [--set KEY=VALUE ...] [--sized] [GRTX]
        The checkpoint unit with its straps tied to the configuration. Its memories must have the bits that the inventory names
        (queues, sector buffers, the paper's 1,074 B), its flip-flops too: else exit code 1. Then its gates; --storage: without.
    rtl.py gates [--units fp_add,...,ray_box,ray_transform] [--set KEY=VALUE ...] [--stages N,N,...] [--sized] [GRTX]
        fp32 operators and intersection units. --stages: flip-flops of pipelines of other depths. Exit code 1: a unit is off by more
        than 20 % from the model's central value.
    rtl.py depth [--units fp_add,...] [--depths 1,2,3,...]
        Longest path of a step with N - 1 registers behind it, which synthesis moves into it: between those before and behind lie N
        pieces. MHz at 45 nm, and at 12 nm with the two ends of the node table of docs/model/cost.md.
    rtl.py toggles [--units fp_add,...] [--count N] [GRTX]
        Energy of an operator by the toggles of its cells' input pins, no glitches, over N random pairs of 2^-10 to 2^10.
    rtl.py clock [--units fp_add,...] [--depth N]
        The clock at which an operator closes between registers on an iCE40 HX8K (40 nm), placed and routed, seed 1.

Yosys 0.23 maps to the OSU 180 nm library (apt-get install yosys qflow-tech-osu018 nextpnr-ice40). Gate equivalents are area over
that of its NAND2X1. Paths are abc's, without wires and without sizing of cells; --sized: mapped for speed, with buffers and
cells that drive their loads; the path is that of a clock, the gates are more.
"""
import argparse
import json
import os
import random
import re
import subprocess
import sys
import tempfile

TOP = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
LIBRARY = os.environ.get("OSU018", "/usr/share/qflow/tech/osu018/osu018_stdcells.lib")
# As yosys runs it for a library, then the longest path; with buffers behind whatever drives many, and cells that drive their load.
ABC = {False: "+strash;ifraig;scorr;dc2;dretime;strash;&get,-n;&nf;&put;topo;stime,-p",
       True: "+strash;ifraig;scorr;dch,-f;map,-B,0.9;buffer,-c,-N,8;topo;upsize;dnsize;stime,-p"}
WORDS = {"fp_add": "fp_add(a, b)", "fp_mul": "fp_mul(a, b)", "fp_compare": "fp_less(a, b) ? a : b", "fp_scale": "fp_mul(a, 32'h3f800003)",
         "fp_reciprocal": "fp_reciprocal(a, fp_divide(a, fp_divide_begin(a)))", "exchange": "a > b ? {a, b} : {b, a}"}
# The longest step of each kind; a third of a division with its rounding is the longest of the transform.
STEPS = {**WORDS, "fp_divide_begin": "fp_divide_begin(a)", "fp_divide": "fp_divide(a, {a[16:0], b})", "fp_reciprocal": "fp_reciprocal(a, {a[16:0], b})"}
UNITS = {"ray_box": ("rt.box", 12, ["ray_box_child", "ray_box_pipeline"]), "ray_transform": ("rt.transform", 6, ["ray_transform_pipeline"])}
TO_45 = 3.37 / 19.21  # the model's adder at 45 nm over this one at 180 nm
REGISTER = 0.10       # ns at 45 nm
TO_12 = (0.34, 0.82)
PIN_PJ = 0.5 * 1.0e-15 * 1.1 ** 2 * 1e12  # 1 fF at 1.1 V, as the model's central values at 45 nm are
# What the inventory's item is called in the RTL.
MEMORIES = {"write_queue": ["write_address", "write_mask", "write_data"],
            **{name: [name] for name in ("submitted", "reads", "open_sectors", "read_sectors", "replay_flag", "source_offset", "destination_offset")}}
REGISTERS = {"source_base": 64, "destination_base": 64, "maximum_size": 16}  # of the paper's table
# What the RTL has beside the inventory: the number of the sector that the read in front asks for next, and whether
# no other follows, known an edge ahead for the sake of the clock (docs/results/rtl.md).
AHEAD = 43 + 1


def node_of(tree, name):
    if tree.get("name") == name:
        return tree
    return next(filter(None, (node_of(child, name) for child in tree.get("children", []))), None)


def cost(grtx, settings, machine="paper"):
    command = [grtx, "cost", "--json", "--items", "--quiet", "--machine", machine] + [a for s in settings for a in ("--set", s)]
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def coefficients(grtx, column=3):
    """{operator: (low, central and high of that column of the table (3: GE), its synthesised GE, or central where there is none)}."""
    text = subprocess.run([grtx, "cost", "--coefficients"], check=True, capture_output=True, text=True).stdout
    known = {}
    for line in text.splitlines():
        cells = [cell.strip() for cell in line.split("|")]
        if len(cells) > 6 and re.match(r"[\d.]+ / ", cells[column]) and not re.match(r"\d", cells[1]):
            low, central, high = (float(part) for part in cells[column].split("/"))
            known[cells[1]] = (low, central, high, float(cells[4]) if re.match(r"[\d.]+$", cells[4]) else central)
    return known


def yosys(script, text="", abc=ABC[False], then=()):
    """Runs a script, with `text` as file operator.sv, and a program with the netlist; gives what the files abc.log, stat and
    netlist.json hold, and what the program said."""
    with tempfile.TemporaryDirectory() as folder:
        with open(os.path.join(folder, "operator.sv"), "w", encoding="utf-8") as stream:
            stream.write(text)
        script = script.replace("ABC", f"tee -q -o abc.log abc -liberty {LIBRARY} -script {abc}").replace("RTL", f"{TOP}/rtl_tlm/rtl")
        said = ""
        for command in filter(None, (["yosys", "-q", "-p", script.replace("STAT", f"tee -q -o stat stat -liberty {LIBRARY}")], list(then))):
            run = subprocess.run(command, cwd=folder, capture_output=True, text=True)
            if run.returncode != 0:
                sys.exit(f"rtl.py: {command[0]}: {run.stderr.strip() or run.stdout[-500:]}")
            said = run.stderr

        def read(name):
            path = os.path.join(folder, name)
            return open(path, encoding="utf-8").read() if os.path.exists(path) else ""
        return read("abc.log"), read("stat"), read("netlist.json"), said


def nand_area():
    with open(LIBRARY, encoding="utf-8") as stream:
        return float(re.search(r"cell *\(NAND2X1\).*?area *: *([\d.]+)", stream.read(), re.S).group(1))


def chip_gates(stat, of=r".*"):
    return float(re.search(rf"Chip area{of}: +([\d.]+)", stat).group(1)) / nand_area()


def longest_path(log):
    """ns, the longest of all modules that abc mapped."""
    return max((float(ps) / 1e3 for ps in re.findall(r"Delay *= *([\d.]+) *ps", log)), default=0.0)


def operator(name, abc=ABC[False]):
    """Gate equivalents, longest path in ns and netlist of an operator by itself."""
    bits = 35 if name == "exchange" else 31
    text = (f"module operator(input logic [{bits}:0] a, input logic [{bits}:0] b, output logic [{2 * bits + 1 if bits > 31 else 31}:0] y);\n"
            f"`include \"fp32.svh\"\nassign y = {WORDS[name]};\nendmodule\n")
    log, stat, netlist, _ = yosys("read_verilog -sv -IRTL operator.sv; hierarchy -top operator; proc; opt -full; wreduce; alumacc; opt; "
                                  "techmap; opt -fast; ABC; opt_clean; write_json netlist.json; STAT", text, abc)
    return chip_gates(stat), longest_path(log), netlist


def cells_of(netlist, name=None):
    """All cells below a module, by default the top one."""
    modules = json.loads(netlist)["modules"]
    top = name or next(n for n, module in modules.items() if int(module["attributes"].get("top", "0"), 2))
    todo = list(modules[top]["cells"].values())
    while todo:
        cell = todo.pop()
        if cell["type"] in modules:
            todo += modules[cell["type"]]["cells"].values()
        else:
            yield cell


def storage(netlist):
    """Memories by name: bits, words, read and write ports; and bits of other flip-flops."""
    memories, flip_flops = {}, 0
    for cell in cells_of(netlist):
        of = cell["parameters"]
        if cell["type"].startswith("$mem"):
            size, width, reads, writes = (int(of[k], 2) for k in ("SIZE", "WIDTH", "RD_PORTS", "WR_PORTS"))
            name = of["MEMID"].lstrip("\\")
            memories[name] = (size * width + memories.get(name, (0,))[0], size, reads, writes)
        elif "dff" in cell["type"]:
            flip_flops += int(of["WIDTH"], 2)
    return memories, flip_flops


def model(grtx, settings, machine="paper"):
    """The configuration, the inventory's bits by item, and gate equivalents of the checkpoint unit's operators."""
    document = cost(grtx, settings, machine)
    unit, buffer = node_of(document["tree"], "checkpoint_unit"), node_of(document["tree"], "warp_buffer")
    bits = {item["name"]: item["bits"] for item in unit["items"] if item.get("bits")}
    bits.update({item["name"]: item["bits"] for item in buffer["items"] if item.get("added_by_grtx")})
    gates = {}
    for item in unit["items"]:
        if not item.get("bits"):
            gates[item["name"]] = gates.get(item["name"], 0) + item["gate_equivalents"]["central"]
    return document["config"], bits, gates


def checkpoint_unit(config, gates, abc=ABC[False]):
    """Memories and flip-flops of the RTL; gate equivalents of the rest and its longest path."""
    lanes, places = config["rt.checkpoint.lanes"], config["rt.checkpoint.write_queue"]
    straps = {"cfg_lanes": (7, lanes), "cfg_write_queue": (places.bit_length(), places),
              "cfg_write_combine": (1, int(config["rt.checkpoint.write_combine"])),
              "cfg_read_buffer": (1, int(config["rt.checkpoint.read_buffer"])), "cfg_entry_bytes": (5, config["rt.checkpoint.entry_bytes"])}
    script = (f"read_verilog -sv -IRTL RTL/checkpoint_unit.sv; hierarchy -top checkpoint_unit -chparam LANES {lanes} "
              f"-chparam WRITE_QUEUE {places} -chparam RAYS {32 * config['rt.warp_buffer.entries']}; "
              f"rename -top top; proc; flatten; delete -input {' '.join('w:' + s for s in straps)}; cd top; "
              + "".join(f"connect -set {name} {bits}'d{value}; " for name, (bits, value) in straps.items())
              + "cd ..; opt -full; opt_clean -purge; memory_collect; opt_clean; write_json netlist.json; ")
    if gates:
        script += "wreduce; peepopt; opt_clean; alumacc; opt; techmap; opt -fast; dfflibmap -liberty " + LIBRARY + "; ABC; opt_clean; STAT"
    log, stat, netlist, _ = yosys(script, abc=abc)
    return *storage(netlist), (chip_gates(stat), longest_path(log)) if gates else None


def check_storage(bits, memories, flip_flops):
    """Lines that say what differs."""
    faults, expected = [], set()
    for item, amount in bits.items():
        if item in REGISTERS or item == "control":  # flip-flops
            continue
        parts = MEMORIES.get(item)
        if parts is None:
            faults.append(f"{item}: the RTL has no such memory")
            continue
        expected.update(parts)
        have = sum(memories.get(part, (0,))[0] for part in parts)
        if have != amount:
            faults.append(f"{item}: {have} bits in the RTL, {amount} in the inventory")
    faults += [f"{name}: {memories[name][0]} bits in the RTL, none in the inventory" for name in memories if name not in expected]
    paper, control = sum(bits[name] for name in REGISTERS), bits["control"] + AHEAD
    if flip_flops != paper + control:
        faults.append(f"flip-flops: {flip_flops} in the RTL, {paper} + {control} expected")
    return faults


def checkpoint(options):
    failed = False
    flip_flop = coefficients(options.grtx)["flip-flop bit"][1]
    for lanes in options.lanes.split(","):
        config, bits, operators = model(options.grtx, options.settings + [f"rt.checkpoint.lanes={lanes}"], options.machine)
        memories, flip_flops, area = checkpoint_unit(config, not options.storage, ABC[options.sized])
        for fault in check_storage(bits, memories, flip_flops):
            failed = True
            print(f"lanes {lanes}: {fault}")
        paper = sum(amount for name, amount in bits.items() if name in REGISTERS or name.endswith(("_offset", "_flag")))
        print(f"lanes {lanes}: {sum(m[0] for m in memories.values())} bits in memories, {flip_flops} flip-flops; inventory {sum(bits.values())} "
              f"bits, of which the paper's {paper // 8} B; control {flip_flops - sum(REGISTERS.values())}")
        print("  ports (read, write): " + ", ".join(f"{name} {m[2]}, {m[3]}" for name, m in sorted(memories.items())))
        if area:
            total = sum(operators.values())
            print(f"  gates: {area[0]:.0f} GE in the RTL, longest path {area[1]:.1f} ns; {total:.0f} GE of operators in the model, "
                  f"{total + (flip_flops - AHEAD) * flip_flop:.0f} with its flip-flops "
                  f"({', '.join(f'{name} {ge:.0f}' for name, ge in operators.items())})", flush=True)
    return failed


def read_unit(unit, parameters):
    """Yosys commands up to a netlist of registers and words; pipelines and children stay modules of their own."""
    keep = "".join(f"setattr -mod -set keep_hierarchy 1 *{module}*; " for module in UNITS[unit][2])
    chparam = "".join(f" -chparam {name} {value}" for name, value in parameters.items())
    return (f"read_verilog -sv -IRTL RTL/intersection_queue.sv RTL/{unit}_unit.sv; hierarchy -top {unit}_unit{chparam}; proc; {keep}flatten; "
            "memory_collect; delete -input */w:fault; setundef -undriven -zero; opt -full; opt_clean -purge; opt_clean; write_json netlist.json; ")


def gates(options):
    known, failed = coefficients(options.grtx), False
    print(f"{'unit':15} {'GE (RTL)':>9} {'synthesised':>12} {'ratio':>6} {'central':>9} {'ratio':>6} {'low to high':>17} {'path, ns':>9}")

    def row(name, ge, values, path, note=""):
        low, central, high, own = values
        print(f"{name:15} {ge:9.0f} {own:12.0f} {ge / own:6.2f} {central:9.0f} {ge / central:6.2f} {low:8.0f} to {high:<6.0f} "
              f"{path:8.2f}{note}", flush=True)
        return not 0.8 <= ge / central <= 1.2

    for name in options.units.split(","):
        if name in WORDS:
            ge, path, _ = operator(name, ABC[options.sized])
            row(name, ge, known[name], path) if name in known else print(f"{name:15} {ge:9.0f} {path:66.2f}", flush=True)
            continue
        document, (key, steps, _) = cost(options.grtx, options.settings), UNITS[name]
        config = document["config"]
        parameters = {"COUNT": config[f"{key}.count"], "STAGES": min(config[f"{key}.latency"], steps), "RAYS": 32 * config["rt.warp_buffer.entries"]}
        log, stat, netlist, _ = yosys(read_unit(name, parameters) + f"alumacc; opt; techmap; opt -fast; dfflibmap -liberty {LIBRARY}; ABC; "
                                      "opt_clean; STAT", abc=ABC[options.sized])
        memories, registers = storage(netlist)
        items = [item for item in node_of(document["tree"], name)["items"] if item["name"] != "queue"]
        values = [sum(item["gate_equivalents"][band] for item in items) for band in ("low", "central", "high")]
        own = 0.0
        for item in items:
            if item.get("bits"):
                own += item["bits"] * known["flip-flop bit"][3]
            else:
                operator_of = known[re.sub(r"\d+$", "", item["name"].split(" ")[0])]
                own += item["gate_equivalents"]["central"] * operator_of[3] / operator_of[1]
        failed |= row(name, chip_gates(stat, " for top module .*"), values + [own], longest_path(log),
                      f"  {registers} flip-flops, {sum(m[0] for m in memories.values())} bits in the queue")
        for module, area in re.findall(r"Chip area for module '\\?(.*?)': +([\d.]+)", stat):
            print(f"    {module[-60:]:60} {float(area) / nand_area():9.0f} GE")
        for stages in filter(None, options.stages.split(",")):
            if int(stages) <= steps:
                print(f"    {stages} registers deep: {storage(yosys(read_unit(name, parameters | {'STAGES': stages}))[2])[1]} flip-flops")
    return failed


def depth(options):
    print(f"{'step':14} {'depth':>5} {'180 nm, ns':>10} {'flip-flops':>10} {'45 nm':>9}   12 nm, MHz")
    for name in options.units.split(","):
        width = 36 if name == "exchange" else 32
        for pieces in (int(d) for d in options.depths.split(",")):
            text = (f"module operator(input logic clk, input logic [{width - 1}:0] a, input logic [{width - 1}:0] b, output logic [71:0] y);\n"
                    f"`include \"fp32.svh\"\n  logic [71:0] p0;\n  always_comb p0 = {STEPS[name]};\n"
                    + "".join(f"  logic [71:0] p{i};\n  always_ff @(posedge clk) p{i} <= p{i - 1};\n" for i in range(1, pieces))
                    + f"  assign y = p{pieces - 1};\nendmodule\n")
            abc = f"+strash;ifraig;scorr;dc2;{'retime,-M,5;strash;' if pieces > 1 else ''}&get,-n;&nf;&put;topo;stime,-p"
            log, _, netlist, _ = yosys("read_verilog -sv -IRTL operator.sv; hierarchy -top operator; proc; flatten; opt -nodffe -nosdff -full; "
                                       "wreduce; alumacc; opt -nodffe -nosdff; techmap; opt -nodffe -nosdff -fast; dfflegalize -cell $_DFF_P_ x; "
                                       "opt_clean; ABC; opt_clean; write_json netlist.json", text, f"{abc}{' -dff' if pieces > 1 else ''}")
            ns = longest_path(log)
            period = ns * TO_45 + REGISTER
            registers = sum("DFF" in cell["type"] for cell in cells_of(netlist))
            print(f"{name:14} {pieces:5} {ns:10.2f} {registers:10} {1e3 / period:5.0f} MHz   "
                  f"{1e3 / (period * TO_12[1]):.0f} to {1e3 / (period * TO_12[0]):.0f}", flush=True)


def cell_functions():
    """{cell of the library: {output pin: its function of the input pins, as Python over whole numbers}}."""
    with open(LIBRARY, encoding="utf-8") as stream:
        text = stream.read()
    cells = {}
    for cell in re.split(r"\n\s*cell *\(", text)[1:]:
        outputs = {}
        for pin in re.split(r"\n\s*pin *\(", cell)[1:]:
            if function := re.search(r'function *: *"([^"]*)"', pin):
                python = re.sub(r"\b(\w+)\b", r"pin['\1']", function.group(1))
                python = re.sub(r"(\)|\])\s+(?=\(|pin|!)", r"\1 & ", python).replace("+", "|").replace("!", "ones ^ ")
                outputs[re.match(r"\"?(\w+)", pin).group(1)] = compile(python, cell[:12], "eval")
        cells[re.match(r"\"?(\w+)", cell).group(1)] = outputs
    return cells


def count_toggles(netlist, operands):
    """Toggles of input pins per operation, mean. Bit k of a number is what a net is for operand k."""
    top = next(iter(json.loads(netlist)["modules"].values()))
    functions = cell_functions()
    ones = (1 << len(operands)) - 1
    value = {"0": 0, "1": ones, "x": 0}
    for port in ("a", "b"):
        for place, net in enumerate(top["ports"].get(port, {"bits": []})["bits"]):
            value[net] = sum((operand[port] >> place & 1) << k for k, operand in enumerate(operands))
    pins, todo = {}, list(top["cells"].values())
    for cell in todo:
        for pin, (net,) in cell["connections"].items():
            if pin not in functions[cell["type"]]:
                pins[net] = pins.get(net, 0) + 1
    while todo:
        later = []
        for cell in todo:
            outputs = functions[cell["type"]]
            inputs = {pin: net for pin, (net,) in cell["connections"].items() if pin not in outputs}
            if not all(net in value for net in inputs.values()):
                later.append(cell)
                continue
            known = {pin: value[net] for pin, net in inputs.items()}
            for pin, function in outputs.items():
                value[cell["connections"][pin][0]] = eval(function, {"pin": known, "ones": ones}) & ones
        if len(later) == len(todo):
            sys.exit("rtl.py: the netlist has a loop")
        todo = later
    changes = sum(bin((value[net] ^ value[net] >> 1) & ones >> 1).count("1") * count for net, count in pins.items())
    return changes / (len(operands) - 1)


def toggles(options):
    generator = random.Random(3)

    def number():
        return generator.getrandbits(1) << 31 | generator.randrange(117, 137) << 23 | generator.getrandbits(23)

    operands = [{"a": number(), "b": number()} for _ in range(options.count)]
    table = coefficients(options.grtx, column=5)
    print(f"{'operator':15} {'pin toggles':>12} {'pJ':>6}   table: low / central / high, pJ at 45 nm")
    for name in options.units.split(","):
        count = count_toggles(operator(name)[2], operands)
        low, central, high = table.get(name, (0, 0, 0))[:3]
        print(f"{name:15} {count:12.0f} {count * PIN_PJ:6.2f}   " + (f"{low:g} / {central:g} / {high:g}" if central else ""), flush=True)


def clock(options):
    synthesis = "synth_ice40 -top top"
    if options.depth > 1:  # without carry chains, which registers cannot be moved across
        synthesis = ("synth_ice40 -nocarry -top top -run begin:map_ffs; dfflegalize -cell $_DFF_P_ x; abc -dff -g AND,XOR,MUX -script "
                     "+strash;ifraig;scorr;dc2;retime,-M,5;strash;map; opt_clean; synth_ice40 -nocarry -run map_ffs:")
    for name in options.units.split(","):
        text = ("module top(input logic clk, input logic in, output logic out);\n`include \"fp32.svh\"\n  logic [31:0] a, b;\n"
                f"  logic [48:0] {', '.join(f'y{i}' for i in range(1, options.depth + 1))};\n  always_ff @(posedge clk) begin\n"
                f"    {{a, b}} <= {{a[30:0], b, in}};\n    y1 <= {STEPS[name]};\n"
                + "".join(f"    y{i} <= y{i - 1};\n" for i in range(2, options.depth + 1)) + f"    out <= ^y{options.depth};\n  end\nendmodule\n")
        said = yosys(f"read_verilog -sv -IRTL operator.sv; {synthesis}; write_json netlist.json", text,
                     then=["nextpnr-ice40", "--hx8k", "--package", "ct256", "--seed", "1", "--json", "netlist.json"])[3]
        cells, mhz = re.findall(r"ICESTORM_LC: +(\d+)", said)[-1], re.findall(r"Max frequency for clock[^:]*: ([\d.]+)", said)[-1]
        print(f"{name:10} depth {options.depth} {cells:>6} logic cells {mhz:>8} MHz", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    def command(work, units="", program=False, **values):
        found = commands.add_parser(work.__name__)
        found.set_defaults(work=work, storage=False)
        if units:
            found.add_argument("--units", default=",".join(units))
        for name, default in values.items():
            found.add_argument("--" + name, default=default, type=type(default))
        if program:
            found.add_argument("grtx", nargs="?", default=os.path.join(TOP, "build/release/grtx"))
        return found

    for found in (command(checkpoint, program=True, lanes="1,4,8,32", machine="paper"), command(gates, [*WORDS, *UNITS], program=True, stages="")):
        found.add_argument("--set", action="append", default=[], dest="settings")
        found.add_argument("--sized", action="store_true")
        if found.get_default("work") is checkpoint:
            found.add_argument("--storage", action="store_true")
    command(depth, STEPS, depths="1,2,3,4,5,6,8,10")
    command(toggles, WORDS, program=True, count=1000)
    command(clock, ["fp_add", "fp_mul", "fp_compare", "fp_scale", "fp_divide"], depth=1)
    options = parser.parse_args()
    if options.work is not clock and not options.storage and not os.path.exists(LIBRARY):
        sys.exit(f"rtl.py: {LIBRARY} is missing (apt-get install qflow-tech-osu018)")
    sys.exit(1 if options.work(options) else 0)


if __name__ == "__main__":
    main()
