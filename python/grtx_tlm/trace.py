# SPDX-License-Identifier: Apache-2.0
"""Traces (``.grtx``) as numpy arrays: what ``grtx trace-dump --json`` prints."""
import json
import operator
import os
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, SupportsIndex, overload

import numpy as np

from .errors import StrPath, TraceError
from .program import file, find_program

EVENT_KINDS = ("visit_internal", "visit_instance", "visit_leaf", "cull", "replay_take", "replay_forward")
#: What the test of a leaf gave, by number.
OUTCOMES = ("miss", "behind", "beyond", "inserted", "displaced", "rejected", "ignored", "nearest")
SLOTS = 8

NODE = np.dtype([("address", "u8"), ("child_base", "u8"), ("child_count", "u1"), ("child_kinds", "u1", (SLOTS,))])
RAY = np.dtype([("pixel", "u4"), ("rounds", "u4")])
ROUND = np.dtype([("lane", "u1"), ("round", "u4"), ("events", "u4"), ("replay", "?"), ("overflow", "?"),
                  ("terminated", "?"), ("preloaded", "u2"), ("k_count", "u2"), ("processed", "u2"),
                  ("eviction_dropped", "u4")])
EVENT = np.dtype([("lane", "u1"), ("round", "u4"), ("kind", "u1"), ("address", "u8"), ("detail", "u1"),
                  ("checkpoints", "u1"), ("shifts", "u2")])
BIN = np.dtype([("lane", "u1"), ("bin", "u1")])
PROCESSED = np.dtype([("lane", "u1"), ("round", "u4"), ("gaussian", "u4"), ("blended", "?")])


@dataclass(repr=False, eq=False)
class RayGroup:
    """The rays of one warp, as structured arrays of one dimension (``pandas.DataFrame(group.events)`` is a table).

    All addresses are bytes from the start of the node image.

    - ``index``, ``frame``: position in the file; frame of a sequence. ``kind``: 'primary', 'glass' or 'mirror'.
    - ``nodes``: the internal nodes visited, ascending: ``address``, ``child_base``, ``child_count``, ``child_kinds``
      (8 per node; 0 internal or unused, 1 instance, 2 procedural, 3 triangle).
    - ``rays``: one per lane: ``pixel`` (y * width + x), ``rounds``.
    - ``rounds``: in order of lane and round: ``events`` (how many), flags, k-buffer entries at begin (``preloaded``) and end
      (``k_count``), ``processed`` (how many), ``eviction_dropped``.
    - ``events``: in order: ``kind`` (see EVENT_KINDS), ``address``; of an internal visit ``detail`` and ``checkpoints`` are
      masks of pushed and checkpointed children; of a leaf ``detail`` is the outcome (see OUTCOMES); of an instance 1 if
      only the ray is transformed; else ``checkpoints`` is 1 if the node was checkpointed. ``shifts``: entries moved. If the
      header's ``any_hit`` is 'delayed', outcome and shifts are those of when the hit's turn came, behind the traversal.
      If its ``opacity_bound`` is 'on', ``checkpoints`` of a leaf inserted or displaced is the number of entries hidden.
      If its ``ahead`` is above 1, events stand depth first, but the ray did not handle them in that order.
    - ``processed``: k-buffer entries that the blending shader looked at: ``gaussian``, ``blended``.
    - ``bins``: with checkpoint bins, of each checkpoint entry in the order of writing: ``lane``, ``bin``.
    """

    index: int
    frame: int
    kind: str
    nodes: np.ndarray
    rays: np.ndarray
    rounds: np.ndarray
    events: np.ndarray
    processed: np.ndarray
    bins: np.ndarray

    def __repr__(self) -> str:
        return (f"<RayGroup {self.index}: {self.kind}, {len(self.rays)} rays, {len(self.rounds)} rounds, "
                f"{len(self.events)} events>")


class Trace:
    """A trace file, read by the program ``grtx``.

    ``Trace(path, program=None)``: the program is ``program``, else the environment's ``GRTX``, else ``grtx`` on the PATH.
    Groups are read when asked for, so a trace may be larger than memory. Raises TraceError for a damaged, cut or foreign
    file, OSError if program or file cannot be read.

    - ``version``: of the format. ``header``, ``totals``: dicts as in docs/model/trace-format.md.
    - ``content_hash``: 16 hex digits that name the trace in results.
    - ``len(trace)``: number of groups; ``trace[i]`` is the RayGroup i, ``trace[-1]`` the last, ``trace[2:8]`` a list of
      them; ``for group in trace`` reads one at a time, in one pass over the file.
    - ``verify()``: hashes, every group, totals (``grtx trace-check``).

    Use it in a ``with`` statement or not: it holds nothing open.
    """

    def __init__(self, path: StrPath, program: StrPath | None = None) -> None:
        self.path, self.program = os.fspath(path), find_program(program)
        with open(self.path, "rb"):
            pass
        about = json.loads(next(self._lines("trace-dump", "--json", "--lane", "0")))
        self.version: int = about["version"]
        self.header: dict[str, Any] = about["header"]
        self.totals: dict[str, int] = about["totals"]
        self.content_hash: str = about["content_hash"]

    def __repr__(self) -> str:
        of = self.header
        return (f"<Trace {self.path}: {of['width']} x {of['height']} pixels, {len(self)} groups, {self.totals['rays']} rays, "
                f"{of['accel']}, k = {of['k']}>")

    def __enter__(self) -> "Trace":
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def __len__(self) -> int:
        return self.header["groups"]

    def __iter__(self) -> Iterator[RayGroup]:
        return (group_of(json.loads(line)) for line in self._all())

    @overload
    def __getitem__(self, index: SupportsIndex) -> RayGroup: ...
    @overload
    def __getitem__(self, index: slice) -> list[RayGroup]: ...

    def __getitem__(self, index: SupportsIndex | slice) -> RayGroup | list[RayGroup]:
        if isinstance(index, slice):
            wanted = range(*index.indices(len(self)))
            if 4 * len(wanted) < len(self):
                return [self[i] for i in wanted]
            found = {i: group_of(json.loads(line)) for i, line in enumerate(self._all()) if i in wanted}
            return [found[i] for i in wanted]
        place = operator.index(index)
        if not -len(self) <= place < len(self):
            raise IndexError(f"{self.path}: group {place} of {len(self)}")
        return group_of(json.loads(list(self._lines("trace-dump", "--json", "--warp", str(place % len(self))))[1]))

    def _all(self) -> Iterator[str]:
        """The groups' lines, in one pass."""
        lines = self._lines("trace-dump", "--json")
        next(lines)
        return lines

    def verify(self) -> None:
        """Reads everything. Raises TraceError."""
        for _ in self._lines("trace-check", "--quiet"):
            pass

    def _lines(self, command: str, *options: str) -> Iterator[str]:
        """The lines that the program prints; it is ended when they are no longer wanted."""
        process = subprocess.Popen([self.program, command, file(self.path), *options], stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True)
        try:
            yield from process.stdout
            said = process.stderr.read().strip()
            if process.wait() != 0:
                line = (said.splitlines() or [f"{command} ended with {process.returncode}"])[0].removeprefix("grtx: ")
                place, colon, rule = line.removeprefix(f"{file(self.path)}: ").partition(": ")
                raise TraceError(self.path, place if colon else "", rule if colon else place)
        finally:
            process.kill()
            process.wait()
            process.stdout.close()
            process.stderr.close()


def read_trace(path: StrPath, program: StrPath | None = None) -> Trace:
    """Opens a trace: ``Trace(path, program)``."""
    return Trace(path, program)


def group_of(line: dict[str, Any]) -> RayGroup:
    """The RayGroup of a line of ``trace-dump --json`` (dict; docs/model/trace-format.md, "As JSON")."""
    nodes = [(n[0], n[1], len(n) - 2, n[2:] + [0] * (SLOTS + 2 - len(n))) for n in line["nodes"]]
    rays, rounds, events, processed, bins = [], [], [], [], []
    for ray in line["rays"]:
        lane, event, looked_at = ray["lane"], 0, 0
        rays.append((ray["pixel"], len(ray["rounds"])))
        bins += [(lane, bin) for bin in ray.get("bins", ())]
        for number, r in enumerate(ray["rounds"]):
            rounds.append((lane, number, *r))
            events += [(lane, number, *e) for e in ray["events"][event:event + r[0]]]
            processed += [(lane, number, *p) for p in ray["processed"][looked_at:looked_at + r[6]]]
            event, looked_at = event + r[0], looked_at + r[6]
    return RayGroup(line["group"], line["frame"], line["kind"], np.array(nodes, NODE), np.array(rays, RAY),
                    np.array(rounds, ROUND), np.array(events, EVENT), np.array(processed, PROCESSED), np.array(bins, BIN))
