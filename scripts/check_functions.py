#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Finds functions whose body has more than 60 lines, in sources that clang-format has written: a body ends where a line
begins with } and is indented as the function is. Tables of data are no functions, and tests may be long.

Usage: check_functions.py [FOLDER]   (default: the folder above this script)
Exit code 1 and one line a function: file, line, how long.
"""
import os
import re
import sys

MOST = 60
FOLDERS = ("base", "traces", "frontend", "modules", "rtl_tlm", "explore", "report", "experiment", "apps", "examples")
NO_FUNCTION = re.compile(r"(inline |constexpr )*(namespace|struct|class|enum|union|if|for|while|switch|else|do|try|extern|case|default)\b"
                         r"|template <[^{]*> (struct|class)\b|}")
LAMBDA = re.compile(r"\[[^\[\]\"]*\](\(.*\))?( mutable)?( -> [\w:<>]+)? {$")


def indent(line):
    return len(line) - len(line.lstrip())


def long_functions(lines):
    """(number of the line, lines of the body) of each function above MOST."""
    for number, line in enumerate(lines):
        if not line.endswith(" {"):
            continue
        start = number
        while start > 0 and not re.search(r"(^|[;{}]|^ *//.*|^ *(public|private|protected):|\)>)$", lines[start - 1]):
            start -= 1
        if NO_FUNCTION.match(" ".join(lines[start:number + 1]).lstrip()) or "(" not in "".join(lines[start:number + 1]):
            continue
        end = " " * indent(lines[number if LAMBDA.search(line) else start]) + "}"
        body = next((i for i, later in enumerate(lines[number + 1:]) if later.startswith(end)), 0)
        if body > MOST:
            yield number + 1, body


def main(arguments):
    top = arguments[0] if arguments else os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")
    found = 0
    for start in FOLDERS:
        for folder, names, files in os.walk(os.path.join(top, start)):
            names.sort()
            for path in (os.path.join(folder, f) for f in sorted(files) if f.endswith((".h", ".cpp"))):
                with open(path, encoding="utf-8") as stream:
                    for line, body in long_functions(stream.read().split("\n")):
                        print(f"{os.path.relpath(path, top)}:{line}: a body of {body} lines, above {MOST}: which second idea moved in?")
                        found += 1
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
