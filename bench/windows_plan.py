# SPDX-License-Identifier: Apache-2.0
"""The plan of bench/windows.py: frames with their machines and designs, drawn by DATE, and the order in which they run."""
import itertools
import math
import random
from collections import defaultdict

DATE = 20261129
K = ["--k", "16"]
DESIGNS = {  # name: structure and rounds; what else belongs to a design, the program says (grtx machine --design)
    "baseline": ["--accel", "tri20", "--checkpoint", "off", *K], "sw": ["--accel", "tlas-tri20", "--checkpoint", "off", *K],
    "hw": ["--accel", "tri20", "--checkpoint", "on", *K], "grtx": ["--accel", "tlas-tri20", "--checkpoint", "on", *K],
    "gautracer": ["--accel", "ellipsoid", "--checkpoint", "off"], "walk": ["--accel", "ellipsoid", "--checkpoint", "off"]}
CHEAP = ("gautracer", "walk")
MACHINES = {  # name: machine, slots, settings
    "1 x 8": ("paper-charged", 8, {"gpu.sms": 1, "gpu.resident_warps": 8, "l2.bytes": 524288, "l2.slices": 1}),
    "2 x 16": ("paper-charged", 32, {"gpu.sms": 2, "gpu.resident_warps": 16, "l2.bytes": 1048576, "l2.slices": 1}),
    "4 x 16": ("paper-lean", 64, {"gpu.sms": 4, "gpu.resident_warps": 16, "l2.bytes": 2097152, "l2.slices": 2}),
    "paper": ("paper", 256, {}), "rdna4-share": ("rdna4-share", 256, {}), "rtx2060-share": ("rtx2060-share", 256, {}),
    "ada-share": ("ada-share", 384, {}), "blackwell-share": ("blackwell-share", 384, {}),
    "16 x 32": ("paper-charged", 512, {"gpu.sms": 16, "l2.bytes": 8388608, "l2.slices": 8})}
PUBLIC = {"wang_sha": "room", "lacadiere": "room", "headquarter_garden": "room", "hon_sui_sen": "building", "taebak": "building",
          "la_fontaine": "object", "la_vestale": "object", "le_poeme": "object", "pizza_161k_sh3": "object", "statue_st-peter_sh0": "object",
          "playbot_L4": "object", "playbot_L6": "object"}
PRESETS = {"hall": "room", "building": "building", "object": "object", "room": "room", "flat": "room", "garden": "building"}
# Of 5,408, 10,368, 20,808 and 36,450 warps of 8 rays or 32; 1332 x 876 pixels are 36,573 warps of 32.
EDGES = {"small": (208, 416), "public": (208, 416), "large": (288, 576), "whole": (408, 816), "full HD": (540, 1080)}
FEW_SLOTS = [name for name, (_, slots, _) in MACHINES.items() if slots <= 64]


def deck_of(lot, names):
    while True:
        yield from lot.sample(names, len(names))


def draw():
    """The frames, in the order of drawing. The first half has warps of 8 rays, which cost a third."""
    lot = random.Random(DATE)

    def deck(names):
        return deck_of(lot, names)

    def hand(cards, count):
        found = []
        while len(found) < count:
            card = next(cards)
            if card not in found:
                found.append(card)
        return found

    few = deck([name for name, (_, slots, _) in MACHINES.items() if slots <= 256])
    many = deck([name for name, (_, slots, _) in MACHINES.items() if slots > 256])
    dear, presets, public = deck(["grtx", "sw", "baseline", "hw"]), deck(list(PRESETS)), deck(sorted(PUBLIC))
    frames = []
    for number in range(60):
        kind = ("small", "large", "small", "small", "public")[number % 5]
        frame = {"view": lot.randrange(4), "rays": 8 if number < 30 else 32, "seed": lot.randrange(1 << 30), "designs": [*CHEAP]}
        frame["edge"] = EDGES[kind][frame["rays"] == 32]
        if kind == "public":  # without the large trees of triangles
            frame["scene"] = next(public)
            frame["class"] = PUBLIC[frame["scene"]]
            frame["view"] %= 2
        else:
            preset = next(presets)
            count, seed = round(math.exp(lot.uniform(math.log(300), math.log(3000)))), lot.randrange(1 << 20)
            frame.update(scene=f"{preset}_{count}_{seed}", preset=preset, count=count, scene_seed=seed)
            frame["class"] = PRESETS[preset]
            if preset not in ("flat", "garden"):  # whose triangles take minutes
                frame["designs"].append(next(dear))
        frame["machines"] = [(name, 0.5) for name in hand(few, 2)] if kind != "large" else [(next(few), 0.25), (next(many), 0.5)]
        # Machines of few slots, where windows suit frames of this size, have all frames.
        have = {name for name, _ in frame["machines"]}
        frame["machines"] += [(name, 0.25 if kind == "large" else 0.5) for name in FEW_SLOTS if name not in have]
        frames.append(frame)
    # What the mode is for, a small share: some frames again as whole ones. (The first two had 7 % until less than 25 % was refused.)
    for frame in frames[3:12:5]:
        frames.append({**frame, "edge": EDGES["full HD"][0], "machines": [("4 x 16", 0.25), ("2 x 16", 0.25)]})
    for frame in frames[1:12:5]:  # and machines of a card's slots
        frames.append({**frame, "edge": EDGES["whole"][0], "machines": [("paper", 0.5), ("rdna4-share", 0.5), ("2 x 16", 0.25)]})
    # Public rooms and buildings, all with warps of 8 rays, have a design with triangles or instances each, too.
    dear = deck_of(random.Random(DATE + 1), ["grtx", "sw", "baseline", "hw"])
    for frame in [frame for frame in frames if frame["scene"] in PUBLIC and frame["class"] != "object"]:
        if frame["rays"] == 8:
            frame["designs"] = [*frame["designs"], next(dear)]
        else:
            frames.append({**frame, "rays": 8, "edge": EDGES["public"][0], "designs": [*frame["designs"], next(dear)]})
    return frames


def name_of(frame):
    return f"{frame['scene']}-{frame['view']}-{frame['edge']}-{frame['rays']}"


def stratum_of(frame):
    if frame["edge"] >= EDGES["whole"][0] and frame["rays"] == 8:
        return "whole"
    if frame["scene"] in PUBLIC:
        return "public object" if frame["class"] == "object" else "public"
    return frame["designs"][-1]


def points(frames):
    """In the order in which they run: by turns one frame and machine of each stratum, warps of 8 rays first. Machines of more slots, which
    refuse all but whole frames, come after them, dear designs of public scenes last."""
    strata = defaultdict(list)
    for rays, turn in itertools.product((8, 32), range(len(FEW_SLOTS))):
        for number, frame in enumerate(frames):
            fits = [machine for machine in frame["machines"] if machine[0] in FEW_SLOTS]
            if frame["rays"] == rays and turn < len(fits):
                strata[stratum_of(frame)].append((frame, *sorted(fits)[(number + turn) % len(fits)]))
    for frame in frames:
        for machine in frame["machines"]:
            if machine[0] not in FEW_SLOTS:
                strata["whole" if stratum_of(frame) == "whole" else "many slots"].append((frame, *machine))
    many = strata.pop("many slots")
    cells = [*filter(None, itertools.chain(*itertools.zip_longest(*strata.values()))), *many]
    found = [(*cell, design) for cell in cells for design in cell[0]["designs"]]
    return sorted(found, key=lambda point: point[0]["scene"] in PUBLIC and point[3] not in CHEAP)
