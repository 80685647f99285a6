# SPDX-License-Identifier: Apache-2.0
"""Pages in Markdown, a section an item. The same results give the same bytes: no date, host or time."""
import os
import re
import sys

from . import figures, items
from .study import geometric_mean

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scripts"))
import docs_prose  # noqa: E402


def shown(value):
    return figures.number(value)


class Page:
    """One item: claims with their values, tables, pictures, sentences. expected: claims.Expected; public: names of the scenes
    whose means are apart."""

    def __init__(self, item, title, claims, which, expected=None, public=()):
        self.item, self.title, self.claims, self.which = item, title, claims, which
        self.expected, self.public = expected, frozenset(public)
        self.found = {}   # (claim, machine): mean over generated scenes
        self.apart = {}   # (claim, machine): mean over public ones
        self.rows = {}    # claim: {machine: {scene: value}}
        self.body, self.pictures = [], {}

    def claim(self, name, machine, values):
        """values: {scene: value} of the scenes that count, or one number."""
        values = values if isinstance(values, dict) else {"": values}
        self.rows.setdefault(name, {})[machine] = values
        for means, is_public in ((self.found, False), (self.apart, True)):
            own = [value for scene, value in values.items() if (scene in self.public) == is_public]
            if own:
                means[name, machine] = geometric_mean(own)

    def text(self, *paragraphs):
        for paragraph in paragraphs:
            self.body += [paragraph, ""]

    def table(self, head, rows):
        self.body += ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
        self.body += ["| " + " | ".join(c if isinstance(c, str) else shown(c) for c in row) + " |" for row in rows] + [""]

    def picture(self, name, svg, alt):
        file = f"{self.item}-{name}.svg"
        self.pictures[file] = svg
        self.body += [f"![{alt}]({file})", ""]

    def means_of(self, name, machine):
        """Means over generated scenes and over public ones, where there are such."""
        return [means[name, machine] for means in (self.found, self.apart) if (name, machine) in means]

    def cells(self, name, machine, means):
        """Mean and range, and whether the paper's number is met within 20 %."""
        mean, claim = means.get((name, machine)), self.claims[name]
        if mean is None:
            return ["–", "–"]
        values = [v for scene, v in self.rows[name][machine].items() if (scene in self.public) == (means is self.apart)]
        spread = f" ({shown(min(values))} to {shown(max(values))})" if len(values) > 1 else ""
        holds = {None: "–", True: "holds", False: "no"}[claim.holds(mean)]
        return [shown(mean) + spread, holds]

    def against(self, name):
        """Machines on which a mean goes against the paper's direction."""
        return [m for m in self.rows[name] if False in [self.claims[name].direction(value) for value in self.means_of(name, m)]]

    def direction(self, name):
        """What is against the paper's direction, and what goes with it where the paper prints no number."""
        claim, against = self.claims[name], self.against(name)
        if against:
            return "**against**" + ("" if len(against) == len(self.rows[name]) else " on " + ", ".join(f"`{m}`" for m in against))
        return "with" if claim.paper is None and (claim.above is not None or claim.below is not None) else "–"

    def cause(self, name):
        """Why ours differs where number or direction does; each cause once, those behind the first with their machine."""
        claim, said = self.claims[name], {}
        for machine in self.rows[name]:
            if False in [claim.holds(value) for value in self.means_of(name, machine)] or machine in self.against(name):
                said.setdefault(claim.cause(machine), machine)
        return " ".join(cause if place == 0 else f"`{machine}`: {cause}" for place, (cause, machine) in enumerate(said.items()))

    def machines(self):
        """Of the section, in the order of its claims."""
        return list(dict.fromkeys(machine for machines in self.rows.values() for machine in machines))

    def claim_rows(self):
        for name in self.rows:
            claim = self.claims[name]
            cells = [cell for machine in self.machines() for means in ((self.found, self.apart) if self.public else (self.found,))
                     for cell in self.cells(name, machine, means)]
            yield [f"`{name}`", claim.what, "–" if claim.paper is None else ("≥ " if claim.bound else "") + shown(claim.paper),
                   *cells, self.direction(name), self.cause(name)]

    def claim_head(self):
        means = [head for machine in self.machines() for kind in (("", ", public scenes") if self.public else ("",))
                 for head in (f"`{machine}`{kind}", "within 20 %")]
        return ["claim", "figure", "the paper", *means, "direction", "why they differ"]

    def unlike_record(self):
        """{machine: claims whose value there is not as recorded}."""
        found = {}
        for (name, machine), value in self.found.items():
            if self.expected is not None and self.expected.same(self.which, machine, self.claims[name], value) is False:
                found.setdefault(machine, []).append(f"`{name}`")
        return found

    def claim_table(self):
        block = Page(self.item, "", self.claims, self.which)
        block.table(self.claim_head(), list(self.claim_rows()))
        for machine, names in self.unlike_record().items():
            block.text(f"**Not as recorded** on `{machine}`: {', '.join(names)}.")
        return block.body

    def section(self):
        """Its part of a page: what an item calls ## is ### there."""
        lines = [f"## {self.title}", "", *(self.claim_table() if self.rows else []), *[re.sub("^## ", "### ", line) for line in self.body]]
        return docs_prose.wrap("\n".join(lines).rstrip("\n") + "\n")


def write_pages(folder, pages, command, model):
    """The pages that hold these sections (items.PAGES). Sections that were not run stay, where the page is of the same command
    and model; else the page is of these alone."""
    for file, title, names in items.PAGES:
        own = {one.title: one for one in pages if one.item in names}
        if not own:
            continue
        which = next(iter(own.values())).which
        head = "\n".join([f"# {title}", "", *stamp(command, model, f"the {which} set ([README.md](README.md)); tables and pictures of machine `paper`", "../"), "", ""])
        path = os.path.join(folder, file)
        sections = {}
        if os.path.exists(path):
            with open(path, encoding="utf-8") as old:
                before = old.read()
            if before.startswith(head):
                sections = {part.split("\n", 1)[0][3:]: part for part in re.split(r"^(?=## )", before[len(head):], flags=re.M)}
        for one in own.values():
            sections[one.title] = one.section()
            for picture, svg in one.pictures.items():
                write(os.path.join(folder, picture), svg)
        titles = [items.ITEMS[name].TITLE for name in names]
        write(path, head + "\n".join(sections[t].rstrip("\n") + "\n" for t in titles if t in sections))


def stamp(command, model, assumes, up):
    """Where the page's figures are from (scripts/model_version.py). Without a date: the same results give the same bytes."""
    return ["| | |", "|---|---|", f"| command | `{command}` |", f"| model version | {model} |",
            f"| machine | [any]({up}README.md#machine-classes): counts, the same on every host |", f"| assumes | {assumes} |"]


def write(path, text):
    """The old bytes or the new ones."""
    with open(path + ".partial", "w", encoding="utf-8") as file:
        file.write(text)
    os.replace(path + ".partial", path)


def tally(pages):
    """{machine: (claims with a printed number, those that hold)}, over generated scenes."""
    counts = {}
    for one in pages:
        for (name, machine), value in one.found.items():
            holds = one.claims[name].holds(value)
            if holds is not None:
                known, held = counts.get(machine, (0, 0))
                counts[machine] = (known + 1, held + holds)
    return counts


def page_row(one, machines):
    """Printed figures that hold, by machine, and claims whose direction is not the paper's."""
    counts = {machine: tally([one]).get(machine) for machine in machines}
    against = {f"`{name}`" for name in one.rows if one.against(name)}
    place = re.sub(r"[^\w\- ]", "", one.title.lower()).replace(" ", "-")
    return [f"[{one.title}]({items.PAGE_OF[one.item]}#{place})", *["{1} of {0}".format(*c) if c else "–" for c in counts.values()], ", ".join(sorted(against)) or "–"]


def write_index(folder, study, pages, claims, machines, command, model):
    """README.md: what was run, and how many claims of each section hold; values.csv: every value behind a mean."""
    lines = ["# The paper, figure by figure", "",
             *stamp(command, model, f"the {study.name} set: scenes and frames below; cycle mode; machines " + ", ".join(f"`{m}`" for m in machines), "../"), "",
             "Of the figures that the paper prints, " + "; ".join(f"{held} of {known} hold on `{machine}`" for machine, (known, held) in
                                                                 tally(pages).items()) + ".", "",
             "A mean is geometric over the scenes of the evaluation, with its range in brackets. *Within 20 %*: `holds` where the paper prints a number and ours is "
             "within 20 % of it (of a bound: beyond it). *Direction*: ours goes with what the paper says without a number; *against* is said beside a number, too. What is "
             "not as recorded is named below its table. Where the paper says what: [claims.toml](../../../bench/paper/claims.toml). Commands and tolerances: "
             "[ARTIFACT.md](../../../ARTIFACT.md). Values of each scene: [values.csv](values.csv).", ""]
    table = Page("", "", claims, study.name)
    roles = {"evaluation": "evaluation", "public": "public, a mean of its own", "shown": "shown, in no mean"}
    table.table(["scene", "Gaussians", "from", "role"],
                [[s.name, f"{s.count:,}" if s.preset else "trained", f"`{s.preset}`, seed {s.seed}, SH {s.sh_degree}" if s.preset
                  else f"`{s.file}`", roles[s.role]] for s in study.scenes])
    table.table(["frame", "pixels", "factor on the field of view", "GPU"],
                [[name, f"{f.width} × {f.height}", str(f.fov_scale), ", ".join(f"`{k}={v}`" for k, v in f.keys) or "whole"]
                 for name, f in study.frames.items()])
    table.text("The generated scenes are of the class of the paper's ([scene classes](../scene-classes.md)), and played no part in the "
               "[fit](../readings.md#fitted-jointly) of `paper`. That machine takes checkpoint traffic as free, `paper-charged` charges every byte of it. Nothing else differs.")
    lines += table.body
    lines += ["## Sections", ""]
    table = Page("", "", claims, study.name)
    table.table(["section", *[f"hold on `{m}`" for m in machines], "against the paper's direction"], [page_row(one, machines) for one in pages])
    lines += table.body
    lines += ["## Not reproduced", "",
              "Rasterisation, OptiX and what was measured on an RTX 5090 and an RX 9070 XT are of real GPUs. The paper's own copies of its six scenes are not public "
              "([ARTIFACT.md](../../../ARTIFACT.md#scenes)).", ""]
    write(os.path.join(folder, "README.md"), docs_prose.wrap("\n".join(lines)))
    rows = ["claim,machine,scene,value"]
    for one in pages:
        rows += [f"{name},{machine},{scene},{value:.6g}" for name, machines_of in one.rows.items()
                 for machine, values in machines_of.items() for scene, value in values.items()]
    write(os.path.join(folder, "values.csv"), "\n".join(rows) + "\n")
