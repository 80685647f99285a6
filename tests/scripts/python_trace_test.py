#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""grtx_tlm.read_trace gives what `grtx trace-dump --json` prints, as arrays whose counts are the totals of the trace;
what the program refuses raises TraceError that names file, place and rule.

    python_trace_test.py GRTX       Exit code 77: numpy or pandas is missing.
"""
import json
import os
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
sys.path.insert(0, os.path.join(ROOT, "python"))
try:
    import numpy as np
    import grtx_tlm
except ImportError as error:
    print(f"skipped: {error}; Debian packages: python3-numpy python3-pandas")
    sys.exit(77)

PROGRAM = ""
ARCHIVED = [os.path.join(ROOT, "data", "traces", name) for name in ("baseline.grtx", "grtx.grtx")]
TRACES = {
    "secondary": "--accel tlas-tri20 --checkpoint on --secondary both",
    "frames": "--accel tri80 --checkpoint on --views 0:2 --bvh-width 8",
    "overflow": "--accel tlas-tri20 --checkpoint on --checkpoint-capacity 8 --k 4",
    "nodes under way": "--accel ellipsoid --k 4 --ahead 8",
    "delayed any-hit shaders": "--accel ellipsoid --k 4 --any-hit delayed",
    "end tested once a round": "--accel box --k 4 --ert 0.1 --ert-check round",
    "bounded by opacity": "--accel tlas-tri20 --checkpoint on --k 16 --opacity-bound on",
    "small warps": "--accel tlas-sphere --warp-size 4 --mapping linear",
}
SUMS = ("rays", "rounds", "visits_internal", "visits_instance", "visits_leaf", "culls", "any_hit_calls",
        "checkpoints_read", "overflows", "processed", "blended")


def grtx(*arguments):
    done = subprocess.run([PROGRAM, *arguments, "--quiet"], capture_output=True, text=True)
    if done.returncode != 0:
        raise AssertionError(f"grtx {' '.join(arguments)}: {done.stderr}")
    return done.stdout


def counted(group):
    """What a group adds to the totals."""
    kinds, outcomes, leaf = group.events["kind"], group.events["detail"], group.events["kind"] == 2
    of_kind = {name: int((kinds == i).sum()) for i, name in enumerate(grtx_tlm.EVENT_KINDS)}
    called = sum(int((leaf & (outcomes == grtx_tlm.OUTCOMES.index(name))).sum())
                 for name in ("inserted", "displaced", "rejected", "ignored"))
    return {"rays": len(group.rays), "rounds": len(group.rounds), "visits_internal": of_kind["visit_internal"],
            "visits_instance": of_kind["visit_instance"], "visits_leaf": of_kind["visit_leaf"], "culls": of_kind["cull"],
            "any_hit_calls": called, "checkpoints_read": of_kind["replay_take"] + of_kind["replay_forward"],
            "overflows": int(group.rounds["overflow"].sum()), "processed": len(group.processed),
            "blended": int(group.processed["blended"].sum())}


class Reads(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        grtx("synth", "--preset", "object", "--count", "600", "--seed", "1", "-o", cls.path("s.ply"))

    @classmethod
    def path(cls, name):
        return os.path.join(cls.folder.name, name)

    def traced(self, options):
        grtx("trace", "--scene", self.path("s.ply"), *options.split(), "--cameras", self.path("s.cameras.json"), "--width", "16",
             "--height", "16", "-o", self.path("t.grtx"))
        return self.path("t.grtx")

    def compare(self, path):
        lines = [json.loads(line) for line in grtx("trace-dump", "--json", path).splitlines()]
        with grtx_tlm.read_trace(path, program=PROGRAM) as trace:
            for key in ("header", "totals", "content_hash", "version"):
                self.assertEqual(getattr(trace, key), lines[0][key], key)
            groups = list(trace)
            self.assertEqual(len(trace), len(groups))
            self.assertEqual([as_dumped(group) for group in groups], lines[1:])
            self.assertEqual(as_dumped(trace[len(trace) - 1]), lines[-1])
            adds = [counted(group) for group in groups]
            self.assertEqual({name: sum(add[name] for add in adds) for name in SUMS},
                             {name: trace.totals[name] for name in SUMS})
            trace.verify()

    def test_archived_traces(self):
        for path in ARCHIVED:
            with self.subTest(path):
                self.compare(path)

    def test_traces_of_other_kinds(self):
        for name, options in TRACES.items():
            with self.subTest(name):
                self.compare(self.traced(options))

    def test_what_the_program_refuses_is_a_trace_error(self):
        with open(ARCHIVED[1], "rb") as file:
            good = file.read()
        flipped = bytearray(good)
        flipped[len(good) // 2] ^= 1
        for data, words in ((b"ply\n" + good[4:], "byte 0: is not a GRTX trace"), (good[:-16], "cut"), (flipped, "hash")):
            with self.subTest(words):
                with open(self.path("bad.grtx"), "wb") as file:
                    file.write(data)
                with self.assertRaises(grtx_tlm.TraceError) as caught:
                    with grtx_tlm.read_trace(self.path("bad.grtx"), program=PROGRAM) as trace:
                        list(trace)
                self.assertEqual(caught.exception.file, self.path("bad.grtx"))
                self.assertIn(words, str(caught.exception))
                self.assertNotIn("bad.grtx", caught.exception.place + caught.exception.rule)

    def test_a_file_whose_name_begins_with_a_dash_is_no_option(self):
        here = os.getcwd()
        os.chdir(os.path.dirname(self.path("x")))
        self.addCleanup(os.chdir, here)
        for name in ("-h", "--json", "-o=x"):
            shutil.copy(ARCHIVED[0], name)
            trace = grtx_tlm.read_trace(name, program=PROGRAM)
            self.assertEqual(trace.content_hash, grtx_tlm.read_trace(ARCHIVED[0], program=PROGRAM).content_hash)
            trace.verify()
            with open(name, "r+b") as file:
                file.truncate(100)
            with self.assertRaises(grtx_tlm.TraceError) as caught:
                grtx_tlm.read_trace(name, program=PROGRAM)
            self.assertEqual(caught.exception.file, name)
            self.assertNotIn(name, caught.exception.place)

    def test_what_is_not_there_is_named(self):
        with self.assertRaises(FileNotFoundError):
            grtx_tlm.read_trace(self.path("none.grtx"), program=PROGRAM)
        with self.assertRaisesRegex(FileNotFoundError, "no program"):
            grtx_tlm.read_trace(ARCHIVED[0], program=self.path("grtx"))
        trace = grtx_tlm.read_trace(ARCHIVED[0], program=PROGRAM)
        for place in (len(trace), -len(trace) - 1):
            with self.assertRaisesRegex(IndexError, f"group {place} of {len(trace)}"):
                trace[place]
        with self.assertRaises(TypeError):
            trace["0"]

    def test_indices_and_slices_are_those_of_a_list(self):
        with grtx_tlm.read_trace(ARCHIVED[1], program=PROGRAM) as trace:
            numbers = list(range(len(trace)))
            self.assertGreater(len(numbers), 4)
            for place in (0, -1, 2, -len(trace), np.int64(3)):
                self.assertEqual(trace[place].index, numbers[place])
            for part in (slice(None), slice(1, 2), slice(-2, None), slice(None, None, -1), slice(1, 100, 3), slice(3, 1)):
                self.assertEqual([group.index for group in trace[part]], numbers[part], part)
            self.assertEqual(as_dumped(trace[:][-1]), as_dumped(trace[-1]))
            self.assertEqual([group.index for group in reversed(trace)], numbers[::-1])

    def test_what_is_shown_of_a_trace(self):
        trace = grtx_tlm.read_trace(ARCHIVED[1], program=PROGRAM)
        header = trace.header
        self.assertEqual(repr(trace), f"<Trace {ARCHIVED[1]}: {header['width']} x {header['height']} pixels, {len(trace)} groups, "
                                      f"{trace.totals['rays']} rays, {header['accel']}, k = {header['k']}>")
        group = trace[0]
        self.assertEqual(repr(group), f"<RayGroup 0: primary, {len(group.rays)} rays, {len(group.rounds)} rounds, "
                                      f"{len(group.events)} events>")


def as_dumped(group):
    """A RayGroup in the form of `grtx trace-dump --json` (docs/model/trace-format.md, "As JSON")."""
    nodes = [[n["address"], n["child_base"], *n["child_kinds"][:n["child_count"]]] for n in group.nodes]
    rays = [{"lane": lane, "pixel": int(ray["pixel"]), "rounds": [], "events": [], "processed": []}
            for lane, ray in enumerate(group.rays)]
    for r in group.rounds.tolist():
        rays[r[0]]["rounds"].append([r[2], *map(int, r[3:])])
    for e in group.events.tolist():
        rays[e[0]]["events"].append(list(e[2:]))
    for p in group.processed.tolist():
        rays[p[0]]["processed"].append([p[2], int(p[3])])
    return {"group": group.index, "frame": group.frame, "kind": group.kind,
            "nodes": [[int(v) for v in node] for node in nodes], "rays": rays}


if __name__ == "__main__":
    PROGRAM = os.path.abspath(sys.argv.pop(1))
    unittest.main()
