# SPDX-License-Identifier: Apache-2.0
"""Sensitivity: k of grtx, field of view, resolution."""
from .. import figures
from ..study import Frame, geometric_mean

TITLE = "Sensitivity: k, field of view, resolution"
KS = (4, 8, 16, 32)
DESIGNS = ("sw", "hw", "grtx")
HIT_RATE = "gpu.l1.node.hit_rate"


def build(study, page):
    machines = study.values["side_machines"]
    page.text("## k of grtx",
              "Stragglers show as SIMT efficiency that falls with k. What smaller k costs besides is in the entries written: each is two transfers of private data.")
    for machine in machines:
        buffer_sizes(study, page, machine)
    page.text("## Field of view",
              "The same number of pixels over a smaller field of view: rays lie closer. *As dense as* is the width of a whole image with that density.")
    for machine in machines:
        fields_of_view(study, page, machine)
    if study.values["resolutions"]:
        page.text("## Resolution")
    for machine in machines:
        resolutions(study, page, machine)


def buffer_sizes(study, page, machine):
    curves, rows, best, four = {}, [], {}, {}
    for scene in study.scenes:
        found = {k: study.point(scene, "grtx", machine, t_k=k) for k in KS}
        cycles = {k: v["gpu.cycles"] for k, v in found.items()}
        curves[scene.name] = [cycles[4] / cycles[k] for k in KS]
        for k, v in found.items():
            rows.append([scene.name, str(k), v["gpu.cycles"] / 1e6, cycles[4] / v["gpu.cycles"], f'{v["gpu.simt.rounds"]:,.0f}',
                         v["gpu.rt.simt_efficiency"], f'{v["gpu.rt.checkpoint.entries_written"]:,.0f}',
                         (v["gpu.l2.dram_reads.checkpoint"] + v["gpu.l2.dram_writes.checkpoint"]) / max(1, v["gpu.l2.dram_reads"])])
        if scene in study.counted:
            best[scene.name] = min(KS, key=cycles.get)
            four[scene.name] = cycles[4] / cycles[8]
    page.claim("best-k-grtx", machine, best)
    page.claim("grtx-k8-over-k4", machine, four)
    page.picture(f"k-{machine}", figures.lines(f"grtx: speed over k = 4, machine {machine}", [str(k) for k in KS], curves, "k",
                                               "speed ÷ speed at 4", {"paper's best": KS.index(8)}), "Speed of grtx over k, a line a scene")
    page.text(f"Machine `{machine}`:")
    page.table(["scene", "k", "M cycles", "speed over k = 4", "rounds of warps", "SIMT efficiency", "checkpoint entries written",
                "checkpoint sectors to and from DRAM ÷ DRAM reads"], rows)


def fields_of_view(study, page, machine):
    side = study.frames["side"]
    scenes = [s for s in study.scenes if s.name in study.values["fov_scenes"] or s.role == "public"]
    speeds = {}
    scales = study.values["fov_scales"]
    dense = [f"{side.width / scale:.0f}" for scale in scales]
    curves, hits, rows = {d: [] for d in DESIGNS}, {"baseline": [], "sw": []}, []
    for scale, width in zip(scales, dense):
        frame = Frame(side.width, side.height, scale, side.keys)
        found = {(s.name, d): study.point(s, d, machine, frame) for s in scenes for d in ("baseline", *DESIGNS)}
        speed = {(s.name, d): found[s.name, "baseline"]["gpu.cycles"] / found[s.name, d]["gpu.cycles"]
                 for s in scenes for d in DESIGNS}
        speeds[scale] = speed
        for d in DESIGNS:
            curves[d].append(geometric_mean(speed[s.name, d] for s in scenes))
        for d in hits:
            hits[d].append(geometric_mean(found[s.name, d][HIT_RATE] for s in scenes))
        for s in scenes:
            rows.append([s.name, width, *[speed[s.name, d] for d in DESIGNS],
                         *[found[s.name, d][HIT_RATE] for d in ("baseline", *DESIGNS)]])
            if scale == scales[-1] and s is scenes[-1]:
                for d in ("sw", "hw", "grtx"):
                    page.claim(f"small-fov-{d}", machine, {t.name: speed[t.name, d] for t in scenes})
    for d in ("sw", "hw"):
        page.claim(f"fov-trend-{d}", machine, {s.name: speeds[scales[-1]][s.name, d] / speeds[scales[0]][s.name, d] for s in scenes})
    page.picture(f"fov-{machine}", figures.lines(f"Speed-up over density, machine {machine}", dense, curves,
                                                 "as dense as an image of this width", "speed-up, mean"), "Speed-up over the density of rays")
    page.picture(f"fov-l1-{machine}", figures.lines(f"L1 hit rate over density, machine {machine}", dense, hits,
                                                    "as dense as an image of this width", "L1 hit rate of node fetches, mean"),
                 "L1 hit rate of baseline and sw over the density of rays")
    page.text(f"Machine `{machine}`:")
    page.table(["scene", "as dense as", *DESIGNS, *[f"L1, {d}" for d in ("baseline", *DESIGNS)]], rows)


def resolutions(study, page, machine):
    sizes = study.values["resolutions"]
    if not sizes:  # part of the full set
        return
    keys = study.frames["main"].keys
    rows = []
    for scene in study.scenes:
        if scene.name not in study.values["resolution_scenes"]:
            continue
        for width, height in sizes:
            found = {d: study.point(scene, d, machine, Frame(width, height, 1.0, keys)) for d in ("baseline", *DESIGNS)}
            speed = {d: found["baseline"]["gpu.cycles"] / found[d]["gpu.cycles"] for d in DESIGNS}
            rows.append([scene.name, f"{width} × {height}", *[speed[d] for d in DESIGNS],
                         *[found[d][HIT_RATE] for d in ("baseline", *DESIGNS)]])
            if [width, height] == sizes[-1]:
                page.claim("high-resolution-sw", machine, speed["sw"])
    page.text(f"Machine `{machine}`:")
    page.table(["scene", "pixels", *DESIGNS, *[f"L1, {d}" for d in ("baseline", *DESIGNS)]], rows)
