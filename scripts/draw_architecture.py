#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Draws docs/images/architecture.svg from the rows of docs/architecture.md: a box for each row, with its name and the file
to open first, which the box is a link to. PLACES says where a row's box stands, and a row that it does not name takes a
spare place; a place without a row is a fault, so the picture has what the page has.

Usage: draw_architecture.py [--check]
--check: writes nothing; exit code 1 and one line a fault: a row without room, a place, or a picture that is out of date.
"""
import os
import re
import sys
from xml.sax.saxutils import escape

DOCS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "docs")
PAGE, PICTURE = os.path.join(DOCS, "architecture.md"), os.path.join(DOCS, "images", "architecture.svg")
WIDTH, HEIGHT = 1240, 1918
NAME, FILE = 8.1, 6.7  # width of a letter
STYLE = """
    .paper { fill: #ffffff }
    .area  { fill: #f3f5f8; stroke: #c3cad5 }
    .part  { fill: #e6ebf2; stroke: #aab4c3 }
    .box   { fill: #ffffff; stroke: #56657a }
    .unit  { fill: #eaf3ff; stroke: #2f6db5 }
    .mem   { fill: #eaf7ee; stroke: #2c8450 }
    .tlm   { fill: #fff3dd; stroke: #b3750c }
    .off   { stroke-dasharray: 5 3 }
    .name  { fill: #17202c; font-size: 14px; font-weight: 600 }
    .file  { fill: #45536a; font-size: 11px; font-family: ui-monospace, 'DejaVu Sans Mono', monospace }
    .head  { fill: #17202c; font-size: 15px; font-weight: 700 }
    .label { fill: #45536a; font-size: 12px }
    .wire  { stroke: #56657a; stroke-width: 1.5; fill: none; marker-end: url(#tip) }
    .both  { stroke: #56657a; stroke-width: 1.5; fill: none; marker-end: url(#tip); marker-start: url(#tip) }
    .tip   { fill: #56657a }
    a:hover rect, a:focus rect { stroke-width: 3 }
    @media (prefers-color-scheme: dark) {
      .paper { fill: #12171e }
      .area  { fill: #1a212b; stroke: #3a4658 }
      .part  { fill: #222c39; stroke: #49586d }
      .box   { fill: #151b23; stroke: #8fa0b8 }
      .unit  { fill: #14283f; stroke: #6fa8e8 }
      .mem   { fill: #132c1f; stroke: #63bd86 }
      .tlm   { fill: #33270f; stroke: #e0a945 }
      .name, .head { fill: #eef2f7 }
      .file, .label { fill: #b6c2d2 }
      .wire, .both { stroke: #8fa0b8 }
      .tip   { fill: #8fa0b8 }
    }
"""


def column(x, width, top, names, kind="box", step=70, height=54):
    return {name: (x, top + step * row, width, height, kind) for row, name in enumerate(names)}


def row(x, width, top, names, kind="box", gap=14, height=54):
    return {name: (x + (width + gap) * place, top, width, height, kind) for place, name in enumerate(names)}


# x, y, width, height, kind of each row's box. Areas come first: their boxes lie on them.
AREAS = {
    "GPU": (20, 706, 1200, 860, "area"), "SM": (40, 840, 1160, 590, "part"),
    "SIMT core": (58, 890, 250, 386, "area"), "RT unit": (382, 890, 800, 386, "area"),
}
PLACES = {
    **column(36, 222, 74, ["Scene", "Camera", "Generated scene"]),
    **column(274, 222, 74, ["Structure", "Hit function", "fp64 reference"]),
    **column(512, 222, 74, ["Rays and rounds", "Image"]),
    **column(786, 202, 74, ["Trace: read, write", "Coding of a group"]),
    **column(1002, 202, 74, ["Events, header", "Orders of children and checkpoints"]),
    **column(36, 222, 354, ["Configuration", "Regression"]),
    **column(274, 222, 354, ["Replay", "Windows"]),
    **column(512, 222, 354, ["Statistics", "Conservation", "Waveforms, stalls"]),
    **column(786, 202, 354, ["Cost", "Sweep", "Search"]),
    **column(1002, 202, 354, ["Report", "Correlation"]),
    **row(786, 202, 622, ["Both halves", "Commands"]),
    **AREAS,
    "Work distributor": (58, 752, 250, 54, "unit"),
    **column(72, 222, 946, ["Shader program", "Issue slots"], "unit", step=84),
    "Load-store unit": (72, 1204, 222, 54, "unit"),
    **row(396, 182, 946, ["RT scheduler", "Warp selection", "Warp walk scheduler", "Warp buffer"], "unit"),
    **row(396, 182, 1032, ["Any-hit collector", "Any-hit unit", "Checkpoint unit", "Stack unit"], "unit"),
    "Ray-box, -triangle, -sphere, -Gaussian, -transform unit": (396, 1118, 378, 54, "unit"),
    **row(788, 182, 1118, ["Shared decisions", "RTL in the loop"], "unit"),
    **row(396, 182, 1204, ["Memory scheduler", "Node dispatch", "Sibling prefetcher", "Delayed hits"], "unit"),
    "L1 data cache": (396, 1336, 378, 54, "mem"), "Cache replacement": (788, 1336, 378, 54, "mem"),
    "Crossbar": (58, 1490, 340, 54, "mem"), "L2 slice": (450, 1490, 340, 54, "mem"),
    "TLM-2.0 AT socket": (842, 1490, 340, 54, "tlm"),
    **row(58, 204, 1636, ["DRAM simulators", "Memory system", "Built-in DRAM", "DRAM channel", "DRAM scheduling"], "mem", gap=26),
    **row(58, 204, 1708, ["GPU as a component", "Protocol checker", "Bridges"], "tlm", gap=26),
    **row(36, 158, 1832, ["Clock of a domain", "Clocked unit", "Link", "Messages", "Addresses", "Inventory", "Base"], gap=10),
}
# Where a row stands that PLACES does not name, so that a unit more is a row of the page alone.
SPARE = {"## Data flow": [(x, 494, 222, 54, "box") for x in (36, 274)],
         "## The GPU": [(396 + 196 * place, 752, 182, 54, "unit") for place in range(4)]}
SHORT = {"Orders of children and checkpoints": "Orders of visits",
         "Ray-box, -triangle, -sphere, -Gaussian, -transform unit": "Ray-box, -triangle, … -transform unit"}
OFF = {"Warp walk scheduler", "Any-hit unit", "Delayed hits", "RTL in the loop", "DRAM simulators", "GPU as a component"}  # no part of the default machine
BANDS = [  # areas that are no row: x, y, width, height, name, folder
    (20, 30, 730, 256, "Functional tracer", "frontend/"), (770, 30, 450, 256, "Contract of the halves", "traces/"),
    (20, 310, 730, 256, "Simulation", "rtl_tlm/"), (770, 310, 450, 256, "Results", "explore/  report/"),
    (770, 580, 450, 110, "Program", "experiment/  apps/"),
    (20, 1592, 1200, 184, "Outside of the GPU", "modules/dram/  modules/tlm/  rtl_tlm/"),
    (20, 1794, 1200, 104, "Below all units", "base/  modules/kernel/  modules/messages/"),
]
WIRES = [
    "M258 101 H274", "M496 101 H512", "M734 101 H786", "M988 101 H1002", "M258 381 H274", "M496 381 H512", "M734 381 H786",
    "M988 381 H1002", "M995 286 V298 H385 V354", "M40 566 V706", "M995 566 V580", "M120 806 V840", "M240 840 V806",
    "M183 1000 V1030", "M183 1084 V1204",
]
BOTH = [
    "M308 1083 H382", "M183 1258 V1306 H440 V1336", "M487 1258 V1336", "M585 1390 V1456 H228 V1490", "M398 1517 H450",
    "M790 1517 H842", "M1012 1544 V1579 H486 V1636", "M262 1663 H288", "M492 1663 H518", "M722 1663 H748",
    "M952 1663 H978",
]
LABELS = [
    (802, 234, "a ray's events, independent of timing:", "start"), (802, 251, "one file serves every machine", "start"),
    (60, 596, "Data flows from left to right; a trace is all that the simulation takes from the tracer.", "start"),
    (60, 616, "Each box is a link to the file to open first. Dashed: not in the default machine.", "start"),
    (112, 828, "LaunchWarp", "end"), (248, 828, "WarpEnded", "start"),
    (345, 1071, "calls,", "middle"), (345, 1103, "hits", "middle"),
    (400, 937, "which warp, which entry of its stack", "start"), (400, 1023, "hits, checkpoints, what spills", "start"),
    (400, 1109, "one class, five pipelines", "start"), (400, 1195, "fetches out, nodes in", "start"), (988, 1195, "in the collector's place", "start"),
    (192, 1300, "records, buffers", "start"), (495, 1300, "nodes", "start"),
    (595, 1420, "misses and writes of each SM", "start"), (1022, 1560, "a socket a slice", "start"),
    (758, 1740, "for platforms of others", "start"),
]


class Fault(Exception):
    pass


def rows():
    """Of the page's two tables of boxes: first file of each row, the names of each table, and the files of all links."""
    with open(PAGE, encoding="utf-8") as file:
        text = file.read()
    boxes, tables, links = {}, {}, set()
    for part in ("## Data flow", "## The GPU"):
        table = text[text.index(part):][len(part):].split("\n## ")[0]
        for line in re.findall(r"^\| (?!box|-)(.*)$", table.split("\n\nA unit's")[0], flags=re.M):
            cells = line.split(" | ")
            files = [os.path.normpath(os.path.join("docs", f)) for f in re.findall(r"\]\(([^)#]+)\)", cells[1])]
            boxes[cells[0].strip()] = files[0]
            tables.setdefault(part, []).append(cells[0].strip())
            links.update(files)
    return boxes, tables, links


def places_of(boxes, tables):
    """Where each row's box stands: its own place, else the next spare one of its table."""
    faults = [f"{name}: a place in the picture without a row in docs/architecture.md" for name in PLACES if name not in boxes]
    places = dict(PLACES)
    for part, names in tables.items():
        unplaced = [name for name in names if name not in PLACES]
        places.update(zip(unplaced, SPARE[part]))
        faults += [f"{name}: a row of docs/architecture.md for which the picture has no spare place left: give it one in PLACES"
                   for name in unplaced[len(SPARE[part]):]]
    if faults:
        raise Fault("\n".join(faults))
    return places


def fitting(path, width):
    """As much of the path's end as fits, cut between folders."""
    parts = path.split("/")
    while len(parts) > 1 and len("/".join(parts)) * FILE > width:
        parts = parts[1:]
    return "/".join(parts)


def box(name, file, place):
    x, y, width, height, kind = place
    shown = SHORT.get(name, name)
    off = " off" if name in OFF else ""
    lines = [f'<a href="../../{file}"><rect class="{kind}{off}" x="{x}" y="{y}" width="{width}" height="{height}" rx="6"/>']
    if name in AREAS:
        at = x + 12 + len(shown) * 8.8 + 14
        file_shown = fitting(file, x + width - at - 8)
        lines += [f'<text class="head" x="{x + 12}" y="{y + 24}">{escape(shown)}</text>',
                  f'<text class="file" x="{at:g}" y="{y + 24}">{file_shown}</text></a>']
    else:
        if len(shown) * NAME > width - 8 or len(fitting(file, width - 8)) * FILE > width - 4:
            raise Fault(f"{name}: does not fit into {width}")
        middle = x + width / 2
        lines += [f'<text class="name" x="{middle:g}" y="{y + 23}" text-anchor="middle">{escape(shown)}</text>',
                  f'<text class="file" x="{middle:g}" y="{y + 41}" text-anchor="middle">{fitting(file, width - 8)}</text></a>']
    return "".join(lines)


def drawn():
    boxes, tables, links = rows()
    places = places_of(boxes, tables)
    parts = [f'<rect class="paper" width="{WIDTH}" height="{HEIGHT}"/>']
    for x, y, width, height, name, folder in BANDS:
        parts += [f'<rect class="area" x="{x}" y="{y}" width="{width}" height="{height}" rx="8"/>',
                  f'<text class="head" x="{x + 16}" y="{y + 25}">{name}</text>',
                  f'<text class="file" x="{x + 16 + len(name) * 8.8 + 14:g}" y="{y + 25}">{folder}</text>']
    parts += [box(name, boxes[name], PLACES[name]) for name in AREAS]
    parts += [f'<path class="wire" d="{d}"/>' for d in WIRES] + [f'<path class="both" d="{d}"/>' for d in BOTH]
    parts += [box(name, boxes[name], place) for name, place in places.items() if name not in AREAS]
    parts += [f'<text class="label" x="{x}" y="{y}" text-anchor="{anchor}">{escape(text)}</text>'
              for x, y, text, anchor in LABELS]
    svg = "\n".join(parts)
    for link in re.findall(r'href="\.\./\.\./([^"]+)"', svg):
        if link not in links:
            raise Fault(f"{link}: a link of the picture that no row has")
    return (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" height="{HEIGHT}" '
            "font-family=\"system-ui, 'DejaVu Sans', sans-serif\" role=\"img\" aria-labelledby=\"title desc\">\n"
            '<title id="title">Architecture of GRTX-TLM</title>\n<desc id="desc">Data flow from a scene to a report, and the '
            "block diagram of the GPU model. Each box is a link to the file to open first.</desc>\n"
            f"<style>{STYLE}</style>\n"
            '<defs><marker id="tip" viewBox="0 0 10 10" refX="9" refY="5" markerWidth="7" markerHeight="7" '
            'orient="auto-start-reverse"><path class="tip" d="M0 0 L10 5 L0 10 z"/></marker></defs>\n' + svg + "\n</svg>\n")


def main():
    if sys.argv[1:] not in ([], ["--check"]):
        sys.exit(__doc__.strip())
    try:
        svg = drawn()
    except Fault as fault:
        print(fault)
        return 1
    with open(PICTURE, encoding="utf-8") as file:
        current = file.read() == svg
    if not current and sys.argv[1:]:
        print("docs/images/architecture.svg: out of date: run scripts/draw_architecture.py")
        return 1
    if not current:
        with open(PICTURE, "w", encoding="utf-8") as file:
            file.write(svg)
    return 0


if __name__ == "__main__":
    sys.exit(main())
