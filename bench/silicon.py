#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Structures and checkpoints on shipped cards, from databases of configs/sweeps/silicon*.toml.

    python3 bench/silicon.py structures ada.sqlite blackwell.sqlite ... [--chart data/measured/rtx-6000-ada.csv]
    python3 bench/silicon.py checkpoints ada-c.sqlite ...
    python3 bench/silicon.py spheres blackwell-128.sqlite

structures: a row a structure and kernel degree, the speed over monolithic icosahedra of the same degree in each view, its
geometric mean, and the chart's mean and range where --chart has the structure. checkpoints: a row a view, the speed of
every way over the fastest rounds without checkpoints, and means. spheres: cycles of 80 triangles over those of a sphere, by its interval.
Exit code 1 when a database has no point to compare.
"""
import argparse
import csv
import os
import sys
from statistics import geometric_mean as mean

from sweep_database import points

NAMES = {"tlas-tri20": "shared icosahedron", "tlas-tri80": "shared, 80 triangles", "tlas-box": "shared box, shader",
         "tlas-sphere": "shared sphere"}


def read(path):
    """[(view, coordinates, cycles)] of the points that are done."""
    return [(point["scene"], point["at"], point["values"]["gpu.cycles"]) for point in points(path, "gpu.cycles")]


def row(cells):
    print("| " + " | ".join(cells) + " |")


def head(cells):
    row(cells)
    row(["---"] * len(cells))


def chart(path):
    """{(structure, degree): (mean, least, largest)} of a file of measured speeds over monolithic icosahedra."""
    found = {}
    with open(path, encoding="utf-8") as file:
        for line in csv.DictReader(line for line in file if not line.startswith("#")):
            found.setdefault((line["design"], int(line["tracer.kernel_degree"])), []).append(float(line["value"]))
    return {key: (mean(values), min(values), max(values)) for key, values in found.items()}


def structures(paths, measured):
    done = 0
    for path in paths:
        cycles = {(at["tracer.kernel_degree"], at["tracer.accel"], scene): value for scene, at, value in read(path)
                  if not any(key.startswith("rt.") for key in at)}
        views = list(dict.fromkeys(scene for _, _, scene in cycles))
        head([os.path.splitext(os.path.basename(path))[0], "degree", *views, "mean", "chart", "inside"])
        for accel, name in NAMES.items():
            for degree in (2, 4):
                ratios = [cycles[degree, "tri20", view] / cycles[degree, accel, view]
                          if (degree, "tri20", view) in cycles and (degree, accel, view) in cycles else None for view in views]
                if None in ratios:
                    continue
                done += 1
                shown = ["", ""]
                if (accel, degree) in measured:
                    middle, least, largest = measured[accel, degree]
                    single = least == largest
                    shown = [f"{middle:.2f}" if single else f"{middle:.2f} ({least:.2f} to {largest:.2f})",
                             "" if single else "yes" if least <= mean(ratios) <= largest else "no"]
                row([name, str(degree), *(f"{ratio:.2f}" for ratio in ratios), f"**{mean(ratios):.2f}**", *shown])
        print()
    return done


def way(at):
    """What a point of silicon_checkpoints.toml is called, and whether it has checkpoints."""
    structure = {"tri20": "one level", "tlas-tri20": "sw", "tlas-box": "boxes"}[at["tracer.accel"]]
    if "simt.cost.intersection_fixed" in at:
        structure += ", dear shader"
    if at.get("tracer.tracing") == "list":
        return f"{structure}, list", False
    if at["tracer.checkpoint"] == "off":
        return f"{structure}, k = {at['tracer.k']}", False
    return f"{'lean' if 'tracer.checkpoint_bins' in at else 'grtx'}, k = {at['tracer.k']}", True


def checkpoints(paths):
    done = 0
    for path in paths:
        found = {}
        for scene, at, cycles in read(path):
            name, has = way(at)
            found.setdefault(scene, {})[name] = (cycles, has)
        names = list(dict.fromkeys(name for ways in found.values() for name in ways))
        rounds = [name for name in names if not name.endswith("list")]
        gains = {}
        head([os.path.splitext(os.path.basename(path))[0], *names, "best of grtx, lean ÷ best rounds without"])
        for scene, ways in found.items():
            if len(ways) < len(names):
                continue
            done += 1
            best = min(ways[name][0] for name in rounds if not ways[name][1])
            best_of = [best / min(ways[name][0] for name in rounds if name.startswith(kind)) for kind in ("grtx", "lean")]
            speeds = [best / ways[name][0] for name in names]
            gains.setdefault(scene.endswith("-full"), []).append(speeds + best_of)
            row([scene, *(f"{speed:.2f}" for speed in speeds), ", ".join(f"{gain:.2f}" for gain in best_of)])
        for full, views in gains.items():
            *speeds, grtx, lean = zip(*views)
            row(["**mean**, " + ("full frames" if full else "128 x 128"), *(f"{mean(of):.2f}" for of in speeds),
                 ", ".join(f"**{mean(of):.2f}** ({min(of):.2f} to {max(of):.2f})" for of in (grtx, lean))])
        print()
    return done


def spheres(paths):
    done = 0
    for path in paths:
        found = {}
        for scene, at, cycles in read(path):
            if at["tracer.kernel_degree"] == 2 and at["tracer.accel"] in ("tlas-tri80", "tlas-sphere"):
                found.setdefault(scene, {})[at["tracer.accel"], at.get("rt.sphere.interval")] = cycles
        intervals = sorted({interval for ways in found.values() for _, interval in ways if interval})
        head([os.path.splitext(os.path.basename(path))[0], *(f"a sphere in {interval}" for interval in intervals)])
        for scene, ways in found.items():
            if all(("tlas-sphere", interval) in ways for interval in intervals) and ("tlas-tri80", None) in ways and intervals:
                done += 1
                row([scene, *(f"{ways['tlas-tri80', None] / ways['tlas-sphere', interval]:.2f}" for interval in intervals)])
        print()
    return done


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("table", choices=["structures", "checkpoints", "spheres"])
    parser.add_argument("databases", nargs="+")
    parser.add_argument("--chart", help="measured speeds over monolithic icosahedra")
    arguments = parser.parse_args()
    if arguments.table == "structures":
        done = structures(arguments.databases, chart(arguments.chart) if arguments.chart else {})
    else:
        done = (checkpoints if arguments.table == "checkpoints" else spheres)(arguments.databases)
    return 0 if done else 1


if __name__ == "__main__":
    sys.exit(main())
