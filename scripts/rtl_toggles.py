#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Energy of an action of the RTL's fp32 operators by toggle counts, beside the cost model's table.

    rtl_toggles.py [--units fp_add,fp_mul,...] [--count N] [GRTX]      default build/release/grtx

Each operator is synthesised as scripts/rtl_gates.py does and given N random pairs of numbers between 2^-10 and 2^10, one after
the other. Counted are toggles of the cells' input pins, a cell settling at once (no glitches). A pin is 1 fF at 1.1 V, as the model's central
values at 45 nm are.
"""
import argparse
import json
import os
import random
import re

import rtl_gates

PIN_PJ = 0.5 * 1.0e-15 * 1.1 ** 2 * 1e12


def cell_functions():
    """{cell of the library: {output pin: its function of the input pins, as Python over whole numbers}}."""
    with open(rtl_gates.LIBRARY, encoding="utf-8") as stream:
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


def toggles(netlist, operands):
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
            raise SystemExit("rtl_toggles.py: the netlist has a loop")
        todo = later
    changes = sum(bin((value[net] ^ value[net] >> 1) & ones >> 1).count("1") * count for net, count in pins.items())
    return changes / (len(operands) - 1)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("grtx", nargs="?", default=os.path.join(rtl_gates.TOP, "build/release/grtx"))
    parser.add_argument("--units", default=",".join(rtl_gates.OPERATORS))
    parser.add_argument("--count", type=int, default=1000)
    options = parser.parse_args()
    generator = random.Random(3)
    number = lambda: generator.getrandbits(1) << 31 | generator.randrange(117, 137) << 23 | generator.getrandbits(23)
    operands = [{"a": number(), "b": number()} for _ in range(options.count)]
    table = rtl_gates.coefficients(options.grtx, column=5)
    print(f"{'operator':15} {'pin toggles':>12} {'pJ':>6}   table: low / central / high, pJ at 45 nm")
    for name in options.units.split(","):
        count = toggles(rtl_gates.operator(name)[2], operands)
        low, central, high = table.get(name, (0, 0, 0))[:3]
        print(f"{name:15} {count:12.0f} {count * PIN_PJ:6.2f}   " + (f"{low:g} / {central:g} / {high:g}" if central else ""), flush=True)


if __name__ == "__main__":
    main()
