"""The dictionary of a group: the internal nodes that it visited (docs/model/trace-format.md, "Payload of a chunk")."""
from .trace_columns import BadColumn, signed
from .trace_header import INTERNAL, TRIANGLE, child_units, unit_bytes

_MAX_UNITS = 1 << 32
SLOTS = 8


class Node:
    """An internal node, and what the predictions keep of it. Addresses in units."""

    __slots__ = ("address", "child_base", "kinds", "children", "operations", "order", "hits", "index")

    def __init__(self, address, child_base, kinds, children, hits):
        self.address, self.child_base, self.kinds, self.children, self.hits = address, child_base, kinds, children, hits
        self.operations = [0] * SLOTS  # with which each child was last popped
        self.order = list(range(SLOTS))  # the list of slots, in which the first left is expected
        self.index = -1

    @classmethod
    def above(cls, child, kind):
        """A node of its own whose only child is a root."""
        return cls(-1, child, [kind], [child], 1)


def _kinds(shape, columns):
    """Kinds of the children by slot."""
    count, leaf = shape & 0xF, shape >> 4 & 3
    if not 1 <= count <= SLOTS:
        raise BadColumn(f"a node with {count} children")
    if shape & 0x80:
        if shape & 0x70:
            raise BadColumn("a node shape with bit 7 and one of bits 4 to 6")
        bits = int.from_bytes(columns["node_kinds"].take(2), "little")
        if bits >> 2 * count:
            raise BadColumn("a kind for a child that does not exist")
        return [bits >> 2 * slot & 3 for slot in range(count)]
    if not shape & 0x40:
        return [leaf] * count
    internal = columns["node_kinds"].next()
    if leaf == INTERNAL or internal == 0 or internal >> count or internal == (1 << count) - 1:
        raise BadColumn("a node with both kinds of children that has but one")
    return [INTERNAL if internal >> slot & 1 else leaf for slot in range(count)]


def _node(address, base, kinds, hits, sizes):
    children = []
    for kind in kinds:
        children.append(base)
        base += sizes[kind]
    if hits >> len(kinds):
        raise BadColumn("a hit of a child that does not exist")
    if base > _MAX_UNITS or address >= _MAX_UNITS or children[0] < 0:
        raise BadColumn("an address outside 2^32 units")
    return Node(address, children[0], kinds, children, hits), base


def _by_address(count, columns, sizes):
    address = end = 0
    for i in range(count):
        step = columns["node_address"].next()
        if i and not step:
            raise BadColumn("the dictionary does not ascend")
        address += step
        kinds = _kinds(columns["node_shape"].next(), columns)
        base = end + signed(columns["node_children"].next())
        node, end = _node(address, base, kinds, columns["node_hits"].next(), sizes)
        yield node


def _as_tree(roots, columns, sizes):
    """Depth first; None on the walk's stack stands for an internal child that is not in the dictionary."""
    end = 0
    for root in roots:
        skipped, walk = True, [root]
        while walk:
            address = walk.pop()
            if address is None:
                skipped = True
                continue
            kinds = _kinds(columns["node_shape"].next(), columns)
            internal = [slot for slot, kind in enumerate(kinds) if kind == INTERNAL]
            mask = columns["node_tree"].next() if internal else 0
            base = end + (columns["node_children"].next() if skipped else 0)
            skipped = False
            node, end = _node(address, base, kinds, columns["node_hits"].next() ^ mask, sizes)
            if mask & ~sum(1 << slot for slot in internal):
                raise BadColumn("a tree goes on at a child that is no internal node")
            for slot in reversed(internal):
                walk.append(node.children[slot] if mask >> slot & 1 else None)
            yield node


def read_dictionary(count, form, columns, header):
    """Nodes by ascending address. Raises BadColumn."""
    sizes, unit = child_units(header), unit_bytes(header)
    if form & 1:
        if form & ~7 or (form & 4 and not header["two_level"]):
            raise BadColumn(f"dictionary stored in an unknown way, {form}")
        roots = [header["root"] // unit] if form & 2 else []
        roots += [header["blas_root"] // unit] if form & 4 else []
        found = _as_tree(roots, columns, sizes)
    elif form:
        raise BadColumn(f"dictionary stored in an unknown way, {form}")
    else:
        found = _by_address(count, columns, sizes)
    nodes = sorted(found, key=lambda node: node.address)
    if len(nodes) != count:
        raise BadColumn(f"a tree of {len(nodes)} nodes, not {count}")
    for i, node in enumerate(nodes):
        node.index = i
        if i and nodes[i - 1].address == node.address:
            raise BadColumn("a node is twice in the dictionary")
    return nodes


def nodes_above_roots(root_kind, header):
    """The nodes of their own whose children are root, BLAS root and objects' roots: (root, blas, {leaf: object})."""
    unit = unit_bytes(header)
    kinds = {0: INTERNAL, 1: 1, 4: TRIANGLE}
    if root_kind not in kinds:
        raise BadColumn(f"root of unknown kind {root_kind}")
    root = Node.above(header["root"] // unit, kinds[root_kind])
    blas = Node.above(header["blas_root"] // unit, TRIANGLE if header["blas_root_is_leaf"] else INTERNAL)
    objects = [Node.above(address // unit, INTERNAL) for address in header.get("object_roots", [])]
    return root, blas, {address // unit: objects[i] for address, i in header.get("scene_leaves", [])}
