# SPDX-License-Identifier: Apache-2.0
"""Frame sequences: what caches that stay warm from frame to frame are worth."""
from .. import figures

TITLE = "Sequences of frames with warm caches"
DESIGNS = ("baseline", "sw", "hw", "grtx")
FRAMES = 4
PANS = [("still", 0.0), ("slow", 0.25), ("fast", 4.0)]  # degrees a frame


def build(study, page):
    page.text(f"{FRAMES} frames from the first view on, the camera turning by 0, 0.25 and 4 degrees a frame. A frame is a 60th of a second: still, 15 and 240 degrees a second ("
              f"[sequences.md](../../model/sequences.md)). *Warm* is the mean of frames 1 to {FRAMES - 1}, *cold* is frame 0, which every other page simulates. A pan "
              "changes what is seen, so *fast* compares different work; *still* has the same work in each frame.")
    for machine in study.values["side_machines"][:1]:
        groups, rows = [], []
        gains, change = {d: {} for d in DESIGNS}, {}
        for scene in [s for s in study.scenes if s.name in study.values["sequence_scenes"]]:
            for name, degrees in PANS:
                found = study.run(scene, machine, pan=(degrees, FRAMES))
                cycles = {d: [found[f"frames.cycles.{d}.{i}"] for i in range(FRAMES)] for d in DESIGNS}
                gain = {d: c[0] / (sum(c[1:]) / (FRAMES - 1)) for d, c in cycles.items()}
                cold = {d: cycles["baseline"][0] / cycles[d][0] for d in DESIGNS}
                warm = {d: sum(cycles["baseline"][1:]) / sum(cycles[d][1:]) for d in DESIGNS}
                groups.append((f"{scene.name}, {name}", gain))
                rows.append([scene.name, name, *[gain[d] for d in DESIGNS], *[cold[d] for d in DESIGNS[1:]], *[warm[d] for d in DESIGNS[1:]]])
                if scene in study.evaluation and name == "slow":
                    for d in DESIGNS:
                        gains[d][scene.name] = gain[d]
                    change[scene.name] = warm["grtx"] / cold["grtx"]
        for d in DESIGNS:
            page.claim(f"warm-{d}", machine, gains[d])
        page.claim("warm-speedup-grtx", machine, change)
        page.picture(f"gain-{machine}", figures.bars(f"Cycles of the cold frame over those of a warm one, machine {machine}", groups,
                                                     list(DESIGNS), base=1.0), "Gain of warm caches, by scene, motion and design")
        page.table(["scene", "motion", *[f"cold ÷ warm, {d}" for d in DESIGNS], *[f"speed-up {d}, cold" for d in DESIGNS[1:]],
                    *[f"{d}, warm" for d in DESIGNS[1:]]], rows)
