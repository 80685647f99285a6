#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Windows mode against cycle mode: how often its 95 % intervals hold, how wide they are, how much time they save.

    python3 bench/windows.py --scenes SCENES --work FOLDER [--only cycle|windows|report] [--plan] [--retry] [--csv F.csv]

FRAMES are drawn by DATE, none by hand: generated scenes of six presets, small ones since cycle mode runs them whole, and public ones (scripts/scenes.sh), each with
machines of 8 to 512 warp slots and designs from shuffled decks. They run in strata: by turns one frame and machine of each dear design
and each kind of public scene and of whole frames, first on machines of up to 64 slots; last what takes minutes, dear designs of public
scenes. Windows go first; what they refuse costs no run in cycle mode. Results lie in FOLDER/cycle.sqlite and FOLDER/windows.sqlite; what is there is not run again, so a run that was
killed goes on, and another rule of windows mode needs windows.sqlite alone (remove the file). Traces lie in FOLDER/traces and serve all
machines. Cases are the cycles of each (frame, machine, design) and the speed-up over the first design of the same frame and machine. A
case is of half `tune` or `show` by a hash of its frame and machine: whoever changes the rule looks at the first half only.
"""
import argparse
import csv
import ctypes
import hashlib
import itertools
import json
import math
import os
import random
import re
import signal
import sqlite3
import subprocess
import sys
import tempfile
from collections import defaultdict

TOP = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
DATE = 20261129
K = ["--k", "16"]
DESIGNS = {"baseline": ["--accel", "tri20", "--checkpoint", "off", *K], "sw": ["--accel", "tlas-tri20", "--checkpoint", "off", *K],
           "hw": ["--accel", "tri20", "--checkpoint", "on", *K], "grtx": ["--accel", "tlas-tri20", "--checkpoint", "on", *K],
           "gautracer": ["--accel", "ellipsoid", "--checkpoint", "off", *K, "--sort-key", "peak", "--tmax-update", "kth"],
           "walk": ["--accel", "ellipsoid", "--checkpoint", "off", "--k", "64", "--tmax-update", "kth", "--ahead", "16", "--layout", "quantised",
                    "--bvh-width", "6"]}
CHEAP = ("gautracer", "walk")
MACHINES = {  # name: machine, slots, settings
    "1 x 8": ("paper-charged", 8, {"gpu.sms": 1, "gpu.resident_warps": 8, "l2.bytes": 524288, "l2.slices": 1}),
    "2 x 16": ("paper-charged", 32, {"gpu.sms": 2, "gpu.resident_warps": 16, "l2.bytes": 1048576, "l2.slices": 1}),
    "4 x 16": ("paper-lean", 64, {"gpu.sms": 4, "gpu.resident_warps": 16, "l2.bytes": 2097152, "l2.slices": 2}),
    "paper": ("paper", 256, {}), "rdna4-share": ("rdna4-share", 256, {}), "rtx2060-share": ("rtx2060-share", 256, {}),
    "ada-share": ("ada-share", 384, {}), "blackwell-share": ("blackwell-share", 384, {}),
    "16 x 32": ("paper-charged", 512, {"gpu.sms": 16, "l2.bytes": 8388608, "l2.slices": 8})}
PUBLIC = {"wang_sha": "room", "lacadiere": "room", "headquarter_garden": "room", "hon_sui_sen": "building", "taebak": "building",
          "la_fontaine": "object", "la_vestale": "object", "le_poeme": "object", "pizza_161k_sh3": "object", "statue_st-peter_sh0": "object",
          "playbot_L4": "object", "playbot_L6": "object"}
PRESETS = {"hall": "room", "building": "building", "object": "object", "room": "room", "flat": "room", "garden": "building"}
# Of 5,408, 10,368, 20,808 and 36,450 warps of 8 rays or 32; 1332 x 876 pixels are 36,573 warps of 32.
EDGES = {"small": (208, 416), "public": (208, 416), "large": (288, 576), "whole": (408, 816), "full HD": (540, 1080)}
LEAST, FEWEST = 0.9, 10  # a statistic of which fewer intervals hold is named
FEW_SLOTS = [name for name, (_, slots, _) in MACHINES.items() if slots <= 64]


def deck_of(lot, names):
    while True:
        yield from lot.sample(names, len(names))


def draw():
    """The frames, in the order of drawing. The first half has warps of 8 rays, which cost a third."""
    lot = random.Random(DATE)

    def deck(names):
        return deck_of(lot, names)

    def hand(cards, count):
        found = []
        while len(found) < count:
            card = next(cards)
            if card not in found:
                found.append(card)
        return found

    few = deck([name for name, (_, slots, _) in MACHINES.items() if slots <= 256])
    many = deck([name for name, (_, slots, _) in MACHINES.items() if slots > 256])
    dear, presets, public = deck(["grtx", "sw", "baseline", "hw"]), deck(list(PRESETS)), deck(sorted(PUBLIC))
    frames = []
    for number in range(60):
        kind = ("small", "large", "small", "small", "public")[number % 5]
        frame = {"view": lot.randrange(4), "rays": 8 if number < 30 else 32, "seed": lot.randrange(1 << 30), "designs": [*CHEAP]}
        frame["edge"] = EDGES[kind][frame["rays"] == 32]
        if kind == "public":  # without the large trees of triangles
            frame["scene"] = next(public)
            frame["class"] = PUBLIC[frame["scene"]]
            frame["view"] %= 2
        else:
            preset = next(presets)
            count, seed = round(math.exp(lot.uniform(math.log(300), math.log(3000)))), lot.randrange(1 << 20)
            frame.update(scene=f"{preset}_{count}_{seed}", preset=preset, count=count, scene_seed=seed)
            frame["class"] = PRESETS[preset]
            if preset not in ("flat", "garden"):  # whose triangles take minutes
                frame["designs"].append(next(dear))
        frame["machines"] = [(name, 0.5) for name in hand(few, 2)] if kind != "large" else [(next(few), 0.25), (next(many), 0.5)]
        # Machines of few slots, where windows suit frames of this size, have all frames.
        have = {name for name, _ in frame["machines"]}
        frame["machines"] += [(name, 0.25 if kind == "large" else 0.5) for name in FEW_SLOTS if name not in have]
        frames.append(frame)
    # What the mode is for, a small share: some frames again as whole ones. Twenty windows are 7 % of the first two.
    for frame in frames[3:12:5]:
        frames.append({**frame, "edge": EDGES["full HD"][0], "machines": [("4 x 16", 0.07), ("2 x 16", 0.07)]})
    for frame in frames[1:12:5]:  # and machines of a card's slots
        frames.append({**frame, "edge": EDGES["whole"][0], "machines": [("paper", 0.5), ("rdna4-share", 0.5), ("2 x 16", 0.125)]})
    # Public rooms and buildings, all with warps of 8 rays, have a design with triangles or instances each, too.
    dear = deck_of(random.Random(DATE + 1), ["grtx", "sw", "baseline", "hw"])
    for frame in [frame for frame in frames if frame["scene"] in PUBLIC and frame["class"] != "object"]:
        if frame["rays"] == 8:
            frame["designs"] = [*frame["designs"], next(dear)]
        else:
            frames.append({**frame, "rays": 8, "edge": EDGES["public"][0], "designs": [*frame["designs"], next(dear)]})
    return frames


def die_with_parent():
    ctypes.CDLL(None).prctl(1, signal.SIGKILL)  # PR_SET_PDEATHSIG


class Refused(Exception):
    """Windows mode would simulate all of it; the message is its reason."""


class Study:
    def __init__(self, options):
        self.options = options
        os.makedirs(os.path.join(options.work, "traces"), exist_ok=True)
        self.databases = {mode: self.open(mode) for mode in ("cycle", "windows")}

    def open(self, mode):
        database = sqlite3.connect(os.path.join(self.options.work, mode + ".sqlite"))
        database.execute("CREATE TABLE IF NOT EXISTS run(frame TEXT, machine TEXT, design TEXT, status TEXT, cpu REAL, document TEXT, "
                         "PRIMARY KEY(frame, machine, design))")
        return database

    def call(self, *arguments, refusable=False):
        """Runs grtx; ends it when it says that windows mode is cycle mode."""
        with subprocess.Popen([self.options.program, *arguments, "--quiet"], stderr=subprocess.PIPE, text=True, preexec_fn=die_with_parent) as run:
            line = ""
            for line in run.stderr:
                why = re.search(r"all of it is simulated, in cycle mode: (.*)", line)
                if refusable and why:
                    run.kill()
                    raise Refused(why.group(1))
        if run.returncode != 0:
            raise RuntimeError(f"grtx {arguments[0]}: {line.strip() or run.returncode}")

    def make(self, path, *arguments):
        """A file that a command makes, if it is not there."""
        if not os.path.exists(path):
            self.call(*arguments, path + ".partial.ply" if path.endswith(".ply") else path + ".partial")
            os.replace(path + ".partial.ply" if path.endswith(".ply") else path + ".partial", path)
        return path

    def trace(self, frame, design):
        if "preset" in frame:
            stem = os.path.join(self.options.work, "traces", frame["scene"])
            if not os.path.exists(stem + ".ply"):
                self.call("synth", "--preset", frame["preset"], "--count", str(frame["count"]), "--seed", str(frame["scene_seed"]), "-o", stem + ".ply")
        else:
            stem = os.path.join(self.options.scenes, frame["scene"])
        return self.make(os.path.join(self.options.work, "traces", f"{name_of(frame)}.{design}.grtx"), "trace", "--scene", stem + ".ply",
                         "--cameras", stem + ".cameras.json", "--view", str(frame["view"]), "--width", str(frame["edge"]), "--height",
                         str(frame["edge"]), "--warp-size", str(frame["rays"]), *DESIGNS[design], "--threads", "1", "-o")

    def run(self, mode, frame, machine, share, design):
        named, _, settings = MACHINES[machine]
        key = (name_of(frame), machine, design)
        database = self.databases[mode]
        old = database.execute("SELECT status FROM run WHERE frame = ? AND machine = ? AND design = ?", key).fetchone()
        if old and (old[0] != "failed" or not self.options.retry):
            return
        print(f"windows.py: {mode}: {', '.join(key)}", file=sys.stderr, flush=True)
        status, cpu, document = "done", 0.0, {}
        with tempfile.TemporaryDirectory(dir=self.options.work) as folder:
            out = os.path.join(folder, "stats.json")
            try:
                self.call("sim", self.trace(frame, design), "--machine", named, *(["--design", design] if design in ("walk", "gautracer") else []),
                          *[text for item in settings.items() for text in ("--set", "=".join(map(str, item)))], "--stats", out,
                          *(["--mode", "windows", "--share", str(share), "--seed", str(frame["seed"])] if mode == "windows" else []),
                          refusable=mode == "windows")
                with open(out, encoding="utf-8") as file:
                    whole = json.load(file)
                cpu = whole["stats"]["host.cpu_seconds"]["value"]
                document = {"stats": {name: s["value"] for name, s in whole["stats"].items() if not name.startswith("host.")},
                            "windows": whole.get("windows")}
            except Refused as refused:
                status, document = "refused", {"why": str(refused)}
            except RuntimeError as failure:
                status, document = "failed", {"why": str(failure)}
        with database:
            database.execute("INSERT OR REPLACE INTO run VALUES (?, ?, ?, ?, ?, ?)", (*key, status, cpu, json.dumps(document)))

    def done(self, mode, point):
        frame, machine, _, design = point
        return self.databases[mode].execute("SELECT 1 FROM run WHERE frame = ? AND machine = ? AND design = ? AND status = 'done'",
                                            (name_of(frame), machine, design)).fetchone() is not None

    def found(self, mode):
        return {(frame, machine, design): (status, cpu, json.loads(document)) for frame, machine, design, status, cpu, document
                in self.databases[mode].execute("SELECT * FROM run")}


def name_of(frame):
    return f"{frame['scene']}-{frame['view']}-{frame['edge']}-{frame['rays']}"


def stratum_of(frame):
    if frame["edge"] >= EDGES["whole"][0] and frame["rays"] == 8:
        return "whole"
    if frame["scene"] in PUBLIC:
        return "public object" if frame["class"] == "object" else "public"
    return frame["designs"][-1]


def points(frames):
    """In the order in which they run: by turns one frame and machine of each stratum, warps of 8 rays first. Machines of more slots, which
    refuse all but whole frames, come after them, dear designs of public scenes last."""
    strata = defaultdict(list)
    for rays, turn in itertools.product((8, 32), range(len(FEW_SLOTS))):
        for number, frame in enumerate(frames):
            fits = [machine for machine in frame["machines"] if machine[0] in FEW_SLOTS]
            if frame["rays"] == rays and turn < len(fits):
                strata[stratum_of(frame)].append((frame, *sorted(fits)[(number + turn) % len(fits)]))
    for frame in frames:
        for machine in frame["machines"]:
            if machine[0] not in FEW_SLOTS:
                strata["whole" if stratum_of(frame) == "whole" else "many slots"].append((frame, *machine))
    many = strata.pop("many slots")
    found = [(*cell, design) for cell in [*filter(None, itertools.chain(*itertools.zip_longest(*strata.values()))), *many] for design in cell[0]["designs"]]
    return sorted(found, key=lambda point: point[0]["scene"] in PUBLIC and point[3] not in CHEAP)


def student_quantile(p, degrees):
    def cumulative(t):
        end, steps = math.atan(t / math.sqrt(degrees)), 400
        h = end / steps
        total = sum((1 if i in (0, steps) else 4 if i % 2 else 2) * math.cos(i * h) ** (degrees - 1) for i in range(steps + 1))
        return 0.5 + math.exp(math.lgamma((degrees + 1) / 2) - math.lgamma(degrees / 2)) / math.sqrt(math.pi) * total * h / 3
    low, high = 0.0, 1.0
    while cumulative(high) < p:
        high *= 2
    for _ in range(50):
        middle = (low + high) / 2
        low, high = (middle, high) if cumulative(middle) < p else (low, middle)
    return (low + high) / 2


def reach(influences, drift):
    """Half of the interval on the logarithm, as spread_of() of rtl_tlm/estimate/estimate.cpp has it."""
    pairs = len(influences) - 1
    squares = sum((after - before) ** 2 for before, after in zip(influences, influences[1:]))
    return student_quantile(0.975, max(2, 2 / 3 * pairs)) * math.sqrt(len(influences) / (2 * pairs) * squares + drift ** 2)


def case_of(what, name, frame, machine, truth, log_estimate, influences, drift, speed):
    off, half = log_estimate - math.log(truth), reach(influences, drift)
    shown = hashlib.sha256(f"{name_of(frame)} {machine}".encode()).digest()[0] % 2
    return {"what": what, "frame": name_of(frame), "class": frame["class"], "public": "yes" if frame["scene"] in PUBLIC else "no",
            "warps": -(-frame["edge"] ** 2 // frame["rays"]), "machine": machine, "slots": MACHINES[machine][1], "design": name, "half": ("tune", "show")[shown], "error": 100 * math.expm1(off), "width": 100 * math.expm1(half), "held": abs(off) <= half, "speed": speed}


def cases_of(frames, exact, estimated):
    """Cases, reasons of refusals by case, and [(name, held)] of the other statistics' intervals."""
    cases, refused, statistics = [], {}, []
    for frame in frames:
        for machine, _ in frame["machines"]:
            known = {}
            for design in frame["designs"]:
                key = (name_of(frame), machine, design)
                if key not in estimated:
                    continue
                status, cpu, document = estimated[key]
                if status != "done":
                    refused[key] = document["why"]
                    continue
                if key not in exact or exact[key][0] != "done":
                    continue
                estimate, truth = document["windows"], exact[key][2]["stats"]
                influences = [influence for _, _, influence in estimate["evidence"]]
                known[design] = truth["gpu.cycles"], estimate["log_cycles"], influences, estimate["drift"]
                cases.append(case_of("cycles", design, frame, machine, *known[design], exact[key][1] / cpu))
                statistics += [(name, low <= truth[name] <= high) for name, (low, high) in estimate["intervals"].items() if name in truth]
            first = frame["designs"][0]
            for design in frame["designs"][1:]:
                if first in known and design in known:
                    a, b = known[first], known[design]
                    cases.append(case_of("speed-up", f"{first} / {design}", frame, machine, a[0] / b[0], a[1] - b[1],
                                         [x - y for x, y in zip(a[2], b[2])], a[3] - b[3], None))
    return cases, refused, statistics


def is_public_place(case):
    return case["public"] == "yes" and case["class"] != "object"


def seldom(statistics):
    """Names whose intervals hold less often than LEAST."""
    by_name = defaultdict(list)
    for name, held in statistics:
        by_name[name].append(held)
    return ", ".join(f"{name} {sum(held)} of {len(held)}" for name, held in sorted(by_name.items())
                     if len(held) >= FEWEST and sum(held) < LEAST * len(held))


def row(name, cases):
    if not cases:
        return f"| {name} | 0 | | | | | |"
    errors, held = sorted(abs(case["error"]) for case in cases), sum(case["held"] for case in cases)
    speeds = sorted(case["speed"] for case in cases if case["speed"])
    return (f"| {name} | {len(cases)} | {held} | {100 * held / len(cases):.0f} % | {sum(errors) / len(errors):.1f} %, {errors[-1]:.1f} % | "
            f"{sum(case['width'] for case in cases) / len(cases):.1f} % | {f'{speeds[len(speeds) // 2]:.1f}' if speeds else ''} |")


def report(frames, study, path):
    exact, estimated = study.found("cycle"), study.found("windows")
    cases, refused, statistics = cases_of(frames, exact, estimated)
    print("| cases | number | held | | error: mean, worst | half-width, mean | times as fast, median |\n|---|---|---|---|---|---|---|")

    def rows(key, names, text="{}"):
        return [(text.format(name), lambda case, name=name: case[key] == name) for name in names]

    for name, is_in in [("all", lambda case: True), *rows("half", ("tune", "show"), "half `{}`"), *rows("what", ("cycles", "speed-up")),
                        *rows("class", ("room", "building", "object")), ("public rooms and buildings", lambda case: is_public_place(case)),
                        ("public objects", lambda case: case["public"] == "yes" and case["class"] == "object"),
                        *rows("slots", sorted({slots for _, slots, _ in MACHINES.values()}), "{} slots"),
                        *rows("design", DESIGNS), ("20,000 warps and more", lambda case: case["warps"] >= 20000)]:
        print(row(name, [case for case in cases if is_in(case)]))
    print(f"\n{len({case['frame'] for case in cases})} frames, public rooms and buildings: "
          f"{', '.join(sorted({case['frame'] for case in cases if is_public_place(case)})) or 'none'}")
    hours = sum(cpu for found in (exact, estimated) for _, cpu, _ in found.values()) / 3600
    print(f"\n{len(refused)} runs refused; {hours:.2f} processor hours.")
    for key, why in refused.items():
        print(f"refused: {', '.join(key)}: {why}")
    for case in cases:
        if not case["held"]:
            print(f"missed: {case['frame']}, {case['machine']}, {case['design']}: {case['error']:+.1f} % at +- {case['width']:.1f} %")
    if statistics:
        print(f"statistics: {100 * sum(held for _, held in statistics) / len(statistics):.0f} % of {len(statistics)} intervals held; below {LEAST:.0%}, of "
              f"{FEWEST} and more: {seldom(statistics) or 'none'}")
    if path:
        with open(path, "w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, list(cases[0]), lineterminator="\n")
            writer.writeheader()
            writer.writerows({key: f"{value:.4g}" if isinstance(value, float) else value for key, value in case.items()} for case in cases)


def run_all(study, todo, only=None):
    for point in todo if only != "report" else []:
        if only != "cycle":
            study.run("windows", *point)
        if only != "windows" and study.done("windows", point):
            study.run("cycle", *point)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", default=os.environ.get("GRTX_SCENES", "scenes"))
    parser.add_argument("--work", default=os.path.join(TOP, "build", "windows"))
    parser.add_argument("--program", default=os.environ.get("GRTX", os.path.join(TOP, "build/release/grtx")))
    parser.add_argument("--only", choices=("cycle", "windows", "report"))
    parser.add_argument("--plan", action="store_true", help="print frames and machines in the order in which they run, and run nothing")
    parser.add_argument("--retry", action="store_true", help="run what failed again")
    parser.add_argument("--csv", help="file for the cases")
    options = parser.parse_args()
    frames = draw()
    if options.plan:
        for (stratum, *cell), found in itertools.groupby(points(frames), lambda point: (stratum_of(point[0]), name_of(point[0]), *point[1:3])):
            print(f"{stratum:14}{cell[0]:32}{cell[1]:16}{cell[2]:<6}{', '.join(design for *_, design in found)}")
        return 0
    study = Study(options)
    run_all(study, points(frames), options.only)
    report(frames, study, options.csv)
    return 0


if __name__ == "__main__":
    sys.exit(main())
