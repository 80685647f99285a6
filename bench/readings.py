#!/usr/bin/env python3
"""What the paper leaves open, judged on its printed figures; from databases of configs/sweeps/readings.toml and rounds.toml.

    python3 bench/readings.py readings.sqlite [--csv F.csv]
    python3 bench/readings.py --rounds rounds.sqlite rounds_single.sqlite

A reading is the machine of the plan with what a point changes. For each class of scene (public whole scenes, generated
ones, objects) a table: geometric means over its views of the paper's six ratios, of node fetches of grtx on top of sw, the
lowest hit rate of nodes in the L1, and the distance (mean squared log ratio to the paper over the six and all views). Then
each view of the first reading. --rounds: speed-ups over the baseline with k = 8, by k, with a single round, and each design at its best.
"""
import argparse
import csv
import json
import math
import re
import sqlite3
import sys
from collections import defaultdict

PAPER = {"sw": 2.00, "hw": 1.94, "grtx": 4.36, "L2 accesses": 4.75, "latency": 1.77, "node fetches": 3.03, "fetches on sw": 2.37}
SIX = list(PAPER)[:6]
DESIGNS = ("baseline", "sw", "hw", "grtx")
NAMES = {"cycles": "gpu.cycles", "l2": "gpu.l2.accesses", "latency": "gpu.rt.node_fetch_latency",
         "fetches": "gpu.rt.node_fetches", "hits": "gpu.l1.node.hit_rate"}
OBJECTS = {"playbot", "pizza", "logo", "st-peter"}


def class_of(scene):
    if re.search(r"-\d+-\d+$", scene):
        return "generated"
    return "objects" if scene in OBJECTS else "public"


def read(path):
    """[(coordinates without view, scene, view, design, {name: value})] of the points that are done."""
    database = sqlite3.connect(f"file:{path}?mode=ro", uri=True)
    rows = []
    for number, scene, design, coordinates in database.execute("SELECT id, scene, design, coordinates FROM point WHERE status = 'done'"):
        at = json.loads(coordinates)
        values = dict(database.execute(
            f"SELECT name, value FROM value WHERE point_id = ? AND name IN ({','.join('?' * len(NAMES))})", (number, *NAMES.values())))
        lacking = [name for name in NAMES.values() if name not in values]
        if lacking:
            sys.exit(f"readings.py: {path}: point {number} has no {lacking[0]}")
        rows.append((at, scene, at.pop("view", 0), design, {short: values[name] for short, name in NAMES.items()}))
    return rows


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
    return ", ".join(f"`{key}` = {value}" for key, value in at)


def readings(paths, out):
    found, order = defaultdict(dict), []
    for path in paths:
        for at, scene, view, design, values in read(path):
            key = tuple(sorted(at.items()))
            if key not in order:
                order.append(key)
            found[key, scene, view][design] = values
    whole = {key: ratios(of) for key, of in found.items() if all(d in of for d in DESIGNS)}
    if not whole:
        sys.exit("readings.py: no reading is there in all four designs")
    for kind in ("public", "generated", "objects"):
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


def rounds(paths):
    """Speed-ups by k; that of a single round is "single". Designs without checkpoints have no traffic to charge."""
    found = defaultdict(lambda: defaultdict(dict))
    for path in paths:
        for at, scene, view, design, values in read(path):
            traffic = at.get("rt.checkpoint.traffic", "") if design in ("hw", "grtx") else ""
            found[scene, view][design, traffic]["single" if at.get("tracer.tracing") == "single" else at["tracer.k"]] = values["cycles"]
    for kind in ("public", "generated"):
        views = {view: of for view, of in sorted(found.items()) if class_of(view[0]) == kind and 8 in of["baseline", ""]}
        if not views:
            continue
        columns = sorted({k for of in views.values() for ks in of.values() for k in ks}, key=lambda k: (k == "single", k))
        rows = []
        for (scene, view), of in views.items():
            base = of["baseline", ""][8]
            for (design, traffic), ks in sorted(of.items(), key=lambda item: (DESIGNS.index(item[0][0]), item[0][1] == "charged")):
                best = min(ks, key=ks.get)
                rows.append([f"{scene} {view}", f"{design}, {traffic}" if traffic else design] +
                            [(f"**{base / ks[k]:.2f}**" if k == best else f"{base / ks[k]:.2f}") if k in ks else "" for k in columns])
            software = max(base / min(of[d, ""].values()) for d in ("baseline", "sw"))
            for traffic in ("uncharged", "charged"):
                hardware = base / min(of["grtx", traffic].values()) if of.get(("grtx", traffic)) else 0
                if 0 < hardware < software:
                    rows.append([f"{scene} {view}", f"software alone ({software:.2f}) beats grtx with {traffic} traffic ({hardware:.2f}), each at its best"] + [""] * len(columns))
        print(f"{kind}:\n\n" + table(["view", "design", *[f"k = {k}" if k != "single" else "single round" for k in columns]], rows) + "\n")
        print("Geometric means:\n")
        means = []
        for key in sorted({key for of in views.values() for key in of}, key=lambda i: (DESIGNS.index(i[0]), i[1] == "charged")):
            row = []
            for k in columns:
                of = [v["baseline", ""][8] / v[key][k] for v in views.values() if k in v.get(key, {})]
                row.append(f"{math.exp(sum(map(math.log, of)) / len(of)):.2f}" if len(of) == len(views) else "")
            means.append([", ".join(filter(None, key))] + row)
        print(table(["design", *[f"k = {k}" if k != "single" else "single round" for k in columns]], means) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("databases", nargs="+")
    parser.add_argument("--rounds", action="store_true")
    parser.add_argument("--csv", help="all ratios of all views")
    options = parser.parse_args()
    if options.rounds:
        rounds(options.databases)
    else:
        readings(options.databases, options.csv)


if __name__ == "__main__":
    main()
