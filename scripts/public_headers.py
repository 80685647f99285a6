#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The public headers (docs/api/public_headers.txt), and what they stand on.

Usage: public_headers.py [--list | --reached | --check]
--list     the public headers
--reached  headers that are not public and that public ones include, so that an installation needs them, too
--check    each public header exists, once, has a comment that says what it is, and shows no type of an internal header;
           each header that an example, the test of the package or a guide includes is public; installed are no more than
           MOST. Exit code 1 and a line a fault
Without: how many there are.
"""
import glob
import os
import re
import sys

TOP = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
LIST = "docs/api/public_headers.txt"
MOST = 159  # of headers that are installed: a third of those that were once
LIBRARIES = ("base", "traces", "frontend", "modules", "rtl_tlm", "explore", "report", "experiment")
# A type of a namespace, as clang-format writes it: at the begin of a line. Forward declarations are none.
TYPE = re.compile(r"^(?:struct|class|enum class|using|concept) (?:alignas\(\w+\) |\[\[[^\]]*\]\] )*(\w+)(?: final)?(?: :[^\n;]*)?(?: \{| =|$)", re.M)
USERS = ("examples/*", "tests/package/outside/*", "docs/guide/*.md", "docs/add-a-module.md")


def read(name):
    with open(os.path.join(TOP, name), encoding="utf-8") as file:
        return file.read()


def public():
    return [line for line in read(LIST).splitlines() if line and not line.startswith("#")]


def all_headers():
    found = [os.path.relpath(path, TOP) for folder in LIBRARIES
             for path in glob.glob(os.path.join(TOP, folder, "**", "*.h"), recursive=True)]
    return sorted(found) + ["apps/grtx/program.h"]


def included(text):
    return re.findall(r'#include "grtx/([^"]+\.h)"', text)


def reached(headers):
    seen, todo = set(), list(headers)
    while todo:
        header = todo.pop()
        if header not in seen and os.path.exists(os.path.join(TOP, header)):
            seen.add(header)
            todo += included(read(header))
    return sorted(seen - set(headers))


def shown(text):
    """Names of what a header shows: all but comments, texts and private parts of classes."""
    private, lines = False, []
    for line in re.sub(r'//[^\n]*|/\*.*?\*/|"(?:[^"\\\n]|\\.)*"', "", text, flags=re.S).splitlines():
        access = re.match(r" +(public|protected|private):", line)
        private = access.group(1) == "private" if access else private and not line.startswith("}")
        lines += [] if private else [line]
        private = private or (line.startswith("class ") and line.endswith("{"))
    return set(re.findall(r"\w+", "\n".join(lines)))


def shown_internals(headers):
    """(public header, type that it shows, internal header that declares it)"""
    internal = {name: header for header in reached(headers) for name in TYPE.findall(read(header))}
    for header in headers:
        text = read(header)
        for name in sorted(shown(text) & set(internal) - set(TYPE.findall(text))):
            yield header, name, internal[name]


def description(text):
    """The comment that begins a header, without the line of the licence."""
    lines = re.match(r"(?://[^\n]*\n)*", text).group(0).splitlines()
    return " ".join(line.lstrip("/ ") for line in lines if "SPDX" not in line)


def faults():
    headers = public()
    for header in dict.fromkeys(headers):
        if not os.path.exists(os.path.join(TOP, header)):
            yield f"{LIST}: {header} does not exist"
        elif not description(read(header)):
            yield f"{header}:1: is public and does not say what it is"
        if headers.count(header) > 1:
            yield f"{LIST}: {header} stands there twice"
    for header, name, where in shown_internals([header for header in headers if os.path.exists(os.path.join(TOP, header))]):
        yield f"{header}: shows {name} of {where}, which is not public ({LIST})"
    for pattern in USERS:
        for path in sorted(glob.glob(os.path.join(TOP, pattern))):
            if os.path.isfile(path) and path.endswith((".cpp", ".h", ".md")):
                name = os.path.relpath(path, TOP)
                for header in sorted(set(included(read(name))) - set(headers)):
                    yield f"{name}: includes {header}, which is not public ({LIST})"
    if (installed := len(set(headers)) + len(reached(headers))) > MOST:
        yield f"{LIST}: with what they include {installed} headers are installed, more than {MOST}"


def main(arguments):
    if arguments == ["--list"]:
        print("\n".join(public()))
    elif arguments == ["--reached"]:
        print("\n".join(reached(public())))
    elif arguments == ["--check"]:
        found = list(faults())
        print("\n".join(found), end="\n" if found else "")
        return 1 if found else 0
    elif arguments:
        sys.exit(__doc__.strip())
    else:
        headers = public()
        print(f"{len(headers)} public, {len(reached(headers))} that they include, {len(all_headers())} in all")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
