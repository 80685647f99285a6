#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What checkpoints cost, from databases of configs/sweeps/checkpoints.toml and checkpoint_parts.toml.

    python3 bench/checkpoints.py checkpoints.sqlite [parts.sqlite ...] [--over free] [--counts SCENE]

A table for each design: a row a view, a column a point, the speed over that of the column --over (cycles of that one over
cycles of this). Views whose column --over is not done are left out. --counts: entries, sectors, L2 accesses, DRAM bytes
and the longest list of the points of one view.
Exit code 1 when nothing can be compared.
"""
import argparse
import json
import sys

from sweep_database import open_plan

COUNTS = {"gpu.rt.node_visits": "visits", "gpu.rt.checkpoint.entries_written": "entries written",
          "gpu.rt.checkpoint.entries_read": "read", "gpu.rt.checkpoint.sectors_written": "sectors written",
          "gpu.rt.checkpoint.sectors_read": "read", "gpu.l2.accesses": "L2 accesses", "gpu.dram.bytes": "DRAM MB",
          "gpu.rt.checkpoint.max_entries": "longest list", "gpu.energy_nj": "energy, mJ", "cost.rt_unit_mm2": "RT unit, mm2"}
SCALED = {"gpu.dram.bytes": (1e6, 1), "gpu.energy_nj": (1e6, 1), "cost.rt_unit_mm2": (1, 3)}  # divisor, digits


def label(at):
    """What a point is called: its structure and k where the plan has several, then what it does with checkpoints."""
    words = []
    if "tracer.accel" in at:
        words.append(at["tracer.accel"])
        words.append("one round" if at.get("tracer.tracing") == "single" else f"k = {at['tracer.k']}")
        if at["tracer.checkpoint"] == "off":
            return ", ".join(words + ["no checkpoints"])
    if at.get("rt.checkpoint.traffic") == "uncharged":
        return ", ".join(words + ["free" if at["tracer.checkpoint_capacity"] > 1024 else "free, lists of 1,024"])
    parts = {"bins": "tracer.checkpoint_bins" in at, "finished": at.get("tracer.below_instance") == "finish",
             "8 B": at.get("rt.checkpoint.entry_bytes") == 8,
             "gathered": bool(at.get("rt.checkpoint.write_combine")), "kept": bool(at.get("rt.checkpoint.read_buffer"))}
    if all(parts.values()):
        words.append("lean")
    else:
        words += [name for name, there in parts.items() if there] or ["charged"]
    if at.get("tracer.checkpoint_bins", 4) != 4:
        words.append(f"{at['tracer.checkpoint_bins']} bins")
    if at.get("rt.checkpoint.open_sectors", 1) != 1:
        words.append(f"{at['rt.checkpoint.open_sectors']} open sectors")
    return ", ".join(words)


def read(paths):
    """{(design, view): {label: {statistic: value}}} of the points that are done."""
    found = {}
    for path in paths:
        database = open_plan(path)
        for number, scene, design, coordinates in database.execute(
                "SELECT id, scene, design, coordinates FROM of_plan WHERE status = 'done' ORDER BY id"):
            at = json.loads(coordinates)
            names = ("gpu.cycles", *COUNTS)
            values = dict(database.execute("SELECT name, value FROM value WHERE point_id = ? AND name IN "
                                           f"({','.join('?' * len(names))})", (number, *names)))
            if "tracer.accel" in at:
                design = "all"
            found.setdefault((design, scene), {}).setdefault(label(at), values)
    return found


def row(cells):
    print("| " + " | ".join(cells) + " |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("databases", nargs="+")
    parser.add_argument("--over", default="free")
    parser.add_argument("--counts", metavar="SCENE")
    arguments = parser.parse_args()
    found = read(arguments.databases)
    if arguments.counts:
        chosen = {design: points for (design, scene), points in found.items() if scene == arguments.counts}
        for design, points in chosen.items():
            row([design, *COUNTS.values()])
            row(["---"] * (1 + len(COUNTS)))
            for name, values in points.items():
                shown = [(values.get(key, 0), *SCALED.get(key, (1, 0))) for key in COUNTS]
                row([name] + [f"{value / divisor:,.{digits}f}" for value, divisor, digits in shown])
            print()
        return 0 if chosen else 1
    compared = {key: points for key, points in found.items() if arguments.over in points}
    for design in dict.fromkeys(design for design, _ in compared):
        views = {scene: points for (of, scene), points in compared.items() if of == design}
        names = list(dict.fromkeys(name for points in views.values() for name in points))
        row([design, *names])
        row(["---"] * (1 + len(names)))
        for scene, points in views.items():
            base = points[arguments.over]["gpu.cycles"]
            row([scene] + [f"{base / points[name]['gpu.cycles']:.2f}" if name in points else "" for name in names])
        print()
    return 0 if compared else 1


if __name__ == "__main__":
    sys.exit(main())
