#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""bench/readings.py on databases whose ratios are known."""
import json
import os
import sqlite3
import subprocess
import sys
import tempfile
import unittest

SCRIPT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "bench", "readings.py")


class Readings(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = os.path.join(folder.name, "d.sqlite")
        self.database = sqlite3.connect(self.path)
        self.database.executescript("""
            CREATE TABLE point(id INTEGER PRIMARY KEY, mode TEXT, scene TEXT, design TEXT, coordinates TEXT, status TEXT,
                               trace_key TEXT);
            CREATE TABLE trace(key TEXT, options TEXT);
            CREATE TABLE value(point_id INTEGER, name TEXT, value REAL);""")

    def point(self, design, cycles, coordinates=None, scene="lacadiere", mode="sampled", **values):
        number = self.database.execute("INSERT INTO point(mode, scene, design, coordinates, status) VALUES (?, ?, ?, ?, 'done')",
                                       (mode, scene, design, json.dumps(coordinates or {}))).lastrowid
        usual = {"l2.accesses": 100, "rt.node_fetch_latency": 50, "rt.node_fetches": 10, "l1.node.hit_rate": 0.9}
        for name, value in {**usual, "cycles": cycles, **{k.replace("__", "."): v for k, v in values.items()}}.items():
            self.database.execute("INSERT INTO value VALUES (?, ?, ?)", (number, "gpu." + name, value))

    def run_script(self, *arguments):
        self.database.commit()
        done = subprocess.run([sys.executable, SCRIPT, *arguments, self.path], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def test_what_is_lacking_is_named(self):
        done = subprocess.run([sys.executable, SCRIPT, self.path], capture_output=True, text=True)
        self.assertIn("no reading is there in all four designs", done.stderr)
        self.point("sw", 100)
        self.database.execute("DELETE FROM value WHERE name = 'gpu.rt.node_fetches'")
        self.database.commit()
        done = subprocess.run([sys.executable, SCRIPT, self.path], capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stderr), (1, f"readings.py: {self.path}: point 1 has no gpu.rt.node_fetches\n"))

    def test_the_paper_s_ratios_have_no_distance(self):
        paper = {"baseline": (8720, 475, 177, 303), "sw": (4360, 400, 150, 237), "hw": (4495, 300, 120, 150), "grtx": (2000, 100, 100, 100)}
        for design, (cycles, l2, latency, fetches) in paper.items():
            self.point(design, cycles, **{"l2.accesses": l2, "rt.node_fetch_latency": latency, "rt.node_fetches": fetches})
        self.assertIn("| 2.00 | 1.94 | 4.36 | 4.75 | 1.77 | 3.03 | 2.37 | 90 % | 0.000 |", self.run_script())

    def test_means_are_geometric_over_the_views_of_a_class(self):
        for scene, cycles in (("lacadiere", (800, 400, 400, 200)), ("taebak", (800, 100, 400, 200)), ("hall-300000-211", (900, 300, 300, 100))):
            for design, c in zip(("baseline", "sw", "hw", "grtx"), cycles):
                self.point(design, c, scene=scene)
                self.point(design, c + 1, scene=scene, mode="cycle")  # of no account
        out = self.run_script()
        self.assertIn("public, 2 views:", out)
        self.assertIn("| as the machine is | 4.00 | 2.00 | 4.00 | 1.00 | 1.00 | 1.00 | 1.00 | 90 % |", out)
        self.assertIn("generated, 1 views:", out)
        self.assertIn("| as the machine is | 3.00 | 3.00 | 9.00 |", out)

    def test_software_alone_is_set_against_grtx_each_at_its_best(self):
        for k, base, sw in ((8, 1000, 600), (16, 900, 500)):
            self.point("baseline", base, {"tracer.k": k})
            self.point("sw", sw, {"tracer.k": k})
        self.point("sw", 250, {"tracer.k": 1024, "tracer.tracing": "single"})
        for traffic, cycles in (("uncharged", 200), ("charged", 400)):
            self.point("grtx", cycles, {"tracer.k": 8, "rt.checkpoint.traffic": traffic})
            self.point("grtx", cycles * 2, {"tracer.k": 4, "rt.checkpoint.traffic": traffic})
        out = self.run_script("--rounds")
        self.assertIn("| lacadiere 0 | sw |  | 1.67 | 2.00 | **4.00** |", out)
        self.assertIn("| lacadiere 0 | 1.11 (16) | 4.00 (single) | 5.00 (8) | 2.50 (8) | 0.80 | 1.60 |", out)

    def test_without_a_baseline_speed_ups_are_over_sw(self):
        for k, cycles in ((8, 600), (16, 500)):
            self.point("sw", cycles, {"tracer.k": k})
        for traffic, cycles in (("uncharged", 200), ("charged", 400)):
            self.point("grtx", cycles, {"tracer.k": 8, "rt.checkpoint.traffic": traffic})
        out = self.run_script("--rounds")
        self.assertIn("speed-up over sw with k = 8:", out)
        self.assertIn("| lacadiere 0 |  | 1.20 (16) | 3.00 (8) | 1.50 (8) | 0.40 | 0.80 |", out)

    def test_latency_is_what_is_under_way_over_what_comes_a_cycle(self):
        usual = {"rt.occupancy": 8, "rt.node_fetches": 100, "rt.node_sectors": 200, "l1.node.reads": 20, "rt.warp_cycles.ready": 1, "rt.warp_cycles.memory": 3}
        self.point("baseline", 1000, **{**usual, "rt.occupancy_integral": 16000, "rt.node_fetch_latency": 400, "l1.node.hits": 10, "l1.miss_latency": 380,
                                        "rt.stall.queue_full": 500})
        self.point("grtx", 200, **{**usual, "rt.occupancy_integral": 3200, "rt.node_fetches": 40, "rt.node_fetch_latency": 100, "l1.node.hits": 15, "l1.miss_latency": 180})
        out = self.run_script("--latency")
        self.assertIn("| lacadiere 0 | baseline | 400 | 20 | 50 | 10% | 25% | 25% | 210 | 400 | 90 % |", out)  # two units
        self.assertIn("| lacadiere 0 | grtx | 100 | 10 | 100 | 50% | 0% | 25% | 65 | 200 | 90 % |", out)
        self.assertIn("| public, 1 | 4.00 | 2.00 | 2.00 | 3.23 | 2.00 |", out)

    def test_primary_and_secondary_rays_are_each_compared_with_their_own(self):
        for design, primary, secondary in (("baseline", 60, 40), ("sw", 30, 40), ("hw", 20, 10), ("grtx", 10, 10)):
            self.point(design, primary + secondary, **{"rays.primary_cycles": primary, "rays.secondary_cycles": secondary})
        out = self.run_script("--parts")
        self.assertIn("| lacadiere 0 | secondary | 1.00 | 4.00 | 4.00 |", out)
        self.assertIn("| lacadiere 0 | primary | 2.00 | 3.00 | 6.00 |", out)

    def test_trends_are_rank_correlations_over_views(self):
        for i, scene in enumerate("abcde"):
            for design in ("baseline", "sw", "hw", "grtx"):
                cycles = {"baseline": 1000, "sw": 1000 - 10 * i, "hw": 500 + 10 * i, "grtx": 100}[design]
                self.point(design, cycles, scene=scene, **{"rt.node_fetches.leaf": i + 1, "rt.node_visits": 20 - i, "rt.any_hit_calls": 1, "l1.node.hit_rate": 0.5 + i / 10})
        out = self.run_script("--trends")
        self.assertIn("public, 5 views, rank correlation of leaves of the fetches: +1.00 with sw, -1.00 with hw", out)
        self.assertIn("rank correlation of visits a hit: -1.00 with sw, +1.00 with hw", out)


if __name__ == "__main__":
    unittest.main()
