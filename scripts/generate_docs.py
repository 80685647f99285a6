#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the generated parts of the documentation anew.

What lies between a line `<!-- generated: grtx ARGUMENTS -->` and the next line `<!-- end of generated -->` of a page in
docs/ becomes what that command prints.

Usage: generate_docs.py [--check] GRTX
--check: writes nothing; exit code 1 and one line for each page that is out of date.
"""
import argparse
import glob
import os
import re
import subprocess
import sys

PART = re.compile(r"(<!-- generated: grtx ([^\n]*) -->\n)(.*?)(<!-- end of generated -->\n)", re.S)


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--check", action="store_true")
    options.add_argument("grtx", help="the program")
    arguments = options.parse_args()

    def renewed(part):
        command = [arguments.grtx] + part.group(2).split()
        printed = subprocess.run(command, check=True, capture_output=True, text=True).stdout
        return part.group(1) + "\n" + printed + "\n" + part.group(4)

    top = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")
    stale = 0
    for page in sorted(glob.glob(os.path.join(top, "docs", "**", "*.md"), recursive=True)):
        with open(page, encoding="utf-8") as file:
            text = file.read()
        fresh = PART.sub(renewed, text)
        if fresh == text:
            continue
        stale += 1
        name = os.path.relpath(page, top)
        if arguments.check:
            print(f"{name}: out of date: run scripts/generate_docs.py {arguments.grtx}", file=sys.stderr)
        else:
            with open(page, "w", encoding="utf-8") as file:
                file.write(fresh)
            print(name)
    return 1 if arguments.check and stale else 0


if __name__ == "__main__":
    sys.exit(main())
