# SPDX-License-Identifier: Apache-2.0
"""Tables of docs/results/designs-show.md from designs-show.csv and designs-show-memory.csv in docs/results/data, that of heap logics
in rivals.md, and what README.md says of
them; readme_tables.py puts the tables into the page, and checks both."""
import csv
import os

import model_version
from evaluation_tables import mean, shown, table

PAGE = os.path.join("docs", "results", "designs-show.md")
DATA = os.path.join("docs", "results", "data", "designs-show.csv")
MEMORY = os.path.join("docs", "results", "data", "designs-show-memory.csv")
LOGICS = os.path.join("docs", "results", "data", "heap-logics.csv")
ROOMS, OBJECTS = ("graffiti_roof", "vr_lab", "lookout"), ("le_poeme", "la_vestale")
GRTX, GAUTRACER, ENTRY = ("grtx", 16), ("gautracer", 48), ("gautracer, by entry", 64)
MIXES = [(name, k) for name in ("by entry, near", "by entry, near, checkpoints") for k in (64, 48)]
OWN = [("walk", 64), ("walk, near", 64)]
COLOUR = ("walk, a colour once in a frame", 64)
HEAPS = ", 16 heap logics"
MORE_MIXES, MORE_OWN = ([(name + HEAPS, k) for name, k in designs] for designs in (MIXES, OWN))  # with dense rays alone
ROWS = [("sw", 32), ("hw", 16), GRTX, GAUTRACER, ENTRY, *MIXES, *OWN, COLOUR]
LINKED = {COLOUR[0]: "walk, a [colour once in a frame](../model/tracer.md#colours)"}


def called(row):
    """What the page calls a design with its keys."""
    keys = row["keys"]
    heaps = HEAPS if "any_hit_unit.count=16" in keys else ""
    if row["design"] == "gautracer" and keys:
        return ("by entry, near" if "near_first" in keys else "gautracer, by entry") + (", checkpoints" if "checkpoint=on" in keys else "") + heaps
    return row["design"] + (", near" if "near_first" in keys else ", a colour once in a frame" if "colour=frame" in keys else "") + heaps


class Crops:
    """The crops of two SMs with one density of rays."""

    def __init__(self, rows, lines):
        self.at = {(called(row), int(row["k"]), row["view"].split("-")[0]): row for row in rows if row["sms"] == "2" and row["lines"] == lines}

    def speed(self, design, view, over=("baseline", 32)):
        return float(self.at[*over, view]["cycles"]) / float(self.at[*design, view]["cycles"])

    def mean(self, design, views):
        return mean(self.speed(design, view) for view in views)

    def best(self, designs, views):
        return max(designs, key=lambda design: self.mean(design, views))

    def cells(self, views, speed, bold=False):
        """Each view's, and their mean."""
        values = [speed(view) for view in views]
        return [", ".join(map(shown, values)), f"**{shown(mean(values))}**" if bold else shown(mean(values))]

    def leads(self, views):
        """Of the walk over the mix that is best for these views, by view."""
        mix = self.best(MIXES, views)
        return [self.speed(OWN[1], view, mix) for view in views]


def crops(top, lines):
    path = os.path.join(top, DATA)
    if not os.path.exists(path):
        return None
    with open(path, encoding="utf-8", newline="") as file:
        return Crops(list(csv.DictReader(file)), lines)


def speeds(top, lines):
    of = crops(top, lines)
    if not of:
        return None
    area = lines == "128"
    rows = []
    for design in ROWS + ([] if area else MORE_MIXES + MORE_OWN):
        cells = [cell for views in (ROOMS, OBJECTS) for cell in
                 of.cells(views, lambda view, design=design: of.speed(design, view), bold=design in OWN and design == of.best(OWN, views))]
        name = LINKED.get(design[0], design[0]) if area else design[0]
        rows.append([name, str(design[1]), *cells, *([shown(float(of.at[*design, ROOMS[0]]["rt_unit_mm2"]), 3)] if area else [])])
    for name, own, rivals in (("walk over by entry, both without near", OWN[0], [ENTRY]),
                              ("walk over by entry, both near, k = 64", OWN[1], MIXES[:1]),
                              ("walk over the best of by entry, near", OWN[1], MIXES),
                              *([] if area else [("the same, both with 16 heap logics", MORE_OWN[1], MORE_MIXES)])):
        cells = [cell for views in (ROOMS, OBJECTS) for cell in
                 of.cells(views, lambda view, views=views, own=own, rivals=rivals: of.speed(own, view, of.best(rivals, views)), bold=len(rivals) > 1)]
        rows.append([name, "", *cells, *([""] if area else [])])
    head = ["design", "k", ", ".join(ROOMS), "rooms", ", ".join(OBJECTS), "objects", *(["mm² of an RT unit"] if area else [])]
    return table(head, rows).replace("|  |", "| |").replace("|  |", "| |")


def faults(top):
    """Rows of README's table and its range of leads that are not those of the data."""
    both = [crops(top, lines) for lines in ("128", "1080")]
    if None in both or not os.path.exists(os.path.join(top, "README.md")):
        return
    columns = [(of, views) for of in both for views in (ROOMS, OBJECTS)]
    text = " ".join(model_version.read(top, "README.md").replace("*", "").split())
    row = lambda value, digits: " | ".join(shown(value(of, views), digits) for of, views in columns) + " |"
    expected = [row(lambda of, views, design=design: of.mean(design, views), digits) for design, digits in ((GRTX, 2), (GAUTRACER, 1), (OWN[1], 1))]
    expected.append(row(lambda of, views: of.mean(of.best(MIXES, views), views), 1))
    expected.append(row(lambda of, views: mean(of.leads(views)), 2))
    leads = [lead for of, views in columns for lead in of.leads(views)]
    expected.append(f"{min(leads):.2f} to {max(leads):.2f}")
    if (*MORE_OWN[1], "lookout") in both[1].at:
        expected.append(" and ".join(shown(mean(both[1].speed(MORE_OWN[1], view, both[1].best(MORE_MIXES, views)) for view in views))
                                     for views in (ROOMS, OBJECTS)))
    for words in expected:
        if words not in text:
            yield f"README.md:1: does not have '{words}', which {DATA} gives"


def memories(top):
    """The walk over the best mix for each class, by L2 slices and bandwidth of the DRAM."""
    path = os.path.join(top, MEMORY)
    if not os.path.exists(path):
        return None
    with open(path, encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    at = {tuple(row[name] for name in ("l2_slices", "dram_gb_s", "lines")) + (row["view"].split("-")[0], row["design"], row["k"], row["checkpoints"]):
          float(row["cycles"]) for row in rows}
    rivals = sorted({key[4:] for key in at if not key[4].startswith("walk")})

    def lead(slices, bandwidth, lines, views):
        return min(mean(at[slices, bandwidth, lines, view, *rival] / at[slices, bandwidth, lines, view, "walk, near", "64", "off"] for view in views)
                   for rival in rivals)
    machines = sorted({key[:2] for key in at}, key=lambda machine: tuple(map(int, machine)))
    return table(["L2 slices", "DRAM, GB/s", "128 lines: rooms, objects", "1,080 lines: rooms, objects"],
                 [[*machine, *(", ".join(shown(lead(*machine, lines, views)) for views in (ROOMS, OBJECTS)) for lines in ("128", "1080"))]
                  for machine in machines])


def heap_logics(top):
    """Speed with 16 and 32 heap logics over that with eight, means of the views of role choose, by density."""
    path = os.path.join(top, LOGICS)
    if not os.path.exists(path):
        return None
    with open(path, encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    at = {(row["design"], row["k"], row["lines"], row["heap_logics"], row["view"]): float(row["cycles"]) for row in rows}
    views = dict.fromkeys(row["view"] for row in rows)

    def over_eight(design, k, lines, logics):
        return shown(mean(at[design, k, lines, "8", view] / at[design, k, lines, logics, view] for view in views))
    return table(["speed over 8 heap logics", "k", "128 lines: 16", "32", "1,080 lines: 16", "32"],
                 [[design, k, *(over_eight(design, k, lines, logics) for lines in ("128", "1080") for logics in ("16", "32"))]
                  for design, k in dict.fromkeys((row["design"], row["k"]) for row in rows)])


MADE = {"heap-logics": lambda top, _page: heap_logics(top), "show-memory": lambda top, _page: memories(top), "show-128": lambda top, _page: speeds(top, "128"),
        "show-1080": lambda top, _page: speeds(top, "1080")}
