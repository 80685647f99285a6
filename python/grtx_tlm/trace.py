"""Reads traces (``.grtx``): header, totals and groups of rays.

Written from docs/model/trace-format.md alone, as a second implementation beside the program's.
"""
import json
import os
import struct

import numpy as np
import xxhash

from .errors import TraceError
from .trace_columns import BadColumn
from .trace_group import decode_group
from .trace_header import BadHeader, checked_header, checked_totals

MAGIC = b"\x93GRTX\r\n\x1a"
END_MAGIC = b"GRTXEND\n"
OLDEST_VERSION, NEWEST_VERSION = 4, 7
EVENT_KINDS = ("visit_internal", "visit_instance", "visit_leaf", "cull", "replay_take", "replay_forward")
_MAX_HEADER, _MAX_TOTALS = 1 << 20, 1 << 16


def _xxh3(data):
    return xxhash.xxh3_64_intdigest(data)


def _object(pairs):
    names = [name for name, _ in pairs]
    if len(set(names)) != len(names):
        raise BadHeader("a key stands twice")
    return dict(pairs)


def _no_constant(name):
    raise BadHeader(f"{name} is no number")


class Trace:
    """A trace file, open for reading.

    ``Trace(path, max_group_bytes=2**28)`` reads header and footer; groups are read when asked for, so a trace may be
    larger than memory. ``max_group_bytes`` bounds what one group may inflate to (the format allows 1 GiB).
    Raises TraceError for damaged, cut or foreign files, OSError if the file cannot be read.

    - ``version``: 4 to 7. ``header``, ``totals``: dicts as in docs/model/trace-format.md.
    - ``content_hash``: 16 hex digits that name the trace in results.
    - ``len(trace)``: number of groups; ``trace[i]`` is the RayGroup i; ``for group in trace`` reads one at a time.
    - ``verify()``: reads the whole file, compares content hash and totals.

    Use it in a ``with`` statement, or call ``close()``.
    """

    def __init__(self, path, max_group_bytes=1 << 28):
        self.path, self.max_group_bytes = os.fspath(path), max_group_bytes
        self._file = open(self.path, "rb")
        try:
            self._bytes = os.fstat(self._file.fileno()).st_size
            self._read_header()
            self._read_footer()
        except BaseException:
            self._file.close()
            raise

    def close(self):
        self._file.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def __len__(self):
        return len(self._offsets)

    def __iter__(self):
        return (self[i] for i in range(len(self)))

    def __getitem__(self, index):
        if not 0 <= index < len(self):
            raise IndexError(f"{self.path}: group {index} of {len(self)}")
        place = f"group {index}"
        offset = self._offsets[index]
        size, digest = struct.unpack("<IQ", self._read(offset, 12, place))
        end = self._offsets[index + 1] if index + 1 < len(self) else self._footer_at
        if offset + 12 + size != end:
            raise self._error(place, "its chunk does not end where the next part begins")
        payload = self._read(offset + 12, size, place)
        if _xxh3(payload) != digest:
            raise self._error(place, "its hash does not match")
        try:
            return decode_group(payload, index, self.frame_of(index), self.header, self.max_group_bytes)
        except BadColumn as error:
            raise self._error(place, str(error)) from None

    def frame_of(self, index):
        """Number of the frame that group ``index`` belongs to."""
        for frame, groups in enumerate(self.header.get("frame_groups", [])[:-1]):
            if index < groups:
                return frame
            index -= groups
        return max(0, len(self.header.get("frame_groups", [])) - 1)

    def verify(self):
        """Reads everything: content hash, all groups, totals. Raises TraceError. Gives the totals counted (dict)."""
        hash_ = xxhash.xxh3_64()
        self._file.seek(0)
        left = self._content_hash_at
        while left:
            block = self._file.read(min(left, 1 << 20))
            if not block:
                raise self._error("content", "the file became shorter while it was read")
            hash_.update(block)
            left -= len(block)
        if f"{hash_.intdigest():016x}" != self.content_hash:
            raise self._error("content", "its hash does not match")
        counted = dict.fromkeys(self.totals, 0)
        for group in self:
            for name, value in count(group, self.header).items():
                counted[name] = max(counted[name], value) if name.startswith("max_") else counted[name] + value
        for name, value in counted.items():
            if value != self.totals[name]:
                raise self._error("totals", f"{name} is {self.totals[name]}, the groups have {value}")
        return counted

    def _error(self, place, rule):
        return TraceError(self.path, place, rule)

    def _read(self, offset, size, place):
        if min(offset, size) < 0 or offset + size > self._bytes:
            raise self._error(place, f"reaches beyond the end of the file, {self._bytes} bytes")
        self._file.seek(offset)
        data = self._file.read(size)
        if len(data) != size:
            raise self._error(place, "cannot be read whole")
        return data

    def _json(self, data, place, check):
        try:
            value = json.loads(data.decode("utf-8"), object_pairs_hook=_object, parse_constant=_no_constant)
            if not isinstance(value, dict):
                raise BadHeader("is no JSON object")
            return check(value)
        except (UnicodeDecodeError, json.JSONDecodeError, RecursionError) as error:
            raise self._error(place, f"is no JSON: {error}") from None
        except BadHeader as error:
            raise self._error(place, str(error)) from None

    def _read_header(self):
        preamble = self._read(0, 24, "preamble")
        magic, self.version, size, digest = struct.unpack("<8sIIQ", preamble)
        if magic != MAGIC:
            raise self._error("preamble", "this is no trace: write one with 'grtx trace -o'")
        if not OLDEST_VERSION <= self.version <= NEWEST_VERSION:
            raise self._error("preamble", f"version {self.version}; known are {OLDEST_VERSION} to {NEWEST_VERSION}. "
                                          "Trace the view again with 'grtx trace'")
        if size > _MAX_HEADER:
            raise self._error("header", f"{size} bytes are more than 1 MiB")
        data = self._read(24, size, "header")
        if _xxh3(data) != digest:
            raise self._error("header", "its hash does not match")
        self.header = self._json(data, "header", lambda value: checked_header(value, self.version))
        self._first_chunk = 24 + size

    def _read_footer(self):
        self._footer_at, magic = struct.unpack("<Q8s", self._read(self._bytes - 16, 16, "trailer"))
        if magic != END_MAGIC:
            raise self._error("trailer", "the file is cut: its end is missing")
        footer = self._read(self._footer_at, self._bytes - 16 - self._footer_at, "footer")
        if len(footer) < 8 + 4 + 16 or _xxh3(footer[:-8]) != struct.unpack("<Q", footer[-8:])[0]:
            raise self._error("footer", "its hash does not match")
        groups, = struct.unpack_from("<Q", footer)
        if groups != self.header["groups"] or 8 + 8 * groups + 4 + 16 > len(footer):
            raise self._error("footer", f"{groups} groups, of which the header knows {self.header['groups']}")
        self._offsets = np.frombuffer(footer, "<u8", groups, 8).tolist()
        starts = self._offsets + [self._footer_at]
        if starts[0] != self._first_chunk or any(a + 12 > b for a, b in zip(starts, starts[1:])):
            raise self._error("footer", "chunks do not follow each other without gaps")
        at = 8 + 8 * groups
        size, = struct.unpack_from("<I", footer, at)
        if size > _MAX_TOTALS or at + 4 + size + 16 != len(footer):
            raise self._error("footer", "its length does not match that of the totals")
        self.totals = self._json(footer[at + 4:at + 4 + size], "totals", checked_totals)
        self.content_hash = f"{struct.unpack_from('<Q', footer, at + 4 + size)[0]:016x}"
        self._content_hash_at = self._footer_at + at + 4 + size


def read_trace(path, **options):
    """Opens a trace: ``Trace(path, **options)``."""
    return Trace(path, **options)


def count(group, header):
    """What a group adds to the totals (dict, keys of the totals; ``max_*`` are maxima). ``group``: RayGroup."""
    events, rounds = group.events, group.rounds
    kind, outcome = events["kind"], events["detail"]
    leaf = kind == 2
    checkpointed = np.where(kind == 0, _POPCOUNT[events["checkpoints"]], events["checkpoints"]).astype(np.int64)
    evicted = leaf & ((outcome == 4) | (outcome == 5)) if header["checkpoint"] else np.zeros(len(events), bool)
    per_round, per_lane = {}, 0
    if header["checkpoint"]:
        where = events["lane"].astype(np.int64) << 32 | events["round"]
        written_at = checkpointed > 0
        places, inverse = np.unique(where[written_at], return_inverse=True)
        per_round = np.bincount(inverse, checkpointed[written_at], len(places)) if len(places) else ()
        evictions = dict(zip(*np.unique(where[evicted], return_counts=True)))
        per_lane = _most_evictions(rounds, evictions)
    return {
        "rays": len(group.rays), "rounds": len(rounds), "visits_internal": int(np.sum(kind == 0)),
        "visits_instance": int(np.sum(kind == 1)), "visits_leaf": int(np.sum(leaf)), "culls": int(np.sum(kind == 3)),
        "any_hit_calls": int(np.sum(leaf & (outcome >= 3) & (outcome <= 6))), "evictions": int(np.sum(evicted)),
        "checkpoints_written": int(checkpointed.sum()), "checkpoints_read": int(np.sum(kind >= 4)),
        "overflows": int(np.sum(rounds["overflow"])), "processed": len(group.processed),
        "blended": int(np.sum(group.processed["blended"])),
        "max_checkpoints_per_round": int(max(per_round, default=0)), "max_evictions_per_ray": int(per_lane),
    }


def _most_evictions(rounds, evictions):
    """Most entries that a ray's eviction buffer held at the end of a round."""
    most = held = 0
    for one in rounds:
        if one["round"] == 0:
            held = 0
        held += int(evictions.get(int(one["lane"]) << 32 | int(one["round"]), 0)) - int(one["preloaded"])
        most = max(most, held)
        held -= int(one["eviction_dropped"])
    return most


_POPCOUNT = np.array([bin(i).count("1") for i in range(256)], np.uint8)
