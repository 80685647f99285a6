# SPDX-License-Identifier: Apache-2.0
"""What docs/model/windows-mode.md says of windows beside cycle mode, from windows.csv and whole-frame.csv in docs/results/data;
readme_tables.py checks it."""
import os
from statistics import mean

import page_data
from show_tables import FRAME

PAGE = os.path.join("docs", "model", "windows-mode.md")
DATA = "windows.csv"
LONG = "36450"  # warps of the frames at a share of 0.07


def line(rows):
    """Cells of the page's table: number, held, error, half-width."""
    errors, held = [abs(float(row["error"])) for row in rows], sum(row["held"] == "True" for row in rows)
    return f"{len(rows)} | {held} ({100 * held / len(rows):.0f} %) | {mean(errors):.1f} %, {max(errors):.1f} % | {mean(float(row['width']) for row in rows):.1f} % |"


def sentences(rows):
    cycles, speeds = ([row for row in rows if row["what"] == what] for what in ("cycles", "speed-up"))
    long = [row for row in cycles if row["warps"] == LONG]
    for name, part in (("cycles", cycles), ("speed-ups", speeds), (f"share 0.07, {int(LONG):,} warps (cycles)", long)):
        yield f"| {name} | {line(part)}"
    yield f"{len(cycles)} of 705 runs with an interval"
    missed = [float(row["error"]) for row in cycles if row["held"] != "True"]
    yield f"All misses are too high, by {min(missed):.1f} to {max(missed):.1f} %"
    yield f"{sum(row['design'] in ('gautracer', 'walk') for row in cycles)} of the {len(cycles)} runs are of gautracer and walk"
    span = lambda *designs: "{:.1f} to {:.1f}".format(*(end(float(row["speed"]) for row in long if row["design"] in designs) for end in (min, max)))
    yield f"{span('grtx', 'sw')} for grtx and sw, {span('gautracer')} for gautracer, {span('walk')} for walk."


def of_frame(rows):
    """Of each design that was run in both modes: what windows err, and half of their interval."""
    at = {(row["design"], row["k"], row["keys"], row["mode"]): row for row in rows}
    both = [(row, at[*key[:3], "windows"]) for key, row in at.items() if key[3] == "cycle" and (*key[:3], "windows") in at]
    errors = [f"{100 * (float(windows['cycles']) / float(cycle['cycles']) - 1):.1f}".replace("-", "−") for cycle, windows in both]
    halves = [f"{100 * max(float(windows['cycles_high']) / float(windows['cycles']) - 1, 1 - float(windows['cycles_low']) / float(windows['cycles'])):.1f}"
              for _, windows in both]
    if both:
        yield f"Errors are {', '.join(errors[:-1])} and {errors[-1]} %, half-widths {', '.join(halves[:-1])} and {halves[-1]} %"


def faults(top):
    if rows := page_data.rows(top, DATA):
        yield from page_data.unsaid(top, PAGE, DATA, sentences(rows))
    if rows := page_data.rows(top, FRAME):
        yield from page_data.unsaid(top, PAGE, FRAME, of_frame(rows))
