# SPDX-License-Identifier: Apache-2.0
"""Relations of sweeps: a point is a run, a killed sweep is a sweep, and a figure is one figure wherever it stands."""
import html
import json
import os
import re

from . import gaussians, views
from .case import ROOT, Broken, relation, values_of

PYTHON = "/usr/bin/python3"  # the one whose packages scripts/install_dependencies.sh installs
AXES = {"l2.latency": [60, 165, 300], "rt.warp_buffer.entries": [1, 4, 16], "rt.box.count": [1, 2, 4],
        "tracer.k": [2, 4, 8, 16], "gpu.core_mhz": [800, 1365.5], "l1.replacement": ["lru", "fifo"],
        "tracer.child_order": ["slot", "near_first"], "tracer.bvh_width": [3, 4, 6], "tracer.warp_size": [16, 32]}


def toml(value):
    return json.dumps(value)


def plan(case, name, designs=("baseline", "sw", "hw", "grtx"), axes=2, values=2):
    """Writes NAME.toml: a generated scene, one or two views, a grid. Gives what it is made of."""
    rng = case.rng
    chosen = {key: rng.sample(AXES[key], min(values, len(AXES[key]))) for key in rng.sample(list(AXES), axes)}
    scene = {"preset": rng.choice(gaussians.PRESETS), "count": rng.randrange(60, 300), "seed": rng.randrange(1 << 30),
             "sh_degree": rng.randrange(4), "views": rng.choice([[0], [1], [0, 1]]), "width": rng.randrange(4, 14),
             "height": rng.randrange(4, 14), "fov_scale": rng.choice([0.5, 1.0, 1.5])}
    made = {"designs": rng.sample(designs, rng.choice([1, 2])), "scene": scene, "grid": chosen,
            "set": {"gpu.sms": rng.choice([1, 2])}}
    if "tracer.k" not in chosen:
        made["set"]["tracer.k"] = 8  # a design has its own otherwise
    case.write(f"{name}.toml", f"designs = {toml(made['designs'])}\n[[scene]]\n" +
               "".join(f"{key} = {toml(value)}\n" for key, value in scene.items()) +
               "[set]\n" + "".join(f"{key} = {toml(value)}\n" for key, value in made["set"].items()) +
               "[grid]\n" + "".join(f"{key} = {toml(value)}\n" for key, value in chosen.items()))
    return made


def structure(design):
    return ["--accel", "tlas-tri20" if design in ("sw", "grtx") else "tri20", "--checkpoint",
            "on" if design in ("hw", "grtx") else "off"]


def points(case, database):
    """Finished points of a database: what they are, and their document."""
    return [(design, json.loads(coordinates), json.loads(document)) for design, coordinates, document in
            case.rows(database, "SELECT design, coordinates, document FROM point WHERE status = 'done' ORDER BY id")]


@relation(each=3)
def sweep_points_are_runs(case):
    """A point of a sweep has every statistic, area and leakage of trace, sim and cost called by hand, on any machine."""
    rng = case.rng
    machine = rng.choice(views.MACHINES)
    made = plan(case, "plan")
    case.grtx("sweep", "plan.toml", "--machine", machine, "-o", "db.sqlite", "--quiet")
    scene = made["scene"]
    case.grtx("synth", "--preset", scene["preset"], "--count", scene["count"], "--seed", scene["seed"], "--sh-degree",
              scene["sh_degree"], "-o", "s.ply", "--quiet")
    design, coordinates, document = rng.choice(points(case, "db.sqlite"))
    tracer, settings = [], []
    for key, value in {**made["set"], **coordinates}.items():
        if key.startswith("tracer."):
            tracer += [f"--{key[7:].replace('_', '-')}", value]
        elif key in made["set"] or key in made["grid"]:
            settings += ["--set", f"{key}={value}"]
    view = coordinates.get("view", scene["views"][0])
    case.grtx("trace", "--scene", "s.ply", "--cameras", "s.cameras.json", "--view", view, "--width", scene["width"], "--height",
              scene["height"], "--fov-scale", scene["fov_scale"], "--machine", machine, *structure(design), *tracer, "-o", "s.grtx", "--quiet")
    case.grtx("sim", "s.grtx", "--machine", machine, *settings, "--stats", "s.json", "--quiet")
    what = f"sweep and sim, {design} {coordinates} on {machine}"
    case.same(what, case.seen(values_of(document["stats"])), case.statistics("s.json"))
    own = case.json("s.json")
    case.same(f"{what}: configuration", case.seen(document["config"]), case.seen(own["config"]))
    # Two files of one content have names of their own.
    swept, run = (case.seen({k: v for k, v in d["inputs"].items() if k.startswith("trace.") and k not in ("trace.files", "trace.scene")
                             and k != "trace.files_hash"}) for d in (document, own))
    case.same(f"{what}: options of the trace", swept, run)


@relation(each=4)
def sweep_traces_are_traces(case):
    """The traces of a sweep, made by processes that keep scene and structure, are the files of trace, byte for byte."""
    rng = case.rng
    views.scene(case, most=300)
    machine = rng.choice(views.MACHINES)
    axes = {key: AXES[key] for key in AXES if key.startswith("tracer.")}
    chosen = {key: rng.sample(axes[key], 2) for key in rng.sample(list(axes), 2)}
    case.write("plan.toml", "designs = ['sw', 'grtx', 'baseline']\n[[scene]]\nfile = 's.ply'\n"
                            "cameras = 's.cameras.json'\nviews = [0, 1]\nwidth = 9\nheight = 5\n[grid]\n" +
               "".join(f"{key} = {toml(value)}\n" for key, value in chosen.items()))
    case.grtx("sweep", "plan.toml", "--machine", machine, "--jobs", rng.choice([1, 2]), "-o", "db.sqlite", "--quiet")
    rows = case.rows("db.sqlite", "SELECT design, coordinates, path FROM point JOIN trace ON trace.key = trace_key ORDER BY id")
    for number, (design, text, path) in enumerate(rng.sample(rows, 4)):
        coordinates = json.loads(text)
        options = [word for key in chosen for word in (f"--{key[7:].replace('_', '-')}", coordinates[key])]
        case.grtx("trace", "--scene", "s.ply", "--cameras", "s.cameras.json", "--view", coordinates["view"], "--width", 9, "--height",
                  5, "--machine", machine, *structure(design), *options, "-o", f"{number}.grtx", "--quiet")
        case.same(f"trace of {design} {text} on {machine}", case.content(path), case.content(f"{number}.grtx"))


@relation(each=4)
def killed_sweeps_end_as_undisturbed(case):
    """A sweep that is killed again and again, and started again, ends with the results of an undisturbed one."""
    rng = case.rng
    plan(case, "plan")
    sweep = ["sweep", "plan.toml", "--jobs", rng.choice([1, 2]), "--quiet", "-o"]
    case.grtx(*sweep, "whole.sqlite")
    os.makedirs(case.path("killed"), exist_ok=True)
    for _ in range(rng.choice([1, 2, 4])):
        case.grtx(*sweep, "killed/db.sqlite", kill_after=rng.uniform(0.02, 0.5))
    case.grtx(*sweep, "killed/db.sqlite", "--retry")
    case.grtx("sweep", "--compare", "whole.sqlite", "killed/db.sqlite", "--quiet")
    query = "SELECT key, mode, scene, design, coordinates, config, status, document FROM point ORDER BY key"
    whole, killed = (case.seen(case.rows(name, query)) for name in ("whole.sqlite", "killed/db.sqlite"))
    case.same("points of the two databases", whole, killed)
    left = sorted(set(os.listdir(case.path("killed"))) - {"db.sqlite", "traces"})
    case.same("files that are left", left, [])


def page_points(page):
    """{point: {column: text}} of the tables of points of a report."""
    found = {}
    for table in re.findall(r'<table id="sweep\d+_points">.*?</table>', page, re.S):
        titles = [html.unescape(t) for t in re.findall(r"<th scope=\"col\"[^>]*>(.*?)</th>", table)]
        for row in re.findall(r"<tr data-id=.*?</tr>", table, re.S):
            cells = [html.unescape(re.sub("<[^>]*>", "", c)) for c in re.findall(r"<t[hd][ >].*?</t[hd]>", row)]
            found[cells[0]] = dict(zip(titles, cells))
    return found


def shown(value):
    """A number as a report's table has it: four digits, or whole."""
    return f"{value:.4g}" if value != int(value) and abs(value) < 1000 else f"{value:,.0f}"


def python_frame(case, database, names):
    """{point: {name: value}} as read_sweep gives them; None where pandas is missing."""
    program = ("import json, sys\nimport grtx_tlm\nframe = grtx_tlm.read_sweep(sys.argv[1])\n"
               "print(json.dumps({str(i): {n: row[n] for n in sys.argv[2:]} for i, row in frame.iterrows()}, default=float))")
    done = case.grtx("-B", "-c", program, database, *names, ends=(0, 1), program=PYTHON,
                     environment={"PYTHONPATH": f"{ROOT}/python"})
    if done.code == 0:
        return json.loads(done.output)
    if b"No module named 'pandas'" in done.errors or b"No module named 'numpy'" in done.errors:
        case.skipped.add("read_sweep: pandas is missing")
        return None
    raise Broken(f"read_sweep: {done.errors.decode(errors='replace').strip().splitlines()[-1]}")


FIGURES = {"gpu.time_us": "time, µs", "gpu.cycles": "cycles", "cost.mm2": "chip, mm²", "gpu.energy_nj_per_ray": "nJ per ray"}


@relation(each=3)
def a_figure_is_one_figure(case):
    """SQLite's document and table, read_sweep, sweep --list and the report's table give the same figure for a point."""
    machine = case.rng.choice(views.MACHINES)
    plan(case, "plan")
    case.grtx("sweep", "plan.toml", "--machine", machine, "-o", "db.sqlite", "--quiet")
    case.grtx("report", "db.sqlite", "-o", "r.html", "--quiet")
    rows = case.rows("db.sqlite", "SELECT id, machine, mode, scene, design, coordinates, document FROM point ORDER BY id")
    values = {}
    for point, name, value in case.rows("db.sqlite", "SELECT point_id, name, value FROM value"):
        values.setdefault(point, {})[name] = value
    frame = case.seen(python_frame(case, "db.sqlite", ["machine", "mode", "scene", "design", *FIGURES]))
    with open(case.path("r.html"), encoding="utf-8") as file:
        page = page_points(file.read())
    listed = case.printed(case.grtx("sweep", "plan.toml", "--machine", machine, "-o", "db.sqlite", "--list", "--json"))["points"]
    names = ("machine", "mode", "scene", "design", "coordinates")
    case.same("points of list and database", case.seen(sorted(json.dumps([p[name] for name in names], sort_keys=True) for p in listed)),
              sorted(json.dumps([*row[1:5], json.loads(row[5])], sort_keys=True) for row in rows))
    for point, own_machine, mode, scene, design, _, document in rows:
        own = values_of(json.loads(document)["stats"])
        numbers = {name: value for name, value in own.items() if isinstance(value, (int, float))}
        table = case.seen({name: value for name, value in values[point].items() if not name.startswith("cost.")})
        case.same(f"point {point}: document and table", numbers, table)
        report = case.seen(page[f"#{point}"])
        for name, title in FIGURES.items():
            case.same(f"point {point}: {name} of table and report", shown(values[point][name]), report[title])
            if frame is not None:
                case.near(f"point {point}: {name} of table and Python", values[point][name], frame[str(point)][name])
        if frame is not None:
            case.same(f"point {point}: what it is", [frame[str(point)][name] for name in names[:4]], [own_machine, mode, scene, design])
        case.same(f"point {point}: its machine", [own_machine, json.loads(document)["inputs"]["machine"].split(",")[0]], [machine] * 2)


def told(case, database, plan, machine):
    """What list, report and Python say of the points of the present plan, without the numbers that points have."""
    case.grtx("report", database, "-o", f"{database}.html", "--quiet")
    with open(case.path(f"{database}.html"), encoding="utf-8") as file:
        page = sorted(json.dumps({k: v for k, v in row.items() if k != "point"}, sort_keys=True)
                      for row in page_points(file.read()).values())
    listed = case.printed(case.grtx("sweep", plan, "--machine", machine, "-o", database, "--list", "--json"))["points"]
    points = sorted(json.dumps([p["machine"], p["mode"], p["scene"], p["design"], p["status"]]) for p in listed if not p["earlier_plan"])
    frame = python_frame(case, database, ["machine", "mode", "design", "earlier_plan", *FIGURES])
    rows = sorted(json.dumps(row, sort_keys=True) for row in (frame or {}).values() if not row["earlier_plan"])
    return case.seen({"report": page, "list": points, **({"Python": rows} if frame else {})})


@relation(each=4)
def edited_plans_are_new_plans(case):
    """A database that an edited plan, or the same on another machine, goes on with tells what a new one tells."""
    rng = case.rng
    machine, other = rng.sample(views.MACHINES, 2)
    plan(case, "plan", axes=1)
    with open(case.path("plan.toml"), encoding="utf-8") as file:
        text = file.read()
    edits = [("gpu.sms = 2", "gpu.sms = 3"), ("gpu.sms = 1", "gpu.sms = 3"), ("[grid]", "[tracer]\nert = 0.1\n[grid]"),
             ("width = ", "width = 1"), ("fov_scale = ", "fov_scale = 0.3 # "), ("views = ", "views = [1] # ")]
    before, after = rng.choice([edit for edit in edits if edit[0] in text])
    case.write("edited.toml", text.replace(before, after))
    on = rng.choice([machine, other])
    case.grtx("sweep", "plan.toml", "--machine", machine, "-o", "old.sqlite", "--quiet")
    case.grtx("sweep", "edited.toml", "--machine", on, "-o", "old.sqlite", "--quiet")
    case.grtx("sweep", "edited.toml", "--machine", on, "-o", "new.sqlite", "--quiet")
    case.grtx("sweep", "--compare", "new.sqlite", "old.sqlite", "--quiet")
    case.same(f"{machine}, then {after!r} on {on}: new and old", *(told(case, name, "edited.toml", on) for name in
                                                                 ("new.sqlite", "old.sqlite")))


@relation(each=4)
def sweeps_do_not_depend_on_their_order(case):
    """A plan in two parts, in one database, gives the points of the whole plan; so do its axes in another order."""
    made = plan(case, "plan", axes=2, values=2)
    with open(case.path("plan.toml"), encoding="utf-8") as file:
        text = file.read()
    head, grid = text.split("[grid]\n")
    lines = grid.splitlines()
    case.write("turned.toml", head + "[grid]\n" + "\n".join(reversed(lines)) + "\n")
    key, values = next(iter(made["grid"].items()))
    case.write("half.toml", head + "[grid]\n" + f"{key} = {toml(values[:1])}\n" + "\n".join(lines[1:]) + "\n")
    case.grtx("sweep", "plan.toml", "-o", "a.sqlite", "--quiet")
    for name in ("half", "turned"):
        case.grtx("sweep", f"{name}.toml", "-o", "b.sqlite", "--quiet")
    query = "SELECT key, mode, scene, design, config, status, document FROM point ORDER BY key"
    one, two = (case.seen(case.rows(name, query)) for name in ("a.sqlite", "b.sqlite"))
    case.same("points of a whole plan and of its parts", one, two)

