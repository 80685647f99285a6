# SPDX-License-Identifier: Apache-2.0
"""The chart that a page of results opens with, one SVG each in docs/images/results/: from docs/results/data/evaluation.csv,
from the page's own table, or from the recorded figures of the paper. scripts/readme_tables.py writes and checks them."""
import math
import os
import re
import sys

import draw_units
import evaluation_tables as tables
import model_version

FOLDER = os.path.join("docs", "images", "results")
KINDS = ("box", "unit", "mem", "mark")  # fills of bars of one group, in turn (draw_units.STYLE)
SHORT = {"gautracer, by entry, no spills": "best mix of the papers' parts", "gautracer, by entry, no spills, leaves of 32 B": "mix, walk's leaves"}


class Chart(draw_units.Figure):
    """A figure in the colours of the pages of `grtx report`; `open` marks are hollow."""
    @property
    def style(self):
        sheet = model_version.read(model_version.TOP, os.path.join("report", "page", "web", "report.css"))
        # The rule of the light scheme and that of the dark one, in the order of the file.
        light, dark = ("".join(f".{name}{{fill:{colour};stroke:{colour}}}" for name, colour in re.findall(r"--(c[1-4]): (#\w+);", rule))
                       for rule in re.findall(r":root \{(.*?)\}", sheet, flags=re.S)[:2])
        return (draw_units.STYLE + ".grid{stroke:#c3cad5;stroke-width:.6} .one{stroke:#56657a;stroke-width:1.2} .span{stroke-width:2}\n" +
                light + "\n@media (prefers-color-scheme: dark){.grid{stroke:#3a4658}.one{stroke:#8fa0b8}" + dark +
                "}\n.open{fill:none;stroke-width:1.8}\n")

    def line(self, x1, y1, x2, y2, kind="grid"):
        self.parts.append(f'<path class="{kind}" d="M{x1:.1f} {y1:.1f} L{x2:.1f} {y2:.1f}"/>')

    def mark(self, shape, kind, x, y):
        if shape == "circle":
            self.parts.append(f'<circle class="{kind}" cx="{x:.1f}" cy="{y:.1f}" r="4.5"/>')
        else:
            corners = {"triangle": [(0, -5.5), (5, 4), (-5, 4)], "square": [(-4.2, -4.2), (4.2, -4.2), (4.2, 4.2), (-4.2, 4.2)]}[shape]
            self.parts.append(f'<path class="{kind}" d="M' + " L".join(f"{x + dx:.1f} {y + dy:.1f}" for dx, dy in corners) + ' z"/>')


def spaced(ticks, values):
    """The ticks that the values need: those between, and one beyond at each end."""
    low, high = min(values), max(values)
    return [tick for tick in ticks if max([t for t in ticks if t <= low], default=0) <= tick <= min([t for t in ticks if t >= high], default=tick)]


def dots(title, legend, rows, ticks, left, band=None):
    """Marks on a logarithmic axis, a row each: (name, [(kind, value, low, high)], text at the right); low None: no span.
    legend: (kind, name); band: the shaded part, to both sides of 1. Marks of two colours in a row stand above each other."""
    right, top = draw_units.WIDTH - 64, 58
    step = 23 if any(len(marks) > 1 for _, marks, _ in rows) else 18
    bottom = top + step * len(rows)
    figure = Chart(title, bottom + 30)
    figure.text(14, 22, title, "name", anchor="start")
    ticks = spaced(ticks, [1 - (band or 0), 1 + (band or 0)] + [value for _, marks, _ in rows for mark in marks for value in mark[1:] if value is not None])
    place = lambda value: left + (right - left) * math.log(value / ticks[0]) / math.log(ticks[-1] / ticks[0])
    if band:
        low, high = place(1 - band), place(1 + band)
        figure.parts.append(f'<rect class="area" x="{low:.1f}" y="{top}" width="{high - low:.1f}" height="{bottom - top}"/>')
    for tick in ticks:
        figure.line(place(tick), top, place(tick), bottom + 4, "one" if tick == 1 else "grid")
        figure.text(place(tick), bottom + 18, f"{tick:g}")
    x = 18
    for kind, name in legend:
        figure.mark("circle", kind, x, 39)
        figure.text(x + 10, 43, name, anchor="start")
        x += 34 + 6.1 * len(name)
    for index, (name, marks, text) in enumerate(rows):
        y = top + step * (index + 0.5)
        figure.line(left, y, right, y)
        figure.text(left - 10, y + 4, name, anchor="end")
        figure.text(right + 8, y + 4, text, anchor="start")
        for kind, value, low, high in marks:
            if low is not None:
                figure.line(place(low), y, place(high), y, f"{kind} span")
            figure.mark("circle", kind, place(value), y + (0 if len(marks) == 1 else -4 if kind.startswith("c1") else 4))
    return figure.svg()


class NoTable(ValueError):
    """A page lacks the table that its chart is drawn from."""


def table(text, *columns):
    """Rows, by the names of columns, of the page's first table that has these; bold and links are gone."""
    plain = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", text.replace("**", ""))
    for head, body in re.findall(r"^(\|.*\|)\n\|[-|]+\|\n((?:\|.*\|\n)+)", plain, flags=re.M):
        names, *rows = [[cell.strip() for cell in line[1:-1].split("|")] for line in (head, *body.splitlines())]
        if set(columns) <= set(names):
            return [dict(zip(names, row)) for row in rows]
    raise NoTable(", ".join(columns))


def numbers(cell):
    """All numbers of a cell."""
    return [float(number.replace(",", "")) for number in re.findall(r"\d[\d,]*(?:\.\d+)?", cell)]


def chart(title, legend, groups):
    """Bars from 0 on: groups are (name, values), a bar for each entry of the legend; None: no bar."""
    left, bar = 250, 15
    most = max(value for _, values in groups for value in values if value is not None)
    height = 58 + sum(bar * len(values) + 12 for _, values in groups)
    figure = draw_units.Figure(title, height)
    figure.text(14, 22, title, "name", anchor="start")
    x = left
    for kind, name in zip(KINDS, legend):
        figure.parts.append(f'<rect class="{kind}" x="{x}" y="33" width="12" height="12"/>')
        figure.text(x + 17, 43, name, anchor="start")
        x += 40 + 6.2 * len(name)
    y = 56
    for name, values in groups:
        figure.text(left - 10, y + bar * len(values) / 2 + 4, name, anchor="end")
        for kind, value in zip(KINDS, values):
            if value is not None:
                width = value / most * (draw_units.WIDTH - left - 70)
                figure.parts.append(f'<rect class="{kind}" x="{left}" y="{y}" width="{width:.1f}" height="{bar - 2}"/>')
                figure.text(left + width + 6, y + bar - 4, f"{value:.2f}", anchor="start")
            y += bar
        y += 12
    return figure.svg()


def rivals(rows):
    of = tables.part(rows, "who-128")
    kinds = [kind for kind, views in of.show.items() if views]
    wanted = [name for name in ("baseline", "sw", "hw", "grtx", "gautracer", *SHORT, "walk") if name in of.first]
    groups = [(f"{SHORT.get(name, name)}, k = {of.best(name)}", [of.mean(name, of.best(name), kind) for kind in kinds]) for name in wanted]
    return chart("Speed over the baseline, each design at its best k", [of.heading(kind) for kind in kinds], groups)


def bounds(rows):
    of = tables.part(rows, "who-128")
    groups = []
    for name, k in of.first.items():
        own = [of.at[name, k, view] for view in of.views if (name, k, view) in of.at]
        if name in ("baseline", "sw", "hw", "grtx", "gautracer", "walk"):
            groups.append((name, [tables.mean(float(row["bound_cycles"]) / float(row["cycles"]) for row in own)]))
    return chart("Largest lower bound over the cycles, mean of all views: 1 is a resource in use all the time", ["all views"], groups)


def checkpoints(rows):
    groups = []
    for part, lines in (("paper-128", "128 lines"), ("paper-full", "1,080 lines")):
        free = tables.part(rows, part, "paper")
        for kind, views in free.of_class.items():
            values = []
            for machine in ("paper-charged", "paper-lean"):
                own = tables.part(rows, part, machine)
                over = [float(free.at["grtx", 8, view]["cycles"]) / float(row["cycles"]) for view in views
                        if own and (row := own.at.get(("grtx", 8, view)))]
                values.append(tables.mean(over))
            if views:
                groups.append((f"{kind}, {lines}", values))
    return chart("grtx: speed over that with free checkpoint traffic", ["charged: paper-charged", "and less of it: paper-lean"], groups)


def scene_classes(rows):
    of = tables.part(rows, "paper-128", "paper")
    groups = [(f"{kind}, {len(views)}", [tables.mean(of.speed(design, 8, view) for view in views) for design in ("sw", "hw", "grtx")])
              for kind, views in of.of_class.items() if views]
    return chart("Speed over the baseline with free checkpoint traffic, k = 8", ["sw", "hw", "grtx"], groups)


def silicon(_top, text):
    """Milliseconds of the card against ours: a mark for each mean of a chart over our fitted and over our other scenes."""
    charts, marks = [], []
    for row in table(text, "chart", "measured", "fitted, 2", "tested, 3"):
        charts += [row["chart"].split(" (")[0]] if row["chart"] else []
        if row[""].endswith(", ms"):
            marks += [(len(charts), row[""][0], " open" if ours == "fitted, 2" else "", numbers(row["measured"])[0], numbers(row[ours])[0],
                       ", all five scenes" if "all five" in row[ours] else "") for ours in ("fitted, 2", "tested, 3") if row[ours]]
    title, size, left, top = "Milliseconds of a frame, ours (up) and measured (across)", 400, 50, 36
    figure = Chart(title, top + size + 44)
    figure.text(14, 22, title, "name", anchor="start")
    ends = 0.85 * min(min(mark[3:5]) for mark in marks), 1.15 * max(max(mark[3:5]) for mark in marks)
    along = lambda value: size * math.log(value / ends[0]) / math.log(ends[1] / ends[0])
    x, y = (lambda value: left + along(value)), (lambda value: top + size - along(value))
    corners = [(ends[0], ends[0]), (ends[0], 1.5 * ends[0]), (ends[1] / 1.5, ends[1]), (ends[1], ends[1]), (ends[1], ends[1] / 1.5), (1.5 * ends[0], ends[0])]
    figure.parts.append('<path class="area" d="M' + " L".join(f"{x(a):.1f} {y(b):.1f}" for a, b in corners) + ' z"/>')
    for tick in (tick for tick in (1, 2, 3, 5, 7, 10, 15, 20, 30, 50, 70, 100) if ends[0] <= tick <= ends[1]):
        figure.line(x(tick), top, x(tick), top + size)
        figure.line(left, y(tick), left + size, y(tick))
        figure.text(x(tick), top + size + 18, f"{tick}")
        figure.text(left - 8, y(tick) + 4, f"{tick}", anchor="end")
    figure.line(x(ends[0]), y(ends[0]), x(ends[1]), y(ends[1]), "one")
    figure.text(left + size / 2, top + size + 36, "measured, ms")
    shapes = {"A": ("triangle", "A: icosahedra, one for each Gaussian"), "C": ("circle", "C: a shared icosahedron"), "D": ("square", "D: a shared box and a shader")}
    for index, structure, hollow, measured, ours, scenes in marks:
        figure.mark(shapes[structure][0], f"c{index}{hollow}", x(measured), y(ours))
        if not 1 / 1.5 <= ours / measured <= 1.5:
            figure.text(x(measured) + 10, y(ours) + 4, f"{ours / measured:.2f} of it{scenes}", anchor="start")
    keys = [(None, "", "RTX 6000 Ada, charts of the sample:"),
            *(("swatch", f"c{index}", name) for index, name in enumerate(charts, 1) if any(mark[0] == index for mark in marks)), None,
            *((shape, "box", name) for shape, name in shapes.values()), None,
            ("circle", "name", "filled: scenes that took no part in the fit"), ("circle", "box", "open: the two fitted scenes"),
            ("swatch", "area", "within 1.5 times")]
    for index, (shape, kind, name) in ((index, key) for index, key in enumerate(keys) if key):
        middle = left + size + 26, top + 20 + 19 * index
        if shape == "swatch":
            figure.parts.append(f'<rect class="{kind}" x="{middle[0] - 9}" y="{middle[1] - 4}" width="18" height="8"/>')
        elif shape:
            figure.mark(shape, kind, *middle)
        figure.text(middle[0] + (14 if shape else -9), middle[1] + 4, name, anchor="start")
    return figure.svg()


def vulkan_sim(_top, text):
    rows, named = [], ""
    for row in table(text, "view", "descriptors", "ours ÷ theirs"):
        named = row["view"].replace("the same", named)
        ratio = numbers(row["ours ÷ theirs"])[0]
        rows.append((named + (", descriptors" if row["descriptors"] == "yes" else ""), [("c2" if "tlas-" in named else "c1", ratio, None, None)], f"{ratio:.3f}"))
    return dots("Cycles, ours ÷ Vulkan-Sim's, on the same node reads; shaded: within 5 %", [("c1", "one level (tri20)"), ("c2", "two levels (tlas-tri20)")],
                rows, (0.7, 0.8, 0.85, 0.9, 0.95, 1, 1.05, 1.1, 1.15, 1.2, 1.3), 290, band=0.05)


def designs_show(_top, text):
    kinds, rows, named = (("rooms", "c1"), ("objects", "c2")), {}, ""
    dense = text.index("As dense as in 1,080 lines")
    for part, hollow in ((text[:dense], ""), (text[dense:], " open")):
        for row in table(part, "design", "rooms", "objects"):
            if " over " in row["design"] or "both" in row["design"]:
                continue
            named = row["design"].replace("the same", named)
            rows.setdefault(named, []).extend((colour + hollow, numbers(row[kind])[0], None, None) for kind, colour in kinds)
    legend = [(colour + hollow, f"{kind}, {lines} lines") for hollow, lines in (("", "128"), (" open", "1,080")) for kind, colour in kinds]
    return dots("Speed over the baseline, as dense as in frames of 128 and of 1,080 lines", legend, [(name, marks, "") for name, marks in rows.items()],
                (1, 2, 5, 10, 20, 50, 100, 200, 500), 320)


def rtl(_top, text):
    rows = [(f"checkpoint unit, {row['lanes']} lane{'s' * (row['lanes'] != '1')}", "c1", numbers(row["ratio"])[0]) for row in table(text, "lanes", "ratio")]
    rows += [(row[""], "c2" if re.match("fp_|reciprocal", row[""]) else "c1", numbers(row["ratio"])[0]) for row in table(text, "", "RTL, GE", "ratio")]
    return dots("Gates: the RTL, synthesised, ÷ the cost model's central value; shaded: within 20 %", [("c1", "unit"), ("c2", "operator")],
                [(name, [(kind, ratio, None, None)], f"{ratio:.2f}") for name, kind, ratio in rows], (0.5, 0.7, 0.8, 0.9, 1, 1.1, 1.2, 1.3, 1.5, 2), 240, band=0.2)


def cost_validation(_top, text):
    rows, named = [], ""
    for kind, item, theirs, ours in (("c1", "RT unit", "die photo, mm²", "ours, mm² (low, central, high)"), ("c2", "unit", "theirs (cycles)", "ours, cells alone")):
        for row in table(text, item, theirs, ours):
            low, middle, high = (value / numbers(row[theirs])[0] for value in numbers(row[ours]))
            named = row[item].split(";")[0].replace("the same", named)
            rows.append((named, [(kind, middle, low, high)], f"{middle:.2f}"))
    return dots("Area, ours ÷ the independent figure: central value, low to high", [("c1", "a die photo, 12 nm"), ("c2", "GauTracer's synthesis, 28 nm, cells alone")],
                rows, (0.2, 0.3, 0.5, 0.7, 1, 1.5, 2, 3, 5, 7, 10), 250)


def readings(top, _text):
    """All figures that the paper prints, as bench/paper has them recorded of machine `paper`."""
    sys.path.append(os.path.join(model_version.TOP, "bench"))
    from paper import claims
    folder = os.path.join(top, "bench", "paper")
    recorded = claims.read(os.path.join(folder, "expected.toml"))["quick"]["paper"]
    figures = sorted(((recorded[claim.id] / claim.paper, claim) for claim in claims.load(os.path.join(folder, "claims.toml")).values()
                      if claim.paper is not None and claim.id in recorded), key=lambda found: found[0])
    met = [claim.holds(recorded[claim.id]) for _, claim in figures]
    rows = [(claim.what + (", at least" if claim.bound else ""), [("c1" if holds else "c4", ratio, None, None)], f"{ratio:.2f}")
            for (ratio, claim), holds in zip(figures, met)]
    return dots("The paper's printed figures on machine paper, ours ÷ the paper's; shaded: within 20 %", [("c1", f"{sum(met)} of {len(met)} hold"),
                ("c4", f"{len(met) - sum(met)} do not")], rows, (0.4, 0.5, 0.6, 0.7, 0.8, 1, 1.2, 1.5, 2, 2.5, 3, 4), 390, band=0.2)


CHARTS = {"rivals": (rivals, ("who-128",)), "bounds": (bounds, ("who-128",)),
          "checkpoints": (checkpoints, ("paper-128", "paper-full")), "scene-classes": (scene_classes, ("paper-128",))}


# Drawn from the page's own table, which so stays the one place of its figures (or, readings, from bench/paper).
OF_PAGES = {"silicon": silicon, "vulkan-sim": vulkan_sim, "designs-show": designs_show, "rtl": rtl, "cost-validation": cost_validation,
            "readings": readings}


def drawn(top):
    """(path, what it is drawn from, a function that draws it) of each chart that its page shows and whose parts are measured."""
    rows = tables.load(top)
    measured = {row["part"] for row in rows}
    for name in (*CHARTS, *OF_PAGES):
        page = os.path.join("docs", "results", name + ".md")
        text = model_version.read(top, page) if os.path.exists(os.path.join(top, page)) else ""
        path = os.path.join(FOLDER, name + ".svg")
        if f"images/results/{name}.svg" in text:
            if name in OF_PAGES:
                yield path, "bench/paper" if name == "readings" else page, lambda name=name, text=text: OF_PAGES[name](top, text)
            elif measured >= set(CHARTS[name][1]):
                yield path, "docs/results/data", lambda name=name: CHARTS[name][0](rows)


def renew(top):
    for path, source, draw in drawn(top):
        os.makedirs(os.path.join(top, FOLDER), exist_ok=True)
        try:
            model_version.write(top, path, draw())
        except NoTable as missing:
            sys.exit(f"{source}:1: has no table with columns {missing}, which scripts/draw_results.py draws")


def faults(top):
    for path, source, draw in drawn(top):
        try:
            if not os.path.exists(os.path.join(top, path)) or model_version.read(top, path) != draw():
                yield f"{path}:1: is not what scripts/draw_results.py makes of {source}: run scripts/readme_tables.py"
        except NoTable as missing:
            yield f"{source}:1: has no table with columns {missing}, which scripts/draw_results.py draws"
