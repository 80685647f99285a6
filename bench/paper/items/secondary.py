# SPDX-License-Identifier: Apache-2.0
"""Secondary rays: a glass sphere and a mirror; primary and secondary rays apart."""
from .. import figures

TITLE = "Secondary rays"
DESIGNS = ("sw", "hw", "grtx")


def build(study, page):
    page.text("One glass sphere and one mirror, placed by the seed ([secondary-rays.md](../../model/secondary-rays.md)). Secondary rays are a launch of their own "
              "after the primary ones; each is compared with its own part of the baseline.")
    first = study.values["side_machines"][0]
    for machine in study.values["side_machines"]:
        groups, ratio, own, without = [], {}, {}, []
        for scene in study.scenes:
            found = {d: study.point(scene, d, machine, t_secondary="both") for d in ("baseline", *DESIGNS)}
            if found["baseline"]["gpu.rays.secondary_cycles"] == 0:
                without.append(scene.name)
                continue
            speed = {(kind, d): found["baseline"][f"gpu.rays.{kind}_cycles"] / found[d][f"gpu.rays.{kind}_cycles"]
                     for kind in ("primary", "secondary") for d in DESIGNS}
            for kind in ("primary", "secondary"):
                groups.append((f"{scene.name}, {kind}", {d: speed[kind, d] for d in DESIGNS}))
            if scene in study.evaluation:
                ratio[scene.name] = speed["secondary", "hw"] / speed["primary", "hw"]
                own[scene.name] = speed["secondary", "hw"]
        page.claim("hw-secondary", machine, own)
        page.claim("hw-secondary-over-primary", machine, ratio)
        if machine != first:
            continue
        page.picture(f"speed-{machine}", figures.bars(f"Speed-up on primary and secondary rays, machine {machine}", groups, list(DESIGNS),
                                                      base=1.0), "Speed-up on primary and on secondary rays, by scene")
        if without:
            page.text(f"No ray of the frame meets glass or mirror in {', '.join(without)}, so there are no secondary rays.")
