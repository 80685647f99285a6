# SPDX-License-Identifier: Apache-2.0
"""Motivation: what a round's time is made of, one round against many, k of the baseline, unique and total visits."""
from .. import figures

TITLE = "Rounds: what they cost the baseline (motivation)"
KS = (4, 8, 16, 32)
SERIES = ["traversal", "sorting", "blending"]


def split(values):
    """Shares of the time of resident warps. Waiting for memory is divided by the sectors that sorting (k-buffer) and
    blending (Gaussian, SH, ray) move."""
    state = {s: values[f"gpu.simt.warp_cycles.{s}"] for s in ("raygen", "blend", "any_hit", "memory", "trace")}
    moved = {kind: sum(values.get(f"gpu.simt.lsu.{way}.{r}", 0) for way in ("loads", "stores") for r in regions)
             for kind, regions in {"sort": ("k_buffer", "eviction"), "blend": ("gaussian", "sh", "ray")}.items()}
    of_sort = moved["sort"] / max(1, moved["sort"] + moved["blend"])
    shares = {"traversal": state["trace"], "sorting": state["any_hit"] + of_sort * state["memory"],
              "blending": state["raygen"] + state["blend"] + (1 - of_sort) * state["memory"]}
    return {name: value / sum(shares.values()) for name, value in shares.items()}


def build(study, page):
    machine = study.values["side_machines"][0]  # the baseline has no checkpoints
    page.text("## One round in traversal, sorting, blending")
    shares = {s.name: split(study.point(s, "baseline", machine)) for s in study.scenes}
    page.claim("traversal-share", machine, {s.name: shares[s.name]["traversal"] for s in study.counted})
    page.picture("split", figures.stacks("Baseline, k = 8: share of the time of resident warps", list(shares.items()), SERIES),
                 "Share of traversal, sorting and blending in the baseline's time, a bar for each scene")
    page.text("Shares of the cycles of resident warps over all rounds. The paper adds one operation after the other on a GPU.")

    page.text("## One round against many, and k of the baseline")
    curves, rows, ratios, best, redundancy = {}, [], {}, {}, {}
    for scene in study.scenes:
        cycles = {k: study.point(scene, "baseline", machine, t_k=k)["gpu.cycles"] for k in KS}
        single = study.point(scene, "baseline", machine, t_k=study.values["dense_k"], t_tracing="single")["gpu.cycles"]
        visits = study.measure(scene, "baseline", machine, frame="side", k=16)
        total, unique = visits["tracer.visits.total"], visits["tracer.visits.unique"]
        curves[scene.name] = [cycles[k] / cycles[16] for k in KS]
        rows.append([scene.name, *[cycles[k] / 1e6 for k in KS], single / 1e6, visits["tracer.hits_behind_end"],
                     visits["tracer.ert_share"], total / 1e6, unique / 1e6])
        if scene in study.counted:
            ratios[scene.name] = single / cycles[16]
            best[scene.name] = min(KS, key=cycles.get)
            redundancy[scene.name] = total / unique
    page.claim("single-over-multi", machine, ratios)
    page.claim("best-k-baseline", machine, best)
    page.claim("total-over-unique", machine, redundancy)
    page.picture("k", figures.lines("Baseline: cycles at k over cycles at k = 16", [str(k) for k in KS], curves, "k",
                                    "cycles ÷ cycles at 16", {"paper's best": KS.index(16)}),
                 "Cycles of the baseline over k, a line for each scene")
    page.table(["scene", f"M cycles, k = {KS[0]}", *map(str, KS[1:]), f"single round, k = {study.values['dense_k']}",
                "hits ÷ processed", "rays ended by ERT", "M visits, k = 16", "of them unique"], rows)
    page.text("A single round pays for hits behind the end of the ray: *hits ÷ processed* says how many there are. Where it is near 1 a single round has "
              "little to lose, and saves every return to the root. The paper's rays need k = 512 to 2048 to hold all hits.")
