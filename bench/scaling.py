#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How processor time and memory of a trace and of its simulation grow with rays, Gaussians and SMs.

    bench/scaling.py [--program GRTX] [--work FOLDER] [--only rays,gaussians,sms] [--most-gaussians N]

Rooms of `grtx synth --preset hall`, design grtx, machine paper-charged, cycle mode, one process at a time. Each axis is varied
alone; the others stay at 48 x 48 rays, 100,000 Gaussians and 8 SMs (SMs: 128 x 128 rays, so that all have work). Prints a table
of each axis in Markdown and, below it, the exponents of a straight line through the logarithms, the first point left out:
what does not grow is most of it. Then the largest run that 24 GiB hold if memory grows on as between the first and the last
point: an extrapolation.
"""
import argparse
import json
import math
import os
import resource
import subprocess
import sys

TOP = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
RAYS, GAUSSIANS, SMS = (16, 32, 48, 64, 96, 128), (30_000, 100_000, 300_000, 1_000_000, 3_000_000), (2, 4, 8, 16, 28, 46, 82)
MIB = 1 << 10  # of the kilobytes that the kernel counts


def run(command):
    """Processor seconds and the largest memory in MiB of a command."""
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    errors = process.stderr.read()
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        sys.exit(f"scaling.py: {' '.join(command)} ended with {process.returncode}: {errors.strip()[-500:]}")
    return used.ru_utime + used.ru_stime, used.ru_maxrss / MIB


class Bench:
    def __init__(self, program, work):
        self.program, self.work = program, work
        os.makedirs(work, exist_ok=True)

    def trace(self, gaussians, pixels):
        scene, trace = f"{self.work}/{gaussians}.ply", f"{self.work}/{gaussians}_{pixels}.grtx"
        if not os.path.exists(scene):
            run([self.program, "synth", "--preset", "hall", "--count", str(gaussians), "--seed", "1", "-o", scene, "--quiet"])
        return trace, run([self.program, "trace", "--scene", scene, "--cameras", scene[:-4] + ".cameras.json", "--width", str(pixels),
                           "--height", str(pixels), "--accel", "tlas-sphere", "--checkpoint", "on", "--threads", "1", "-o", trace, "--quiet"])

    def simulate(self, trace, sms):
        found = run([self.program, "sim", trace, "--machine", "paper-charged", "--set", f"gpu.sms={sms}", "--stats", f"{self.work}/s.json", "--quiet"])
        with open(f"{self.work}/s.json", encoding="utf-8") as file:
            return found, json.load(file)["stats"]


def exponent(points):
    """Slope and place of the line through the logarithms."""
    x, y = [math.log(a) for a, _ in points], [math.log(b) for _, b in points]
    mean_x, mean_y = sum(x) / len(x), sum(y) / len(y)
    slope = sum((a - mean_x) * (b - mean_y) for a, b in zip(x, y)) / sum((a - mean_x) ** 2 for a in x)
    return slope, math.exp(mean_y - slope * mean_x)


def table(name, rows):
    print(f"\n| {name} | trace, s | trace, MiB | simulation, s | simulation, MiB | node fetches | cycles |\n|---|---|---|---|---|---|---|")
    for at, traced, simulated, fetches, cycles in rows:
        print(f"| {at:,} | {traced[0]:.1f} | {traced[1]:,.0f} | {simulated[0]:.1f} | {simulated[1]:,.0f} | {fetches:,.0f} | {cycles:,.0f} |", flush=True)
    lines = {}
    for what, column, part in (("trace, s", 1, 0), ("trace, MiB", 1, 1), ("simulation, s", 2, 0), ("simulation, MiB", 2, 1)):
        lines[what] = exponent([(row[0], max(row[column][part], 1e-3)) for row in rows[1:]])
    print("\nExponents: " + "; ".join(f"{what}: {slope:.2f}" for what, (slope, _) in lines.items()) + ".")
    for what, column in (("trace", 1), ("simulation", 2)):
        (x, low), (at, high) = [(row[0], row[column][1]) for row in (rows[0], rows[-1])]
        if high > 1.5 * low:  # else it hardly grows
            print(f"Extrapolated, {(high - low) * 1024 / (at - x):,.2f} KiB more for each: 24 GiB hold a {what} of "
                  f"{x + (24 * 1024 - low) * (at - x) / (high - low):,.0f} {name}.")


def main():
    parser = argparse.ArgumentParser(prog="scaling.py", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=os.path.join(TOP, "build", "release", "grtx"))
    parser.add_argument("--work", default=os.path.join(TOP, "build", "scaling"))
    parser.add_argument("--only", default="rays,gaussians,sms")
    parser.add_argument("--most-gaussians", type=int, default=1_000_000)
    options = parser.parse_args()
    if not os.access(options.program, os.X_OK):
        parser.error(f"--program {options.program}: no program")
    if options.most_gaussians < GAUSSIANS[2]:
        parser.error(f"--most-gaussians {options.most_gaussians}: must be {GAUSSIANS[2]} at least, for a line")
    unknown = set(options.only.split(",")) - {"rays", "gaussians", "sms"}
    if unknown:
        parser.error(f"--only {options.only}: must be of rays, gaussians, sms")
    bench = Bench(options.program, options.work)

    def point(at, gaussians, pixels, sms):
        trace, traced = bench.trace(gaussians, pixels)
        simulated, values = bench.simulate(trace, sms)
        return at, traced, simulated, values["gpu.rt.node_fetches"]["value"], values["gpu.cycles"]["value"]
    if "rays" in options.only:
        table("rays", [point(pixels * pixels, 100_000, pixels, 8) for pixels in RAYS])
    if "gaussians" in options.only:
        table("Gaussians", [point(count, count, 48, 8) for count in GAUSSIANS if count <= options.most_gaussians])
    if "sms" in options.only:
        table("SMs", [point(sms, 100_000, 128, sms) for sms in SMS])
    print(f"\nLargest memory of a child: {resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / MIB:,.0f} MiB")


if __name__ == "__main__":
    main()
