"""Byte columns of a trace: how numbers lie in them (docs/model/trace-format.md, "Payload of a chunk")."""
import numpy as np
import zstandard

#: The columns of a group, in the order of the file.
COLUMNS = ("group", "node_address", "node_tree", "node_shape", "node_kinds", "node_children", "node_hits", "ray",
           "round_flags", "preloaded", "k_count", "processed_count", "eviction_dropped", "inner_gap", "inner", "hits",
           "checkpoints", "leaf_gap", "leaf", "shifts", "replay_op", "replay_entry", "gaussian_id", "processed",
           "gaussian_low", "gaussian_high")
MAX_EXPANSION = 32768  # bytes a stored byte can stand for


class BadColumn(Exception):
    """A rule of the payload that does not hold; the reader adds file and group."""


def varints(data):
    """All varints of ``data`` (bytes) as a list of int. Raises BadColumn on a cut, a long or an over-long one."""
    raw = np.frombuffer(data, np.uint8)
    if not raw.size:
        return []
    if raw[-1] & 0x80:
        raise BadColumn("ends within a varint")
    last = np.flatnonzero(raw < 0x80)
    first = np.concatenate(([0], last[:-1] + 1))
    length = last - first + 1
    if length.max() > 10:
        raise BadColumn("varint of more than 64 bits")
    if np.any((raw[last] == 0) & (length > 1)):
        raise BadColumn("varint that is not in its shortest form")
    if np.any((length == 10) & (raw[last] > 1)):
        raise BadColumn("varint of more than 64 bits")
    values = np.zeros(last.size, np.uint64)
    for place in range(int(length.max())):
        reaches = length > place
        byte = (raw[first[reaches] + place] & 0x7F).astype(np.uint64)
        values[reaches] |= byte << np.uint64(7 * place)
    return values.tolist()


def signed(value):
    """The number that a zigzag varint stands for."""
    return value >> 1 if value & 1 == 0 else -(value >> 1) - 1


class Column:
    """One column, read front to back. ``values``: its entries as unsigned numbers, a list or bytes."""

    __slots__ = ("name", "values", "at")

    def __init__(self, name, values):
        self.name, self.values, self.at = name, values, 0

    def next(self):
        at = self.at
        if at == len(self.values):
            raise BadColumn(f"column {self.name} ends too early")
        self.at = at + 1
        return self.values[at]

    def varint(self):
        """The next varint of a column of bytes."""
        end = self.at
        while end < len(self.values) and self.values[end] & 0x80 and end - self.at < 10:
            end += 1
        if end >= len(self.values):
            raise BadColumn(f"column {self.name} ends too early")
        value = varints(self.values[self.at:end + 1])[0]
        self.at = end + 1
        return value

    def take(self, count):
        """The next ``count`` entries."""
        end = self.at + count
        if end > len(self.values):
            raise BadColumn(f"column {self.name} ends too early")
        values = self.values[self.at:end]
        self.at = end
        return values

    def finish(self):
        if self.at != len(self.values):
            raise BadColumn(f"column {self.name} has {len(self.values) - self.at} entries too many")


_VARINT = frozenset(("node_address", "node_children", "ray", "preloaded", "k_count", "processed_count",
                     "eviction_dropped", "shifts", "replay_entry", "gaussian_id", "gaussian_high"))


def _inflate(name, stored, size):
    try:
        stated = zstandard.frame_content_size(stored)
        if stated not in (-1, size):
            raise BadColumn(f"column {name} inflates to {stated} bytes, not {size}")
        unpacker = zstandard.ZstdDecompressor(max_window_size=1 << 27).decompressobj()
        data = unpacker.decompress(stored)
    except zstandard.ZstdError as error:
        raise BadColumn(f"column {name} is no zstd frame: {error}") from None
    except MemoryError:
        raise BadColumn(f"column {name} takes more memory than there is") from None
    if unpacker.unused_data or not unpacker.eof:
        raise BadColumn(f"column {name} is not one zstd frame")
    if len(data) != size:
        raise BadColumn(f"column {name} inflates to {len(data)} bytes, not {size}")
    return data


def split(payload, max_bytes):
    """The columns of a chunk's payload: name -> Column. ``max_bytes`` bounds their sum. Raises BadColumn."""
    lengths = Column("sizes", payload)
    sizes = [lengths.varint() for _ in range(2 * len(COLUMNS))]
    at = lengths.at
    if sum(sizes[0::2]) > max_bytes:
        raise BadColumn(f"columns of {sum(sizes[0::2])} bytes, more than max_group_bytes, {max_bytes}")
    columns = {}
    for i, name in enumerate(COLUMNS):
        size, packed = sizes[2 * i], sizes[2 * i + 1]
        stored = packed or size
        if at + stored > len(payload):
            raise BadColumn(f"column {name} reaches beyond the payload")
        data = payload[at:at + stored]
        at += stored
        if packed:
            if size > packed * MAX_EXPANSION:
                raise BadColumn(f"column {name} claims {size} bytes of {packed} stored ones")
            data = _inflate(name, data, size)
        try:
            columns[name] = Column(name, varints(data) if name in _VARINT else data)
        except BadColumn as error:
            raise BadColumn(f"column {name} {error}") from None
    if at != len(payload):
        raise BadColumn(f"{len(payload) - at} bytes behind the last column")
    return columns
