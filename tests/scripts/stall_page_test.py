#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""docs/guide/a-stall.md: its commands print what stands there, and the lanes wait in the cycles that it names.

Usage: stall_page_test.py [--record] GRTX   (--record: writes the bars anew; the sentences are yours)
"""
import json
import os
import re
import shlex
import subprocess
import sys
import tempfile
import unittest

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
PAGE = os.path.join(ROOT, "docs", "guide", "a-stall.md")
BARS = re.compile(r"(?<=```\n)gpu\.rt: every cycle.*?(?=```)", re.S)


def read(path):
    with open(path, encoding="utf-8") as file:
        return file.read()


def changes(path, signal):
    """(cycle, value) of each change of a signal of warp 7, from the waveform."""
    names, cycle, found = {}, 0, []
    for line in read(path).splitlines():
        words = line.split()
        if words[:1] == ["$var"]:
            names.setdefault(words[4], words[3])
        elif line.startswith("b") and words[1] == names["cycle"]:
            cycle = int(words[0][1:], 2)
        elif line.startswith("b") and words[1] == names.get(signal):
            found.append((cycle, int(words[0][1:], 2)))
    return found


class StallPage(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(temporary.cleanup)
        cls.folder = temporary.name
        os.symlink(os.path.join(ROOT, "configs"), os.path.join(cls.folder, "configs"))
        cls.text = read(PAGE)
        cls.printed = []
        for command in re.findall(r"^grtx .*", cls.text, re.M):
            run = subprocess.run([PROGRAM, *shlex.split(command)[1:]], cwd=cls.folder, capture_output=True, text=True, check=True)
            if command.startswith("grtx stalls"):
                cls.printed.append(run.stdout.split("\n\n")[0] + "\n")

    def test_the_bars(self):
        self.assertEqual(BARS.findall(self.text), self.printed)

    # There was no stall of the fastest design, and none by the timeline.
    def test_the_fastest_design_and_the_timeline(self):
        self.assertEqual(len(self.printed), 2)
        self.assertLess(os.path.getsize(os.path.join(self.folder, "t.pftrace")), 2e6)

    def test_the_statistics(self):
        stats = json.loads(read(os.path.join(self.folder, "s.json")))["stats"]

        def value(name):
            return stats[name]["value"] if isinstance(stats[name], dict) else stats[name]

        self.assertIn(f"({value('gpu.rt.any_hit.timeouts')} of {value('gpu.rt.any_hit.batches')}\nbatches)".replace("\n", " "),
                      self.text.replace("\n", " "))
        self.assertIn(f"({100 * value('gpu.bound.rt_port') / value('gpu.cycles'):.0f} % of the cycles)", self.text.replace("\n", " "))

    def test_the_waveform(self):
        waveform = os.path.join(self.folder, "w.vcd")
        waiting = changes(waveform, "lanes_waiting_any_hit")
        self.assertIn((6037, 0x0E0F0707), waiting)
        self.assertIn((6098, 0), waiting)
        self.assertIn((6098, 0x0E0F0707), changes(waveform, "lanes_in_any_hit"))
        self.assertIn((6117, 0), changes(waveform, "lanes_in_any_hit"))
        self.assertIn((6081, 0xF0F0F080), changes(waveform, "lanes_waiting_memory"))


def record():
    StallPage.setUpClass()
    with open(PAGE, "w", encoding="utf-8") as file:
        file.write(BARS.sub(lambda _: StallPage.printed.pop(0), StallPage.text))


if __name__ == "__main__":
    PROGRAM = os.path.abspath(sys.argv.pop())
    if "--record" in sys.argv:
        record()
    else:
        unittest.main()
