# SPDX-License-Identifier: Apache-2.0
"""Relations of energy, area and leakage: wholes are sums, and every command prices alike."""
import json

from . import gaussians, views
from .case import relation, values_of


def priced_trace(case):
    """Makes s.grtx with what changes a price: structure, layout, width of nodes, test of popped nodes, bins, an object list. Gives
    the options of the machine."""
    rng = case.rng
    machine = rng.choice(views.MACHINES)
    views.scene(case, most=200)
    scene, accel = "s.ply", rng.choice(views.DESIGNS)
    more = ["--pop-test", rng.choice(["on", "off"]), "--layout", rng.choice(["vulkan_sim", "compact", "compressed"])]
    if more[-1] != "compressed":
        more += ["--bvh-width", rng.randrange(2, 9)]
    settings = views.settings(rng)
    if accel[1] == "on" and rng.random() < 0.5:
        more += ["--checkpoint-bins", rng.choice([2, 4])]
        settings += ["--set", "rt.checkpoint.entry_bytes=8"]  # which bins want
    if rng.random() < 0.3:
        accel, scene = ("tlas-tri20", accel[1]), "objects.json"
        gaussians.write_cameras(case.path(scene), [{"file": "s.ply"}, {"file": "s.ply", "translate": [0.5, 0, 0]}])
    more = [] if rng.random() < 0.3 else more  # the machine's own
    case.grtx("trace", "--scene", scene, *views.view(case, most=17), "--machine", machine, "--accel", accel[0], "--checkpoint",
              accel[1], *more, "-o", "s.grtx", "--quiet")
    return ["--machine", machine, *settings]


@relation()
def energy_is_one_sum(case):
    """sim's energy is the sum of its parts and that of cost --stats, part by part, between its low and its high end."""
    machine = priced_trace(case)
    case.grtx("sim", "s.grtx", *machine, "--stats", "s.json", "--quiet")
    values = case.statistics("s.json")
    parts = {name[len("gpu.energy_nj."):]: value for name, value in values.items() if name.startswith("gpu.energy_nj.")}
    case.near("sim: energy and its parts", values["gpu.energy_nj"], sum(parts.values()), slack=1e-6 * values["gpu.energy_nj"])
    case.at_most("the low end of the energy", values["gpu.energy_nj_low"], values["gpu.energy_nj"])
    case.at_most("the energy", values["gpu.energy_nj"], values["gpu.energy_nj_high"])
    cost = case.printed(case.grtx("cost", *machine, "--stats", "s.json", "--json"))
    own = {}
    for part in case.seen([[part["part"], part["nanojoules"]["central"]] for part in cost["parts"]]):
        group = part[0].split(".")[0]
        own[group] = own.get(group, 0.0) + part[1]
    for group in sorted({*own, *parts}):
        # Each of the parts of sim is a whole number of picojoules.
        case.near(f"{machine[1]}: energy of {group} by sim and by cost", parts.get(group, 0.0), own.get(group, 0.0), slack=0.01)


def totals(node):
    """Area and leakage of the own items and the children of a node of cost's tree."""
    parts = [*node["items"], *(child for child in node["children"] for _ in range(child["copies"]))]
    return {(name, end): sum(part[name][end] for part in parts) for name in ("area_mm2", "leakage_mw", "gate_equivalents")
            for end in ("low", "central", "high")}


def check_tree(case, node, place):
    for (name, end), sum_of_parts in totals(node).items():
        case.near(f"{place}: {name}, {end}, and its parts", node[name][end], sum_of_parts, 1e-9)
    for child in node["children"]:
        check_tree(case, child, f"{place}.{child['name']}")


@relation()
def area_is_one_sum(case):
    """Area, gates and leakage of every node of cost's tree are the sums of its items and children."""
    rng = case.rng
    document = case.printed(case.grtx("cost", "--machine", rng.choice(views.MACHINES), *views.settings(rng), "--design",
                                      rng.choice(["baseline", "sw", "hw", "grtx"]), "--layout",
                                      rng.choice(["vulkan_sim", "compact", "compressed"]), "--json"))
    check_tree(case, case.seen(document["tree"]), "gpu")


@relation(each=3)
def sweeps_price_alike(case):
    """A sweep's energy, area and leakage are those of sim and of cost for the same trace, widths of nodes and object lists too."""
    rng = case.rng
    machine, width, accel = rng.choice(views.MACHINES), rng.randrange(2, 9), rng.choice(["sw", "grtx"])
    views.scene(case, most=200)
    objects = rng.random() < 0.5
    if objects:
        gaussians.write_cameras(case.path("objects.json"), [{"file": "s.ply"}, {"file": "s.ply", "translate": [0.5, 0, 0]}])
    scene = "objects.json" if objects else "s.ply"
    case.write("plan.toml", f"designs = ['{accel}']\n[[scene]]\nfile = '{scene}'\ncameras = 's.cameras.json'\nwidth = 8\nheight = 6\n"
                            f"[tracer]\nk = 8\nbvh_width = {width}\nlayout = 'vulkan_sim'\n[set]\ngpu.sms = 2\n[grid]\nl2.latency = [100]\n")
    case.grtx("sweep", "plan.toml", "--machine", machine, "-o", "db.sqlite", "--quiet")
    case.grtx("trace", "--scene", scene, "--cameras", "s.cameras.json", "--width", 8, "--height", 6, "--machine", machine, "--accel",
              "tlas-tri20", "--checkpoint", "on" if accel == "grtx" else "off", "--k", 8, "--bvh-width", width, "--layout", "vulkan_sim", "-o",
              "s.grtx", "--quiet")
    settings = ["--machine", machine, "--set", "gpu.sms=2", "--set", "l2.latency=100"]
    case.grtx("sim", "s.grtx", *settings, "--stats", "s.json", "--quiet")
    document = json.loads(case.rows("db.sqlite", "SELECT document FROM point")[0][0])
    swept, run = case.seen(values_of(document["stats"])), case.statistics("s.json")
    case.same("energies of sweep and sim", {n: v for n, v in swept.items() if "energy" in n},
              {n: v for n, v in run.items() if "energy" in n})
    # What cost says of the run: leakage is the whole machine's, which has all of its area.
    parts = case.printed(case.grtx("cost", *settings, "--stats", "s.json", "--json"))["parts"]
    leakage = case.seen(next(part["nanojoules"]["central"] for part in parts if part["part"] == "leakage"))
    mw = case.seen(next(value for name, value in case.rows("db.sqlite", "SELECT name, value FROM value") if name == "cost.leakage_mw"))
    case.near(f"{machine}, width {width}{', objects' if objects else ''}: leakage of sweep and cost", mw * run["gpu.time_us"], leakage,
              1e-6, slack=0.001)  # whole picojoules
