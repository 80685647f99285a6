# SPDX-License-Identifier: Apache-2.0
"""Tables of docs/results/silicon.md from silicon.csv and silicon-frames*.csv in docs/results/data and from data/measured/points.csv, and the
sentences of that page with figures of them; readme_tables.py puts the tables into the page, and checks both."""
import csv
import math
import os
import sys

import page_data
from evaluation_tables import mean, shown, table

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "bench"))
import silicon  # noqa: E402

PAGE = os.path.join("docs", "results", "silicon.md")
DATA = "silicon.csv"
POINTS = os.path.join("data", "measured", "points.csv")
FITTED = ("lacadiere", "taebak")
PRICE = 200  # call_per_lane of the page's machines
SCHEDULERS = 8  # four on each of two SMs
CHARTS = {"October 2025": "October 2025, degree 4", "August 2025": "August 2025, degree 2, other models", "third chart": "third chart, degree 2"}
ADA, RTX5090 = "RTX 6000 Ada", "RTX 5090"
# Rows of the fit: price of a lane, of a batch, cycles an instance.
FIT = ((0, 0, 4), (50, 0, 4), (100, 0, 4), (100, 150, 4), (150, 0, 4), (PRICE, 0, 4), (300, 0, 4))
# What each mechanism does: bounds of instances, price of a lane, cycles an instance.
MECHANISMS = (("neither: tight bounds, 7 cycles an instance", "tight", 0, 7), ("box corners alone", "box_corners", 0, 7),
              ("box corners, 4 cycles an instance", "box_corners", 0, 4), ("calls alone (tight, 7 cycles)", "tight", PRICE, 7),
              ("**all: `ada`**", "box_corners", PRICE, 4))


class Crops:
    """Crops that were simulated, and what their frames take on the card."""

    def __init__(self, top, rows, frames="silicon-frames.csv"):
        self.rows = rows
        self.points = os.path.join(top, POINTS)
        self.scale = silicon.scales(os.path.join(top, page_data.FOLDER, frames))

    def of(self, accel, **wanted):
        """{scene: row} of a structure; the price of the page's machines where none is named."""
        wanted = {"plan": "silicon", "machine": "ada", "kernel_degree": 4, "k": 18, "tracing": "multi", "call_per_lane": PRICE, "call_fixed": 0} | wanted
        if accel == "tri20":  # has no instances
            wanted |= {"instance_bounds": "tight", "transform_interval": ""}
        else:
            wanted = {"instance_bounds": "box_corners", "transform_interval": 4} | wanted
        return {row["scene"]: row for row in self.rows if row["accel"] == accel and all(row[name] == str(value) for name, value in wanted.items())}

    def cycles(self, row, more=0.0):
        """Of one SM a ray, without the tail of the crop; more: cycles of the crop that were not simulated."""
        return (float(row["cycles"]) + more) * float(row["occupancy"]) / int(row["entries"]) * int(row["sms"]) / (int(row["warps"]) * 32)

    def ours(self, **wanted):
        """What silicon.quantities compares, of both degrees and all structures."""
        return {(str(degree), str(k), accel): {scene: self.cycles(row) for scene, row in self.of(accel, kernel_degree=degree, k=k, **wanted).items()}
                for degree in (2, 4) for k in (16, 18) for accel in silicon.ABC}

    def compared(self, card, **wanted):
        return list(silicon.quantities(silicon.published(self.points, card), self.scale, self.ours(**wanted)))

    def frame(self, card, found, more=lambda _: 0.0):
        """Milliseconds of a frame of the card by scene, of crops of degree 4 from boxes; more: cycles of a crop that were not simulated."""
        chart = [line for line in silicon.published(self.points, card) if line["tracer.kernel_degree"] == "4" and line["design"] == "tlas-box"]
        ours = {("4", chart[0]["tracer.k"], "tlas-box"): {scene: self.cycles(row, more(row)) for scene, row in found.items()}}
        [(_, _, measured, times)] = silicon.quantities(chart, self.scale, ours)
        return measured, times


def crops(top, frames="silicon-frames.csv"):
    rows = page_data.rows(top, DATA)
    there = rows and all(os.path.exists(os.path.join(top, name)) for name in (POINTS, os.path.join(page_data.FOLDER, frames)))
    return Crops(top, rows, frames) if there else None


def means(found, scenes=None):
    return mean(value for scene, value in found.items() if scenes is None or scene in scenes)


def log_error(values):
    return silicon.log_error(list(values))


def fit(of):
    """Two scenes and October's chart by what a call costs: A / C, D / A, ms of A and their sum of squares in standard errors."""
    chart = [line for line in silicon.published(of.points, ADA) if "October" in line["source"]]

    def ours(lane, batch, interval):
        """A / C, D / A and ms of A by scene."""
        key = {"call_per_lane": lane, "call_fixed": batch}
        found = {accel: {scene: of.cycles(row) for scene, row in of.of(accel, transform_interval=interval, **key).items() if scene in FITTED}
                 for accel in silicon.ABC}
        names = {name: values for _, name, _, values in silicon.quantities(chart, of.scale, {("4", "18", accel): cycles for accel, cycles in found.items()})}
        return [names[name] for name in ("A / C", "D / A", "A, ms")]
    measured = {name: values for _, name, values, _ in silicon.quantities(chart, of.scale, {})}
    measured = [measured[name] for name in ("A / C", "D / A", "A, ms")]
    # Errors of ours are those at the price of the page for all rows, so that weights are the same.
    weights = [math.hypot(log_error(a.values()), log_error(b.values())) for a, b in zip(ours(PRICE, 0, 4), measured)]
    lines = [["chart", *cells(measured), ""]]
    squares = {}
    for key in (*FIT, (PRICE, 0, 2), (PRICE, 0, 7)):
        values = ours(*key)
        squares[key] = sum((math.log(means(value) / means(other)) / weight) ** 2 for value, other, weight in zip(values, measured, weights))
        lane, batch, interval = key
        name = (str(lane) if key != (PRICE, 0, 4) else f"**{lane}**") + (f", `call_fixed` {batch}" if batch else "") + (f", {interval} cycles an instance" if interval != 4 else "")
        lines.append([name, *cells(values), f"**{squares[key]:.1f}**" if key == (PRICE, 0, 4) else f"{squares[key]:.1f}"])
    return table(["`call_per_lane`", "A / C", "D / A", "A, ms a frame", "χ²"], lines).replace("|  |", "| |")


def cells(values):
    return [f"{means(value):.{digits}f}" for value, digits in zip(values, (2, 2, 1))]


def mechanisms(of):
    """All five scenes, ms of crops."""
    chart = [line for line in silicon.published(of.points, ADA) if "October" in line["source"]]
    names = ("A / C", "D / A", "D / C", "A, ms", "C, ms", "D, ms")

    def line(called, values, bold):
        cell = [f"{means(values[name]):.2f}" for name in names[:3]] + [", ".join(f"{means(values[name]):.1f}" for name in names[3:])]
        return [called, *(f"**{text}**" if bold else text for text in cell)]
    lines = [line("chart", {name: values for _, name, values, _ in silicon.quantities(chart, {}, {})}, False)]
    for called, bounds, price, interval in MECHANISMS:
        ours = {("4", "18", accel): {scene: of.cycles(row) for scene, row in of.of(accel, instance_bounds=bounds, call_per_lane=price, transform_interval=interval).items()}
                for accel in silicon.ABC}
        lines.append(line(called, {name: values for _, name, _, values in silicon.quantities(chart, {}, ours)}, "**" in called))
    return table(["machine", "A / C", "D / A", "D / C", "A, C, D in ms"], lines)


def spread(values, name):
    values, digits = list(values), 1 if name.endswith("ms") else 2
    return f"{mean(values):.{digits}f} ({min(values):.{digits}f} to {max(values):.{digits}f})", f"{mean(values):.{digits}f}"


def held(name, measured, tested):
    """Cells: ours over the measured, and how many standard errors that is."""
    ratio = means(tested) / means(measured)
    return ratio, math.log(ratio) / math.hypot(log_error(measured.values()), log_error(tested.values()))


def signed(errors):
    return f"{errors:+.1f}".replace("-", "−")


def rows_of_charts(of):
    """(chart, quantity, measured, fitted, tested) of the RTX 6000 Ada's charts."""
    for (source, _, _), name, measured, ours in of.compared(ADA):
        yield (next(called for key, called in CHARTS.items() if key in source), name, measured, {scene: ours[scene] for scene in ours if scene in FITTED},
               {scene: ours[scene] for scene in ours if scene not in FITTED})


def rivals(of):
    """Shaders over icosahedra, and lists over rounds: {scene: ratio} of each."""
    boxes = of.of("tlas-box", kernel_degree=2, k=16)
    over = lambda found: {scene: float(boxes[scene]["cycles"]) / float(row["cycles"]) for scene, row in found.items()}
    return over(of.of("tri20", kernel_degree=2)), over(of.of("tlas-box", kernel_degree=2, k=16, tracing="list"))


def of_cards(of):
    """Milliseconds and ratios of the charts beside ours."""
    lines, last = [], ""
    for chart, name, measured, fitted, tested in rows_of_charts(of):
        ratio, errors = held(name, measured, tested)
        whole, middle = spread(tested.values(), name)
        lines.append([chart if chart != last else "", name, spread(measured.values(), name)[0], spread(fitted.values(), name)[1],
                      whole.replace(middle, f"**{middle}**", 1), f"{ratio:.2f}", signed(errors)])
        last = chart
    [(_, name, measured, ours)] = of.compared(RTX5090, machine="blackwell")
    ratio, errors = held(name, measured, ours)
    whole, middle = spread(ours.values(), name)
    lines.append(["RTX 5090, 3dgrut, 16 hits, degree 4 (`blackwell`)", name, spread(measured.values(), name)[0], "",
                  whole.replace(middle, f"**{middle}**", 1) + ", all five", f"{ratio:.2f}", signed(errors)])
    shaders, lists = rivals(of)
    for called, quantity, published, after, ours in (
            ("RTX 3090, GauTracer", "shaders ÷ icosahedra", over(of, "RTX 3090"), None, shaders),
            ("RTX 4090, GRay ÷ 3DGRT, both from boxes", "list ÷ rounds", over(of, "RTX 4090"), 1.25, lists)):
        spare = f"; {after} after [PR 268](https://github.com/nv-tlabs/3dgrut/pull/268)" if after else ""
        values = [published] + ([after] if after else [])
        lines.append([called, quantity, f"{published:.2f}{spare}", "", f"**{means(ours):.2f}** ± {100 * log_error(ours.values()):.0f} %, all five",
                      "; ".join(f"{means(ours) / value:.2f}" for value in values),
                      "; ".join(signed(math.log(means(ours) / value) / log_error(ours.values())) for value in values)])
    return table(["chart", "", "measured", "fitted, 2", "tested, 3", "tested ÷ measured", "standard errors"], lines).replace("|  |", "| |").replace("|  |", "| |")


def over(of, card):
    """The speed-up that is published of a card."""
    with open(of.points, encoding="utf-8") as file:
        return next(float(line["value"]) for line in csv.DictReader(line for line in file if not line.startswith("#")) if line["card"] == card and line["over"])


def priced(row, price, own=0.0):
    """Cycles more of a crop at another price of a lane, and with so much of an own call for the any-hit shader of a box's hit."""
    return (float(row["any_hit_lanes"]) * (price - PRICE) + own * float(row["any_hit_calls"]) * PRICE) / SCHEDULERS


def met(value, wanted):
    """The price at which a rising or falling function has the wanted value."""
    low, high = 0.0, 2000.0
    rising = value(high) > value(low)
    while high - low > 0.01:
        middle = (low + high) / 2
        low, high = (low, middle) if (value(middle) > wanted) == rising else (middle, high)
    return low


def frame_at(of, card, machine, k):
    """(mean that is measured, our mean at a price and with an own call) of boxes of degree 4."""
    found = of.of("tlas-box", machine=machine, k=k)
    measured = means(of.frame(card, found)[0])
    return measured, lambda price, own=0.0: means(of.frame(card, found, lambda row: priced(row, price, own))[1])


def lists_at(of):
    """Lists over rounds, where a lane of the list has another price."""
    boxes, lists = (of.of("tlas-box", kernel_degree=2, k=16, **more) for more in ({}, {"tracing": "list"}))
    return lambda price: {scene: float(boxes[scene]["cycles"]) / (float(row["cycles"]) + priced(row, price)) for scene, row in lists.items()}


def prices(of):
    """What other prices of a call would do."""
    lines = []
    for card, machine, k, half in ((ADA, "ada", 18, True), (RTX5090, "blackwell", 16, False)):
        measured, ours = frame_at(of, card, machine, k)
        lines.append([f"{card}, D, degree 4, ms", f"{measured:.1f}", f"{ours(PRICE):.1f}", f"{met(ours, measured):.0f}",
                      f"{ours(PRICE, 1):.1f}" + (f"; half of it: {ours(PRICE, 0.5):.1f}" if half else "")])
    published, at = over(of, "RTX 4090"), lists_at(of)
    lines.append(["RTX 4090, list over rounds (GRay ÷ 3DGRT)", f"{published:.2f}", f"{means(at(PRICE)):.2f}",
                  f"{met(lambda price: means(at(price)), published):.0f} for the list, {PRICE} for rounds", ""])
    return table(["figure", "measured", f"at {PRICE}", "met with a price of", "with an own call for the any-hit shader of a box's hit"],
                 lines).replace("|  |", "| |")


def faults(top):
    if of := crops(top):
        yield from page_data.unsaid(top, PAGE, DATA, [*of_tested(of), *of_prices(of), *of_paper(of)])
        yield from page_data.unsaid(top, "README.md", DATA, [f"frames are met within {worst(of):.2f} times"])
    if of := crops(top, "silicon-frames-show.csv"):
        yield from page_data.unsaid(top, PAGE, DATA, of_show(of))


def worst(of):
    """The furthest mean of a chart's milliseconds, on the tested scenes."""
    times = [means(tested) / means(measured) for _, name, measured, _, tested in rows_of_charts(of) if name.endswith("ms")]
    return max(max(ratio, 1 / ratio) for ratio in times)


def of_tested(of):
    """The head of the page, and what it says of ratios."""
    rows = list(rows_of_charts(of))
    [(_, _, measured, ours)] = of.compared(RTX5090, machine="blackwell")
    yield f"milliseconds are within {worst(of):.2f} times of an RTX 6000 Ada's in each mean"
    yield f"an RTX 5090's frame takes {means(ours) / means(measured):.2f} of its time here."
    ratios = [(measured, tested, held(name, measured, tested)[1]) for _, name, measured, _, tested in rows if not name.endswith("ms")]
    count = {1: "one", 2: "two", 3: "three", 4: "four", 5: "five", 6: "six"}
    short = [f"{means(tested):.2f} for {means(measured):.2f}" for measured, tested, errors in ratios if abs(errors) > 2]
    yield (f"Of {count[len(ratios)]} ratios of structures {count[len(ratios) - len(short)]} are within two standard errors on tested scenes; "
           f"{count[len(short)]} fall short, {' and '.join(short)}.")
    _, lists = rivals(of)
    yield f"A list over rounds has {means(lists):.2f} for a measured {over(of, 'RTX 4090'):.2f}."
    slower = [value for (source, _, _), name, _, ours in of.compared(ADA) if name == "D / A" for value in ours.values()]
    yield f"D is slower than A on every scene of both degrees, as on silicon: {min(slower):.2f} to {max(slower):.2f} times."


def of_prices(of):
    """What binds boxes, and what is missing on each card."""
    shares = []
    for key in ({}, {"kernel_degree": 2}, {"kernel_degree": 2, "k": 16}, {"kernel_degree": 2, "k": 16, "tracing": "list"}, {"machine": "blackwell", "k": 16}):
        shares += [100 * PRICE * float(row["any_hit_lanes"]) / SCHEDULERS / float(row["cycles"]) for row in of.of("tlas-box", **key).values()]
    yield f"is {min(shares):.0f} to {max(shares):.0f} % of the cycles on all five scenes"
    at = lists_at(of)
    price = met(lambda value: means(at(value)), over(of, "RTX 4090"))
    then = at(price)
    yield f"If its calls cost {price:.0f}, that is {(PRICE - price) / 32:.1f} slots less for each of 32 words"
    yield f"gains nothing on wang_sha ({then['wang_sha']:.2f}) and loses on hon_sui_sen ({then['hon_sui_sen']:.2f})"
    measured, ours = frame_at(of, RTX5090, "blackwell", 16)
    of_ada, ada = frame_at(of, ADA, "ada", 18)
    yield f"a factor of {measured / ours(PRICE):.2f} is missing"
    lacks = of_ada / ada(PRICE)
    yield f"{lacks:.2f} is what D lacks on the {ADA}, too; {measured / ours(PRICE) / lacks:.2f} is left."
    yield f"An own call makes {ours(PRICE, 1):.1f} ms of our {ours(PRICE):.1f}"
    yield f"on the {ADA} an own call is {ada(PRICE, 1) / of_ada:.2f} times too much"


def of_paper(of):
    """The paper's card: what a shared structure is worth."""
    said = []
    for machine in ("blackwell", "blackwell-whole"):
        key = {"plan": "128 lines", "machine": machine, "kernel_degree": 2, "k": 8}
        base, shared = of.of("tri20", **key), of.of("tlas-tri20", **key)
        gains = [of.cycles(base[scene]) / of.cycles(shared[scene]) for scene in base]
        said.append(f"{mean(gains):.2f} ({min(gains):.2f} to {max(gains):.2f}")
    yield f"sharing the BLAS is worth {said[0]} by view) with a share of the L2, and {said[1]}) with the whole L2"


def of_show(of):
    """Views of role show."""
    chart = [line for line in silicon.published(of.points, ADA) if "October" in line["source"]]
    found = {name: (measured, ours) for _, name, measured, ours in silicon.quantities(chart, of.scale, of.ours(plan="silicon_show"))}
    times = [found[f"{letter}, ms"] for letter in "ACD"]
    text = [f"{means(ours):.1f} ({min(ours.values()):.1f} to {max(ours.values()):.1f})" for _, ours in times]
    over_chart = [f"{means(ours) / means(measured):.2f}" for measured, ours in times]
    yield f"A takes {text[0].replace(' (', ' ms (', 1)}, C {text[1]}, D {text[2]}: {over_chart[0]}, {over_chart[1]} and {over_chart[2]} of October's chart."
    pair = lambda name: f"{means(found[name][1]):.2f} for {means(found[name][0]):.2f}"
    off = [held(name, *found[name])[1] for name in ("A / C", "D / C")]
    yield f"D / A is {pair('D / A')}. A / C is {pair('A / C')} and D / C {pair('D / C')}, {-off[0]:.1f} and {-off[1]:.1f} standard errors too low."


def made(function):
    return lambda top, _page: function(of) if (of := crops(top)) else None


MADE = {"silicon-fit": made(fit), "silicon-mechanisms": made(mechanisms), "silicon-cards": made(of_cards), "silicon-prices": made(prices)}
