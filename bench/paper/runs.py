# SPDX-License-Identifier: Apache-2.0
"""Runs what a study asked for through the public commands of grtx, and answers from what they wrote. Everything lies in
one folder: scenes/, plans/, measures/, traces/ and the database runs.sqlite, which `grtx sweep` fills. All of it is
written atomically, so whoever is killed goes on where it was."""
import ctypes
import hashlib
import json
import lzma
import os
import re
import shutil
import signal
import sqlite3
import subprocess

from .study import Measurement, Point


class Failed(Exception):
    """A command of grtx that did not do its work; the message is one line. code: 2 for bad input, else 1."""

    def __init__(self, message, code=1):
        super().__init__(message)
        self.code = code


def scalar(text):
    """A value of the command line as TOML writes it."""
    if text in ("true", "false"):
        return text
    try:
        float(text)
        return text
    except ValueError:
        return json.dumps(text)


def die_with_parent():
    """Called in a child: whoever kills this program kills its runs (Linux)."""
    ctypes.CDLL(None).prctl(1, signal.SIGKILL)  # PR_SET_PDEATHSIG


def toml(value):
    return json.dumps(value)  # booleans, numbers and plain texts are the same in both


def flat(document):
    """Nested tables and lists as one: names joined by '.' -> value."""
    found = {}

    def walk(prefix, node):
        if isinstance(node, (dict, list)):
            for name, inner in node.items() if isinstance(node, dict) else enumerate(node):
                walk(f"{prefix}.{name}" if prefix else str(name), inner)
        else:
            found[prefix] = node

    walk("", document)
    return found


class Results:
    """program: grtx; folder: where it works; settings: key=value of the command line, for every simulation and cost."""

    def __init__(self, program, folder, scenes_folder, settings, limits, jobs, say):
        self.program, self.folder, self.scenes_folder = program, folder, scenes_folder
        self.settings, self.limits, self.jobs, self.say = settings, limits, jobs, say
        self.database = os.path.join(folder, "runs.sqlite")
        self.keys = {}      # Point -> its key in the database
        self.documents = {}
        # Of "grtx 1.0.0, model version 8, commit 4cb9e62b, GNU 12.2.0": which model the figures are of.
        printed = subprocess.run([program, "--version"], capture_output=True, text=True, check=True).stdout
        self.model = re.search(r"model version (\d+)", printed).group(1)
        for name in ("scenes", "plans", "measures"):
            os.makedirs(os.path.join(folder, name), exist_ok=True)

    def run(self, asked):
        """Makes whatever is missing. asked: Study.asked."""
        points, measurements = list(asked[Point]), list(asked[Measurement])
        for scene in {what.scene: None for what in points + measurements}:
            self.make_scene(scene)
        plans = self.plans(points)
        for number, (machine, text, members) in enumerate(plans, 1):
            self.say(f"plan {number} of {len(plans)}: {len(members)} points, machine {machine}")
            self.sweep(machine, text, members)
        for number, what in enumerate(measurements, 1):
            self.say(f"measurement {number} of {len(measurements)}: {what.scene.name}, {dict(what.options)['accel']}")
            self.measure(what)

    def of(self, what):
        """What a run said: name -> value."""
        if what not in self.documents:
            self.documents[what] = (self.values(what) if isinstance(what, Point) else
                                    self.measure(what) if isinstance(what, Measurement) else self.cost(what))
        return self.documents[what]

    # Scenes

    def scene_files(self, scene):
        if scene.preset:
            stem = os.path.join(self.folder, "scenes", scene.stem)
            return stem + ".ply", stem + ".cameras.json"
        plain = os.path.join(self.scenes_folder, scene.file + ".ply")
        unpacked = os.path.join(self.folder, "scenes", scene.file + ".ply")
        return (plain if os.path.exists(plain) else unpacked,
                os.path.join(self.scenes_folder, scene.cameras + ".cameras.json"))

    def make_scene(self, scene):
        ply, cameras = self.scene_files(scene)
        if os.path.exists(ply):
            return
        partial = os.path.join(self.folder, "scenes", "partial.ply")
        if scene.preset:
            self.call("synth", "--preset", scene.preset, "--count", scene.count, "--seed", scene.seed, "--sh-degree",
                      scene.sh_degree, "-o", partial)
            os.replace(partial.removesuffix(".ply") + ".cameras.json", cameras)  # first: where a scene is, its cameras are
        else:
            with lzma.open(os.path.join(self.scenes_folder, scene.file + ".ply.xz")) as packed, open(partial, "wb") as file:
                shutil.copyfileobj(packed, file)
        os.replace(partial, ply)

    # Simulations, by grtx sweep

    def plans(self, points):
        """[(machine, text of the plan, its points)]: scenes that share all points of a frame share a plan."""
        by_scene = {}
        for p in points:
            by_scene.setdefault((p.machine, p.frame, p.scene), []).append(p)
        grouped = {}
        for (machine, frame, scene), members in by_scene.items():
            options = tuple(sorted({p.options for p in members}, key=str))
            grouped.setdefault((machine, frame, options), []).append((scene, members))
        return [(machine, self.plan_text(frame, [s for s, _ in group], options),
                 [p for _, members in group for p in members])
                for (machine, frame, options), group in grouped.items()]

    def plan_text(self, frame, scenes, options):
        lines = ['mode = "cycle"']
        for scene in scenes:
            ply, cameras = self.scene_files(scene)
            lines += ["[[scene]]", f"name = {toml(scene.name)}", f"file = {toml(os.path.abspath(ply))}",
                      f"cameras = {toml(os.path.abspath(cameras))}", f"width = {frame.width}", f"height = {frame.height}",
                      f"fov_scale = {frame.fov_scale}"]
        keys = {name: toml(value) for name, value in frame.keys}
        keys.update((s.split("=", 1)[0], scalar(s.split("=", 1)[1])) for s in self.settings)
        lines += ["[set]"] + [f"{name} = {value}" for name, value in keys.items()]
        lines += ["[limits]"] + [f"{name} = {value}" for name, value in self.limits.items()]
        for point in options:
            lines += ["[[point]]"] + [f"{name} = {toml(value)}" for name, value in point]
        return "\n".join(lines) + "\n"

    def sweep(self, machine, text, members):
        path = os.path.join(self.folder, "plans", hashlib.sha256(text.encode()).hexdigest()[:16] + ".toml")
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
        for key, _, scene, _, coordinates in self.listed(path, machine):
            for p in members:
                if p.scene.name == scene and dict(p.options) == coordinates:
                    self.keys[p] = key
        lost = [p for p in members if p not in self.keys]
        if lost:
            raise Failed(f"{path}: no point of its own has {dict(lost[0].options)}: another one resolves to the same")
        if any(status != "done" for _, status, *_ in self.listed(path, machine)):
            self.call("sweep", path, "-o", self.database, "--machine", machine, "--jobs", self.jobs, "--retry",
                      accept=(0, 1))
        for key, status, scene, design, coordinates in self.listed(path, machine):
            if status != "done":
                raise Failed(f"{path}: {scene} {design} {coordinates}: {self.reason(key) or status}")

    def listed(self, path, machine):
        listed = json.loads(self.call("sweep", path, "-o", self.database, "--machine", machine, "--list", "--json"))
        for point in (p for p in listed["points"] if not p["earlier_plan"]):
            yield tuple(point[name] for name in ("key", "status", "scene", "design", "varied"))

    def query(self, sql, *arguments):
        connection = sqlite3.connect(f"file:{self.database}?mode=ro", uri=True)
        try:
            return connection.execute(sql, arguments).fetchall()
        finally:
            connection.close()

    def reason(self, key):
        return next((row[0] for row in self.query("SELECT reason FROM point WHERE key = ?", key)), None)

    def values(self, point):
        return dict(self.query("SELECT name, value FROM value JOIN point ON id = point_id WHERE key = ?", self.keys[point]))

    # Measurements and costs

    def measure(self, what):
        ply, cameras = self.scene_files(what.scene)
        arguments = ["--machine", what.machine, "--width", what.frame.width, "--height", what.frame.height,
                     "--fov-scale", what.frame.fov_scale]
        for name, value in what.options:
            arguments += ["--" + name.replace("_", "-"), value]
        for setting in self.settings:
            name, value = setting.split("=", 1)
            if name.startswith("tracer."):
                arguments += ["--" + name[7:].replace("_", "-"), value]
        key = hashlib.sha256(json.dumps([what.scene.stem, *map(str, arguments)]).encode()).hexdigest()[:16]
        path = os.path.join(self.folder, "measures", key + ".json")
        if not os.path.exists(path):
            partial = os.path.join(self.folder, "measures", "partial.json")
            threads = ["--threads", self.jobs] if self.jobs else []
            self.call("trace", "--scene", ply, "--cameras", cameras, *arguments, *threads, "--no-trace", "--stats", partial)
            os.replace(partial, path)
        with open(path, encoding="utf-8") as file:
            return {name: entry["value"] for name, entry in json.load(file)["stats"].items()}

    def cost(self, what):
        arguments = ["--machine", what.machine, "--design", what.design]
        for name, value in what.options:
            arguments += ["--" + name.replace("_", "-"), value]
        for setting in self.settings:
            if not setting.startswith("tracer."):
                arguments += ["--set", setting]
        return flat(json.loads(self.call("cost", *arguments, "--json")))

    def call(self, *arguments, accept=(0,)):
        """Runs grtx; returns what it printed. Throws Failed with its own line."""
        command = [self.program, *map(str, arguments), *([] if "--json" in arguments or "--list" in arguments else ["--quiet"])]
        run = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=die_with_parent)
        if run.returncode not in accept:
            lines = run.stderr.strip().splitlines()
            raise Failed(f"grtx {arguments[0]}: {lines[-1] if lines else f'exit code {run.returncode}'}",
                         2 if run.returncode == 2 else 1)
        return run.stdout
