# SPDX-License-Identifier: Apache-2.0
"""Tables of docs/results/rtl.md from rtl.csv in docs/results/data, and the sentences of that page that compare them; readme_tables.py puts
the tables into the page, and checks both."""
import os

import page_data
from evaluation_tables import shown, table

PAGE = os.path.join("docs", "results", "rtl.md")
DATA = "rtl.csv"
MACHINE_MHZ, BOX_CYCLES, TRANSFORM_CYCLES = 1365, 13, 6  # gpu.core_mhz, rt.box.latency, rt.transform.latency


def number(cell):
    return f"{int(cell):,}" if cell else ""


def ratio(row):
    return float(row["rtl"]) / float(row["model"])


def checkpoint(rows):
    return table(["lanes", "RTL, GE", "model, GE", "ratio", "longest path at 180 nm, ns"],
                 [[row["unit"], number(row["rtl"]), number(row["model"]), shown(ratio(row)), row["path_ns"]] for row in rows if row["part"] == "checkpoint"])


def intersection(rows):
    return table(["", "RTL, GE", "model, GE", "ratio", "low to high", "longest path at 180 nm, ns"],
                 [[row["unit"], number(row["rtl"]), number(row["model"]), shown(ratio(row)), f"{number(row['low'])} to {number(row['high'])}", row["path_ns"]]
                  for row in rows if row["part"] in ("intersection", "operator")]).replace("|  |", "| |", 1)


def closes(row):
    """Whether a unit reaches the machine's clock."""
    if float(row["mhz_low"]) >= MACHINE_MHZ:
        return "yes"
    return "at the best end" if float(row["mhz_high"]) >= MACHINE_MHZ else "no"


def clock(rows):
    return table(["unit", "180 nm, ns", "12 nm, MHz", "closes"],
                 [[row["unit"], row["path_ns"], f"{number(row['mhz_low'])} to {number(row['mhz_high'])}" if row["mhz_high"] else f"{number(row['mhz_low'])} and more",
                   closes(row)] for row in rows if row["part"] == "clock"]).replace("|  |", "| |")


def deeper(rows):
    """Cycles with deeper units, and how many more than with those of the machine."""
    at = {}
    for row in rows:
        if row["part"] == "deeper":
            at.setdefault(row["unit"], {})[row["note"]] = int(row["cycles"])
    depths = list(next(iter(at.values())))
    return table(["cycles", f"latencies {depths[0]}", *depths[1:]],
                 [[unit, f"{found[depths[0]]:,}", *(f"{found[depth]:,} ({100 * (found[depth] / found[depths[0]] - 1):+.1f} %)" for depth in depths[1:])]
                  for unit, found in at.items()])


def sentences(rows):
    ratios = [ratio(row) for row in rows if row["part"] in ("checkpoint", "intersection")]
    worst = {row["unit"]: ratio(row) for row in rows if row["part"] == "operator"}
    yield (f"They have {min(ratios):.2f} to {max(ratios):.2f} of the cost model's gates; the worst operator, an adder, "
           f"has {min(worst.values()):.2f}.")
    depth = lambda unit, end: min(int(row["cycles"]) for row in rows if row["part"] == "clock" and row["unit"].startswith(unit) and row["cycles"]
                                  and closes(row) in (("yes", "at the best end") if end == "best" else ("yes",)))
    words = {2: "two", 3: "three"}
    short = depth("ray box", "best") - BOX_CYCLES
    yield (f"So {BOX_CYCLES} cycles for a box (`rt.box.latency`) are {words.get(short, short)} short of what this RTL needs at the best end, "
           f"{depth('ray box', 'worst') - BOX_CYCLES} at the worst.")
    yield f"six of a transform are {depth('ray transform', 'best') - TRANSFORM_CYCLES} short at the best."
    count = {row["unit"]: number(row["rtl"]) for row in rows if row["part"] == "agreement"}
    yield f"{count['traces a unit']} random traces for each unit"
    yield f"{count['entries written']} entries written and {count['entries read']} read"
    for unit in ("ray-box", "ray-transform"):
        yield f"the {unit} unit | {count[f'{unit} operations']} operations"


def faults(top):
    if rows := page_data.rows(top, DATA):
        yield from page_data.unsaid(top, PAGE, DATA, sentences(rows))


def made(function):
    return lambda top, _page: function(rows) if (rows := page_data.rows(top, DATA)) else None


MADE = {"rtl-checkpoint": made(checkpoint), "rtl-intersection": made(intersection), "rtl-clock": made(clock), "rtl-deeper": made(deeper)}
