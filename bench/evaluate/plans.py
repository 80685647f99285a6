# SPDX-License-Identifier: Apache-2.0
"""What is simulated: parts of the evaluation, each a plan of `grtx sweep` on each of its machines."""
import json
import os
import tomllib
from dataclasses import dataclass, field

HERE = os.path.dirname(os.path.abspath(__file__))
TOP = os.path.normpath(os.path.join(HERE, "..", ".."))
SET = "configs/scenes/evaluation.toml"
HOURS = 8  # of two cores that all parts may take
LIMITS = {"seconds": 3600, "memory_mb": 9000}
QUARTER = {"gpu.sms": 2, "l2.bytes": 1048576, "l2.slices": 1}  # of the paper's GPU
FREE_CALLS = {"simt.cost.call_per_lane": 0}  # of shaders, as in Vulkan-Sim, which GauTracer's figures are of
SMALL = {"tracer.accel": "tlas-tri20", "tracer.checkpoint": "on", "tracer.k": 8, "tracer.checkpoint_capacity": 1024, "rt.checkpoint.entry_bytes": 8,
         "rt.checkpoint.write_combine": True, "rt.checkpoint.read_buffer": True}
LEAN = {"small entries": {}, "finished": {"tracer.below_instance": "finish"}, "bins": {"tracer.checkpoint_bins": 4}}  # machine paper-lean has all
L2 = {"¼ MiB": 1 << 18, "½ MiB": 1 << 19, "1 MiB": 1 << 20, "2 MiB": 1 << 21, "4 MiB": 1 << 22, "8 MiB": 1 << 23}  # of two SMs
FULL = 1080  # lines of a frame at full density


@dataclass(frozen=True)
class Part:
    """Views and designs of a table, at one density. lines: of the whole view whose rays are as dense; pixels: an edge of its middle
    that is simulated. seconds: of a point and its trace, mean on one core of class H, for --plan while none is done."""
    name: str
    table: str
    machines: tuple
    mode: str
    pixels: int
    lines: int
    seconds: float
    keys: dict = field(default_factory=dict)
    designs: str = ""  # table of designs.toml, if it is not that of the views
    role: str = ""  # of its views; all, if empty. On those that show, a design has the k of its list `shown`

    @property
    def rows(self):
        return self.designs or self.table

    @property
    def folder(self):
        return self.name + (f"-{self.role}" if self.role == "show" else "")


CARDS = ("ada-quarter", "blackwell-quarter", "rdna4-quarter", "rtx2060-quarter")  # of the shares of cards
PARTS = (
    Part("who-128", "who", ("paper-charged",), "cycle", 48, 128, 10, QUARTER, role="choose"),
    Part("who-128", "who", ("paper-charged",), "cycle", 48, 128, 25, QUARTER, role="show"),
    Part("who-full", "who", ("paper-charged",), "cycle", 48, FULL, 12, QUARTER),
    Part("secondary", "secondary", ("paper-charged",), "cycle", 48, 128, 25, {**QUARTER, "tracer.secondary": "both"}),
    Part("cards", "shares", CARDS, "cycle", 32, 128, 10, designs="cards"),
    Part("l2", "cards", ("paper-charged",), "cycle", 48, 128, 10, {key: value for key, value in QUARTER.items() if key != "l2.bytes"}),
    Part("steps", "cards", ("rtx2060-share",), "cycle", 64, 128, 40, FREE_CALLS, designs="steps"),
    Part("paper-128", "paper", ("paper", "paper-charged", "paper-lean"), "cycle", 64, 128, 25, QUARTER),
    Part("paper-full", "paper", ("paper", "paper-charged", "paper-lean"), "cycle", 64, FULL, 12, QUARTER),
    Part("lean", "paper", ("paper-charged",), "cycle", 64, 128, 25, QUARTER))
NAMES = tuple(dict.fromkeys(part.name for part in PARTS))


def read(path):
    with open(path, "rb") as file:
        return tomllib.load(file)


class BadSet(Exception):
    """A view of SET whose role is none or another than what its tuned and fitted say; the message is one line."""


def check_roles(views):
    """Nothing is chosen on a view that shows."""
    for view in views:
        chosen = [name for name in ("tuned", "fitted") if view.get(name)]
        wanted = "choose" if chosen else "show"
        if view.get("role") != wanted:
            raise BadSet(f"{SET}: {label(view)}: role is {json.dumps(view.get('role', 'missing'))}: must be {wanted}, since it has "
                         f"{' and '.join(chosen) or 'neither tuned nor fitted'}")
    return views


def views(part, quick):
    found = read(os.path.join(TOP, SET))
    return [view for view in (found["quick"] if quick else check_roles(found["view"]))
            if part.table in view["tables"] and (quick or part.role in ("", view["role"]))]


def points(part, machine, quick):
    """{(design, k): keys and tracer options}, in the order of the tables."""
    if part.name == "lean":
        return {(name, 8): {**SMALL, **own} for name, own in LEAN.items()}
    if part.table == "paper":
        # Without checkpoints the three machines are one.
        return {(name, 8): {"design": name, "tracer.k": 8} for name in (("baseline", "sw") if machine == "paper" else ()) + ("hw", "grtx")}
    plan = read(os.path.join(HERE, "designs.toml"))
    found = {}
    for design in plan["design"]:
        if part.name == "l2":
            if "at_l2" in design:
                own = of_design(plan, design, machine, design["at_l2"])
                found |= {(f"{design['name']}, L2 {called}", design["at_l2"]): own | {"l2.bytes": size} for called, size in L2.items()}
            continue
        if not {part.rows, part.name} & set(design["tables"]):
            continue
        sizes = design["on_cards" if part.rows == "cards" else "k"]
        if part.role == "show":
            sizes = design.get("shown", sizes)
        for k in sizes[:2 if part.name == "who-128" else 1] if quick else sizes:
            found[design["name"], k] = of_design(plan, design, machine, k)
    return found


def of_design(plan, design, machine, k):
    """Keys and tracer options of a design of designs.toml."""
    keys = {"tracer.k": k} | ({} if "design" in design.get("keys", {}) else {"tracer.checkpoint": "off"})
    for name in design.get("parts", []):
        keys |= plan["part"][name] | (plan["rdna4"].get(name, {}) if machine.startswith("rdna4") else {})
    keys |= design.get("keys", {})
    return {key: 3 * k if value == "3 k" else value for key, value in keys.items()}


def text(part, machine, scenes, quick):
    """The plan; scenes: the folder of the public ones."""
    lines = [f"mode = {json.dumps(part.mode)}"]
    pixels, fov = (8, 1.0) if quick else (part.pixels, part.pixels / part.lines)
    for view in views(part, quick):
        lines += ["[[scene]]", f"name = {json.dumps(label(view))}", f"view = {view['view']}", f"width = {pixels}", f"height = {pixels}",
                  f"fov_scale = {fov:.6g}"]
        if "preset" in view:
            lines += [f"{key} = {json.dumps(view[key])}" for key in ("preset", "count", "seed")]
        else:
            stem = os.path.join(os.path.abspath(scenes), view["scene"])
            lines += [f"file = {json.dumps(stem + '.ply')}", f"cameras = {json.dumps(stem + '.cameras.json')}"]
    shared = {key: value for key, value in part.keys.items() if not key.startswith("tracer.")}
    for table, entries in (("[set]", shared), ("[limits]", LIMITS)):
        lines += [table] + [f"{key} = {json.dumps(value)}" for key, value in entries.items()]
    for own in points(part, machine, quick).values():
        lines += ["[[point]]"] + [f"{key} = {json.dumps(value)}" for key, value in whole(part, own).items()]
    return "\n".join(lines) + "\n"


def file_of(machine):
    """What --machine takes: the name, or the file of a card's quarter."""
    card, quarter, _ = machine.partition("-quarter")
    return os.path.join(TOP, "configs", "sweeps", "quarters", card + ".toml") if quarter else machine


def whole(part, own):
    """Keys of a point: its own and the part's options of the tracer."""
    return own | {key: value for key, value in part.keys.items() if key.startswith("tracer.")}


def label(view):
    return f"{view['scene']}-{view['view']}"


def views_of(parts):
    """Of all of them, without --quick."""
    return [view for part in parts for view in views(part, False)]
