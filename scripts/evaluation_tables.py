# SPDX-License-Identifier: Apache-2.0
"""Tables of pages from evaluation.csv in docs/results/data, which bench/evaluate writes; readme_tables.py puts them into pages. A table says
under itself of which scenes, machine, mode, interval and version it is. A page with such tables has a row `scenes` in its stamp: the
hash of configs/scenes/evaluation.toml as it was. When the file is another, the page is a fault.
"""
import collections
import csv
import hashlib
import os
import re
import textwrap
import tomllib
from statistics import geometric_mean

import model_version

DATA = os.path.join("docs", "results", "data", "evaluation.csv")
SET = "configs/scenes/evaluation.toml"
COLUMNS = ("part", "machine", "mode", "view", "class", "generated", "took_part", "design", "k", "cycles", "half_interval", "energy_nj_per_ray",
           "rt_unit_mm2", "chip_mm2", "bound", "bound_cycles", "l2_accesses", "node_latency", "node_fetches", "node_visits", "instructions",
           "dram_bytes", "node_hit_rate", "rays", "model", "set", "date")
PAPER = ("Speed-up, GRTX-SW", "Speed-up, GRTX-HW", "Speed-up, GRTX", "Fewer L2 accesses, GRTX", "Shorter node fetch latency, GRTX",
         "Fewer node fetches, GRTX")  # of report/page/paper_targets.toml
CLASSES = {"rooms": lambda row: row["generated"] == "0" and row["class"] != "object",
           "objects": lambda row: row["generated"] == "0" and row["class"] == "object", "generated": lambda row: row["generated"] == "1"}


def hash_of_set(top):
    with open(os.path.join(top, SET), "rb") as file:
        return hashlib.sha256(file.read()).hexdigest()[:8]


def load(top):
    path = os.path.join(top, DATA)
    if not os.path.exists(path):
        return []
    with open(path, encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def mean(values):
    values = list(values)
    return geometric_mean(values) if values and None not in values else None


def shown(value, digits=2):
    return "–" if value is None else f"{value:.{digits}f}"


def with_range(values, digits=2):
    """Mean, smallest and largest."""
    values = list(values)
    if None in values or not values:
        return "–"
    if len(values) == 1:
        return f"**{values[0]:.{digits}f}**"
    return f"**{mean(values):.{digits}f}** ({min(values):.{digits}f}–{max(values):.{digits}f})"


def table(head, rows):
    return "".join("| " + " | ".join(row) + " |\n" for row in [head, ["---"] * len(head), *rows]).replace(" --- ", "---")


def caption(rows):
    """Whatever a figure of these rows needs to be quoted."""
    unique = lambda name: sorted({row[name] for row in rows})
    half = max(float(row["half_interval"]) for row in rows)
    widest = f", half of an interval at most {100 * half:.1f} %" if half else ", no interval"
    said = (f"(Scenes `{', '.join(unique('set'))}`; machine {', '.join(f'`{machine}`' for machine in unique('machine'))}; "
            f"mode {', '.join(unique('mode'))}{widest}; version {', '.join(unique('model'))} of the model.)")
    return f"\n{textwrap.fill(said, 120)}\n"


class Part:
    """Rows of one part on one machine: cycles and the rest of each design and view."""

    def __init__(self, rows):
        self.rows = rows
        self.at = {(row["design"], int(row["k"]), row["view"]): row for row in rows}
        self.designs = list(dict.fromkeys((row["design"], int(row["k"])) for row in rows))
        first = {row["view"]: row for row in rows}
        self.views = list(first)
        self.of_class = {name: [view for view, row in first.items() if inside(row)] for name, inside in CLASSES.items()}
        self.choose = [view for view, row in first.items() if row["took_part"]]  # k is chosen on these, and shown on the others
        self.show = {name: [view for view in views if view not in self.choose] or views for name, views in self.of_class.items()}
        self.first = {}  # of each design: its first k
        for design, k in self.designs:
            self.first.setdefault(design, k)
        views = self.choose or self.views
        self.base = max((k for design, k in self.designs if design == "baseline"), default=0,
                        key=lambda k: mean(1 / float(row["cycles"]) if (row := self.at.get(("baseline", k, view))) else None for view in views) or 0)

    def ratio(self, column, design, k, view, base, base_k):
        """What the base has of it over what the design has; None where one is not there."""
        own, other = self.at.get((design, k, view)), self.at.get((base, base_k, view))
        return float(other[column]) / float(own[column]) if own and other else None

    def speed(self, design, k, view):
        return self.ratio("cycles", design, k, view, "baseline", self.base)

    def mean(self, design, k, name):
        return mean(self.speed(design, k, view) for view in self.show[name])

    def heading(self, name):
        """Of a column with the mean of a class."""
        views = self.show[name]
        return f"{name}, {len(views)}" + (" (k is chosen on them)" if set(views) & set(self.choose) else "")

    def energy(self, design, k):
        views = [view for views in self.show.values() for view in views]
        over = mean(self.ratio("energy_nj_per_ray", design, k, view, "baseline", self.base) for view in views)
        return None if over is None else 1 / over

    def best(self, design):
        """The k with the largest mean over the views of role choose; where there are none, over all."""
        views = self.choose or self.views
        return max((k for name, k in self.designs if name == design), key=lambda k: mean(self.speed(design, k, view) for view in views) or 0)

    def shown(self):
        """(design, k, what k is called): each design with its first k and its best."""
        for design, first in self.first.items():
            best = self.best(design)
            yield design, first, str(first)
            if best != first:
                yield design, best, f"best: {best}"


def part(rows, name, machine=None):
    """None where the part has no figures."""
    own = [row for row in rows if row["part"] == name and machine in (None, row["machine"])]
    return Part(own) if own else None


def who(rows, name):
    """A row per design, with its best k, and on who-128 with its first one, too; a column per class of views: speed over the baseline
    with its best k."""
    of = part(rows, name)
    if not of:
        return None
    costs = name == "who-128"
    kinds = [kind for kind, views in of.of_class.items() if views]
    head = ["design", "k", *(of.heading(kind) for kind in kinds), *(["RT unit, mm²", "chip, mm²"] if costs else []), "energy"]
    lines = []
    for design, k, called in of.shown():
        if not costs and k != of.best(design):
            continue
        any_row = next(row for (d, size, _), row in of.at.items() if (d, size) == (design, k))
        lines.append([design, called, *(with_range(of.speed(design, k, view) for view in of.show[kind]) for kind in kinds),
                      *([shown(float(any_row["rt_unit_mm2"])), shown(float(any_row["chip_mm2"]), 1)] if costs else []),
                      shown(of.energy(design, k))])
    return table(head, lines) + caption(of.rows)


def cards(rows):
    """Shares of cards beside each other: speed over the baseline on each, and energy, of each design with its best k there."""
    machines = list(dict.fromkeys(row["machine"] for row in rows if row["part"] == "cards"))
    if not machines:
        return None
    parts = {machine: part(rows, "cards", machine) for machine in machines}
    kinds = [kind for kind in CLASSES if any(of.of_class[kind] for of in parts.values())]
    lines = []
    for design in next(iter(parts.values())).first:
        cells, called = [], set()
        for of in parts.values():
            k = of.best(design)
            called.add(k)
            cells += [shown(of.mean(design, k, kind)) for kind in kinds] + [shown(of.energy(design, k))]
        lines.append([design, ", ".join(map(str, sorted(called))), *cells])
    head = ["design", "k", *(f"`{machine}`: {kind}" if kind == kinds[0] else kind for machine in machines for kind in [*kinds, "energy"])]
    return table(head, lines) + caption([row for row in rows if row["part"] == "cards"])


def l2(rows):
    """Speed over the baseline with an L2 of 1 MiB, rooms / objects, a column a size; and the chip of the last design."""
    of, base = part(rows, "l2"), part(rows, "who-128")
    if None in (of, base):
        return None
    names, sizes = (list(dict.fromkeys(design.split(", L2 ")[at] for design, _ in of.designs)) for at in (0, 1))
    kinds = [kind for kind, views in of.of_class.items() if views]
    both = Part([row for row in base.rows if row["view"] in of.views] + of.rows)
    lines = []
    for name in names:
        k = next(k for design, k in of.designs if design.startswith(name + ", L2 "))
        lines.append([name, str(k), *(" / ".join(shown(both.mean(f"{name}, L2 {size}", k, kind), 1) for kind in kinds) for size in sizes)])
    chips = [next(row["chip_mm2"] for row in of.rows if row["design"] == f"{names[-1]}, L2 {size}") for size in sizes]
    lines.append([f"chip with {names[-1]}, mm²", "", *(shown(float(chip), 1) for chip in chips)])
    return table(["design", "k", *(f"L2 of {size}" for size in sizes)], lines) + caption(of.rows)


def steps(rows):
    """GauTracer's steps over its own baseline: speed of each view, and how many times fewer instructions and so on, means of all views."""
    of = part(rows, "steps")
    if not of:
        return None
    columns = {"instructions ÷": "instructions", "visits ÷": "node_visits", "DRAM bytes ÷": "dram_bytes", "energy ÷": "energy_nj_per_ray"}
    base, lines = "boxes, both shaders", []
    for design, k in of.designs:
        over = lambda column, design=design, k=k: [of.ratio(column, design, k, view, base, 16) for view in of.views]
        lines.append([design, str(k), *map(shown, over("cycles")), *(shown(mean(over(column))) for column in columns.values())])
    return table(["step", "k", *of.views, *columns], lines) + caption(of.rows)


def found(rows):
    """README's: a row a [[comparison]] of bench/evaluate/designs.toml, ratios of mean speeds of each class of views."""
    near, full = part(rows, "who-128"), part(rows, "who-full")
    if not near or not full:
        return None
    columns = [(near, kind, "") for kind, views in near.of_class.items() if views] + [(full, "rooms", ", as dense as in full HD")]
    lines = []
    for comparison in comparisons():
        cells = [shown(over(of, kind, comparison)) for of, kind, _ in columns]
        lines.append([comparison["says"], *(f"**{cell}**" if comparison.get("bold") else cell for cell in cells)])
    return table(["speed over", *(of.heading(kind) + dense for of, kind, dense in columns)], lines) + caption(near.rows + full.rows)


def over(of, kind, comparison):
    """How many times the speed of the fastest of its rivals it has; each with the k that is named, or its best."""
    def fastest(designs):
        return max((of.mean(design, comparison.get("k") or of.best(design), kind) or 0 for design in designs if design in of.first), default=0)
    own, rival = fastest([comparison["of"]]), fastest(comparison["over"])
    return own / rival if own and rival else None


def comparisons():
    with open(os.path.join(model_version.TOP, "bench", "evaluate", "designs.toml"), "rb") as file:
        return tomllib.load(file)["comparison"]


def paper_figures(names=PAPER):
    with open(os.path.join(model_version.TOP, "report", "page", "paper_targets.toml"), "rb") as file:
        found = {target["name"]: target["paper"] for target in tomllib.load(file)["run"]}
    return [found[name] for name in names]


def headline(rows):
    """The paper's six ratios: means of each class of views."""
    columns = ("l2_accesses", "node_latency", "node_fetches")
    lines = [["the paper's text (mean of its six scenes)", "", *map(shown, paper_figures())]]
    base = part(rows, "paper-128", "paper")
    if not base:
        return None
    apart = {view for view in base.views if not base.at["baseline", 8, view]["took_part"]}
    groups = {"rooms": base.of_class["rooms"], "other views of these": [view for view in base.of_class["rooms"] if view in apart],
              "objects": base.of_class["objects"], "generated": base.of_class["generated"]}
    for machine in ("paper", "paper-charged"):
        both = Part(base.rows + [row for row in rows if row["part"] == "paper-128" and row["machine"] == machine])
        for name, views in groups.items():
            if views:
                cells = [mean(both.speed(design, 8, view) for view in views) for design in ("sw", "hw", "grtx")]
                cells += [mean(both.ratio(column, "grtx", 8, view, "baseline", 8) for view in views) for column in columns]
                lines.append([f"`{machine}`", f"{name}, {len(views)}", *map(shown, cells)])
    return table(["machine", "views", "sw", "hw", "grtx", "L2 accesses ÷", "node latency ÷", "node fetches ÷"], lines) + caption(
        [row for row in rows if row["part"] == "paper-128" and row["machine"] != "paper-lean"])


def classes(rows):
    """A row a class of views: what their rays visit, and speeds of the paper's designs with free traffic of checkpoints; means and ranges."""
    base, dense = part(rows, "paper-128", "paper"), part(rows, "paper-full", "paper")
    if None in (base, dense):
        return None

    def visits(design, view):
        row = base.at.get((design, 8, view))
        return float(row["node_visits"]) / float(row["rays"]) if row else None

    lines = []
    for kind, views in base.of_class.items():
        if views:
            lines.append([f"{kind}, {len(views)}", *(shown(mean(visits(design, view) for view in views), 0) for design in ("baseline", "sw", "grtx")),
                          *(with_range(of.speed(design, 8, view) for view in views) for of in (base, dense) for design in ("sw", "hw", "grtx"))])
    head = ["views", "visits a ray: baseline", "sw", "grtx", "speed: sw", "hw", "grtx", "1,080 lines: sw", "hw", "grtx"]
    return table(head, lines) + caption([row for row in rows if row["part"].startswith("paper-") and row["machine"] == "paper"])


def binds(rows, name):
    """What each design waits for: resources with the largest lower bound, of how many views where not of all, and the range of that bound over
    the cycles."""
    of = part(rows, name)
    if not of:
        return None
    lines = []
    for design, k in of.first.items():
        own = [of.at[design, k, view] for view in of.views if (design, k, view) in of.at]
        shares = [float(row["bound_cycles"]) / float(row["cycles"]) for row in own]
        counts = collections.Counter(row["bound"] for row in own).most_common()
        names = ", ".join(bound if len(counts) == 1 else f"{bound} {count}" for bound, count in counts)
        lines.append([design, str(k), names, f"{min(shares):.2f}–{max(shares):.2f}"])
    return table(["design", "k", f"largest bound, of {len(of.views)} views", "over the cycles"], lines) + caption(of.rows)


def checkpoints(rows):
    """What charging takes from hw and grtx, and what `paper-lean` gets back: speed over that with free traffic, a row a class of views."""
    at = {(row["part"], row["machine"], row["design"], row["view"]): float(row["cycles"]) for row in rows if row["part"] in ("paper-128", "paper-full")}
    of = part(rows, "paper-128", "paper")
    if not of or not part(rows, "paper-full", "paper-lean"):
        return None
    columns = [(density, design, machine) for density in ("paper-128", "paper-full") for design in ("hw", "grtx")
               for machine in ("paper-charged", "paper-lean")]

    def over_free(view, density, design, machine):
        free, own = at.get((density, "paper", design, view)), at.get((density, machine, design, view))
        return free / own if free and own else None

    lines = [[f"{kind}, {len(views)}", *(with_range(over_free(view, *column) for view in views) for column in columns)]
             for kind, views in of.of_class.items() if views]
    head = ["views", *(("1,080 lines: " if density == "paper-full" and (design, machine) == ("hw", "paper-charged") else "")
                               + f"{design} {'charged' if machine == 'paper-charged' else 'lean'}" for density, design, machine in columns)]
    return table(head, lines) + caption([row for row in rows if row["part"].startswith("paper-")])


def lean(rows):
    """What each mechanism of `paper-lean` is worth to grtx: speed over that with free traffic, and what finishing instances adds to the visits."""
    of, free, whole = part(rows, "lean"), part(rows, "paper-128", "paper"), part(rows, "paper-128", "paper-lean")
    if None in (of, free, whole):
        return None
    of = Part(free.rows + of.rows + [{**row, "design": "all"} for row in whole.rows if row["design"] == "grtx"])
    lines = [[f"{kind}, {len(views)}",
              *(with_range(of.ratio("cycles", design, 8, view, "grtx", 8) for view in views) for design in ("small entries", "finished", "bins", "all")),
              with_range(of.ratio("node_visits", "small entries", 8, view, "finished", 8) for view in views)]
             for kind, views in free.of_class.items() if views]
    head = ["views", "small entries", "and finished instances", "and bins", "all: `paper-lean`", "visits, finished"]
    return table(head, lines) + caption([row for row in rows if row["part"] in ("lean", "paper-128")])


MADE = {"who-128": lambda rows: who(rows, "who-128"), "who-full": lambda rows: who(rows, "who-full"),
        "secondary": lambda rows: who(rows, "secondary"), "cards": cards, "l2": l2, "steps": steps, "found": found, "headline": headline, "classes": classes,
        "checkpoints": checkpoints, "lean": lean,
        "binds-128": lambda rows: binds(rows, "who-128"), "binds-full": lambda rows: binds(rows, "who-full")}
PARTS_OF = {"found": {"who-128", "who-full"}, "headline": {"paper-128"}, "classes": {"paper-128", "paper-full"},
            "checkpoints": {"paper-128", "paper-full"}, "lean": {"lean", "paper-128"},
            "l2": {"l2", "who-128"},
            "binds-128": {"who-128"}, "binds-full": {"who-full"}}


def made(top, name):
    """The table; None while nothing of it is measured."""
    return MADE[name](load(top))


def tables_of(text):
    return set(re.findall(r"<!-- generated: scripts/readme_tables\.py (\S+) -->", text)) & set(MADE)


def rows_of_page(text, rows):
    """Rows behind the tables of a page."""
    parts = set().union(*(PARTS_OF.get(name, {name}) for name in tables_of(text)))
    return [row for row in rows if row["part"] in parts]


def versions_cell(measured, now):
    """Of the stamp of a page whose tables say of which version they are."""
    oldest, *others = sorted(measured)
    if oldest == now:
        return str(now)
    return f"measured with version {oldest}" + (f"; tables that say so with version {', '.join(map(str, others))}" if others else "")


def renew_stamps(top):
    """Date, version and scenes of each page of results that has such tables and nothing else in it that a model gave."""
    rows = load(top)
    for page in model_version.pages(top):
        text = model_version.read(top, page)
        own = rows_of_page(text, rows)
        if not own:
            continue
        fresh = {"command": "`scripts/scenes.sh scenes`, `python3 bench/evaluate --scenes scenes`", "date": max(row["date"] for row in own),
                 "model version": versions_cell({int(row["model"]) for row in own}, model_version.current(top)),
                 "scenes": f"[evaluation.toml](../../{SET}), {', '.join(sorted({row['set'] for row in own}))}"}
        command = model_version.stamp(text).get("command", "")
        if "bench/evaluate" not in command:
            fresh["command"] = f"{command}; {fresh['command']}"
        for name, value in fresh.items():
            line, there = f"| {name} | {value} |\n", re.compile(rf"^\| {name} \| .* \|\n", re.M)
            text = there.sub(lambda _, line=line: line, text, 1) if there.search(text) else re.sub(
                r"^(\| machine \| .* \|\n)", lambda found, line=line: line + found.group(1), text, count=1, flags=re.M)
        model_version.write(top, page, text)


def faults(top):
    """Pages and data whose figures are of other scenes than those of SET, and data of another version of the model, but for those
    that a line of older_pages.csv excepts."""
    if not os.path.exists(os.path.join(top, SET)):
        return
    present, now = hash_of_set(top), str(model_version.current(top))
    excepted = {line["page"] for line in model_version.exceptions(top)}
    for page in sorted(set(model_version.pages(top)) - excepted):
        of = model_version.stamp(model_version.read(top, page)).get("scenes", "")
        for old in re.findall(r"(?<=, )[0-9a-f]{8}\b", of):
            if old != present:
                yield f"{page}:1: its figures are of scenes {old}, {SET} is {present}: python3 bench/evaluate"
    stale = any((row["set"], row["model"]) != (present, now) for row in load(top))
    if DATA in excepted:
        if not stale:
            yield f"{model_version.OLDER}: {DATA}: is of the present scenes and model: the line goes"
        return
    for name, value, what in (("set", present, f"scenes, {SET} is"), ("model", now, "version of the model, it has")):
        for old in sorted({row[name] for row in load(top)} - {value}):
            parts = sorted({row["part"] for row in load(top) if row[name] == old})
            yield f"{DATA}:1: {', '.join(parts)}: of another {what} {value}: python3 bench/evaluate"
