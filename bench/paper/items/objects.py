# SPDX-License-Identifier: Apache-2.0
"""Three-level scenes: objects that move, traced and simulated, with the cost of a frame's update."""
from dataclasses import replace

from .. import figures
from ..study import Scene

TITLE = "Scenes of several moving objects"
STATUES = 3
TURNS = [0.0, 10.0]  # degrees: two frames


def build(study, page):
    page.text(f"A room of at most {study.values['proxy_gaussians']:,} Gaussians with {STATUES} placements of one statue in a ring before the camera, who move on by 10 degrees between two frames. There are a scene TLAS over the objects, a TLAS "
              "of each file, and one BLAS ([multi-object.md](../../model/multi-object.md)). A frame rebuilds the scene TLAS alone. The designs are sw and grtx, for a monolithic "
              "structure has no objects; *flattened* is the same Gaussians as one scene. The paper gives no number.")
    most = study.values["proxy_gaussians"]
    of = study.values["objects"]
    room = next(replace(s, count=min(s.count, most)) for s in study.scenes if s.name == of["room"])
    statue = Scene("statue", "shown", preset=of["statue"], count=room.count, seed=room.seed, sh_degree=room.sh_degree)
    for machine in study.values["side_machines"][:1]:
        rows, groups, speed, share = [], [], {}, {}
        for turn in TURNS:
            placed = dict(statue=statue, statues=STATUES, turn=turn)
            three, flat = study.run(room, machine, **placed), study.run(room, machine, flatten=True, **placed)
            name = f"frame {TURNS.index(turn)}"
            for kind, found in (("three levels", three), ("flattened", flat)):
                cycles = {d: found[f"designs.{d}.gpu.cycles"] for d in ("sw", "grtx")}
                update = found["designs.grtx.accel.update.bytes"] if kind == "three levels" else found["designs.grtx.accel.bytes"]
                ratio = cycles["sw"] / cycles["grtx"]
                part = update / found["designs.grtx.gpu.dram.bytes"]
                groups.append((f"{name}, {kind}", {"grtx": ratio}))
                rows.append([name, kind, cycles["sw"] / 1e6, cycles["grtx"] / 1e6, ratio, f"{update:,.0f}", 1e6 * part,
                             found["designs.grtx.accel.bytes"] / 2**20])
                if kind == "three levels":
                    speed[name], share[name] = ratio, 1e6 * part
        page.claim("objects-grtx", machine, speed)
        page.claim("objects-update", machine, share)
        page.picture(f"speed-{machine}", figures.bars(f"Speed-up of grtx over sw, several objects, machine {machine}", groups, ["grtx"], base=1.0),
                     "Speed-up of grtx over sw with three levels and flattened, by frame")
        page.table(["frame", "scene", "M cycles, sw", "M cycles, grtx", "grtx over sw", "bytes that an update writes", "millionths of the frame's DRAM bytes, grtx",
                    "node image, MiB"], rows)
        page.text("Of the flattened scene an update writes every node again.")
