#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""scripts/card_kit.py: what it writes is read by grtx sweep and grtx correlate, and a card that is the model itself has no error.

    card_kit_test.py GRTX
"""
import csv
import json
import os
import sqlite3
import subprocess
import sys
import tempfile
import unittest

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
PROGRAM = ""


class CardKit(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def grtx(self, *arguments):
        done = subprocess.run([PROGRAM, *arguments], capture_output=True, text=True, cwd=self.folder)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def fill(self, value_of):
        with open(os.path.join(self.folder, "measured.csv"), encoding="utf-8") as file:
            lines = list(csv.DictReader(line for line in file if not line.startswith("#")))
        with open(os.path.join(self.folder, "filled.csv"), "w", encoding="utf-8", newline="") as file:
            writer = csv.DictWriter(file, lines[0])
            writer.writeheader()
            writer.writerows({**line, "value": value_of(line)} for line in lines)
        return json.loads(self.grtx("correlate", "filled.csv", "card.sqlite", "--json"))

    def test_a_card_that_is_the_model_has_no_error_and_one_twice_as_slow_half_its_time(self):
        kit = [sys.executable, os.path.join(ROOT, "scripts", "card_kit.py"), self.folder, "--card", "a card", "--sms", "100", "--mhz",
               "2000", "--program", PROGRAM, "--count", "500"]
        subprocess.run(kit, check=True, capture_output=True)
        empty = subprocess.run([PROGRAM, "correlate", "measured.csv", "x.sqlite"], capture_output=True, text=True, cwd=self.folder)
        self.assertEqual(empty.returncode, 2)
        self.grtx("sweep", "plan.toml", "-o", "card.sqlite", "--machine", os.path.join(ROOT, "configs/sweeps/quarters/ada.toml"), "--quiet")
        database = sqlite3.connect(os.path.join(self.folder, "card.sqlite"))
        self.addCleanup(database.close)
        times = {}
        for number, scene, at in database.execute("SELECT id, scene, coordinates FROM point").fetchall():
            at = json.loads(at)
            value = dict(database.execute("SELECT name, value FROM value WHERE point_id = ?", (number,)))
            full = value["gpu.cycles"] * value["gpu.rt.occupancy"] / 8  # entries of a warp buffer
            # 900 crops of 48 x 48, two of a hundred SMs
            times[scene, at["tracer.accel"], str(at["tracer.kernel_degree"])] = full * 900 * 2 / 100 / 2000e3
        self.assertEqual(len(times), 12)
        key = lambda line: (line["scene"], line["design"], line["tracer.kernel_degree"])
        for slower in (1, 2):
            result = self.fill(lambda line: times[key(line)] * slower)
            self.assertEqual(len(result["comparisons"]), 12)
            for one in result["comparisons"]:
                self.assertAlmostEqual(one["simulated"] / one["measured"], 1 / slower, places=6)
            self.assertEqual(result["unmatched"], [])


if __name__ == "__main__":
    PROGRAM = os.path.abspath(sys.argv.pop(1))
    unittest.main()
