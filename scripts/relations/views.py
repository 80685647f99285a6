# SPDX-License-Identifier: Apache-2.0
"""Generated views and random ways to trace them."""
from . import gaussians

# The structures of one proxy: whichever is walked, the hits are the same.
STRUCTURES = {"icosahedron": ["tri20", "tlas-tri20"], "icosphere": ["tri80", "tlas-tri80"],
              "sphere": ["ellipsoid", "tlas-sphere"], "box": ["box", "tlas-box"]}
DESIGNS = [("tri20", "off"), ("tlas-tri20", "off"), ("tri20", "on"), ("tlas-tri20", "on"), ("ellipsoid", "on"),
           ("tlas-sphere", "on"), ("tri80", "off"), ("tlas-tri80", "on"), ("box", "off"), ("tlas-box", "off")]
# Machines of at most eight SMs: what the others do these do. Not rtx2060-share and blackwell-share: SETTINGS would have to fit their three channels.
MACHINES = ["paper", "paper-charged", "paper-lean", "ada-share", "rdna4-share"]
SETTINGS = {"gpu.sms": [1, 2, 3], "rt.warp_buffer.entries": [1, 2, 16], "rt.warp_buffer.stack_entries": [4, 16, 64],
            "rt.scheduler.policy": ["round_robin", "greedy_then_oldest"], "rt.prefetch.enabled": ["true", "false"],
            "rt.box.count": [1, 8], "rt.checkpoint.lanes": [1, 32], "l1.bytes": [65536, 262144], "l1.latency": [5, 60],
            "l2.bytes": [131072, 8388608], "l2.latency": [40, 400], "l2.slices": [1, 2, 8], "dram.banks": [4, 32],
            "l1.private_writes": ["write_back"], "gpu.rt_units": [2],
            "gpu.core_mhz": [700, 1900]}


def settings(rng):
    """--set options: a few keys that go together whatever their values."""
    some = rng.sample(list(SETTINGS), rng.randrange(4))
    return [word for key in some for word in ("--set", f"{key}={rng.choice(SETTINGS[key])}")]


def scene(case, name="s", presets=None, most=500):
    """Makes NAME.ply and NAME.cameras.json; gives the preset."""
    rng = case.rng
    preset = rng.choice(presets or gaussians.PRESETS)
    count = rng.randrange(60, most)
    case.grtx("synth", "--preset", preset, "--count", count, "--seed", rng.randrange(1 << 30), "--sh-degree",
              rng.randrange(4), "-o", f"{name}.ply", "--quiet")
    if preset in gaussians.PRESETS and rng.random() < 0.15:
        path = case.path(f"{name}.ply")
        gaussians.write_ply(path, gaussians.of_degree_4(gaussians.read_ply(path), rng.random()))
    return preset


def size(rng, most=20):
    return ["--width", rng.randrange(4, most), "--height", rng.randrange(4, most)]


def view(case, name="s", most=20):
    """Options of a random view of NAME: camera, size, field of view."""
    rng = case.rng
    views = len(gaussians.read_cameras(case.path(f"{name}.cameras.json")))
    return ["--cameras", f"{name}.cameras.json", "--view", rng.randrange(views), *size(rng, most), "--fov-scale",
            f"{rng.choice([0.2, 0.5, 1, 1, 1.7]):g}"]


def shading(rng, proxy="icosahedron"):
    """Options that change the image: it is compared between runs that share them."""
    options = ["--ert", rng.choice(["0.001", "0.001", "0.05", "0"]), "--kernel-radius", rng.choice(["adaptive", "adaptive", "3sigma"]),
               "--sh-dir", rng.choice(["ray", "centre"])]
    options += ["--kernel-degree", rng.choice([2, 2, 4])]
    if rng.random() < 0.3:
        options += ["--sort-key", "peak"]
    if proxy == "sphere" and rng.random() < 0.3:
        options += ["--inside", "count"]
    return options


def walk(rng, proxy="icosahedron", tracing=True):
    """Options that leave the image alone: structure, rounds, orders, layout, warps, threads."""
    options = ["--accel", rng.choice(STRUCTURES[proxy]), "--k", rng.choice([1, 2, 3, 8, 16, 64]),
               "--child-order", rng.choice(["near_first", "slot", "vulkan_sim"]), "--pop-test", rng.choice(["on", "off"]),
               "--tmax-update", rng.choice(["reported", "kth"]), "--instance-bounds", rng.choice(["tight", "box_corners"]),
               "--warp-size", rng.choice([4, 8, 16, 32]), "--mapping", rng.choice(["tile8x4", "linear"]),
               "--box-bits", rng.choice([8, 8, 5, 3]), "--threads", rng.choice([1, 2])]
    layout = rng.choice(["vulkan_sim", "vulkan_sim", "compact", "compressed"])
    options += ["--layout", layout]
    if layout != "compressed":
        options += ["--bvh-width", rng.randrange(2, 9)]
    how = rng.random()
    if tracing and how < 0.25:
        return options + rng.choice([["--tracing", "closest"], ["--tracing", "single"],
                                     ["--tracing", "list", "--list-capacity", rng.choice([16, 1024])]])
    if how < 0.75:
        options += ["--checkpoint", "on", "--checkpoint-capacity", rng.choice([1, 7, 64, 1024]),
                    "--replay-tmax", rng.choice(["infinity", "kth"])]
        if rng.random() < 0.4:
            options += ["--checkpoint-bins", rng.choice([2, 4])]
        else:
            options += ["--checkpoint-order", rng.choice(["fifo", "lifo", "nearest"])]
        options += ["--below-instance", rng.choice(["checkpoint", "finish"])]
    else:
        options += ["--any-hit", rng.choice(["immediate", "delayed"])]
    return options


def traced(case, name, design=None, preset=None, most=400, pixels=17, more=()):
    """Makes a scene and a trace NAME.grtx of a view of it, with NAME.trace.json; gives the options of the trace."""
    rng = case.rng
    scene(case, name, presets=preset, most=most)
    accel, checkpoint = design or rng.choice(DESIGNS)
    options = ["--scene", f"{name}.ply", *view(case, name, pixels), "--accel", accel, "--checkpoint", checkpoint, *more]
    case.grtx("trace", *options, "-o", f"{name}.grtx", "--stats", f"{name}.trace.json", "--quiet")
    return options
