#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The plans of cards (configs/sweeps/silicon*.toml) run as a whole, on small scenes of the names that they give and fewer pixels, and what
docs/results/silicon.md does with their databases works: the tables of bench/silicon.py, and grtx correlate.

    silicon_plans_test.py GRTX
"""
import glob
import json
import os
import subprocess
import sys
import tempfile
import tomllib
import unittest

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
PROGRAM = ""
POINTS = os.path.join(ROOT, "data", "measured", "points.csv")
# Of each plan: the machine, the tables, and the card of which grtx correlate has this many comparisons.
USES = {"silicon": ("ada", [["ms", "--fitted", "lacadiere,taebak"]], ("RTX 6000 Ada", 7)),
        "silicon_show": ("ada", [["ms", "--fitted", "lacadiere,taebak"]], ("RTX 6000 Ada", 3)),
        "silicon_16": ("blackwell", [["rivals"], ["ms", "--card", "RTX 5090"]], ("RTX 5090", 1)),
        "silicon_paper": ("blackwell", [["structures"]], ("RTX 5090", 1)),
        "silicon_128": ("rdna4", [["structures"], ["spheres"]], None),
        "silicon_checkpoints": ("ada", [["checkpoints"]], None)}


class SiliconPlans(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def run_in(self, *command):
        done = subprocess.run(command, capture_output=True, text=True, cwd=self.folder)
        self.assertEqual(done.returncode, 0, f"{command}: {done.stderr}")
        return done.stdout

    def scene(self, view, seed):
        for name in ("file", "cameras"):
            os.makedirs(os.path.join(self.folder, os.path.dirname(view[name])), exist_ok=True)
        made = os.path.join(self.folder, "made.ply")
        self.run_in(PROGRAM, "synth", "--preset", "hall", "--count", "200", "--seed", str(seed), "-o", made, "--quiet")
        os.replace(made, os.path.join(self.folder, view["file"]))
        os.replace(made.replace(".ply", ".cameras.json"), os.path.join(self.folder, view["cameras"]))

    def frames_of(self, text):
        """A row for each degree and structure of the plan's first scene: `frames` ended with a KeyError for each plan."""
        first, *others = text.split("[[scene]]\n")[1:]
        text = "[[scene]]\n" + first + others[-1][others[-1].index("[limits]"):]
        with open(os.path.join(self.folder, "first.toml"), "w", encoding="utf-8") as file:
            file.write(text)
        settings = tomllib.loads(text)
        grid = settings["grid"]["tracer"]
        rows = self.run_in(sys.executable, os.path.join(ROOT, "bench", "silicon.py"), "frames", "first.toml", "--program", PROGRAM).splitlines()[2:]
        self.assertEqual({tuple(row.split(",")[:3]) for row in rows},
                         {(view["name"], str(degree), accel) for view in settings["scene"] for degree in grid["kernel_degree"]
                          for accel in ("tri20", "tlas-tri20", "tlas-box")})

    def test_each_runs_as_a_whole_and_what_reads_it_finds_its_points(self):
        with open(os.path.join(ROOT, "configs", "scenes", "scenes.txt"), encoding="utf-8") as file:
            public = {line.split()[0] for line in file if line[0] != "#"}
        plans = {os.path.splitext(os.path.basename(path))[0]: path for path in glob.glob(os.path.join(ROOT, "configs", "sweeps", "silicon*.toml"))}
        self.assertEqual(set(plans), set(USES))
        for name, path in plans.items():
            with open(path, encoding="utf-8") as file:
                text = file.read()
            for seed, view in enumerate(tomllib.loads(text)["scene"], 1):
                self.assertIn(os.path.basename(view["file"]).removesuffix(".ply"), public, name)
                self.scene(view, seed)
                text = text.replace(f"width = {view['width']}\n", "width = 8\n").replace(f"height = {view['height']}\n", "height = 8\n")
            with open(os.path.join(self.folder, name + ".toml"), "w", encoding="utf-8") as file:
                file.write(text)
            machine, tables, compared = USES[name]
            self.run_in(PROGRAM, "sweep", name + ".toml", "-o", name + ".sqlite", "--machine",
                        os.path.join(ROOT, "configs", "sweeps", "quarters", machine + ".toml"), "--quiet")
            for table, *more in tables:
                self.run_in(sys.executable, os.path.join(ROOT, "bench", "silicon.py"), table, name + ".sqlite", *more)
            if name == "silicon_show":
                self.frames_of(text)
            if compared:
                card, count = compared
                found = json.loads(self.run_in(PROGRAM, "correlate", POINTS, name + ".sqlite", "--card", card, "--json"))
                self.assertEqual(len(found["comparisons"]), count, name)


if __name__ == "__main__":
    PROGRAM = os.path.abspath(sys.argv.pop(1))
    unittest.main()
