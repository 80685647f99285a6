# SPDX-License-Identifier: Apache-2.0
"""bench/checkpoints.py on a small database: what a point is called, speeds over another, counts, and nothing to compare."""
import json
import os
import sqlite3
import subprocess
import sys
import tempfile
import unittest

SCRIPT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "bench", "checkpoints.py")
LEAN = {"rt.checkpoint.traffic": "charged", "tracer.checkpoint_bins": 4, "tracer.below_instance": "finish", "rt.checkpoint.entry_bytes": 8,
        "rt.checkpoint.write_combine": True, "rt.checkpoint.read_buffer": True}


class Checkpoints(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = os.path.join(folder.name, "d.sqlite")
        self.database = sqlite3.connect(self.path)
        self.addCleanup(self.database.close)
        self.database.executescript("""
            CREATE TABLE point(id INTEGER PRIMARY KEY, scene TEXT, design TEXT, coordinates TEXT, status TEXT);
            CREATE TABLE value(point_id INTEGER, name TEXT, value REAL);""")

    def point(self, cycles, coordinates, design="hw", status="done", **values):
        number = self.database.execute("INSERT INTO point(scene, design, coordinates, status) VALUES ('room', ?, ?, ?)",
                                       (design, json.dumps(coordinates), status)).lastrowid
        for name, value in {"gpu.cycles": cycles, **values}.items():
            self.database.execute("INSERT INTO value VALUES (?, ?, ?)", (number, name, value))

    def run_script(self, *arguments, code=0):
        self.database.commit()
        done = subprocess.run([sys.executable, SCRIPT, self.path, *arguments], capture_output=True, text=True)
        self.assertEqual(done.returncode, code, done.stderr)
        return [line for line in done.stdout.splitlines() if not line.startswith("| ---")]

    def test_speeds_are_over_free_lists_that_do_not_overflow(self):
        self.point(1000, {"rt.checkpoint.traffic": "uncharged", "tracer.checkpoint_capacity": 8192})
        self.point(800, {"rt.checkpoint.traffic": "uncharged", "tracer.checkpoint_capacity": 1024})
        self.point(2000, {"rt.checkpoint.traffic": "charged", "tracer.checkpoint_capacity": 1024})
        self.point(1250, LEAN)
        self.point(1600, {key: value for key, value in LEAN.items() if key != "rt.checkpoint.read_buffer"})
        self.point(1, LEAN, status="failed")
        self.assertEqual(self.run_script(), ["| hw | free | free, lists of 1,024 | charged | lean | bins, finished, 8 B, gathered |",
                                             "| room | 1.00 | 1.25 | 0.50 | 0.80 | 0.62 |", ""])

    def test_designs_of_a_plan_with_structures_share_a_table(self):
        sphere = {"tracer.accel": "tlas-sphere", "tracer.k": 16, "rt.checkpoint.traffic": "charged"}
        self.point(300, {**sphere, "tracer.checkpoint": "on"}, design="tlas-sphere+checkpoint")
        self.point(450, {**sphere, "tracer.checkpoint": "off"}, design="tlas-sphere")
        self.point(600, {**sphere, "tracer.k": 1024, "tracer.tracing": "single", "tracer.checkpoint": "off"}, design="tlas-sphere")
        self.assertEqual(self.run_script("--over", "tlas-sphere, k = 16, charged")[1], "| room | 1.00 | 0.67 | 0.50 |")

    def test_counts_have_their_units(self):
        self.point(1, LEAN, **{"gpu.dram.bytes": 2.5e6, "gpu.energy_nj": 3e6, "gpu.rt.node_visits": 12345, "cost.rt_unit_mm2": 0.9359})
        row = self.run_script("--counts", "room")[1].split(" | ")
        self.assertEqual((row[0], row[1], row[7], row[9], row[10]), ("| lean", "12,345", "2.5", "3.0", "0.936 |"))

    def test_nothing_to_compare_is_said_by_the_code(self):
        self.point(1, LEAN)
        self.assertEqual(self.run_script(code=1), [])
        self.assertEqual(self.run_script("--counts", "hall", code=1), [])


if __name__ == "__main__":
    unittest.main()
