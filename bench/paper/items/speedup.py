# SPDX-License-Identifier: Apache-2.0
"""The main comparison, at both k and both thresholds; other proxies."""
import math
from dataclasses import replace

from .. import figures
from ..study import Frame, geometric_mean

TITLE = "Speed-up of sw, hw and grtx"
DESIGNS = ("sw", "hw", "grtx")
READINGS = [(8, 0.001), (8, 0.03), (16, 0.001), (16, 0.03)]
ONE_RAY = Frame(1, 1, 1.0)  # sizes do not depend on rays
PROXIES = ["tri80", "tlas-tri80", "ellipsoid", "tlas-sphere"]


def speedups(study, scene, machine, frame="main", **options):
    cycles = {d: study.point(scene, d, machine, frame, **options)["gpu.cycles"] for d in ("baseline", *DESIGNS)}
    return {d: cycles["baseline"] / cycles[d] for d in DESIGNS}


def build(study, page):
    machines = study.values["machines"]
    main_comparison(study, page, machines)
    readings(study, page, machines)
    orders(study, page)
    proxies(study, page)


def main_comparison(study, page, machines):
    page.text("## The main comparison: k = 8, threshold 0.001")
    marks = {d: page.claims[f"speedup-{d}"].paper for d in DESIGNS}
    for machine in machines:
        rows = {s.name: speedups(study, s, machine) for s in study.scenes}
        for design in DESIGNS:
            page.claim(f"speedup-{design}", machine, {s.name: rows[s.name][design] for s in study.counted})
        page.claim("grtx-over-best", machine,
                   {s.name: rows[s.name]["grtx"] / max(rows[s.name]["sw"], rows[s.name]["hw"]) for s in study.counted})
        if machine != machines[0]:
            continue
        groups = list(rows.items()) + [("mean of the generated", {d: geometric_mean(rows[s.name][d] for s in study.evaluation) for d in DESIGNS})]
        page.picture(f"main-{machine}", figures.bars(f"Speed-up over the baseline, machine {machine}", groups, list(DESIGNS), marks,
                                                     base=1.0), f"Speed-up of sw, hw and grtx on machine {machine}, by scene")


def readings(study, page, machines):
    page.text("## k and the threshold of early termination",
              "The paper states neither for its main comparison. Means over the scenes of the evaluation; *distance* is the root mean squared log "
              "ratio to the paper's three speed-ups. Baseline and designs have the same k; the last two columns let each keep its better one.")
    rows, best = [], {}
    for machine in machines:
        means = {}
        for k, ert in READINGS:
            own = [speedups(study, s, machine, t_k=k, t_ert=ert) for s in study.evaluation]
            means[k, ert] = [geometric_mean(row[design] for row in own) for design in DESIGNS]
        distance = {at: root_mean_square_log(row, [page.claims[f"speedup-{d}"].paper for d in DESIGNS]) for at, row in means.items()}
        best[machine] = min(distance, key=distance.get)
        if machine == machines[0]:
            rows = [[str(k), str(ert), *row, distance[k, ert], *at_better_k(study, machine, ert)] for (k, ert), row in means.items()]
        at = lambda k, ert: means[k, ert][DESIGNS.index("grtx")]
        page.claim("grtx-k16-over-k8", machine, at(16, 0.001) / at(8, 0.001))
        page.claim("grtx-ert03-over-ert001", machine, at(8, 0.03) / at(8, 0.001))
    page.table(["k", "threshold", *DESIGNS, "distance", "grtx over baseline, better k", "grtx over sw, better k"], rows)
    page.text("Nearest to the paper: " + "; ".join(f"`{m}` at k = {k}, threshold {ert}" for m, (k, ert) in best.items()) + ".")


def at_better_k(study, machine, ert):
    """Mean speed of grtx over baseline and over sw, each at the k, of 8 and 16, that is better for it on the scene."""
    better = {(s.name, d): min(study.point(s, d, machine, "main", t_k=k, t_ert=ert)["gpu.cycles"] for k in (8, 16))
              for s in study.evaluation for d in ("baseline", "sw", "grtx")}
    return [geometric_mean(better[s.name, d] / better[s.name, "grtx"] for s in study.evaluation) for d in ("baseline", "sw")]


def orders(study, page):
    page.text("## Order of children",
              "The paper does not state the order in which a node's hit children are visited. `paper` has the order of their slots; sorted children (`near_first`) "
              "spare the baseline most visits, so every ratio to it falls. Means over the generated scenes.")
    machines, rows = study.values["side_machines"], []
    for machine in machines:
        orders = {order: {s.name: speedups(study, s, machine, **options) for s in study.evaluation}
                  for order, options in (("slot", {}), ("near_first", {"t_child_order": "near_first"}))}
        page.claim("grtx-sorted-over-slot", machine, {name: row["grtx"] / orders["slot"][name]["grtx"] for name, row in orders["near_first"].items()})
        if machine == machines[0]:
            rows = [[order, *[geometric_mean(row[d] for row in found.values()) for d in DESIGNS]] for order, found in orders.items()]
    page.table(["order", *DESIGNS], rows)


def root_mean_square_log(ours, paper):
    return math.sqrt(sum(math.log(a / b) ** 2 for a, b in zip(ours, paper)) / len(paper))


def proxies(study, page):
    most = study.values["proxy_gaussians"]
    scenes = [replace(s, count=min(s.count, most)) for s in study.scenes if s.preset]
    machine = study.values["side_machines"][0]  # none has checkpoints
    page.text("## Other proxies",
              f"Generated scenes of at most {most:,} Gaussians of the same seeds: 80 triangles each of more do not fit into a workstation's memory. "
              "Speed over the baseline, and bytes of the structure per Gaussian, in the mean. The paper measured its proxies on GPUs.")
    cycles = {s.name: {p: study.point(s, p, machine)["gpu.cycles"] for p in ("tri20", "tlas-tri20", *PROXIES)} for s in scenes}
    speed = {name: {p: row["tri20"] / c for p, c in row.items() if p != "tri20"} for name, row in cycles.items()}
    for name, over, of in [("tlas-tri80-over-tri80", "tri80", "tlas-tri80"), ("ellipsoid-over-tri20", "tri20", "ellipsoid"),
                           ("sphere-over-tri20", "tri20", "tlas-sphere")]:
        page.claim(name, machine, {s.name: cycles[s.name][over] / cycles[s.name][of] for s in scenes if s.role == "evaluation"})
    page.picture(f"proxies-{machine}", figures.bars(f"Proxies: speed over 20 triangles, machine {machine}", list(speed.items()),
                                                    ["tlas-tri20", *PROXIES], base=1.0), "Speed of each proxy over the baseline, by scene")
    page.table(["structure", "speed over baseline", "B per Gaussian"],
               [[p, geometric_mean(row["tri20"] / row[p] for row in cycles.values()),
                 geometric_mean(study.measure(s, p, machine, ONE_RAY)["accel.bytes_per_gaussian"] for s in scenes)]
                for p in ("tri20", "tlas-tri20", *PROXIES)])
