#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Structures and checkpoints on shipped cards, from databases of configs/sweeps/silicon*.toml.

    python3 bench/silicon.py ms ada.sqlite --card "RTX 6000 Ada" --frames docs/results/data/silicon-frames.csv --fitted lacadiere,taebak
    python3 bench/silicon.py frames PLAN.toml --program build/release/grtx > docs/results/data/silicon-frames.csv
    python3 bench/silicon.py rivals ada-16.sqlite
    python3 bench/silicon.py structures ada.sqlite blackwell.sqlite ... [--chart data/measured/rtx-6000-ada.csv]
    python3 bench/silicon.py checkpoints ada-c.sqlite ...
    python3 bench/silicon.py spheres blackwell-128.sqlite

ms: milliseconds of a whole frame of the card and ratios of structures beside the points of data/measured/points.csv, by source: means over
scenes, standard errors of their logarithms, on scenes that were fitted and on the others. A crop counts without its tail (its cycles times
the mean share of warp buffer entries that are in use), and as its frame: times the frame's any-hit calls a ray over the crop's.
frames: any-hit calls a ray of each view of a plan, of the crop and of 160 x 90 rays over its whole frame. rivals: rounds over a list from
boxes, and shaders over icosahedra. structures: a row a structure and kernel degree, the speed over monolithic icosahedra of the same degree in each view, its
geometric mean, and the chart's mean and range where --chart has the structure. checkpoints: a row a view, the speed of
every way over the fastest rounds without checkpoints, and means. spheres: cycles of 80 triangles over those of a sphere, by its interval.
Exit code 1 when a database has no point to compare.
"""
import argparse
import csv
import json
import math
import os
import subprocess
import sys
import tempfile
import tomllib
from statistics import geometric_mean as mean, stdev

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


ABC = {"tri20": "A", "tlas-tri20": "C", "tlas-box": "D"}  # the charts' letters


def frames(plan, program):
    """Prints scene, degree, structure, any-hit calls a ray of the crop and of the whole frame."""
    with open(plan, "rb") as file:
        settings = tomllib.load(file)
    print("# Any-hit calls a ray, in the crop of a plan and over its whole frame of 16 to 9: bench/silicon.py frames")
    print("scene,tracer.kernel_degree,accel,crop,frame")
    beside = os.path.dirname(plan)
    for view in settings["scene"]:
        for degree in settings["grid"]["tracer"]["kernel_degree"]:
            for accel in ABC:
                calls = []
                for size in ((view["width"], view["height"], view["fov_scale"]), (160, 90, 1.0)):
                    with tempfile.NamedTemporaryFile(suffix=".json") as stats:
                        subprocess.run([program, "trace", "--scene", os.path.join(beside, view["file"]), "--cameras",
                                        os.path.join(beside, view["cameras"]), "--view", str(view["view"]), "--width", str(size[0]),
                                        "--height", str(size[1]), "--fov-scale", str(size[2]), "--accel", accel, "--k", "18", "--layout", "compact",
                                        "--machine", "ada", "--instance-bounds", "box_corners", "--kernel-degree", str(degree), "--no-trace", "--quiet", "--stats", stats.name], check=True)
                        found = json.load(open(stats.name, encoding="utf-8"))["stats"]
                    calls.append(found["tracer.any_hit.calls"]["value"] / found["tracer.rays"]["value"])
                print(f"{view['name']},{degree},{accel},{calls[0]:.2f},{calls[1]:.2f}", flush=True)
    return 1


def log_error(values):
    """Standard error of the mean of logarithms; 0 of a single value."""
    return stdev([math.log(value) for value in values]) / math.sqrt(len(values)) if len(values) > 1 else 0.0


def against(measured, ours):
    """Cells: the means of both and their ranges, ours over measured, that in standard errors, inside two of them or not."""
    spread = lambda of: f"{mean(of):.3g} ({min(of):.3g} to {max(of):.3g})" if len(of) > 1 else f"{of[0]:.3g}"
    ratio, error = mean(ours) / mean(measured), math.hypot(log_error(measured), log_error(ours))
    if not error:
        return [spread(measured), spread(ours), f"{ratio:.2f}", "", ""]
    off = math.log(ratio) / error
    return [spread(measured), spread(ours), f"{ratio:.2f}", f"{off:+.1f}", "yes" if abs(off) <= 2 else "no"]


def published(path, card):
    """Points of a card that give the milliseconds of a frame and can be simulated."""
    with open(path, encoding="utf-8") as file:
        return [line for line in csv.DictReader(line for line in file if not line.startswith("#"))
                if line["card"] == card and not line["why"] and not line["over"]]


def scales(path):
    """{(scene, degree, structure): any-hit calls a ray of the frame over those of the crop}; nothing without a file."""
    if not path:
        return {}
    with open(path, encoding="utf-8") as file:
        return {(line["scene"], line["tracer.kernel_degree"], line["accel"]): float(line["frame"]) / float(line["crop"])
                for line in csv.DictReader(line for line in file if not line.startswith("#"))}


def quantities(lines, scale, ours):
    """Of each chart, (source, degree, k): (chart, quantity, measured by scene, ours by scene). ours: {(degree, k, structure): {scene: cycles a
    ray of one SM}}."""
    charts, of = {}, {}
    for line in lines:
        chart = line["source"], line["tracer.kernel_degree"], line["tracer.k"]
        of.setdefault(chart, []).append(line)
        charts.setdefault(chart, {}).setdefault(line["design"], {})[line["scene"]] = float(line["value"])
    for chart, structures in charts.items():
        _, degree, k = chart
        pixels, sms, mhz = (mean(float(line[name]) for line in of[chart]) for name in ("pixels", "sms", "mhz"))  # photographs differ in pixels
        bare = {design: ours.get((degree, k, design), {}) for design in structures}
        for design in structures:
            yield chart, f"{ABC[design]}, ms", structures[design], {
                scene: value * pixels / sms / (1000 * mhz) * scale.get((scene, degree, design), 1.0) for scene, value in bare[design].items()}
        for above, below in (("tri20", "tlas-tri20"), ("tlas-box", "tri20"), ("tlas-box", "tlas-tri20")):
            if above in structures and below in structures:  # ours of the same crop
                over = lambda of, above=above, below=below: {scene: of[above][scene] / of[below][scene] for scene in of[above] if scene in of[below]}
                yield chart, f"{ABC[above]} / {ABC[below]}", over(structures), over(bare)


def milliseconds(paths, arguments):
    """Rows of ms: each source of the card's points, each structure and ratio of two, fitted scenes and others."""
    ours = {}
    for path in paths:
        for point in points(path, "gpu.cycles", "gpu.rt.occupancy", "gpu.distributor.groups"):
            at, values, config = {**{"tracer." + key: value for key, value in point["tracer"].items()}, **point["at"]}, point["values"], point["config"]
            full = values["gpu.cycles"] * values["gpu.rt.occupancy"] / config["rt.warp_buffer.entries"]
            key = str(at["tracer.kernel_degree"]), str(at["tracer.k"]), at["tracer.accel"]
            ours.setdefault(key, {})[point["scene"]] = full * config["gpu.sms"] / (values["gpu.distributor.groups"] * 32)
    head(["source", "degree", "quantity", "measured", "scenes", "ours", "ours ÷ measured", "in standard errors", "within two"])
    done = 0
    fitted = set(arguments.fitted.split(",")) if arguments.fitted else set()
    for (source, degree, _), name, measured, found in quantities(published(arguments.points, arguments.card), scales(arguments.frames), ours):
        for kind, wanted in (("fitted", lambda scene: scene in fitted), ("others", lambda scene: scene not in fitted), ("all", lambda scene: True)):
            values = [value for scene, value in found.items() if wanted(scene)]
            if values and (kind == "all" or fitted):
                done += 1
                cells = against(list(measured.values()), values)
                row([source, degree, name, cells[0], f"{kind}, {len(values)}", *cells[1:]])
    return done


def rivals(paths):
    done = 0
    head(["scene", "rounds of 16 over a list, boxes", "shader over icosahedra"])
    found = {}
    for path in paths:
        for point in points(path, "gpu.cycles"):
            at = {**{"tracer." + key: value for key, value in point["tracer"].items()}, **point["at"]}
            if int(at["tracer.kernel_degree"]) == 2:
                found.setdefault(point["scene"], {})[at["tracer.accel"], at.get("tracer.tracing", "multi")] = point["values"]["gpu.cycles"]
    ratios = []
    for scene, ways in found.items():
        box = ways.get(("tlas-box", "multi"))
        pair = [box / ways[way] if box and way in ways else None for way in (("tlas-box", "list"), ("tri20", "multi"))]
        if None not in pair:
            done += 1
            ratios.append(pair)
            row([scene, *(f"{one:.2f}" for one in pair)])
    if ratios:
        row(["**mean**, ± a standard error", *(f"**{mean(of):.2f}** ± {100 * log_error(of):.0f} %" for of in zip(*ratios))])
    return done


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("table", choices=["ms", "frames", "rivals", "structures", "checkpoints", "spheres"])
    parser.add_argument("databases", nargs="+")
    parser.add_argument("--chart", help="measured speeds over monolithic icosahedra")
    parser.add_argument("--points", default=os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "data/measured/points.csv"))
    parser.add_argument("--card", default="RTX 6000 Ada")
    parser.add_argument("--frames", help="CSV of frames: a crop then counts as its frame")
    parser.add_argument("--fitted", default="", help="scenes that were fitted, with commas between")
    parser.add_argument("--program", default="build/release/grtx")
    arguments = parser.parse_args()
    if arguments.table == "ms":
        done = milliseconds(arguments.databases, arguments)
    elif arguments.table == "frames":
        done = sum(frames(plan, arguments.program) for plan in arguments.databases)
    elif arguments.table == "rivals":
        done = rivals(arguments.databases)
    elif arguments.table == "structures":
        done = structures(arguments.databases, chart(arguments.chart) if arguments.chart else {})
    else:
        done = (checkpoints if arguments.table == "checkpoints" else spheres)(arguments.databases)
    return 0 if done else 1


if __name__ == "__main__":
    sys.exit(main())
