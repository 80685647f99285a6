#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The page of estimate errors: what windows mode says against cycle mode, over every case of sweep databases.

    grtx sweep PLAN.toml -o paper.sqlite --machine paper --mode cycle
    grtx sweep PLAN.toml -o paper.sqlite --machine paper --mode windows
    python3 bench/estimate_errors.py paper=paper.sqlite ada-share=ada-share.sqlite [--csv F.csv] [--cases] [--used "playbot 0,logo 0"]
    python3 bench/estimate_errors.py paper=F.csv ada-share=ada-share.sqlite
    python3 bench/estimate_errors.py --windows paper-charged=FOLDER [--constants CYCLES,SPEED-UP]

A case is a point (scene, view, design, coordinates) that a database has in cycle mode and in another one. Printed for each machine and mode,
then for all machines together: the distribution of the error of gpu.cycles and of the speed-up over the baseline, the
worst case by name, and how often an interval held cycle mode's value. A point that a mode simulates as a whole has none.
--cases prints every case, with how many times as fast the
estimate was by wall time; --csv writes them, and the cases of a machine can be read from such a file. --used names scenes
with their views that took part in making the estimates: rows are then of these, of the others (held out) and of all.
--windows reads statistics of `grtx sim` in place of databases: FOLDER/SCENE.DESIGN.whole.json of cycle mode and
FOLDER/SCENE.DESIGN.SEED.json of windows mode (bench/windows.sh makes them). The intervals, of cycles and of speed-ups,
are counted with the constants that the program gave them or with --constants: 0.012,0.02 are those of the program.
Exit code 1 when a limit of --max-mean, --max-worst or --max-speedup (percent) is exceeded or there is no case.
"""
import argparse
import csv
import glob
import json
import math
import os
import sys
from collections import defaultdict

from sweep_database import points

PARTS = ("held out", "used", "all")  # of the cases, as --used tells them apart
NAMES = ("gpu.cycles", "gpu.windows.cycles_low", "gpu.windows.cycles_high")


def read(machine, path):
    """[(machine, mode, scene, view, coordinates, design, values, seconds)] of the points that are done."""
    return [(machine, point["mode"], point["scene"], point["at"].pop("view", 0), point["at"], point["design"], point["values"], point["seconds"])
            for point in points(path, *NAMES)]


def text(coordinates):
    return ", ".join(f"{key} = {value}" for key, value in sorted(coordinates.items()))


def cases_of(rows):
    """One case for each estimate whose point cycle mode has, too: a dictionary with errors in percent."""
    truth = {}
    for machine, mode, scene, view, at, design, values, seconds in rows:
        if mode == "cycle":
            truth[machine, scene, view, text(at), design] = values["gpu.cycles"], seconds
    cases = []
    for machine, mode, scene, view, at, design, values, seconds in rows:
        exact, cycle_seconds = truth.get((machine, scene, view, text(at), design), (None, 0))
        if mode == "cycle" or exact is None:
            continue
        case = {"machine": machine, "mode": mode, "scene": scene, "view": view, "at": text(at), "design": design,
                "cycles": exact, "estimate": values["gpu.cycles"], "error": 100 * (values["gpu.cycles"] / exact - 1)}
        if seconds:
            case["times as fast"] = cycle_seconds / seconds
        low, high = (values.get(f"gpu.windows.cycles_{end}", exact) for end in ("low", "high"))
        if low < high:
            case["held"] = low <= exact <= high
            case["half"] = 100 * (max(case["estimate"] / low, high / case["estimate"]) - 1)
        cases.append(case)
    speed_ups(cases)
    return cases


def recorded_cases(machine, path):
    """The cases of the machine in a file that --csv wrote."""
    with open(path, newline="", encoding="utf-8") as file:
        found = [row for row in csv.DictReader(file) if row["machine"] == machine]
    numbers = ("cycles", "estimate", "error", "speed-up error", "times as fast", "half", "speed-up half")
    cases = []
    for row in found:
        case = {key: float(value) if key in numbers else value for key, value in row.items() if value}
        case.update({"view": int(row["view"]), "at": row["at"]})
        case.update({key: row[key] == "True" for key in ("held", "speed-up held") if row.get(key)})
        cases.append(case)
    return cases


def speed_ups(cases):
    """Adds the error of the speed-up over the baseline of the same machine, mode, scene and coordinates."""
    bases = {(c["machine"], c["mode"], c["scene"], c["view"], c["at"]): c for c in cases if c["design"] == "baseline"}
    for case in cases:
        base = bases.get((case["machine"], case["mode"], case["scene"], case["view"], case["at"]))
        if base is not None and case is not base:
            case["speed-up error"] = 100 * ((base["estimate"] / case["estimate"]) / (base["cycles"] / case["cycles"]) - 1)


BIAS_DEGREES = 4.0  # kBiasDegrees of rtl_tlm/estimate/estimate.h; the rest here is estimate.cpp's, too


def student_quantile(p, degrees):
    def cumulative(t):
        end, steps = math.atan(t / math.sqrt(degrees)), 400
        h = end / steps
        total = sum((1 if i in (0, steps) else 4 if i % 2 else 2) * math.cos(i * h) ** (degrees - 1) for i in range(steps + 1))
        return 0.5 + math.exp(math.lgamma((degrees + 1) / 2) - math.lgamma(degrees / 2)) / math.sqrt(math.pi) * total * h / 3
    low, high = 0.0, 1.0
    while cumulative(high) < p:
        high *= 2
    for _ in range(50):
        middle = (low + high) / 2
        low, high = (middle, high) if cumulative(middle) < p else (low, middle)
    return (low + high) / 2


def reach(influences, degrees, bias):
    """Half of the interval on the logarithm."""
    variance, square = (degrees + 2) / degrees * sum(i * i for i in influences), bias * bias
    both = variance + square
    if both == 0:
        return 0.0
    together = both * both / (variance * variance / degrees + square * square / BIAS_DEGREES)
    return max(student_quantile(0.975, together) * math.sqrt(both), student_quantile(0.975, BIAS_DEGREES) * bias)


def influences_of(estimate):
    return {group: influence for group, _, influence in estimate["evidence"]}


def window_cases(machine, folder, constants):
    """The same of a folder of statistics: whole traces, and windows of them."""
    cases, found = [], {}
    for path in sorted(glob.glob(os.path.join(folder, "*.whole.json"))):
        scene, design = os.path.basename(path)[:-len(".whole.json")].rsplit(".", 1)
        with open(path, encoding="utf-8") as file:
            exact = json.load(file)["stats"]["gpu.cycles"]["value"]
        for other in sorted(glob.glob(glob.escape(path[:-len("whole.json")]) + "*.json")):
            seed = other[len(path) - len("whole.json"):-len(".json")]
            if seed == "whole":
                continue
            with open(other, encoding="utf-8") as file:
                estimate = json.load(file)["windows"]
            if estimate["whole"]:
                continue  # exact
            found[scene, design, seed] = estimate
            off = estimate["log_cycles"] - math.log(exact)
            half = reach(influences_of(estimate).values(), estimate["degrees_of_freedom"], constants[0] if constants else estimate["bias"][0])
            cases.append({"machine": machine, "mode": "windows", "scene": scene, "view": 0, "at": f"seed = {seed}", "design": design,
                          "cycles": exact, "estimate": math.exp(estimate["log_cycles"]), "error": 100 * math.expm1(off),
                          "held": abs(off) <= half, "half": 100 * math.expm1(half)})
    speed_ups(cases)
    for case in cases:
        if "speed-up error" not in case:
            continue
        seed = case["at"].removeprefix("seed = ")
        base, other = found[case["scene"], "baseline", seed], found[case["scene"], case["design"], seed]
        groups, others = influences_of(base), influences_of(other)
        half = reach([groups.get(g, 0) - others.get(g, 0) for g in {*groups, *others}],
                     min(base["degrees_of_freedom"], other["degrees_of_freedom"]), constants[1] if constants else base["bias"][1])
        case["speed-up held"] = abs(math.log1p(case["speed-up error"] / 100)) <= half
        case["speed-up half"] = 100 * math.expm1(half)
    return cases


def quantile(sizes, share):
    """The smallest size that at least `share` of them do not exceed."""
    return sorted(sizes)[max(0, math.ceil(share * len(sizes)) - 1)]


def name_of(case):
    at = f", {case['at']}" if case["at"] else ""
    return f"{case['scene']} {case['view']}, {case['machine']}, {case['design']}{at}"


def distribution(cases, key):
    """Cells of a row: count, mean size, 95th percentile, worst with its name."""
    found = [c for c in cases if key in c]
    if not found:
        return ["0", "", "", "", ""]
    sizes = [abs(c[key]) for c in found]
    worst = max(found, key=lambda c: abs(c[key]))
    return [str(len(found)), f"{sum(sizes) / len(sizes):.1f} %", f"{quantile(sizes, 0.95):.1f} %", f"{worst[key]:+.1f} %", name_of(worst)]


def table(header, rows):
    return "\n".join(["| " + " | ".join(header) + " |", "|" + "---|" * len(header)] +
                     ["| " + " | ".join(row) + " |" for row in rows])


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("databases", nargs="*", metavar="MACHINE=DB.sqlite")
    options.add_argument("--windows", action="append", default=[], metavar="MACHINE=FOLDER")
    options.add_argument("--constants", type=lambda text: [float(number) for number in text.split(",")])
    options.add_argument("--csv")
    options.add_argument("--cases", action="store_true")
    options.add_argument("--used", type=lambda text: {name.strip() for name in text.split(",")}, metavar="SCENE VIEW,...")
    for name in ("mean", "worst", "speedup"):
        options.add_argument(f"--max-{name}", type=float)
    arguments = options.parse_args()
    rows, cases = [], []
    for entry in arguments.databases:
        machine, _, path = entry.rpartition("=")
        if path.endswith(".csv"):
            cases += recorded_cases(machine, path)
        else:
            rows += read(machine or path, path)
    cases += cases_of(rows)
    for entry in arguments.windows:
        machine, _, folder = entry.rpartition("=")
        cases += window_cases(machine or folder, folder, arguments.constants)
    if not cases:
        print("estimate_errors.py: no point is there in cycle mode and in another one", file=sys.stderr)
        return 1

    groups = defaultdict(list)
    for case in cases:
        parts = ["all"]
        if arguments.used is not None:
            parts.append("used" if f"{case['scene']} {case['view']}" in arguments.used else "held out")
        for part in parts:
            groups[case["mode"], case["machine"], part].append(case)
            groups[case["mode"], "all", part].append(case)
    ordered = sorted(groups.items(), key=lambda item: (item[0][0], item[0][1] == "all", item[0][1], PARTS.index(item[0][2])))
    for key, title in (("error", "Cycles"), ("speed-up error", "Speed-up over the baseline")):
        print(f"{title}:\n")
        print(table(["mode", "machine", "cases", "mean size", "95 % within", "worst", "which"],
                    [[mode, machine if part == "all" else f"{machine}, {part}"] + distribution(group, key)
                     for (mode, machine, part), group in ordered]) + "\n")
    for mode in sorted({c["mode"] for c in cases}):
        for key, what in (("held", "cycles"), ("speed-up held", "speed-ups")):
            held = [c[key] for c in cases if c["mode"] == mode and key in c]
            halves = [c[key.replace("held", "half")] for c in cases if c["mode"] == mode and key.replace("held", "half") in c]
            width = f"; half of an interval is {sum(halves) / len(halves):.1f} % in the mean" if halves else ""
            if held:
                print(f"Intervals of {what} in {mode} mode that held the true value: {sum(held)} of {len(held)}"
                      f" ({100 * sum(held) / len(held):.0f} %){width}.\n")
    if arguments.cases:
        print(table(["mode", "machine", "scene", "view", "at", "design", "cycles", "error", "of the speed-up", "times as fast"],
                    [[c["mode"], c["machine"], c["scene"], str(c["view"]), c["at"], c["design"], f"{c['cycles']:.0f}", f"{c['error']:+.1f} %",
                      f"{c['speed-up error']:+.1f} %" if "speed-up error" in c else "",
                      f"{c['times as fast']:.1f}" if "times as fast" in c else ""] for c in cases]))
    if arguments.csv:
        with open(arguments.csv, "w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, ["machine", "mode", "scene", "view", "at", "design", "cycles", "estimate", "error", "speed-up error", "held", "times as fast",
                                           "half", "speed-up held", "speed-up half"])
            writer.writeheader()
            writer.writerows(cases)
    mean = sum(abs(c["error"]) for c in cases) / len(cases)
    worst = max(abs(c["error"]) for c in cases)
    speedup = max((abs(c["speed-up error"]) for c in cases if "speed-up error" in c), default=0.0)
    failed = [f"{name} {value:.2f} % exceeds {limit} %" for name, value, limit in
              (("mean error of cycles", mean, arguments.max_mean), ("worst error of cycles", worst, arguments.max_worst),
               ("worst error of a speed-up", speedup, arguments.max_speedup)) if limit is not None and value > limit]
    for line in failed:
        print(f"estimate_errors.py: {line}", file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
