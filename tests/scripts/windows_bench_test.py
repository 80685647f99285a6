#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""bench/windows.py: its plan, and its report of databases whose errors are known."""
import json
import math
import os
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "bench"))
import windows  # noqa: E402
import windows_plan  # noqa: E402
import windows_report  # noqa: E402


class Plan(unittest.TestCase):
    def test_is_the_same_each_time_and_has_all_machines_designs_and_classes(self):
        frames = windows_plan.draw()
        self.assertEqual(frames, windows_plan.draw())
        self.assertEqual({name for frame in frames for name, _ in frame["machines"]}, set(windows_plan.MACHINES))
        self.assertEqual({design for frame in frames for design in frame["designs"]}, set(windows_plan.DESIGNS))
        self.assertEqual({frame["class"] for frame in frames}, {"room", "building", "object"})
        self.assertEqual(len({windows_plan.name_of(frame) for frame in frames}), len(frames))

    def test_a_beginning_has_all_designs_classes_few_slots_and_public_rooms(self):
        points = windows_plan.points(windows_plan.draw())
        self.assertEqual(len({(windows_plan.name_of(frame), machine, design) for frame, machine, _, design in points}), len(points))
        self.assertEqual(len(points), sum(len(frame["machines"]) * len(frame["designs"]) for frame in windows_plan.draw()))
        first = points[:150]
        for design in windows_plan.DESIGNS:
            self.assertGreaterEqual(sum(point[3] == design for point in first), 7, design)
        for name in windows_plan.FEW_SLOTS:
            self.assertGreaterEqual(sum(point[1] == name for point in first), 30, name)
        self.assertGreaterEqual(len({frame["scene"] for frame, *_ in first if windows_plan.stratum_of(frame) == "public"}), 4)
        self.assertEqual({frame["class"] for frame, *_ in first}, {"room", "building", "object"})


class Report(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        program = os.path.join(self.folder, "grtx")  # never runs a simulation: what cycle mode took is there already
        with open(program, "w", encoding="utf-8") as file:
            file.write("#!/bin/sh\nexit 3\n")
        os.chmod(program, 0o755)
        self.options = ["--work", self.folder, "--program", program, "--only", "report"]
        self.frame = next(frame for frame in windows_plan.draw() if len(frame["designs"]) == 3)
        options = type("Options", (), {"work": self.folder, "program": program, "retry": False})
        self.study = windows.Study(options)

    def put(self, mode, design, status, cpu, document):
        key = (windows_plan.name_of(self.frame), self.frame["machines"][0][0], design)
        with self.study.databases[mode] as database:
            database.execute("INSERT INTO run VALUES (?, ?, ?, ?, ?, ?)", (*key, status, cpu, json.dumps(document)))

    def estimate(self, cycles, influences, drift=0.0, intervals=None):
        half = windows_report.reach(influences, drift)
        of_cycles = {"gpu.cycles": [cycles * math.exp(-half), cycles * math.exp(half)]}
        return {"windows": {"log_cycles": math.log(cycles), "drift": drift, "evidence": [[i, 0.0, x] for i, x in enumerate(influences)],
                            "intervals": {**of_cycles, **(intervals or {})}}}

    def printed(self):
        return subprocess.run([sys.executable, windows.__file__, *self.options], capture_output=True, text=True, check=True).stdout

    def test_cycles_and_speed_ups_are_held_or_missed_and_a_refusal_is_named(self):
        base, other, third = self.frame["designs"]
        for design, cycles in ((base, 1000), (other, 500), (third, 400)):
            self.put("cycle", design, "done", 8.0, {"stats": {"gpu.cycles": cycles, "gpu.l2.accesses": 10}})
        waves = [0.001 * (-1) ** i for i in range(20)]
        # Both are 10 % too high, which their intervals of 1.4 % do not hold; the speed-up is exact.
        self.put("windows", base, "done", 1.0, self.estimate(1100, waves, intervals={"gpu.l2.accesses": [9, 11]}))
        self.put("windows", other, "done", 1.0, self.estimate(550, waves, drift=0.001, intervals={"gpu.l2.accesses": [11, 12]}))
        self.put("windows", third, "refused", 0.0, {"why": "too few"})
        printed = self.printed()
        self.assertIn("| all | 3 | 1 | 33 % | 6.7 %, 10.0 % |", printed)
        self.assertIn("| cycles | 2 | 0 | 0 % | 10.0 %, 10.0 % | ", printed)
        self.assertIn("| speed-up | 1 | 1 | 100 % | 0.0 %, 0.0 % | 0.2 % |", printed)
        self.assertIn("| 8.0 |", printed)
        self.assertIn(f"refused: {windows_plan.name_of(self.frame)}, {self.frame['machines'][0][0]}, {third}: too few", printed)
        self.assertIn("25 % of 4 intervals held", printed)  # both of cycles are missed

    def test_what_windows_refuse_costs_no_run_in_cycle_mode(self):
        with open(self.study.options.program, "w", encoding="utf-8") as file:  # makes traces of no bytes, and refuses them
            file.write("#!/bin/sh\n"
                       "[ $1 = sim ] && echo 'grtx: windows mode: a trace: all of it is simulated, in cycle mode: too few' >&2 && exec sleep 60\n"
                       "[ $1 = machine ] && echo '{\"keys\": {}}' && exit\n"
                       "eval made=\\${$(($# - 1))}\n"
                       ": > \"$made\"\n")
        point = (self.frame, *self.frame["machines"][0], self.frame["designs"][0])
        windows.run_all(self.study, [point])
        self.assertEqual([row[0] for row in self.study.found("windows").values()], ["refused"])
        self.assertEqual(self.study.found("cycle"), {})
        self.assertIn("too few", self.printed())

    def test_a_statistic_that_holds_seldom_is_named(self):
        statistics = [("gpu.a", i > 0) for i in range(10)] + [("gpu.b", i > 1) for i in range(10)] + [("gpu.c", False)] * 9
        self.assertEqual(windows_report.seldom(statistics), "gpu.b 8 of 10")

    def test_options_of_a_design_are_the_program_s(self):
        keys = {"tracer.k": {"value": 64, "from": "--design walk"}, "tracer.tmax_update": {"value": "kth", "from": "--design walk"},
                "tracer.pop_test": {"value": "on", "from": "paper.toml:9"}, "rt.traversal": {"value": "warp", "from": "--design walk"}}
        with open(self.study.options.program, "w", encoding="utf-8") as file:
            file.write(f"#!/bin/sh\necho '{json.dumps({'keys': keys})}'\n")
        self.assertEqual(self.study.options_of("walk"), ["--k", "64", "--tmax-update", "kth"])

    def test_the_interval_of_cycles_is_the_program_s(self):
        base = self.frame["designs"][0]
        self.put("cycle", base, "done", 8.0, {"stats": {"gpu.cycles": 1000}})
        self.put("windows", base, "done", 1.0, self.estimate(1100, [0.0] * 20, intervals={"gpu.cycles": [990, 1210]}))
        self.assertIn("| cycles | 1 | 1 | 100 % | 10.0 %, 10.0 % | 10.0 % |", self.printed())

    def test_a_drift_makes_an_interval_wider(self):
        self.assertAlmostEqual(windows_report.reach([0.0] * 31, 0.01), windows_report.student_quantile(0.975, 20) * 0.01)
        self.assertAlmostEqual(windows_report.student_quantile(0.975, 5), 2.5706, places=3)

    def test_what_is_there_is_not_run_again_and_what_failed_only_with_retry(self):
        base = self.frame["designs"][0]
        self.put("cycle", base, "failed", 0.0, {"why": "killed"})
        self.study.run("cycle", self.frame, *self.frame["machines"][0], base)
        self.assertEqual([row[0] for row in self.study.found("cycle").values()], ["failed"])
        self.assertEqual(json.loads(self.study.databases["cycle"].execute("SELECT document FROM run").fetchone()[0]), {"why": "killed"})
        self.study.options.retry = True
        self.study.run("cycle", self.frame, *self.frame["machines"][0], base)
        self.assertIn("grtx", next(iter(self.study.found("cycle").values()))[2]["why"])


if __name__ == "__main__":
    unittest.main()
