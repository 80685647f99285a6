#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""scripts/demo.sh with a small scene: a picture with something in it, a table of three machines whose speed-ups are those of the results, and the
report's path on the last line; it and others refuse what they do not know.

    demo_test.py GRTX
"""
import json
import os
import re
import subprocess
import sys
import tempfile
import unittest

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
PROGRAM = ""
MACHINES = ("paper-1sm", "charged-1sm", "rdna4-1sm")


def run(*command):
    return subprocess.run(command, capture_output=True, text=True, check=False)


class Demo(unittest.TestCase):
    def test_its_end_is_the_results(self):
        with tempfile.TemporaryDirectory() as folder:
            done = run(os.path.join(ROOT, "scripts", "demo.sh"), "--program", PROGRAM, "--count", "3000", "-o", folder)
            self.assertEqual(done.returncode, 0, done.stderr)
            lines = done.stdout.rstrip().splitlines()
            self.assertEqual(lines[-1].split(": ")[-1], os.path.join(os.path.realpath(folder), "report.html"))
            with open(os.path.join(folder, "report.html"), encoding="utf-8") as page:
                self.assertIn("<html", page.read())
            self.assertGreater(os.path.getsize(os.path.join(folder, "hall.png")), 10000)  # an empty one has 800 bytes
            for machine in MACHINES:
                with open(os.path.join(folder, machine, "results.json"), encoding="utf-8") as file:
                    speedup = json.load(file)["speedup"]
                rows = {line.split()[1]: line.split()[3] for line in lines if line.startswith(f"{machine} ")}
                self.assertEqual(rows, {"baseline": "1.00", **{name: f"{ratio:.2f}" for name, ratio in speedup.items()}})
            table = [line for line in lines if line.startswith(tuple(f"{name} " for name in ("machine", *MACHINES)))]
            self.assertEqual(len(table), 19)
            self.assertLessEqual(max(map(len, table)), 80)
            self.assertIn("bit-identical", done.stdout)
            # 100 % of the cycles lay behind the last start of a warp: 128 warps had 256 slots.
            full = [re.fullmatch(r"full \((.*)\): (\d+) warps are (.*) times the (\d+) warp slots; at most (\d+) % .*", line) for line in lines if line.startswith("full (")]
            self.assertEqual({name for match in full for name in match[1].split(", ")}, set(MACHINES))
            for match in full:
                self.assertGreaterEqual(int(match[2]), 4 * int(match[4]))
                self.assertLess(int(match[5]), 50)
            self.assertEqual([line[:2] for line in lines if line[:1].isdigit()], ["1.", "2.", "3.", "4."])

    def test_bad_requests_are_refused_before_anything_is_made(self):
        with tempfile.TemporaryDirectory() as folder:
            out = os.path.join(folder, "out")
            for options, rule in ((("--count", "many"), "--count many: must be a number of Gaussians"),
                                  (("--count", "0"), "--count 0: must be a number of Gaussians"),
                                  (("--program", folder + "/none"), f"--program {folder}/none: no such program")):
                done = run(os.path.join(ROOT, "scripts", "demo.sh"), "--program", PROGRAM, *options, "-o", out)
                self.assertEqual((done.returncode, done.stdout, done.stderr), (2, "", f"demo.sh: {rule}\n"))
            self.assertEqual(os.listdir(folder), [])

    def test_unknown_options_are_refused(self):
        for script in ("demo.sh", "install_dependencies.sh", "deb.sh", "nightly.sh"):
            done = run(os.path.join(ROOT, "scripts", script), "--everything")
            self.assertEqual(done.returncode, 2)
            self.assertRegex(done.stderr, rf"^{script}: --everything: must be [^\n]*\n$")


if __name__ == "__main__":
    PROGRAM = os.path.abspath(sys.argv.pop(1))
    unittest.main()
