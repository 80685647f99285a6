"""Pages in Markdown. The same results give the same bytes: no date, host or time."""
import os

from . import figures
from .study import geometric_mean


def shown(value):
    return figures.number(value)


class Page:
    """One item: claims with their values, tables, pictures, sentences."""

    def __init__(self, item, title, claims, which):
        self.item, self.title, self.claims, self.which = item, title, claims, which
        self.found = {}   # (claim, machine): mean
        self.rows = {}    # claim: {machine: {scene: value}}
        self.body, self.pictures = [], {}

    def claim(self, name, machine, values):
        """values: {scene: value} of the scenes that count, or one number."""
        values = values if isinstance(values, dict) else {"": values}
        self.rows.setdefault(name, {})[machine] = values
        self.found[name, machine] = geometric_mean(values.values())

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

    def cell(self, name, machine):
        values = self.rows[name].get(machine)
        if values is None:
            return "–", "–"
        mean, claim = self.found[name, machine], self.claims[name]
        spread = f" ({shown(min(values.values()))} to {shown(max(values.values()))})" if len(values) > 1 else ""
        ratio = shown(mean / claim.paper) if claim.paper else "–"
        return shown(mean) + spread, ratio

    def direction(self, name):
        """Whether the paper's direction holds, on which machines not."""
        held = {m: self.claims[name].direction(self.found[name, m]) for m in self.rows[name]}
        if None in held.values():
            return "–"
        against = [f"`{m}`" for m, holds in held.items() if not holds]
        return "**exception** on " + ", ".join(against) if against else "holds"

    def claim_rows(self, machines):
        for name in self.rows:
            claim = self.claims[name]
            paper = "–" if claim.paper is None else ("≥ " if claim.bound else "") + shown(claim.paper)
            cells = [c for m in machines for c in self.cell(name, m)]
            yield [f"`{name}`", claim.what, paper, *cells, self.direction(name), claim.why]

    def claim_head(self, machines):
        return ["claim", "figure", "paper", *[h for m in machines for h in (f"`{m}`: mean (range)", "ours ÷ paper")],
                "the paper's direction", "why they differ"]

    def markdown(self, machines, command):
        lines = [f"# {self.title}", "", f"The {self.which} set. `{command}`", ""]
        if self.rows:
            block = Page(self.item, "", self.claims, self.which)
            block.table(self.claim_head(machines), list(self.claim_rows(machines)))
            lines += ["## Claims", ""] + block.body
            sources = {self.claims[n].what: self.claims[n].source for n in self.rows}
            lines += ["Places in the paper: " + "; ".join(f"{what}: {source}" for what, source in sources.items()) + ".", ""]
        return "\n".join(lines + self.body).rstrip("\n") + "\n"

    def write(self, folder, machines, command):
        for file, svg in self.pictures.items():
            write(os.path.join(folder, file), svg)
        write(os.path.join(folder, f"paper-{self.item}.md"), self.markdown(machines, command))


def write(path, text):
    """The old bytes or the new ones."""
    with open(path + ".partial", "w", encoding="utf-8") as file:
        file.write(text)
    os.replace(path + ".partial", path)


def write_index(folder, study, pages, claims, machines, command):
    """README.md: what was run, and every claim; values.csv: every value behind a mean."""
    lines = ["# The paper, figure by figure", "",
             f"Made by `{command}`: the {study.name} set, fast mode unless a page says otherwise, machines "
             + " and ".join(f"`{m}`" for m in machines) + ". A mean is geometric over the scenes of the evaluation. "
             "Claims, tolerances and commands: [ARTIFACT.md](../../../ARTIFACT.md).", ""]
    table = Page("", "", claims, study.name)
    table.table(["scene", "Gaussians", "from", "role"],
                [[s.name, f"{s.count:,}" if s.preset else "trained", f"`{s.preset}`, seed {s.seed}, SH {s.sh_degree}" if s.preset
                  else f"`{s.file}`", "evaluation" if s.role == "evaluation" else "used in fitting, in no mean"] for s in study.scenes])
    table.table(["frame", "pixels", "factor on the field of view", "GPU"],
                [[name, f"{f.width} × {f.height}", str(f.fov_scale), ", ".join(f"`{k}={v}`" for k, v in f.keys) or "whole"]
                 for name, f in study.frames.items()])
    table.text("The machine `paper` was chosen on playbot, pizza, logo, st-peter and `dense_indoor` seed 1 ([readings.md](../readings.md)): child "
               "order `slot`, pop test `on`, one sector a cycle, private writes through. Nothing else was fitted, and none of these scenes is in a mean.")
    lines += table.body
    for one in pages:
        if one.rows:
            block = Page("", "", claims, study.name)
            block.table(one.claim_head(machines), list(one.claim_rows(machines)))
            lines += [f"## [{one.title}](paper-{one.item}.md)", ""] + block.body
        else:
            lines += [f"## [{one.title}](paper-{one.item}.md)", ""]
    lines += ["## Not reproduced", "",
              "Rasterisation against ray tracing, OptiX against Vulkan and the measurements on an RTX 5090 and an RX 9070 XT are of real GPUs: no model here. "
              "The paper's six trained scenes are not public.", ""]
    write(os.path.join(folder, "README.md"), "\n".join(lines))
    rows = ["claim,machine,scene,value"]
    for one in pages:
        rows += [f"{name},{machine},{scene},{value:.6g}" for name, machines_of in one.rows.items()
                 for machine, values in machines_of.items() for scene, value in values.items()]
    write(os.path.join(folder, "values.csv"), "\n".join(rows) + "\n")
