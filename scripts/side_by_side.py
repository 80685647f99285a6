#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Two processes of run, sweep and search side by side in one folder: one is refused by name, or the results are equal.

  scripts/side_by_side.py --program build/release/grtx --tries 50

Of each try the second process starts a random moment after the first (--seed). What must hold:

run     two scenes into one folder. Whoever ends with 0 leaves results of one scene alone, those of an undisturbed run.
sweep   one plan into one database, and into two databases of one folder, which share their traces: an undisturbed one's.
search  as sweep.

Exit code 0: every try held; 1: one did not, in a line each.
"""
import argparse
import json
import random
import subprocess
import sys
import tempfile
import time
from pathlib import Path

SECONDS = 300  # of one process, then it hangs
DESIGNS = ("baseline", "sw", "hw", "grtx")
SMALL = Path(__file__).resolve().parent.parent / "configs" / "small.toml"

SCENE = "[[scene]]\npreset = 'object'\ncount = 300\nseed = {}\nwidth = 8\nheight = 8\n"
SWEEP = f"base = '{SMALL}'\n" + SCENE.format(7) + "[grid]\ntracer.k = [4, 8]\nrt.warp_buffer.entries = [2, 4]\n"
SEARCH = (f"base = '{SMALL}'\n" + SCENE.format(7) + SCENE.format(8) + "role = 'evaluation'\n"
          "[[parameter]]\nkey = 'design'\nvalues = ['sw', 'grtx']\n"
          "[[parameter]]\nkey = 'rt.warp_buffer.entries'\nvalues = [2, 4]\n"
          "[[parameter]]\nkey = 'rt.checkpoint.lanes'\nvalues = [1, 4]\n"
          "[[objective]]\nvalue = 'gpu.time_us'\n[[objective]]\nvalue = 'cost.rt_unit_mm2'\n"
          "[reference]\ndesign = 'sw'\nrt.warp_buffer.entries = 4\nrt.checkpoint.lanes = 1\n"
          "[search]\npopulation = 8\ncandidates = 8\n")


class Bench:
    def __init__(self, program, folder, seed):
        self.program, self.folder, self.random = program, Path(folder), random.Random(seed)
        (self.folder / "sweep.toml").write_text(SWEEP)
        (self.folder / "search.toml").write_text(SEARCH)
        for seed in (1, 2):
            self.must(["synth", "--preset", "object", "--count", "300", "--seed", str(seed), "-o", f"s{seed}.ply", "--quiet"])

    def start(self, arguments):
        return subprocess.Popen([self.program, *arguments], cwd=self.folder, text=True, stdout=subprocess.PIPE,
                                stderr=subprocess.PIPE)

    def end(self, process):
        _, errors = process.communicate(timeout=SECONDS)
        return process.returncode, errors

    def must(self, arguments):
        code, errors = self.end(self.start(arguments))
        if code != 0:
            sys.exit(f"grtx {' '.join(arguments)}: {errors.strip()}")

    def both(self, first, second, within):
        """Ends of two processes, the second started at most `within` seconds after the first."""
        a = self.start(first)
        time.sleep(self.random.random() * within)
        b = self.start(second)
        return self.end(a), self.end(b)

    def run(self, scene, output):
        return ["run", "--scene", f"s{scene}.ply", "--cameras", f"s{scene}.cameras.json", "--width", "8", "--height", "8",
                "--config", str(SMALL), "--jobs", "2", "--quiet", "-o", output]

    def results(self, output):
        document = json.loads((self.folder / output / "results.json").read_text())
        files = {document["inputs"][design]["trace.files_hash"] for design in DESIGNS}
        return files, {design: document["designs"][design]["gpu.cycles"]["value"] for design in DESIGNS}

    def same(self, a, b):
        compared = subprocess.run([self.program, "sweep", "--compare", a, b], cwd=self.folder, text=True,
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
        return "" if compared.returncode == 0 else f"{a} and {b} differ: {compared.stdout.strip()[:200]}"


def refused(ends, name):
    """What is wrong with how two processes ended; refusals are counted by the caller."""
    if all(code != 0 for code, _ in ends):
        return f"both ended badly: {ends}"
    for code, errors in ends:
        if code != 0 and (code != 2 or name not in errors or "filling it" not in errors or errors.count("\n") != 1):
            return f"ended with {code}: {errors.strip()[:200]}"
    return ""


def try_run(bench, number):
    output = f"run{number}"
    ends = bench.both(bench.run(1, output), bench.run(2, output), 0.5)
    wrong = refused(ends, output)
    if wrong:
        return wrong, ends
    left = bench.results(output)
    of = [scene for scene in (1, 2) if left == bench.results(f"alone{scene}")]
    if not of or ends[of[0] - 1][0] != 0:
        return f"the results are those of no scene that was run: {left}", ends
    return "", ends


def try_database(bench, command, number):
    one, plan = f"{command}{number}.sqlite", f"{command}.toml"
    arguments = [command, plan, "--quiet", "--jobs", "1", "-o"]
    ends = bench.both(arguments + [one], arguments + [one], 0.3)
    wrong = refused(ends, one) or bench.same(one, f"alone.{command}.sqlite")
    if wrong:
        return wrong, ends
    # Two databases, whose traces are the same files.
    folder = bench.folder / f"{command}{number}"
    folder.mkdir()
    two = [f"{command}{number}/{name}.sqlite" for name in "ab"]
    both = bench.both(arguments + [two[0]], arguments + [two[1]], 0.3)
    if any(code != 0 for code, _ in both):
        return f"two databases in one folder: {both}", ends
    return bench.same(two[0], f"alone.{command}.sqlite") or bench.same(two[1], f"alone.{command}.sqlite"), ends


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", required=True, help="the grtx program")
    parser.add_argument("--tries", type=int, default=50)
    parser.add_argument("--commands", default="run,sweep,search")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    program = str(Path(options.program).resolve())
    failures = 0
    with tempfile.TemporaryDirectory(prefix="grtx_side_by_side_") as folder:
        bench = Bench(program, folder, options.seed)
        for command in options.commands.split(","):
            if command == "run":
                for scene in (1, 2):
                    bench.must(bench.run(scene, f"alone{scene}"))
            else:
                bench.must([command, f"{command}.toml", "--quiet", "-o", f"alone.{command}.sqlite"])
            counts = {"refused": 0, "equal": 0, "wrong": 0}
            for number in range(options.tries):
                wrong, ends = try_run(bench, number) if command == "run" else try_database(bench, command, number)
                if wrong:
                    print(f"{command}, try {number}: {wrong}")
                    counts["wrong"] += 1
                else:
                    counts["refused" if any(code == 2 for code, _ in ends) else "equal"] += 1
            failures += counts["wrong"]
            print(f"{command}: {options.tries} tries, {counts['refused']} refused, {counts['equal']} equal, "
                  f"{counts['wrong']} wrong", flush=True)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
