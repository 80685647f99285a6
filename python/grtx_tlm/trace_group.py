"""A group of rays, decoded: the rays of one warp (docs/model/trace-format.md, "Events")."""
from dataclasses import dataclass

import numpy as np

from .trace_columns import BadColumn, signed, split
from .trace_dictionary import SLOTS, read_dictionary
from .trace_header import unit_bytes
from .trace_replay import Replay

RAY_KINDS = ("primary", "glass", "mirror")

NODE = np.dtype([("address", "u8"), ("child_base", "u8"), ("child_count", "u1"), ("child_kinds", "u1", (SLOTS,))])
RAY = np.dtype([("pixel", "u4"), ("rounds", "u4")])
ROUND = np.dtype([("lane", "u1"), ("round", "u4"), ("events", "u4"), ("replay", "?"), ("overflow", "?"),
                  ("terminated", "?"), ("preloaded", "u2"), ("k_count", "u2"), ("processed", "u2"),
                  ("eviction_dropped", "u4")])
EVENT = np.dtype([("lane", "u1"), ("round", "u4"), ("kind", "u1"), ("address", "u8"), ("detail", "u1"),
                  ("checkpoints", "u1"), ("shifts", "u2")])
PROCESSED = np.dtype([("lane", "u1"), ("round", "u4"), ("gaussian", "u4"), ("blended", "?")])


@dataclass
class RayGroup:
    """The rays of one warp, as structured arrays of one dimension (``pandas.DataFrame(group.events)`` is a table).

    All addresses are bytes from the start of the node image.

    - ``index``, ``frame``: position in the file; frame of a sequence. ``kind``: 'primary', 'glass' or 'mirror'.
    - ``nodes``: the internal nodes visited, ascending: ``address``, ``child_base``, ``child_count``, ``child_kinds``
      (8 a node; 0 internal or unused, 1 instance, 2 procedural, 3 triangle).
    - ``rays``: one a lane: ``pixel`` (y * width + x), ``rounds``.
    - ``rounds``: in order of lane and round: ``events`` (how many), flags, k-buffer entries at begin (``preloaded``) and end
      (``k_count``), ``processed`` (how many), ``eviction_dropped``.
    - ``events``: in order: ``kind`` (see EVENT_KINDS), ``address``; of an internal visit ``detail`` and ``checkpoints`` are
      masks of pushed and checkpointed children; of a leaf ``detail`` is the outcome (see OUTCOMES); of an instance 1 if
      only the ray is transformed; else ``checkpoints`` is 1 if the node was checkpointed. ``shifts``: entries moved.
    - ``processed``: k-buffer entries that the blending shader looked at: ``gaussian``, ``blended``.
    """

    index: int
    frame: int
    kind: str
    nodes: np.ndarray
    rays: np.ndarray
    rounds: np.ndarray
    events: np.ndarray
    processed: np.ndarray


class _Gaussians:
    """Processed Gaussians and their predictions: which one came next the last time."""

    def __init__(self, count, columns):
        self.columns, self.ids, gaussian = columns, [], 0
        for i, step in enumerate(columns["gaussian_id"].take(count)):
            if i and not step:
                raise BadColumn("distinct Gaussians do not ascend")
            gaussian += step
            self.ids.append(gaussian)
        if self.ids and self.ids[-1] >> 31:
            raise BadColumn(f"Gaussian {self.ids[-1]}, beyond 2^31")
        self.following = [None] * (count + 1)
        self.last = count  # the start of a ray

    def start_ray(self):
        self.last = len(self.ids)

    def next(self):
        byte = self.columns["processed"].next()
        if byte > 3:
            raise BadColumn(f"unknown flags {byte} of a processed entry")
        if byte & 2:
            position = self.columns["gaussian_low"].next() | self.columns["gaussian_high"].next() << 8
            if position >= len(self.ids):
                raise BadColumn(f"processed Gaussian {position} of {len(self.ids)}")
            self.following[self.last] = position
        else:
            position = self.following[self.last]
            if position is None:
                raise BadColumn("a predicted Gaussian where nothing was processed before")
        self.last = position
        return self.ids[position], byte & 1


def decode_group(payload, index, frame, header, max_bytes):
    """The RayGroup of a chunk's payload. Raises BadColumn."""
    columns = split(payload, max_bytes)
    group = columns["group"]
    if group.varint() != index:
        raise BadColumn("is stored under another number")
    kind, root_kind = group.next(), group.next()
    if kind >= len(RAY_KINDS):
        raise BadColumn(f"unknown kind of rays {kind}")
    node_count, ray_count, form, gaussian_count = group.varint(), group.varint(), group.next(), group.varint()
    if ray_count > header["warp_size"]:
        raise BadColumn(f"{ray_count} rays, more than the warp size, {header['warp_size']}")
    if node_count > len(columns["node_shape"].values):
        raise BadColumn("column node_shape ends too early")
    nodes = read_dictionary(node_count, form, columns, header)
    gaussians = _Gaussians(gaussian_count, columns)
    replay = Replay(nodes, root_kind, columns, header)
    rays, rounds, processed, pixel = [], [], [], 0
    for lane in range(ray_count):
        pixel += signed(columns["ray"].next())
        if not 0 <= pixel < 1 << 32:
            raise BadColumn(f"pixel {pixel}")
        rays.append((pixel, columns["ray"].next()))
        gaussians.start_ray()
        source = ()
        for number in range(rays[-1][1]):
            source = _read_round(lane, number, source, columns, replay, gaussians, rounds, processed)
    replay.finish()
    for column in columns.values():
        column.finish()
    events = np.array(replay.events, EVENT)
    unit = unit_bytes(header)
    events["address"] *= unit
    table = np.array([(n.address * unit, n.child_base * unit, len(n.kinds), n.kinds + [0] * (SLOTS - len(n.kinds)))
                      for n in nodes], NODE)
    return RayGroup(index, frame, RAY_KINDS[kind], table, np.array(rays, RAY), np.array(rounds, ROUND), events,
                    np.array(processed, PROCESSED))


def _read_round(lane, number, source, columns, replay, gaussians, rounds, processed):
    flags = columns["round_flags"].next()
    if flags > 7:
        raise BadColumn(f"unknown flags {flags} of a round")
    preloaded, k_count = columns["preloaded"].next(), columns["k_count"].next()
    looked_at = k_count - signed(columns["processed_count"].next())
    dropped = columns["eviction_dropped"].next() if flags & 2 else 0
    for what, value, limit in (("preloaded", preloaded, 1 << 16), ("k_count", k_count, 1 << 16),
                               ("processed_count", looked_at, 1 << 16), ("eviction_dropped", dropped, 1 << 32)):
        if not 0 <= value < limit:
            raise BadColumn(f"lane {lane} round {number} has a {what} of {value}")
    first = len(replay.events)
    destination = replay.round(lane, number, flags & 1, source)
    rounds.append((lane, number, len(replay.events) - first, flags & 1, flags & 2, flags & 4, preloaded, k_count,
                   looked_at, dropped))
    for _ in range(looked_at):
        processed.append((lane, number, *gaussians.next()))
    return () if flags & 2 else destination
