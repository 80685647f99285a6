#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the tables of README.md and docs/results/README.md from recorded data, and the headers of folders into their
READMEs: readme_tables.py [--check].

Between `<!-- generated: scripts/readme_tables.py NAME -->` and `<!-- end of generated -->` stands what NAME makes of
docs/results/data, of docs/results/rivals.md or of the headers below the page. A table whose data are of an older model says `measured with version N` (model_version.py).
"""
import csv
import decimal
import itertools
import math
import os
import re
import sys

import model_version

PART = re.compile(r"(<!-- generated: scripts/readme_tables\.py (\S+) -->\n)(.*?)(<!-- end of generated -->\n)", re.S)
DESIGNS = ("sw", "hw", "grtx")
PAPER = (2.00, 1.94, 4.36, 4.75, 1.77, 3.03)
RATIOS = ("sw", "hw", "grtx", "L2 accesses", "latency", "node fetches")
GENERATED = re.compile(r"-\d+-\d+$")  # scenes of grtx synth
OBJECTS = {"playbot", "pizza", "logo", "st-peter"}


def data(top, name):
    with open(os.path.join(top, "docs", "results", "data", name), encoding="utf-8") as file:
        return list(csv.DictReader(file))


def table(head, rows):
    return "".join("| " + " | ".join(row) + " |\n" for row in [head, ["---"] * len(head), *rows]).replace(" --- ", "---")


def said(top, of):
    return "" if of == model_version.current(top) else f"\n(Measured with version {of} of the model.)\n"


def headline(top, _page):
    """Geometric means over the public whole scenes of docs/results/readings.md."""
    rows = [row for row in data(top, "readings.csv") if not GENERATED.search(row["scene"]) and row["scene"] not in OBJECTS]
    lines = [["the paper's text (mean of its six scenes)"] + [f"{value:.2f}" for value in PAPER]]
    for label, traffic in (("`paper`: checkpoint traffic costs nothing", "uncharged"), ("`paper-charged`: every byte of it is charged", "charged")):
        of = [row for row in rows if row["reading"] == f"`rt.checkpoint.traffic` = {traffic}"]
        lines.append([label] + [f"{math.exp(sum(math.log(float(row[name])) for row in of) / len(of)):.2f}" for name in RATIOS])
    version = model_version.version_of(model_version.read(top, "docs/results/readings.md"), model_version.current(top))
    return table(["machine", *DESIGNS, "L2 accesses ÷", "node latency ÷", "node fetches ÷"], lines) + said(top, version)


WINNERS = "docs/results/rivals.md"
CONTENDERS = (("baseline", "baseline: a tree of triangles, rounds from its root"),
              ("grtx", "GRTX: shared tree, checkpoints"),
              ("grtx, what costs little", "GRTX with what costs little: wide port, leaves of 64 B"),
              ("list of all hits, spheres", "list of all hits, by shaders alone (as GRay)"),
              ("gautracer", "GauTracer: units for Gaussians in place of shaders"),
              ("gautracer, by entry", "GauTracer, hits sorted by entry, not by peak"),
              ("gautracer, by entry, checkpoints", "GauTracer, sorted by entry, with GRTX's checkpoints"))


def markdown_tables(text):
    """Each table as a list of rows, the first its head, cells without bold."""
    found = re.findall(r"(?:^\|.*\n)+", text, re.M)
    return [[[cell.strip().strip("*") for cell in line.strip("|\n").split("|")] for line in table.splitlines() if not line.startswith("|---")]
            for table in found]


def one_digit(text):
    """As a reader rounds what is printed: 1.45 is 1.5."""
    return str(decimal.Decimal(text).quantize(decimal.Decimal("0.1"), decimal.ROUND_HALF_UP))


def winners(top, _page):
    """The designs of docs/results/rivals.md beside each other, the fastest in rooms in bold."""
    text = model_version.read(top, WINNERS)
    tables = markdown_tables(text)
    first = next(table for table in tables if table[0][0] == "design")
    main = [dict(zip(first[0], row)) for row in first[1:]]
    dense = next(table for table in tables if table[0][0].startswith("speed over the baseline"))
    rows = []
    for name, label in CONTENDERS:
        row = max((row for row in main if row["design"] == name), key=lambda row: float(row["rooms"]))
        column = dense[0].index(name) if name in dense[0] else None
        values = sorted((line[column] for line in dense[1:]), key=float) if column else []
        span = " to ".join(one_digit(value) for value in (values[0], values[-1])) if column else "1.0"
        rows.append([label, one_digit(row["rooms"]), one_digit(row["objects"]), span, row["RT unit, mm²"], row["energy of a ray"]])
    best = max(range(len(rows)), key=lambda number: float(rows[number][1]))
    rows[best] = [f"**{cell}**" for cell in [rows[best][0] + ": the fastest of these", *rows[best][1:]]]
    version = model_version.version_of(text, model_version.current(top))
    return table(["design", "rooms", "objects", "five times as dense", "RT unit, mm²", "energy"], rows) + said(top, version)


def versions(top, _page):
    """What changed with each version of the model: docs/results/README.md."""
    return table(["version", "since", "what changed"],
                 [[row["version"], row["date"], row["what changed"]] for row in reversed(model_version.versions(top))])


def headers(top, page):
    """Headers below the page's folder that it does not name itself, and that are no nearer to another README."""
    folder = os.path.join(top, os.path.dirname(page))
    named = PART.sub("", model_version.read(top, page))
    rows = []
    for here, below, files in os.walk(folder):
        below[:] = sorted(name for name in below if not os.path.exists(os.path.join(here, name, "README.md")))
        for name in sorted(name for name in files if name.endswith(".h")):
            path = os.path.relpath(os.path.join(here, name), folder)
            if f"({path})" not in named:
                rows.append([f"[{path}]({path})", first_sentence(model_version.read(top, os.path.join(here, name)))])
    return table(["header", "holds"], rows)


def first_sentence(text):
    below_licence = text.split("\n", 1)[1] if text.startswith("// SPDX") else text
    lines = itertools.takewhile(lambda line: line.startswith("//"), below_licence.splitlines())
    said = re.split(r"(?<=[a-z)\d])[.:](?: |$)", " ".join(line[2:].strip() for line in lines))[0]
    return said.replace("|", "\\|")


MADE = {"headline": headline, "winners": winners, "versions": versions, "headers": headers}
FOLDERS = ("apps", "base", "frontend", "lab", "rtl_tlm", "rtl_tlm/rtl", "study", "traces", "view",
           *(f"modules/{name}" for name in ("cache", "dram", "kernel", "messages", "noc", "rt_unit", "simt", "tlm")))
PAGES = ("README.md", "docs/results/README.md", *(f"{folder}/README.md" for folder in FOLDERS))


def renewed(top, page):
    return PART.sub(lambda part: part.group(1) + "\n" + MADE[part.group(2)](top, page) + "\n" + part.group(4), model_version.read(top, page))


def renew(top):
    for page in PAGES:
        if os.path.exists(os.path.join(top, page)):
            model_version.write(top, page, renewed(top, page))


def faults(top):
    for page in PAGES:
        if os.path.exists(os.path.join(top, page)) and PART.search(text := model_version.read(top, page)):
            fresh = renewed(top, page)
            for line, (now, then) in enumerate(zip(text.splitlines(), fresh.splitlines()), 1):
                if now != then:
                    yield f"{page}:{line}: is not what scripts/readme_tables.py makes of docs/results/data or of headers: {then}"
                    break
            else:
                if text != fresh:
                    yield f"{page}:1: is not what scripts/readme_tables.py makes of docs/results/data or of headers"


def main():
    if sys.argv[1:] == ["--check"]:
        found = list(faults(model_version.TOP))
        print("\n".join(found))
        return 1 if found else 0
    if len(sys.argv) > 1:
        sys.exit(__doc__.strip())
    renew(model_version.TOP)
    return 0


if __name__ == "__main__":
    sys.exit(main())
