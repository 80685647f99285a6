# SPDX-License-Identifier: Apache-2.0
"""Where the gain comes from: node fetches, their latency, L1 and L2; the sibling prefetcher."""
from .. import figures
from ..study import structure

TITLE = "Source of the gain: node fetches, latency, L1 and L2"
DESIGNS = ("sw", "hw", "grtx")
FIGURES = [("fetches", "Node fetches over the baseline's", "gpu.rt.node_fetches"),
           ("latency", "Node fetch latency over the baseline's", "gpu.rt.node_fetch_latency"),
           ("l2", "L2 accesses over the baseline's", "gpu.l2.accesses")]
CLAIMS = [("fetches-grtx", "gpu.rt.node_fetches", "baseline", "grtx"), ("fetches-hw-on-sw", "gpu.rt.node_fetches", "sw", "grtx"),
          ("latency-grtx", "gpu.rt.node_fetch_latency", "baseline", "grtx"), ("l2-grtx", "gpu.l2.accesses", "baseline", "grtx")]
HIT_RATE = "gpu.l1.node.hit_rate"


def build(study, page):
    machines = study.values["machines"]
    found = {(m, s.name, d): study.point(s, d, m, "main") for m in machines for s in study.scenes for d in ("baseline", *DESIGNS)}
    for machine in machines:
        for claim, statistic, over, of in CLAIMS:
            page.claim(claim, machine, {s.name: found[machine, s.name, over][statistic] / found[machine, s.name, of][statistic]
                                        for s in study.counted})
        page.claim("l1-sw", machine, {s.name: found[machine, s.name, "sw"][HIT_RATE] for s in study.counted})
        page.claim("l1-grtx-over-sw", machine, {s.name: found[machine, s.name, "grtx"][HIT_RATE] / found[machine, s.name, "sw"][HIT_RATE]
                                                for s in study.counted})
    for machine in machines:
        page.text(f"## Machine `{machine}`")
        for name, title, statistic in FIGURES:
            groups = [(s.name, {d: found[machine, s.name, d][statistic] / found[machine, s.name, "baseline"][statistic]
                                for d in DESIGNS}) for s in study.scenes]
            marks = {"grtx": 1 / page.claims[f"{name}-grtx"].paper}
            page.picture(f"{name}-{machine}", figures.bars(f"{title}, machine {machine}", groups, list(DESIGNS), marks, unit="", base=1.0),
                         f"{title}, by scene and design")
        groups = [(s.name, {d: found[machine, s.name, d][HIT_RATE] for d in ("baseline", *DESIGNS)}) for s in study.scenes]
        page.picture(f"l1-{machine}", figures.bars(f"L1 hit rate of node fetches, machine {machine}", groups, ["baseline", *DESIGNS],
                                                   {"sw": page.claims["l1-sw"].paper}, unit=""), "L1 hit rate, by scene and design")
        own = [d for d in ("baseline", *DESIGNS) if study.same(machine, structure(d)[1]) == machine]
        if len(own) < 4:
            page.text("Designs without checkpoints are as on the other machine.")
        page.table(["scene", "design", "node fetches", "latency, cycles", "L1 hit rate", "L2 accesses", "DRAM MB"],
                   [[s.name, d, f'{found[machine, s.name, d]["gpu.rt.node_fetches"]:,.0f}', found[machine, s.name, d]["gpu.rt.node_fetch_latency"],
                     found[machine, s.name, d][HIT_RATE], f'{found[machine, s.name, d]["gpu.l2.accesses"]:,.0f}',
                     found[machine, s.name, d]["gpu.dram.bytes"] / 1e6] for s in study.scenes for d in own])
    prefetch(study, page)


def prefetch(study, page):
    page.text("## The sibling prefetcher",
              "The paper adds it to bring the L1 hit rate nearer to that of real GPUs, and prints no figure without it.")
    rows = []
    for machine in study.values["side_machines"][:1]:
        gains = {}
        for scene in study.scenes:
            for design in ("baseline", "grtx"):
                on, off = study.point(scene, design, machine), study.point(scene, design, machine, rt__prefetch__enabled=False)
                rows.append([scene.name, design, off[HIT_RATE], on[HIT_RATE], off["gpu.cycles"] / on["gpu.cycles"]])
                if design == "baseline" and scene in study.counted:
                    gains[scene.name] = on[HIT_RATE] / off[HIT_RATE]
        page.claim("prefetch-l1", machine, gains)
    page.table(["scene", "design", "L1 hit rate without", "with", "speed-up by it"], rows)
