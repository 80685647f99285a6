#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""bench/scene_class.py on a small scene: what it counts entry by entry is what the trace's totals and the simulation count, and a row outside
a given range is bold and ends with 1.

    scene_class_test.py GRTX
"""
import csv
import json
import os
import subprocess
import sys
import tempfile
import unittest

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
SCRIPT = os.path.join(ROOT, "bench", "scene_class.py")
sys.path.insert(0, os.path.dirname(SCRIPT))
PROGRAM = ""


class SceneClass(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.scene = os.path.join(temporary.name, "room.ply")
        self.file = lambda name: os.path.join(temporary.name, name)
        subprocess.run([PROGRAM, "synth", "--preset", "room", "--count", "3000", "-o", self.scene, "--quiet"], check=True)

    def measure(self, *more):
        return subprocess.run([SCRIPT, "--program", PROGRAM, "--size", "16", *more, self.scene + ":1"],
                              capture_output=True, text=True, check=False)

    def test_entries_are_those_that_the_simulation_counts(self):
        import scene_class  # from bench/
        trace, statistics = self.file("t.grtx"), self.file("s.json")
        cameras = self.scene.replace(".ply", ".cameras.json")
        # 16 x 16 pixels are eight warps, fewer than the sample takes: every entry is looked at.
        subprocess.run([PROGRAM, "trace", "--scene", self.scene, "--cameras", cameras, "--width", "16", "--height", "16", "--accel",
                        "tlas-tri20", "--checkpoint", "on", "-o", trace, "--quiet"], check=True)
        subprocess.run([PROGRAM, "sim", trace, "--stats", statistics, "--quiet"], check=True)
        with open(statistics, encoding="utf-8") as file:
            simulated = json.load(file)["stats"]
        entries = scene_class.look_at_entries(PROGRAM, trace)
        self.assertEqual(entries["written"], simulated["gpu.rt.checkpoint.entries_written"]["value"])
        self.assertEqual(entries["read"], simulated["gpu.rt.checkpoint.entries_read"]["value"])
        self.assertEqual(entries["forwarded"], simulated["gpu.rt.replay_forwards"]["value"])
        self.assertGreater(entries["blas"], 0)
        self.assertLess(entries["blas"], entries["written"])

    def test_rounds_and_visits_of_rays_add_up_to_the_totals(self):
        import scene_class  # from bench/
        trace, statistics = self.file("t.grtx"), self.file("s.json")
        subprocess.run([PROGRAM, "trace", "--scene", self.scene, "--cameras", self.scene.replace(".ply", ".cameras.json"), "--width", "16", "--height",
                        "16", "--accel", "tlas-tri20", "-o", trace, "--stats", statistics, "--quiet"], check=True)
        with open(statistics, encoding="utf-8") as file:
            traced = json.load(file)["stats"]
        rays = scene_class.rounds_and_visits(PROGRAM, trace)
        self.assertEqual(len(rays), traced["tracer.rays"]["value"])
        self.assertEqual(sum(rounds for rounds, _ in rays), traced["tracer.rounds"]["value"])
        self.assertEqual(sum(visits for _, visits in rays), traced["tracer.visits.total"]["value"])

    def test_a_visit_is_of_a_ray_of_more_rounds_than_a_ray(self):
        done = self.measure("--rounds")
        self.assertEqual(done.returncode, 0, done.stderr)
        by_ray, by_visit, ratio = (float(cell) for cell in done.stdout.splitlines()[-1].split("|")[2:5])
        self.assertGreater(by_visit, by_ray)
        self.assertGreater(ratio, 1)

    def test_what_lies_outside_a_range_is_bold(self):
        rows = self.file("rows.csv")
        done = self.measure("--csv", rows)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertNotIn("**", done.stdout)
        self.assertEqual(self.measure("--range", rows).returncode, 0)
        with open(rows, encoding="utf-8", newline="") as file:
            head, row = csv.reader(file)
        row[head.index("rounds")] = "99"
        with open(rows, "w", encoding="utf-8", newline="") as file:
            csv.writer(file).writerows([head, row])
        done = self.measure("--range", rows)
        self.assertEqual(done.returncode, 1)
        self.assertEqual(done.stdout.count("**"), 2)


if __name__ == "__main__":
    PROGRAM = os.path.abspath(sys.argv.pop(1))
    unittest.main()
