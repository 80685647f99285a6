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


def speedups(study, scene, machine, mode="sampled", frame="main", **options):
    cycles = {d: study.point(scene, d, machine, frame, mode, **options)["gpu.cycles"] for d in ("baseline", *DESIGNS)}
    return {d: cycles["baseline"] / cycles[d] for d in DESIGNS}


def build(study, page):
    machines = study.values["machines"]
    means = main_comparison(study, page, machines)
    readings(study, page, machines, means)
    orders(study, page)
    confirmation(study, page)
    proxies(study, page)


def main_comparison(study, page, machines):
    page.text("## The main comparison: k = 8, threshold 0.001")
    marks = {d: page.claims[f"speedup-{d}"].paper for d in DESIGNS}
    means = {}
    for machine in machines:
        rows = {s.name: speedups(study, s, machine) for s in study.scenes}
        for design in DESIGNS:
            page.claim(f"speedup-{design}", machine, {s.name: rows[s.name][design] for s in study.counted})
            means[machine, 8, 0.001, design] = geometric_mean(rows[s.name][design] for s in study.evaluation)
        page.claim("grtx-over-best", machine,
                   {s.name: rows[s.name]["grtx"] / max(rows[s.name]["sw"], rows[s.name]["hw"]) for s in study.counted})
        groups = list(rows.items()) + [("mean of the generated", {d: means[machine, 8, 0.001, d] for d in DESIGNS})]
        page.picture(f"main-{machine}", figures.bars(f"Speed-up over the baseline, machine {machine}", groups, list(DESIGNS), marks,
                                                     base=1.0), f"Speed-up of sw, hw and grtx on machine {machine}, by scene")
    return means


def readings(study, page, machines, means):
    page.text("## k and the threshold of early termination",
              "The paper states neither for its main comparison. Means over the scenes of the evaluation; *distance* is the root mean squared log "
              "ratio to the paper's three speed-ups. Baseline and designs have the same k; the last two columns let baseline, sw and grtx keep their better one.")
    rows = []
    for machine in machines:
        cycles = {}
        for k, ert in READINGS:
            own = {s.name: speedups(study, s, machine, t_k=k, t_ert=ert) for s in study.evaluation}
            cycles[k, ert] = {(s.name, d): study.point(s, d, machine, "main", t_k=k, t_ert=ert)["gpu.cycles"]
                              for s in study.evaluation for d in ("baseline", "sw", "grtx")}
            for design in DESIGNS:
                means[machine, k, ert, design] = geometric_mean(r[design] for r in own.values())
        for k, ert in READINGS:
            row = [means[machine, k, ert, d] for d in DESIGNS]
            distance = root_mean_square_log(row, [page.claims[f"speedup-{d}"].paper for d in DESIGNS])
            better = {(s.name, d): min(cycles[8, ert][s.name, d], cycles[16, ert][s.name, d])
                      for s in study.evaluation for d in ("baseline", "sw", "grtx")}
            fair = [geometric_mean(better[s.name, d] / better[s.name, "grtx"] for s in study.evaluation) for d in ("baseline", "sw")]
            rows.append([machine, str(k), str(ert), *row, distance, *fair])
        at = lambda k, ert: means[machine, k, ert, "grtx"]
        page.claim("grtx-k16-over-k8", machine, at(16, 0.001) / at(8, 0.001))
        page.claim("grtx-ert03-over-ert001", machine, at(8, 0.03) / at(8, 0.001))
    page.table(["machine", "k", "threshold", "sw", "hw", "grtx", "distance", "grtx over the baseline, each at its better k",
                "grtx over sw, each at its better k"], rows)
    best = {m: min((r for r in rows if r[0] == m), key=lambda r: r[6]) for m in machines}
    page.text("Nearest to the paper: " + "; ".join(f"`{m}` at k = {r[1]}, threshold {r[2]}" for m, r in best.items()) + ".")


def orders(study, page):
    page.text("## Order of children",
              "The paper does not state the order in which a node's hit children are visited. `paper` has the order of their slots; sorted children (`near_first`) "
              "spare the baseline most visits, so every ratio to it falls. Means over the generated scenes.")
    rows = []
    for machine in study.values["side_machines"]:
        slot = {s.name: speedups(study, s, machine) for s in study.evaluation}
        near = {s.name: speedups(study, s, machine, t_child_order="near_first") for s in study.evaluation}
        for name, found in (("slot", slot), ("near_first", near)):
            rows.append([machine, name, *[geometric_mean(row[d] for row in found.values()) for d in DESIGNS]])
        page.claim("grtx-sorted-over-slot", machine, {name: near[name]["grtx"] / slot[name]["grtx"] for name in slot})
    page.table(["machine", "order", *DESIGNS], rows)


def root_mean_square_log(ours, paper):
    return math.sqrt(sum(math.log(a / b) ** 2 for a, b in zip(ours, paper)) / len(paper))


def confirmation(study, page):
    page.text("## Cycle by cycle",
              "The figures above are of sampled mode. The same comparison simulated cycle by cycle, on frame *side*:")
    rows = []
    for scene in study.scenes:
        if scene.name not in study.values["confirm"]:
            continue
        sampled, cycle = (speedups(study, scene, "paper", mode, "side") for mode in ("sampled", "cycle"))
        for design in DESIGNS:
            rows.append([scene.name, design, sampled[design], cycle[design], f"{100 * (sampled[design] / cycle[design] - 1):+.1f} %"])
    page.table(["scene", "design", "sampled", "cycle", "sampled against cycle"], rows)


def proxies(study, page):
    most = study.values["proxy_gaussians"]
    scenes = [replace(s, count=min(s.count, most)) for s in study.scenes if s.preset]
    page.text("## Other proxies",
              f"Generated scenes of at most {most:,} Gaussians of the same seeds: 80 triangles each of more do not fit into a workstation's memory. "
              "Speed over the baseline (20 triangles a Gaussian, k = 8, no checkpointing), and bytes of the structure a Gaussian. The paper "
              "measured its proxies on GPUs and gives the range of TLAS over the monolithic structure.")
    for machine in study.values["side_machines"][:1]:  # none has checkpoints
        groups, rows, shared = [], [], {}
        for scene in scenes:
            base = study.point(scene, "baseline", machine)["gpu.cycles"]
            cycles = {p: study.point(scene, p, machine)["gpu.cycles"] for p in ("tri20", "tlas-tri20", *PROXIES)}
            groups.append((scene.name, {p: base / c for p, c in cycles.items() if p != "tri20"}))
            sizes = {p: study.measure(scene, p, machine, ONE_RAY) for p in ("tri20", "tlas-tri20", *PROXIES)}
            for p, c in cycles.items():
                rows.append([scene.name, p, base / c, sizes[p]["accel.bytes_per_gaussian"], sizes[p]["accel.bytes"] / 2**20])
            shared[scene.name] = cycles
        for name, over, of in [("tlas-tri80-over-tri80", "tri80", "tlas-tri80"), ("ellipsoid-over-tri20", "tri20", "ellipsoid"),
                               ("sphere-over-tri20", "tri20", "tlas-sphere")]:
            page.claim(name, machine, {s.name: shared[s.name][over] / shared[s.name][of] for s in scenes if s.role == "evaluation"})
        page.picture(f"proxies-{machine}", figures.bars(f"Proxies: speed over 20 triangles, machine {machine}", groups,
                                                        ["tlas-tri20", *PROXIES], base=1.0), "Speed of each proxy over the baseline, by scene")
        page.table(["scene", "structure", "speed over baseline", "B a Gaussian", "MiB"], rows)
