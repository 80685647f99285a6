#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""scripts/test_summary.py: parts, skipped tests with their reasons, failed tests, exit codes."""
import json
import os
import subprocess
import sys
import tempfile
import unittest

SCRIPT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scripts", "test_summary.py")


def case(name, label, status, output=""):
    return (label, name, f'<testcase name="{name}" classname="{name}" time="1.5" status="{status}">'
                         f"<system-out>{output}</system-out></testcase>")


def summary(*cases):
    with tempfile.NamedTemporaryFile("w", suffix=".xml") as results, tempfile.NamedTemporaryFile("w") as names:
        results.write(f'<testsuite name="x">{"".join(text for _, _, text in cases)}</testsuite>')
        json.dump({"tests": [{"name": name, "properties": [{"name": "LABELS", "value": [label]}]} for label, name, _ in cases]}, names)
        results.flush()
        names.flush()
        done = subprocess.run([sys.executable, "-B", SCRIPT, results.name, names.name], capture_output=True, text=True, check=False)
    return done.returncode, done.stdout.splitlines()


class TestSummary(unittest.TestCase):
    def test_parts_reasons_and_failures(self):
        code, lines = summary(
            case("A.one", "base", "run"), case("A.two", "base", "fail", "boom"),
            case("B.a", "frontend", "notrun", "[ RUN ] B.a\n../b_test.cpp:7: Skipped\nno scenes at hand\n\n[ SKIPPED ] B.a"),
            case("B.b", "frontend", "notrun", "../b_test.cpp:9: Skipped\nno scenes at hand\n"),
            case("rtl.c", "rtl", "notrun", "skipped: no yosys\n"), case("d", "rtl", "notrun", "last words\n\n"))
        self.assertEqual(code, 1)
        self.assertEqual([line.split() for line in lines[:5]],
                         [["part", "passed", "skipped", "failed", "seconds"], ["base", "1", "0", "1", "3"],
                          ["frontend", "0", "2", "0", "3"], ["rtl", "0", "2", "0", "3"], ["all", "1", "4", "1", "9"]])
        self.assertEqual(lines[5:], ["skipped: B.a and 1 more: no scenes at hand", "skipped: d: last words",
                                     "skipped: rtl.c: no yosys", "FAILED: A.two"])

    def test_all_passed_is_0_and_nothing_is_1(self):
        self.assertEqual(summary(case("A", "base", "run"))[0], 0)
        self.assertEqual(summary()[0], 1)


if __name__ == "__main__":
    unittest.main()
