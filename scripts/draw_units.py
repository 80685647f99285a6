#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Draws the figures of the unit pages, one SVG each in docs/images/units/: boxes, arrows, and bars of bytes or bits to scale.

Usage: draw_units.py [--check]
--check: writes nothing; exit code 1 and one line for each figure that is out of date.
"""
import os
import re
import sys
from xml.sax.saxutils import escape

FOLDER = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "docs", "images", "units")
WIDTH = 760
STYLE = """
.paper{fill:#fff} .area{fill:#f3f5f8;stroke:#c3cad5} .box{fill:#fff;stroke:#56657a} .unit{fill:#eaf3ff;stroke:#2f6db5}
.mem{fill:#eaf7ee;stroke:#2c8450} .mark{fill:#fff3dd;stroke:#b3750c} .none{fill:none;stroke:#aab4c3;stroke-dasharray:4 3}
.name{fill:#17202c;font-size:13px;font-weight:600} .label{fill:#45536a;font-size:11.5px}
.wire{stroke:#56657a;stroke-width:1.5;fill:none;marker-end:url(#tip)} .tip{fill:#56657a}
@media (prefers-color-scheme: dark){
.paper{fill:#12171e} .area{fill:#1a212b;stroke:#3a4658} .box{fill:#151b23;stroke:#8fa0b8} .unit{fill:#14283f;stroke:#6fa8e8}
.mem{fill:#132c1f;stroke:#63bd86} .mark{fill:#33270f;stroke:#e0a945} .none{stroke:#49586d}
.name{fill:#eef2f7} .label{fill:#b6c2d2} .wire{stroke:#8fa0b8} .tip{fill:#8fa0b8}}
"""


class Figure:
    style = STYLE

    def __init__(self, title, height):
        self.title, self.height, self.parts, self.places = title, height, [], {}

    def text(self, x, y, what, kind="label", anchor="middle"):
        self.parts.append(f'<text class="{kind}" x="{x:g}" y="{y:g}" text-anchor="{anchor}">{escape(what)}</text>')

    def box(self, key, x, y, width, height, name, *labels, kind="box"):
        """A box with a name and lines of text below it; raises where a line does not fit."""
        for what, letter in [(name, 7.4), *((label, 6.1) for label in labels)]:
            if len(what) * letter > width - 4:
                raise ValueError(f"{self.title}: '{what}' does not fit into {width}")
        self.places[key] = (x, y, width, height)
        self.parts.append(f'<rect class="{kind}" x="{x}" y="{y}" width="{width}" height="{height}" rx="6"/>')
        top = y + height / 2 + 4.5 - 7.5 * len(labels)
        if name:
            self.text(x + width / 2, top, name, "name")
        for line, label in enumerate(labels):
            self.text(x + width / 2, top + 15 * (line + 1) - (0 if name else 7.5), label)

    def point(self, place):
        """'key:side' or 'key:side.3': the middle of a side, or that share of it."""
        key, side = place.split(":")
        share = float(side[1:] or 0.5)
        x, y, width, height = self.places[key]
        return side[0], {"l": (x, y + share * height), "r": (x + width, y + share * height),
                         "t": (x + share * width, y), "b": (x + share * width, y + height)}[side[0]]

    def arrow(self, start, end, label="", dx=0, dy=-5, bend=0.5, anchor="middle"):
        """From side to side, with at most two corners; the label stands at the middle of the longest piece."""
        (out, (x1, y1)), (into, (x2, y2)) = self.point(start), self.point(end)
        if out in "lr" and into in "lr":
            middle = x1 + bend * (x2 - x1) if (out == "r") != (into == "r") else (max if out == "r" else min)(x1, x2) + bend
            points = [(x1, y1), (middle, y1), (middle, y2), (x2, y2)]
        elif out in "tb" and into in "tb":
            middle = y1 + bend * (y2 - y1) if (out == "b") != (into == "b") else (max if out == "b" else min)(y1, y2) + bend
            points = [(x1, y1), (x1, middle), (x2, middle), (x2, y2)]
        else:
            points = [(x1, y1), (x2, y1) if out in "lr" else (x1, y2), (x2, y2)]
        # Points on a straight line go, so that the label finds the middle.
        points = [p for i, p in enumerate(points) if i in (0, len(points) - 1) or not (
            points[i - 1][0] == p[0] == points[-1][0] or points[i - 1][1] == p[1] == points[-1][1])]
        self.parts.append('<path class="wire" d="M' + " L".join(f"{x:g} {y:g}" for x, y in points) + '"/>')
        if label:
            a, b = max(zip(points, points[1:]), key=lambda piece: abs(piece[0][0] - piece[1][0]) + abs(piece[0][1] - piece[1][1]))
            self.text((a[0] + b[0]) / 2 + dx, (a[1] + b[1]) / 2 + dy, label, anchor=anchor)

    def bar(self, y, name, fields, scale, left=150, unit=""):
        """A row of fields (first, end, text, kind) to scale; a text that does not fit stands below its field."""
        self.text(left - 8, y + 17, name, anchor="end")
        for first, end, what, kind in fields:
            x, width = left + first * scale, (end - first) * scale
            self.parts.append(f'<rect class="{kind}" x="{x:g}" y="{y}" width="{width:g}" height="26"/>')
            if what and len(what) * 6.1 <= width - 2:
                self.text(x + width / 2, y + 17, what)
            elif what:
                self.text(x + width / 2, y + 39, what)
        self.text(left + max(end for _, end, _, _ in fields) * scale + 6, y + 17, unit, anchor="start")

    def svg(self):
        return (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {self.height}" width="{WIDTH}" height="{self.height}" '
                f'font-family="system-ui, \'DejaVu Sans\', sans-serif" role="img" aria-label="{escape(self.title)}">\n'
                f"<title>{escape(self.title)}</title>\n<style>{self.style}</style>\n"
                '<defs><marker id="tip" viewBox="0 0 10 10" refX="9" refY="5" markerWidth="7" markerHeight="7" orient="auto">'
                '<path class="tip" d="M0 0 L10 5 L0 10 z"/></marker></defs>\n'
                f'<rect class="paper" width="{WIDTH}" height="{self.height}"/>\n' + "\n".join(self.parts) + "\n</svg>\n")


def default(key):
    """A key's default as docs/model/configuration.md, which the program prints, has it."""
    with open(os.path.join(FOLDER, "..", "..", "model", "configuration.md"), encoding="utf-8") as file:
        return re.search(rf"^\* `{re.escape(key)}` \(([^;)]*)", file.read(), re.M).group(1)


def checkpoint_lists():
    f = Figure("Checkpoint lists of a ray over two rounds", 330)
    f.box("r0", 10, 10, 740, 130, "", kind="area")
    f.text(20, 28, "round r, from the root: each reported hit lowers t_max to its t", "label", "start")
    f.box("walk", 25, 50, 150, 70, "traversal", "k nearest hits", "to the k-buffer", kind="unit")
    f.box("dest", 405, 50, 150, 70, "destination", "buffer r mod 2", "(node, leaf, t) each", kind="mem")
    f.arrow("walk:r", "dest:l", "nodes and leaves beyond t_max")
    f.text(650, 80, "not fetched again")
    f.text(650, 96, "until their turn")
    f.box("r1", 10, 170, 740, 150, "", kind="area")
    f.text(20, 188, "round r + 1, replay: t_max begins at the end of the ray again", "label", "start")
    f.box("source", 405, 215, 150, 70, "source", "the same buffer,", "read in order", kind="mem")
    f.arrow("dest:b", "source:t", "becomes", dx=8, anchor="start", dy=0)
    f.box("take", 25, 200, 190, 44, "take: t ≤ t_max", "push, fetch, traverse", kind="unit")
    f.box("next", 25, 266, 190, 44, "forward: t > t_max", "no fetch", kind="mark")
    f.arrow("source:l.3", "take:r", "", bend=0.4)
    f.arrow("source:l.7", "next:r", "", bend=0.4)
    f.box("dest2", 600, 215, 140, 70, "destination", "buffer (r + 1)", "mod 2", kind="mem")
    f.arrow("next:b", "dest2:b", "", bend=6)
    f.text(310, 309, "forwarded")
    return f


def checkpoint_entries():
    f = Figure("Bits of a checkpoint entry in its four sizes", 250)
    sibling, node, leaf, scene, t = (("siblings", "box"), ("node", "unit"), ("instance leaf", "mem"), ("scene leaf", "area"),
                                     ("t", "mark"))
    rows = [
        ("20 B (default)", [(0, 40, *node), (40, 59, *sibling), (59, 64, "", "none"), (64, 104, *leaf),
                            (104, 128, *scene), (128, 160, *t)]),
        ("16 B", [(0, 32, *t), (32, 64, *node), (64, 96, *leaf), (96, 115, *sibling), (115, 127, "scene leaf", "area"), (127, 128, "", "none")]),
        ("8 B", [(0, 31, *t), (31, 32, "", "none"), (32, 37, "", "unit"), (37, 64, "node, leaf", "mem")]),
        ("28 B", [(0, 40, *node), (40, 59, *sibling), (59, 64, "", "none"), (64, 104, *leaf), (104, 128, "", "none"),
                  (128, 192, "scene leaf, its own address", "area"), (192, 224, *t)]),
    ]
    for index, (name, fields) in enumerate(rows):
        f.bar(12 + 56 * index, name, fields, 2.75, left=115)
    f.text(115, 242, "Bits from 0 on. Dashed: unused. 8 B: b bits are the BLAS node.", anchor="start")
    return f


def k_buffer():
    f = Figure("What the any-hit shader does with a hit, k = 4", 300)
    for x, what in [(45, "hit"), (190, "k-buffer before"), (425, "k-buffer after"), (590, "eviction buffer"), (700, "t_max")]:
        f.text(x, 20, what, "name")
    rows = [
        ("inserted: room", 1.9, [1.1, 2.4], [1.1, 1.9, 2.4], "–", "stays"),
        ("displaced: full, nearer than the last", 1.5, [1.1, 1.9, 2.4, 2.8], [1.1, 1.5, 1.9, 2.4], "2.8", "stays"),
        ("rejected and reported: full, not nearer", 3.2, [1.1, 1.5, 1.9, 2.4], [1.1, 1.5, 1.9, 2.4], "2.8, 3.2", "3.2"),
    ]
    for index, (what, hit, before, after, evicted, limit) in enumerate(rows):
        y = 58 + 68 * index
        f.text(10, y - 8, what, anchor="start")
        f.box("hit", 20, y, 50, 30, "", f"{hit}", kind="mark")
        for left, entries in [(100, before), (335, after)]:
            for cell in range(4):
                entry = f"{entries[cell]}" if cell < len(entries) else "–"
                f.box(f"cell{left}", left + 45 * cell, y, 45, 30, "", entry,
                      kind="mark" if left == 335 and entry == f"{hit}" else "unit" if entry != "–" else "none")
        f.places["before"], f.places["after"] = (100, y, 180, 30), (335, y, 180, 30)
        f.arrow("hit:r", "before:l")
        f.arrow("before:r", "after:l")
        f.box("out", 545, y, 90, 30, "", evicted, kind="mem" if evicted != "–" else "none")
        f.box("limit", 670, y, 60, 30, "", limit, kind="mark" if limit != "stays" else "none")
    f.text(10, 262, "The next round fills its k-buffer with the k nearest hits of the eviction buffer (preloaded) and blends them in order.",
           anchor="start")
    f.text(10, 282, "With checkpointing only: without it, evicted hits are found again from the root. tmax-update kth: t_max is the k-th t.",
           anchor="start")
    return f


def node_formats():
    f = Figure("Bytes of nodes in the layouts", 480)
    box, triangle, matrix, link, other = "unit", "mem", "mark", "area", "box"
    rows = [
        ("vulkan_sim", None),
        ("internal", [(0, 12, "origin", box), (12, 16, "", link), (16, 28, "kinds", other), (28, 64, "6 boxes of 8 bits", box)]),
        ("triangle leaf", [(0, 16, "index", other), (16, 64, "three vertices", triangle)]),
        ("instance leaf", [(0, 16, "id, root", link), (16, 64, "world to object", matrix), (64, 80, "BLAS, id", link),
                           (80, 128, "object to world", matrix)]),
        ("compact", None),
        ("internal", [(0, 12, "origin", box), (12, 16, "", link), (16, 32, "kinds", other), (32, 80, "8 boxes of 8 bits", box)]),
        ("triangle leaf", [(0, 72, "six vertices: up to four faces", triangle), (72, 80, "id", other)]),
        ("instance leaf", [(0, 48, "world to object", matrix), (48, 80, "root, BLAS, id", link), (80, 128, "object to world", matrix),
                           (128, 160, "zero", "none")]),
        ("compressed", None),
        ("internal", [(0, 12, "origin", box), (12, 16, "", link), (16, 22, "", other), (22, 64, "8 boxes of 7 bits", box)]),
        ("instance leaf", [(0, 48, "world to object", matrix), (48, 64, "root, id", link)]),
        ("quantised", None),
        ("leaf, instance", [(0, 4.25, "", link), (4.25, 12.5, "mean", matrix), (12.5, 32, "world to unit", matrix)]),
    ]
    y = 8
    for name, fields in rows:
        if fields is None:
            f.text(10, y + 18, name, "name", "start")
            y += 28
            continue
        f.bar(y, name, fields, 3.7, left=110, unit=f"{fields[-1][1]} B")
        y += 40
    f.text(300, 26, "small field of internal nodes: child offset, i32", anchor="start")
    return f


def l1_cache():
    f = Figure("L1 data cache", 320)
    for index, client in enumerate(["rt_node", "simt", "rt_checkpoint", "rt_prefetch", "rt_stack"]):
        f.box(client, 10, 24 + 46 * index, 110, 34, client)
    f.places["clients"] = (10, 24, 110, 218)
    f.box("pick", 170, 90, 140, 80, "accept", "one per bank/cycle,", "rotating priority;", "else stall.*", kind="unit")
    f.arrow("clients:r", "pick:l", "")
    f.box("tags", 370, 34, 150, 70, "tags and data", "banks; 32 B sectors", "of 128 B lines", kind="mem")
    f.arrow("pick:t", "tags:l", "hit", dx=0)
    f.box("mshr", 370, 130, 150, 50, "MSHRs", "a sector each; merge", kind="unit")
    f.arrow("pick:r.6", "mshr:l", "miss")
    f.box("queue", 580, 130, 160, 50, "miss queue", "one per cycle", kind="unit")
    f.arrow("mshr:r", "queue:l")
    f.box("back", 580, 210, 160, 50, "write-back buffer", "dirty lines that leave", kind="unit")
    f.arrow("tags:r.7", "back:l", "", bend=0.5)
    f.text(545, 225, "victim", anchor="end")
    f.box("xbar", 580, 285, 160, 28, "crossbar", kind="area")
    f.arrow("back:b", "xbar:t")
    f.arrow("queue:r.5", "xbar:r.5", "", bend=12)
    f.box("fill", 370, 279, 150, 40, "fill", "one sector per cycle", kind="unit")
    f.arrow("xbar:l", "fill:r")
    f.arrow("fill:l", "clients:b.7", "answers every waiter", dx=20)
    f.arrow("tags:t.3", "clients:t.5", "", bend=-14)
    f.text(250, 24, "hit: after latency")
    return f


def l2_slice():
    f = Figure("L2 slice", 230)
    f.box("in", 10, 30, 100, 50, "crossbar", "request", kind="area")
    f.box("pipe", 150, 30, 150, 50, "pipeline", "l2.latency, 165 cycles", kind="unit")
    f.box("tags", 340, 20, 150, 70, "tags and data", "write-back,", "write-allocate", kind="mem")
    f.box("reply", 540, 30, 100, 50, "reply queue", kind="unit")
    f.box("out", 670, 30, 80, 50, "crossbar", "reply", kind="area")
    f.arrow("in:r", "pipe:l")
    f.arrow("pipe:r", "tags:l")
    f.arrow("tags:r", "reply:l", "hit")
    f.arrow("reply:r", "out:l")
    f.box("mshr", 340, 150, 150, 50, "MSHRs", "merge a sector's reads", kind="unit")
    f.box("dramq", 540, 150, 100, 50, "DRAM queue", kind="unit")
    f.box("dram", 670, 150, 80, 50, "DRAM", "socket", kind="area")
    f.arrow("tags:b.3", "mshr:t.3", "miss", dx=-18, dy=4)
    f.arrow("mshr:r", "dramq:l", "read")
    f.arrow("tags:b.8", "dramq:t", "dirty victim", dx=0)
    f.arrow("dramq:r", "dram:l")
    f.arrow("dram:b", "mshr:b", "fill: answers the waiters", bend=14, dy=12)
    return f


def dram_channel():
    f = Figure("A DRAM channel", 220)
    f.box("slice", 10, 60, 90, 60, "L2 slices", "in turn", kind="area")
    f.box("queue", 140, 60, 110, 60, "queue", "bursts; one", "request waits", kind="unit")
    f.box("banks", 300, 10, 150, 60, "each bank's", "oldest request,", "oldest row hit", kind="unit")
    f.box("policy", 300, 120, 150, 60, "dram.scheduling", "fr_fcfs, fr_fcfs_cap,", "fcfs", kind="mark")
    f.box("commands", 500, 60, 110, 60, "commands", "one row, one", "column per clock", kind="unit")
    f.box("cells", 650, 10, 100, 60, "banks", "rcd, ras, rp,", "rrd, faw, …", kind="mem")
    f.box("bus", 650, 120, 100, 60, "data bus", "ccd a burst,", "turn", kind="mem")
    f.arrow("slice:r", "queue:l")
    f.arrow("queue:r.3", "banks:l", "")
    f.arrow("banks:b", "policy:t", "")
    f.arrow("policy:r", "commands:b", "")
    f.arrow("banks:r", "commands:t", "timing allows", dy=-5)
    f.arrow("commands:r.3", "cells:l", "")
    f.arrow("commands:r.7", "bus:l", "")
    f.arrow("bus:b", "slice:b", "response, fixed_latency clocks after the last data", bend=30, dy=-4)
    return f


def crossbar():
    f = Figure("Crossbar: one of its two networks (requests; replies run the other way)", 210)
    for index, what in enumerate(["SM 0", "SM 1", "SM n"]):
        f.box(f"in{index}", 10, 15 + 65 * index, 110, 44, what, "head of its link", kind="area")
    for index, what in enumerate(["slice 0", "slice m"]):
        y = 25 + 100 * index
        f.box(f"pick{index}", 290, y, 120, 60, "arbiter", "round robin,", "one per cycle", kind="unit")
        f.box(f"buffer{index}", 450, y, 150, 60, "in transit, buffer", "latency packets,", "then output_buffer", kind="mem")
        f.box(f"out{index}", 650, y + 8, 100, 44, what, kind="area")
        f.arrow(f"pick{index}:r", f"buffer{index}:l")
        f.arrow(f"buffer{index}:r", f"out{index}:l")
    f.arrow("in0:r.3", "pick0:l.2", bend=0.5)
    f.arrow("in0:r.7", "pick1:l.2", bend=0.35)
    f.arrow("in1:r.3", "pick0:l.5", bend=0.65)
    f.arrow("in1:r.7", "pick1:l.5", bend=0.55)
    f.arrow("in2:r.3", "pick0:l.8", bend=0.8)
    f.arrow("in2:r.7", "pick1:l.8", bend=0.5)
    return f


def memory_scheduler():
    f = Figure("Memory scheduler: from visits to sectors and back", 200)
    f.box("lanes", 10, 40, 110, 60, "lanes", "of one warp,", "a node each", kind="area")
    f.box("merge", 160, 40, 130, 60, "merge", "one node: one fetch,", "also in flight", kind="unit")
    f.box("queue", 330, 40, 120, 60, "queue", "64 fetches", kind="unit")
    f.box("sectors", 490, 40, 120, 60, "sectors", "oldest fetch first,", "one per cycle", kind="unit")
    f.box("l1", 650, 40, 100, 60, "L1", "client rt_node", kind="area")
    for a, b in ["lanes merge".split(), "merge queue".split(), "queue sectors".split(), "sectors l1".split()]:
        f.arrow(f"{a}:r", f"{b}:l")
    f.box("table", 330, 140, 280, 44, "table of fetches, a record a lane", "complete: all sectors are back", kind="mem")
    f.arrow("l1:b", "table:r")
    f.arrow("table:l", "lanes:b", "the lanes go to their unit", dx=20)
    f.box("simt", 490, 2, 260, 26, "", "rt.memory.by_shader: NodeFetchBatch", kind="none")
    f.arrow("queue:t", "simt:l", "")
    return f


def intersection_units():
    f = Figure("Intersection units: all of one kind", 190)
    f.box("dispatch", 10, 55, 130, 70, "node dispatch", "lanes whose node", "has come", kind="area")
    for index, (name, what) in enumerate([("ray_box", "internal nodes"), ("ray_transform", "instance leaves"),
                                          ("ray_triangle", "triangle leaves"), ("ray_sphere", "or ray_gaussian")]):
        f.box(name, 190, 8 + 45 * index, 150, 36, name, what, kind="unit")
        f.arrow("dispatch:r", f"{name}:l", bend=0.4)
    f.box("queue", 390, 20, 130, 60, "queue", "in order; a place", "for every lane", kind="mem")
    f.box("pipes", 560, 20, 190, 60, "pipelines: count", "one start an interval,", "result after latency", kind="unit")
    f.text(455, 12, "each unit:", anchor="middle")
    f.arrow("queue:r", "pipes:l")
    f.box("result", 560, 120, 190, 50, "result", "lane: next state", kind="area")
    f.arrow("pipes:b", "result:t")
    f.arrow("ray_transform:r", "queue:l", bend=0.5)
    f.text(455, 140, "an ellipsoid: ray_transform,")
    f.text(455, 155, "then ray_sphere or ray_gaussian")
    return f


def lane_states():
    f = Figure("States of a lane in the warp buffer", 270)
    f.box("idle", 10, 20, 110, 36, "idle")
    f.box("ready", 170, 110, 110, 44, "ready", kind="mark")
    f.box("memory", 350, 20, 150, 36, "waiting_memory", kind="unit")
    f.box("unit", 600, 20, 150, 36, "in_unit", kind="unit")
    f.box("wait", 600, 100, 150, 36, "waiting_any_hit", kind="unit")
    f.box("shader", 600, 180, 150, 36, "in_any_hit", kind="unit")
    f.box("stack", 350, 90, 190, 36, "waiting_stack", kind="unit")
    f.box("write", 350, 148, 190, 36, "waiting_checkpoint_write", kind="unit")
    f.box("read", 350, 206, 190, 36, "waiting_checkpoint_read", kind="unit")
    f.box("done", 10, 114, 110, 36, "finished", kind="mem")
    f.arrow("idle:r", "ready:t", "call accepted")
    f.arrow("ready:r.2", "memory:l", "visit", bend=0.5, dx=-18)
    f.arrow("memory:r", "unit:l", "node came")
    f.arrow("unit:b", "wait:t", "hit", dx=6, dy=4, anchor="start")
    f.arrow("wait:b", "shader:t", "batch", dx=6, dy=4, anchor="start")
    f.arrow("unit:l.8", "stack:r.3", "", bend=0.5)
    f.arrow("shader:l", "stack:r.8", "", bend=0.5)
    f.arrow("stack:b", "write:t", "")
    f.arrow("write:l", "ready:r.75", "", bend=0.5)
    f.arrow("ready:b.7", "read:l", "source entry")
    f.arrow("read:t", "write:b", "")
    f.arrow("ready:l", "done:r", "")
    f.text(145, 172, "no event left")
    f.text(20, 255, "waiting_stack and waiting_checkpoint_write: only if needed", anchor="start")
    return f


def stack_unit():
    f = Figure("Stack of a lane: warp buffer and memory", 190)
    f.text(20, 26, "top", anchor="start")
    for cell in range(8):
        f.box(f"s{cell}", 20 + 45 * cell, 36, 45, 40, "", f"{cell}", kind="unit")
    f.places["chip"] = (20, 36, 360, 40)
    f.text(20, 96, "warp buffer: stack_entries (8)", anchor="start")
    for cell in range(4):
        f.box(f"m{cell}", 470 + 45 * cell, 36, 45, 40, "", f"{8 + cell}", kind="mem")
    f.places["memory"] = (470, 36, 180, 40)
    f.text(670, 60, "… 256", anchor="start")
    f.text(560, 96, "memory, region stack")
    f.arrow("s7:t", "m0:t", "spill: the lowest sector", bend=-14)
    f.arrow("memory:b.2", "chip:b.6", "fill: when the warp buffer's part is empty and the next event takes the top", bend=64, dy=14)
    f.text(20, 178, "A sector is two entries of 16 B (four of 8 B without t). One a cycle is sent; the lane waits for its last.",
           anchor="start")
    return f


def prefetcher():
    f = Figure("Prefetcher of the RT unit", 90)
    f.box("sibling", 10, 10, 230, 70, "siblings of a leaf", "rt.prefetch.enabled", kind="unit")
    f.box("queue", 330, 10, 150, 70, "queue", "rt.prefetch.queue (32)", "merged, dropped", kind="mem")
    for name in ["sibling"]:
        f.arrow(f"{name}:r", "queue:l", bend=0.5)
    f.box("l1", 600, 32, 150, 70, "L1", "client rt_prefetch:", "useful, late, unused", kind="area")
    f.arrow("queue:r", "l1:l", "sector per cycle")
    return f


def work_distributor():
    f = Figure("Work distributor", 190)
    f.box("trace", 10, 60, 110, 60, "trace file", "groups in order", kind="area")
    f.box("source", 160, 60, 140, 60, "TraceSource", "pool of decoded", "groups, ahead", kind="mem")
    f.box("distributor", 350, 60, 150, 60, "work distributor", "one launch per cycle,", "SMs in turn", kind="unit")
    f.arrow("trace:r", "source:l")
    f.arrow("source:r", "distributor:l")
    for index, sm in enumerate(["SM 0", "SM 1", "SM n"]):
        f.box(f"sm{index}", 600, 10 + 62 * index, 150, 46, sm, "lowest free warp slot", kind="area")
        f.arrow("distributor:r", f"sm{index}:l", bend=0.5)
    f.arrow("sm2:l.9", "distributor:b", "")
    f.text(420, 150, "WarpEnded: slot and group are free", anchor="end")
    return f


def any_hit_unit():
    f = Figure("Any-hit unit: a heap for each ray, in registers", 200)
    f.box("gaussian", 10, 20, 150, 60, "ray_gaussian", "peak of the response,", "alpha", kind="unit")
    f.box("queue", 220, 20, 130, 60, "hits that wait", "lane l: logic", "l mod count", kind="mem")
    f.box("logic", 410, 20, 150, 60, "heap logic", "compare, swap: 2 to 12", "cycles per hit", kind="unit")
    f.box("heaps", 620, 20, 130, 60, "registers", "k hits a ray:", "t, alpha, id", kind="mem")
    f.box("lane", 410, 130, 150, 50, "lane goes on", "t_max: root of the heap", kind="area")
    f.box("simt", 620, 130, 130, 50, "SIMT core", "blends; stores", "what falls out", kind="area")
    f.arrow("gaussian:r", "queue:l")
    f.arrow("queue:r", "logic:l")
    f.arrow("logic:r", "heaps:l", "")
    f.arrow("logic:b", "lane:t", "")
    f.arrow("heaps:b", "simt:t", "in order")
    return f


def warp_walk():
    f = Figure("A warp's stack, its node slots and where children come", 220)
    f.text(20, 20, "top", anchor="start")
    rows = [("a", "11…1", "unit"), ("b", "under way", "mark"), ("c", "0110…", "unit"), ("d", "under way", "mark"),
            ("e", "1…", "unit"), ("f", "…01", "unit")]
    for row, (name, mask, kind) in enumerate(rows):
        f.box(name, 20, 28 + 28 * row, 150, 26, f"node {name}: {mask}", kind=kind)
    f.box("memory", 20, 198, 150, 20, "memory: spilled", kind="mem")
    f.box("slots", 250, 50, 150, 70, "node slots", f"ahead ({default('rt.warp_stack.ahead')}): record,", "lanes in tests", kind="mem")
    f.box("units", 460, 20, 130, 60, "units", "a test per lane", kind="unit")
    f.box("hits", 460, 120, 130, 60, "hits", "128, a list a lane", kind="mem")
    f.box("any", 650, 120, 110, 60, "any-hit unit", "or collector", kind="area")
    f.box("fetch", 250, 158, 150, 50, "memory scheduler", "once for all lanes", kind="area")
    f.arrow("b:r", "slots:l.2", "", bend=0.5)
    f.arrow("d:r", "slots:l.8", "", bend=0.5)
    f.arrow("slots:r.2", "units:l", "", bend=0.5)
    f.arrow("units:b", "hits:t", "")
    f.arrow("hits:r", "any:l", "")
    f.arrow("fetch:t", "slots:b", "")
    f.text(620, 45, "children of b come", anchor="start")
    f.text(620, 60, "between a and c", anchor="start")
    return f


FIGURES = {
    "checkpoint-lists": checkpoint_lists, "checkpoint-entries": checkpoint_entries, "k-buffer": k_buffer,
    "node-formats": node_formats, "l1-cache": l1_cache, "l2-slice": l2_slice, "dram-channel": dram_channel, "crossbar": crossbar,
    "memory-scheduler": memory_scheduler, "intersection-units": intersection_units, "lane-states": lane_states,
    "stack-unit": stack_unit, "prefetcher": prefetcher, "work-distributor": work_distributor, "any-hit-unit": any_hit_unit,
    "warp-walk": warp_walk}


def main():
    if sys.argv[1:] not in ([], ["--check"]):
        sys.exit(__doc__.strip())
    stale = 0
    for name, draw in FIGURES.items():
        path, svg = os.path.join(FOLDER, name + ".svg"), draw().svg()
        old = ""
        if os.path.exists(path):
            with open(path, encoding="utf-8") as file:
                old = file.read()
        if svg == old:
            continue
        stale += 1
        if sys.argv[1:]:
            print(f"docs/images/units/{name}.svg: out of date: run scripts/draw_units.py")
            continue
        os.makedirs(FOLDER, exist_ok=True)
        with open(path, "w", encoding="utf-8") as file:
            file.write(svg)
    return 1 if sys.argv[1:] and stale else 0


if __name__ == "__main__":
    sys.exit(main())
