# SPDX-License-Identifier: Apache-2.0
"""Tables I and II: the machine, and the scenes with the sizes of their structures."""
TITLE = "Configuration and scenes (Tables I and II)"

TABLE_I = [  # what, the paper's value, configuration key: all are shown where a machine has another
    ("Streaming multiprocessors", 8, "gpu.sms"), ("Clock, MHz", 1365, "gpu.core_mhz"),
    ("Warp schedulers an SM (128 lanes)", 4, "simt.schedulers"), ("L1D, bytes", 131072, "l1.bytes"),
    ("L1D line, bytes", 128, "l1.line_bytes"), ("L1D ways, LRU", 256, "l1.ways"), ("L1D latency, cycles", 20, "l1.latency"),
    ("L2, bytes", 4194304, "l2.bytes"), ("L2 line, bytes", 128, "l2.line_bytes"), ("L2 ways, LRU", 16, "l2.ways"),
    ("L2 latency, cycles", 165, "l2.latency"), ("Memory clock, MHz", 3500, "dram.mhz"), ("RT units an SM", 1, "gpu.rt_units"),
    ("Warp buffer of an RT unit", 8, "rt.warp_buffer.entries")]

TABLE_II = [  # the paper's scenes: M Gaussians, height, GiB 20-tri, MiB TLAS+20-tri, footprints in MiB
    ("train", 1.46, 27, 2.34, 208, 160, 33), ("truck", 2.43, 28, 3.88, 345, 181, 36), ("bonsai", 1.13, 26, 1.81, 161, 159, 30),
    ("room", 0.76, 26, 1.21, 107, 150, 21), ("drjohnson", 1.72, 26, 2.75, 245, 121, 15),
    ("playroom", 0.97, 27, 1.54, 137, 77, 13)]
MIB = 1024.0 * 1024.0


def build(study, page):
    machines = study.values["machines"]
    configurations = {m: study.cost(m, "grtx") for m in machines}
    page.text("## Table I")
    unlike = [row for row in TABLE_I if any(float(configurations[m][f"config.{row[2]}"]) != row[1] for m in machines)]
    if unlike:
        page.table(["", "paper", *[f"`{m}`" for m in machines], "key"],
                   [[what, str(paper), *[str(configurations[m][f"config.{key}"]) for m in machines], f"`{key}`"]
                    for what, paper, key in unlike])
    page.text("As in the paper: " + ", ".join(f"`{key}` {paper}" for row in TABLE_I if row not in unlike for _, paper, key in [row]) + ".")
    page.text("Not modelled: the L1I. What the paper leaves open: [configuration.md](../../model/configuration.md); how it was chosen: [readings.md](../readings.md).")
    rows, footprints, bytes_of, heights = [], {}, {"tri20": {}, "tlas": {}}, {}
    for name, millions, height, mono, two, own, shared in TABLE_II:
        rows.append([name + " (paper)", millions, str(height), mono * 1024, two, own, shared])
    for scene in study.scenes:
        mono, two = study.measure(scene, "baseline"), study.measure(scene, "sw")
        per = [m["accel.bytes_per_gaussian"] for m in (mono, two)]
        feet = [m["accel.footprint_bytes"] / MIB for m in (mono, two)]
        rows.append([scene.name, mono["accel.bytes"] / per[0] / 1e6, str(round(mono["accel.height"])), mono["accel.bytes"] / MIB,
                     two["accel.bytes"] / MIB, *feet])
        if scene in study.counted:
            bytes_of["tri20"][scene.name], bytes_of["tlas"][scene.name] = per
            footprints[scene.name] = feet[0] / feet[1]
            heights[scene.name] = mono["accel.height"]
    page.claim("bytes-tri20", "paper", bytes_of["tri20"])
    page.claim("bytes-tlas", "paper", bytes_of["tlas"])
    page.claim("height-tri20", "paper", heights)
    page.claim("footprint", "paper", footprints)
    page.text("## Table II")
    page.table(["scene", "M Gaussians", "height, 20-tri", "MiB, 20-tri", "MiB, TLAS+20-tri", "footprint MiB, 20-tri", "TLAS+20-tri"], rows)
    page.text("The footprint is what the main frame touches.")
