# SPDX-License-Identifier: Apache-2.0
"""Where the gain comes from: node fetches, their latency, L1 and L2; the sibling prefetcher."""
from .. import figures
from ..study import geometric_mean

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
    machine = machines[0]
    own = {(s.name, d): found[machine, s.name, d] for s in study.scenes for d in ("baseline", *DESIGNS)}
    for name, title, statistic in FIGURES:
        groups = [(s.name, {d: own[s.name, d][statistic] / own[s.name, "baseline"][statistic] for d in DESIGNS}) for s in study.scenes]
        marks = {"grtx": 1 / page.claims[f"{name}-grtx"].paper}
        page.picture(f"{name}-{machine}", figures.bars(f"{title}, machine {machine}", groups, list(DESIGNS), marks, unit="", base=1.0),
                     f"{title}, by scene and design")
    groups = [(s.name, {d: own[s.name, d][HIT_RATE] for d in ("baseline", *DESIGNS)}) for s in study.scenes]
    page.picture(f"l1-{machine}", figures.bars(f"L1 hit rate of node fetches, machine {machine}", groups, ["baseline", *DESIGNS],
                                               {"sw": page.claims["l1-sw"].paper}, unit=""), "L1 hit rate, by scene and design")
    mean = lambda design, statistic: geometric_mean(own[s.name, design][statistic] for s in study.evaluation)
    page.text("Means over the generated scenes:")
    page.table(["design", "M node fetches", "latency, cycles", "L1 hit rate", "M L2 accesses", "DRAM MB"],
               [[d, mean(d, "gpu.rt.node_fetches") / 1e6, mean(d, "gpu.rt.node_fetch_latency"), mean(d, HIT_RATE), mean(d, "gpu.l2.accesses") / 1e6,
                 mean(d, "gpu.dram.bytes") / 1e6] for d in ("baseline", *DESIGNS)])
    prefetch(study, page)


def prefetch(study, page):
    page.text("## The sibling prefetcher",
              "The paper adds it to bring the L1 hit rate nearer to that of real GPUs.")
    machine = study.values["side_machines"][0]
    found = {(s.name, d): (study.point(s, d, machine, rt__prefetch__enabled=False), study.point(s, d, machine))
             for s in study.counted for d in ("baseline", "grtx")}
    page.claim("prefetch-l1", machine, {s.name: found[s.name, "baseline"][1][HIT_RATE] / found[s.name, "baseline"][0][HIT_RATE] for s in study.counted})
    mean = lambda design, of: geometric_mean(of(*found[s.name, design]) for s in study.evaluation)
    page.table(["design", "L1 hit rate without", "with", "speed-up by it"],
               [[d, mean(d, lambda off, on: off[HIT_RATE]), mean(d, lambda off, on: on[HIT_RATE]),
                 mean(d, lambda off, on: off["gpu.cycles"] / on["gpu.cycles"])] for d in ("baseline", "grtx")])
