#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Holds the arrows between the folders: who may include whom.

* Between top-level folders: frontend -> traces <- modules <- rtl_tlm <- explore <- report <- experiment <- apps; experiment and
  apps alone also see frontend; base lies below all.
* Between all folders inside them: no circles. A unit's decide/ is a part of the unit. The codec implements interfaces of
  traces, so the headers of traces count as one folder and its sources as another, above the codec.
* What units decide without time (decide/) reaches no header of SystemC.
* What is inside a folder alone (traces/codec) is included by that folder alone.
* The README of modules, rtl_tlm and frontend says of each folder which of its neighbours it includes: exactly those.
* NAME_config.h declares NameConfig; NAME_if.h declares name_if, name_in_if or the base class NameModule. A unit's counters
  stand in its NAME_config.h, or in NAME_counters.h if it has no keys, and share its name.
* Every include of the project's own is written from the top ("grtx/modules/kernel/link.h") and leads to a file.

Usage: check_arrows.py [--graph] [FOLDER]   (default: the folder above this script; --graph prints who includes whom)
Exit code 1 and the includes at fault, one a line: file, line, rule.
"""
import os
import re
import sys

BELOW = {
    "base": [],
    "traces": ["base"],
    "frontend": ["base", "traces"],
    "modules": ["base", "traces"],
    "rtl_tlm": ["base", "traces", "modules"],
    "explore": ["base", "traces", "modules", "rtl_tlm"],
    "report": ["base", "traces", "modules", "rtl_tlm", "explore"],
    "experiment": ["base", "traces", "modules", "rtl_tlm", "explore", "report", "frontend"],
    "apps": ["base", "traces", "modules", "rtl_tlm", "explore", "report", "frontend", "experiment"],
}
# Folders whose headers are interfaces that the folders inside them see, and whose sources use those folders.
SOURCES_STAND_ABOVE = {"traces"}
# What all parts of the RT unit share lies below them, and the netlist above.
SHARED_DECISIONS = "modules/rt_unit/decide"
# Folders that nobody sees but the folder around them.
INSIDE_ALONE = {"traces/codec": "traces"}
# Arrows that close a circle today, with the reason. It is to stay empty.
ALLOWED = {}

INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*"([^"]+)"', re.M)
SYSTEMC = re.compile(r"^[ \t]*#[ \t]*include[ \t]*<((?:systemc|tlm)[^>]*)>", re.M)


def part_of(file):
    """The folder whose arrows a file's includes are."""
    folder, name = os.path.split(file)
    if folder != SHARED_DECISIONS:
        folder = re.sub(r"/decide(/.*)?$", "", folder)
    return folder + "/*.cpp" if folder in SOURCES_STAND_ABOVE and name.endswith(".cpp") else folder


def sources(top):
    for start in BELOW:
        for folder, names, files in os.walk(os.path.join(top, start)):
            names.sort()
            for name in sorted(files):
                if name.endswith((".h", ".cpp", ".cpp.in")):
                    yield os.path.relpath(os.path.join(folder, name), top).replace(os.sep, "/")


def read_includes(top, faults):
    """(from part, to part) -> the places that make the arrow; appends to faults what breaks a rule by itself."""
    arrows = {}
    for file in sources(top):
        with open(os.path.join(top, file), encoding="utf-8") as stream:
            text = stream.read()
        for found in INCLUDE.finditer(text):
            place = f"{file}:{text.count(chr(10), 0, found.start(1)) + 1}"
            path = found.group(1)
            if not path.startswith("grtx/"):
                faults.append(f"{place}: includes {path}, which is not written from the top (grtx/...)")
                continue
            path = path[len("grtx/"):]
            if not os.path.isfile(os.path.join(top, path)):
                faults.append(f"{place}: includes {path}, which does not exist")
                continue
            above, below = file.split("/")[0], path.split("/")[0]
            if above != below and below not in BELOW[above]:
                faults.append(f"{place}: includes {path}, but {above} stands not above {below}")
                continue
            owner = INSIDE_ALONE.get(os.path.dirname(path), above)
            if owner != above:
                faults.append(f"{place}: includes {path}, but {os.path.dirname(path)} is seen by {owner} alone")
                continue
            if part_of(file) != part_of(path):
                arrows.setdefault((part_of(file), part_of(path)), []).append(f"{place}: includes {path}")
    return arrows


def systemc_faults(top):
    """Each file in a decide/ that includes SystemC, by itself or through others, with the way there."""
    direct, below = {}, {}
    for file in sources(top):
        with open(os.path.join(top, file), encoding="utf-8") as stream:
            text = stream.read()
        direct[file] = SYSTEMC.findall(text)
        below[file] = [path[len("grtx/"):] for path in INCLUDE.findall(text)]
    for file in filter(re.compile("/decide/").search, below):
        ways, seen = [[file]], {file}
        for way in ways:
            if direct.get(way[-1]):
                yield f"{file}: stands in a decide/, but includes {' -> '.join(way[1:] + [direct[way[-1]][0]])}"
                break
            ways += [way + [path] for path in below.get(way[-1], []) if path not in seen]
            seen.update(below.get(way[-1], []))


def name_faults(top):
    """Headers of units that are not named after what they declare."""
    for file in sources(top):
        found = re.fullmatch(r"modules/.*?([a-z0-9_]+)_(config|if)\.h", file)
        if found:
            name, kind = found.groups()
            camel = "".join(word.capitalize() for word in name.split("_"))
            declared = f"{camel}Config" if kind == "config" else f"({name}(_in)?_if|{camel}Module)"
            with open(os.path.join(top, file), encoding="utf-8") as stream:
                if not re.search(rf"^(struct|class) {declared} [^;]*{{", stream.read(), re.M):
                    yield f"{file}: declares no {declared}, after which it would be named"


def readme_faults(top, arrows):
    """Rows of a README's column "includes" that are not what the folder includes. The column's head names what all may."""
    for start in BELOW:
        page = os.path.join(top, start, "README.md")
        if not os.path.isfile(page):
            continue
        with open(page, encoding="utf-8") as stream:
            head, *rows = re.findall(r"^\| (?:folder \|.*\| includes, beside|\[\w+/\]).*$", stream.read(), re.M) or [""]
        if "includes, beside" not in head:
            continue
        for_all = set(re.findall(r"`(\w+)`", head.split("|")[-2]))
        told = {re.match(r"\| \[(\w+)/\]", row).group(1): set(re.findall(r"`(\w+)`", row.split("|")[-2])) for row in rows}
        found = {folder: set() for folder in told}
        for above, below in arrows:
            if above.startswith(start + "/"):
                steps = below.split("/")
                found.setdefault(above.split("/")[1], set()).add(steps[1] if steps[0] == start else steps[0])
        for folder in sorted(told):
            for name in sorted(found[folder] - for_all - told[folder] - {folder}):
                yield f"{start}/README.md: {folder}/ includes {name}, which its row does not say"
            for name in sorted(told[folder] - found[folder]):
                yield f"{start}/README.md: {folder}/ includes no {name}, though its row says so"
        for folder in sorted(set(found) - set(told)):
            yield f"{start}/README.md: {folder}/ has no row"


def counters_faults(top):
    """Counters with a table of their own that stand where nobody looks for them."""
    for file in sources(top):
        if not re.match(r"modules/.*\.h$", file):
            continue
        with open(os.path.join(top, file), encoding="utf-8") as stream:
            names = re.findall(r"^  static const CounterTable<(\w+)Counters>& table\(\);", stream.read(), re.M)
        header = re.search(r"([a-z0-9_]+)_(?:config|counters)\.h$", file)
        unit = "".join(word.capitalize() for word in header.group(1).split("_")) if header else ""
        for name in names:
            if not (unit and (name in unit or unit in name)):
                yield f"{file}: declares {name}Counters, which belong into NAME_config.h or NAME_counters.h of their unit"


def shortest_way(arrows, start, end):
    """Folders from start to end along the arrows; None where there is no way."""
    ways = [[start]]
    seen = {start}
    for way in ways:
        if way[-1] == end:
            return way
        for above, below in sorted(arrows):
            if above == way[-1] and below not in seen:
                seen.add(below)
                ways.append(way + [below])
    return None


def circle_faults(arrows):
    """Each circle once, with the includes of its arrows: those made by the fewest first, as the ones to mend."""
    faults = []
    told = set()
    for above, below in sorted(arrows):
        back = shortest_way(arrows, below, above)
        if back is None or frozenset(back) in told:
            continue
        told.add(frozenset(back))
        circle = [above] + back
        steps = sorted(zip(circle, circle[1:]), key=lambda step: len(arrows[step]))
        for number, step in enumerate(steps):
            for place in arrows[step] if number == 0 else arrows[step][:1]:
                faults.append(f"{place}, an arrow of the circle {' -> '.join(circle)}")
    return faults


def main(arguments):
    graph = "--graph" in arguments
    folders = [a for a in arguments if a != "--graph"]
    top = folders[0] if folders else os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")
    faults = []
    arrows = read_includes(top, faults)
    if graph:
        for part in sorted({above for above, _ in arrows}):
            print(f"{part} -> {', '.join(sorted(below for above, below in arrows if above == part))}")
    for arrow, why in ALLOWED.items():
        if arrow not in arrows and not folders:
            faults.append(f"scripts/check_arrows.py: {arrow[0]} -> {arrow[1]} ({why}) is gone: take it off the list")
    faults += circle_faults({arrow: places for arrow, places in arrows.items() if arrow not in ALLOWED})
    faults += systemc_faults(top)
    faults += name_faults(top)
    faults += counters_faults(top)
    faults += readme_faults(top, arrows)
    for fault in faults:
        print(fault)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
