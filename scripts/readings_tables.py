# SPDX-License-Identifier: Apache-2.0
"""Tables of docs/results/readings.md from fit.csv and fit_public.csv in docs/results/data: what each freedom of machine `paper` does to the
ten figures of the main frame; readme_tables.py puts them into the page, and checks them."""
import functools

import page_data
from evaluation_tables import mean, paper_figures, shown, table

NAMES = {"sw": "Speed-up, GRTX-SW", "hw": "Speed-up, GRTX-HW", "grtx": "Speed-up, GRTX", "node fetches": "Fewer node fetches, GRTX",
         "fetches on sw": "Fewer node fetches, GRTX against GRTX-SW", "latency": "Shorter node fetch latency, GRTX",
         "L2 accesses": "Fewer L2 accesses, GRTX", "L1 hits, sw": "L1 hit rate of node fetches, GRTX-SW"}  # of report/page/paper_targets.toml
FIGURES = ("sw", "hw", "grtx", "grtx over the better", *list(NAMES)[3:], "L1 hits, grtx on sw")
AT_LEAST = "L1 hits, sw"  # of the ratio of L1 hits the paper says the least
SEARCHED, LEFT_OUT = ("hall", "building", "taebak-1"), ("room", "lacadiere-2")  # of fit.csv
PUBLIC = ("headquarter_garden-0", "taebak-1"), ("lacadiere-2", "wang_sha-1", "hon_sui_sen-1")  # of fit_public.csv: searched, left out
STEPS = {"queue": "nothing: `paper`", "queue header": "no header", "queue write-back": "written back", "queue warps": "16 resident warps",
         "queue misses": "misses", "queue leaf": "leaves of 64 B"}


@functools.cache
def paper():
    """What the paper has of each figure."""
    found = dict.fromkeys(FIGURES, 1.0) | dict(zip(NAMES, paper_figures(NAMES.values())))  # the last: as many hits on both
    return found | {"grtx over the better": found["grtx"] / found["sw"]}


def within(figure, value):
    """Within 20 % of the paper."""
    return value >= paper()[figure] if figure == AT_LEAST else abs(value / paper()[figure] - 1) <= 0.2


def means(rows, machine, views):
    """Of each figure, over views."""
    at = {(row["machine"], row["view"], row["figure"]): float(row["value"]) for row in rows}
    return {figure: mean(at[machine, view, figure] for view in views) for figure in FIGURES}


def fitted(top):
    """A queue of 64 and one of 256, on the searched views and on the others."""
    rows = page_data.rows(top, "fit.csv")
    if not rows:
        return None
    columns = [means(rows, machine, views) for views in (SEARCHED, LEFT_OUT) for machine in ("paper", "queue")]
    lines = [[figure, ("≥ " if figure == AT_LEAST else "") + f"{paper()[figure]:.2f}",
              *(shown(column[figure]) if within(figure, column[figure]) else f"**{shown(column[figure])}**" for column in columns)] for figure in FIGURES]
    lines.append(["within 20 %, of ten", "", *(str(sum(within(figure, column[figure]) for figure in FIGURES)) for column in columns)])
    return table(["figure", "the paper", "searched: queue 64", "queue 256", "left out: queue 64", "queue 256"], lines).replace("|  |", "| |")


def freedoms(top):
    """Further freedoms one at a time, on public views."""
    rows = page_data.rows(top, "fit_public.csv")
    if not rows:
        return None
    lines = []
    for machine, called in STEPS.items():
        sides = [means(rows, machine, views) for views in PUBLIC]
        outside = [figure for figure in FIGURES if not all(within(figure, side[figure]) for side in sides)]
        lines.append([called, *(str(sum(within(figure, side[figure]) for figure in FIGURES)) for side in sides), ", ".join(outside)])
    return table(["queue, and", "searched: within, of ten", "left out: within, of ten", "outside 20 % on one side or both"], lines).replace("|  |", "| |")


MADE = {"readings-fitted": lambda top, _page: fitted(top), "readings-freedoms": lambda top, _page: freedoms(top)}
