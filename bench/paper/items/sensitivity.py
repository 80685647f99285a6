# SPDX-License-Identifier: Apache-2.0
"""Sensitivity: k of grtx, field of view, resolution."""
from .. import figures
from ..study import Frame, geometric_mean

TITLE = "Sensitivity: k, field of view, resolution"
KS = (4, 8, 16, 32)
DESIGNS = ("sw", "hw", "grtx")
HIT_RATE = "gpu.l1.node.hit_rate"
COLUMNS = [*DESIGNS, *(f"L1, {d}" for d in ("baseline", *DESIGNS))]


def build(study, page):
    machines = study.values["side_machines"]
    page.text("## k of grtx",
              "Stragglers show as SIMT efficiency that falls with k. What smaller k costs besides is in the checkpoint entries written: each is two transfers of private data.")
    for machine in machines:
        buffer_sizes(study, page, machine)
    page.text("## Field of view",
              "The same number of pixels over a smaller field of view: rays lie closer. *As dense as* is the width of a whole image with that density.")
    for machine in machines:
        fields_of_view(study, page, machine)
    if study.values["resolutions"]:  # part of the full set
        page.text("## Resolution")
        for machine in machines:
            resolutions(study, page, machine)


def buffer_sizes(study, page, machine):
    found = {(s.name, k): study.point(s, "grtx", machine, t_k=k) for s in study.scenes for k in KS}
    cycles = {at: v["gpu.cycles"] for at, v in found.items()}
    page.claim("best-k-grtx", machine, {s.name: min(KS, key=lambda k: cycles[s.name, k]) for s in study.counted})
    page.claim("grtx-k8-over-k4", machine, {s.name: cycles[s.name, 4] / cycles[s.name, 8] for s in study.counted})
    if machine != study.values["side_machines"][0]:
        return
    curves = {s.name: [cycles[s.name, 4] / cycles[s.name, k] for k in KS] for s in study.scenes}
    page.picture(f"k-{machine}", figures.lines(f"grtx: speed over k = 4, machine {machine}", [str(k) for k in KS], curves, "k",
                                               "speed ÷ speed at 4", {"paper's best": KS.index(8)}), "Speed of grtx over k, a line for each scene")
    mean = lambda k, statistic: geometric_mean(found[s.name, k][statistic] for s in study.evaluation)
    page.table(["k, mean", "M cycles", "rounds of warps", "SIMT efficiency", "M entries written"],
               [[str(k), mean(k, "gpu.cycles") / 1e6, mean(k, "gpu.simt.rounds"), mean(k, "gpu.rt.simt_efficiency"),
                 mean(k, "gpu.rt.checkpoint.entries_written") / 1e6] for k in KS])


def fields_of_view(study, page, machine):
    side = study.frames["side"]
    scenes = [s for s in study.scenes if s.name in study.values["fov_scenes"] or s.role == "public"]
    first = machine == study.values["side_machines"][0]
    scales = study.values["fov_scales"] if first else study.values["fov_scales"][::max(1, len(study.values["fov_scales"]) - 1)]  # the ends
    found = {(scale, s.name): designs_at(study, s, machine, Frame(side.width, side.height, scale, side.keys)) for scale in scales for s in scenes}
    for d in DESIGNS:
        page.claim(f"small-fov-{d}", machine, {s.name: found[scales[-1], s.name][d] for s in scenes})
    for d in ("sw", "hw"):
        page.claim(f"fov-trend-{d}", machine, {s.name: found[scales[-1], s.name][d] / found[scales[0], s.name][d] for s in scenes})
    if not first:
        return
    dense = {scale: f"{side.width / scale:.0f}" for scale in scales}
    mean = {scale: {c: geometric_mean(found[scale, s.name][c] for s in scenes if s.role == "evaluation") for c in COLUMNS} for scale in scales}
    page.picture(f"fov-{machine}", figures.lines(f"Speed-up over density, machine {machine}", list(dense.values()),
                                                 {d: [row[d] for row in mean.values()] for d in DESIGNS}, "as dense as an image of this width",
                                                 "speed-up, mean"), "Speed-up over the density of rays")
    over = " and ".join(s.name for s in scenes if s.role == "evaluation")
    page.table([f"as dense as, mean of {over}", *COLUMNS], [[dense[scale], *row.values()] for scale, row in mean.items()])


def designs_at(study, scene, machine, frame):
    """Speed-ups over the baseline, and L1 hit rates, by column."""
    at = {d: study.point(scene, d, machine, frame) for d in ("baseline", *DESIGNS)}
    return {**{d: at["baseline"]["gpu.cycles"] / at[d]["gpu.cycles"] for d in DESIGNS}, **{f"L1, {d}": v[HIT_RATE] for d, v in at.items()}}


def resolutions(study, page, machine):
    rows = []
    for scene in [s for s in study.scenes if s.name in study.values["resolution_scenes"]]:
        for width, height in study.values["resolutions"]:
            found = designs_at(study, scene, machine, Frame(width, height, 1.0, study.frames["main"].keys))
            rows.append([scene.name, f"{width} × {height}", *[found[c] for c in COLUMNS]])
        page.claim("high-resolution-sw", machine, found["sw"])
    if machine == study.values["side_machines"][0]:
        page.table(["scene", "pixels", *COLUMNS], rows)
