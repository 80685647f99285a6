#!/usr/bin/env python3
"""bench/readings.py on databases whose ratios are known."""
import json
import os
import sqlite3
import subprocess
import sys
import tempfile
import unittest

SCRIPT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "bench", "readings.py")
NAMES = ("gpu.cycles", "gpu.l2.accesses", "gpu.rt.node_fetch_latency", "gpu.rt.node_fetches", "gpu.l1.node.hit_rate")
PAPER = {"baseline": (8720, 475, 177, 303, 0.5), "sw": (4360, 400, 150, 237, 0.75), "hw": (4495, 300, 120, 150, 0.5),
         "grtx": (2000, 100, 100, 100, 0.8)}  # the paper's ratios to three digits


class Readings(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = os.path.join(folder.name, "d.sqlite")
        self.database = sqlite3.connect(self.path)
        self.database.executescript("""
            CREATE TABLE point(id INTEGER PRIMARY KEY, scene TEXT, design TEXT, coordinates TEXT, status TEXT);
            CREATE TABLE value(point_id INTEGER, name TEXT, value REAL);""")

    def point(self, scene, design, coordinates, values, status="done"):
        number = self.database.execute("INSERT INTO point(scene, design, coordinates, status) VALUES (?, ?, ?, ?)",
                                       (scene, design, json.dumps(coordinates), status)).lastrowid
        self.database.executemany("INSERT INTO value VALUES (?, ?, ?)", [(number, *pair) for pair in zip(NAMES, values)])

    def run_script(self, *arguments):
        self.database.commit()
        return subprocess.run([sys.executable, SCRIPT, self.path, *arguments], capture_output=True, text=True, check=False)

    def test_the_paper_s_ratios_have_no_distance_and_classes_are_apart(self):
        for scene, slower in (("wang_sha", 1), ("hall-300000-1", 2), ("pizza", 1)):
            for design, values in PAPER.items():
                cycles = values[0] * (slower if design == "grtx" else 1)
                self.point(scene, design, {"l1.ways": 4, "view": 3}, (cycles, *values[1:]))
        self.point("wang_sha", "baseline", {"l1.ways": 8}, PAPER["baseline"])  # a reading without the other designs
        self.point("wang_sha", "sw", {"l1.ways": 4, "view": 3}, (1, 1, 1, 1, 1), status="failed")
        out = self.run_script().stdout
        self.assertEqual([line for line in out.splitlines() if line.endswith(" views:")],
                         ["public, 1 views:", "generated, 1 views:", "objects, 1 views:"])
        rows = [line for line in out.splitlines() if line.startswith("| `l1.ways` = 4 |")]
        self.assertEqual(rows[0], "| `l1.ways` = 4 | 2.00 | 1.94 | 4.36 | 4.75 | 1.77 | 3.03 | 2.37 | 75 % | 0.000 |")
        self.assertEqual(rows[1], "| `l1.ways` = 4 | 2.00 | 1.94 | 2.18 | 4.75 | 1.77 | 3.03 | 2.37 | 75 % | 0.080 |")  # ln(2)^2 / 6
        self.assertNotIn("= 8", out)

    def test_rounds_are_over_the_baseline_with_k_of_8_and_the_best_is_marked(self):
        def cycles(n):
            return (n, 1, 1, 1, 1)
        for k, n in ((8, 1000), (16, 800)):
            self.point("room-1-1", "baseline", {"tracer.k": k}, cycles(n))
        self.point("room-1-1", "sw", {"tracer.k": 1024, "tracer.tracing": "single"}, cycles(250))
        self.point("room-1-1", "grtx", {"tracer.k": 8, "rt.checkpoint.traffic": "charged"}, cycles(500))
        self.point("room-1-1", "grtx", {"tracer.k": 8, "rt.checkpoint.traffic": "uncharged"}, cycles(200))
        lines = self.run_script("--rounds").stdout.splitlines()
        self.assertIn("| view | design | k = 8 | k = 16 | single round |", lines)
        self.assertIn("| room-1-1 0 | baseline | 1.00 | **1.25** |  |", lines)
        self.assertIn("| room-1-1 0 | sw |  |  | **4.00** |", lines)
        self.assertIn("| room-1-1 0 | grtx, uncharged | **5.00** |  |  |", lines)
        self.assertIn("| room-1-1 0 | software alone (4.00) beats grtx with charged traffic (2.00), each at its best |  |  |  |", lines)

    def test_what_is_lacking_is_named(self):
        self.assertIn("no reading is there in all four designs", self.run_script().stderr)
        self.point("s", "sw", {}, (1, 2, 3))
        done = self.run_script()
        self.assertEqual((done.returncode, done.stderr), (1, f"readings.py: {self.path}: point 1 has no gpu.rt.node_fetches\n"))


if __name__ == "__main__":
    unittest.main()
