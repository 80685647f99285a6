#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Of which class a scene is: the statistics by which whole rooms and buildings differ from objects (docs/results/scene-classes.md).

    bench/scene_class.py [--program GRTX] [--size 128] [--fov-scale 1] [--csv F.csv] [--range F.csv] [--speedups | --rounds] SCENE.ply[:VIEW,VIEW...]...

Cameras are those beside the scene, SCENE.cameras.json; without views, all of them. Rays are traced as the machine `paper` asks,
and sw and grtx are simulated, grtx with checkpoint traffic that costs nothing. --csv adds the rows to a file; --range
prints what lies outside the range of such a file's rows in bold and then exits with 1; --speedups simulates all designs.
--rounds: in place of all that, the rounds of a ray, in the mean over rays and over the node visits of sw, and the visits of sw over grtx's.
--scaled G.csv --range F.csv: the range of the trained views F at the counts of the generated views G (PRESET_COUNT_SEED VIEW), by how
footprints (a power) and L1 hits (points a doubling) go with the count within G's presets; and which of G lie outside.
"""
import argparse
import csv
import json
import math
import os
import re
import statistics as mathematics
import subprocess
import sys
import tempfile
from collections import defaultdict

FREE = ("--set", "rt.checkpoint.traffic=uncharged")
TRACES = {"baseline": ("tri20", "off"), "hw": ("tri20", "on"), "sw": ("tlas-tri20", "off"), "grtx": ("tlas-tri20", "on")}
SAMPLE = 64  # warps in which entries are looked at one by one


def columns(of, entries):
    """of(design, statistic) -> value; entries: of the sample. The row in the order of the table."""
    rays, rounds = of("grtx", "tracer.rays"), of("grtx", "tracer.rounds")
    mib = 2.0 ** -20
    return {
        "footprint tri20": of("baseline", "accel.footprint_bytes") * mib,
        "footprint tlas": of("grtx", "accel.footprint_bytes") * mib,
        "rounds": rounds / rays,
        "ERT %": 100 * of("grtx", "tracer.ert_share"),
        "hits / processed": of("grtx", "tracer.hits_behind_end"),
        "visits baseline": of("baseline", "tracer.visits.total") / rays,
        "visits sw": of("sw", "tracer.visits.total") / rays,
        "visits grtx": of("grtx", "tracer.visits.total") / rays,
        "written": of("grtx", "tracer.checkpoint.written") / rounds,
        "read": of("grtx", "tracer.checkpoint.read") / rounds,
        "in BLAS %": 100 * entries["blas"] / entries["written"],
        "forwarded %": 100 * of("free", "gpu.rt.replay_forwards") / of("grtx", "tracer.checkpoint.read"),
        "most entries": of("grtx", "tracer.checkpoint.max_per_ray"),
        "L1 sw %": 100 * of("sw", "gpu.l1.node.hit_rate"),
        "L1 free %": 100 * of("free", "gpu.l1.node.hit_rate"),
    }


def speedups(of):
    return {design: of("baseline", "gpu.cycles") / of(design, "gpu.cycles") for design in ("sw", "hw", "grtx", "free")}


def call(program, *arguments):
    done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"scene_class: {arguments[0]}: {done.stderr.strip()}")
    return done.stdout


def look_at_entries(program, trace):
    """Checkpoint entries written, of those inside a BLAS, read, and of those forwarded, in a sample of the warps."""
    header = json.loads(call(program, "trace-dump", trace, "--warp", 0, "--lane", 0).split("header ", 1)[1].split("\n", 1)[0])
    found = dict.fromkeys(("written", "blas", "read", "forwarded"), 0)
    for warp in sorted({number * header["groups"] // SAMPLE for number in range(SAMPLE)}):
        for line in call(program, "trace-dump", trace, "--warp", warp).splitlines():
            event = re.match(r" +\d+ (\w+) +0x", line)
            if not event:
                continue
            found["read"] += event[1] in ("take", "forward")
            found["forwarded"] += event[1] == "forward"
            before, kept, children = line.partition("checkpointed")
            if kept:  # the node itself, or those of its children that follow
                addresses = re.findall(r":0x(\w+)", children) or re.findall(r" 0x(\w+)", before)[:1]
                found["written"] += len(addresses)
                found["blas"] += sum(int(address, 16) >= header["blas_base"] for address in addresses)
    return found


def rounds_and_visits(program, trace):
    """Of each ray: its rounds and its node visits."""
    found = []
    with subprocess.Popen([program, "trace-dump", trace], stdout=subprocess.PIPE, text=True) as dump:
        for line in dump.stdout:  # tens of millions: no regular expressions
            if line.startswith("      "):
                found[-1][1] += line.split(maxsplit=2)[1] in ("internal", "instance", "leaf")
            elif line.startswith("  lane "):
                found.append([int(line.split()[4]), 0])
    if dump.returncode != 0:
        sys.exit("scene_class: trace-dump failed")
    return found


def measure_rounds(options, scene, view):
    with tempfile.TemporaryDirectory(prefix="grtx_scene_class_") as folder:
        rays = {}
        for design in ("sw", "grtx"):
            accel, checkpoint = TRACES[design]
            file = os.path.join(folder, design + ".grtx")
            call(options.program, "trace", *view_of(options, scene, view), "--accel", accel, "--checkpoint", checkpoint, "-o", file, "--quiet")
            rays[design] = rounds_and_visits(options.program, file)
    visits = {design: sum(visits for _, visits in found) for design, found in rays.items()}
    return {"rounds of a ray": sum(rounds for rounds, _ in rays["sw"]) / len(rays["sw"]),
            "of the ray of a visit": sum(rounds * visits for rounds, visits in rays["sw"]) / visits["sw"],
            "visits sw / grtx": visits["sw"] / visits["grtx"]}


def view_of(options, scene, view):
    return ("--scene", scene, "--cameras", scene.removesuffix(".ply") + ".cameras.json", "--view", view, "--width", options.size,
            "--height", options.size, "--fov-scale", options.fov_scale, "--machine", "paper-charged")


def measure(options, scene, view):
    machine = ("--machine", "paper-charged")
    statistics = {}
    with tempfile.TemporaryDirectory(prefix="grtx_scene_class_") as folder:

        def simulate(name, design, *settings):
            file = os.path.join(folder, name + ".sim.json")
            call(options.program, "sim", os.path.join(folder, design + ".grtx"), *machine, *settings, "--stats", file)
            load(name, file)

        def load(name, file):
            with open(file, encoding="utf-8") as text:
                statistics.setdefault(name, {}).update(json.load(text)["stats"])

        def of(design, name):
            return statistics[design][name]["value"]

        for design, (accel, checkpoint) in TRACES.items():
            if design == "hw" and not options.speedups:
                continue
            trace, file = os.path.join(folder, design + ".grtx"), os.path.join(folder, design + ".json")
            kept = ("--no-trace",) if design == "baseline" and not options.speedups else ("-o", trace)
            call(options.program, "trace", *view_of(options, scene, view), "--accel", accel, "--checkpoint", checkpoint, *kept,
                 "--stats", file, "--quiet")
            load(design, file)
            if design == "sw" or options.speedups:
                simulate(design, design)
        simulate("free", "grtx", *FREE)
        row = columns(of, look_at_entries(options.program, os.path.join(folder, "grtx.grtx")))
        return {**row, **speedups(of)} if options.speedups else row


def views_of(scene):
    with open(scene.removesuffix(".ply") + ".cameras.json", encoding="utf-8") as file:
        return range(len(json.load(file)))


TRAINED = {"wang_sha": 1250000, "lacadiere": 1495636, "headquarter_garden": 842951, "hon_sui_sen": 1250000, "taebak": 764871}


def rows_of(path):
    with open(path, encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def scaled(generated, trained):
    for column in ("footprint tri20", "footprint tlas", "L1 sw %", "L1 free %"):
        power = column.startswith("footprint")
        y, back = (math.log, math.exp) if power else (float, float)
        by_preset, found = defaultdict(list), []
        for row in generated:
            preset, count, _ = row["view"].split()[0].rsplit("_", 2)
            by_preset[preset].append((math.log2(int(count)), y(float(row[column]))))
            found.append((int(count), row["view"], float(row[column])))
        apart = [(x - mathematics.mean(a for a, _ in points), z - mathematics.mean(b for _, b in points)) for points in by_preset.values() for x, z in points]
        slope = sum(x * z for x, z in apart) / sum(x * x for x, _ in apart)
        print(f"{column}: " + (f"power {slope / math.log(2):.2f} of the count" if power else f"{slope:+.1f} points a doubling"))
        for count in sorted({c for c, _, _ in found}):
            values = [back(y(float(row[column])) + slope * math.log2(count / TRAINED[row["view"].split()[0]])) for row in trained]
            outside = [f"{view} ({value:.1f})" for c, view, value in found if c == count and not min(values) <= value <= max(values)]
            print(f"  {count}: {min(values):.1f} to {max(values):.1f}; outside: {', '.join(outside) or 'none'}")


def write(value):
    return f"{value:.2f}" if value < 10 else f"{value:.0f}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default="build/release/grtx")
    parser.add_argument("--size", type=int, default=128, help="pixels an edge")
    parser.add_argument("--fov-scale", type=float, default=1, help="factor on the field of view")
    parser.add_argument("--csv", help="rows are added to this file")
    parser.add_argument("--range", help="rows of the class: what lies outside is bold")
    parser.add_argument("--speedups", action="store_true", help="all designs, over the baseline")
    parser.add_argument("--rounds", action="store_true", help="rounds alone, weighted by rays and by node visits")
    parser.add_argument("--scaled", metavar="G.csv", help="no scene is measured: the range at the counts of these rows")
    parser.add_argument("scenes", nargs="*", metavar="SCENE.ply[:VIEWS]")
    options = parser.parse_args()
    if not options.scenes and not (options.scaled and options.range):
        parser.error("SCENE.ply, or --scaled with --range, is missing")
    if options.scaled:
        return scaled(rows_of(options.scaled), rows_of(options.range))
    allowed = {}
    if options.range:
        rows = rows_of(options.range)
        allowed = {name: (min(float(r[name]) for r in rows), max(float(r[name]) for r in rows))
                   for name in rows[0] if name not in ("view", "sw", "hw", "grtx", "free")}  # speed-ups are no property
    outside = False
    head = None
    for asked in options.scenes:
        scene, _, views = asked.partition(":")
        for view in (int(v) for v in views.split(",")) if views else views_of(scene):
            row = {column: float(f"{value:.6g}") for column, value in (measure_rounds if options.rounds else measure)(options, scene, view).items()}
            name = f"{os.path.basename(scene).removesuffix('.ply')} {view}"
            if head is None:
                head = list(row)
                print("| view | " + " | ".join(head) + " |\n|" + "---|" * (len(head) + 1))
            cells = []
            for column, value in row.items():
                least, most = allowed.get(column, (value, value))
                inside = least <= value <= most
                outside = outside or not inside
                cells.append(write(value) if inside else f"**{write(value)}**")
            print(f"| {name} | " + " | ".join(cells) + " |", flush=True)
            if options.csv:
                new = not os.path.exists(options.csv)
                with open(options.csv, "a", encoding="utf-8", newline="") as file:
                    writer = csv.writer(file)
                    if new:
                        writer.writerow(["view"] + head)
                    writer.writerow([name, *row.values()])
    if allowed:
        print("| *range* | " + " | ".join(f"{write(allowed[c][0])} to {write(allowed[c][1])}" if c in allowed else "" for c in head) + " |")
    return 1 if outside else 0


if __name__ == "__main__":
    sys.exit(main())
