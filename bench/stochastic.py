#!/usr/bin/env python3
"""Stochastic tracing beside the exact designs: PSNR against simulated milliseconds, as Markdown and as a picture.

  bench/stochastic.py build/release/grtx FOLDER --scene NAME SCENE.ply CAMERAS.json [--scene ...]

PSNR is against `grtx reference` without early termination; time is gpu.time_us of fast mode on a machine of configs/, cut to
the share of a view: 64 x 64 pixels as dense as in 128 x 128, two SMs, an L2 of 1 MiB. FOLDER keeps all runs.
"""

import argparse
import csv
import json
import re
import subprocess
from pathlib import Path

VIEW = "--view 0 --width 64 --height 64 --fov-scale 0.5 --quiet".split()
QUARTER = "--set gpu.sms=2 --set l2.bytes=1048576 --set l2.slices=1".split()
SAMPLES = [1, 2, 4, 8, 16, 32, 64]
ERT = [0.001, 0.03, 0.3]
EXACT = {  # name: options of the trace; k of the paper, and the best design without its structure
    "baseline": "--accel tri20 --k 8".split(),
    "grtx": "--accel tlas-tri20 --checkpoint on --k 8".split(),
    "grtx, k = 16": "--accel tlas-tri20 --checkpoint on --k 16".split(),
    "ellipsoid, checkpointing, k = 16": "--accel ellipsoid --checkpoint on --k 16".split(),
}


def call(*words):
    result = subprocess.run([str(w) for w in words], capture_output=True, text=True)
    if result.returncode != 0:
        raise SystemExit(result.stderr.strip())
    return result.stdout


class Scene:
    def __init__(self, grtx, folder, machine, name, ply, cameras):
        self.grtx, self.machine, self.name = grtx, machine, name
        self.folder = folder / name
        self.folder.mkdir(parents=True, exist_ok=True)
        self.input = ["--scene", ply, "--cameras", cameras, *VIEW]
        self.reference = {}

    def reference_of(self, accel):
        if accel not in self.reference:
            path = self.folder / f"reference_{accel}.pfm"
            if not path.exists():
                call(self.grtx, "reference", *self.input, "--accel", accel, "--ert", 0, "-o", path)
            self.reference[accel] = path
        return self.reference[accel]

    def point(self, what, accel, options):
        """(dB, milliseconds, node visits a ray)"""
        stem = re.sub(r"[^A-Za-z0-9.]+", "_", what)
        image, trace, stats = (self.folder / (stem + end) for end in (".pfm", ".grtx", ".json"))
        call(self.grtx, "trace", *self.input, *options, "--image", image, "-o", trace)
        call(self.grtx, "sim", trace, "--machine", self.machine, *QUARTER, "--mode", "fast", "--stats", stats, "--quiet")
        trace.unlink()
        psnr = float(re.search(r"PSNR (\S+) dB", call(self.grtx, "compare", self.reference_of(accel), image)).group(1))
        values = json.loads(stats.read_text())["stats"]
        milliseconds = values["gpu.time_us"]["value"] / 1e3
        return psnr, milliseconds

    def points(self):
        for name, options in EXACT.items():
            accel = options[1]
            for ert in ERT:
                what = f"{name}, ERT {ert}"
                yield what, "exact", *self.point(what, accel, [*options, "--ert", ert])
        for samples in SAMPLES:
            what = f"stochastic, {samples} samples"
            options = f"--accel ellipsoid --tracing stochastic --samples {samples}".split()
            yield what, "stochastic", *self.point(what, "ellipsoid", options)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("grtx")
    parser.add_argument("folder", type=Path)
    parser.add_argument("--scene", nargs=3, action="append", required=True, metavar=("NAME", "PLY", "CAMERAS"))
    parser.add_argument("--machine", default="paper")
    arguments = parser.parse_args()
    scenes = [Scene(arguments.grtx, arguments.folder, arguments.machine, *scene) for scene in arguments.scene]
    table = {}
    with open(arguments.folder / "stochastic.csv", "w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(["scene", "setting", "kind", "psnr_db", "milliseconds"])
        for scene in scenes:
            for what, kind, psnr, milliseconds in scene.points():
                rows.writerow([scene.name, what, kind, f"{psnr:.2f}", f"{milliseconds:.3f}"])
                table.setdefault(what, {})[scene.name] = (psnr, milliseconds)
    names = [scene.name for scene in scenes]
    print("| setting | " + " | ".join(f"{n}: ms | PSNR, dB" for n in names) + " |")
    print("|---|" + "---|---|" * len(names))
    for what, row in table.items():
        print(f"| {what} | " + " | ".join(f"{row[n][1]:.2f} | {row[n][0]:.1f}" for n in names) + " |")


if __name__ == "__main__":
    main()
