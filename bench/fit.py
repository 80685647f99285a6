#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Fits what the paper leaves open of machine `paper` to its printed figures (bench/fit.toml: views, frames, freedoms).

    python3 bench/fit.py run PROGRAM --scenes DIR -o DIR "queue" "queue port" [--frames main,small] [--views fit] [--mode cycle]
    python3 bench/fit.py table -o DIR [--csv F.csv]
    python3 bench/fit.py select -o DIR

A machine is `paper` with what fit.toml has as today, and some freedoms, by name; "" is without any. run: what is missing, by `grtx sweep`, one database a frame and
kind of design; those without checkpoints do not meet rt.checkpoint keys, so machines share them. table: each machine's figures, over the views that the
search sees, over the others, and how many are within 20 %. select: forward selection, all views and with one scene left out.
"""
import argparse
import csv
import json
import math
import os
import subprocess
import sqlite3
import sys
import tomllib
from collections import defaultdict

HERE = os.path.dirname(os.path.abspath(__file__))
HOLDS = 0.20
# Printed figures that a machine decides; the others are of scenes (bytes, height, footprint, buffers) or a sum (storage).
PAPER = {"sw": 2.00, "hw": 1.94, "grtx": 4.36, "grtx over the better": 2.18, "node fetches": 3.03, "fetches on sw": 2.37, "latency": 1.77,
         "L2 accesses": 4.75, "L1 hits, sw": 0.70, "L1 hits, grtx on sw": 1.0, "best k, baseline": 16, "best k, grtx": 8, "small field, sw": 1.43,
         "small field, hw": 1.94, "sw by field": 0.715, "hw by field": 1.0, "hw, secondary on primary": 1.0, "sw by shader": 2.43}
BOUNDS = {"L1 hits, sw"}  # the paper prints a lower bound
WITH_CHECKPOINTS, WITH_INSTANCES = {"hw", "grtx"}, {"sw", "grtx"}
OF_INSTANCES = {"rt.memory.blas_header_read", "rt.memory.instance_leaf_bytes"}


def keys_of(plan, machine):
    keys = dict(plan["today"])
    for name in machine.split():
        if name not in plan["freedom"]:
            sys.exit(f"fit.py: no freedom {name}; there are {', '.join(plan['freedom'])}")
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
    views = {n: v for n, v in plan["view"].items() if options.views in ("all", "fit" if v["fit"] else "left") or n in options.views.split(",")}
    for name in options.frames.split(","):
        frame = plan["frame"][name]
        for design, varied in frame["designs"].items():
            if options.designs and design not in options.designs.split(","):
                continue
            path = os.path.join(options.out, f"{name}-{design}.toml")
            with open(path, "w", encoding="utf-8") as file:
                file.write(plan_text(plan, frame, design, varied, options.machines or [""], views, os.path.abspath(options.scenes)))
            subprocess.run([options.program, "sweep", path, "-o", path[:-5] + ".sqlite", "--machine", "paper", "--mode", options.mode,
                            "--jobs", str(options.jobs), "--retry", "--quiet"], check=False)


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
            database = sqlite3.connect(f"file:{path}?mode=ro", uri=True)
            for number, view, config, tracer in database.execute(
                    "SELECT id, point.scene, config, json_extract(options, '$.tracer') FROM point JOIN trace ON trace.key = trace_key "
                    "WHERE point.status = 'done' AND mode = ?", (mode,)):
                config, tracer = json.loads(config), json.loads(tracer)
                option = {"k": tracer["k"], "secondary": tracer["secondary"], "shader": config["rt.memory.by_shader"]}.get(name)
                values = database.execute("SELECT name, value FROM value WHERE point_id = ? AND name LIKE 'gpu.%'", (number,))
                table[name, design, view, str(option), address({k: config[k] for k in plan["today"]}, design)] = dict(values)
            database.close()

    def of(machine, view, frame, design, option=None):
        return table.get((frame, design, view, str(option), address(keys_of(plan, machine), design)))
    return of


def figures(of, machine, view):
    """The figures that there are points for."""
    at = {d: of(machine, view, "main", d) for d in ("baseline", "sw", "hw", "grtx")}
    if not all(at.values()):
        return {}  # means are over the same views for all figures of the main frame
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


def geometric(values):
    return math.exp(sum(map(math.log, values)) / len(values))


def means(by_view, views):
    names = {n for v in views for n in by_view.get(v, {})}
    return {n: geometric([by_view[v][n] for v in views if n in by_view.get(v, {})]) for n in names}


def holds(name, value):
    return value >= PAPER[name] if name in BOUNDS else abs(value / PAPER[name] - 1) <= HOLDS


def objective(mean, names):
    """Figures outside plus the mean squared log ratio. names: that all machines have."""
    outside = sum(not holds(n, mean[n]) for n in names)
    apart = [0 if n in BOUNDS and holds(n, mean[n]) else math.log(mean[n] / PAPER[n]) ** 2 for n in names]
    return outside + sum(apart) / len(names), outside


def machines_of(plan, out):
    """All that were run, by name, `paper` first."""
    with open(os.path.join(out, "machines.json"), encoding="utf-8") as file:
        return json.load(file)


def note_machines(options):
    path = os.path.join(options.out, "machines.json")
    known = json.load(open(path, encoding="utf-8")) if os.path.exists(path) else [""]
    known += [m for m in options.machines if m not in known]
    with open(path, "w", encoding="utf-8") as file:
        json.dump(known, file)


def table(options, plan):
    of = read(plan, options.out, options.mode)
    views = {"fit": [n for n, v in plan["view"].items() if v["fit"]], "left out": [n for n, v in plan["view"].items() if not v["fit"]]}
    rows = []
    for machine in machines_of(plan, options.out):
        by_view = {v: figures(of, machine, v) for v in plan["view"]}
        for side, names in views.items():
            mean = means(by_view, names)
            have = [n for n in PAPER if n in mean]
            if have:
                value, outside = objective(mean, have)
                print(f"{machine or 'paper'} ({side}, {sum('grtx' in by_view[v] for v in names)} views): {len(have) - outside} of {len(have)} hold, objective {value:.3f}")
                print("   " + "; ".join(f"{n} {mean[n]:.2f}{'' if holds(n, mean[n]) else ' X'}" for n in have) + " | " + "; ".join(f"{n} {mean[n]:.2f}" for n in sorted(mean) if n not in PAPER))
        rows += [[machine or "paper", v, n, f"{x:.4f}"] for v, f in by_view.items() for n, x in f.items()]
    if options.csv:
        with open(options.csv, "w", newline="", encoding="utf-8") as file:
            csv.writer(file).writerows([["machine", "view", "figure", "value"], *rows])


def select(options, plan):
    """Forward: from `paper` the freedom that lowers the objective most, until none lowers the number of figures outside. With all views that the
    search sees, and with each scene left out, on which the choice is then judged. A step is taken among the machines that were run."""
    of = read(plan, options.out, options.mode)
    known = {frozenset(m.split()): m for m in machines_of(plan, options.out)}
    by_view = {key: {v: figures(of, m, v) for v in plan["view"]} for key, m in known.items()}
    seen = [n for n, v in plan["view"].items() if v["fit"]]

    def judge(key, views):
        mean = means(by_view[key], [v for v in views if "grtx" in by_view[key][v]])
        return objective(mean, [n for n in PAPER if n in mean]) if "grtx" in mean else None

    def forward(views):
        at = frozenset()
        path = [(at, *judge(at, views))]
        while True:
            steps = [(key, judge(key, views)) for key in known if len(key) == len(at) + 1 and at < key]
            steps = [(key, *value) for key, value in steps if value]
            best = min(steps, key=lambda s: s[1], default=None)
            if not best or best[2] >= path[-1][2] and best[1] >= path[-1][1] - 0.005:
                return path
            path.append(best)
            at = best[0]

    for left in [None, *sorted({v.rsplit("-", 1)[0] for v in seen if "grtx" in by_view[frozenset()][v]})]:
        views = [v for v in seen if v.rsplit("-", 1)[0] != left]
        path = forward(views)
        print(f"without {left}:" if left else "all views that the search sees:")
        for key, value, outside in path:
            print(f"    {' '.join(sorted(key)) or 'paper'}: {outside} outside, objective {value:.3f}")
        out = [v for v in seen if v not in views]
        if any("grtx" in by_view[path[-1][0]][v] and "grtx" in by_view[frozenset()][v] for v in out):
            on = [judge(key, out) for key in (frozenset(), path[-1][0])]
            print(f"    on {left}: paper {on[0][1]} outside, {on[0][0]:.3f}; chosen {on[1][1]}, {on[1][0]:.3f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["run", "table", "select"])
    parser.add_argument("machines", nargs="*", help="names of freedoms, in one text a machine")
    parser.add_argument("--program", default="grtx")
    parser.add_argument("--plan", default=os.path.join(HERE, "fit.toml"))
    parser.add_argument("--scenes", default="scenes")
    parser.add_argument("-o", "--out", required=True)
    parser.add_argument("--frames", default="main,small,k")
    parser.add_argument("--designs", default="")
    parser.add_argument("--views", default="fit", help="fit, left, all, or names")
    parser.add_argument("--mode", default="sampled")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--csv")
    options = parser.parse_intermixed_args()
    with open(options.plan, "rb") as file:
        plan = tomllib.load(file)
    if options.what == "run":
        os.makedirs(options.out, exist_ok=True)
        note_machines(options)
        run(options, plan)
    else:
        {"table": table, "select": select}[options.what](options, plan)


if __name__ == "__main__":
    main()
