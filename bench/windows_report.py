# SPDX-License-Identifier: Apache-2.0
"""The report of bench/windows.py: which intervals hold, as tables and as a file of cases."""
import csv
import hashlib
import math
from collections import defaultdict

from windows_plan import DESIGNS, MACHINES, PUBLIC, name_of

LEAST, FEWEST = 0.9, 10  # a statistic of which fewer intervals hold is named


def student_quantile(p, degrees):
    def cumulative(t):
        end, steps = math.atan(t / math.sqrt(degrees)), 400
        h = end / steps
        total = sum((1 if i in (0, steps) else 4 if i % 2 else 2) * math.cos(i * h) ** (degrees - 1) for i in range(steps + 1))
        return 0.5 + math.exp(math.lgamma((degrees + 1) / 2) - math.lgamma(degrees / 2)) / math.sqrt(math.pi) * total * h / 3
    low, high = 0.0, 1.0
    while cumulative(high) < p:
        high *= 2
    for _ in range(50):
        middle = (low + high) / 2
        low, high = (middle, high) if cumulative(middle) < p else (low, middle)
    return (low + high) / 2


def reach(influences, drift):
    """Half of the interval on the logarithm, for a ratio, which no run has; as spread_of() of rtl_tlm/estimate/estimate.cpp."""
    pairs = len(influences) - 1
    squares = sum((after - before) ** 2 for before, after in zip(influences, influences[1:]))
    return student_quantile(0.975, max(2, 2 / 3 * pairs)) * math.sqrt(len(influences) / (2 * pairs) * squares + drift ** 2)


def case_of(what, name, frame, machine, truth, log_estimate, half, speed):
    """half: of the interval, on the logarithm."""
    off = log_estimate - math.log(truth)
    shown = hashlib.sha256(f"{name_of(frame)} {machine}".encode()).digest()[0] % 2
    return {"what": what, "frame": name_of(frame), "class": frame["class"], "public": "yes" if frame["scene"] in PUBLIC else "no",
            "warps": -(-frame["edge"] ** 2 // frame["rays"]), "machine": machine, "slots": MACHINES[machine][1], "design": name,
            "half": ("tune", "show")[shown], "error": 100 * math.expm1(off), "width": 100 * math.expm1(half),
            "held": abs(off) <= half, "speed": speed}


def cases_of(frames, exact, estimated):
    """Cases, reasons of refusals by case, and [(name, held)] of the other statistics' intervals."""
    cases, refused, statistics = [], {}, []
    for frame in frames:
        for machine, _ in frame["machines"]:
            known = {}
            for design in frame["designs"]:
                key = (name_of(frame), machine, design)
                if key not in estimated:
                    continue
                status, cpu, document = estimated[key]
                if status != "done":
                    refused[key] = document["why"]
                    continue
                if key not in exact or exact[key][0] != "done":
                    continue
                estimate, truth = document["windows"], exact[key][2]["stats"]
                influences = [influence for _, _, influence in estimate["evidence"]]
                known[design] = truth["gpu.cycles"], estimate["log_cycles"], influences, estimate["drift"]
                half = math.log(estimate["intervals"]["gpu.cycles"][1]) - estimate["log_cycles"]
                cases.append(case_of("cycles", design, frame, machine, *known[design][:2], half, exact[key][1] / cpu))
                statistics += [(name, low <= truth[name] <= high) for name, (low, high) in estimate["intervals"].items() if name in truth]
            first = frame["designs"][0]
            for design in frame["designs"][1:]:
                if first in known and design in known:
                    a, b = known[first], known[design]
                    cases.append(case_of("speed-up", f"{first} / {design}", frame, machine, a[0] / b[0], a[1] - b[1],
                                         reach([x - y for x, y in zip(a[2], b[2])], a[3] - b[3]), None))
    return cases, refused, statistics


def is_public_place(case):
    return case["public"] == "yes" and case["class"] != "object"


def seldom(statistics):
    """Names whose intervals hold less often than LEAST."""
    by_name = defaultdict(list)
    for name, held in statistics:
        by_name[name].append(held)
    return ", ".join(f"{name} {sum(held)} of {len(held)}" for name, held in sorted(by_name.items())
                     if len(held) >= FEWEST and sum(held) < LEAST * len(held))


def row(name, cases):
    if not cases:
        return f"| {name} | 0 | | | | | |"
    errors, held = sorted(abs(case["error"]) for case in cases), sum(case["held"] for case in cases)
    speeds = sorted(case["speed"] for case in cases if case["speed"])
    return (f"| {name} | {len(cases)} | {held} | {100 * held / len(cases):.0f} % | {sum(errors) / len(errors):.1f} %, {errors[-1]:.1f} % | "
            f"{sum(case['width'] for case in cases) / len(cases):.1f} % | {f'{speeds[len(speeds) // 2]:.1f}' if speeds else ''} |")


def report(frames, study, path):
    exact, estimated = study.found("cycle"), study.found("windows")
    cases, refused, statistics = cases_of(frames, exact, estimated)
    print("| cases | number | held | | error: mean, worst | half-width, mean | times as fast, median |\n|---|---|---|---|---|---|---|")

    def rows(key, names, text="{}"):
        return [(text.format(name), lambda case, name=name: case[key] == name) for name in names]

    for name, is_in in [("all", lambda case: True), *rows("half", ("tune", "show"), "half `{}`"), *rows("what", ("cycles", "speed-up")),
                        *rows("class", ("room", "building", "object")), ("public rooms and buildings", lambda case: is_public_place(case)),
                        ("public objects", lambda case: case["public"] == "yes" and case["class"] == "object"),
                        *rows("slots", sorted({slots for _, slots, _ in MACHINES.values()}), "{} slots"),
                        *rows("design", DESIGNS), ("20,000 warps and more", lambda case: case["warps"] >= 20000)]:
        print(row(name, [case for case in cases if is_in(case)]))
    print(f"\n{len({case['frame'] for case in cases})} frames, public rooms and buildings: "
          f"{', '.join(sorted({case['frame'] for case in cases if is_public_place(case)})) or 'none'}")
    hours = sum(cpu for found in (exact, estimated) for _, cpu, _ in found.values()) / 3600
    print(f"\n{len(refused)} runs refused; {hours:.2f} processor hours.")
    for key, why in refused.items():
        print(f"refused: {', '.join(key)}: {why}")
    for case in cases:
        if not case["held"]:
            print(f"missed: {case['frame']}, {case['machine']}, {case['design']}: {case['error']:+.1f} % at +- {case['width']:.1f} %")
    if statistics:
        share = 100 * sum(held for _, held in statistics) / len(statistics)
        print(f"statistics: {share:.0f} % of {len(statistics)} intervals held; below {LEAST:.0%}, of {FEWEST} and more: "
              f"{seldom(statistics) or 'none'}")
    if path:
        with open(path, "w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, list(cases[0]), lineterminator="\n")
            writer.writeheader()
            writer.writerows({key: f"{value:.4g}" if isinstance(value, float) else value for key, value in case.items()} for case in cases)
