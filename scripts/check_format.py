#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Finds sources that clang-format would write otherwise (.clang-format).

Usage: check_format.py [--fix] [FILE...]   (default: every .h and .cpp of the project)
Exit code 1 and one line a file that differs; 77, with a notice, when clang-format 14 (Debian 12) is not there: another
version formats otherwise.
"""
import os
import re
import shutil
import subprocess
import sys

MAJOR = 14
TOP = os.path.abspath(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))


def find_tool():
    """clang-format of the pinned version, or what is there instead."""
    seen = []
    for name in (f"clang-format-{MAJOR}", "clang-format"):
        if shutil.which(name):
            version = subprocess.run([name, "--version"], capture_output=True, text=True, check=True).stdout
            found = re.search(r"version (\d+)", version)
            if found and int(found.group(1)) == MAJOR:
                return name, ""
            seen.append(version.strip())
    return None, ", ".join(seen) or "none"


def main(arguments):
    tool, seen = find_tool()
    if tool is None:
        print(f"check_format: skipped, clang-format {MAJOR} is needed and there is {seen}")
        return 77
    files = [a for a in arguments if a != "--fix"]
    if not files:
        for folder, names, here in os.walk(TOP):
            names[:] = sorted(n for n in names if not n.startswith(".") and n != "build")
            files += [os.path.join(folder, f) for f in sorted(here) if f.endswith((".h", ".cpp"))]
    if "--fix" in arguments:
        return subprocess.run([tool, "-i", *files], check=False).returncode
    run = subprocess.run([tool, "--dry-run", *files], capture_output=True, text=True, check=False)
    if run.returncode != 0:
        print(run.stderr)
        return run.returncode
    differing = {}
    for found in re.finditer(r"^(.*?):(\d+):\d+: warning: code should be clang-formatted", run.stderr, re.M):
        differing.setdefault(os.path.relpath(found.group(1), TOP), found.group(2))
    for file, line in sorted(differing.items()):
        print(f"{file}:{line}: is not as clang-format writes it (scripts/check_format.py --fix)")
    return 1 if differing else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
