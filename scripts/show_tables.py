# SPDX-License-Identifier: Apache-2.0
"""Tables of docs/results/designs-show.md from designs-show*.csv and whole-frame.csv in docs/results/data, one of rivals.md from
heap-logics.csv, and sentences of the former and of README.md with figures of them; readme_tables.py puts the tables into the pages, and
checks both."""
import os

import page_data
from evaluation_tables import mean, paper_figures, shown, table, with_range

PAGE = os.path.join("docs", "results", "designs-show.md")
DATA = os.path.join(page_data.FOLDER, "designs-show.csv")
MEMORY, PICTURES, SIZE, FRAME = "designs-show-memory.csv", "designs-show-pictures.csv", "designs-show-size.csv", "whole-frame.csv"
LOGICS, PAPER = "heap-logics.csv", "paper-show.csv"
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
    rows = page_data.rows(top, os.path.basename(DATA))
    return Crops(rows, lines) if rows else None


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
    """What README and the page say of the data, and the data do not give."""
    both = [crops(top, lines) for lines in ("128", "1080")]
    if None not in both:
        yield from page_data.unsaid(top, "README.md", DATA, of_readme(*both))
        if (*MORE_OWN[1], "lookout") in both[1].at:
            yield from page_data.unsaid(top, PAGE, DATA, of_page(*both, page_data.rows(top, os.path.basename(DATA))))
    if rows := page_data.rows(top, FRAME):
        yield from page_data.unsaid(top, "README.md", FRAME, of_frame(rows))
    if rows := page_data.rows(top, PICTURES):
        far = min((float(row["dB"]), row["view"]) for row in rows if called(row) == GAUTRACER[0])
        walk = next(float(row["dB"]) for row in rows if called(row) == OWN[0][0] and row["view"] == far[1])
        yield from page_data.unsaid(top, "README.md", PICTURES, [f"{far[0]:.0f} and {walk:.0f} dB from it on one object"])
    if rows := page_data.rows(top, SIZE):
        yield from page_data.unsaid(top, PAGE, SIZE, of_size(rows))


def of_readme(near, dense):
    """Rows of README's table and its range of leads."""
    columns = [(of, views) for of in (near, dense) for views in (ROOMS, OBJECTS)]
    row = lambda value, digits: " | ".join(shown(value(of, views), digits) for of, views in columns) + " |"
    for design, digits in ((GRTX, 2), (GAUTRACER, 1), (OWN[1], 1)):
        yield row(lambda of, views, design=design: of.mean(design, views), digits)
    yield row(lambda of, views: of.mean(of.best(MIXES, views), views), 1)
    yield row(lambda of, views: mean(of.leads(views)), 2)
    leads = [lead for of, views in columns for lead in of.leads(views)]
    yield f"{min(leads):.2f} to {max(leads):.2f}"
    plain = [shown(mean(of.speed(OWN[0], view, ENTRY) for view in views)) for of, views in columns]
    yield f"with both off it is {', '.join(plain[:-1])} and {plain[-1]}"


def of_page(near, dense, every_row):
    """Sentences of the page that compare rows of its tables."""
    def worth(of, design, over):
        """Of a design over another, mean of each class: (rooms, objects)."""
        return [mean(of.speed(design, view, over) for view in views) for views in (ROOMS, OBJECTS)]

    def best(of, designs, over):
        return [mean(of.speed(of.best(designs, views), view, of.best(over, views)) for view in views) for views in (ROOMS, OBJECTS)]

    def span(pairs, views, digits=2):
        """Of the first of each pair over the second."""
        every = [of.speed(design, view, over) for of in (near, dense) for design, over in pairs for view in views]
        return f"{min(every):.{digits}f} to {max(every):.{digits}f}"

    both = lambda values: " and ".join(map(shown, values))
    leads = [[mean(of.leads(views)) for views in (ROOMS, OBJECTS)] for of in (near, dense)]
    yield f"The walk has {leads[0][0]:.2f} (rooms) and {leads[0][1]:.2f} times (objects)"
    yield f"at full density it is {both(leads[1])}."
    every = [[lead for views in (ROOMS, OBJECTS) for lead in of.leads(views)] for of in (near, dense)]
    yield "By view the lead is " + ", and ".join(f"{min(of):.2f} to {max(of):.2f}" for of in every) + "."
    whole = {called(row): float(row["cycles"]) for row in every_row if row["sms"] == "8"}
    yield f"the walk has {whole[ENTRY[0]] / whole[OWN[0][0]]:.2f} times the speed of by entry"
    own, rival = ([worth(of, design, plain) for of in (near, dense)] for design, plain in ((OWN[1], OWN[0]), (MIXES[0], ENTRY)))
    yield (f"is worth {own[0][1]:.2f} and {own[1][1]:.2f} for the walk on objects, {own[0][0]:.2f} and {own[1][0]:.2f} in rooms. "
           f"The rival gains more: {rival[0][1]:.2f} and {rival[1][1]:.2f}, {rival[0][0]:.2f} and {rival[1][0]:.2f}.")
    heaps, mixes = worth(dense, MORE_OWN[1], OWN[1]), best(dense, MORE_MIXES, MIXES)
    area = lambda of, design: float(of.at[*design, ROOMS[0]]["rt_unit_mm2"])
    yield (f"{heaps[0]:.2f} (rooms) and {heaps[1]:.2f} times (objects) as fast at full density, the best mix {both(mixes)}, "
           f"for {100 * (area(dense, MORE_OWN[1]) / area(dense, OWN[1]) - 1):.1f} % of the RT unit")
    colour = {view: dense.speed(COLOUR, view, OWN[0]) for view in (*ROOMS, *OBJECTS)}
    yield f"{both([colour[view] for view in ROOMS[:2]])} on the two rooms with harmonics at full density, {both([colour[view] for view in OBJECTS])} on"
    slower = [100 * (1 - near.speed(COLOUR, view, OWN[0])) for view in (*ROOMS, *OBJECTS)]
    yield f"costs {min(slower):.0f} to {max(slower):.0f} % with sparse rays"
    grtx, more = [(GRTX, ("sw", 32))], [(MIXES[2], MIXES[0]), (MIXES[3], MIXES[1])]
    yield f"are worth {span(grtx, ROOMS)} over sw in rooms, {span(grtx, OBJECTS, 1)} on objects."
    yield (f"they are worth {span(more, ROOMS)} in rooms, {span(more, OBJECTS)} on objects, "
           f"for {100 * (area(near, MIXES[2]) / area(near, MIXES[0]) - 1):.0f} % of the RT unit")


def of_frame(rows):
    """README's sentence on a whole frame."""
    ms = {(called(row), row["mode"]): float(row["cycles"]) / float(row["mhz"]) / 1e3 for row in rows}
    mixes = [float(row["cycles"]) / float(row["mhz"]) / 1e3 for row in rows if (called(row), int(row["k"])) in MIXES and row["mode"] == "windows"]
    named = [f"{ms[name, 'windows']:,.0f} {unit}({word})" for name, word, unit in
             (("baseline", "baseline", "ms "), ("grtx", "GRTX", ""), ("gautracer", "GauTracer", "")) if (name, "windows") in ms]
    yield f"takes {', '.join(named)}, {min(mixes):.0f} (the best mix) and {ms[OWN[1][0], 'windows']:.0f} (`walk`)"


def of_size(rows):
    """Sentences of the page on launches that are too small to fill the machine."""
    started = [(row, 100 * (1 - float(row["tail_cycles"]) / float(row["cycles"]))) for row in rows]
    span = lambda wanted: "{:.0f} to {:.0f} %".format(*(end(share for row, share in started if wanted(row)) for end in (min, max)))
    yield f"after {span(lambda row: row['width'] == '48' and row['design'] != 'baseline')} of these runs"
    yield f"of the baseline: after {span(lambda row: row['width'] == '48' and row['design'] == 'baseline')}"
    yield f"after {min(share for row, share in started if row['width'] == '192' and row['design'] != 'baseline'):.0f} % or more"
    at = {(called(row), row["width"]): float(row["cycles"]) for row in rows if row["view"] == "lookout-0" and row["lines"] == "1080"}
    yield ("four times the pixels take the baseline {:.2f} times the cycles, by entry {:.2f} and the walk {:.2f}."
           .format(*(at[name, "96"] / at[name, "48"] for name in ("baseline", MIXES[0][0], OWN[1][0]))))


def memories(top):
    """The walk over the best mix for each class, by L2 slices and bandwidth of the DRAM."""
    rows = page_data.rows(top, MEMORY)
    if not rows:
        return None
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


def whole_gpu(top):
    """Speeds over the baseline on all SMs of the machine."""
    rows = [row for row in page_data.rows(top, os.path.basename(DATA)) or [] if row["sms"] == "8"]
    if not rows:
        return None
    base = float(rows[0]["cycles"])
    return table([called(row) for row in rows[1:]], [[shown(base / float(row["cycles"])) for row in rows[1:]]])


def sizes(top):
    """The walk over by entry, both near, by the pixels of a crop."""
    rows = page_data.rows(top, SIZE)
    if not rows:
        return None
    at = {(called(row), row["width"], row["view"].split("-")[0]): row for row in rows if row["design"] != "baseline"}
    views = list(dict.fromkeys(view for _, _, view in at))

    def lead(width, view):
        return shown(float(at[MIXES[0][0], width, view]["cycles"]) / float(at[OWN[1][0], width, view]["cycles"])) if (OWN[1][0], width, view) in at else ""
    lines = [[f"{width} × {width}", f"{int(at[OWN[1][0], width, views[0]]['warps']):,}", *(lead(width, view) for view in views)]
             for width in dict.fromkeys(width for _, width, _ in at)]
    return table(["pixels", "warps", *views], lines).replace("|  |", "| |").replace("|  |", "| |")


def pictures(top):
    """Energy of the crops of 128 lines, and how far their pictures are from the baseline's."""
    of, rows = crops(top, "128"), page_data.rows(top, PICTURES)
    if not of or not rows:
        return None
    views = (*ROOMS, *OBJECTS)
    seen = {(called(row), int(row["k"]), row["view"].split("-")[0]): row for row in rows}
    picture = lambda design: [seen[*design, view]["picture"] for view in views]
    lines = []
    for design in (("baseline", 32), *ROWS):
        if not all((*design, view) in seen for view in views):
            continue
        energy = [float(of.at[*design, view]["energy_nj_per_ray"]) * int(of.at[*design, view]["width"]) ** 2 / 1e6 for view in views]
        same = "the same" if picture(design) == picture(("baseline", 32)) else "as by entry" if design != ENTRY and picture(design) == picture(ENTRY) else ""
        lines.append([design[0], str(design[1]), ", ".join(map(page_data.significant, energy)),
                      "" if design[0] == "baseline" else same or ", ".join(f"{float(seen[*design, view]['dB']):.1f}" for view in views)])
    return table(["design", "k", f"mJ of the crop at 128 lines: {', '.join(views)}", "dB from the baseline's picture"], lines).replace("|  |", "| |")


def frame(top):
    """A whole frame by windows, beside cycle mode where it was run: a row a design."""
    rows = page_data.rows(top, FRAME)
    if not rows:
        return None
    at = {(called(row), int(row["k"]), row["mode"]): row for row in rows}

    def over(name, k):
        """Cycles of a design over those of the walk, with as many heap logics; both of one mode, cycle mode where both have it."""
        walk = (OWN[1][0] + (HEAPS if name.endswith(HEAPS) else ""), OWN[1][1])
        modes = [mode for mode in ("cycle", "windows") if (name, k, mode) in at and (*walk, mode) in at]
        return float(at[name, k, modes[0]]["cycles"]) / float(at[*walk, modes[0]]["cycles"]) if modes else None

    lines = []
    for name, k in dict.fromkeys((name, k) for name, k, _ in at):
        windows, cycle = at.get((name, k, "windows")), at.get((name, k, "cycle"))
        first = windows or cycle

        def interval(column, unit, show, row=windows):
            value, *ends = (show(float(row[column + end]) / unit) for end in ("", "_low", "_high") if row[column + end])
            return value + (f" ({ends[0]} to {ends[1]})" if ends else "")

        millions = lambda value: f"{value:,.1f}"
        trace = ", ".join(f"{float(first[column]) / unit:{show}}" for column, unit, show in (("trace_bytes", 1e6, ",.0f"), ("trace_minutes", 1, ".1f")) if first[column])
        lines.append([name, str(k), interval("cycles", 1e6, millions) if windows else "", f"{float(first['cycles']) / float(first['mhz']) / 1e3:,.1f}",
                      interval("mJ", 1, page_data.significant) if windows else "",
                      f"{float(cycle['cycles']) / 1e6:,.2f}, {page_data.significant(float(cycle['mJ']))}" if cycle else "", shown(over(name, k)), trace,
                      ", ".join(f"{float(row['run_minutes']):.1f}" for row in (windows, cycle) if row)])
    return table(["design", "k", "M cycles", "ms", "mJ", "in cycle mode: M cycles, mJ", "÷ the walk's cycles", "trace: MB, processor minutes",
                  "runs: processor minutes"], lines).replace("|  |", "| |")


def heap_logics(top):
    """Speed with 16 and 32 heap logics over that with eight, means of the views of role choose, by density."""
    rows = page_data.rows(top, LOGICS)
    if not rows:
        return None
    at = {(row["design"], row["k"], row["lines"], row["heap_logics"], row["view"]): float(row["cycles"]) for row in rows}
    views = dict.fromkeys(row["view"] for row in rows)

    def over_eight(design, k, lines, logics):
        return shown(mean(at[design, k, lines, "8", view] / at[design, k, lines, logics, view] for view in views))
    return table(["speed over 8 heap logics", "k", "128 lines: 16", "32", "1,080 lines: 16", "32"],
                 [[design, k, *(over_eight(design, k, lines, logics) for lines in ("128", "1080") for logics in ("16", "32"))]
                  for design, k in dict.fromkeys((row["design"], row["k"]) for row in rows)])


def paper_show(top):
    """The paper's six ratios on rooms that took no part: means and ranges."""
    rows = page_data.rows(top, PAPER)
    if not rows:
        return None
    at = {(row["view"], row["design"], row["machine"]): row for row in rows}
    views = list(dict.fromkeys(row["view"] for row in rows))
    columns = [("cycles", "sw"), ("cycles", "hw"), ("cycles", "grtx"), ("l2_accesses", "grtx"), ("node_latency", "grtx"), ("node_fetches", "grtx")]

    def ratio(view, machine, column, design):
        """The baseline and sw, which have no checkpoints, were run on the first machine alone."""
        own = at[view, design, "paper" if design == "sw" else machine]
        return float(at[view, "baseline", "paper"][column]) / float(own[column])
    lines = [["the paper's text", *map(shown, paper_figures())]]
    lines += [[f"`{machine}`", *(with_range(ratio(view, machine, *column) for view in views) for column in columns)]
              for machine in dict.fromkeys(row["machine"] for row in rows)]
    return table([f"rooms that took no part, {len(views)} views", "sw", "hw", "grtx", "L2 accesses ÷", "node latency ÷", "node fetches ÷"], lines)


MADE = {"paper-show": lambda top, _page: paper_show(top), "heap-logics": lambda top, _page: heap_logics(top), "show-memory": lambda top, _page: memories(top), "show-128": lambda top, _page: speeds(top, "128"),
        "show-1080": lambda top, _page: speeds(top, "1080"), "show-gpu": lambda top, _page: whole_gpu(top), "show-size": lambda top, _page: sizes(top),
        "show-pictures": lambda top, _page: pictures(top), "show-frame": lambda top, _page: frame(top)}
