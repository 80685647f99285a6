# SPDX-License-Identifier: Apache-2.0
"""RT units of other vendors."""
from .. import figures

TITLE = "RT units of other vendors"
DESIGNS = ("sw", "hw", "grtx")


def build(study, page):
    page.text("RT units that only intersect, as AMD's: the shader cores walk the tree and read its nodes (`rt.memory.by_shader`, "
              "`configs/intersection_only.toml`). Cycle mode, on a smaller frame.")
    first = study.values["side_machines"][0]
    groups = []
    for machine in study.values["side_machines"]:
        own = {}
        for scene in study.evaluation:
            for name, keys in (("RT unit", {}), ("shader", {"rt__memory__by_shader": True})):
                if machine != first and not keys:
                    continue
                cycles = {d: study.point(scene, d, machine, "cycle", **keys)["gpu.cycles"] for d in ("baseline", *DESIGNS)}
                speed = {d: cycles["baseline"] / cycles[d] for d in DESIGNS}
                if keys:
                    own[scene.name] = speed
                if machine == first:
                    groups.append((f"{scene.name}, {name} fetches", speed))
        for d in DESIGNS:
            page.claim(f"by-shader-{d}", machine, {name: speed[d] for name, speed in own.items()})
    page.picture(f"by-shader-{first}", figures.bars(f"Speed-up by who fetches nodes, machine {first}", groups, list(DESIGNS), base=1.0),
                 "Speed-up with nodes fetched by RT unit or shader, by scene")
