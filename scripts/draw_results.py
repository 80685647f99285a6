# SPDX-License-Identifier: Apache-2.0
"""The chart that a page of results opens with, one SVG each in docs/images/results/, from docs/results/data/evaluation.csv.
scripts/readme_tables.py writes and checks them with the tables of the same data."""
import os

import draw_units
import evaluation_tables as tables
import model_version

FOLDER = os.path.join("docs", "images", "results")
KINDS = ("box", "unit", "mem", "mark")  # fills of bars of one group, in turn (draw_units.STYLE)
SHORT = {"gautracer, by entry, no spills": "best mix of the papers' parts", "gautracer, by entry, no spills, leaves of 32 B": "mix, walk's leaves"}


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


CHARTS = {"rivals": (rivals, ("who-128",)), "bounds": (bounds, ("who-128",)),
          "checkpoints": (checkpoints, ("paper-128", "paper-full")), "scene-classes": (scene_classes, ("paper-128",))}


def drawn(top):
    """(path, text) of each chart that its page shows and whose parts are measured."""
    rows = tables.load(top)
    measured = {row["part"] for row in rows}
    for name, (draw, parts) in CHARTS.items():
        page = os.path.join("docs", "results", name + ".md")
        shown = os.path.exists(os.path.join(top, page)) and f"images/results/{name}.svg" in model_version.read(top, page)
        if shown and measured >= set(parts):
            yield os.path.join(FOLDER, name + ".svg"), draw(rows)


def renew(top):
    for path, text in drawn(top):
        os.makedirs(os.path.join(top, FOLDER), exist_ok=True)
        model_version.write(top, path, text)


def faults(top):
    for path, text in drawn(top):
        if not os.path.exists(os.path.join(top, path)) or model_version.read(top, path) != text:
            yield f"{path}:1: is not what scripts/draw_results.py makes of docs/results/data: run scripts/readme_tables.py"
