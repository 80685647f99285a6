#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How far can our ignorance move the answer? The four designs with every parameter that the paper leaves open (confidence
B or C in docs/model/configuration.md) halved and doubled, switches flipped and policies exchanged, one at a time: a plan of
`grtx sweep`, and the table of its database. With --pairs 8 the plan has the pairs of the eight strongest parameters of a
database, each at the value that moves most; with --strongest 4 these alone, say for another scene.

  scripts/sensitivity.py plan --scene F.ply --cameras C.json --size 48 --set gpu.sms=2 -o one.toml
  grtx sweep one.toml -o s.sqlite --machine paper
  scripts/sensitivity.py table s.sqlite
  scripts/sensitivity.py plan ... --pairs 8 --of s.sqlite -o pairs.toml       then sweep it into s.sqlite, and table again
"""
import argparse
import itertools
import json
import os
import sqlite3
import subprocess
import sys

DESIGNS = ("baseline", "sw", "hw", "grtx")
# Switches that take a part away are not ignorance about it; and parts that none of the designs has.
LEFT_OUT = ("rt.memory.by_shader", "rt.sphere.", "simt.registers", "simt.cost.sort_per_entry", "simt.cost.node_fetch")


def open_parameters(grtx):
    """(key, default, allowed values) of every parameter that the paper does not give."""
    text = subprocess.run([grtx, "sim", "--list-config"], check=True, capture_output=True, text=True).stdout
    for line in text.splitlines():
        cells = [cell.strip() for cell in line.strip().strip("|").split(" | ")]
        if line.startswith("| `") and len(cells) == 7 and cells[6] != "A":
            key = cells[0].strip("`")
            if not key.startswith(LEFT_OUT) and not key.endswith(".perfect"):
                yield key, cells[1], cells[2]


def alternatives(default, allowed):
    """Half and double of a number, within its range; the other values of a choice."""
    if " to " not in allowed:
        return [value.strip() for value in allowed.split(",") if value.strip() != default]
    low, high = (float(limit) for limit in allowed.split(" to "))
    values = [min(max(float(default) * factor, low), high) for factor in (0.5, 2.0)]
    texts = [repr(value) if "." in default else str(round(value)) for value in values]
    return [text for text in texts if float(text) != float(default)]


def toml(value):
    try:
        return str(float(value)) and value
    except ValueError:
        return value if value in ("true", "false") else json.dumps(value)


def write_plan(options):
    usual = dict(setting.split("=", 1) for setting in options.set)
    if options.pairs or options.strongest:
        ranked = strongest(read(options.of, options.mode))
        points = [a + b for a, b in itertools.combinations(ranked[:options.pairs], 2)] + ranked[:options.strongest]
    else:
        points = [((key, value),) for key, default, allowed in open_parameters(options.grtx)
                  if not options.only or key in options.only for value in alternatives(usual.get(key, default), allowed)]
    path = lambda name: json.dumps(os.path.abspath(name))
    lines = [f"designs = {json.dumps(DESIGNS)}", "", "[[scene]]", f"file = {path(options.scene)}",
             f"cameras = {path(options.cameras)}", f"view = {options.view}", f"width = {options.size}",
             f"height = {options.size}", f"fov_scale = {options.fov_scale}", "", "[set]"]
    lines += [f"{key} = {toml(value)}" for key, value in usual.items()]
    for point in [()] + points:
        lines += ["", "[[point]]"] + [f"{key} = {toml(value)}" for key, value in point]
    with open(options.output, "w", encoding="utf-8") as file:
        file.write("\n".join(lines) + "\n")
    print(f"{options.output}: {len(points) + 1} points of four designs")


def read(path, mode):
    """{((key, value), ...): {design: cycles}} of the points that are done in all designs; () is the default."""
    rows = sqlite3.connect(path).execute(
        "SELECT coordinates, design, value FROM point JOIN value ON value.point_id = point.id "
        "WHERE status = 'done' AND name = 'gpu.cycles' AND mode = ?", (mode,))
    found = {}
    for coordinates, design, cycles in rows:
        at = tuple((k, v if isinstance(v, str) else json.dumps(v)) for k, v in json.loads(coordinates).items())
        found.setdefault(at, {})[design] = cycles
    found = {at: cycles for at, cycles in found.items() if len(cycles) == len(DESIGNS)}
    if () not in found:
        sys.exit(f"sensitivity: {path}: has no default of all four designs in mode {mode}")
    return found


def speedups(cycles):
    return {design: cycles["baseline"] / cycles[design] for design in DESIGNS[1:]}


def strongest(found):
    """Single points, of each parameter the one that moves the speed-up of grtx most, in that order."""
    usual = speedups(found[()])["grtx"]
    best = {}
    for at, cycles in found.items():
        if len(at) == 1:
            moved = abs(speedups(cycles)["grtx"] / usual - 1)
            best[at[0][0]] = max(best.get(at[0][0], (0, at)), (moved, at))
    return [at for _, at in sorted(best.values(), key=lambda one: -one[0])]


def print_table(options):
    found = read(options.database, options.mode)
    default, usual = found[()], speedups(found[()])
    name = lambda at: ", ".join(f"`{key}={value}`" for key, value in at) or "default"
    print("| parameter | " + " | ".join(DESIGNS[1:]) + " | cycles of " + ", ".join(DESIGNS) + " |\n|---|---|---|---|---|")
    order = [key for ((key, _),) in strongest(found)]
    rank = lambda at: (len(at), [order.index(key) for key, _ in at], at)
    for at in sorted((at for at in found if len(at) < 2), key=rank)[:options.most]:
        moved = ", ".join(f"{100 * (found[at][d] / default[d] - 1):+.1f} %" for d in DESIGNS) if at else \
            ", ".join(f"{default[d]:.0f}" for d in DESIGNS)
        print(f"| {name(at)} | " + " | ".join(f"{x:.2f}" for x in speedups(found[at]).values()) + f" | {moved} |")
    pairs = [at for at in found if len(at) == 2 and all((one,) in found for one in at)]
    if pairs:
        print("\n| pair | " + " | ".join(f"{d}, alone × alone, together" for d in usual) + " |\n|---|---|---|---|")
    for at in sorted(pairs, key=rank):
        alone = [speedups(found[(one,)]) for one in at]
        both = speedups(found[at])
        print(f"| {name(at)} | " + " | ".join(f"{alone[0][d] * alone[1][d] / usual[d]:.2f}, {both[d]:.2f}" for d in usual) + " |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(required=True)
    plan = commands.add_parser("plan", help="writes a plan of grtx sweep")
    plan.add_argument("--grtx", default="build/release/grtx", help="the program (default: %(default)s)")
    plan.add_argument("--scene", required=True)
    plan.add_argument("--cameras", required=True)
    plan.add_argument("--view", type=int, default=0)
    plan.add_argument("--size", type=int, default=48, help="width and height, pixels (default: %(default)s)")
    plan.add_argument("--fov-scale", type=float, default=1.0, help="as in grtx trace (default: %(default)s)")
    plan.add_argument("--only", action="append", default=[], metavar="KEY", help="these parameters (default: all)")
    plan.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="for all points, as in grtx sim")
    plan.add_argument("--pairs", type=int, default=0, metavar="N", help="pairs of the N strongest of a database")
    plan.add_argument("--strongest", type=int, default=0, metavar="N", help="the N strongest of a database")
    plan.add_argument("--of", metavar="DB", help="that database")
    plan.add_argument("--mode", default="cycle", help="mode of its points (default: %(default)s)")
    plan.add_argument("-o", "--output", required=True)
    plan.set_defaults(run=write_plan)
    table = commands.add_parser("table", help="prints what a database of the plan says")
    table.add_argument("database")
    table.add_argument("--mode", default="cycle", help="of its points (default: %(default)s)")
    table.add_argument("--most", type=int, default=40, help="rows (default: %(default)s)")
    table.set_defaults(run=print_table)
    options = parser.parse_args()
    if (getattr(options, "pairs", 0) or getattr(options, "strongest", 0)) and not options.of:
        parser.error("--pairs and --strongest need --of")
    options.run(options)


if __name__ == "__main__":
    main()
