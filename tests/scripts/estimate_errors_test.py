#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""bench/estimate_errors.py on a database whose errors are known: cycle mode 1000 and 500 cycles, estimates beside them."""
import json
import math
import os
import sqlite3
import subprocess
import sys
import tempfile
import unittest

SCRIPT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "bench", "estimate_errors.py")


class EstimateErrors(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.path = os.path.join(folder.name, "d.sqlite")
        self.database = sqlite3.connect(self.path)
        self.database.executescript("""
            CREATE TABLE point(id INTEGER PRIMARY KEY, mode TEXT, scene TEXT, design TEXT, coordinates TEXT, status TEXT,
                               seconds REAL);
            CREATE TABLE value(point_id INTEGER, name TEXT, value REAL);""")

    def point(self, mode, design, cycles, coordinates=None, status="done", seconds=0, **values):
        number = self.database.execute("INSERT INTO point(mode, scene, design, coordinates, status, seconds) VALUES (?, 's', ?, ?, ?, ?)",
                                       (mode, design, json.dumps(coordinates or {}), status, seconds)).lastrowid
        for name, value in {"cycles": cycles, **values}.items():
            self.database.execute("INSERT INTO value VALUES (?, ?, ?)", (number, "gpu." + name.replace("__", "."), value))

    def run_script(self, *arguments):
        self.database.commit()
        return subprocess.run([sys.executable, SCRIPT, f"m={self.path}", *arguments], capture_output=True, text=True)

    def test_errors_are_those_of_cycles_and_of_speed_ups(self):
        self.point("cycle", "baseline", 1000, seconds=8)
        self.point("cycle", "grtx", 500)
        self.point("windows", "baseline", 1010, seconds=2)
        self.point("windows", "grtx", 490)  # speed-up 2.0612 in place of 2
        out = self.run_script("--cases").stdout
        self.assertIn("| windows | m | 2 | 1.5 % | 2.0 % | -2.0 % | s 0, m, grtx |", out)
        self.assertIn("| windows | m | 1 | 3.1 % | 3.1 % | +3.1 % | s 0, m, grtx |", out)
        self.assertIn("| windows | m | s | 0 |  | baseline | 1000 | +1.0 % |  | 4.0 |", out)

    def test_cases_of_scenes_that_took_part_stand_apart(self):
        for design, cycles, estimate in (("baseline", 1000, 1010), ("grtx", 500, 490)):
            self.point("cycle", design, cycles)
            self.point("windows", design, estimate)
        out = self.run_script("--used", "other 0, s 0").stdout
        self.assertIn("| windows | m, used | 2 | 1.5 % | 2.0 % | -2.0 % | s 0, m, grtx |", out)
        self.assertNotIn("held out", out)
        self.assertIn("| windows | all, held out | 2 | 1.5 % |", self.run_script("--used", "s 1").stdout)

    def test_cases_on_record_are_those_of_the_database(self):
        for design, cycles, estimate in (("baseline", 1000, 1010), ("grtx", 500, 490)):
            self.point("cycle", design, cycles)
            self.point("windows", design, estimate)
        path = os.path.join(self.folder, "cases.csv")
        out = self.run_script("--cases", "--csv", path).stdout
        recorded = subprocess.run([sys.executable, SCRIPT, f"m={path}", "--cases"], capture_output=True, text=True)
        self.assertEqual(recorded.stdout, out)

    def test_coordinates_that_cycle_mode_lacks_have_nothing_to_be_compared_with(self):
        self.point("cycle", "grtx", 500, {"tracer.k": 8})
        self.point("windows", "grtx", 501, {"tracer.k": 8})
        self.point("windows", "grtx", 900, {"tracer.k": 16})
        self.point("windows", "grtx", 900, {"tracer.k": 8}, status="failed")
        self.assertIn("| windows | m | 1 | 0.2 % | 0.2 % | +0.2 % | s 0, m, grtx, tracer.k = 8 |", self.run_script().stdout)

    def test_intervals_are_counted_where_they_have_a_width(self):
        for k, (cycles, low, high) in enumerate([(505, 490, 510), (520, 510, 530), (500, 500, 500)], 1):
            self.point("cycle", "grtx", 500, {"tracer.k": k})
            self.point("windows", "grtx", cycles, {"tracer.k": k}, windows__cycles_low=low, windows__cycles_high=high)
        # Half widths: 505 / 490 and 520 / 510.
        self.assertIn("Intervals of cycles in windows mode that held the true value: 1 of 2 (50 %); half of an interval is 2.5 % in the mean.", self.run_script().stdout)

    def statistics(self, name, cycles, estimate=None):
        document = {"stats": {"gpu.cycles": {"value": cycles}}}
        if estimate is not None:
            document["windows"] = {"log_cycles": math.log(cycles), "whole": False, "degrees_of_freedom": 20, "bias": [0.01, 0.01],
                                   "evidence": [[group, 0, influence] for group, influence in estimate.items()]}
        with open(os.path.join(self.folder, name + ".json"), "w", encoding="utf-8") as file:
            json.dump(document, file)

    def run_windows(self, *arguments):
        return subprocess.run([sys.executable, SCRIPT, "--windows", f"m={self.folder}", *arguments], capture_output=True, text=True).stdout

    def test_windows_against_whole_traces_by_the_constants_of_the_program_or_others(self):
        self.statistics("room.baseline.whole", 1000)
        self.statistics("room.grtx.whole", 500)
        # Half of an interval by the constant alone is exp(2.776 * 0.01) - 1 = 2.8 %.
        self.statistics("room.baseline.1", 1020, {})
        self.statistics("room.baseline.2", 1040, {})
        self.statistics("room.grtx.1", 510, {})
        self.statistics("room.grtx.2", 510, {})
        out = self.run_windows()
        self.assertIn("| windows | m | 4 | 2.5 % | 4.0 % | +4.0 % | room 0, m, baseline, seed = 2 |", out)
        self.assertIn("Intervals of cycles in windows mode that held the true value: 3 of 4 (75 %); half of an interval is 2.8 %", out)
        self.assertIn("Intervals of speed-ups in windows mode that held the true value: 2 of 2 (100 %)", out)
        wider = self.run_windows("--constants", "0.02,0.001")
        self.assertIn("of cycles in windows mode that held the true value: 4 of 4", wider)
        self.assertIn("of speed-ups in windows mode that held the true value: 1 of 2", wider)

    def test_what_the_same_windows_took_too_long_in_both_designs_cancels_in_the_speed_up(self):
        for name, cycles in (("baseline", 1000), ("grtx", 500)):
            self.statistics(f"room.{name}.whole", cycles)
            self.statistics(f"room.{name}.1", cycles, {8: 0.03, 16: 0.04})
        out = self.run_windows("--constants", "0,0.001")
        # 2.086 * sqrt(22 / 20 * (0.03^2 + 0.04^2)) on the logarithm
        self.assertIn("2 of 2 (100 %); half of an interval is 11.6 %", out)
        self.assertIn("1 of 1 (100 %); half of an interval is 0.3 %", out)

    def test_limits_and_an_empty_comparison_fail(self):
        self.point("cycle", "grtx", 500)
        self.assertEqual(self.run_script().returncode, 1)
        self.point("windows", "grtx", 520)
        self.assertEqual(self.run_script("--max-worst", "4.1", "--max-mean", "4.1").returncode, 0)
        failed = self.run_script("--max-worst", "3.9")
        self.assertEqual(failed.returncode, 1)
        self.assertIn("worst error of cycles 4.00 % exceeds 3.9 %", failed.stderr)


if __name__ == "__main__":
    unittest.main()
