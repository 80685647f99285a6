#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""data/traces: the files are those of SHA256SUMS, `grtx trace-check` proves them consistent, and `grtx regress` finds the
statistics on record.

    archived_traces_test.py GRTX
"""
import hashlib
import os
import subprocess
import sys
import unittest

FOLDER = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "data", "traces"))
PROGRAM = ""


def sums():
    with open(os.path.join(FOLDER, "SHA256SUMS"), encoding="utf-8") as file:
        return [line.split() for line in file]


class ArchivedTraces(unittest.TestCase):
    def test_the_files_are_those_that_were_archived(self):
        names = sorted(f for f in os.listdir(FOLDER) if f.endswith(".grtx"))
        self.assertEqual(names, sorted(name for _, name in sums()))
        for digest, name in sums():
            with open(os.path.join(FOLDER, name), "rb") as file:
                self.assertEqual(hashlib.sha256(file.read()).hexdigest(), digest, name)

    def test_they_are_consistent(self):
        for _, name in sums():
            subprocess.run([PROGRAM, "trace-check", os.path.join(FOLDER, name), "--quiet"], check=True)

    def test_they_give_the_statistics_on_record(self):
        outcome = subprocess.run([PROGRAM, "regress", FOLDER, "--jobs", "2"], capture_output=True, text=True)
        self.assertEqual(outcome.returncode, 0, outcome.stdout + outcome.stderr)
        self.assertIn("3 cases: 3 equal", outcome.stdout)


if __name__ == "__main__":
    PROGRAM = os.path.abspath(sys.argv.pop(1))
    unittest.main()
