#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""GauTracer's steps from its baseline to its design, on scenes of a folder: python3 bench/gautracer_steps.py SCENES

SCENES: as scripts/scenes.sh fills it, with the two objects beside (configs/sweeps/rivals.toml names the files). Traces
and statistics lie in a temporary folder. --program GRTX, --machine NAME (rtx2060-share). Prints Markdown.
Exit code 1 when no scene is there.
"""
import argparse
import json
import os
import subprocess
import sys
import tempfile

VIEWS = [("playbot", "playbot_500k_sh2", "playbot", 0), ("pizza", "pizza_161k_sh3", "pizza", 1),
         ("lacadiere", "lacadiere", "lacadiere", 0), ("taebak", "taebak", "taebak", 1),
         ("headquarter_garden", "headquarter_garden", "headquarter_garden", 0), ("wang_sha", "wang_sha", "wang_sha", 1)]
COMMON = ["--sort-key", "peak", "--ert-check", "round"]
PRUNED = COMMON + ["--accel", "ellipsoid", "--tmax-update", "kth"]
UNIT = ["rt.gaussian.enabled=true", "simt.registers_per_thread=32"]


def heaps(k):
    return UNIT + ["rt.any_hit_unit.enabled=true", f"simt.payload_registers={3 * k}"]


# Name of a step: the tracer's options, the keys.
STEPS = {"icosahedra": (COMMON + ["--accel", "tri20", "--any-hit", "delayed", "--k", "16"], []),
         "baseline": (COMMON + ["--accel", "box", "--any-hit", "delayed", "--k", "16"], []),
         "Gaussian unit": (COMMON + ["--accel", "ellipsoid", "--any-hit", "delayed", "--k", "16"], UNIT),
         "+ any-hit unit": (COMMON + ["--accel", "ellipsoid", "--any-hit", "delayed", "--k", "16"], heaps(16)),
         "+ pruning": (PRUNED + ["--k", "16"], heaps(16)),
         "nearest first": (PRUNED + ["--k", "16", "--child-order", "near_first"], heaps(16)),
         "k = 8": (PRUNED + ["--k", "8"], heaps(8)), "k = 32": (PRUNED + ["--k", "32"], heaps(32))}
RATIOS = {"speed": "gpu.cycles", "instructions": "gpu.simt.instructions.total", "visits": "gpu.rt.node_visits",
          "DRAM bytes": "gpu.dram.bytes", "energy": "gpu.energy_nj"}


def row(cells):
    print("| " + " | ".join(cells) + " |")


def measured(arguments, view, folder):
    """{step: {statistic: value}} of a view."""
    name, scene, cameras, number = view
    at = os.path.join(arguments.scenes, scene + ".ply"), os.path.join(arguments.scenes, cameras + ".cameras.json")
    if not all(map(os.path.exists, at)):
        return None
    found, made = {}, {}
    for step, (options, keys) in STEPS.items():
        trace = made.get(tuple(options))
        if trace is None:
            trace = made[tuple(options)] = os.path.join(folder, f"{name}{len(made)}.grtx")
            subprocess.run([arguments.program, "trace", "--scene", at[0], "--cameras", at[1], "--view", str(number), "--width",
                            "64", "--height", "64", "--fov-scale", "0.5", "--machine", arguments.machine, "--quiet", "-o",
                            trace, *options], check=True)
        stats = os.path.join(folder, "stats.json")
        subprocess.run([arguments.program, "sim", trace, "--machine", arguments.machine, "--quiet", "--stats", stats] +
                       [word for key in keys for word in ("--set", key)], check=True, stderr=subprocess.DEVNULL)
        with open(stats, encoding="utf-8") as file:
            found[step] = {key: value["value"] for key, value in json.load(file)["stats"].items()}
    for trace in made.values():
        os.remove(trace)
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes")
    parser.add_argument("--program", default="build/release/grtx")
    parser.add_argument("--machine", default="rtx2060-share")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        views = {view[0]: found for view in VIEWS if (found := measured(arguments, view, folder)) is not None}
    if not views:
        return 1
    for what, statistic in RATIOS.items():
        print(f"\n{what}: baseline over step\n")
        row(["view", *STEPS])
        row(["---"] * (1 + len(STEPS)))
        for name, found in views.items():
            row([name, *(f"{found['baseline'][statistic] / found[step][statistic]:.2f}" for step in STEPS)])
    return 0


if __name__ == "__main__":
    sys.exit(main())
