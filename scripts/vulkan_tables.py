# SPDX-License-Identifier: Apache-2.0
"""Tables of docs/results/vulkan-sim.md from vulkan-sim.csv and vulkan-sim-paper.csv in docs/results/data, and the sentences of that page
with figures of them; readme_tables.py puts the tables into the page, and checks both."""
import os

import page_data
from evaluation_tables import PAPER, mean, paper_figures, shown, table

PAGE = os.path.join("docs", "results", "vulkan-sim.md")
DATA, READINGS = "vulkan-sim.csv", "vulkan-sim-paper.csv"
LEVELS = ("tri20", "tlas-tri20")  # one level, two
VIEWS = ("room", "object", "hall")
NO_STORES = "no stores of hits"
ASKED = NO_STORES + ", lanes that have asked"
TWO_SMS = ASKED + ", our order, two SMs"
REPLAY, OTHER_ORDER, STACK = "the replay's order here", "rt.memory.oldest_warp_first=false", "the whole stack"
APART, FITTED = ("taebak", "wang_sha", "hon_sui_sen"), ("headquarter_garden", "lacadiere")
CHARGED = ("lacadiere", "wang_sha", "hon_sui_sen")
RATIOS = (("sw", "cycles"), ("hw", "cycles"), ("grtx", "cycles"), ("grtx", "l2_accesses"), ("grtx", "node_latency"), ("grtx", "node_fetches"))


def percent(ratio, digits=1):
    """How far a ratio is from 1, with its sign."""
    off = f"{100 * (ratio - 1):+.{digits}f}"
    return (off if float(off) else off[1:]).replace("-", "−") + " %"


def number(cell, digits=0):
    return f"{float(cell):,.{digits}f}"


class Replays:
    """Cases are (view, structure, pixels of a side, with descriptors); quantities of both sides by what was changed."""

    def __init__(self, rows):
        self.at = {(row["view"], row["structure"], int(row["pixels"]), row["descriptors"], row["setting"], row["quantity"]): row for row in rows}
        self.cases = list(dict.fromkeys(key[:4] for key in self.at if key[4:] == ("", "cycles")))
        self.plain = [case for case in self.cases if case[0] in VIEWS]

    def cell(self, side, case, quantity="cycles", setting=""):
        row = self.at.get((*case, setting, quantity))
        return row[side] if row else ""

    def ours(self, *key):
        return float(self.cell("ours", *key))

    def theirs(self, *key):
        return float(self.cell("theirs", *key))

    def ratio(self, *key):
        return self.ours(*key) / self.theirs(*key)

    def pair(self, case, quantity, setting=""):
        return ", ".join(number(self.cell(side, case, quantity, setting)) for side in ("theirs", "ours"))

    def of(self, setting):
        return list(dict.fromkeys(key[:4] for key in self.at if key[4:] == (setting, "cycles")))

    def over_sw(self):
        """{case of one level: baseline ÷ sw of ours over theirs}."""
        both = [(case, (case[0], LEVELS[1], *case[2:])) for case in self.plain if case[1] == LEVELS[0]]
        return {base: self.ratio(base) / self.ratio(sw) for base, sw in both if sw in self.cases}


def replays(top):
    rows = page_data.rows(top, DATA)
    return Replays(rows) if rows else None


def name(case, sized=True):
    return f"{case[0]}, {case[1]}" + (f", {case[2]}²" if sized else "")


def cases(of):
    """Every case as it is."""
    lines = [["the same, box corners" if case[0].endswith("box corners") else name(case), case[3],
              *(number(of.cell(side, case)) for side in ("theirs", "ours")),
              *(shown(of.ratio(case, quantity), 3) for quantity in ("cycles", "warp_latency", "l1_misses"))] for case in of.cases]
    return table(["view", "descriptors", "theirs, cycles", "ours", "ours ÷ theirs", "time of a warp in the unit, ÷", "sectors that leave the L1, ÷"], lines)


def goals(of):
    """How many cases meet each goal, and the range by size."""
    def line(goal, within, ratios):
        met = sum(abs(ratio - 1) <= within for ratio in ratios.values())
        spans = []
        for pixels in (16, 32, 64):
            own = [ratio for case, ratio in ratios.items() if case[2] == pixels]
            spans.append(f"{percent(min(own))[:-2]} to {percent(max(own))}")
        return [f"{goal} within {100 * within:.0f} %", f"{met} of {len(ratios)}", *spans]
    cycles = {case: of.ratio(case) for case in of.cases}
    level = lambda structure: {case: ratio for case, ratio in cycles.items() if case[1] == structure}
    return table(["goal", "met", "16²", "32²", "64²"], [
        line("cycles of tri20", 0.05, level(LEVELS[0])), line("cycles of tlas-tri20", 0.1, level(LEVELS[1])), line("cycles", 0.03, cycles),
        line("baseline ÷ sw", 0.05, of.over_sw()), line("sectors that leave the L1", 0.02, {case: of.ratio(case, "l1_misses") for case in of.cases})])


def stores(of):
    """The room without the stores of hits."""
    def triple(case, quantity, shortened=number):
        both = [shortened(of.cell("theirs", case, quantity, setting)) for setting in ("", NO_STORES)]
        return ", ".join([*both, shortened(of.cell("ours", case, quantity, NO_STORES))])
    return table(["room", "descriptors", "cycles without, ours", "DRAM reads with, without, ours", "mean time of a warp in the RT unit with, without, ours"],
                 [[f"{case[1]}, {case[2]}²", case[3], f"{of.pair(case, 'cycles', NO_STORES)} ({percent(of.ratio(case, 'cycles', NO_STORES))})",
                   triple(case, "dram_reads"), triple(case, "warp_latency")] for case in of.of(NO_STORES)])


def habits(of):
    """The room without both habits."""
    return table(["room", "descriptors", "cycles theirs, ours", "a warp", "sectors asked for", "that leave the L1", "DRAM reads"],
                 [[f"{case[1]}, {case[2]}²", case[3], f"{of.pair(case, 'cycles', ASKED)} ({percent(of.ratio(case, 'cycles', ASKED))})",
                   *(of.pair(case, quantity, ASKED) for quantity in ("warp_latency", "l1_sectors", "l1_misses", "dram_reads"))] for case in of.of(ASKED)])


def requests(of):
    """Two levels where a request was counted by SM on both sides."""
    lines = []
    for case in of.cases:
        if of.cell("theirs", case, "busiest_sm_requests"):
            busy = [100 * float(of.cell(side, case, "busiest_sm_requests")) / float(of.cell(side, case)) for side in ("theirs", "ours")]
            lines.append([f"{case[0]}, {case[2]}²", *(f"{share:.1f}" for share in busy),
                          *(number(of.cell(side, case, "busiest_sm_requests")) for side in ("theirs", "ours")),
                          *(shown(of.ratio(case, quantity), 3) for quantity in ("busiest_sm_requests", "cycles"))])
    return table(["tlas-tri20, descriptors", "the busiest SM sends in, % of cycles: theirs", "ours", "its requests, theirs", "ours", "ours ÷ theirs",
                  "cycles, ours ÷ theirs"], lines)


def orders(of):
    return table(["64²", "sectors that leave the L1", "cycles"],
                 [[name(case, sized=False), *(shown(of.ratio(case, quantity, REPLAY), 3) for quantity in ("l1_misses", "cycles"))] for case in of.of(REPLAY)])


def processor(of):
    lines = []
    for pixels in (16, 32, 64):
        own = [case for case in of.plain if case[2] == pixels and of.cell("ours", case, "processor_seconds")]
        seconds = [[float(of.cell(side, case, "processor_seconds")) for case in own] for side in ("theirs", "ours")]
        quicker = [theirs / ours for theirs, ours in zip(*seconds)]
        lines.append([f"{pixels}²", *(f"{min(side):.{digits}f} to {max(side):.{digits}f}" for side, digits in zip(seconds, (1, 2))),
                      f"{min(quicker):.0f} to {max(quicker):.0f}"])
    return table([f"{3 * len(own)} views", "theirs, mended", "ours", "÷"], lines)


def in_stack(of, view, structure, quantity, setting=STACK):
    return of.at.get((view, structure, 16, "", setting, quantity))


def stack_hits(of):
    lines = []
    for quantity, called in (("rounds", "rounds"), ("any_hits_front", "any-hits of front faces"),
                             ("any_hits_both_faces", "any-hits of both faces, theirs alone"),
                             ("hits_taken", "hits taken from buffers"), ("hits_blended", "hits blended"),
                             ("transmittance_difference", "transmittance of a ray, largest difference ÷ ours")):
        cells = []
        for view in VIEWS[:2]:
            found = {row[side] for structure in LEVELS for row in [in_stack(of, view, structure, quantity)] for side in ("theirs", "ours") if row[side]}
            # One figure stands for both sides and both structures.
            cells.append(" or ".join(sorted((f"{float(value):.1e}".replace("e-0", "e-") if "e-" in value else number(value)) for value in found)))
        lines.append([called, *cells])
    return table(["all rounds, theirs and ours, on both structures", *VIEWS[:2]], lines)


def stack_visits(of):
    columns = [(view, structure) for view in VIEWS[:2] for structure in LEVELS]
    def cell(column, quantity, setting=STACK):
        row = in_stack(of, *column, quantity, setting)
        return ", ".join(number(row[side]) for side in ("theirs", "ours") if row[side]) if row else ""
    lines = [[called, *(cell(column, quantity, setting) for column in columns)] for called, quantity, setting in (
        ("internal nodes", "visits_internal", STACK), ("instances", "visits_instance", STACK), ("leaves", "visits_leaf", STACK),
        ("rays of 256 equal in visits of each kind", "rays_equal", STACK), ("the same with our boxes there", "rays_equal", STACK + ", our boxes"))]
    return table(["visits, theirs, ours", *(f"{view}, {structure}" for view, structure in columns)], lines).replace("|  |", "| |")


class Readings:
    def __init__(self, rows):
        self.at = {(row["machine"], row["reading"], row["view"], row["design"]): row for row in rows}
        self.names = list(dict.fromkeys(row["reading"] for row in rows if row["machine"] == "paper" and row["view"] == APART[0]))

    def ratio(self, reading, view, design, column, machine="paper"):
        base = self.at["paper", reading, view, "baseline"]
        return float(base[column]) / float(self.at[machine, reading, view, design][column])

    def six(self, reading, views):
        return [mean(self.ratio(reading, view, *ratio) for view in views) for ratio in RATIOS]


def readings(top):
    rows = page_data.rows(top, READINGS)
    return Readings(rows) if rows else None


def of_paper(top):
    """The paper's six ratios on the views that took no part in any choice, and in brackets on all five."""
    of = readings(top)
    if not of:
        return None
    paper = paper_figures()
    near = lambda six: sum(abs(own / theirs - 1) <= 0.1 for own, theirs in zip(six, paper))
    lines = [["the paper's text", *map(shown, paper), ""]]
    for reading in of.names:
        apart, every = of.six(reading, APART), of.six(reading, APART + FITTED)
        lines.append([f"`{reading[:-2]}`{reading[-2:]}" if "_" in reading else reading,
                      *(f"{shown(own)} ({shown(all_five)})" for own, all_five in zip(apart, every)),
                      f"{near(apart)} ({near(every)})"])
    head = ["reading", "sw", "hw", "grtx", "L2 accesses ÷", "node latency ÷", "node fetches ÷", f"within 10 %, of {len(PAPER)}"]
    return table(head, lines).replace("|  |", "| |")


def faults(top):
    if of := replays(top):
        yield from page_data.unsaid(top, PAGE, DATA, [*of_replays(of), *of_room(of), *of_busy(of), *of_stack(of)])
    if of := readings(top):
        yield from page_data.unsaid(top, PAGE, READINGS, of_readings(of))


def span(values, digits=1):
    values = list(values)
    return f"{min(values):.{digits}f} to {max(values):.{digits}f}"


def of_replays(of):
    ratios = {case: of.ratio(case) for case in of.cases}
    furthest = max(ratios, key=lambda case: abs(ratios[case] - 1))
    levels = {LEVELS[0]: "one level", LEVELS[1]: "two levels"}[furthest[1]]
    yield (f"take {span(ratios.values(), 3)} times Vulkan-Sim's cycles; furthest off is the {furthest[0]} on {levels} at {furthest[2]} × {furthest[2]}.")
    large = [100 * (ratio - 1) for case, ratio in ratios.items() if case[1:3] == (LEVELS[1], 64)]
    yield f"The two-level structure is then {span(large, 0)} % slower here"
    in_one = [100 * (of.ratio(case, "l1_misses", REPLAY) - 1) for case in of.of(REPLAY)]
    yield f"in one order they are within {max(map(abs, in_one)):.0f} %"
    room = ("room", LEVELS[0], 32, "no")
    yield f"{percent(of.ratio(room, 'l1_misses'))} on tri20 of the room at 32²"
    timed = [case for case in of.plain if of.cell("ours", case, "processor_seconds")]
    seconds = {case: of.theirs(case, "processor_seconds") / of.ours(case, "processor_seconds") for case in timed}
    ends = [end(seconds, key=seconds.get) for end in (min, max)]
    yield (f"{span(seconds.values(), 0)} times, " + ("both on two levels" if {case[1] for case in ends} == {LEVELS[1]} else "on either structure")
           + f" ({', '.join(case[0] for case in ends)})")
    case = ("room", LEVELS[1], 16, "yes")
    shipped, mended = (of.theirs(case, "processor_seconds", setting) for setting in ("as shipped", "mended, beside it"))
    yield f"it is {shipped / mended:.0f} times slower still, on the one view that was run so, with equal cycles: {shipped:.1f} s for {mended:.1f} mended"


def of_room(of):
    """What its stores and its early chunks are worth on the room."""
    case = ("room", LEVELS[1], 16, "no")
    listed = of.ours(case, "l1_misses", "with the list of blended Gaussians")
    yield f"misses {number(listed)} node sectors, without them {number(of.cell('ours', case, 'l1_misses'))}"
    yield f"{number(of.cell('theirs', case, 'hit_stores'))} stores turn over"
    one_level = [100 * (of.theirs(c, "dram_reads", NO_STORES) / of.ours(c, "dram_reads") - 1) for c in of.of(NO_STORES) if c[1] == LEVELS[0]]
    yield f"but for {max(one_level):.1f} % on tri20"
    others = [of.theirs(c, "dram_reads") / of.ours(c, "dram_reads") for c in of.plain if c[0] != "room"]
    yield f"up to {max(others):.1f} times ours"
    slower = [of.ratio(c, "cycles", NO_STORES) for c in of.of(NO_STORES) if c[1] == LEVELS[1]]
    yield f"are the {percent(min(slower))[:-2]} to {percent(max(slower))}."
    fewer = lambda sizes: [100 * (1 - 1 / of.ratio(c, "l1_sectors")) for c in of.plain if c[1] == LEVELS[1] and c[2] in sizes]
    yield f"theirs asks the L1 for {span(fewer((16, 32)), 0)} % fewer sectors on tlas-tri20 than ours, at 64² for {span(fewer((64,)), 0)} % fewer"
    asked = [(of.cell("theirs", case, quantity, ASKED), of.cell("ours", case, quantity, ASKED)) for quantity in ("cycles", "warp_latency")]
    off = [f"{abs(100 * (float(ours) / float(theirs) - 1)):.1f}" for theirs, ours in asked]
    yield (f"theirs takes {number(asked[0][0])} cycles and {number(asked[1][0])} a warp at 16² (ours {number(asked[0][1])} and {number(asked[1][1])}: "
           f"{off[0]} and {off[1]} % apart)")
    unsorted = [c for c in of.of(OTHER_ORDER) if c[1:3] == (LEVELS[1], 32)]
    yield f"at 32² cycles were {span((of.ratio(c, 'cycles', OTHER_ORDER) for c in unsorted), 3)} of theirs"
    yield f"(sectors within {max(abs(100 * (of.ratio(c, 'l1_misses') - 1)) for c in unsorted):.1f} %)"
    left = [100 * (of.ratio(c, "l1_misses", OTHER_ORDER) - 1) for c in unsorted]
    yield f"{-min(left):.0f} % fewer to {max(left):.0f} % more of them left the L1"
    counts = [abs(100 * (of.ratio(c, quantity, ASKED) - 1)) for c in of.of(ASKED) for quantity in ("warp_latency", "l1_sectors", "l1_misses", "dram_reads")]
    cycles = max(abs(100 * (of.ratio(c, "cycles", ASKED) - 1)) for c in of.of(ASKED))
    yield f"agree on the room within {cycles:.1f} % in cycles and {max(counts):.1f} % in each count"
    both = [("room", structure, 16, "yes") for structure in LEVELS]
    theirs, ours = ([float(of.cell(side, c, "cycles", ASKED)) for c in both] for side in ("theirs", "ours"))
    yield f"is then {theirs[0] / theirs[1]:.2f} theirs and {ours[0] / ours[1]:.2f} ours ({percent(ours[0] / ours[1] * theirs[1] / theirs[0])})"
    misses = [of.cell("theirs", ("room", structure, 16, "no"), "own_count_of_misses") for structure in reversed(LEVELS)]
    yield f"Its count of misses, {' and '.join(map(number, misses))} at 16²"


def of_busy(of):
    """How often the busiest SM sends, and what else could bind."""
    busy = lambda view, structure, pixels: [100 * of.ours(c, "busiest_sm_requests") / of.ours(c) for c in of.plain
                                            if view in (None, c[0]) and c[1:] == (structure, pixels, "yes")]
    both = [c for c in of.cases if of.cell("theirs", c, "busiest_sm_hit_stores")]
    yield f"are among theirs, {max(100 * of.theirs(c, 'busiest_sm_hit_stores') / of.theirs(c, 'busiest_sm_requests') for c in both):.0f} %."
    yield f"ours sends in {busy('object', LEVELS[1], 32)[0]:.1f} % of the cycles at 32² and in {busy('object', LEVELS[1], 64)[0]:.1f} % at 64²"
    yield f"At 16² it sends in {span(busy(None, LEVELS[1], 16), 0)} %"
    yield f"On tri20 at 64² it sends in {span(busy(None, LEVELS[0], 64), 0)} %"
    case = ("room", LEVELS[1], 64, "yes")
    changed = {key[4]: float(row["ours"]) / of.ours(case) for key, row in of.at.items() if key[:4] == case and "=" in key[4] and key[5] == "cycles"}
    port, merge, wait = (changed.pop(f"rt.memory.{key}") for key in ("sectors_per_cycle=2", "merge_in_flight=false", "descriptor_wait=1"))
    yield f"`sectors_per_cycle=2` {percent(port, 0)}, `merge_in_flight=false` {percent(merge, 0)}, `descriptor_wait=1` {percent(wait)}."
    yield f"are each within {max(abs(100 * (ratio - 1)) for ratio in changed.values()):.1f} %"
    case = ("room", LEVELS[1], 32, "yes")
    off = {quantity: percent(of.ratio(case, quantity, TWO_SMS)) for quantity in ("cycles", "warp_latency", "l1_sectors", "l1_misses", "busiest_sm_requests")}
    reads = {of.cell(side, case, "dram_reads", TWO_SMS) for side in ("theirs", "ours")}
    alike = sorted({off[quantity] for quantity in ("warp_latency", "l1_sectors", "l1_misses")})
    yield (f"theirs takes {number(of.cell('theirs', case, 'cycles', TWO_SMS))} cycles and ours {number(of.cell('ours', case, 'cycles', TWO_SMS))} "
           f"({off['cycles']}). A warp's time in the unit, requests and sectors that leave the L1 are {' or '.join(alike)}, "
           f"the busiest SM's requests {off['busiest_sm_requests']}, DRAM reads {'equal' if len(reads) == 1 else 'not equal'}.")
    one_level = [c for c in of.of(REPLAY) if c[1] == LEVELS[0]]
    yield f"ours is then {span((100 * (1 - of.ratio(c, 'cycles', REPLAY)) for c in one_level), 0)} % quicker"
    reads = [f"{of.theirs(c, 'dram_reads', REPLAY) / of.ours(c, 'dram_reads', REPLAY):.1f}" for c in one_level]
    yield f"Theirs has {', '.join(reads[:-1])} and {reads[-1]} times the DRAM reads"


def of_stack(of):
    """Of the program that ran through its whole stack."""
    more = {}
    for structure in LEVELS:
        rows = [in_stack(of, view, structure, f"visits_{kind}") for view in VIEWS[:2] for kind in ("internal", "instance", "leaf")]
        more[structure] = max(abs(100 * (float(row["theirs"]) / float(row["ours"]) - 1)) for row in rows if row)
    yield f"differs by at most {more[LEVELS[0]]:.2f} % on one level and {more[LEVELS[1]]:.1f} % on two"
    visits = lambda view, structure, kind: [float(in_stack(of, view, structure, f"visits_{kind}")[side]) for side in ("theirs", "ours")]
    instances = [100 * (theirs / ours - 1) for theirs, ours in (visits(view, LEVELS[1], "instance") for view in VIEWS[:2])]
    yield f"That makes {' and '.join(f'{value:.1f}' for value in instances)} % more visits of instances"
    internal = [theirs - ours for theirs, ours in (visits(view, LEVELS[0], "internal") for view in VIEWS[:2])]
    leaves = [ours - theirs for theirs, ours in (visits(view, LEVELS[0], "leaf") for view in VIEWS[:2])]
    yield f"{internal[0]:.0f} to {internal[1]:.0f} internal nodes more there, {leaves[0]:.0f} or {leaves[1]:.0f} leaves fewer"
    hits = lambda view, faces: float(in_stack(of, view, LEVELS[0], f"any_hits_{faces}")["theirs"])
    faces = [hits(view, "both_faces") / hits(view, "front") for view in VIEWS[:2]]
    yield f"{span(faces)} times as often"
    rounds = sum(float(in_stack(of, view, structure, "rounds")["ours"]) for view in VIEWS[:2] for structure in LEVELS)
    equal = {in_stack(of, view, structure, "rays_equal", STACK + ", our boxes")["theirs"] for view in VIEWS[:2] for structure in LEVELS}
    yield f"{'each' if equal == {'256'} else 'not each'} of the {number(rounds)} rounds visits as many nodes of each kind there as here"
    exact = in_stack(of, "room", LEVELS[1], "rays_equal", STACK + ", the exact box of the BLAS")["theirs"]
    yield f"makes {exact} of 256 rays of the room equal on two levels"
    room, thing = ([number(in_stack(of, view, LEVELS[1], f"visits_{kind}", STACK + ", tight bounds here")["ours"])
                    for kind in ("internal", "instance", "leaf")] for view in VIEWS[:2])
    yield (f"the room has {room[0]} visits of internal nodes, {room[1]} of instances and {room[2]} of leaves, the object {thing[0]}, "
           f"{thing[1]} and {thing[2]}.")


def of_readings(of):
    grtx = lambda reading: span((of.ratio(reading, view, "grtx", "cycles") for view in APART + FITTED), 2)
    yield f"(grtx by view: {grtx('today')} today, {grtx('all four')} with all four)"
    before, after = ([of.ratio(reading, "lacadiere", *ratio) for ratio in RATIOS] for reading in ("today", "oldest_warp_first"))
    yield (f"sw {after[0]:.2f} for {before[0]:.2f}, hw {after[1]:.2f} and {before[1]:.2f}, grtx {after[2]:.2f} for {before[2]:.2f}, L2 accesses "
           f"{after[3]:.2f} for {before[3]:.2f}, latency {after[4]:.2f} for {before[4]:.2f}, fetches {after[5]:.2f} for {before[5]:.2f}.")
    charged = lambda reading: [shown(mean(of.ratio(reading, view, design, "cycles", "paper-charged") for view in CHARGED)) for design in ("hw", "grtx")]
    yield f"({' and '.join(charged('all four'))}; today {' and '.join(charged('today'))}, on {CHARGED[0]}, {CHARGED[1]} and {CHARGED[2]})"
    six = of.six("all but box corners", CHARGED)
    yield (f"give grtx {six[4]:.2f} of the latency, {six[5]:.2f} of the fetches and {six[3]:.2f} of the L2 accesses, but {six[2]:.2f} of the speed, "
           f"and sw {six[0]:.2f}")


def made(function):
    return lambda top, _page: function(of) if (of := replays(top)) else None


MADE = {**{f"vulkan-{what}": made(function) for what, function in {
    "cases": cases, "goals": goals, "stores": stores, "habits": habits, "requests": requests, "orders": orders, "processor": processor,
    "hits": stack_hits, "visits": stack_visits}.items()}, "vulkan-paper": lambda top, _page: of_paper(top)}
