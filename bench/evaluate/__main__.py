# SPDX-License-Identifier: Apache-2.0
"""Measures every figure of the pages that rest on configs/scenes/evaluation.toml, and writes them: databases of `grtx sweep`,
evaluation.csv in docs/results/data, the tables and stamps of the pages and README's, and a report of each database.

    python3 bench/evaluate [--only PART ...] [--plan] [--quick]

What a database has is not run again: a run that was killed goes on, and a second one changes nothing. Parts may run in several places,
each with --only; their databases, brought together in the folder of --work, give the pages.
Exit code 0: all points are done; 1: some are not, and are named; 2: bad input.
"""
import argparse
import csv
import glob
import json
import os
import shutil
import sqlite3
import subprocess
import sys

import plans
from plans import NAMES, PARTS, TOP

sys.path += [os.path.join(TOP, "scripts"), os.path.join(TOP, "bench")]
import evaluation_tables as tables  # noqa: E402
import readme_tables  # noqa: E402
from paper.runs import die_with_parent  # noqa: E402

BOUND = "gpu.bound."
NO_BOUNDS = (BOUND + "largest", BOUND + "fraction")  # of all others
PAGES = ("README.md", "docs/results/*.md", "docs/results/data/model_versions.csv", "rtl_tlm/run/model_version.h", "bench/paper/*.toml", plans.SET)


class Failed(Exception):
    """The message is one line. code: 2 for bad input, else 1."""

    def __init__(self, message, code=1):
        super().__init__(message)
        self.code = code


def options_of(arguments):
    parser = argparse.ArgumentParser(prog="bench/evaluate", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", metavar="PART", action="append", choices=NAMES, help=f"repeatable: {', '.join(NAMES)}")
    parser.add_argument("--plan", action="store_true", help="print points, what is done and the time on two cores, and run nothing")
    parser.add_argument("--quick", action="store_true", help="tiny generated scenes: well-formed pages below --work, no evidence")
    parser.add_argument("--scenes", metavar="DIR", default=os.environ.get("GRTX_SCENES", "scenes"),
                        help="what scripts/scenes.sh brought (default: GRTX_SCENES, else scenes)")
    parser.add_argument("--work", metavar="DIR", help="databases (default: build/evaluate, build/evaluate-quick)")
    parser.add_argument("--into", metavar="DIR", help="the tree whose pages are written (default: this one; --quick: WORK/tree)")
    parser.add_argument("--program", metavar="GRTX", default=os.environ.get("GRTX", os.path.join(TOP, "build/release/grtx")))
    parser.add_argument("--jobs", type=int, default=0, help="of grtx sweep; 0: one a core")
    parser.add_argument("--launcher", choices=("local", "slurm"), default="local", help="of grtx sweep")
    parser.add_argument("--sbatch", metavar="TEXT", default="", help="of grtx sweep")
    parser.add_argument("--retry", action="store_true", help="run what failed again")
    parser.add_argument("--keep-traces", action="store_true", help="traces stay (default: a part's go when it is done)")
    options = parser.parse_args(arguments)
    if not os.access(options.program, os.X_OK):
        parser.error(f"{options.program}: no program; build it (scripts/build.sh) or name it with --program")
    options.parts = [part for part in PARTS if part.name in (options.only or NAMES) and not (options.quick and part.role == "show")]
    options.work = options.work or os.path.join(TOP, "build", "evaluate-quick" if options.quick else "evaluate")
    try:
        views = plans.views_of(options.parts)
    except plans.BadSet as bad:
        parser.error(str(bad))
    for view in [] if options.quick or options.plan else views:
        path = os.path.join(options.scenes, view["scene"] + ".ply")
        if "preset" not in view and not os.path.exists(path):
            parser.error(f"{path}: is not there; scripts/scenes.sh brings it, --scenes names the folder")
    return options


def say(line):
    print(f"evaluate: {line}", file=sys.stderr, flush=True)


class Sweeps:
    """The databases of the folder --work: one a part and machine."""

    def __init__(self, options):
        self.options = options
        os.makedirs(options.work, exist_ok=True)

    def machines(self, part):
        return part.machines[:1] if self.options.quick and part.rows == "cards" else part.machines

    def database(self, part, machine):
        return os.path.join(self.options.work, part.folder, machine + ".sqlite")

    def call(self, *arguments, accept=(0,)):
        run = subprocess.run([self.options.program, *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                             preexec_fn=die_with_parent)
        if run.returncode not in accept:
            raise Failed(f"grtx {arguments[0]}: {(run.stderr.strip().splitlines() or ['no word'])[-1]}", 2 if run.returncode == 2 else 1)
        return run.stdout

    def plan(self, part, machine):
        """Path of the plan, written if it is another than before."""
        path = self.database(part, machine).replace(".sqlite", ".toml")
        os.makedirs(os.path.dirname(path), exist_ok=True)
        text = plans.text(part, machine, self.options.scenes, self.options.quick)
        if not os.path.exists(path) or readme_tables.model_version.read("", path) != text:
            readme_tables.model_version.write("", path, text)
        return path

    def run(self, part):
        for machine in self.machines(part):
            path = self.database(part, machine)
            plan = self.plan(part, machine)
            if self.states(part, machine) != {"done"} or self.options.retry:
                say(f"{part.folder} on {machine}: {len(plans.views(part, self.options.quick))} views, "
                    f"{len(plans.points(part, machine, self.options.quick))} points each")
                more = ["--retry"] if self.options.retry else []
                more += ["--sbatch", self.options.sbatch] if self.options.sbatch else []
                self.call("sweep", plan, "-o", path, "--machine", plans.file_of(machine), "--jobs", self.options.jobs, "--launcher", self.options.launcher,
                          "--quiet", *more, accept=(0, 1))
                self.call("report", path, "-o", path.replace(".sqlite", ".html"), "--quiet")
        if not self.options.keep_traces:  # machines of a part share them
            shutil.rmtree(os.path.join(self.options.work, part.folder, "traces"), ignore_errors=True)

    def states(self, part, machine):
        """States of the points of the plan in the database, by the plan's text that filled it; {None}: of another plan or model."""
        path, plan = self.database(part, machine), self.plan(part, machine)
        if not os.path.exists(path):
            return {None}
        listed = json.loads(self.call("sweep", plan, "-o", path, "--machine", plans.file_of(machine), "--list", "--json"))
        return {point["status"] for point in listed["points"] if not point["earlier_plan"]}

    def rows(self, part):
        """Rows of the CSV: of what is done of the part. Points that are not are named."""
        rows, missing = [], 0
        for machine in self.machines(part):
            if not os.path.exists(self.database(part, machine)):
                continue
            database = sqlite3.connect(f"file:{self.database(part, machine)}?mode=ro", uri=True)
            meta = dict(database.execute("SELECT key, value FROM meta"))
            of = {}
            for number, scene, coordinates, status, reason in database.execute(
                    "SELECT id, scene, coordinates, status, reason FROM point JOIN present ON point_id = id"):
                of[scene, json.dumps(json.loads(coordinates), sort_keys=True)] = number, status, reason
            for view in plans.views(part, self.options.quick):
                for (design, k), own in plans.points(part, machine, self.options.quick).items():
                    number, status, reason = of[plans.label(view), json.dumps(plans.whole(part, own), sort_keys=True)]
                    if status == "done":
                        values = dict(database.execute("SELECT name, value FROM value WHERE point_id = ?", (number,)))
                        rows.append(self.row(part, machine, view, design, k, values, meta))
                    else:
                        missing += 1
                        say(f"{part.name} on {machine}: {plans.label(view)}, {design}, k = {k}: {status}: {reason}")
        return rows, missing

    def row(self, part, machine, view, design, k, v, meta):
        bound = max((name for name in v if name.startswith(BOUND) and name not in NO_BOUNDS), key=v.get)
        values = {"cycles": int(v["gpu.cycles"]), "half_interval": 0.0, "energy_nj_per_ray": v["gpu.energy_nj_per_ray"],
                  "rt_unit_mm2": v["cost.rt_unit_mm2"], "chip_mm2": v["cost.mm2"], "bound_cycles": v[bound],
                  "l2_accesses": v["gpu.l2.accesses"], "node_latency": v["gpu.rt.node_fetch_latency"], "node_fetches": v["gpu.rt.node_fetches"],
                  "node_visits": v["gpu.rt.node_visits"], "instructions": v["gpu.simt.instructions.total"], "dram_bytes": v["gpu.dram.bytes"],
                  "node_hit_rate": v["gpu.l1.node.hit_rate"],
                  "rays": round(v["gpu.energy_nj"] / v["gpu.energy_nj_per_ray"])}
        took = "; ".join([f"tuned: {what}" for what in view.get("tuned", [])] + [f"fitted: {what}" for what in view.get("fitted", [])])
        return {"part": part.name, "machine": machine, "mode": part.mode, "view": plans.label(view), "class": view["class"],
                "generated": int("preset" in view), "took_part": took, "design": design, "k": k,
                **{name: f"{value:.7g}" if isinstance(value, float) else value for name, value in values.items()}, "bound": bound.removeprefix(BOUND),
                "model": meta["model_version"], "set": tables.hash_of_set(TOP), "date": meta["created"][:10]}


def estimate(sweeps, options):
    """A line per part and machine: points, those done, hours of two cores for the rest; and how many hours all may take."""
    print(f"{'part':14}{'machine':18}{'points':>7}{'done':>6}{'hours left':>12}")
    total = 0.0
    for part in options.parts:
        for machine in sweeps.machines(part):
            count = len(plans.views(part, options.quick)) * len(plans.points(part, machine, options.quick))
            done, seconds = 0, part.seconds
            path = sweeps.database(part, machine)
            if os.path.exists(path):
                done, own = sqlite3.connect(f"file:{path}?mode=ro", uri=True).execute(
                    "SELECT count(*), avg(point.seconds + ifnull(trace.seconds, 0)) FROM point JOIN present ON point_id = id "
                    "LEFT JOIN trace ON trace.key = trace_key WHERE point.status = 'done'").fetchone()
                seconds = own or seconds
            hours = (count - done) * seconds / 2 / 3600
            total += hours
            print(f"{part.folder:14}{machine:18}{count:7}{done:6}{hours:12.2f}")
    print(f"{'together':45}{total:12.2f} of at most {plans.HOURS}")


def write_pages(options, rows):
    """The CSV with these rows in place of those of their parts, and whatever is made of it."""
    into = options.into or (os.path.join(options.work, "tree") if options.quick else TOP)
    if os.path.realpath(into) != os.path.realpath(TOP):
        for pattern in PAGES:
            for path in glob.glob(os.path.join(TOP, pattern)):
                target = os.path.join(into, os.path.relpath(path, TOP))
                os.makedirs(os.path.dirname(target), exist_ok=True)
                shutil.copyfile(path, target)
    fresh = {row["part"] for row in rows}
    kept = [row for row in tables.load(into) if row["part"] not in fresh]
    order = list(NAMES)
    path = os.path.join(into, tables.DATA)
    with open(path + ".partial", "w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, tables.COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(sorted(kept + rows, key=lambda row: order.index(row["part"])))
    os.replace(path + ".partial", path)
    tables.renew_stamps(into)
    readme_tables.renew(into)
    say(f"{len(rows)} figures of {', '.join(sorted(fresh))}: {os.path.relpath(path)} and the pages of {os.path.relpath(into)}")


def main():
    options = options_of(sys.argv[1:])
    sweeps = Sweeps(options)
    if options.plan:
        estimate(sweeps, options)
        return 0
    rows, missing = [], 0
    try:
        for part in options.parts:
            sweeps.run(part)
            own, lacking = sweeps.rows(part)
            rows, missing = rows + own, missing + lacking
        if not rows:
            raise Failed("no point is done")
        write_pages(options, rows)
    except Failed as failure:
        say(str(failure))
        return failure.code
    return 1 if missing else 0


if __name__ == "__main__":
    sys.exit(main())
