# SPDX-License-Identifier: Apache-2.0
"""scripts/reproduce.sh: runs a set of sets.toml item by item, writes its pages, and compares its figures with what is
expected. Exit code 0: done, all within tolerance; 1: a figure left its tolerance, or a run failed; 2: bad input."""
import argparse
import hashlib
import os
import sys

from . import claims as claims_of
from . import items, page, runs
from .study import Frame, Scene, Study

HERE = os.path.dirname(os.path.abspath(__file__))
TOP = os.path.normpath(os.path.join(HERE, "..", ".."))


def options_of(arguments):
    parser = argparse.ArgumentParser(prog="scripts/reproduce.sh", description=__doc__.split(":", 1)[1].strip())
    parser.add_argument("--quick", action="store_true", help="small scenes: minutes in place of hours")
    parser.add_argument("--only", metavar="ITEM", help=f"one section: {', '.join(items.ITEMS)}")
    parser.add_argument("-o", "--output", metavar="DIR", help="pages (default: docs/results/paper)",
                        default=os.path.join(TOP, "docs", "results", "paper"))
    parser.add_argument("--work", metavar="DIR", default=os.path.join(TOP, "build", "reproduce"),
                        help="scenes, traces, results (default: build/reproduce)")
    parser.add_argument("--scenes", metavar="DIR", default=os.environ.get("GRTX_SCENES", ""),
                        help="trained scenes as .ply or .ply.xz, such as scripts/scenes.sh brings (default: GRTX_SCENES, else "
                             "generated ones alone)")
    parser.add_argument("--set", metavar="KEY=VALUE", action="append", default=[], dest="settings",
                        help="configuration key or tracer.OPTION for every simulation; repeatable")
    parser.add_argument("--jobs", type=int, default=0, help="simulations at a time; 0: one a core")
    parser.add_argument("--program", metavar="GRTX", default=os.environ.get("GRTX", os.path.join(TOP, "build/release/grtx")),
                        help="the grtx to run (default: GRTX, else build/release/grtx)")
    parser.add_argument("--sets", metavar="F.toml", default=os.path.join(HERE, "sets.toml"), help="other sets")
    parser.add_argument("--expected", metavar="F.toml", default=os.path.join(HERE, "expected.toml"), help="other values")
    parser.add_argument("--record", action="store_true", help="write this run's values as the expected ones")
    options = parser.parse_args(arguments)
    if options.only and options.only not in items.ITEMS:
        parser.error(f"--only {options.only}: is none of {', '.join(items.ITEMS)}")
    if any("=" not in s for s in options.settings):
        parser.error("--set: must be KEY=VALUE")
    if not os.access(options.program, os.X_OK):
        parser.error(f"{options.program}: no program; build it (scripts/build.sh) or name it with --program")
    if options.scenes and not os.path.isdir(options.scenes):
        parser.error(f"--scenes {options.scenes}: no such folder")
    return options


def study_of(options, say):
    sets = claims_of.read(options.sets)
    name = "quick" if options.quick else "full"
    chosen = sets[name]
    scenes = [Scene(**s) for s in chosen["scenes"]]
    for trained in sets.get("trained", []) if options.scenes else []:
        at = lambda name: os.path.exists(os.path.join(options.scenes, name))
        if at(trained["cameras"] + ".cameras.json") and (at(trained["file"] + ".ply") or at(trained["file"] + ".ply.xz")):
            scenes.append(Scene(**{**trained, "items": tuple(trained["items"])}))
    if not options.scenes:
        say("no folder of trained scenes (--scenes, GRTX_SCENES): generated scenes alone")
    frames = {n: Frame(f["width"], f["height"], f["fov_scale"], tuple(sorted(f["set"].items())))
              for n, f in chosen["frames"].items()}
    return Study(name, scenes, frames, chosen)


def build(study, names, claims, expected=None):
    pages = []
    public = [s.name for s in study.all_scenes if s.role == "public"]
    for name in names:
        study.item = name
        one = page.Page(name, items.ITEMS[name].TITLE, claims, study.name, expected, public)
        items.ITEMS[name].build(study, one)
        pages.append(one)
    study.item = ""
    return pages


def main():
    options = options_of(sys.argv[1:])
    say = lambda text: print(f"reproduce: {text}", file=sys.stderr, flush=True)
    claims, expected = claims_of.load(), claims_of.Expected(options.expected)
    study = study_of(options, say)
    names = [options.only] if options.only else list(items.ITEMS)
    with open(options.program, "rb") as file:  # results of another build are not taken for this one's
        work = os.path.join(options.work, hashlib.sha256(file.read()).hexdigest()[:12])
    results = runs.Results(options.program, work, options.scenes, options.settings, study.values["limits"], options.jobs, say)
    build(study, names, claims)
    try:
        results.run(study.asked)
        study.results = results
        pages = build(study, names, claims, expected)
    except runs.Failed as failure:
        say(str(failure))
        return failure.code
    found = {}
    for one in pages:
        found.update(one.found)
    if options.record:  # before the pages, which say what is as recorded
        if not options.only:
            expected.values.pop(study.name, None)  # claims and machines that are no more
        expected.record(study.name, found)
    os.makedirs(options.output, exist_ok=True)
    command = "scripts/reproduce.sh" + (" --quick" if options.quick else "") + (" --scenes scenes" if options.scenes else "")
    page.write_pages(options.output, pages, command, results.model)
    if not options.only:
        page.write_index(options.output, study, pages, claims, study.values["machines"], command, results.model)
    faults = list(expected.faults(study.name, found, claims))
    for line in faults:
        say(line)
    for machine, (printed, held) in page.tally(pages).items():
        say(f"machine {machine}: {held} of the {printed} figures that the paper prints hold within 20 %")
    known = sum(expected.of(study.name, machine, name) is not None for name, machine in found)
    say(f"{options.output}: {len(found)} figures, {known} with a value on record, {len(faults)} outside their tolerance of it")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
