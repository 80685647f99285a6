# SPDX-License-Identifier: Apache-2.0
"""What GRTX costs: storage in the RT unit, buffers in memory, area."""
from .. import figures

TITLE = "Hardware cost, checkpoint and eviction buffers"
MIB, GIB = 2.0 ** 20, 2.0 ** 30
BITS = [("replay flags", "replay_flag"), ("source offsets", "source_offset"), ("destination offsets", "destination_offset"),
        ("source address", "source_base"), ("destination address", "destination_base"), ("maximum size", "maximum_size")]


def build(study, page):
    costs = {machine: study.cost(machine, "grtx") for machine in study.values["machines"]}
    for machine, cost in costs.items():
        page.claim("storage", machine, cost["checkpoint_storage.bytes"])
    cost = costs[study.values["machines"][0]]
    page.text("## Storage added to an RT unit",
              "In bits: " + ", ".join(f'{name} {cost[f"checkpoint_storage.bits.{key}"]:,.0f}' for name, key in BITS) +
              ". Area and energy: [cost-validation.md](../cost-validation.md).")

    page.text("## Buffers in memory",
              "Entries are the most that a ray of the main frame had; a ray needs two checkpoint buffers and one eviction buffer, and there are as many "
              "as rays can be resident: SMs × 32 warps × 32 lanes. The defaults of `grtx cost`, 256 and 283 entries, are chosen to give the paper's 97.68 MiB.")
    groups, rows, eight, many = [], [], {}, {}
    for scene in study.scenes:
        most = study.measure(scene, "grtx", k=8)
        entries = (most["tracer.checkpoint.max_per_ray"], most["tracer.eviction.max_per_ray"])
        a_ray = 2 * 20 * entries[0] + 8 * entries[1]
        own, scaled = a_ray * 32 * 32 * 8 / MIB, a_ray * 32 * 32 * 170 / GIB
        groups.append((scene.name, {"8 SMs": own}))
        rows.append([scene.name, f"{entries[0]:,.0f}", f"{entries[1]:,.0f}", own, scaled])
        if scene in study.evaluation:
            eight[scene.name], many[scene.name] = own, scaled
    worst = max(eight, key=eight.get)
    page.claim("buffers-8", "paper", {worst: eight[worst]})
    page.claim("buffers-170", "paper", {worst: many[worst]})
    page.picture("buffers", figures.bars("Checkpoint and eviction buffers, 8 SMs, MiB", groups, ["8 SMs"],
                                         {"8 SMs": page.claims["buffers-8"].paper}, unit="MiB"), "MiB of buffers, a bar for each scene")
    page.table(["scene", "most checkpoint entries", "most evictions", "MiB, 8 SMs", "GiB, 170 SMs"], rows)
