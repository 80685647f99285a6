#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Who wins: the proposals of both papers and what lies between them, from a database of configs/sweeps/rivals.toml or
of beyond.toml.

    python3 bench/rivals.py rivals.sqlite [--over DESIGN] [--binds]

A row a design and k, a column a view: speed over the baseline, or the design that --over names, with the better k of that
view (cycles of that over cycles of this); then the geometric mean over rooms and over objects, the silicon of an RT unit and of the chip, and the energy of
a ray over that of the baseline with the better k. Rows and columns that are not done are left out. --binds: what each
design waits for on each view, the largest lower bound over its cycles.
Exit code 1 when nothing can be compared.
"""
import argparse
import json
import math
import sys

from sweep_database import open_plan

BOUNDS = ("dram_bandwidth", "l2_port", "l1_miss_port", "l1_port", "rt_port", "simt_issue", "unit.box", "unit.gaussian", "longest_warp")
STATISTICS = ("gpu.cycles", "gpu.energy_nj_per_ray", "cost.rt_unit_mm2", "cost.mm2", *(f"gpu.bound.{bound}" for bound in BOUNDS))
OBJECTS = ("playbot", "pizza", "logo", "st-peter", "object")
STRUCTURES = {("tri20", "off"): "baseline", ("tlas-tri20", "off"): "sw", ("tri20", "on"): "hw", ("tlas-tri20", "on"): "grtx"}


def own(at):
    """What a point sets beside what its design is."""
    said = ", no spills" if at.get("rt.warp_buffer.stack_entries", 0) >= 24 else ""
    return said + (f", L1 of {at['l1.bytes'] // 1024} KB" if "l1.bytes" in at else "")


def design(at):
    """What a point is called, without its k."""
    checkpoints, wide = at["tracer.checkpoint"], at.get("rt.memory.sectors_per_cycle", 1) > 1
    if at.get("tracer.tracing") == "list":
        return "list of all hits, spheres"
    if at.get("tracer.tracing") == "single":
        return "one round, ellipsoids"
    if at.get("rt.any_hit_unit.enabled"):
        name = "gautracer" if at["tracer.accel"] == "ellipsoid" else "spheres in heaps"
        name += ", by entry" if at.get("tracer.sort_key") == "entry" else ""
        if at.get("rt.traversal") == "warp":
            name = "walk" if at.get("tracer.sort_key") == "entry" else "walk, by peak"
        return name + ("" if wide else ", port of one sector") + (", checkpoints" if checkpoints == "on" else "") + own(at)
    if at["tracer.accel"] == "tlas-sphere":
        return "spheres, checkpoints"
    return STRUCTURES[at["tracer.accel"], checkpoints] + (", what costs little" if wide else "")


def read(path):
    """{(design, k): {view: {statistic: value}}}, in the order of the plan."""
    database = open_plan(path)
    found = {}
    for number, scene, coordinates in database.execute(
            "SELECT id, scene, coordinates FROM of_plan WHERE status = 'done' ORDER BY id"):
        at = json.loads(coordinates)
        values = dict(database.execute(
            f"SELECT name, value FROM value WHERE point_id = ? AND name IN ({','.join('?' * len(STATISTICS))})",
            (number, *STATISTICS)))
        found.setdefault((design(at), at["tracer.k"]), {})[scene] = values
    return found


def mean(values):
    values = list(values)
    return math.exp(sum(map(math.log, values)) / len(values)) if values else math.nan


def row(cells):
    print("| " + " | ".join(cells) + " |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("database")
    parser.add_argument("--over", default="baseline", metavar="DESIGN")
    parser.add_argument("--binds", action="store_true")
    arguments = parser.parse_args()
    found = read(arguments.database)
    base = {}
    for (name, _), views in found.items():
        for view, values in views.items():
            if name == arguments.over and values["gpu.cycles"] < base.get(view, {"gpu.cycles": math.inf})["gpu.cycles"]:
                base[view] = values
    views = [view for view in base if all(view in of for of in found.values())]
    if not views:
        return 1
    rooms, objects = ([view for view in views if view.startswith(OBJECTS) == of] for of in (False, True))
    title = ["design", "k", *views]
    if arguments.binds:
        row(title)
        row(["---"] * len(title))
        for (name, k), of in found.items():
            cells = []
            for view in views:
                bound = max(BOUNDS, key=lambda b: of[view][f"gpu.bound.{b}"])
                cells.append(f"{bound} {of[view][f'gpu.bound.{bound}'] / of[view]['gpu.cycles']:.2f}")
            row([name, str(k), *cells])
        return 0
    row(title + ["**rooms**", "**objects**", "RT unit, mm²", "chip, mm²", "energy of a ray"])
    row(["---"] * (len(title) + 5))
    for (name, k), of in found.items():
        speed = {view: base[view]["gpu.cycles"] / of[view]["gpu.cycles"] for view in views}
        energy = mean(of[view]["gpu.energy_nj_per_ray"] / base[view]["gpu.energy_nj_per_ray"] for view in views)
        any_view = of[views[0]]
        row([name, str(k), *(f"{speed[view]:.2f}" for view in views), f"**{mean(speed[v] for v in rooms):.2f}**",
             f"**{mean(speed[v] for v in objects):.2f}**", f"{any_view['cost.rt_unit_mm2']:.2f}",
             f"{any_view['cost.mm2']:.1f}", f"{energy:.2f}"])
    return 0


if __name__ == "__main__":
    sys.exit(main())
