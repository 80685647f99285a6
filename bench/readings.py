#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What the paper leaves open, judged on its printed figures; from databases of configs/sweeps/readings.toml and those beside it.

    python3 bench/readings.py readings.sqlite readings_more.sqlite [--csv F.csv]
    python3 bench/readings.py --rounds rounds.sqlite rounds_grtx.sqlite
    python3 bench/readings.py --latency readings.sqlite
    python3 bench/readings.py --trends readings.sqlite
    python3 bench/readings.py --parts secondary.sqlite proxies.sqlite

A reading is the machine of the plan with what a point changes. For each class of scene (public whole scenes, generated
ones, objects) a table: geometric means over its views of the paper's six ratios, of node fetches of grtx on top of sw, the
lowest hit rate of nodes in the L1, and the distance (mean squared log ratio to the paper over the six and all views). Then
each view of the first reading.
--rounds: speed-ups over the baseline with k = 8, by k, with a single round, and each design at its best.
--latency: why node fetches take what they take, and the paper's ratio under other definitions of it.
--trends: by which statistic of a view the gains of sw and hw differ, as rank correlations.
--parts: speed-ups by structure, and of primary and secondary rays.
"""
import argparse
import csv
import json
import math
import re
import sys
from collections import defaultdict

from sweep_database import open_plan

PAPER = {"sw": 2.00, "hw": 1.94, "grtx": 4.36, "L2 accesses": 4.75, "latency": 1.77, "node fetches": 3.03, "fetches on sw": 2.37}
SIX = list(PAPER)[:6]
DESIGNS = ("baseline", "sw", "hw", "grtx")
L1_LATENCY = 20  # cycles, of all machines of the plans
NAMES = {"cycles": "gpu.cycles", "l2": "gpu.l2.accesses", "latency": "gpu.rt.node_fetch_latency",
         "fetches": "gpu.rt.node_fetches", "hits": "gpu.l1.node.hit_rate"}
OBJECTS = {"playbot", "pizza", "logo", "st-peter"}


def class_of(scene):
    if re.search(r"-\d+-\d+$", scene):
        return "generated"
    if scene in OBJECTS:
        return "objects"
    near = re.search(r"-(full|small|256)$", scene)
    return f"public, {near[1]}" if near else "public"


def read(path, mode):
    """[(coordinates without view, scene, view, design, {name: value})] of the points of that mode that are done."""
    database = open_plan(path)
    rows = []
    # A view that the plan does not vary is in the options of the trace alone.
    for number, scene, design, coordinates, view in database.execute(
            "SELECT id, of_plan.scene, design, coordinates, json_extract(options, '$.view') FROM of_plan "
            "LEFT JOIN trace ON trace.key = trace_key WHERE of_plan.status = 'done' AND mode = ?", (mode,)):
        at = json.loads(coordinates)
        values = defaultdict(float, database.execute("SELECT name, value FROM value WHERE point_id = ? AND name LIKE 'gpu.%'", (number,)))
        for short, name in NAMES.items():
            if name not in values:
                sys.exit(f"readings.py: {path}: point {number} has no {name}")
            values[short] = values[name]
        rows.append((at, scene, at.pop("view", view or 0), design, values))
    return rows


def by_reading(paths, mode):
    """{(coordinates, scene, view): {design: values}}, and the coordinates in the order of the plan."""
    found, order = defaultdict(dict), []
    for path in paths:
        for at, scene, view, design, values in read(path, mode):
            key = tuple(sorted(at.items()))
            if key not in order:
                order.append(key)
            found[key, scene, view][design] = values
    return found, order


def ratios(of):
    base, grtx = of["baseline"], of["grtx"]
    speed = {d: base["cycles"] / of[d]["cycles"] for d in DESIGNS[1:]}
    return {**speed, "L2 accesses": base["l2"] / grtx["l2"], "latency": base["latency"] / grtx["latency"],
            "node fetches": base["fetches"] / grtx["fetches"], "fetches on sw": of["sw"]["fetches"] / grtx["fetches"],
            "hits": min(of["sw"]["hits"], grtx["hits"])}


def mean(rows, name):
    return math.exp(sum(math.log(row[name]) for row in rows) / len(rows))


def distance(rows):
    return sum(math.log(row[name] / PAPER[name]) ** 2 for row in rows for name in SIX) / (len(rows) * len(SIX))


def table(header, rows):
    return "\n".join(["| " + " | ".join(header) + " |", "|" + "---|" * len(header)] + ["| " + " | ".join(map(str, row)) + " |" for row in rows])


def label(at):
    return ", ".join(f"`{key}` = {value}" for key, value in at) or "as the machine is"


def readings(paths, mode, out):
    found, order = by_reading(paths, mode)
    whole = {key: ratios(of) for key, of in found.items() if all(d in of for d in DESIGNS)}
    if not whole:
        sys.exit("readings.py: no reading is there in all four designs")
    for kind in sorted({class_of(key[1]) for key in whole}, key=lambda k: (k.startswith("objects"), k.startswith("generated"), k)):
        views = sorted({key[1:] for key in whole if class_of(key[1]) == kind})
        rows = []
        for reading in order:
            of = [whole[reading, *view] for view in views if (reading, *view) in whole]
            if of:
                note = "" if len(of) == len(views) else f" ({len(of)} views)"
                rows.append([label(reading) + note] + [f"{mean(of, n):.2f}" for n in PAPER] +
                            [f"{100 * min(r['hits'] for r in of):.0f} %", f"{distance(of):.3f}"])
        if rows:
            paper = ["*the paper*"] + [f"*{v:.2f}*" for v in PAPER.values()] + ["*70 %*", ""]
            print(f"{kind}, {len(views)} views:\n\n" + table(["reading", *PAPER, "least L1 hits", "distance"], [paper] + rows) + "\n")
    first = order[0]
    print(f"Each view, {label(first)}:\n")
    print(table(["view", *PAPER, "least L1 hits"], [[f"{scene} {view}"] + [f"{row[n]:.2f}" for n in PAPER] + [f"{100 * row['hits']:.0f} %"]
                                                    for (reading, scene, view), row in sorted(whole.items()) if reading == first]))
    if out:
        with open(out, "w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(["reading", "scene", "view", *PAPER, "least L1 hits"])
            for (reading, scene, view), row in sorted(whole.items(), key=str):
                writer.writerow([label(reading), scene, view] + [f"{row[n]:.4f}" for n in (*PAPER, "hits")])


def parts_of(v):
    """Of a run: what a node fetch takes, where, and by other definitions of its latency; cycles."""
    reads, misses = v["gpu.l1.node.reads"], v["gpu.l1.node.reads"] - v["gpu.l1.node.hits"]
    units = v["gpu.rt.occupancy_integral"] / v["gpu.rt.occupancy"] / v["cycles"]
    busy = sum(v[f"gpu.rt.warp_cycles.{w}"] for w in ("ready", "memory", "checkpoint", "stack", "unit", "any_hit", "retire"))
    return {"latency": v["latency"], "fetches under way": v["fetches"] * v["latency"] / v["cycles"] / units,
            "fetches a 1,000 cycles": 1000 * v["fetches"] / v["cycles"] / units,
            "port busy": v["gpu.rt.node_sectors"] / v["cycles"] / units, "queue full": v["gpu.rt.stall.queue_full"] / v["cycles"] / units,
            "warps ready": v["gpu.rt.warp_cycles.ready"] / busy,
            "a sector, hits and misses": L1_LATENCY + misses / reads * v["gpu.l1.miss_latency"], "a miss of the L1": L1_LATENCY + v["gpu.l1.miss_latency"]}


def latency(paths, mode):
    """Mean latency = fetches under way / fetches a cycle (Little). So its ratio is how much more quickly fetches come, speed-up ÷
    fewer fetches, times how many more of the baseline's are under way. Each reading."""
    found, order = by_reading(paths, mode)
    shown = {"latency": "{:.0f}", "fetches under way": "{:.0f}", "fetches a 1,000 cycles": "{:.0f}", "port busy": "{:.0%}", "queue full": "{:.0%}",
             "warps ready": "{:.0%}", "a sector, hits and misses": "{:.0f}", "a miss of the L1": "{:.0f}"}
    for reading in order:
        rows, ratio = [], defaultdict(list)
        for (at, scene, view), of in sorted(found.items(), key=str):
            if at != reading or not {"baseline", "grtx"} <= set(of):
                continue
            parts = {d: parts_of(of[d]) for d in DESIGNS if d in of}
            rows += [[f"{scene} {view}", d] + [text.format(part[name]) for name, text in shown.items()] + [f"{100 * of[d]['hits']:.0f} %"] for d, part in parts.items()]
            base, grtx = parts["baseline"], parts["grtx"]
            ratio[class_of(scene)].append([base[n] / grtx[n] for n in ("latency", "fetches under way")] + [grtx["fetches a 1,000 cycles"] / base["fetches a 1,000 cycles"]] +
                                          [base[n] / grtx[n] for n in ("a sector, hits and misses", "a miss of the L1")])
        if rows:
            print(f"{label(reading)}\n\n" + table(["view", "design", *shown, "L1 hits"], rows) + "\n")
            print("Baseline over grtx, geometric means; the paper has 1.77, which is 4.36 / 3.03 = 1.44 times 1.23:\n")
            print(table(["views", "latency", "= fetches under way", "x speed-up ÷ fewer fetches", "a sector, hits and misses", "a miss of the L1"],
                        [[f"{kind}, {len(of)}"] + [f"{geometric(x):.2f}" for x in zip(*of)] for kind, of in sorted(ratio.items())]) + "\n")


def geometric(values):
    return math.exp(sum(map(math.log, values)) / len(values))


def rank_correlation(x, y):
    """Spearman's, of values without ties."""
    rank = lambda values: [sorted(values).index(v) for v in values]
    n = len(x)
    return 1 - 6 * sum((a - b) ** 2 for a, b in zip(rank(x), rank(y))) / (n * (n * n - 1))


def trends(paths, mode):
    """Of the first reading: statistics of the baseline beside the gains of sw and hw, view by view."""
    found, order = by_reading(paths, mode)
    of_baseline = {"leaves of the fetches": lambda v: v["gpu.rt.node_fetches.leaf"] / v["fetches"],
                   "visits a hit": lambda v: v["gpu.rt.node_visits"] / v["gpu.rt.any_hit_calls"],
                   "L1 hits": lambda v: v["hits"]}
    rows = [(scene, view, [f(of["baseline"]) for f in of_baseline.values()], ratios(of))
            for (at, scene, view), of in sorted(found.items(), key=str) if at == order[0] and all(d in of for d in DESIGNS)]
    print(table(["view", *of_baseline, "sw", "hw", "fetches ÷, sw"],
                [[f"{scene} {view}"] + [f"{x:.3f}" for x in at] + [f"{r['sw']:.2f}", f"{r['hw']:.2f}", f"{r['node fetches'] / r['fetches on sw']:.2f}"]
                 for scene, view, at, r in rows]) + "\n")
    for kind in sorted({class_of(row[0]) for row in rows} | {"all but objects"}):
        some = [row for row in rows if class_of(row[0]) == kind or (kind == "all but objects" and class_of(row[0]) != "objects")]
        for i, name in enumerate(of_baseline):
            if len(some) >= 5:
                print(f"{kind}, {len(some)} views, rank correlation of {name}: " +
                      ", ".join(f"{rank_correlation([r[2][i] for r in some], [r[3][d] for r in some]):+.2f} with {d}" for d in ("sw", "hw")))


def parts(paths, mode):
    """Speed-ups over the baseline of the same coordinates, whole, primary and secondary; structures over tri20."""
    found, order = by_reading(paths, mode)
    accels = defaultdict(dict)
    for (at, scene, view), of in found.items():
        if "tracer.accel" in dict(at):
            accels[scene, view][dict(at)["tracer.accel"]] = next(iter(of.values()))
    if accels:
        names = sorted({a for of in accels.values() for a in of})
        print(table(["view", *names], [[f"{s} {v}"] + [f"{of['tri20']['cycles'] / of[a]['cycles']:.2f}" for a in names] for (s, v), of in sorted(accels.items())]) + "\n")
    for reading in order:
        rows, means = [], defaultdict(list)
        for (at, scene, view), of in sorted(found.items(), key=str):
            if at != reading or not all(d in of for d in DESIGNS):
                continue
            for rays, name in (("all", "gpu.cycles"), ("primary", "gpu.rays.primary_cycles"), ("secondary", "gpu.rays.secondary_cycles")):
                if of["baseline"][name]:
                    speed = [of["baseline"][name] / of[d][name] for d in DESIGNS[1:]]
                    rows.append([f"{scene} {view}", rays] + [f"{x:.2f}" for x in speed])
                    means[class_of(scene), rays].append(speed)
        if rows:
            rows += [[f"*mean, {kind}*", rays] + [f"*{geometric(x):.2f}*" for x in zip(*of)] for (kind, rays), of in means.items()]
            print(f"{label(reading)}\n\n" + table(["view", "rays", *DESIGNS[1:]], rows) + "\n")


def rounds(paths, mode):
    """Speed-ups by k; that of a single round is "single". Designs without checkpoints have no traffic to charge."""
    found = defaultdict(lambda: defaultdict(dict))
    for path in paths:
        for at, scene, view, design, values in read(path, mode):
            traffic = at.get("rt.checkpoint.traffic", "") if design in ("hw", "grtx") else ""
            found[scene, view][design, traffic]["single" if at.get("tracer.tracing") == "single" else at["tracer.k"]] = values["cycles"]
    column = lambda k: f"k = {k}" if k != "single" else "single round"
    order = lambda key: (DESIGNS.index(key[0]), key[1] == "charged")
    for kind in sorted({class_of(scene) for scene, _ in found}, reverse=True):
        whole = [view for view in found if 8 in found[view]["baseline", ""]]
        unit = "baseline" if whole else "sw"  # ratios of sw and grtx need no baseline
        views = {view: of for view, of in sorted(found.items()) if class_of(view[0]) == kind and 8 in of[unit, ""]}
        if not views:
            continue
        columns = sorted({k for of in views.values() for ks in of.values() for k in ks}, key=lambda k: (k == "single", k))
        speed = {view: {key: {k: of[unit, ""][8] / cycles for k, cycles in ks.items()} for key, ks in of.items() if ks} for view, of in views.items()}
        rows = [[f"{scene} {view}", ", ".join(filter(None, key))] +
                [(f"**{ks[k]:.2f}**" if ks[k] == max(ks.values()) else f"{ks[k]:.2f}") if k in ks else "" for k in columns]
                for (scene, view), of in speed.items() for key, ks in sorted(of.items(), key=lambda item: order(item[0]))]
        for key in sorted({key for of in speed.values() for key in of}, key=order):
            of = [[ks[key][k] for ks in speed.values() if k in ks.get(key, {})] for k in columns]
            rows.append(["*mean*", ", ".join(filter(None, key))] + [f"*{geometric(one):.2f}*" if len(one) == len(views) else "" for one in of])
        print(f"{kind}, {len(views)} views, speed-up over {unit} with k = 8:\n\n" + table(["view", "design", *map(column, columns)], rows) + "\n")
        best = {view: {key: max((x, str(k)) for k, x in ks.items()) for key, ks in of.items()} for view, of in speed.items()}
        keys = [("baseline", ""), ("sw", ""), ("grtx", "uncharged"), ("grtx", "charged")]
        rows, shares = [], defaultdict(list)
        for (scene, view), of in best.items():
            software = max(of[key] for key in keys[:2] if key in of)
            for key in keys[2:]:
                if key in of:
                    shares[key].append(software[0] / of[key][0])
            rows.append([f"{scene} {view}"] + [f"{of[key][0]:.2f} ({of[key][1]})" if key in of else "" for key in keys] +
                        [f"{software[0] / of[key][0]:.2f}" if key in of else "" for key in keys[2:]])
        if len(shares) == 2:
            rows.append(["*mean*"] + [f"*{geometric([of[key][0] for of in best.values()]):.2f}*" if all(key in of for of in best.values()) else "" for key in keys] +
                        [f"*{geometric(shares[key]):.2f}*" for key in keys[2:]])
        print("Each at its best (k):\n\n" + table(["view", *[", ".join(filter(None, key)) for key in keys], "software alone ÷ grtx, uncharged", "÷ grtx, charged"], rows) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("databases", nargs="+")
    for what in (rounds, latency, trends, parts):
        parser.add_argument(f"--{what.__name__}", dest="what", action="store_const", const=what)
    parser.add_argument("--mode", default="sampled", help="of the points (default: %(default)s)")
    parser.add_argument("--csv", help="all ratios of all views")
    options = parser.parse_args()
    if options.what:
        options.what(options.databases, options.mode)
    else:
        readings(options.databases, options.mode, options.csv)


if __name__ == "__main__":
    main()
