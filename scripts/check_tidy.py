#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs clang-tidy (.clang-tidy) over a part of the sources.

Usage: check_tidy.py [--base REVISION] [FILE...]
Without arguments, as the tests call it: the folders named in ALWAYS, whose sources are joined as the build joins them: what
they include is read once. With --base main: what differs from where the branch left main, uncommitted changes too; a header
counts as the source of the same name, or as one that includes it. FILE: those instead; one that the build does not know is
compiled by itself.
Exit code 1 and what clang-tidy says; 77, with a notice, when clang-tidy 14 (Debian 12) is not there.
"""
import argparse
import concurrent.futures
import glob
import json
import os
import re
import shutil
import subprocess
import sys

MAJOR = 14
TOP = os.path.abspath(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
BUILD = os.path.join(TOP, "build", "tidy")
ALWAYS = ("base/", "traces/")  # clean; the next folder joins when it is, and the time allows it
FOLDERS = ("base/", "traces/", "frontend/", "modules/", "rtl_tlm/", "explore/", "report/", "experiment/", "apps/", "examples/")


def git(*arguments):
    run = subprocess.run(["git", "-C", TOP, *arguments], capture_output=True, text=True, check=False)
    return run.stdout.splitlines() if run.returncode == 0 else []


def find_tool():
    for name in (f"clang-tidy-{MAJOR}", "clang-tidy"):
        if shutil.which(name):
            version = subprocess.run([name, "--version"], capture_output=True, text=True, check=True).stdout
            if re.search(rf"version {MAJOR}\.", version):
                return name
    return None


def source_of(file):
    """The source that shows what a changed file says, or None."""
    if not file.startswith(FOLDERS) or not os.path.exists(os.path.join(TOP, file)):
        return None
    if file.endswith(".cpp"):
        return file
    if not file.endswith(".h"):
        return None
    if os.path.exists(os.path.join(TOP, file[:-2] + ".cpp")):
        return file[:-2] + ".cpp"
    for source in sorted(glob.glob(os.path.join(TOP, file.split("/")[0], "**", "*.cpp"), recursive=True)):
        with open(source, encoding="utf-8") as text:
            if f'#include "grtx/{file}"' in text.read():
                return os.path.relpath(source, TOP)
    return None


def changed_files(base):
    start = git("merge-base", base, "HEAD", "--")
    if not start:
        sys.exit(f"check_tidy: {base} and HEAD have no commit in common")
    return git("diff", "--name-only", start[0], "--") + git("ls-files", "-o", "--exclude-standard")


def compile_database(build, *options):
    """The files that are compiled, and how, without what clang does not know of GCC."""
    made = subprocess.run(["cmake", "-S", TOP, "-B", build, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                           "-DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON", "-DGRTX_BUILD_TESTS=OFF", "-DGRTX_REPORT_CHARTS=OFF", *options],
                          capture_output=True, text=True, check=False)
    if made.returncode != 0:
        sys.exit(made.stdout + made.stderr)
    path = os.path.join(build, "compile_commands.json")
    with open(path, encoding="utf-8") as file:
        commands = json.load(file)
    for command in commands:
        command["command"] = re.sub(r" -(fpch-preprocess|Wno-restrict|Wno-stringop-overflow)(?= )", "",
                                    command["command"])
    with open(path, "w", encoding="utf-8") as file:
        json.dump(commands, file)
    return {os.path.relpath(command["file"], TOP) for command in commands}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--base")
    parser.add_argument("files", nargs="*")
    options = parser.parse_args()
    tool = find_tool()
    if tool is None:
        print(f"check_tidy: skipped, clang-tidy {MAJOR} is needed")
        return 77
    joined = not options.files and not options.base
    build = os.path.join(BUILD, "joined" if joined else "single")
    known = compile_database(build, *(["-DCMAKE_UNITY_BUILD=ON", "-DGRTX_BUILD_FRONTEND=OFF", "-DGRTX_BUILD_MODULES=OFF"]
                                      if joined else ["-DCMAKE_UNITY_BUILD=OFF"]))
    if options.files:
        sources = [os.path.relpath(os.path.abspath(f), TOP) for f in options.files]
    elif options.base:
        sources = [s for s in dict.fromkeys(map(source_of, changed_files(options.base))) if s in known]
    else:
        sources = sorted(known)

    def run(source):
        how = ["-p", build] if source in known else [f"--config-file={TOP}/.clang-tidy"]
        after = [] if source in known else ["--", "-std=c++20", "-I", os.path.join(TOP, "include")]
        if joined:  # a source is then what another includes
            how += ["--checks=-bugprone-suspicious-include", rf"--header-filter=^{re.escape(TOP)}/({'|'.join(ALWAYS)}).*\.(h|cpp)$"]
        return source, subprocess.run([tool, "--quiet", *how, os.path.join(TOP, source), *after], capture_output=True,
                                      text=True, check=False)

    failed = []
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for source, result in pool.map(run, sources):
            if result.returncode != 0:
                failed.append(source)
                print(result.stdout + re.sub(r"^\d+ warnings.*\n|^Suppressed.*\n", "", result.stderr, flags=re.M), end="")
    print(f"check_tidy: {len(sources)} {'joined ' if joined else ''}sources, {len(failed)} with findings")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
