"""Replays the rays of a group: a column is read whenever the replay does not tell what comes next
(docs/model/trace-format.md, "Replaying a group" and "Predictions")."""
from .trace_columns import BadColumn, signed
from .trace_dictionary import nodes_above_roots
from .trace_header import INSTANCE, INTERNAL, PROCEDURAL, unit_bytes

VISIT_INTERNAL, VISIT_INSTANCE, VISIT_LEAF, CULL, REPLAY_TAKE, REPLAY_FORWARD = range(6)
#: What the test of a leaf gave, by number.
OUTCOMES = ("miss", "behind", "beyond", "inserted", "displaced", "rejected", "ignored", "nearest")
INSERTED, DISPLACED = 3, 4
MAX_POPS = 1 << 30  # of a group
_MAX_SHIFTS = 4095

# Operation of a leaf -> (event kind, outcome, checkpointed)
_LEAF = {0: (VISIT_LEAF, 0, 0), 1: (VISIT_LEAF, 1, 0), 2: (VISIT_LEAF, 2, 0), 3: (VISIT_LEAF, 3, 0),
         4: (VISIT_LEAF, 4, 0), 5: (VISIT_LEAF, 5, 0), 6: (VISIT_LEAF, 6, 0), 7: (VISIT_LEAF, 2, 1), 8: (CULL, 0, 0),
         9: (CULL, 0, 1), 10: (VISIT_LEAF, 7, 0)}


class _Surprises:
    """A pair of columns NAME_gap and NAME: counts predicted pops, and gives the bytes of the others."""

    __slots__ = ("gaps", "bytes", "left", "byte_follows")

    def __init__(self, gaps, data):
        self.gaps, self.bytes, self.left, self.byte_follows = gaps, data, 0, False

    def pop(self):
        """0 for a predicted pop, else the byte that tells what differs."""
        while not self.left:
            if self.byte_follows:
                self.byte_follows = False
                byte = self.bytes.next()
                if not byte:
                    raise BadColumn(f"column {self.bytes.name} has a 0")
                return byte
            self.left = self.gaps.next()
            self.byte_follows = self.left != 255
        self.left -= 1
        return 0

    def finish(self):
        if self.left:
            raise BadColumn(f"column {self.gaps.name} predicts {self.left} pops too many")


def _slots(mask):
    while mask:
        low = mask & -mask
        yield low.bit_length() - 1
        mask ^= low


class Replay:
    """Walks the rounds of a group. ``nodes``: its dictionary, whose predictions change as it goes.

    ``events`` collects tuples (lane, round, kind, address in units, detail, checkpoints, shifts).
    """

    def __init__(self, nodes, root_kind, columns, header):
        self.columns = columns
        self.nodes = {node.address: node for node in nodes}
        self.root, self.blas, self.objects = nodes_above_roots(root_kind, header)
        self.child_order = header["child_order"]
        self.checkpoint_order = header["checkpoint_order"]
        unit = unit_bytes(header)
        self.blas_base = header["blas_base"] // unit if header["two_level"] else 1 << 64
        # Where an object's TLAS begins: with three levels, behind it an entry lies in an object.
        header_units = 1
        self.objects_base = header["object_roots"][0] // unit - header_units if self.objects else 1 << 64
        self.two_level = header["two_level"]
        self.inner = _Surprises(columns["inner_gap"], columns["inner"])
        self.leaf = _Surprises(columns["leaf_gap"], columns["leaf"])
        if sum(map(sum, (columns["inner_gap"].values, columns["leaf_gap"].values))) > MAX_POPS:
            raise BadColumn(f"more than {MAX_POPS} pops")
        self.events = []

    def round(self, lane, number, replays, source):
        """One round. ``source``: entries (parent, slot, scene leaf, instance leaf); gives the destination buffer."""
        self.lane, self.number = lane, number
        # What one visit pushed: [parent, mask of slots left, nothing popped yet, scene leaf, instance leaf].
        self.stack = [] if replays else [[self.root, 1, True, None, None]]
        self.destination = []
        read, following, taken = 0, 0, set()
        if not replays:
            source = ()
        while True:
            if self.stack:
                self._pop()
            elif read < len(source):
                if self.checkpoint_order == "nearest":
                    position = following + signed(self.columns["replay_entry"].next())
                    if not 0 <= position < len(source) or position in taken:
                        raise BadColumn(f"lane {lane} round {number} reads source entry {position}, which is not left")
                    taken.add(position)
                    following = position + 1
                else:
                    position = read if self.checkpoint_order == "fifo" else len(source) - 1 - read
                read += 1
                self._replay(source[position])
            else:
                return self.destination

    def finish(self):
        self.inner.finish()
        self.leaf.finish()

    def _event(self, kind, address, detail=0, checkpoints=0, shifts=0):
        self.events.append((self.lane, self.number, kind, address, detail, checkpoints, shifts))

    def _replay(self, entry):
        parent, slot, scene, instance = entry
        address = parent.children[slot]
        operation = self.columns["replay_op"].next()
        if operation == 0:
            self._event(REPLAY_TAKE, address)
            self.stack.append([parent, 1 << slot, True, scene, instance])
            if address >= self.objects_base:
                self._transform(scene)
            if address >= self.blas_base:
                self._transform(instance)
        elif operation in (1, 2):
            self._event(REPLAY_FORWARD, address, 0, operation - 1)
            if operation == 2:
                self.destination.append(entry)
        else:
            raise BadColumn(f"unknown replay operation {operation}")

    def _transform(self, leaf):
        if leaf is None:
            raise BadColumn(f"lane {self.lane} round {self.number} takes a node that no instance leads to")
        self._event(VISIT_INSTANCE, leaf, 1)

    def _expected(self, parent, mask, fresh):
        if self.child_order == "near_first":
            for slot in parent.order:
                if mask >> slot & 1:
                    return slot
        if self.child_order == "vulkan_sim":
            if fresh:
                for slot in _slots(mask):
                    if parent.kinds[slot] == INTERNAL:
                        return slot
            return mask.bit_length() - 1
        return (mask & -mask).bit_length() - 1

    def _ranked(self, parent, mask, rank):
        """The slot with ``rank`` others before it, which moves before the first of them."""
        if self.child_order != "near_first":
            raise BadColumn(f"a rank, though children come in order {self.child_order}")
        left = [slot for slot in parent.order if mask >> slot & 1]
        if rank >= len(left):
            raise BadColumn(f"rank {rank} of {len(left)} children")
        parent.order.remove(left[rank])
        parent.order.insert(parent.order.index(left[0]), left[rank])
        return left[rank]

    def _pop(self):
        top = self.stack[-1]
        parent, mask, fresh, scene, instance = top
        slot = self._expected(parent, mask, fresh)
        byte = (self.leaf if parent.kinds[slot] >= PROCEDURAL else self.inner).pop()
        differs = False
        if byte:
            if byte >> 4 & 7:
                slot = self._ranked(parent, mask, byte >> 4 & 7)
            parent.operations[slot] ^= byte & 0xF
            differs = byte >= 0x80
        mask ^= 1 << slot
        if mask:
            top[1], top[2] = mask, False
        else:
            self.stack.pop()
        kind, operation = parent.kinds[slot], parent.operations[slot]
        if kind == INTERNAL and operation < 2:
            self._visit_internal(parent.children[slot], operation, differs, scene, instance)
            return
        if differs:
            raise BadColumn("hits that differ, of what has none")
        address, entry = parent.children[slot], (parent, slot, scene, instance)
        if kind >= PROCEDURAL:
            self._pop_leaf(address, operation, entry)
        elif operation in (2, 3):
            self._event(CULL, address, 0, operation - 2)
            if operation == 3:
                self.destination.append(entry)
        elif kind == INSTANCE and operation == 0:
            self._visit_instance(address, scene)
        else:
            raise BadColumn(f"unknown operation {operation} of an inner node")

    def _pop_leaf(self, address, operation, entry):
        if operation not in _LEAF:
            raise BadColumn(f"unknown operation {operation} of a leaf")
        kind, outcome, checkpointed = _LEAF[operation]
        shifts = 0
        if kind == VISIT_LEAF and outcome in (INSERTED, DISPLACED):
            shifts = self.columns["shifts"].next()
            if shifts > _MAX_SHIFTS:
                raise BadColumn(f"{shifts} entries shifted")
        self._event(kind, address, outcome, checkpointed, shifts)
        if checkpointed:
            self.destination.append(entry)

    def _visit_instance(self, address, scene):
        if not self.two_level:
            raise BadColumn("an instance leaf in a monolithic structure")
        self._event(VISIT_INSTANCE, address)
        if self.objects and address < self.objects_base:
            if address not in self.objects:
                raise BadColumn(f"instance leaf {address} is none of the header's scene_leaves")
            self.stack.append([self.objects[address], 1, True, address, None])
        else:
            self.stack.append([self.blas, 1, True, scene, address])

    def _visit_internal(self, address, operation, differs, scene, instance):
        node = self.nodes.get(address)
        if node is None:
            raise BadColumn(f"visited node {address} is not in the dictionary")
        if differs:
            change = self.columns["hits"].next()
            if not change or change >> len(node.kinds):
                raise BadColumn("a change of hits that is none, or of a child that does not exist")
            node.hits ^= change
        hits, checkpointed = node.hits, 0
        if operation == 1:
            checkpointed = self._checkpointed(hits)
            for slot in _slots(checkpointed):
                self.destination.append((node, slot, scene, instance))
        pushed = hits ^ checkpointed
        self._event(VISIT_INTERNAL, address, pushed, checkpointed)
        if pushed:
            self.stack.append([node, pushed, True, scene, instance])

    def _checkpointed(self, hits):
        slots = list(_slots(hits))
        if len(slots) < 2:
            if not slots:
                raise BadColumn("checkpointed children of a node without hits")
            return hits
        which = self.columns["checkpoints"].next()
        if not which or which >> len(slots):
            raise BadColumn("checkpointed hits that do not exist")
        return sum(1 << slot for i, slot in enumerate(slots) if which >> i & 1)
