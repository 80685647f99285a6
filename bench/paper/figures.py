# SPDX-License-Identifier: Apache-2.0
"""Pictures as SVG, 480 wide, so that letters stay readable on a screen of 390 pixels; colours for light and dark pages."""
import math
from xml.sax.saxutils import escape

WIDTH = 480
COLOURS = [  # light, dark: of equal lightness, told apart without red and green
    ("#6b7280", "#9ca3af"), ("#0072b2", "#56b4e9"), ("#c2570c", "#f0a04b"), ("#00795c", "#3fc49c"), ("#8a3f9e", "#cf8fe0"),
    ("#7a6a00", "#d9c645")]
DASHES = ["", "6 3", "2 3", "8 3 2 3", "4 2", "1 3"]


OF_NAME = {"baseline": 0, "sw": 1, "hw": 2, "grtx": 3, "tri80": 4, "tlas-tri20": 1, "tlas-tri80": 2, "ellipsoid": 3,
           "tlas-sphere": 5}  # a design has one colour in all pictures


def colours(names):
    """{name: number of its colour}; names that are no designs take them in order."""
    return {name: OF_NAME.get(name, index) for index, name in enumerate(names)}


def number(value):
    """Three significant digits, never as a power of ten."""
    if value == 0 or not math.isfinite(value):
        return "0" if value == 0 else "–"
    digits = max(0, 2 - math.floor(math.log10(abs(value))))
    return f"{value:,.{min(digits, 4)}f}"


class Canvas:
    def __init__(self, title):
        self.title, self.parts = title, []

    def text(self, x, y, what, anchor="start", size=13, kind="ink", weight="normal"):
        self.parts.append(f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" font-size="{size}" '
                          f'font-weight="{weight}" class="{kind}">{escape(str(what))}</text>')

    def line(self, x1, y1, x2, y2, kind="grid", dash="", width=1):
        dashed = f' stroke-dasharray="{dash}"' if dash else ""
        self.parts.append(f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" class="{kind}" '
                          f'stroke-width="{width}"{dashed}/>')

    def bar(self, x, y, width, height, colour):
        self.parts.append(f'<rect x="{x:.1f}" y="{y:.1f}" width="{max(0.5, width):.1f}" height="{height:.1f}" '
                          f'class="f{colour % len(COLOURS)}"/>')

    def path(self, points, colour):
        self.parts.append(f'<polyline points="{" ".join(f"{x:.1f},{y:.1f}" for x, y in points)}" fill="none" '
                          f'class="s{colour % len(COLOURS)}" stroke-width="2" '
                          f'stroke-dasharray="{DASHES[colour % len(DASHES)]}"/>')
        for x, y in points:
            self.parts.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3" class="f{colour % len(COLOURS)}"/>')

    def legend(self, names, y, marked, first=0):
        """Returns where it ends. marked: whether the paper's mark is explained, too."""
        x = 12
        for index, name in enumerate([*names, *(["the paper"] if marked else [])]):
            width = 30 + 7.2 * len(name)
            if x + width > WIDTH - 8:
                x, y = 12, y + 20
            if index < len(names):
                self.bar(x, y - 9, 12, 10, first + colours(names)[name])
            else:
                self.line(x + 6, y - 11, x + 6, y + 3, "mark", width=3)
            self.text(x + 18, y, name, size=12)
            x += width
        return y + 12

    def svg(self, height):
        light = "".join(f".f{i}{{fill:{c}}}.s{i}{{stroke:{c}}}" for i, (c, _) in enumerate(COLOURS))
        dark = "".join(f".f{i}{{fill:{c}}}.s{i}{{stroke:{c}}}" for i, (_, c) in enumerate(COLOURS))
        style = (".halo{paint-order:stroke;stroke:#ffffff;stroke-width:4px}.paper{fill:#ffffff}.ink{fill:#1f2328}.soft{fill:#57606a}.grid{stroke:#d0d7de}.axis{stroke:#57606a}"
                 ".mark{stroke:#1f2328}" + light + "@media (prefers-color-scheme:dark){.halo{stroke:#0d1117}.paper{fill:#0d1117}"
                 ".ink{fill:#e6edf3}.soft{fill:#9198a1}.grid{stroke:#30363d}.axis{stroke:#9198a1}.mark{stroke:#ffffff}" +
                 dark + "}")
        return (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height:.0f}" width="{WIDTH}" '
                f'height="{height:.0f}" font-family="Helvetica, Arial, sans-serif" role="img">'
                f"<title>{escape(self.title)}</title><style>{style}</style>"
                f'<rect class="paper" width="100%" height="100%"/>\n' + "\n".join(self.parts) + "\n</svg>\n")


def wrapped(text, letters):
    lines = [""]
    for word in text.split():
        if len(lines[-1]) + len(word) + 1 > letters and lines[-1]:
            lines.append("")
        lines[-1] = (lines[-1] + " " + word).strip()
    return lines


def heading(canvas, title):
    y = 22
    for line in wrapped(title, 56):
        canvas.text(12, y, line, size=14, weight="bold")
        y += 18
    return y


def bars(title, groups, series, marks=None, unit="×", base=0.0):
    """Horizontal bars. groups: [(name, {series: value or None})]; marks: {series: the paper's value}, a line across its
    bars; base: a value at which a line stands (1 for ratios)."""
    marks = marks or {}
    canvas = Canvas(title)
    y = canvas.legend(series, heading(canvas, title) + 6, bool(marks)) + 10
    left, right = 16, WIDTH - 64
    top = max([v for _, row in groups for v in row.values() if v is not None] + list(marks.values()) + [base]) or 1.0
    scale = (right - left) / top
    height = 15
    labels = []
    for name, row in groups:
        canvas.text(left, y + 10, name, size=13, weight="bold")
        y += 16
        start = y
        for one in series:
            value = row.get(one)
            if value is None:
                continue
            canvas.bar(left, y, value * scale, height - 3, colours(series)[one])
            end = value * scale
            if one in marks:
                at = left + marks[one] * scale
                canvas.line(at, y - 2, at, y + height - 1, "mark", width=2.5)
                if abs(marks[one] * scale - end) < 40:
                    end = max(end, marks[one] * scale)
            labels.append((left + end + 5, y + 10, number(value) + (unit if unit == "×" else f" {unit}".rstrip())))
            y += height
        canvas.line(left, start - 2, left, y, "axis")
        if base:
            canvas.line(left + base * scale, start - 2, left + base * scale, y, "axis", dash="3 3")
        y += 10
    for x, at, text in labels:
        canvas.text(x, at, text, size=12, kind="ink halo")
    return canvas.svg(y + 4)


def lines(title, xs, series, x_name, y_name, marks=None):
    """Lines over evenly spaced places. xs: their names; series: {name: [value a place]}; marks: {name: index}: a line at a
    place."""
    canvas = Canvas(title)
    y = canvas.legend(list(series), heading(canvas, title) + 6, False) + 24
    left, right, height = 52, WIDTH - 20, 200
    values = [v for row in series.values() for v in row]
    top, low = max(values) * 1.05, 0.0
    step = 10 ** math.floor(math.log10(top))
    step = next(step * f for f in (0.1, 0.2, 0.5, 1, 2) if top / (step * f) <= 6)
    place = lambda i: left + 20 + (right - left - 40) * (i / max(1, len(xs) - 1))
    at = lambda v: y + height - (v - low) / (top - low) * height
    canvas.text(12, y - 10, y_name, size=12, kind="soft")
    tick = 0.0
    while tick <= top:
        canvas.line(left, at(tick), right, at(tick))
        canvas.text(left - 6, at(tick) + 4, number(tick), anchor="end", size=12, kind="soft")
        tick += step
    for index, name in enumerate(xs):
        canvas.text(place(index), y + height + 18, name, anchor="middle", size=12)
    canvas.text((left + right) / 2, y + height + 38, x_name, anchor="middle", size=12, kind="soft")
    for name, row in series.items():
        canvas.path([(place(i), at(v)) for i, v in enumerate(row)], colours(series)[name])
    for name, index in (marks or {}).items():
        canvas.line(place(index), y, place(index), y + height, "mark", dash="2 4")
        canvas.text(place(index) + 5, y + height - 6, name, size=12)
    return canvas.svg(y + height + 50)


def stacks(title, groups, series):
    """Horizontal bars of shares that add up to 1. groups: [(name, {series: share})]."""
    canvas = Canvas(title)
    y = canvas.legend(series, heading(canvas, title) + 6, False, first=1) + 10
    left, width = 16, WIDTH - 32
    for name, row in groups:
        canvas.text(left, y + 10, name, size=13, weight="bold")
        canvas.text(WIDTH - 16, y + 10, ", ".join(f"{100 * row[s]:.1f} %" for s in series), anchor="end", size=12, kind="soft")
        y += 16
        x = left
        for index, one in enumerate(series):
            if row[one] > 0.0005:
                canvas.bar(x, y, row[one] * width, 14, index + 1)
            x += row[one] * width
        y += 26
    return canvas.svg(y)
