#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Processor time and instructions of a memory request, ours beside simulators of others: DRAM alone, L1 alone.

    bench/peers.py [--ramulator BUILD] [--dramsys BUILD] [--l1 NAME=PROGRAM]... [--work FOLDER] [--requests N]

A peer is measured where its path is given, and skipped, saying so, where it is not. --ramulator, --dramsys: build folders
of yours (docs/guide/dram-backends.md). --l1: a program of yours that gives another simulator's cache the requests of
bench/l1_requests.cpp: its arguments are KILOBYTES and REQUESTS, it prints requests, misses, cycles, nanoseconds a request.

All take the same requests: reads of 32 B, one slice, 64 in flight (DRAM, GDDR6); reads of 64 B blocks, one a cycle
(L1 of 64 KB). Readers, links and SystemC's kernel are part of each figure of the DRAM; `perfect` shows what they take.
Time is the processor's, the least of three runs. Instructions are valgrind's, of N requests more (none: "-").
Prints tables in Markdown, with versions and the kind of host. Exit code 2: bad input.
"""
import argparse
import os
import platform
import re
import shutil
import subprocess
import sys

TOP = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))


def must(command, **more):
    done = subprocess.run(command, capture_output=True, text=True, check=False, **more)
    if done.returncode != 0:
        sys.exit(f"peers.py: {' '.join(command[:4])} ended with {done.returncode}:\n{(done.stdout + done.stderr)[-2000:]}")
    return done.stdout


def version(folder):
    done = subprocess.run(["git", "-C", folder, "describe", "--tags", "--always", "--dirty"], capture_output=True, text=True, check=False)
    return done.stdout.strip() or "of no git checkout"


def source_of(build):
    with open(os.path.join(build, "CMakeCache.txt"), encoding="utf-8") as cache:
        return re.search(r"^CMAKE_HOME_DIRECTORY:INTERNAL=(.*)$", cache.read(), re.M)[1]


def instructions(command, requests):
    """Of a request: of 2 N requests without those of N, so that the start is left out; None without valgrind."""
    if not shutil.which("valgrind"):
        return None
    counts = []
    for count in (requests, 2 * requests):
        done = subprocess.run(["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", *command(count)], capture_output=True, text=True,
                              check=False)
        found = re.search(r"Collected : (\d+)", done.stderr)
        if done.returncode != 0 or not found:
            sys.exit(f"peers.py: valgrind {' '.join(command(count))}:\n{done.stderr[-2000:]}")
        counts.append(int(found[1]))
    return (counts[1] - counts[0]) / requests


def row(cells):
    print("| " + " | ".join(cells) + " |", flush=True)


def shown(number):
    return "-" if number is None else f"{number:,.0f}"


def dram(options, bench):
    models = {"perfect": ("built in, no banks", "perfect", ["--config", f"{TOP}/configs/dram/gddr6.toml"]),
              "built_in": ("built in", "built_in", ["--config", f"{TOP}/configs/dram/gddr6.toml"])}
    if options.ramulator:
        models["ramulator"] = (f"Ramulator {version(source_of(options.ramulator))}", "ramulator",
                               ["--config", os.path.join(options.work, "ramulator_gddr6.yaml")])
    if options.dramsys:
        models["dramsys"] = (f"DRAMSys {version(source_of(options.dramsys))}", "dramsys", ["--config", f"{TOP}/configs/dram/dramsys_gddr6.json"])
    print("\nDRAM alone, GDDR6, reads of 32 B, one slice, 64 in flight:\n")
    row(["memory", "streaming, ns", "random, ns", "% of the peak", "instructions, both"])
    row(["---"] * 5)
    for name, model, settings in models.values():
        def command(requests):
            return [bench, "--model", model, *settings, "--slices", "1", "--requests", str(requests), "--peak", "28.07"]
        best, peak = {}, {}
        for _ in range(3):
            for line in must(command(options.requests), cwd=TOP).splitlines():
                cells = line.split()
                if cells and cells[0] == model:
                    best[cells[1]] = min(float(cells[-1]), best.get(cells[1], float("inf")))
                    peak[cells[1]] = cells[5]
        count = instructions(command, options.requests // 10)
        row([name, shown(best["streaming"]), shown(best["random"]), f"{peak['streaming']}, {peak['random']}", shown(count and count / 2)])


def l1(options, ours):
    programs = [("ours", [ours])]
    programs += [(name, [os.path.abspath(program)]) for name, program in options.l1]
    print("\nL1 alone, 64 KB, 16 ways, reads of 64 B blocks, one a cycle, memory of 100 cycles:\n")
    row(["cache", "blocks of", "misses", "cycles", "ns", "instructions"])
    row(["---"] * 6)
    for name, program in programs:
        for kilobytes in ("32", "1024"):
            def command(requests):
                return [*program, kilobytes, str(requests)]
            runs = [must(command(options.requests)).split() for _ in range(3)]
            requests, misses, cycles, _ = map(float, runs[0])
            row([name, f"{kilobytes} KB", f"{100 * misses / requests:.1f} %", shown(cycles), shown(min(float(run[-1]) for run in runs)),
                 shown(instructions(command, options.requests // 10))])


def main():
    parser = argparse.ArgumentParser(prog="peers.py", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--ramulator", metavar="BUILD")
    parser.add_argument("--dramsys", metavar="BUILD")
    parser.add_argument("--l1", metavar="NAME=PROGRAM", action="append", default=[])
    parser.add_argument("--work", metavar="FOLDER", default=os.path.join(TOP, "build", "peers"), help="default: build/peers")
    parser.add_argument("--requests", type=int, default=200_000)
    options = parser.parse_args()
    if options.requests < 10_000:
        parser.error("--requests: must be 10000 at least")
    for name in ("ramulator", "dramsys"):
        path = getattr(options, name)
        if not path:
            print(f"{name}: skipped, --{name} names no path")
        elif not os.path.exists(os.path.join(path, "CMakeCache.txt")):
            parser.error(f"--{name} {path}: has no CMakeCache.txt")
        else:
            setattr(options, name, os.path.abspath(path))
    options.l1 = [text.partition("=")[::2] for text in options.l1]
    for name, program in options.l1:
        if not os.access(program, os.X_OK):
            parser.error(f"--l1 {name}={program}: must be NAME=PROGRAM, a program that runs")
    if not options.l1:
        print("another L1: skipped, --l1 names no program")
    options.work = os.path.abspath(options.work)
    must(["cmake", "-S", TOP, "-B", options.work, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", "-DCMAKE_UNITY_BUILD=ON", "-DGRTX_BUILD_BENCH=ON",
          "-DGRTX_BUILD_TESTS=OFF", f"-DGRTX_RAMULATOR={options.ramulator or ''}", f"-DGRTX_DRAMSYS={options.dramsys or ''}"])
    must(["cmake", "--build", options.work, "--target", "dram_bandwidth", "l1_requests"])
    cpu = re.search(r"^model name\s*: (.*)$", open("/proc/cpuinfo", encoding="utf-8").read(), re.M)
    print(f"host: {cpu[1] if cpu else platform.processor()}, {os.cpu_count()} processors; {must(['c++', '--version']).splitlines()[0]}; "
          f"this project {version(TOP)}")
    dram(options, os.path.join(options.work, "bench", "dram_bandwidth"))
    l1(options, os.path.join(options.work, "bench", "l1_requests"))


if __name__ == "__main__":
    main()
