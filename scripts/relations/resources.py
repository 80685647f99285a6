# SPDX-License-Identifier: Apache-2.0
"""Relations of a machine's keys: more of a resource is not slower, and what only looks like a change changes nothing."""
import re

from fuzz_machines import POWERS, TABLE1, keys_of

from . import views
from .case import relation

# Units of which more is better, and less.
MORE = {"SMs", "MHz", "warps", "units", "heaps", "entries", "fetches", "sectors/cycle", "entries/cycle", "sectors", "pipelines",
        "schedulers", "banks", "slices", "requests", "packets", "replies", "lines", "bursts"}
LESS = {"cycles", "instructions", "clocks"}
CAPACITIES = {"l1.bytes", "l2.bytes"}
# Of which neither is better; a shape: other addresses meet.
NOT_A_RESOURCE = {
    "rt.any_hit.timeout": "a longer wait fills batches",
    "rt.warp_stack.window": "0 is all", "rt.warp_stack.write_ports": "0 is any number", "rt.warp_stack.tests": "0 is places for all",
    "rt.warp_buffer.ray_banks": "0 is no limit", "rt.memory.node_ports": "0 is no limit",
    "dram.bandwidth_gb_s": "0 is dram.mhz, which is one",
    "rt.memory.instance_leaf_bytes": "a layout of nodes",
    "rt.checkpoint.open_sectors": "each keeps less in flight",
    "rt.checkpoint.entry_bytes": "a layout of entries",
    "rt.prefetch.records": "more is fetched that no one may ask for",
    "rt.prefetch.queue": "as rt.prefetch.records",
    "simt.list_batch": "a longer scan for fewer scans",
    "simt.registers": "a limit only with simt.registers_per_thread",
    "simt.registers_per_thread": "0 is no limit",
    "simt.payload_registers": "a part of simt.registers_per_thread",
    "l1.line_bytes": "a shape", "l1.ways": "a shape", "l2.line_bytes": "a shape", "l2.ways": "a shape",
    "l1.mshr_merges": "a merge that has to wait may find its sector later for nothing",
    "l2.mshr_merges": "as l1.mshr_merges",
    "l2.slices": "each has a DRAM channel and a share of the L2: other addresses meet",
    "l2.interleave_bytes": "a shape",
    "dram.channels": "0 is one per slice; other addresses meet",
    "dram.banks": "other addresses meet in a bank",
    "dram.bank_groups": "a shape", "dram.group_bytes": "a shape", "dram.row_bytes": "a shape", "dram.burst_bytes": "a shape",
    "dram.hit_cap": "fairness", "dram.age_cap": "fairness",
    "dram.timing.rcd_wr": "0 is rcd", "dram.timing.refi": "0 is no refresh",
}
# More of these may be slower, by so much, and why.
MAY_BE_SLOWER = {
    "gpu.sms": (0.5, "each begins with a cold L1, which fewer warps share"),
    "gpu.resident_warps": (0.25, "a small launch is balanced worse (docs/model/work_distributor.md)"),
}
SLOWER = 0.10  # all others: warps meet in another order, and of a few the last one decides


def resources(program):
    """{name: (Key, whether more is better)}: unit and range as grtx sim --list-config prints them."""
    found = {}
    for key in keys_of(program):
        if key.names or key.name in NOT_A_RESOURCE:
            continue
        if key.unit in MORE or key.name in CAPACITIES:
            found[key.name] = (key, True)
        elif key.unit in LESS:
            found[key.name] = (key, False)
    return found


def two_values(rng, key):
    """A value near the default and a larger one, as text."""
    middle = key.default if key.default else rng.choice([1, 4, 16])
    low = key.text(middle * 4 ** rng.uniform(-1, 0.7))
    high = key.text(float(low) * rng.choice([2, 2, 4]) if float(low) else middle)
    return low, high


@relation()
def more_is_not_slower(case):
    """More of a resource, or less latency, takes at most 10 % more time; MAY_BE_SLOWER names the keys that may take more, and why."""
    rng = case.rng
    known = resources(case.program)
    name = rng.choice(sorted(known))
    key, better = known[name]
    views.traced(case, "s", pixels=33, preset=["object", "room", "hall", "flat"])
    # Of one or two SMs, so that there are warps to wait for; every byte charged.
    machine = ["--machine", TABLE1, "--set", f"gpu.sms={rng.choice([1, 2])}"]
    if name.startswith(("l1.", "l2.")):
        machine += ["--set", "l1.bytes=16384", "--set", "l1.ways=16", "--set", "l2.bytes=131072"]
    low, high = two_values(rng, key)
    if low == high:
        low, high = key.text(key.low), key.text(key.default or key.low + 1)
    times = []
    for number, value in enumerate((low, high) if better else (high, low)):
        done = case.grtx("sim", "s.grtx", *machine, "--set", f"{name}={value}", "--stats", f"{number}.json", "--quiet", ends=(0, 2))
        if done.code == 2:  # a rule about two keys
            case.holds("a machine that is refused is refused in a line", done.errors.count(b"\n") == 1)
            return
        times.append(case.statistics(f"{number}.json")["gpu.time_us"])
    share = MAY_BE_SLOWER.get(name, (SLOWER, ""))[0]
    case.at_most(f"{name} of {low if better else high} and then of {high if better else low}: us", times[1], times[0] * (1 + share))


@relation()
def perfect_levels_are_bounds(case):
    """A level of memory that always hits, and then the next ones too, is not slower."""
    rng = case.rng
    views.traced(case, "s", pixels=25)
    machine = ["--machine", rng.choice(views.MACHINES)]
    times = []
    for number, perfect in enumerate(((), ("dram",), ("dram", "l2"), ("dram", "l2", "l1"))):
        settings = [word for level in perfect for word in ("--set", f"{level}.perfect=true")]
        case.grtx("sim", "s.grtx", *machine, *settings, "--stats", f"{number}.json", "--quiet")
        times.append(case.statistics(f"{number}.json")["gpu.time_us"])
    for what, before, after in zip(("dram", "l2", "l1"), times, times[1:]):
        case.at_most(f"time with a perfect {what}", after, before * (1 + SLOWER))


@relation()
def clocks_set_the_pace(case):
    """All clocks twice as fast: the same cycles, the same counts, half of the time."""
    views.traced(case, "s")
    rng = case.rng
    core, dram = rng.choice([500, 1000, 1250]), rng.choice([1000, 2000, 2500])
    runs = []
    for factor in (1, 2):
        case.grtx("sim", "s.grtx", "--machine", "paper-charged", "--set", f"gpu.core_mhz={core * factor}", "--set",
                  f"dram.mhz={dram * factor}", "--stats", f"{factor}.json", "--quiet")
        runs.append(case.statistics(f"{factor}.json"))
    case.near("half of the time", runs[0]["gpu.time_us"], 2 * runs[1]["gpu.time_us"], 1e-9)
    counts = [{n: v for n, v in run.items() if "energy" not in n and n != "gpu.time_us"} for run in runs]
    case.same("counts", *counts)


@relation()
def settings_have_one_meaning(case):
    """--set, a file of --config and the machine's own file are three ways to say the same: equal statistics."""
    rng = case.rng
    views.traced(case, "s")
    machine, settings = rng.choice(views.MACHINES), []
    while not settings:
        settings = views.settings(rng)
    tables = {}
    for setting in settings[1::2]:
        key, value = setting.split("=")
        table, name = key.rsplit(".", 1)
        tables.setdefault(table, []).append(f"{name} = {value if re.fullmatch('[0-9.]+|true|false', value) else repr(value)}\n")
    text = "".join(f"[{table}]\n{''.join(lines)}" for table, lines in tables.items())
    case.write("keys.toml", text)
    case.write("own.toml", f"include = '{TABLE1.replace('table1', f'machines/{machine}')}'\n" + text)
    runs = []
    for number, how in enumerate((["--machine", machine, *settings], ["--machine", machine, "--config", "keys.toml"],
                                  ["--machine", "own.toml"])):
        case.grtx("sim", "s.grtx", *how, "--stats", f"{number}.json", "--quiet")
        runs.append(case.statistics(f"{number}.json"))
    case.same("--set and --config", runs[0], runs[1])
    case.same("--set and a machine's file", runs[0], runs[2])


@relation()
def construction_and_idle_skip_do_not_matter(case):
    """The order of construction and skipping of idle cycles change no statistic."""
    rng = case.rng
    views.traced(case, "s")
    machine = ["--machine", rng.choice(views.MACHINES), *views.settings(rng)]
    runs = []
    for number, how in enumerate(([], ["--construction-order", rng.randrange(1, 1000)], ["--no-idle-skip"])):
        case.grtx("sim", "s.grtx", *machine, *how, "--stats", f"{number}.json", "--quiet")
        runs.append(case.statistics(f"{number}.json"))
        if number:
            case.same(f"no option and {' '.join(map(str, how))}", runs[0], runs[-1])


@relation()
def warm_is_warm(case):
    """--warm T gives the statistics of --save-state of T and then --warm-state."""
    rng = case.rng
    views.traced(case, "s")
    case.grtx("trace", "--scene", "s.ply", "--cameras", "s.cameras.json", "--view", 1, *views.size(rng), "--accel", "tlas-tri20",
              "-o", "first.grtx", "--quiet")
    case.grtx("trace", "--scene", "s.ply", "--cameras", "s.cameras.json", "--view", 0, *views.size(rng), "--accel", "tlas-tri20",
              "-o", "then.grtx", "--quiet")
    machine = ["--machine", rng.choice(views.MACHINES), *views.settings(rng)]
    case.grtx("sim", "then.grtx", *machine, "--warm", "first.grtx", "--stats", "a.json", "--quiet")
    case.grtx("sim", "first.grtx", *machine, "--save-state", "state", "--quiet")
    case.grtx("sim", "then.grtx", *machine, "--warm-state", "state", "--stats", "b.json", "--quiet")
    case.same("--warm and --warm-state", case.statistics("a.json"), case.statistics("b.json"))
