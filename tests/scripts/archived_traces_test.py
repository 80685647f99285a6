#!/usr/bin/env python3
"""data/traces: the files are those of SHA256SUMS, `grtx trace-check` proves them consistent, and `grtx sim` gives the
statistics of expected.json.

    archived_traces_test.py GRTX [--record]
"""
import hashlib
import json
import os
import subprocess
import sys
import tempfile
import unittest

FOLDER = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "data", "traces"))
EXPECTED = os.path.join(FOLDER, "expected.json")
STATISTICS = ["gpu.cycles", "gpu.rt.node_visits", "gpu.rt.node_fetches", "gpu.rt.any_hit.batches",
              "gpu.rt.checkpoint.entries_written", "gpu.l1.accesses", "gpu.l2.accesses", "gpu.dram.bytes"]
PROGRAM = ""


def sums():
    with open(os.path.join(FOLDER, "SHA256SUMS"), encoding="utf-8") as file:
        return [line.split() for line in file]


def simulated(name, mode):
    with tempfile.TemporaryDirectory() as folder:
        statistics = os.path.join(folder, "s.json")
        subprocess.run([PROGRAM, "sim", os.path.join(FOLDER, name), "--machine", "paper", "--mode", mode, "--stats",
                        statistics, "--quiet"], check=True)
        with open(statistics, encoding="utf-8") as file:
            stats = json.load(file)["stats"]
    return {s: stats[s]["value"] for s in STATISTICS}


def all_simulated():
    return {name: {mode: simulated(name, mode) for mode in ("cycle", "fast")} for _, name in sums()}


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
        with open(EXPECTED, encoding="utf-8") as file:
            self.assertEqual(json.load(file), all_simulated())


if __name__ == "__main__":
    PROGRAM = os.path.abspath(sys.argv.pop(1))
    if "--record" in sys.argv:
        with open(EXPECTED, "w", encoding="utf-8") as file:
            file.write(json.dumps(all_simulated(), indent=1) + "\n")
    else:
        unittest.main()
