#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs random legal machines on random small traces.

    scripts/fuzz_machines.py [--program build/release/grtx] [--first SEED] [--count N] [--seconds S] [--keep FOLDER]

A seed is a trace and a configuration. Keys and ranges are those that `grtx sim --list-config` prints. A third of the
machines is mild (every key within a factor of four of its default), a third at edges (a few keys at an end of their range
or anywhere in it), a third both. Held for each:

* it ends with 0 (conservation laws and lower bounds hold), or with 2 and one line;
* nobody takes longer than --timeout or more than --memory.

Prints a row a find (seed, what, command), then a table for docs/validation.md. Exit code 1 with finds.
"""
import argparse
import collections
import math
import os
import random
import re
import resource
import shlex
import shutil
import subprocess
import sys
import tempfile
import time

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
TABLE1 = os.path.join(ROOT, "configs", "table1.toml")  # every key at its default, checkpoint traffic charged
# Values that a rule wants to be powers of two.
POWERS = {"l1.line_bytes", "l2.line_bytes", "l2.interleave_bytes", "rt.memory.sectors_per_cycle",
          "simt.sectors_per_cycle", "rt.memory.instance_leaf_bytes", "dram.group_bytes"}
# Whole sets of the default shapes: most other sizes are refused.
SETS = {"l1.bytes": 32768, "l2.bytes": 8192}
# The tags of larger ones do not fit into --memory; a unit that is blocked asks in each cycle of a longer wait, for minutes.
MOST = {"l2.bytes": 1 << 28, "dram.fixed_latency": 1e6}
SCENES = [("object", 120), ("flat", 150), ("object", 400)]
DESIGNS = [("tri20", "off"), ("tlas-tri20", "off"), ("tri20", "on"), ("tlas-tri20", "on"), ("tri80", "off"),
           ("tlas-tri80", "on"), ("ellipsoid", "off"), ("ellipsoid", "on"), ("tlas-sphere", "off"),
           ("tlas-sphere", "on")]
TRACES = 150
# What a run that ends well may say: what limits its figures (notes).
NOTICES = r"grtx: sim: "


class Key:
    """A row of --list-config."""

    def __init__(self, name, default, values, unit):
        self.name, self.unit = name, unit
        ends = re.fullmatch(r"(\S+) to (\S+)", values)
        self.names = None if ends else values.split(", ")
        if ends:
            self.default, self.low, self.high = float(default), float(ends[1]), min(float(ends[2]), MOST.get(name, math.inf))
        self.whole = bool(ends) and not name.endswith("mhz")

    def text(self, value):
        if self.name in POWERS and value > 0:
            value = 2 ** round(math.log2(value))
        if step := SETS.get(self.name):
            value = max(1, round(value / step)) * step
        value = min(max(value, self.low), self.high)
        return str(round(value)) if self.whole else f"{value:.6g}"

    def near(self, rng):
        """Within a factor of four of the default."""
        if self.names:
            return rng.choice(self.names)
        if self.default == 0:
            return self.text(rng.choice([0, 0, 1, 2, 4, 8, 40]))
        return self.text(self.default * 4 ** rng.uniform(-1, 1))

    def far(self, rng):
        """An end of the range, beside it, or anywhere."""
        if self.names:
            return rng.choice(self.names)
        where = rng.randrange(6)
        if where < 2:
            return self.text(self.low + where)
        if where < 4:
            return self.text(self.high - (where - 2))
        low = max(self.low, 1)
        return self.text(low * (self.high / low) ** rng.random())


def keys_of(program):
    text = subprocess.run([program, "sim", "--list-config"], check=True, capture_output=True, text=True).stdout
    keys = []
    for row in text.splitlines():
        cells = [cell.strip() for cell in re.split(r"(?<!\\)\|", row)]
        if len(cells) < 5 or not cells[1].startswith("`"):
            continue
        if "implementation" in cells[1] or cells[1] == "`dram.model`":
            continue  # what a build may not have
        keys.append(Key(cells[1].strip("`"), cells[2], cells[3], cells[4]))
    return keys


def machine(rng, keys):
    """Settings, and whether it is mild."""
    kind = rng.choice(["mild", "edge", "both"])
    settings = {}
    if kind != "edge":
        for key in rng.sample(keys, rng.randrange(1, 25)):
            settings[key.name] = key.near(rng)
    if kind != "mild":
        for key in rng.sample(keys, rng.choice([1, 1, 2, 3, 6])):
            settings[key.name] = key.far(rng)
    # An SM costs the host time, and what 256 of them do 16 do.
    if int(settings.get("gpu.sms", 2)) > 16 and rng.random() < 0.9:
        settings["gpu.sms"] = str(rng.randrange(1, 16))
    settings.setdefault("gpu.sms", "2")
    return kind, settings


def repaired(settings, message):
    """Drops the key that a rule about two keys names, and those of the same table; None: there is none left."""
    match = re.match(r"grtx: \S+: ([a-z0-9_.]+)", message)
    if not match:
        return None
    table = match[1].rsplit(".", 1)[0]
    left = {key: value for key, value in settings.items()
            if not (key == match[1] or key.startswith(table + ".") or key in message)}
    return left if left != settings else None


class Traces:
    """So many, by number, each made when it is first asked for."""

    def __init__(self, program, folder):
        self.program, self.folder, self.made = program, folder, {}

    def call(self, *arguments):
        subprocess.run([self.program, *arguments, "--quiet"], check=True, cwd=self.folder, capture_output=True)

    def scene(self, number):
        name = f"scene{number}"
        if not os.path.exists(f"{self.folder}/{name}.ply"):
            preset, count = SCENES[number]
            self.call("synth", "--preset", preset, "--count", str(count), "--seed", str(7 + number), "--sh-degree",
                      str(number), "-o", f"{name}.ply")
        return name

    def trace(self, number):
        """Its name; None: options that do not go together."""
        if number not in self.made:
            self.made[number] = self.make(f"t{number}.grtx", *self.options(random.Random(f"trace {number}")))
        return self.made[number]

    def options(self, rng):
        """(scene, (width, height), options of the tracer)."""
        scene = self.scene(rng.randrange(len(SCENES)))
        accel, checkpoint = rng.choice(DESIGNS)
        # Mostly one or two warps.
        width, height = rng.choice([(4, 4), (8, 4), (8, 8), (8, 8), (16, 8), (16, 12)])
        if rng.random() < 0.03:
            width, height = 64, 64
        options = ["--accel", accel, "--checkpoint", checkpoint, "--k", rng.choice(["1", "2", "4", "8", "16"]),
                   "--child-order", rng.choice(["near_first", "slot", "vulkan_sim"]),
                   "--pop-test", rng.choice(["on", "off"]),
                   "--layout", rng.choice(["vulkan_sim", "vulkan_sim", "compact", "compressed", "quantised"])]
        if checkpoint == "off" and rng.random() < 0.3:
            tracing = rng.choice(["single", "closest", "list"])
            options += ["--tracing", tracing]
            if tracing == "list":
                options += ["--list-capacity", rng.choice(["16", "1024"])]
            if tracing == "single":
                options[options.index("--k") + 1] = "256"
        if rng.random() < 0.2:
            options += ["--warp-size", rng.choice(["4", "8", "16"])]
        if rng.random() < 0.1:
            options += ["--secondary", "both"]
        return scene, (width, height), options

    def make(self, name, scene, size, options):
        try:
            self.call("trace", "--scene", f"{scene}.ply", "--cameras", f"{scene}.cameras.json", "--width", str(size[0]),
                      "--height", str(size[1]), *options, "-o", name)
        except subprocess.CalledProcessError:
            return None
        return name


class Fuzzer:
    def __init__(self, options, folder):
        self.options, self.folder = options, folder
        self.program = os.path.abspath(options.program)
        self.keys = keys_of(self.program)
        self.traces = Traces(self.program, folder)
        self.finds = []
        self.ended = collections.Counter()
        self.slowest = (0.0, 0)

    def run(self, seed, trace, settings):
        """(code, lines of stderr)."""
        arguments = [self.program, "sim", trace, "--quiet", "--machine", TABLE1]
        for key, value in settings.items():
            arguments += ["--set", f"{key}={value}"]
        begin = time.monotonic()
        memory = self.options.memory << 20

        def before():
            resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))

        try:
            done = subprocess.run(arguments, cwd=self.folder, capture_output=True, text=True, preexec_fn=before,
                                  timeout=self.options.timeout)
            code, errors = done.returncode, re.sub(r"grtx: configuration: .* no effect .*\n", "", done.stderr)
        except subprocess.TimeoutExpired:
            code, errors = "hang", ""
        seconds = time.monotonic() - begin
        if seconds > self.slowest[0]:
            self.slowest = (seconds, seed)
        self.ended["machines", code] += 1
        self.command = shlex.join(arguments[1:])
        return code, errors.strip().splitlines()

    def find(self, seed, what):
        self.finds.append(seed)
        print(f"seed {seed}: {what}\n    grtx {self.command}", flush=True)
        if self.options.keep:
            os.makedirs(self.options.keep, exist_ok=True)
            trace = self.command.split()[1]
            shutil.copy(f"{self.folder}/{trace}", f"{self.options.keep}/{seed}.grtx")

    def judge(self, seed, code, lines):
        """Whether a run ended as a run may."""
        if code == 0:
            strange = [line for line in lines if not re.match(NOTICES, line)]
            if strange:
                self.find(seed, strange[0])
        elif code != 2 or len(lines) != 1 or not lines[0].startswith("grtx: "):
            self.find(seed, f"ends with {code}: {' / '.join(lines[-2:])[-300:]}")
            return False
        return True

    def one(self, seed):
        rng = random.Random(seed)
        trace = None
        while trace is None:
            number = rng.randrange(TRACES)
            trace = self.traces.trace(number)
        kind, settings = machine(rng, self.keys)
        for _ in range(6):  # rules about two keys
            code, lines = self.run(seed, trace, settings)
            if not self.judge(seed, code, lines):
                return
            fewer = repaired(settings, lines[-1]) if code == 2 else None
            if fewer is None:
                break
            settings = fewer
        self.ended[kind, code] += 1

    def table(self, count, seconds):
        print(f"\n{count} machines from seed {self.options.first}, {seconds:.0f} s, {len(self.finds)} finds; slowest run "
              f"{self.slowest[0]:.1f} s (seed {self.slowest[1]})\n\n| runs | exit 0 | exit 2 | other |\n"
              "|---|---|---|---|")
        codes = {code: n for (of, code), n in self.ended.items() if of == "machines"}
        other = sum(n for code, n in codes.items() if code not in (0, 2))
        print(f"| cycle | {codes.get(0, 0)} | {codes.get(2, 0)} | {other} |")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", default=f"{ROOT}/build/release/grtx")
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--seconds", type=float, default=math.inf, help="no new machine after so many")
    parser.add_argument("--timeout", type=float, default=60, help="seconds of a run, then it hangs")
    parser.add_argument("--memory", type=int, default=4096, help="MiB of address space of a run")
    parser.add_argument("--keep", help="folder for traces of finds")
    options = parser.parse_args()
    begin = time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        fuzzer = Fuzzer(options, folder)
        count = 0
        try:
            while count < options.count and time.monotonic() - begin < options.seconds:
                fuzzer.one(options.first + count)
                count += 1
        except KeyboardInterrupt:
            pass  # the table is of those that are done
        fuzzer.table(count, time.monotonic() - begin)
        sys.exit(1 if fuzzer.finds else 0)


if __name__ == "__main__":
    main()
