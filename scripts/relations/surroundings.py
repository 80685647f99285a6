# SPDX-License-Identifier: Apache-2.0
"""Relations of a run's surroundings: where it runs, in which language, time zone, home and with how many threads changes no byte."""
import json
import os

from . import views
from .case import relation, values_of

# None: unset.
SURROUNDINGS = [{"LC_ALL": "de_DE.UTF-8", "LANG": "de_DE.UTF-8"}, {"LC_ALL": "no_SUCH"}, {"TZ": "Asia/Kathmandu"},
                {"TZ": ":nowhere"}, {"HOME": None}, {"HOME": "/nonexistent", "USER": None}, {"TMPDIR": "/nonexistent"},
                {"COLUMNS": "20", "TERM": "dumb"}, {"MALLOC_PERTURB_": "165"}, {"LC_NUMERIC": "de_DE.UTF-8", "LC_ALL": None},
                {"PATH": "/nonexistent"}, {"XDG_CACHE_HOME": "/nonexistent"}]
FILES = ["s.ply", "s.cameras.json", "t.grtx", "t.pfm", "t.png", "t.json", "s.json", "r.html", "c.csv"]


def drop_host(path):
    """Takes what the host took out of a file of statistics."""
    with open(path, encoding="utf-8") as file:
        document = json.load(file)
    document["stats"] = {name: document["stats"][name] for name in values_of(document["stats"])}
    with open(path, "w", encoding="utf-8") as file:
        json.dump(document, file)


def session(case, place, environment, threads, seed):
    """A short session in a folder of its own; what it wrote and printed, by file."""
    view = ["--scene", "s.ply", "--cameras", "s.cameras.json", "--width", 9, "--height", 7]
    printed = {}
    for name, words in {
            "synth": ["synth", "--preset", "object", "--count", 80, "--seed", seed, "-o", "s.ply", "--json"],
            "trace": ["trace", *view, "--accel", "tlas-tri20", "--checkpoint", "on", "--threads", threads, "-o", "t.grtx", "--image",
                      "t.pfm", "--stats", "t.json", "--quiet"],
            "picture": ["trace", *view, "--no-trace", "--threads", threads, "--image", "t.png", "--quiet"],
            "check": ["trace-check", "t.grtx", "--json"], "info": ["info", "s.ply", "--json"], "dump": ["trace-dump", "t.grtx"],
            "sim": ["sim", "t.grtx", "--stats", "s.json", "--quiet"], "stalls": ["stalls", "s.json"],
            "report": ["report", "s.json", "-o", "r.html", "--quiet"], "cost": ["cost", "--csv", "c.csv"],
            "energy": ["cost", "--stats", "s.json"], "list": ["sim", "--list-config"]}.items():
        printed[name] = case.grtx(*words, folder=place, environment=environment).output
        if "--stats" in words and name != "energy":
            drop_host(os.path.join(case.folder, place, words[words.index("--stats") + 1]))
    for file in FILES:
        with open(os.path.join(case.folder, place, file), "rb") as stream:
            printed[file] = stream.read()
    return case.seen(printed)


@relation(each=3)
def surroundings_do_not_matter(case):
    """A session in another folder, language, time zone, home and with other threads writes and prints the same bytes."""
    rng = case.rng
    seed = rng.randrange(1 << 30)
    other = {}
    for more in rng.sample(SURROUNDINGS, 3):
        other.update(more)
    first = session(case, "here", {}, 1, seed)
    second = session(case, f"d{'x' * rng.randrange(60)}/über all", other, rng.choice([2, 3]), seed)
    case.same(f"sessions with {other}", first, second)


@relation()
def paths_do_not_matter(case):
    """A file named by another path, or printed in place of written, holds the same numbers."""
    rng = case.rng
    options = views.traced(case, "s")
    os.makedirs(case.path("below"), exist_ok=True)
    absolute = [case.path(v) if isinstance(v, str) and v.endswith((".ply", ".cameras.json")) else v for v in options]
    case.grtx("trace", *absolute, "-o", "../far.grtx", "--stats", "../far.json", "--quiet", folder="below")
    case.same("statistics of a trace by another path", case.statistics("s.trace.json"), case.statistics("far.json"))
    machine = ["--machine", rng.choice(views.MACHINES), *views.settings(rng)]
    case.grtx("sim", "s.grtx", *machine, "--stats", "a.json", "--quiet")
    case.grtx("sim", case.path("far.grtx"), *machine, "--stats", "../b.json", "--quiet", folder="below")
    case.same("statistics of a run by another path", case.statistics("a.json"), case.statistics("b.json"))
    printed = case.printed(case.grtx("sim", "s.grtx", *machine, "--json"))
    case.same("--stats and --json", case.statistics("a.json"), case.seen(values_of(printed["stats"])))
