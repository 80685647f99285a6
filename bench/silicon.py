#!/usr/bin/env python3
"""Shipped silicon beside the model, from the database of configs/sweeps/silicon.toml: monolithic icosahedra (A) against a TLAS
over one icosahedron (C) and over one ellipsoid (D), per scene.

    python3 bench/silicon.py silicon.sqlite
"""
import json
import math
import sqlite3
import sys

STRUCTURES = {"tri20": "A", "tlas-tri20": "C", "tlas-sphere": "D"}
# nvpro-samples/vk_gaussian_splatting, doc/ray_tracing_3d_gaussians.md, RTX 6000 Ada: bars of nine scenes, read to 3 %.
SILICON = {"C": (0.81, 1.07, 1.30), "D": (0.47, 0.65, 0.89)}
SHOWN = {"hit": "gpu.l1.node.hit_rate", "fetches": "gpu.rt.node_fetches", "latency": "gpu.rt.node_fetch_latency"}


def read(path):
    """{scene: {structure: {name: value}}} of the points that are done."""
    found = {}
    with sqlite3.connect(path) as database:
        for number, scene, coordinates in database.execute(
                "SELECT id, scene, coordinates FROM point WHERE status = 'done' ORDER BY id"):
            structure = STRUCTURES[json.loads(coordinates)["tracer.accel"]]
            found.setdefault(scene, {})[structure] = dict(
                database.execute("SELECT name, value FROM value WHERE point_id = ?", (number,)))
    return {scene: by for scene, by in found.items() if len(by) == len(STRUCTURES)}


def main():
    scenes = read(sys.argv[1])
    ratios = {"C": [], "D": []}
    print("| scene | A / C | A / D | L1 hit rate A, C | node fetches A / C | fetch latency A, C | DRAM MB A, C |")
    print("|---|---|---|---|---|---|---|")
    for scene, by in scenes.items():
        a, c = by["A"], by["C"]
        for structure in ratios:
            ratios[structure].append(a["gpu.cycles"] / by[structure]["gpu.cycles"])
        print(f"| {scene} | {ratios['C'][-1]:.2f} | {ratios['D'][-1]:.2f} "
              f"| {100 * a[SHOWN['hit']]:.0f} %, {100 * c[SHOWN['hit']]:.0f} % | {a[SHOWN['fetches']] / c[SHOWN['fetches']]:.2f} "
              f"| {a[SHOWN['latency']]:.0f}, {c[SHOWN['latency']]:.0f} | {a['gpu.dram.bytes'] / 1e6:.0f}, {c['gpu.dram.bytes'] / 1e6:.0f} |")
    mean = {s: math.exp(sum(map(math.log, values)) / len(values)) for s, values in ratios.items()}
    print(f"| **geometric mean** | **{mean['C']:.2f}** | **{mean['D']:.2f}** | | | | |")
    print("| silicon, mean (range) | " + " | ".join(f"{m:.2f} ({low:.2f} to {high:.2f})" for low, m, high in SILICON.values())
          + " | | | | |")


if __name__ == "__main__":
    main()
