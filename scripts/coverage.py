#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Which lines the tests run, from a build of preset `fuzz` (clang, -fcoverage-mapping).

    LLVM_PROFILE_FILE=$PWD/build/fuzz/profile/%m_%p.profraw ctest --preset fuzz      # or single test programs
    scripts/coverage.py [--build build/fuzz] [--profiles build/fuzz/profile] [--folders modules,traces] [--lines]

Prints a table of docs/validation.md: lines of each folder, those that a test ran, the share. --lines: also each piece of --folders
that none ran, as FILE:FIRST-LAST and its first line. Profiles are merged into one file and then removed, so several runs add up.
"""
import argparse
import collections
import glob
import os
import re
import shutil
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
TOP = ("base", "traces", "frontend", "modules", "rtl_tlm", "explore", "report", "experiment", "apps")


def tool(name):
    for candidate in (name, name + "-14"):
        if shutil.which(candidate):
            return candidate
    sys.exit(f"coverage.py: {name} is needed (apt-get install llvm)")


def merge(profiles):
    """Adds what lies in the folder to PROFILES/all.profdata."""
    total, raw = profiles + "/all.profdata", sorted(glob.glob(profiles + "/*.profraw"))
    for start in range(0, len(raw), 200):
        some = raw[start:start + 200]
        before = [total] if os.path.exists(total) else []
        # A process that was killed leaves a profile that is cut off.
        subprocess.run([tool("llvm-profdata"), "merge", "--sparse", "--failure-mode=all", "-o", total + ".new", *before, *some],
                       check=True, stderr=subprocess.DEVNULL)
        os.replace(total + ".new", total)
        for file in some:
            os.remove(file)
    if not os.path.exists(total):
        sys.exit(f"coverage.py: {profiles} holds no profiles")
    return total


def counted_lines(build, profile):
    """{file: {line: times}} of the project's own folders."""
    programs = [p for p in [build + "/grtx", *glob.glob(build + "/tests/*_tests"), build + "/tests/fuzz_readers"]
                if os.path.isfile(p) and os.access(p, os.X_OK)]
    if not programs:
        sys.exit(f"coverage.py: {build} holds no programs")
    objects = [word for program in programs[1:] for word in ("-object", program)]
    text = subprocess.run([tool("llvm-cov"), "export", "-format=lcov", "-instr-profile", profile, programs[0], *objects],
                          check=True, capture_output=True, text=True).stdout
    lines, file = collections.defaultdict(dict), None
    for row in text.split("\n"):
        if row.startswith("SF:"):
            path = re.sub(r".*/include/grtx/", ROOT + "/", row[3:])  # headers are seen through the build's links
            file = os.path.relpath(os.path.realpath(path), ROOT)
            file = file if file.split("/")[0] in TOP else None
        elif file and row.startswith("DA:"):
            line, times = row[3:].split(",")[:2]
            lines[file][int(line)] = max(lines[file].get(int(line), 0), int(times))
    return lines


def folder_of(file):
    parts = file.split("/")
    return "/".join(parts[:2]) if parts[0] in ("modules", "frontend", "rtl_tlm", "explore", "report") and len(parts) > 2 else parts[0]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--build", default=ROOT + "/build/fuzz")
    parser.add_argument("--profiles", default=ROOT + "/build/fuzz/profile")
    parser.add_argument("--folders", default="modules,traces")
    parser.add_argument("--lines", action="store_true")
    options = parser.parse_args()
    lines = counted_lines(options.build, merge(options.profiles))
    total, run = collections.Counter(), collections.Counter()
    for file, counts in lines.items():
        total[folder_of(file)] += len(counts)
        run[folder_of(file)] += sum(times > 0 for times in counts.values())
    print("| folder | lines | run | share |\n|---|---|---|---|")
    for folder in sorted(total):
        print(f"| `{folder}/` | {total[folder]} | {run[folder]} | {100 * run[folder] / total[folder]:.1f} % |")
    if not options.lines:
        return
    for file in sorted(lines):
        if file.split("/")[0] not in options.folders.split(","):
            continue
        with open(f"{ROOT}/{file}", encoding="utf-8") as source:
            text = source.read().split("\n")
        pieces = []
        for line in sorted(lines[file]):
            if lines[file][line] > 0:
                continue
            if pieces and line == pieces[-1][1] + 1:
                pieces[-1][1] = line
            else:
                pieces.append([line, line])
        for first, last in pieces:
            print(f"{file}:{first}-{last}: {text[first - 1].strip()}")


if __name__ == "__main__":
    main()
