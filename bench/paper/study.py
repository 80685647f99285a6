# SPDX-License-Identifier: Apache-2.0
"""What is measured. An item asks a study for statistics of points, measurements and costs; a study that plans notes what
was asked and answers 1, a study that answers has run it all. So each item is written once."""
import collections
import statistics
from dataclasses import dataclass, field

DESIGNS = {"baseline": ("tri20", "off"), "sw": ("tlas-tri20", "off"), "hw": ("tri20", "on"), "grtx": ("tlas-tri20", "on")}


def structure(design):
    """Acceleration structure, and whether there is checkpointing. design: of DESIGNS, or a structure without it."""
    return DESIGNS.get(design, (design, "off"))


@dataclass(frozen=True)
class Scene:
    """A scene that `grtx synth` makes (preset), or a trained one (file and cameras without their endings)."""
    name: str
    role: str  # evaluation: generated, in the means that are recorded; public: trained, with means of its own; shown: in none
    preset: str = ""
    count: int = 0
    seed: int = 0
    sh_degree: int = 0
    file: str = ""
    cameras: str = ""
    items: tuple = ()  # pages that it is on; (): all

    @property
    def stem(self):
        """Name of the files that hold it: all that they depend on."""
        return f"{self.preset}-{self.count}-{self.seed}-sh{self.sh_degree}" if self.preset else self.file


# What costs nothing on the first costs its bytes on the second, and they have nothing else apart (machine_test.cpp).
FREE, CHARGED = "paper", "paper-charged"


@dataclass(frozen=True)
class Frame:
    """Pixels, factor on the tangent of half the field of view, and configuration keys of the GPU that sees them."""
    width: int
    height: int
    fov_scale: float
    keys: tuple = ()


@dataclass(frozen=True)
class Point:
    """One simulation. options: sorted pairs of tracer.OPTION or configuration key and value."""
    scene: Scene
    frame: Frame
    machine: str
    options: tuple


@dataclass(frozen=True)
class Measurement:
    """One run of the functional tracer that writes statistics and no trace."""
    scene: Scene
    frame: Frame
    machine: str
    options: tuple  # sorted pairs of an option of `grtx trace`, with _ for -, and its value


@dataclass(frozen=True)
class Cost:
    """One run of `grtx cost`."""
    machine: str
    design: str
    options: tuple = ()


@dataclass
class Study:
    """One set of sets.toml. Without `results` it plans."""
    name: str
    all_scenes: list
    frames: dict
    values: dict  # the set's other entries
    results: object = None  # runs.Results
    asked: dict = field(default_factory=lambda: collections.defaultdict(dict))
    item: str = ""  # that is being built

    @property
    def planning(self):
        return self.results is None

    @property
    def scenes(self):
        return [s for s in self.all_scenes if not self.item or not s.items or self.item in s.items]

    @property
    def evaluation(self):
        return [s for s in self.scenes if s.role == "evaluation"]

    @property
    def counted(self):
        """Scenes of claims: the evaluation and the public ones."""
        return [s for s in self.scenes if s.role in ("evaluation", "public")]

    @staticmethod
    def same(machine, checkpoint):
        """A machine that gives the same: without checkpoints none is charged."""
        return FREE if machine == CHARGED and checkpoint == "off" else machine

    def ask(self, what):
        self.asked[type(what)][what] = None
        return collections.defaultdict(lambda: 1.0) if self.planning else self.results.of(what)

    def point(self, scene, design, machine="paper", frame="side", **options):
        """Statistics of a simulation: name -> value. design: of DESIGNS, or an acceleration structure. options: of the tracer with a leading t_, the others configuration keys with __ for '.'."""
        accel, checkpoint = structure(design)
        chosen = {"tracer.accel": accel, "tracer.checkpoint": checkpoint, "tracer.k": 8, "tracer.ert": 0.001}
        for name, value in options.items():
            chosen["tracer." + name[2:] if name.startswith("t_") else name.replace("__", ".")] = value
        at = self.frames[frame] if isinstance(frame, str) else frame
        return self.ask(Point(scene, at, self.same(machine, checkpoint), tuple(sorted(chosen.items()))))

    def measure(self, scene, design, machine="paper", frame="main", **options):
        """Statistics of the tracer alone: name -> value."""
        accel, checkpoint = structure(design)
        chosen = {"accel": accel, "checkpoint": checkpoint, **options}
        at = self.frames[frame] if isinstance(frame, str) else frame
        # The tracer of both is the same.
        return self.ask(Measurement(scene, at, self.same(machine, "off"), tuple(sorted(chosen.items()))))

    def cost(self, machine, design, **options):
        """What `grtx cost --json` says: names of nested tables joined by '.' -> value."""
        return self.ask(Cost(machine, design, tuple(sorted(options.items()))))


def geometric_mean(values):
    values = list(values)
    if len(values) == 1:
        return values[0]  # to the last bit
    return 0.0 if 0 in values else statistics.geometric_mean(values)
