#!/usr/bin/env python3
"""How far can our ignorance move the answer? Simulates the four designs with every parameter that the paper leaves
open (confidence B or C in docs/model/configuration.md) halved and doubled, switches flipped and policies exchanged, one at a
time, and records cycles and the speed-ups over the baseline. With --pairs 8 also the pairs of the eight strongest
parameters, each at the value that moves most; with --confirm 4 the four strongest again in cycle mode.

  scripts/sensitivity.py --scene F.ply --cameras C.json [--view 0] [--size 48] [--machine paper] [--set gpu.sms=2 ...] -o FOLDER

Writes FOLDER/sensitivity.csv (one row a parameter value and design; a run that is interrupted goes on where it was),
FOLDER/sensitivity.svg (the tornado) and FOLDER/sensitivity_table.md. Python's standard library only.
"""

import argparse
import concurrent.futures
import csv
import hashlib
import itertools
import json
import os
import subprocess
import sys
import tempfile

DESIGNS = {
    "baseline": ["--accel", "tri20", "--checkpoint", "off"],
    "sw": ["--accel", "tlas-tri20", "--checkpoint", "off"],
    "hw": ["--accel", "tri20", "--checkpoint", "on"],
    "grtx": ["--accel", "tlas-tri20", "--checkpoint", "on"],
}
COLUMNS = ["inputs", "key", "value", "design", "cycles"]


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--grtx", default="build/release/grtx", help="the program (default: %(default)s)")
    parser.add_argument("--scene", required=True)
    parser.add_argument("--cameras", required=True)
    parser.add_argument("--view", default="0")
    parser.add_argument("--size", type=int, default=48, help="width and height, pixels (default: %(default)s)")
    parser.add_argument("--fov-scale", default="1", help="as in grtx trace (default: %(default)s)")
    parser.add_argument("--machine", default="paper", help="as in grtx run (default: %(default)s)")
    parser.add_argument("--mode", default="cycle", choices=["cycle", "fast"])
    parser.add_argument("--only", action="append", default=[], metavar="KEY", help="these parameters (default: all)")
    parser.add_argument("--pairs", type=int, default=0, metavar="N", help="pairs of the N strongest (default: none)")
    parser.add_argument("--confirm", type=int, default=0, metavar="N",
                        help="with --mode fast: the N strongest again in cycle mode (default: none)")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="for all runs, as in grtx sim")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--most", type=int, default=20, help="bars of the tornado (default: %(default)s)")
    parser.add_argument("--report-only", action="store_true", help="table and picture of the runs that are there")
    parser.add_argument("-o", "--output", required=True)
    return parser.parse_args()


def open_parameters(grtx):
    """(key, default, allowed values, confidence) of every parameter that the paper does not give."""
    text = subprocess.run([grtx, "sim", "--list-config"], check=True, capture_output=True, text=True).stdout
    parameters = []
    for line in text.splitlines():
        cells = [cell.strip() for cell in line.strip().strip("|").split(" | ")]
        if not line.startswith("| `") or len(cells) != 7:
            continue
        key, default, allowed, confidence = cells[0].strip("`"), cells[1], cells[2], cells[6]
        if confidence != "A" and not key.startswith("fast."):  # how fast mode approximates is no hardware
            parameters.append((key, default, allowed, confidence))
    return parameters


def alternatives(default, allowed):
    """Half and double of a number, within its range; the other values of a choice."""
    if " to " not in allowed:
        return [value.strip() for value in allowed.split(",") if value.strip() != default]
    low, high = (float(limit) for limit in allowed.split(" to "))
    number = float(default)
    whole = "." not in default
    values = []
    for factor in (0.5, 2.0):
        value = min(max(number * factor, low), high)
        text = str(round(value)) if whole else repr(value)
        if float(text) != number:
            values.append(text)
    return values


def is_limit_study(key):
    """Switches that take a part away are not ignorance about it."""
    return key.endswith(".perfect") or key == "rt.memory.by_shader"


def is_unused(key):
    """Parameters of parts that none of the four designs has, or that only the hardware cost knows."""
    unused = ("rt.sphere.", "simt.registers", "simt.cost.sort_per_entry", "simt.cost.node_fetch")
    return key.startswith(unused)


def simulate(grtx, machine, mode, settings, trace):
    """Cycles, or None when the program refuses the combination."""
    with tempfile.NamedTemporaryFile(suffix=".json") as statistics:
        command = [grtx, "sim", "--quiet", trace, "--machine", machine, "--mode", mode, "--stats", statistics.name]
        for setting in settings:
            command += ["--set", setting]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode == 2:
            return None
        if done.returncode != 0:
            raise RuntimeError(f"{' '.join(command)}: {done.stderr.strip()}")
        with open(statistics.name) as file:
            return json.load(file)["stats"]["gpu.cycles"]["value"]


def trace_designs(arguments, traces):
    for design, options in DESIGNS.items():
        command = [arguments.grtx, "trace", "--quiet", "--machine", arguments.machine, "--scene", arguments.scene,
                   "--cameras", arguments.cameras, "--view", arguments.view, "--width", str(arguments.size),
                   "--height", str(arguments.size), "--fov-scale", arguments.fov_scale]
        subprocess.run(command + options + ["-o", traces[design]], check=True)


def identity(arguments, traces):
    """Changes with anything that the cycles depend on, so that rows of another run are not taken for ours."""
    digest = hashlib.sha256("\n".join([arguments.machine, arguments.mode] + arguments.set).encode())
    for path in [arguments.grtx] + list(traces.values()):
        with open(path, "rb") as file:
            digest.update(hashlib.sha256(file.read()).digest())
    return digest.hexdigest()[:12]


def read_rows(path, inputs):
    if not os.path.exists(path):
        return {}
    with open(path, newline="") as file:
        return {(row["key"], row["value"], row["design"]): row["cycles"]
                for row in csv.DictReader(file) if row["inputs"] == inputs}


def write_rows(path, inputs, rows):
    with open(path + ".new", "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        for (key, value, design), cycles in rows.items():
            writer.writerow([inputs, key, value, design, cycles])
    os.replace(path + ".new", path)


def one_at_a_time(parameters):
    """Points (key, value, design) of the default and of every parameter value."""
    points = [("default", "", design) for design in DESIGNS]
    for key, default, allowed, _ in parameters:
        points += [(key, value, design) for value in alternatives(default, allowed) for design in DESIGNS]
    return points


def in_pairs(strongest):
    """The same of all pairs of results; keys and values joined by a blank."""
    return [(f'{a["key"]} {b["key"]}', f'{a["value"]} {b["value"]}', design)
            for a, b in itertools.combinations(strongest, 2) for design in DESIGNS]


CYCLE = "cycle: "  # before the key of a point that is simulated in cycle mode whatever --mode says


def confirmations(strongest):
    points = [(CYCLE + "default", "", design) for design in DESIGNS]
    return points + [(CYCLE + r["key"], r["value"], design) for r in strongest for design in DESIGNS]


def settings_of(key, value):
    if key == "default":
        return []
    return [f"{k}={v}" for k, v in zip(key.split(), value.split())]


def run_all(arguments, wanted, traces, inputs):
    """Cycles of the points, as text; "" where the program refuses. Keeps what is in the file."""
    path = os.path.join(arguments.output, "sensitivity.csv")
    done = read_rows(path, inputs)
    missing = [] if arguments.report_only else [point for point in wanted if point not in done]
    print(f"{len(wanted)} points, {len(missing)} to simulate", flush=True)

    def one(point):
        key, value, design = point
        mode = "cycle" if key.startswith(CYCLE) else arguments.mode
        settings = arguments.set + settings_of(key.removeprefix(CYCLE), value)
        cycles = simulate(arguments.grtx, arguments.machine, mode, settings, traces[design])
        return point, "" if cycles is None else str(cycles)

    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        for number, (point, cycles) in enumerate(pool.map(one, missing), 1):
            done[point] = cycles
            if number % 20 == 0 or number == len(missing):
                write_rows(path, inputs, done)
                print(f"{number} of {len(missing)}", flush=True)
    return done


def evaluate(rows, parameters):
    """For each parameter value: (key, value, cycles relative to the default by design, speed-ups by design)."""
    default = {design: int(rows["default", "", design]) for design in DESIGNS}
    results = []
    for key, usual, allowed, confidence in parameters:
        for value in alternatives(usual, allowed):
            cycles = {design: rows.get((key, value, design), "") for design in DESIGNS}
            if "" in cycles.values():
                continue  # the program refuses it, or it has not been simulated yet
            cycles = {design: int(text) for design, text in cycles.items()}
            relative = {design: cycles[design] / default[design] for design in DESIGNS}
            speedup = {design: cycles["baseline"] / cycles[design] for design in DESIGNS}
            results.append({"key": key, "default": usual, "value": value, "confidence": confidence,
                            "relative": relative, "speedup": speedup})
    return default, results


def by_parameter(results, effect):
    """Parameters in order of their largest |effect| - 1; each with its results."""
    grouped = {}
    for result in results:
        grouped.setdefault(result["key"], []).append(result)
    return sorted(grouped.values(), key=lambda group: -max(abs(effect(result) - 1) for result in group))


def speedups(rows, key="default", value=""):
    cycles = {design: rows.get((key, value, design), "") for design in DESIGNS}
    if "" in cycles.values():
        return None
    return {design: int(cycles["baseline"]) / int(cycles[design]) for design in DESIGNS if design != "baseline"}


def pairs_table(rows, strongest):
    """Speed-ups of each pair beside the product of what its two parameters do alone."""
    usual = speedups(rows)
    lines = ["| first | second | " + " | ".join(f"{d}, alone × alone, together" for d in usual) + " |", "|---|---|" + "---|" * len(usual)]
    for a, b in itertools.combinations(strongest, 2):
        both = speedups(rows, f'{a["key"]} {b["key"]}', f'{a["value"]} {b["value"]}')
        if both is None:
            continue
        cells = [f'{a["speedup"][d] * b["speedup"][d] / usual[d]:.2f}, {both[d]:.2f}' for d in usual]
        lines.append(f'| `{a["key"]}={a["value"]}` | `{b["key"]}={b["value"]}` | ' + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def confirmed_table(rows, strongest):
    lines = ["| parameter | mode | " + " | ".join(d for d in DESIGNS if d != "baseline") + " |", "|---|---|---|---|---|"]
    for key, value in [("default", "")] + [(r["key"], r["value"]) for r in strongest]:
        for mode, prefix in (("fast", ""), ("cycle", CYCLE)):
            found = speedups(rows, prefix + key, value)
            if found is not None:
                name = f"`{key}={value}`" if value else key
                lines.append(f"| {name} | {mode} | " + " | ".join(f"{x:.3f}" for x in found.values()) + " |")
    return "\n".join(lines) + "\n"


def escape(text):
    return text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")


def tornado(title, panels, most):
    """SVG of panels, two a row, each (heading, groups, effect): bars of effect - 1 in percent around 0."""
    row, label, width, top, bottom = 20, 250, 380, 30, 24
    panel_width = label + width + 20
    panel_height = top + most * row + bottom
    total = (2 * panel_width, 26 + (len(panels) + 1) // 2 * panel_height + 20)
    svg = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{total[0]}" height="{total[1]}" font-family="sans-serif" '
           'font-size="11">', f'<rect width="{total[0]}" height="{total[1]}" fill="white"/>',
           f'<text x="10" y="18" font-size="14">{escape(title)}</text>']
    for index, (heading, groups, effect) in enumerate(panels):
        svg += panel(index % 2 * panel_width, 26 + index // 2 * panel_height, heading, groups[:most], effect,
                     row, label, width, top)
    svg.append(f'<text x="10" y="{total[1] - 6}" fill="#555">red: smaller value or switched off; blue: larger value, '
               'switched on, or another policy; the value stands at its bar</text></svg>')
    return "\n".join(svg) + "\n"


def panel(left, above, heading, groups, effect, row, label, width, top):
    middle = left + label + width / 2
    largest = max([abs(effect(r) - 1) for group in groups for r in group] + [0.01])
    scale = (width / 2 - 40) / largest
    svg = [f'<text x="{left + label}" y="{above + 20}" font-weight="bold">{escape(heading)}</text>']
    for i, group in enumerate(groups):
        y = above + top + i * row
        name = f'{group[0]["key"]} = {group[0]["default"]}'
        svg.append(f'<text x="{left + label - 6}" y="{y + 13}" text-anchor="end">{escape(name)}</text>')
        thick = (row - 3) / len(group)
        for j, result in enumerate(group):
            change = effect(result) - 1
            length = abs(change) * scale
            x = middle if change >= 0 else middle - length
            bar = y + j * thick
            colour = "#c0504d" if is_smaller(result) else "#4f81bd"
            svg.append(f'<rect x="{x:.1f}" y="{bar:.1f}" width="{length:.1f}" height="{thick:.1f}" fill="{colour}">'
                       f'<title>{escape(result["key"])} = {escape(result["value"])}: {100 * change:+.2f} %</title></rect>')
            anchor, offset = ("start", 3) if change >= 0 else ("end", -3)
            svg.append(f'<text x="{middle + change * scale + offset:.1f}" y="{bar + thick / 2 + 3:.1f}" '
                       f'text-anchor="{anchor}" font-size="8">{escape(result["value"])}</text>')
    end = above + top + len(groups) * row
    svg.append(f'<line x1="{middle}" y1="{above + top}" x2="{middle}" y2="{end}" stroke="black"/>')
    for change in (-largest, 0, largest):
        svg.append(f'<text x="{middle + change * scale:.1f}" y="{end + 12}" text-anchor="middle">'
                   f'{100 * change:+.1f} %</text>')
    return svg


def is_smaller(result):
    try:
        return float(result["value"]) < float(result["default"])
    except ValueError:
        return result["value"] == "false"


def table(default, results, most):
    speedup = {design: default["baseline"] / default[design] for design in DESIGNS}
    lines = ["Default: " + ", ".join(f"{d} {default[d]} cycles" for d in DESIGNS) + "; speed-ups "
             + ", ".join(f"{d} {speedup[d]:.3f}" for d in DESIGNS if d != "baseline") + ".", "",
             "| parameter | default | value | conf. | " + " | ".join(f"cycles {d}" for d in DESIGNS) + " | "
             + " | ".join(f"speed-up {d}" for d in DESIGNS if d != "baseline") + " |",
             "|---|---|---|---|" + "---|" * 7]
    for group in by_parameter(results, lambda r: r["speedup"]["grtx"] / speedup["grtx"])[:most]:
        for r in group:
            lines.append(f'| `{r["key"]}` | {r["default"]} | {r["value"]} | {r["confidence"]} | '
                         + " | ".join(f'{100 * (r["relative"][d] - 1):+.2f} %' for d in DESIGNS) + " | "
                         + " | ".join(f'{r["speedup"][d]:.3f}' for d in DESIGNS if d != "baseline") + " |")
    return "\n".join(lines) + "\n"


def main():
    arguments = parse_arguments()
    os.makedirs(arguments.output, exist_ok=True)
    usual = dict(setting.split("=", 1) for setting in arguments.set)
    parameters = [(key, usual.get(key, default), allowed, confidence)
                  for key, default, allowed, confidence in open_parameters(arguments.grtx)
                  if not is_limit_study(key) and not is_unused(key) and (not arguments.only or key in arguments.only)]
    traces = {design: os.path.join(arguments.output, design + ".grtx") for design in DESIGNS}
    if not arguments.report_only:
        trace_designs(arguments, traces)
    inputs = identity(arguments, traces)
    rows = run_all(arguments, one_at_a_time(parameters), traces, inputs)
    default, results = evaluate(rows, parameters)
    speedup = {design: default["baseline"] / default[design] for design in DESIGNS}
    effect = lambda r: r["speedup"]["grtx"] / speedup["grtx"]
    ranked = [max(group, key=lambda r: abs(effect(r) - 1)) for group in by_parameter(results, effect)]
    rows = run_all(arguments, in_pairs(ranked[:arguments.pairs]) if arguments.pairs else [], traces, inputs)
    rows = run_all(arguments, confirmations(ranked[:arguments.confirm]) if arguments.confirm else [], traces, inputs)
    panels = []
    for design in ("sw", "hw", "grtx"):
        effect = lambda r, d=design: r["speedup"][d] / speedup[d]
        panels.append((f"speed-up of {design}: {speedup[design]:.2f}", by_parameter(results, effect), effect))
    effect = lambda r: r["relative"]["grtx"]
    panels.append((f"cycles of grtx: {default['grtx']}", by_parameter(results, effect), effect))
    name = f"{os.path.basename(arguments.scene)}, view {arguments.view}, {arguments.size} x {arguments.size}"
    with open(os.path.join(arguments.output, "sensitivity.svg"), "w") as file:
        file.write(tornado(f"One parameter at a time, halved and doubled: {name}", panels, arguments.most))
    with open(os.path.join(arguments.output, "sensitivity_table.md"), "w") as file:
        file.write(table(default, results, arguments.most))
        if arguments.pairs:
            file.write("\n" + pairs_table(rows, ranked[:arguments.pairs]))
        if arguments.confirm:
            file.write("\n" + confirmed_table(rows, ranked[:arguments.confirm]))
    moved = {d: [min(r["speedup"][d] for r in results), max(r["speedup"][d] for r in results)]
             for d in DESIGNS if d != "baseline"}
    for design, (low, high) in moved.items():
        print(f"speed-up of {design}: {speedup[design]:.3f}, with one parameter moved {low:.3f} to {high:.3f}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
