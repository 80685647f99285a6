"""Header and totals of a trace, and what follows from them (docs/model/trace-format.md, "Header")."""

UINT, BOOL = "number", "flag"
_U32 = (1 << 32) - 1
_U64 = (1 << 64) - 1

#: Fields of the header: what each holds. A tuple lists the names that are known.
FIELDS = {
    "accel": ("tri20", "tri80", "ellipsoid", "tlas-tri20", "tlas-tri80", "tlas-sphere"),
    "tracing": ("multi", "single", "closest", "stochastic"),
    "k": UINT, "checkpoint": BOOL,
    "checkpoint_order": ("fifo", "lifo", "nearest"),
    "child_order": ("near_first", "slot", "vulkan_sim"),
    "width": UINT, "height": UINT, "warp_size": UINT,
    "warp_mapping": ("tile8x4", "linear"),
    "groups": UINT, "bvh_width": UINT, "node_image_bytes": UINT, "root": UINT, "two_level": BOOL,
    "blas_base": UINT, "blas_root": UINT, "blas_bytes": UINT, "blas_root_is_leaf": BOOL,
    "gaussians": UINT, "sh_degree": UINT, "gaussian_record_bytes": UINT, "sh_record_bytes": UINT,
    "checkpoint_capacity": UINT,
}
LAYOUTS = ("vulkan_sim", "compact", "obb", "compressed")
TOTALS = ("rays", "rounds", "visits_internal", "visits_instance", "visits_leaf", "culls", "any_hit_calls", "evictions",
          "checkpoints_written", "checkpoints_read", "overflows", "processed", "blended", "max_checkpoints_per_round",
          "max_evictions_per_ray")

# Kinds of a child: how node_shape and node_kinds number them.
INTERNAL, INSTANCE, PROCEDURAL, TRIANGLE = range(4)


class BadHeader(Exception):
    """A field that does not hold what the format says; the reader adds the file."""


def _is_number(value, limit=_U64):
    return isinstance(value, int) and not isinstance(value, bool) and 0 <= value <= limit


def _check_keys(what, found, wanted):
    for key in found:
        if key not in wanted:
            raise BadHeader(f"unknown key '{key}' in the {what}")
    for key in wanted:
        if key not in found:
            raise BadHeader(f"key '{key}' is missing in the {what}")


def _check_lists(header):
    if "frame_groups" in header:
        frames = header["frame_groups"]
        if not isinstance(frames, list) or not all(map(_is_number, frames)) or sum(frames) != header["groups"]:
            raise BadHeader("frame_groups is no list of numbers that add up to groups")
    roots = header.get("object_roots", [])
    if not isinstance(roots, list) or not all(map(_is_number, roots)) or roots != sorted(set(roots)):
        raise BadHeader("object_roots is no ascending list of addresses")
    leaves = header.get("scene_leaves", [])
    if not isinstance(leaves, list) or not all(
            isinstance(p, list) and len(p) == 2 and _is_number(p[0]) and _is_number(p[1]) and p[1] < len(roots)
            for p in leaves):
        raise BadHeader("scene_leaves is no list of pairs [address, index into object_roots]")
    if any(a[0] >= b[0] for a, b in zip(leaves, leaves[1:])):
        raise BadHeader("scene_leaves does not ascend")
    if bool(roots) != bool(leaves) or (roots and not header["two_level"]):
        raise BadHeader("object_roots and scene_leaves do not belong together")


def checked_header(header, version):
    """``header`` (dict) with ``layout`` and ``pop_test`` filled in. Raises BadHeader."""
    wanted = set(FIELDS) | {"inputs"}
    if version >= 5:
        wanted.add("pop_test")
    if version >= 6:
        wanted |= {"object_roots", "scene_leaves"}
    if version >= 7:
        wanted.add("frame_groups")
    if "layout" in header:
        wanted.add("layout")
    _check_keys("header", header, wanted)
    fields = dict(FIELDS, layout=LAYOUTS, pop_test=("on", "off"))
    for key, kind in fields.items():
        if key not in header:
            continue
        value = header[key]
        good = (_is_number(value) if kind is UINT else isinstance(value, bool) if kind is BOOL else value in kind)
        if not good:
            raise BadHeader(f"{key} is {value!r}, which is no {kind if isinstance(kind, str) else 'name of it'}")
    inputs = header["inputs"]
    if not isinstance(inputs, dict) or not all(isinstance(v, str) for v in inputs.values()):
        raise BadHeader("inputs is no object of strings")
    _check_lists(header)
    full = dict(header)
    full.setdefault("layout", "vulkan_sim")
    full.setdefault("pop_test", "on")
    unit = unit_bytes(full)
    addresses = [full["root"], full["blas_base"], full["blas_root"], *full.get("object_roots", []),
                 *(a for a, _ in full.get("scene_leaves", []))]
    if any(a % unit or a // unit > _U32 for a in addresses):
        raise BadHeader(f"an address is no multiple of the unit, {unit} bytes")
    if not 2 <= full["bvh_width"] <= 8:
        raise BadHeader("bvh_width is not 2 to 8")
    if not 1 <= full["warp_size"] <= 32:
        raise BadHeader("warp_size is not 1 to 32")
    return full


def checked_totals(totals):
    """``totals`` (dict). Raises BadHeader."""
    _check_keys("totals", totals, TOTALS)
    for key, value in totals.items():
        if not _is_number(value):
            raise BadHeader(f"{key} is {value!r}, which is no number")
    return totals


def unit_bytes(header):
    """Bytes of the unit in which addresses are counted."""
    return 80 if header["layout"] == "compact" else 64


def child_units(header):
    """Units that a child takes, by its kind (internal, instance, procedural, triangle); docs/model/node-image.md."""
    layout = header["layout"]
    wide = layout in ("vulkan_sim", "obb") and header["bvh_width"] > 6
    return (2 if wide else 1, 1 if layout == "compressed" else 2, 1, 1)
