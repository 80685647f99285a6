#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Cycles against the largest lower bound, and what the RT units waited for: a Markdown table over scenes and designs.

  scripts/bounds.py --size 64 [--machine configs/table1.toml] [--set gpu.sms=2] SCENE.ply:CAMERAS.json[:VIEW] ...

Python's standard library only. Traces go to a temporary folder and are removed.
"""

import argparse
import json
import os
import subprocess
import tempfile

DESIGNS = {
    "baseline": ["--accel", "tri20", "--checkpoint", "off"],
    "sw": ["--accel", "tlas-tri20", "--checkpoint", "off"],
    "hw": ["--accel", "tri20", "--checkpoint", "on"],
    "grtx": ["--accel", "tlas-tri20", "--checkpoint", "on"],
}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--grtx", default="build/release/grtx")
    parser.add_argument("--size", type=int, default=64)
    parser.add_argument("--machine", default="configs/table1.toml")
    parser.add_argument("--child-order", default="near_first")
    parser.add_argument("--set", action="append", default=[])
    parser.add_argument("scenes", nargs="+", metavar="SCENE.ply:CAMERAS.json[:VIEW]")
    arguments = parser.parse_args()
    print("| scene | design | cycles | largest bound | bound, cycles | cycles / bound | stalls of the RT units |")
    print("|---|---|---|---|---|---|---|", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        for scene in arguments.scenes:
            path, cameras, view = (scene.split(":") + ["0"])[:3]
            for design, options in DESIGNS.items():
                trace, statistics = os.path.join(folder, "t.grtx"), os.path.join(folder, "s.json")
                subprocess.run([arguments.grtx, "trace", "--quiet", "--scene", path, "--cameras", cameras, "--view", view,
                                "--width", str(arguments.size), "--height", str(arguments.size), "--machine", arguments.machine, "--child-order",
                                arguments.child_order, *options, "-o", trace],
                               check=True)
                settings = [word for setting in arguments.set for word in ("--set", setting)]
                subprocess.run([arguments.grtx, "sim", "--quiet", trace, "--machine", arguments.machine, *settings,
                                "--stats", statistics], check=True)
                with open(statistics) as file:
                    stats = json.load(file)["stats"]
                cycles = stats["gpu.cycles"]["value"]
                bound = stats["gpu.bound.largest"]["value"]
                name = stats["gpu.bound.largest"]["description"].split(": ")[1]
                stalls = {n.rsplit(".", 1)[1]: s["value"] for n, s in stats.items() if n.startswith("gpu.rt.stall.")}
                total = sum(stalls.values()) + stats["gpu.rt.selections"]["value"]
                shown = ", ".join(f"{n} {100 * v / total:.0f} %"
                                  for n, v in sorted(stalls.items(), key=lambda s: -s[1])[:3] if v > 0)
                base = os.path.splitext(os.path.basename(path))[0]
                print(f"| {base} | {design} | {cycles} | {name} | {bound} | {cycles / bound:.2f} | {shown} |", flush=True)


if __name__ == "__main__":
    main()
