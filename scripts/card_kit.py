#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""For who has a card that traces rays: writes scenes, cameras, a plan and a table to fill, so that the card's milliseconds can be held
against the model. What to run on the card, and with which options, is in the folder's README.txt.

    scripts/card_kit.py FOLDER --card "RTX 4090" --sms 128 --mhz 2520 [--program build/release/grtx] [--count 300000]

--sms, --mhz: SMs of the card, and the core clock at which it renders (nvidia-smi --query-gpu=clocks.sm --format=csv -l 1).
"""
import argparse
import itertools
import json
import math
import os
import subprocess
import sys

SCENES = {"room": 621, "building": 622}
STRUCTURES = {"tri20": "Use TLAS Instances off, Use AABBs off", "tlas-tri20": "Use TLAS Instances on, Use AABBs off",
              "tlas-box": "Use TLAS Instances on, Use AABBs on"}
DEGREES = (2, 4)
WIDTH, HEIGHT, CROP = 1920, 1080, 48  # pixels of the frame, and of the side of the crop that is simulated
README = """1. On the card: NVIDIA's vk_gaussian_splatting, commit 158655a (https://github.com/nvpro-samples/vk_gaussian_splatting).
   Load each scene, set its camera from NAME.cameras.json (3DGS layout; vertical field of view {fov:.2f} degrees), window
   {width} x {height}, pipeline ray tracing (3DGRT), payload of 18 hits, BLAS compaction on, no temporal sampling, no denoiser.
   For each line of measured.csv set
{structures}
   and the degree of the kernel, wait until the time of a frame is steady, and write its milliseconds under value.
   low and high: the range that you saw. pixels, sms and mhz are of your frame and card; mend them if they differ.
2. Here: grtx sweep plan.toml -o card.sqlite --machine MACHINE
   MACHINE: the nearest of configs/sweeps/quarters (a crop does not fill a card; of its SMs two suffice).
3. grtx correlate measured.csv card.sqlite -o card.html
"""


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder")
    parser.add_argument("--card", required=True)
    parser.add_argument("--sms", type=int, required=True)
    parser.add_argument("--mhz", type=float, required=True)
    parser.add_argument("--program", default=os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "build", "release", "grtx"))
    parser.add_argument("--count", type=int, default=300000, help="Gaussians of a scene (default %(default)s)")
    arguments = parser.parse_args()
    if not os.access(arguments.program, os.X_OK):
        sys.exit(f"card_kit.py: {arguments.program}: no such program; build it, or name one with --program")
    if "," in arguments.card or arguments.sms < 1 or not arguments.mhz > 0:
        sys.exit("card_kit.py: --card: has a comma, or --sms or --mhz is not above 0")
    os.makedirs(arguments.folder, exist_ok=True)
    at = lambda name: os.path.join(arguments.folder, name)
    plan = ['mode = "cycle"', ""]
    for name, seed in SCENES.items():
        done = subprocess.run([arguments.program, "synth", "--preset", name, "--count", str(arguments.count), "--seed", str(seed),
                               "-o", at(name + ".ply"), "--quiet"], check=False)
        if done.returncode:
            sys.exit(done.returncode)
        plan += ["[[scene]]", f'name = "{name}"', f'file = "{name}.ply"', f'cameras = "{name}.cameras.json"', "view = 0",
                 f"width = {CROP}", f"height = {CROP}", f"fov_scale = {CROP / HEIGHT:.6f}", ""]
    plan += ["[limits]", "seconds = 3600", "memory_mb = 9000", "", "[tracer]", "k = 18", 'layout = "compact"',
             'instance_bounds = "box_corners"', "", "[grid]", f"tracer.kernel_degree = {list(DEGREES)}",
             "tracer.accel = [" + ", ".join(f'"{accel}"' for accel in STRUCTURES) + "]"]
    lines = ["# Milliseconds of a frame: fill in value (README.txt).",
             "card,scene,design,quantity,tracer.kernel_degree,value,low,high,pixels,sms,mhz"]
    lines += [f"{arguments.card},{scene},{accel},frame.ms,{degree},,,,{WIDTH * HEIGHT},{arguments.sms},{arguments.mhz:g}"
              for scene, degree, accel in itertools.product(SCENES, DEGREES, STRUCTURES)]
    texts = {"plan.toml": plan, "measured.csv": lines,
             "README.txt": [README.format(width=WIDTH, height=HEIGHT, fov=vertical_view(at("room.cameras.json")),
                                          structures="\n".join(f"     {accel}: {options}" for accel, options in STRUCTURES.items()))]}
    for name, text in texts.items():
        with open(at(name), "w", encoding="utf-8") as file:
            file.write("\n".join(text).rstrip("\n") + "\n")
    print(f"{arguments.folder}: read README.txt")


def vertical_view(cameras):
    with open(cameras, encoding="utf-8") as file:
        camera = json.load(file)[0]
    return math.degrees(2 * math.atan(camera["height"] / 2 / camera["fy"]))


if __name__ == "__main__":
    main()
