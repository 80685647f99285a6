#!/usr/bin/env python3
"""Readings of the paper against its six ratios, from the databases of configs/sweeps/readings*.toml.

    python3 bench/readings.py readings.sqlite readings_write_back.sqlite [--csv F.csv]

Prints a table of all readings in the order of their distance to the paper (mean squared log ratio over the six ratios
and all scenes), then the best reading scene by scene, the steps from the first reading to it, and what one more change would do.
"""
import argparse
import csv
import json
import math
import sqlite3
import sys

PAPER = {"sw": 2.00, "hw": 1.94, "grtx": 4.36, "L2 accesses": 4.75, "latency": 1.77, "node fetches": 3.03}
AXES = ("order", "pop test", "private writes", "ports")
FIRST = ("near_first", "on", "write_through", 1)
DESIGNS = ("baseline", "sw", "hw", "grtx")
NAMES = {"cycles": "gpu.cycles", "l2": "gpu.l2.accesses", "latency": "gpu.rt.node_fetch_latency",
         "fetches": "gpu.rt.node_fetches"}


def read(path):
    """{(reading, scene): {design: {name: value}}} of the points that are done."""
    database = sqlite3.connect(path)
    found = {}
    for number, scene, design, coordinates, config in database.execute(
            "SELECT id, scene, design, coordinates, config FROM point WHERE status = 'done'"):
        at, machine = json.loads(coordinates), json.loads(config)
        reading = (at["tracer.child_order"], at["tracer.pop_test"], machine["l1.private_writes"],
                   machine["rt.memory.sectors_per_cycle"])
        values = dict(database.execute(
            f"SELECT name, value FROM value WHERE point_id = ? AND name IN ({','.join('?' * len(NAMES))})",
            (number, *NAMES.values())))
        found.setdefault((reading, scene), {})[design] = {k: values[n] for k, n in NAMES.items()}
    return found


def ratios(designs):
    base, grtx = designs["baseline"], designs["grtx"]
    speed = {d: base["cycles"] / designs[d]["cycles"] for d in DESIGNS[1:]}
    return {**speed, "L2 accesses": base["l2"] / grtx["l2"], "latency": base["latency"] / grtx["latency"],
            "node fetches": base["fetches"] / grtx["fetches"]}


def distance(rows):
    """Mean squared log ratio to the paper."""
    logs = [math.log(row[name] / PAPER[name]) ** 2 for row in rows for name in PAPER]
    return sum(logs) / len(logs)


def geometric_mean(rows, name):
    return math.exp(sum(math.log(row[name]) for row in rows) / len(rows))


def steps_to(best, table):
    """From FIRST to `best`, each time the axis whose change brings most."""
    reading, path = FIRST, [("first reading", FIRST)]
    while reading != best:
        options = [tuple(best[j] if j == i else reading[j] for j in range(len(AXES)))
                   for i in range(len(AXES)) if reading[i] != best[i]]
        following = min(options, key=lambda r: distance(table[r]))
        changed = next(i for i in range(len(AXES)) if following[i] != reading[i])
        path.append((f"{AXES[changed]}: {following[changed]}", following))
        reading = following
    return path


def other_steps(best, table):
    """The best reading with one axis at another value, each: (label, reading)."""
    steps = []
    for i, axis in enumerate(AXES):
        for value in sorted({r[i] for r in table} - {best[i]}, key=str):
            reading = best[:i] + (value,) + best[i + 1:]
            if reading in table:
                steps.append((f"{axis}: {value}", reading))
    return steps


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("databases", nargs="+")
    parser.add_argument("--csv", help="all ratios of all scenes")
    options = parser.parse_args()
    by_scene = {}
    for path in options.databases:
        by_scene.update(read(path))
    whole = {key: ratios(d) for key, d in by_scene.items() if all(n in d for n in DESIGNS)}
    if not whole:
        sys.exit("readings: no reading is complete")
    scenes = sorted({scene for _, scene in whole})
    table = {}
    for (reading, scene), row in whole.items():
        table.setdefault(reading, {})[scene] = row
    table = {r: [rows[s] for s in scenes] for r, rows in table.items() if set(rows) == set(scenes)}

    head = list(AXES) + list(PAPER) + ["distance"]
    print("| " + " | ".join(head) + " |\n|" + "---|" * len(head))
    print("| *paper* | | | | " + " | ".join(f"*{v:.2f}*" for v in PAPER.values()) + " | |")
    ranked = sorted(table, key=lambda r: distance(table[r]))
    for reading in ranked:
        cells = [str(v) for v in reading] + [f"{geometric_mean(table[reading], n):.2f}" for n in PAPER]
        print("| " + " | ".join(cells) + f" | {distance(table[reading]):.4f} |")
    best = ranked[0]
    print(f"\nBest reading: {', '.join(map(str, best))}\n\n| scene | " + " | ".join(PAPER) + " |\n|" +
          "---|" * (len(PAPER) + 1))
    for scene, row in zip(scenes, table[best]):
        print(f"| {scene} | " + " | ".join(f"{row[n]:.2f}" for n in PAPER) + " |")
    if FIRST in table:
        path = steps_to(best, table)
        print("\nSteps: " + "; ".join(f"{label} {distance(table[r]):.4f}" for label, r in path))
        print("One more: " + "; ".join(f"{label} {distance(table[r]):.4f}" for label, r in other_steps(best, table)))
    if options.csv:
        with open(options.csv, "w", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(list(AXES) + ["scene"] + list(PAPER))
            for (reading, scene), row in sorted(whole.items(), key=str):
                writer.writerow(list(reading) + [scene] + [f"{row[n]:.4f}" for n in PAPER])


if __name__ == "__main__":
    main()
