# SPDX-License-Identifier: Apache-2.0
"""A case of a relation: runs the program in a folder, reads what it wrote, and compares."""
import array
import contextlib
import json
import math
import os
import random
import shlex
import sqlite3
import subprocess
import sys
from dataclasses import dataclass

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
SECONDS = 300  # of one run, then it hangs
RELATIONS = {}


class Broken(Exception):
    """A relation does not hold: what differs, in one line."""


@dataclass
class Relation:
    name: str
    check: object
    each: int  # one case for so many of a cheap relation's


def relation(each=1):
    """Registers a function of a Case under its own name. each: how many cases of a cheap relation one of it takes."""
    def register(check):
        RELATIONS[check.__name__] = Relation(check.__name__, check, each)
        return check
    return register


@dataclass
class Done:
    code: int
    output: bytes
    errors: bytes


@dataclass(frozen=True)
class Image:
    """Float RGB, rows from the top."""
    width: int
    height: int
    values: tuple

    def mirrored(self):
        rows = [self.values[3 * self.width * y:3 * self.width * (y + 1)] for y in range(self.height)]
        return Image(self.width, self.height,
                     tuple(v for row in rows for x in reversed(range(self.width)) for v in row[3 * x:3 * x + 3]))

    def pixel(self, x, y):
        at = 3 * (y * self.width + x)
        return self.values[at:at + 3]


def read_pfm(content):
    kind, size, scale, floats = content.split(b"\n", 3)
    width, height = map(int, size.split())
    if kind != b"PF" or float(scale) >= 0 or len(floats) != 12 * width * height:
        raise Broken("the image is no little-endian PFM of its size")
    values = array.array("f", floats)
    if sys.byteorder != "little":
        values.byteswap()
    row = 3 * width
    return Image(width, height, tuple(v for y in reversed(range(height)) for v in values[row * y:row * (y + 1)]))


def decibels(one, two):
    """PSNR of two images on values clamped to 0 to 1, as grtx compare has it; infinite where they are equal to the bit."""
    if one == two:
        return math.inf
    squares = 0.0
    for a, b in zip(one.values, two.values):
        if a != b:
            squares += (min(max(a, 0.0), 1.0) - min(max(b, 0.0), 1.0)) ** 2
    return math.inf if squares == 0.0 else 10 * math.log10(len(one.values) / squares)


def shorten(value):
    text = repr(value)
    return text if len(text) < 60 else text[:57] + "..."


def differences(one, two):
    """Lines that say where two values of the same shape differ."""
    if isinstance(one, dict) and isinstance(two, dict):
        for key in [*one, *(k for k in two if k not in one)]:
            if key not in one or key not in two:
                yield f"{key} is in {'the first' if key in one else 'the second'} alone"
            elif one[key] != two[key] and not (one[key] != one[key] and two[key] != two[key]):
                yield from (f"{key}: {line}" for line in differences(one[key], two[key]))
    elif isinstance(one, Image) and isinstance(two, Image) and (one.width, one.height) == (two.width, two.height):
        for at in (i for i in range(one.width * one.height) if one.values[3 * i:3 * i + 3] != two.values[3 * i:3 * i + 3]):
            yield f"pixel {at % one.width}, {at // one.width} {one.values[3 * at:3 * at + 3]} and {two.values[3 * at:3 * at + 3]}"
    elif isinstance(one, (list, tuple)) and isinstance(two, (list, tuple)) and len(one) == len(two):
        yield from (f"entry {i}: {shorten(a)} and {shorten(b)}" for i, (a, b) in enumerate(zip(one, two)) if a != b)
    elif isinstance(one, bytes) and isinstance(two, bytes) and one != two:
        at = next((i for i, (a, b) in enumerate(zip(one, two)) if a != b), min(len(one), len(two)))
        yield f"byte {at}: {one[at:at + 24]!r} and {two[at:at + 24]!r}"
    elif one != two:
        yield f"{shorten(one)} and {shorten(two)}"


class Case:
    """rng: what the case chooses. Every value that a relation compares passes seen(): a test alters one there and expects
    that the relation notices. earlier: what the runs of the same case gave before; none is started again."""

    def __init__(self, program, folder, seed, alter=None, earlier=()):
        self.program, self.folder, self.rng = program, folder, random.Random(seed)
        self.alter, self.earlier = alter, list(earlier)
        self.runs, self.commands, self.observed, self.claims, self.skipped = [], [], 0, 0, set()

    # What runs.

    def grtx(self, *arguments, ends=(0,), environment=None, folder="", program=None, kill_after=None):
        """Runs the program in a folder of the case; Broken when it ends with another code. kill_after: seconds, then SIGKILL;
        how it ended is then left open."""
        words = [program or self.program, *map(str, arguments)]
        place = os.path.join(self.folder, folder)
        self.commands.append((f"cd {shlex.quote(place)} && " if folder else "") +
                             shlex.join(["grtx" if w == self.program else w for w in words]))
        done = self.earlier[len(self.runs)] if len(self.runs) < len(self.earlier) else self.start(words, place, environment,
                                                                                                kill_after)
        self.runs.append(done)
        if kill_after is None and done.code not in ends:
            said = done.errors.decode(errors="replace").strip().splitlines() or ["nothing"]
            raise Broken(f"{words[1]} ends with {done.code}: {said[-1][:300]}")
        return done

    def start(self, words, place, environment, kill_after):
        os.makedirs(place, exist_ok=True)
        env = {**os.environ, **(environment or {})}
        env = {name: value for name, value in env.items() if value is not None}
        process = subprocess.Popen(words, cwd=place, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, env=env, start_new_session=True)
        try:
            output, errors = process.communicate(timeout=SECONDS if kill_after is None else kill_after)
        except subprocess.TimeoutExpired:
            process.kill()
            output, errors = process.communicate()
            if kill_after is None:
                raise Broken(f"{words[1]} hangs") from None
        return Done(process.returncode, output, errors)

    def path(self, name):
        return os.path.join(self.folder, name)

    def write(self, name, text):
        with open(self.path(name), "w", encoding="utf-8") as file:
            file.write(text)
        return name

    # What was written.

    def seen(self, value):
        number, self.observed = self.observed, self.observed + 1
        return self.alter(number, value) if self.alter else value

    def content(self, name):
        with open(self.path(name), "rb") as file:
            return self.seen(file.read())

    def image(self, name):
        with open(self.path(name), "rb") as file:
            return self.seen(read_pfm(file.read()))

    def json(self, name):
        with open(self.path(name), encoding="utf-8") as file:
            return json.load(file)

    @staticmethod
    def printed(done):
        """The JSON document that a command printed."""
        return json.loads(done.output)

    def statistics(self, name):
        """{name: value} without the host's."""
        return self.seen(values_of(self.json(name)["stats"]))

    def rows(self, name, query):
        """Rows of a database."""
        with contextlib.closing(sqlite3.connect(f"file:{self.path(name)}?mode=ro", uri=True)) as database:
            return [list(row) for row in database.execute(query)]

    # What must hold.

    def same(self, what, one, two):
        self.claims += 1
        lines = list(differences(one, two))
        if lines:
            more = f", and {len(lines) - 1} more" if len(lines) > 1 else ""
            raise Broken(f"{what}: {lines[0]}{more}")

    def close(self, what, one, two, bound):
        """Two images at least `bound` dB alike."""
        self.claims += 1
        if (one.width, one.height) != (two.width, two.height):
            raise Broken(f"{what}: images of other sizes")
        found = decibels(one, two)
        if not found >= bound:
            raise Broken(f"{what}: {found:.1f} dB, less than {bound}; {next(differences(one, two), '')}")

    def near(self, what, one, two, share=0.0, slack=0.0):
        """Two numbers that differ by at most a share of the larger one and a slack."""
        self.claims += 1
        if not abs(one - two) <= share * max(abs(one), abs(two)) + slack:
            raise Broken(f"{what}: {one:.12g} and {two:.12g}")

    def at_most(self, what, one, limit):
        self.claims += 1
        if not one <= limit:
            raise Broken(f"{what}: {one:.12g}, more than {limit:.12g}")

    def holds(self, what, true):
        self.claims += 1
        if not true:
            raise Broken(what)


def values_of(entries):
    """{name: value} of {name: {value, unit, description}}, without the host's."""
    host = ("host.", "tracer.wall_seconds", "tracer.rays_per_second", "tracer.visits_per_second", "accel.build_seconds",
            "accel.pack_seconds", "accel.update.seconds")
    return {name: entry["value"] for name, entry in entries.items() if not name.startswith(host)}
