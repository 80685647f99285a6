# SPDX-License-Identifier: Apache-2.0
"""Relations within the statistics of one run, and between the statistics of commands that look at the same thing."""
import os
import re
import tomllib

from . import views
from .case import ROOT, relation, values_of

# "whole = sum of parts", of statistics below `gpu.` (tracer's: written out). <region>: each of the names of address regions;
# <n>: numbers; <any>: any one name. A part that a run does not list is 0.
LAWS = """
rt.node_visits = rt.visits_internal + rt.visits_instance + rt.visits_leaf
rt.node_visits = rt.node_visits.<region>
rt.node_fetches = rt.node_fetches.<region>
rt.node_fetches = rt.node_fetch_latency.histogram.from_<n>
rt.node_sectors = rt.node_sectors.<region>
rt.calls = rt.warp_latency.histogram.from_<n>
rt.calls = simt.rounds
rt.occupancy_integral = rt.warp_cycles.<any>
rt.selections = sm<n>.rt.selections + sm<n>.rt<n>.selections
rt.any_hit_calls = simt.any_hit.calls
rt.checkpoint.entries_read = rt.replay_takes + rt.replay_forwards
simt.warps = sm<n>.warps
simt.warps = distributor.groups
simt.instructions.total = simt.instructions.<any>
simt.resident_warp_cycles = simt.warp_cycles.<any>
simt.lsu.sectors = simt.lsu.loads.<region> + simt.lsu.stores.<region> + rt.shader_fetch.sectors
l1.responses = l1.accesses
l1.accesses = l1.all.reads + l1.all.writes + l1.prefetch.requests
l1.all.reads = l1.all.hits + l1.all.hits_on_miss + l1.all.misses
l1.all.reads = l1.<region>.reads
l1.all.hits = l1.<region>.hits
l1.all.hits_on_miss = l1.<region>.hits_on_miss
l1.all.misses = l1.<region>.misses
l1.all.writes = l1.<region>.writes
l1.all.write_hits = l1.<region>.write_hits
l1.node.reads = rt.node_sectors
l1.stack.reads = rt.stack.fills
l1.stack.writes = rt.stack.spills
l1.checkpoint.reads = rt.checkpoint.sectors_read
l1.checkpoint.writes = rt.checkpoint.sectors_written
l1.fills = l1.sent_reads
l1.sent_reads = l1.all.misses + l1.prefetch.fetched
l1.sent_reads = l1.miss_latency.histogram.from_<n>
crossbar.request.packets = l1.sent_reads + l1.sent_writes
crossbar.reply.packets = crossbar.request.packets
l2.accesses = l2.all.reads + l2.all.writes
l2.all.reads = l1.sent_reads
l2.all.reads = l2.all.hits + l2.all.hits_on_miss + l2.all.misses
l2.all.writes = l1.sent_writes
l2.all.reads = l2.<region>.reads
l2.all.hits = l2.<region>.hits
l2.all.misses = l2.<region>.misses
l2.all.writes = l2.<region>.writes
l2.all.misses = l2.dram_reads
l2.dram_reads = l2.dram_reads.<region>
l2.dram_writes = l2.dram_writes.<region>
dram.reads = l2.dram_reads
dram.writes = l2.dram_writes
dram.responses = dram.reads + dram.writes
dram.bytes = dram.channel<n>.bytes
energy_nj = energy_nj.<any>
"""
REGIONS = "tlas|blas|leaf|instance|checkpoint|eviction|k_buffer|gaussian|sh|ray|stack"


def pattern(term):
    text = re.escape(f"gpu.{term}").replace("<region>", f"(?:{REGIONS})").replace("<n>", r"\d+").replace("<any>", r"(?!total)[a-z0-9_]+")
    return re.compile(text)


def law_terms(values):
    """(law, whole, sum of the parts) of each law."""
    for law in LAWS.strip().splitlines():
        whole, parts = law.split(" = ")
        terms = [pattern(term) for term in parts.split(" + ")]
        yield law, values.get(f"gpu.{whole}", 0), sum(v for name, v in values.items() if any(t.fullmatch(name) for t in terms))


def check_laws(case, values, config):
    for law, whole, parts in law_terms(values):
        # Energies are whole picojoules in floats; all else are integers.
        case.near(law, whole, parts, slack=1e-6 * abs(whole) if law.startswith("energy") else 0)
    cycles = values["gpu.cycles"]
    units = config["gpu.sms"] * config["gpu.rt_units"]
    stalls = sum(v for name, v in values.items() if re.fullmatch(r"gpu\.rt\.stall\.[a-z_]+", name))
    case.near("selections and stalls are the cycles of all RT units", values["gpu.rt.selections"] + stalls, units * cycles)
    case.near("bytes are sectors of 32", values["gpu.dram.bytes"], 32 * (values["gpu.dram.reads"] + values["gpu.dram.writes"]))
    period = round(1e9 / config["gpu.core_mhz"])  # whole femtoseconds, as the clock has it
    case.near("time is cycles by the clock", values["gpu.time_us"], cycles * period * 1e-9, 1e-9)
    bounds = [v for name, v in values.items() if re.fullmatch(r"gpu\.bound\.(?!largest|fraction)[a-z0-9_.]+", name)]
    case.near("the largest bound is the largest", values["gpu.bound.largest"], max(bounds))
    case.at_most("the largest bound is one of the cycles", values["gpu.bound.largest"], cycles)
    for level in ("l1.all", "l2.all", "l1.node", "l2.node"):
        reads = values[f"gpu.{level}.reads"]
        case.near(f"hit rate of {level}", values[f"gpu.{level}.hit_rate"], values[f"gpu.{level}.hits"] / max(1, reads), 1e-9)


@relation()
def counts_add_up(case):
    """Wholes are the sums of their parts: visits, sectors, L1, L2 and DRAM accesses, bytes, cycles by reason, instructions, energy."""
    rng = case.rng
    views.traced(case, "s")
    by_shader = ["--set", f"rt.memory.by_shader={rng.choice(['true', 'false', 'false'])}"]
    case.grtx("sim", "s.grtx", "--machine", rng.choice(views.MACHINES), *views.settings(rng), *by_shader, "--stats", "s.json",
              "--quiet")
    check_laws(case, case.statistics("s.json"), case.json("s.json")["config"])


# What the tracer counted, and what the hardware executed.
EXECUTED = {"tracer.visits.internal": "gpu.rt.visits_internal", "tracer.visits.instance": "gpu.rt.visits_instance",
            "tracer.visits.leaf": "gpu.rt.visits_leaf", "tracer.visits.total": "gpu.rt.node_visits",
            "tracer.any_hit.calls": "gpu.rt.any_hit_calls", "tracer.rounds": "gpu.simt.ray_rounds",
            "tracer.checkpoint.written": "gpu.rt.checkpoint.entries_written",
            "tracer.checkpoint.read": "gpu.rt.checkpoint.entries_read", "tracer.processed": "gpu.simt.processed",
            "tracer.blended": "gpu.simt.blended"}


@relation()
def machines_execute_the_trace(case):
    """Every machine executes the events of the trace; trace-check and trace --stats count the same."""
    rng = case.rng
    views.traced(case, "s")
    counted = case.statistics("s.trace.json")
    case.grtx("sim", "s.grtx", "--machine", rng.choice(views.MACHINES), *views.settings(rng), "--stats", "s.json", "--quiet")
    run = case.statistics("s.json")
    for traced, executed in EXECUTED.items():
        case.near(f"{traced} and {executed}", counted[traced], run[executed])
    totals = case.seen(case.printed(case.grtx("trace-check", "s.grtx", "--json"))["totals"])
    for name in ("rounds", "visits_internal", "visits_instance", "visits_leaf", "processed", "blended"):
        case.near(f"trace-check: {name}", totals[name], counted[f"tracer.{name.replace('visits_', 'visits.')}"])


def tracer_options(machine):
    """What a machine chooses for the tracer, its includes first."""
    with open(f"{ROOT}/configs/machines/{machine}.toml", "rb") as file:
        table = tomllib.load(file)
    options = {}
    for include in [table["include"]] if isinstance(table.get("include"), str) else table.get("include", []):
        if os.path.dirname(include) in ("", "."):
            options.update(tracer_options(include.removesuffix(".toml")))
    return {**options, **{name: str(value) for name, value in table.get("tracer", {}).items()}}


@relation()
def machines_know_their_traces(case):
    """sim names each option that a machine chooses and the trace has otherwise, in a note, and --strict refuses such a trace."""
    rng = case.rng
    of, on = rng.choice(views.MACHINES), rng.choice(views.MACHINES)
    views.traced(case, "s", design=("tlas-tri20", "on"), more=["--machine", of])
    usage = case.grtx("trace", "--help").output.decode()
    default = {name.replace("-", "_"): value for name, value in re.findall(r"(?m)^ +--([a-z-]+) [^=\n]*=(\S+)(?:  |$)", usage)}
    # What one machine chooses all have: unsaid it is the default.
    chosen = {name for machine in views.MACHINES for name in tracer_options(machine)}
    one, two = ({**default, **tracer_options(machine)} for machine in (of, on))
    other = sorted(name for name in chosen if one[name] != two[name])
    case.grtx("sim", "s.grtx", "--machine", on, "--stats", "s.json", "--quiet", ends=(0, 2))
    if case.runs[-1].code == 2:  # bins want entries of eight bytes
        case.holds("a machine that cannot take the trace says so in a line", case.runs[-1].errors.count(b"\n") == 1)
        return
    notes = {note["id"]: note["text"] for note in case.json("s.json")["notes"]}
    named = case.seen(sorted(re.findall(r"([a-z_]+) is [^ ,]+, not ", notes.get("tracer-options", ""))))
    case.same(f"options of {on} that a trace of {of} has otherwise, and those that the note names", other, named)
    strict = case.seen(case.grtx("sim", "s.grtx", "--machine", on, "--strict", "--quiet", ends=(0, 2)).code)
    case.same(f"--strict on {on} with a trace of {of}", strict, 2 if other else 0)


@relation(each=3)
def a_run_is_its_parts(case):
    """grtx run gives the statistics of trace and sim of each design, and speed-ups that are quotients of their cycles."""
    rng = case.rng
    views.scene(case, most=300)
    view = ["--scene", "s.ply", *views.view(case, most=13), "--k", 8]  # run takes each design's own otherwise
    machine = rng.choice(views.MACHINES)
    case.grtx("run", *view, "--machine", machine, "-o", "out", "--quiet")
    results = case.json("out/results.json")
    design = rng.choice(["baseline", "sw", "hw", "grtx"])
    accel, checkpoint = {"baseline": ("tri20", "off"), "sw": ("tlas-tri20", "off"), "hw": ("tri20", "on"),
                         "grtx": ("tlas-tri20", "on")}[design]
    case.grtx("trace", *view, "--machine", machine, "--accel", accel, "--checkpoint", checkpoint, "-o", "s.grtx", "--stats", "t.json",
              "--quiet")
    case.grtx("sim", "s.grtx", "--machine", machine, "--stats", "s.json", "--quiet")
    alone, together = case.statistics("s.json"), case.seen(values_of(results["designs"][design]))
    case.same(f"run and sim, {design} on {machine}", alone, {name: v for name, v in together.items() if name.startswith("gpu.")})
    traced = case.statistics("t.json")
    case.same(f"run and trace, {design} on {machine}", {n: v for n, v in traced.items() if n in together},
              {n: v for n, v in together.items() if n in traced})
    for name, speedup in case.seen(dict(results["speedup"])).items():
        cycles = [results["designs"][d]["gpu.cycles"]["value"] for d in ("baseline", name)]
        case.near(f"speed-up of {name}", speedup, cycles[0] / cycles[1], 1e-9)
