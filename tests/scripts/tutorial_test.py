#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""docs/guide/tutorial.md: its commands, run verbatim, print what stands there, and its figures are those of its database.

Usage: tutorial_test.py [--record] GRTX   (--record: writes the printed tables anew; the sentences are yours)
"""
import json
import os
import re
import shlex
import sqlite3
import subprocess
import sys
import tempfile
import unittest

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
PAGE = os.path.join(ROOT, "docs", "guide", "tutorial.md")
RUN = re.compile(r"(?<=prints\n\n```\n).*?(?=```)", re.S)
TABLE = re.compile(r"^\| design \| L1.*?(?=\n\n)", re.S | re.M)


def read(path):
    with open(path, encoding="utf-8") as file:
        return file.read()


def points(path):
    """{(design, KB of L1): values by name}."""
    with sqlite3.connect(path) as database:
        found = {}
        for number, design, coordinates, status in database.execute("SELECT id, design, coordinates, status FROM point"):
            assert status == "done", status
            size = json.loads(coordinates)["l1.bytes"] // 1024
            found[design, size] = dict(database.execute("SELECT name, value FROM value WHERE point_id = ?", (number,)))
        return found


def table(of):
    lines = ["| design | L1 | time | L1 hits of nodes | area |", "|---|---|---|---|---|"]
    for (design, size), v in sorted(of.items()):
        lines.append(f"| {design} | {size} KB | {v['gpu.time_us']:,.0f} µs | {100 * v['gpu.l1.node.hit_rate']:.1f} % | "
                     f"{v['cost.mm2']:.2f} mm² |")
    return "\n".join(lines)


class Tutorial(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(temporary.cleanup)
        cls.text = read(PAGE)
        with open(os.path.join(temporary.name, "l1.toml"), "w", encoding="utf-8") as file:
            file.write(re.search(r"```toml\n(.*?)```", cls.text, re.S).group(1))
        cls.printed = {}
        for command in re.findall(r"^grtx [a-z].*", cls.text, re.M):
            run = subprocess.run([PROGRAM, *shlex.split(command)[1:]], cwd=temporary.name, capture_output=True, text=True, check=True)
            cls.printed[command.split()[1]] = run.stdout
        cls.points = points(os.path.join(temporary.name, "l1.sqlite"))
        cls.report = read(os.path.join(temporary.name, "l1.html"))

    def ratio(self, name, design, over=(128, 256)):
        return self.points[design, over[0]][name] / self.points[design, over[1]][name]

    def test_the_run(self):
        self.assertEqual(RUN.search(self.text).group(0), self.printed["run"])

    def test_the_table_of_points(self):
        self.assertEqual(TABLE.search(self.text).group(0), table(self.points))
        self.assertEqual(len(self.points), 6)

    def test_the_report_holds_all_points(self):
        self.assertIn("Points done 6 / 6", " ".join(re.sub(r"<[^>]*>", " ", self.report).split()))

    def test_the_sentence(self):
        page = " ".join(self.text.split())
        area = self.points["grtx", 256]["cost.mm2"] / self.points["grtx", 128]["cost.mm2"] - 1
        self.assertIn(f"the baseline {100 * (self.ratio('gpu.time_us', 'baseline') - 1):.0f} % faster", page)
        self.assertIn(f"GRTX {100 * (self.ratio('gpu.time_us', 'grtx') - 1):.0f} %", page)
        self.assertIn(f"{100 * area:.1f} % more area", page)
        for size in (128, 256):
            speed_up = self.points["baseline", size]["gpu.time_us"] / self.points["grtx", size]["gpu.time_us"]
            self.assertIn(f"{speed_up:.2f} with {size} KB", page)


def record():
    Tutorial.setUpClass()
    text = RUN.sub(lambda _: Tutorial.printed["run"], Tutorial.text, count=1)
    text = TABLE.sub(lambda _: table(Tutorial.points), text, count=1)
    with open(PAGE, "w", encoding="utf-8") as file:
        file.write(text)


if __name__ == "__main__":
    PROGRAM = os.path.abspath(sys.argv.pop())
    if "--record" in sys.argv:
        record()
        Tutorial.doClassCleanups()
    else:
        unittest.main()
