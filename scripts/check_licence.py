#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Finds source files without a licence line (SPDX) at the top.

Usage: check_licence.py [--fix]
Exit code 1 and one line a file that has none; --fix writes it.
"""
import os
import sys

TOP = os.path.abspath(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
LINE = "SPDX-License-Identifier: Apache-2.0"
COMMENTS = {".h": "// {}", ".cpp": "// {}", ".sv": "// {}", ".svh": "// {}", ".js": "// {}", ".mjs": "// {}",
            ".css": "/* {} */", ".py": "# {}", ".sh": "# {}", ".cmake": "# {}", "CMakeLists.txt": "# {}"}
FOREIGN = ("data", "node_modules")  # folders whose files are inputs, not sources


def comment_of(name):
    """How a file of this name says it, or None if it says nothing."""
    return COMMENTS.get(name) or COMMENTS.get(os.path.splitext(name)[1])


def source_files():
    """Every source file of the project: its path and the line that it starts with."""
    for folder, names, files in os.walk(TOP):
        names[:] = sorted(n for n in names if not n.startswith((".", "build")) and n not in FOREIGN)
        for name in sorted(files):
            comment = comment_of(name)
            if comment:
                yield os.path.join(folder, name), comment.format(LINE)


def with_licence(text, line):
    """The text with the line on top, below `#!` if it has one; None if it is there already."""
    lines = text.split("\n")
    at = 1 if lines[0].startswith("#!") else 0
    if len(lines) > at and lines[at] == line:
        return None
    return "\n".join(lines[:at] + [line] + lines[at:])


def main(arguments):
    missing = []
    for path, line in source_files():
        with open(path, encoding="utf-8") as stream:
            text = with_licence(stream.read(), line)
        if text is None:
            continue
        missing.append(os.path.relpath(path, TOP))
        if "--fix" in arguments:
            with open(path, "w", encoding="utf-8") as stream:
                stream.write(text)
    if "--fix" in arguments:
        print(f"check_licence: {len(missing)} files written")
        return 0
    for path in missing:
        print(f"{path}:1: no line '{LINE}'")
    return 1 if missing else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
