#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the tables of README.md and of pages of results from recorded data, and the headers of folders into their READMEs:
readme_tables.py [--check].

Between `<!-- generated: scripts/readme_tables.py NAME -->` and `<!-- end of generated -->` stands what NAME makes of
docs/results/data (the modules *_tables.py) or of the headers below the page.
"""
import itertools
import os
import re
import sys

import draw_results
import evaluation_tables
import model_version
import readings_tables
import rtl_tables
import show_tables
import silicon_tables
import vulkan_tables
import windows_tables

PART = re.compile(r"(<!-- generated: scripts/readme_tables\.py (\S+) -->\n)(.*?)(<!-- end of generated -->\n)", re.S)


def versions(top, _page):
    """What changed with the last two versions of the model: docs/results/README.md, which links the file with all."""
    return evaluation_tables.table(["version", "since", "what changed"], [
        [row["version"], row["date"], row["what changed"]] for row in reversed(model_version.versions(top)[-2:])])


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
    return evaluation_tables.table(["header", "holds"], rows)


def first_sentence(text):
    below_licence = text.split("\n", 1)[1] if text.startswith("// SPDX") else text
    lines = itertools.takewhile(lambda line: line.startswith("//"), below_licence.splitlines())
    said = re.split(r"(?<=[a-z)\d])[.:](?: |$)", " ".join(line[2:].strip() for line in lines))[0]
    return said.replace("|", "\\|")


MADE = {"versions": versions, "headers": headers,
        **readings_tables.MADE, **rtl_tables.MADE, **show_tables.MADE, **silicon_tables.MADE, **vulkan_tables.MADE,
        **{name: lambda top, _page, name=name: evaluation_tables.made(top, name) for name in evaluation_tables.MADE}}
FOLDERS = ("apps", "base", "experiment", "explore", "frontend", "report", "rtl_tlm", "rtl_tlm/rtl", "traces",
           *(f"modules/{name}" for name in ("cache", "dram", "kernel", "messages", "noc", "rt_unit", "simt", "tlm")))
PAGES = ("README.md", *(f"docs/results/{name}.md" for name in ("README", "rivals", "scene-classes", "bounds", "checkpoints", "designs-show", "silicon", "vulkan-sim", "rtl", "readings")),
         *(f"{folder}/README.md" for folder in FOLDERS))


def renewed(top, page):
    """What is not measured yet stays as it is."""
    def fresh(part):
        made = MADE[part.group(2)](top, page)
        return part.group(0) if made is None else part.group(1) + "\n" + made + "\n" + part.group(4)

    return PART.sub(fresh, model_version.read(top, page))


def renew(top):
    for page in PAGES:
        if os.path.exists(os.path.join(top, page)):
            model_version.write(top, page, renewed(top, page))
    draw_results.renew(top)


def faults(top):
    yield from draw_results.faults(top)
    yield from show_tables.faults(top)
    yield from rtl_tables.faults(top)
    yield from silicon_tables.faults(top)
    yield from vulkan_tables.faults(top)
    yield from windows_tables.faults(top)
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
