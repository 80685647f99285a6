#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Windows mode against cycle mode: how often its 95 % intervals hold, how wide they are, how much time they save.

    python3 bench/windows.py --scenes SCENES --work FOLDER [--only cycle|windows|report] [--plan] [--retry] [--csv F.csv]

The plan (windows_plan.py) is drawn by date, none of it by hand: generated scenes of six presets, small ones since cycle mode runs them
whole, and public ones (scripts/scenes.sh), each with machines of 8 to 512 warp slots and designs from shuffled decks. They run in strata:
by turns one frame and machine of each dear design and each kind of public scene and of whole frames, first on machines of up to 64
slots; last what takes minutes, dear designs of public scenes. Windows go first; what they refuse costs no run in cycle mode.
Results lie in FOLDER/cycle.sqlite and FOLDER/windows.sqlite; what is there is not run again, so a run that was killed goes on, and
another rule of windows mode needs windows.sqlite alone (remove the file). Traces lie in FOLDER/traces and serve all machines.
Cases (windows_report.py) are the cycles of each (frame, machine, design) and the speed-up over the first design of the same frame and
machine. A case is of half `tune` or `show` by a hash of its frame and machine: whoever changes the rule looks at the first half only.
"""
import argparse
import ctypes
import itertools
import json
import os
import re
import signal
import sqlite3
import subprocess
import sys
import tempfile

from windows_plan import DESIGNS, MACHINES, draw, name_of, points, stratum_of
from windows_report import report

TOP = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))


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
        command = [self.options.program, *arguments, "--quiet"]
        with subprocess.Popen(command, stderr=subprocess.PIPE, text=True, preexec_fn=die_with_parent) as run:
            line = ""
            for line in run.stderr:
                why = re.search(r"all of it is simulated, in cycle mode: (.*)", line)
                if refusable and why:
                    run.kill()
                    raise Refused(why.group(1))
        if run.returncode != 0:
            raise RuntimeError(f"grtx {arguments[0]}: {line.strip() or run.returncode}")

    def make(self, path, *arguments):
        """A file that a command makes: whole, or not at all."""
        self.call(*arguments, path + ".partial")
        os.replace(path + ".partial", path)
        return path

    def options_of(self, design):
        """Options of the tracer that belong to a design: those that its machine has from it."""
        command = [self.options.program, "machine", "paper", "--design", design, "--json"]
        run = subprocess.run(command, capture_output=True, text=True, check=False)
        if run.returncode != 0:
            raise RuntimeError(f"grtx machine: {run.stderr.strip() or run.returncode}")
        own = {name: key["value"] for name, key in json.loads(run.stdout)["keys"].items() if key["from"] == f"--design {design}"}
        return [text for name, value in own.items() if name.startswith("tracer.")
                for text in ("--" + name[len("tracer."):].replace("_", "-"), str(value))]

    def trace(self, frame, design):
        if "preset" in frame:
            stem = os.path.join(self.options.work, "traces", frame["scene"])
            if not os.path.exists(stem + ".ply"):
                self.call("synth", "--preset", frame["preset"], "--count", str(frame["count"]), "--seed", str(frame["scene_seed"]),
                          "-o", stem + ".ply")
        else:
            stem = os.path.join(self.options.scenes, frame["scene"])
        path = os.path.join(self.options.work, "traces", f"{name_of(frame)}.{design}.grtx")
        if os.path.exists(path):
            return path
        return self.make(path, "trace", "--scene", stem + ".ply", "--cameras", stem + ".cameras.json", "--view", str(frame["view"]),
                         "--width", str(frame["edge"]), "--height", str(frame["edge"]), "--warp-size", str(frame["rays"]),
                         *DESIGNS[design], *self.options_of(design), "--threads", "1", "-o")

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
                self.call("sim", self.trace(frame, design), "--machine", named, "--design", design,
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
        found = self.databases[mode].execute("SELECT status FROM run WHERE frame = ? AND machine = ? AND design = ?",
                                             (name_of(frame), machine, design)).fetchone()
        return found is not None and found[0] == "done"

    def found(self, mode):
        return {(frame, machine, design): (status, cpu, json.loads(document)) for frame, machine, design, status, cpu, document
                in self.databases[mode].execute("SELECT * FROM run")}


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
        cells = itertools.groupby(points(frames), lambda point: (stratum_of(point[0]), name_of(point[0]), *point[1:3]))
        for (stratum, *cell), found in cells:
            print(f"{stratum:14}{cell[0]:32}{cell[1]:16}{cell[2]:<6}{', '.join(design for *_, design in found)}")
        return 0
    study = Study(options)
    run_all(study, points(frames), options.only)
    report(frames, study, options.csv)
    return 0


if __name__ == "__main__":
    sys.exit(main())
