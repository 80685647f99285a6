#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Fits what the paper leaves open of machine `paper` to its printed figures (bench/fit.toml: views, frames, freedoms).

    python3 bench/fit.py run "queue" "queue port" --program GRTX --scenes DIR -o DIR [--frames main,small] [--views fit]
    python3 bench/fit.py table ["" "queue"] -o DIR [--csv F.csv]
    python3 bench/fit.py select ["" "queue"] -o DIR

A machine is `paper` with what fit.toml has as today, and some freedoms, by name; "" is without any. run: what is missing, by `grtx sweep`, one database a frame and
kind of design; those without checkpoints do not meet rt.checkpoint keys, so machines share them. table: each machine's figures, over the views that the
search sees, over the others, and how many are within 20 %. select: forward selection, all views and with one scene left out. Both compare the machines named, or
all that there are, over the views that each of them has; --from F.csv takes what --csv wrote in place of the databases.
Exit code 2: bad input.
"""
import argparse
import csv
import itertools
import json
import math
import os
import shutil
import sqlite3
import subprocess
import sys
import tomllib
from statistics import geometric_mean

from paper import claims

from sweep_database import points

HERE = os.path.dirname(os.path.abspath(__file__))
# Printed figures that a machine decides; the others are of scenes (bytes, height, footprint, buffers) or a sum (storage).
CLAIMS = {"sw": "speedup-sw", "hw": "speedup-hw", "grtx": "speedup-grtx", "grtx over the better": "grtx-over-best", "node fetches": "fetches-grtx",
          "fetches on sw": "fetches-hw-on-sw", "latency": "latency-grtx", "L2 accesses": "l2-grtx", "L1 hits, sw": "l1-sw",
          "L1 hits, grtx on sw": "l1-grtx-over-sw", "best k, baseline": "best-k-baseline", "best k, grtx": "best-k-grtx",
          "small field, sw": "small-fov-sw", "small field, hw": "small-fov-hw", "sw by field": "fov-trend-sw", "hw by field": "fov-trend-hw",
          "hw, secondary on primary": "hw-secondary-over-primary", "sw by shader": "by-shader-sw"}
PAPER = {name: claims.load()[claim] for name, claim in CLAIMS.items()}
DESIGNS = ("baseline", "sw", "hw", "grtx")
COLUMNS = ["mode", "machine", "view", "figure", "value"]
WITH_CHECKPOINTS, WITH_INSTANCES = {"hw", "grtx"}, {"sw", "grtx"}
OF_INSTANCES = {"rt.memory.blas_header_read", "rt.memory.instance_leaf_bytes"}


def refuse(reason):
    print(f"fit.py: {reason}", file=sys.stderr)
    sys.exit(2)


def known(what, names, among):
    """These names, if all are known."""
    for name in names:
        if name not in among:
            refuse(f"no {what} {name!r}; there are {', '.join(among)}")
    return names


def keys_of(plan, machine):
    keys = dict(plan["today"])
    for name in known("freedom", machine.split(), plan["freedom"]):
        keys.update(plan["freedom"][name])
    return keys


def effective(keys, design):
    """What of a machine a design meets."""
    return {k: v for k, v in keys.items() if (design in WITH_CHECKPOINTS or not k.startswith("rt.checkpoint.")) and (design in WITH_INSTANCES or k not in OF_INSTANCES)}


# Running


def plan_text(plan, frame, design, options, machines, views, scenes):
    lines = [f'designs = ["{design}"]']
    for name, view in views.items():
        lines += ["[[scene]]", f"name = {json.dumps(name)}", f"file = {json.dumps(os.path.join(scenes, view['file'] + '.ply'))}",
                  f"cameras = {json.dumps(os.path.join(scenes, view['file'] + '.cameras.json'))}", f"view = {view.get('view', 0)}",
                  f"width = {frame['size']}", f"height = {frame['size']}", f"fov_scale = {view['scale'] * frame['factor']:.6g}"]
    lines += ["[set]"] + [f"{k} = {json.dumps(v)}" for k, v in plan["set"].items()] + ["[limits]", "seconds = 3600", "memory_mb = 9000"]
    points = []
    for machine in machines:
        for option in options:
            point = {**effective(keys_of(plan, machine), design), **option}
            if point not in points:
                points.append(point)
    for point in points:
        lines += ["[[point]]"] + [f"{k} = {json.dumps(v)}" for k, v in point.items()]
    return "\n".join(lines) + "\n"


def run(options, plan):
    machines = options.machines or [""]
    frames = known("frame", options.frames.split(","), plan["frame"])
    designs = known("design", options.designs.split(",") if options.designs else list(DESIGNS), DESIGNS)
    if options.views in ("all", "fit", "left"):
        chosen = [n for n, v in plan["view"].items() if options.views in ("all", "fit" if v["fit"] else "left")]
    else:
        chosen = known("view", options.views.split(","), plan["view"])
    views = {name: plan["view"][name] for name in chosen}
    for machine in machines:
        keys_of(plan, machine)
    for file in (os.path.join(options.scenes, view["file"] + end) for view in views.values() for end in (".ply", ".cameras.json")):
        if not os.path.exists(file):
            refuse(f"--scenes: {file}: no such file")
    if not shutil.which(options.program):
        refuse(f"--program {options.program}: no program")
    os.makedirs(options.out, exist_ok=True)
    note_machines(options.out, machines)
    for name in frames:
        frame = plan["frame"][name]
        for design, varied in frame["designs"].items():
            if design not in designs:
                continue
            path = os.path.join(options.out, f"{name}-{design}.toml")
            with open(path, "w", encoding="utf-8") as file:
                file.write(plan_text(plan, frame, design, varied, machines, views, os.path.abspath(options.scenes)))
            swept = subprocess.run([options.program, "sweep", path, "-o", path[:-5] + ".sqlite", "--machine", "paper", "--mode", options.mode,
                                    "--jobs", str(options.jobs), "--retry", "--quiet"], check=False)
            if swept.returncode not in (0, 1):  # 1: points that failed are missing from the table
                sys.exit(swept.returncode)


# Reading


def read(plan, out, mode):
    """A function: machine, view, frame, design, option -> statistics, or None where they are missing."""
    table = {}
    address = lambda keys, design: json.dumps(effective(keys, design), sort_keys=True)
    for name, frame in plan["frame"].items():
        for design in frame["designs"]:
            path = os.path.join(out, f"{name}-{design}.sqlite")
            if not os.path.exists(path):
                continue
            try:
                done = points(path, earlier=True)
            except sqlite3.Error as error:
                refuse(f"{path}: {error}")
            for point in done:
                config, tracer = point["config"], point["tracer"]
                option = {"k": tracer["k"], "secondary": tracer["secondary"], "shader": config["rt.memory.by_shader"]}.get(name)
                if point["mode"] == mode:
                    table[name, design, point["scene"], str(option), address({k: config.get(k) for k in plan["today"]}, design)] = point["values"]

    def of(machine, view, frame, design, option=None):
        return table.get((frame, design, view, str(option), address(keys_of(plan, machine), design)))
    return of


def figures(of, machine, view):
    """The figures that there are points for."""
    at = {d: of(machine, view, "main", d) for d in DESIGNS}
    if not all(at.values()):
        return {}
    found = {}
    cycles = {d: v["gpu.cycles"] for d, v in at.items()}
    base, grtx, sw = at["baseline"], at["grtx"], at["sw"]
    for d in ("sw", "hw", "grtx"):
        found[d] = cycles["baseline"] / cycles[d]
    found["grtx over the better"] = min(cycles["sw"], cycles["hw"]) / cycles["grtx"]
    ratio = lambda name, a, b: a[name] / b[name]
    found["node fetches"] = ratio("gpu.rt.node_fetches", base, grtx)
    found["fetches on sw"] = ratio("gpu.rt.node_fetches", sw, grtx)
    found["latency"] = ratio("gpu.rt.node_fetch_latency", base, grtx)
    found["L2 accesses"] = ratio("gpu.l2.accesses", base, grtx)
    found["L1 hits, sw"] = sw["gpu.l1.node.hit_rate"]
    found["L1 hits, grtx on sw"] = ratio("gpu.l1.node.hit_rate", grtx, sw)
    for design, ks in (("baseline", (16, 32)), ("grtx", (4, 16))):
        by_k = {8: at[design], **{k: of(machine, view, "k", design, k) for k in ks}}
        if all(by_k.values()):
            found[f"best k, {design}"] = min(by_k, key=lambda k: by_k[k]["gpu.cycles"])
            for k in ks:
                found[f"{design}, k = {k} on 8"] = by_k[8]["gpu.cycles"] / by_k[k]["gpu.cycles"]
    small = {d: of(machine, view, "small", d) for d in ("baseline", "sw", "hw")}
    for d in ("sw", "hw"):
        if small["baseline"] and small[d]:
            found[f"small field, {d}"] = small["baseline"]["gpu.cycles"] / small[d]["gpu.cycles"]
            found[f"{d} by field"] = found[f"small field, {d}"] / found[d]
    second = {d: of(machine, view, "secondary", d, "both") for d in ("baseline", "hw")}
    if all(second.values()) and second["hw"]["gpu.rays.secondary_cycles"]:
        ratio = lambda kind: second["baseline"][f"gpu.rays.{kind}_cycles"] / second["hw"][f"gpu.rays.{kind}_cycles"]
        found["hw, secondary on primary"] = ratio("secondary") / ratio("primary")
    shader = {d: of(machine, view, "shader", d, True) for d in ("baseline", "sw")}
    if all(shader.values()):
        found["sw by shader"] = shader["baseline"]["gpu.cycles"] / shader["sw"]["gpu.cycles"]
    return found


def databases_of(plan, out, modes):
    """{machine: {view: (mode, figures)}}, of the first mode that has the main frame."""
    path = os.path.join(out, "machines.json")
    if not os.path.exists(path):
        refuse(f"{path}: no such file: `fit.py run` writes it")
    with open(path, encoding="utf-8") as file:
        machines = json.load(file)
    found = {machine: {} for machine in machines}
    for mode in modes:
        of = read(plan, out, mode)
        for machine, view in itertools.product(machines, plan["view"]):
            own = figures(of, machine, view)
            if own:
                found[machine].setdefault(view, (mode, own))
    return found


def table_of(plan, path, modes):
    """The same, of what --csv wrote."""
    found = {}
    with open(path, newline="", encoding="utf-8") as file:
        rows = list(csv.reader(file))
    if not rows or rows[0] != COLUMNS:
        refuse(f"{path}:1: must be {','.join(COLUMNS)}")
    for mode in modes:
        here = {}
        for line, row in enumerate(rows[1:], 2):
            try:
                own, machine, view, name, value = row[0], row[1], row[2], row[3], float(row[4])
            except (IndexError, ValueError):
                refuse(f"{path}:{line}: must be {','.join(COLUMNS)}")
            if view not in plan["view"] or not value > 0:
                refuse(f"{path}:{line}: " + (f"no view {view!r} in the plan" if view not in plan["view"] else "a figure must be above 0"))
            machine = "" if machine == "paper" else machine
            keys_of(plan, machine)
            if own == mode:
                here.setdefault((machine, view), {})[name] = value
        for (machine, view), own in here.items():
            found.setdefault(machine, {}).setdefault(view, (mode, own))
    return found


def loaded(options, plan):
    """Machines, {machine: {view: figures}} of the views that each of them has, and all of them with their modes."""
    modes = options.mode.split(",")
    everything = table_of(plan, options.source, modes) if options.source else databases_of(plan, options.out, modes)
    machines = list(dict.fromkeys(known("machine", options.machines, everything) if options.machines else [m for m, views in everything.items() if views]))
    have = [v for v in plan["view"] if any(v in everything[m] for m in machines)]
    common = [v for v in have if all(v in everything[m] for m in machines)]
    if not common:
        refuse("no view that each machine has: " + ("no points yet" if not have else "name machines to compare"))
    unlike = [v for v in have if v not in common]
    if unlike:
        print(f"fit.py: left out, as not every machine has them: {', '.join(unlike)}", file=sys.stderr)
    return machines, {m: {v: everything[m][v][1] for v in common} for m in machines}, everything


def means(by_view, views, machines):
    """{machine: {figure: mean}}, each figure over those of the views where every machine has it."""
    found = {m: {} for m in machines}
    for name in dict.fromkeys(n for v in views for n in by_view[machines[0]][v]):
        on = [v for v in views if all(name in by_view[m][v] for m in machines)]
        for m in machines if on else ():
            found[m][name] = geometric_mean([by_view[m][v][name] for v in on])
    return found


def holds(name, value):
    return PAPER[name].holds(value)


def objective(mean, names):
    """Figures outside plus the mean squared log ratio. names: that all machines have."""
    outside = sum(not holds(n, mean[n]) for n in names)
    apart = [0 if PAPER[n].bound and holds(n, mean[n]) else math.log(mean[n] / PAPER[n].paper) ** 2 for n in names]
    return outside + sum(apart) / len(names), outside


def note_machines(out, machines):
    """Which were run, by name, `paper` first."""
    path = os.path.join(out, "machines.json")
    noted = [""]
    if os.path.exists(path):
        with open(path, encoding="utf-8") as file:
            noted = json.load(file)
    with open(path + ".partial", "w", encoding="utf-8") as file:
        json.dump(list(dict.fromkeys([*noted, *machines])), file)
    os.replace(path + ".partial", path)


def table(options, plan):
    machines, by_view, everything = loaded(options, plan)
    for side, fit in (("fit", True), ("left out", False)):
        views = [v for v in by_view[machines[0]] if plan["view"][v]["fit"] == fit]
        for machine, mean in means(by_view, views, machines).items():
            have = [n for n in PAPER if n in mean]
            if have:
                value, outside = objective(mean, have)
                print(f"{machine or 'paper'} ({side}: {', '.join(views)}): {len(have) - outside} of {len(have)} hold, objective {value:.3f}")
                print("   " + "; ".join(f"{n} {mean[n]:.2f}{'' if holds(n, mean[n]) else ' X'}" for n in have) + " | " + "; ".join(f"{n} {mean[n]:.2f}" for n in sorted(mean) if n not in PAPER))
    if options.csv:
        rows = [[mode, m or "paper", v, n, f"{x:.4f}"] for m, views in everything.items() for v, (mode, own) in views.items() for n, x in own.items()]
        with open(options.csv + ".partial", "w", newline="", encoding="utf-8") as file:
            csv.writer(file).writerows([COLUMNS, *rows])
        os.replace(options.csv + ".partial", options.csv)


def select(options, plan):
    """Forward: from `paper` the freedom that lowers the objective most, until none lowers the number of figures outside. With all views that the
    search sees, and with each scene left out, on which the choice is then judged. A step is taken among the machines that are compared."""
    machines, by_view, _ = loaded(options, plan)
    of_freedoms = {frozenset(m.split()): m for m in machines}
    if frozenset() not in of_freedoms:
        refuse('select begins with the machine without freedoms, "", which is not there')

    def judged(views):
        """{freedoms: (objective, figures outside)}"""
        mean = means(by_view, views, machines)
        names = [n for n in PAPER if n in mean[""]]
        return {key: objective(mean[m], names) for key, m in of_freedoms.items()}

    def forward(views):
        worth, at = judged(views), frozenset()
        path = [(at, *worth[at])]
        while True:
            steps = [(key, *worth[key]) for key in worth if len(key) == len(at) + 1 and at < key]
            best = min(steps, key=lambda s: s[1], default=None)
            if not best or best[2] >= path[-1][2] and best[1] >= path[-1][1] - 0.005:
                return path
            path.append(best)
            at = best[0]

    scene = lambda view: view.rsplit("-", 1)[0]
    seen = [v for v in by_view[""] if plan["view"][v]["fit"]]
    if not seen:
        refuse("no view that the search sees is one that each machine has")
    for left in [None, *sorted({scene(v) for v in seen})]:
        views, out = [v for v in seen if scene(v) != left], [v for v in seen if scene(v) == left]
        if not views:
            continue
        path = forward(views)
        print(f"without {left}:" if left else "all views that the search sees:")
        for key, value, outside in path:
            print(f"    {' '.join(sorted(key)) or 'paper'}: {outside} outside, objective {value:.3f}")
        if out:
            on = judged(out)
            print(f"    on {left}: paper {on[frozenset()][1]} outside, {on[frozenset()][0]:.3f}; chosen {on[path[-1][0]][1]}, {on[path[-1][0]][0]:.3f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["run", "table", "select"])
    parser.add_argument("machines", nargs="*", help="names of freedoms, in one text a machine")
    parser.add_argument("--program", default="grtx")
    parser.add_argument("--plan", default=os.path.join(HERE, "fit.toml"))
    parser.add_argument("--scenes", default="scenes")
    parser.add_argument("-o", "--out", help="folder of the databases")
    parser.add_argument("--from", dest="source", metavar="F.csv", help="figures of --csv in place of the databases (table, select)")
    parser.add_argument("--frames", default="main,small,k")
    parser.add_argument("--designs", default="")
    parser.add_argument("--views", default="fit", help="fit, left, all, or names")
    parser.add_argument("--mode", default="cycle", help="of run; of table and select several: a view is of the first that has it")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--csv")
    options = parser.parse_intermixed_args()
    if bool(options.out) == bool(options.source) or (options.what == "run" and options.source):
        refuse("-o DIR, or for table and select --from F.csv")
    options.machines = [" ".join(m.split()) for m in options.machines]
    at = options.plan
    try:
        with open(options.plan, "rb") as file:
            plan = tomllib.load(file)
        for name in ("set", "view", "frame", "today", "freedom"):
            if name not in plan:
                refuse(f"{options.plan}: no table [{name}]")
        at = options.source or options.out
        {"run": run, "table": table, "select": select}[options.what](options, plan)
    except (OSError, ValueError) as error:
        refuse(f"{getattr(error, 'filename', None) or at}: {getattr(error, 'strerror', None) or error}")


if __name__ == "__main__":
    main()
