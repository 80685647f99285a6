#!/usr/bin/python3
"""The trace reader of python/grtx_tlm equals the program's, field by field, on traces of every kind that `grtx trace`
writes and on those of data/traces; damaged traces raise TraceError that names file, place and rule.

    python_trace_test.py GRTX       Exit code 77: numpy, xxhash or zstandard is missing.
"""
import json
import os
import random
import struct
import subprocess
import sys
import tempfile
import unittest

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
sys.path.insert(0, os.path.join(ROOT, "python"))
try:
    import xxhash
    import grtx_tlm
except ImportError as error:
    print(f"skipped: {error}; Debian packages: python3-numpy python3-pandas python3-xxhash python3-zstandard")
    sys.exit(77)

PROGRAM = ""
ARCHIVED = [os.path.join(ROOT, "data", "traces", name) for name in ("baseline.grtx", "grtx.grtx")]
DEFAULTS = {"layout": "vulkan_sim", "pop_test": "on"}  # header fields that a file may leave out
# Options of `grtx trace`, and the version of the file that they give.
TRACES = {
    "baseline": (4, "--accel tri20"),
    "sw": (4, "--accel tlas-tri20 --k 4"),
    "hw": (4, "--accel tri20 --checkpoint on"),
    "grtx": (4, "--accel tlas-tri20 --checkpoint on --k 4"),
    "tri80": (4, "--accel tri80 --bvh-width 4"),
    "tlas-tri80": (4, "--accel tlas-tri80 --checkpoint on --bvh-width 8"),
    "sphere": (4, "--accel tlas-sphere --checkpoint on --k 2"),
    "ellipsoid": (4, "--accel ellipsoid --checkpoint on --bvh-width 2"),
    "slot": (4, "--accel tlas-tri20 --checkpoint on --child-order slot"),
    "vulkan_sim": (5, "--accel tlas-tri20 --checkpoint on --child-order vulkan_sim"),
    "no pop test": (5, "--accel tlas-tri20 --checkpoint on --pop-test off --k 4"),
    "lifo": (4, "--accel tlas-tri20 --checkpoint on --checkpoint-order lifo --k 4"),
    "nearest": (4, "--accel tlas-tri20 --checkpoint on --checkpoint-order nearest --k 4"),
    "overflow": (4, "--accel tlas-tri20 --checkpoint on --checkpoint-capacity 8 --k 4"),
    "kth": (4, "--accel tri20 --checkpoint on --tmax-update kth --replay-tmax kth --sort-key peak"),
    "compact": (4, "--accel tlas-tri20 --checkpoint on --layout compact"),
    "compact tri20": (4, "--accel tri20 --checkpoint on --layout compact"),
    "obb": (4, "--accel tri20 --checkpoint on --layout obb"),
    "compressed": (4, "--accel tlas-tri20 --checkpoint on --layout compressed"),
    "single": (4, "--accel tri20 --tracing single --k 16"),
    "closest": (4, "--accel tlas-tri20 --tracing closest"),
    "stochastic": (4, "--accel tlas-tri20 --tracing stochastic --samples 3"),
    "small warps": (4, "--accel tlas-tri20 --checkpoint on --warp-size 4 --mapping linear"),
    "secondary": (4, "--accel tlas-tri20 --checkpoint on --secondary both"),
    "frames": (7, "--accel tlas-tri20 --checkpoint on --views 0:2"),
    "objects": (6, "--scene {objects} --accel tlas-tri20 --checkpoint on --k 4"),
    "objects, nearest": (6, "--scene {objects} --accel tlas-sphere --checkpoint on --k 4 --checkpoint-order nearest"),
    "one Gaussian": (4, "--scene {one} --accel tlas-sphere --checkpoint on"),
}


def grtx(*arguments):
    done = subprocess.run([PROGRAM, *arguments, "--quiet"], capture_output=True, text=True)
    if done.returncode != 0:
        raise AssertionError(f"grtx {' '.join(arguments)}: {done.stderr}")
    return done.stdout


class Traces(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        cls.scene, cls.objects, cls.one = (cls.path(n) for n in ("s.ply", "objects.json", "one.ply"))
        grtx("synth", "--preset", "object", "--count", "600", "--seed", "1", "-o", cls.scene)
        grtx("synth", "--preset", "object", "--count", "1", "--seed", "1", "-o", cls.one)
        with open(cls.objects, "w", encoding="utf-8") as file:
            json.dump([{"file": "s.ply"}, {"file": "s.ply", "translate": [1, 0, 0], "scale": 0.5},
                       {"file": "one.ply", "translate": [0, 1, 0]}], file)

    @classmethod
    def path(cls, name):
        return os.path.join(cls.folder.name, name)

    @classmethod
    def traced(cls, options, width=16):
        options = options.format(objects=cls.objects, one=cls.one).split()
        if "--scene" not in options:
            options += ["--scene", cls.scene]
        grtx("trace", *options, "--cameras", cls.path("s.cameras.json"), "--width", str(width), "--height", str(width),
             "-o", cls.path("t.grtx"))
        return cls.path("t.grtx")


class ReaderEqualsTheProgram(Traces):
    def compare(self, path):
        lines = [json.loads(line) for line in grtx("trace-dump", "--json", path).splitlines()]
        with grtx_tlm.read_trace(path) as trace:
            for key in ("header", "totals", "content_hash", "version"):
                self.assertEqual(getattr(trace, key), {**DEFAULTS, **lines[0][key]} if key == "header"
                                 else lines[0][key], key)
            self.assertEqual(len(trace), len(lines) - 1)
            for group, theirs in zip(trace, lines[1:]):
                self.assertEqual(as_dumped(group), theirs)
            self.assertEqual(trace.verify(), lines[0]["totals"])
            return trace.version

    def test_on_archived_traces(self):
        for path in ARCHIVED:
            with self.subTest(path):
                self.compare(path)

    def test_on_traces_of_every_kind(self):
        for name, (version, options) in TRACES.items():
            with self.subTest(name):
                self.assertEqual(self.compare(self.traced(options)), version)


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


class DamagedTraces(Traces):
    """What must happen to a byte that is wrong: TraceError, never another exception, never a wrong answer."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.good = cls.traced("--accel tlas-tri20 --checkpoint on --k 4", width=8)
        with open(cls.good, "rb") as file:
            cls.bytes = file.read()

    def write(self, data):
        with open(self.path("bad.grtx"), "wb") as file:
            file.write(data)
        return self.path("bad.grtx")

    def read_all(self, data):
        with grtx_tlm.read_trace(self.write(data)) as trace:
            return trace.verify()

    def read_first(self, data):
        with grtx_tlm.read_trace(self.write(data)) as trace:
            return trace[0]

    def refused(self, data, words, read=None):
        with self.assertRaises(grtx_tlm.TraceError) as caught:
            (read or self.read_all)(data)
        self.assertEqual(caught.exception.file, self.path("bad.grtx"))
        self.assertIn(words, str(caught.exception))

    def test_each_flipped_byte_is_found(self):
        picks = random.Random(1).sample(range(len(self.bytes)), min(len(self.bytes), 200))
        for at in [*range(64), *range(len(self.bytes) - 64, len(self.bytes)), *picks]:
            with self.subTest(at):
                damaged = bytearray(self.bytes)
                damaged[at] ^= 0x41
                self.refused(damaged, "bad.grtx: ")

    def test_each_cut_is_found(self):
        for size in [*range(0, 64), *range(64, len(self.bytes), 197), len(self.bytes) - 1]:
            with self.subTest(size):
                self.refused(self.bytes[:size], "bad.grtx: ")

    def test_what_is_wrong_is_named(self):
        version = bytearray(self.bytes)
        version[8:12] = struct.pack("<I", 3)
        self.refused(version, "version 3; known are 4 to 7")
        self.refused(b"ply\n" + self.bytes[4:], "this is no trace")
        self.refused(self.bytes[:-16] + bytes(16), "the file is cut")
        size, = struct.unpack_from("<I", self.bytes, 12)
        chunk = bytearray(self.bytes)
        chunk[24 + size + 20] ^= 1
        self.refused(chunk, "content: its hash does not match")
        self.refused(chunk, "group 0: its hash does not match", self.read_first)

    def test_a_payload_whose_hashes_are_right_is_checked_by_its_rules(self):
        """Changes bytes of the first chunk and mends all hashes. Either a rule refuses it, or what was read still is a
        trace; a reader that hangs is ended by the time limit of the test."""
        start = 24 + struct.unpack_from("<I", self.bytes, 12)[0]
        size, = struct.unpack_from("<I", self.bytes, start)
        seeded, refused = random.Random(2), 0
        for _ in range(300):
            damaged = bytearray(self.bytes)
            for _ in range(seeded.choice((1, 1, 2, 4))):
                damaged[start + 12 + seeded.randrange(size)] = seeded.randrange(256)
            try:
                self.read_all(with_hashes(damaged, start, size))
            except grtx_tlm.TraceError as error:
                refused += 1
                self.assertRegex(str(error), r"bad\.grtx: (group 0|totals): .")
        self.assertGreater(refused, 250)

    def test_headers_that_lie_are_refused(self):
        for key, value, words in (("accel", "tri21", "accel"), ("k", -1, "k is -1"), ("k", True, "k is True"),
                                  ("root", 65, "no multiple of the unit"), ("bvh_width", 9, "bvh_width"),
                                  ("groups", 77, "which the header knows 77"), ("surprise", 1, "unknown key 'surprise'"), ("k", None, "missing")):
            with self.subTest(key=key, value=value):
                self.refused(self.with_header(key, value), words)

    def with_header(self, key, value):
        size, = struct.unpack_from("<I", self.bytes, 12)
        header = json.loads(self.bytes[24:24 + size])
        if value is None:
            del header[key]
        else:
            header[key] = value
        text = json.dumps(header).encode()
        data = bytearray(self.bytes[:12] + struct.pack("<IQ", len(text), xxhash.xxh3_64_intdigest(text)) + text +
                         self.bytes[24 + size:])
        longer = len(text) - size
        footer = struct.unpack_from("<Q", self.bytes, len(self.bytes) - 16)[0] + longer
        struct.pack_into("<Q", data, len(data) - 16, footer)
        for at in range(footer + 8, footer + 8 + 8 * struct.unpack_from("<Q", data, footer)[0], 8):
            struct.pack_into("<Q", data, at, struct.unpack_from("<Q", data, at)[0] + longer)
        start = 24 + len(text)
        return with_hashes(data, start, struct.unpack_from("<I", data, start)[0])


def with_hashes(data, start, size):
    """`data` with the hashes of its first chunk, of the content and of the footer made right."""
    struct.pack_into("<Q", data, start + 4, xxhash.xxh3_64_intdigest(data[start + 12:start + 12 + size]))
    footer, = struct.unpack_from("<Q", data, len(data) - 16)
    struct.pack_into("<Q", data, len(data) - 32, xxhash.xxh3_64_intdigest(data[:-32]))
    struct.pack_into("<Q", data, len(data) - 24, xxhash.xxh3_64_intdigest(data[footer:-24]))
    return data


if __name__ == "__main__":
    PROGRAM = os.path.abspath(sys.argv.pop(1))
    unittest.main()
