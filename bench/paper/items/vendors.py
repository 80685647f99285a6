# SPDX-License-Identifier: Apache-2.0
"""RT units of other vendors."""
from .. import figures

TITLE = "RT units of other vendors"
DESIGNS = ("sw", "hw", "grtx")


def build(study, page):
    page.text("RT units that only intersect, as AMD's: the shader cores walk the tree and read its nodes (`rt.memory.by_shader`, "
              "`configs/intersection_only.toml`). Cycle mode, on a smaller frame.")
    for machine in study.values["side_machines"]:
        groups, rows, own = [], [], {}
        for scene in study.evaluation:
            for name, keys in (("RT unit fetches", {}), ("shader fetches", {"rt__memory__by_shader": True})):
                cycles = {d: study.point(scene, d, machine, "cycle", "cycle", **keys)["gpu.cycles"] for d in ("baseline", *DESIGNS)}
                speed = {d: cycles["baseline"] / cycles[d] for d in DESIGNS}
                groups.append((f"{scene.name}, {name}", speed))
                rows.append([scene.name, name, *[speed[d] for d in DESIGNS], cycles["baseline"] / 1e6])
                if keys:
                    own[scene.name] = speed
        for d in DESIGNS:
            page.claim(f"by-shader-{d}", machine, {name: speed[d] for name, speed in own.items()})
        page.picture(f"by-shader-{machine}", figures.bars(f"Speed-up by who fetches nodes, machine {machine}", groups, list(DESIGNS), base=1.0),
                     "Speed-up with nodes fetched by RT unit or shader, by scene")
        page.table(["scene", "who fetches", *DESIGNS, "M cycles, baseline"], rows)
