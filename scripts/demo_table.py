#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""One table of runs on several machines, and what its numbers mean: demo_table.py GRTX RESULTS.json..."""
import json
import sys

COLUMNS = (("cycles M", "gpu.cycles", 1e-6, "{:.2f}"), ("fetch M", "gpu.rt.node_fetches", 1e-6, "{:.2f}"),
           ("L1 hits", "gpu.l1.node.hit_rate", 100, "{:.0f} %"), ("DRAM MB", "gpu.dram.bytes", 1e-6, "{:.0f}"), ("mJ", "gpu.energy_nj", 1e-6, "{:.2f}"))
WIDTH = 9


def main(program, files):
    runs = []
    for name in files:
        with open(name, encoding="utf-8") as file:
            runs.append(json.load(file))

    def value(run, design, statistic):
        return run["designs"][design][statistic]["value"]

    def speedup(run, design):
        return value(run, "baseline", "gpu.cycles") / value(run, design, "gpu.cycles")

    modes = sorted({inputs["mode"] for run in runs for inputs in run["inputs"].values()})
    versions = sorted({str(run["model_version"]) for run in runs})
    print(f"mode {', '.join(modes)}; model version {', '.join(versions)}")
    print(f"{'machine':<13}{'design':<10}{'k':>3}{'speed-up':>9}" + "".join(f"{title:>{WIDTH}}" for title, *_ in COLUMNS))
    for run in runs:
        for design in run["designs"]:
            cells = (form.format(value(run, design, statistic) * scale) for _, statistic, scale, form in COLUMNS)
            print(f"{run['machine']:<13}{design:<10}{run['inputs'][design]['trace.k']:>3}{speedup(run, design):>9.2f}" + "".join(f"{cell:>{WIDTH}}" for cell in cells))
    launches = {}  # how full a machine is and the machines
    for run in runs:
        warps, slots = value(run, "baseline", "gpu.distributor.groups"), run["config"]["gpu.sms"] * run["config"]["gpu.resident_warps"]
        tail = max(value(run, design, "gpu.distributor.tail_cycles") / value(run, design, "gpu.cycles") for design in run["designs"])
        text = f"{warps} warps are {warps / slots:.1f} times the {slots} warp slots; at most {100 * tail:.0f} % of a design's cycles lie behind the last start"
        launches.setdefault(text, []).append(run["machine"])
    for text, machines in launches.items():
        print(f"full ({', '.join(machines)}): {text}")
    notes = {}  # a text and the machines whose figures it limits
    for run in runs:
        for note in (note for own in run.get("notes", {}).values() for note in own):
            notes.setdefault(note["text"], {})[run["machine"]] = None
    for text, machines in notes.items():
        print(f"mind ({', '.join(machines)}): {text}")
    identical = all(run["images_identical"] for run in runs)
    print("images of designs that blend in one order:", "bit-identical" if identical else "DIFFERENT")

    first, last = runs[0], runs[-1]
    fewer = value(first, "baseline", "gpu.rt.node_fetches") / value(first, "hw", "gpu.rt.node_fetches")
    hits = [100 * value(first, design, "gpu.l1.node.hit_rate") for design in ("baseline", "sw")]
    charging = [run["machine"] for run in runs if run["config"]["rt.checkpoint.traffic"] == "charged"]
    free = f", where checkpoint traffic is free ({charging[0]} charges it)" if charging and first["machine"] not in charging else ""
    print(f"""
1. On the machine {first['machine']}{free}, grtx is {speedup(first, 'grtx'):.1f} times as fast as the baseline: one BLAS for all Gaussians (sw)
   takes the L1 hits of nodes from {hits[0]:.0f} to {hits[1]:.0f} %; with checkpoints (hw) {fewer:.1f} times fewer nodes are fetched.
   Each design has the k, the hits that a ray collects per round, at which it is fast; --k 8 would be the paper's for all.
2. gautracer, which takes the shaders out of the traversal and has no checkpoints, is {speedup(first, 'gautracer'):.1f} times as fast.
   walk, where the lanes of a warp also share a stack and a Gaussian takes 32 bytes, is {speedup(first, 'walk'):.1f} times as fast.
3. On {last['machine']}, a share of a GPU of today as far as it is known, the same view gives {speedup(last, 'sw'):.1f} (sw),
   {speedup(last, 'hw'):.1f} (hw), {speedup(last, 'grtx'):.1f} (grtx), {speedup(last, 'gautracer'):.1f} (gautracer) and {speedup(last, 'walk'):.1f} (walk): what a proposal gains depends on the machine.
4. Next: `{program}` alone shows five steps to your own runs, `{program} run --help` all options; an L1 of half
   the size is `--set l1.bytes=65536`, your own scene `--scene point_cloud.ply`.
""")
    return 0 if identical else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2:]))
