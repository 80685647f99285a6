# SPDX-License-Identifier: Apache-2.0
"""Plots with matplotlib. Each takes an optional ``ax`` (else a new figure's) and gives the axes it drew on."""
from collections.abc import Mapping, Sequence

try:
    import matplotlib.pyplot as plt
except ModuleNotFoundError as missing:
    raise ModuleNotFoundError(f"grtx_tlm.plots needs {missing.name}: pip install matplotlib, or apt install python3-matplotlib",
                              name=missing.name) from None
import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from .errors import unknown
from .frames import DESIGNS, Results, coordinates, speedup

Reference = Mapping[str, float] | pd.Series

#: Colours of the designs, which people with red-green blindness can tell apart (Okabe and Ito): those of the report's pages
#: (report/page/web/report.css).
COLOURS = {"baseline": "#999999", "sw": "#56B4E9", "hw": "#E69F00", "grtx": "#009E73", "gautracer": "#CC79A7", "walk": "#D55E00"}
STALL = "gpu.rt.stall."


def _axes(ax: Axes | None) -> Axes:
    return ax if ax is not None else plt.subplots(constrained_layout=True)[1]


def plot_speedup(speedups: pd.DataFrame | pd.Series, reference: Reference | None = None, ax: Axes | None = None,
                 over: str = "the baseline") -> Axes:
    """Bars of the designs' speed-ups, as in the paper's main figure.

    ``speedups``: frame of one row per scene, one column per design (no unit), or the series of one scene. ``over``: whose cycles
    they are relative to.
    ``reference``: by design, drawn as a line over each bar (say the paper's means). Raises ValueError if empty.
    """
    frame = speedups.to_frame().T if speedups.ndim == 1 else speedups
    if frame.empty:
        raise ValueError("plot_speedup: there is no scene")
    ax, width = _axes(ax), 0.8 / frame.shape[1]
    places = np.arange(len(frame))
    for i, design in enumerate(frame.columns):
        left = places + (i - (frame.shape[1] - 1) / 2) * width
        bars = ax.bar(left, frame[design], width, label=design, color=COLOURS.get(design))
        ax.bar_label(bars, fmt="%.2f", fontsize=8)
        if reference is not None and design in reference:
            ax.hlines([reference[design]] * len(left), left - width / 2, left + width / 2, colors="black",
                      label=None if i else "reference")
    ax.set_xticks(places, [str(name) for name in frame.index])
    ax.set_ylabel(f"speed-up over {over}")
    ax.legend()
    return ax


def _need(what: str, frame: pd.DataFrame, *columns: str) -> None:
    for name in columns:
        if name not in frame:
            raise ValueError(f"{what}: {unknown(name, frame.columns)}")


def _of_the_plan(frame: pd.DataFrame) -> pd.DataFrame:
    return frame[~frame["earlier_plan"]] if "earlier_plan" in frame else frame


def pareto_front(frame: pd.DataFrame, x: str, y: str) -> pd.DataFrame:
    """Rows of ``frame`` than which no other is smaller in both columns; ascending in ``x``. Rows with NaN, and points of an
    earlier plan, are left out."""
    _need("pareto_front", frame, x, y)
    ordered = _of_the_plan(frame).dropna(subset=[x, y]).sort_values([x, y])
    best = ordered[y].cummin().shift()
    return ordered[~(ordered[y] >= best)]


def plot_pareto(sweep: pd.DataFrame, x: str = "cost.mm2", y: str = "gpu.time_us", ax: Axes | None = None,
                label: str | Sequence[str] = (), limit: float | None = None) -> Axes:
    """Points of a sweep (``read_sweep``) and their front, both axes the smaller the better; without those of an earlier plan.
    Units: ``sweep.attrs``. ``label``: columns whose values name the points of the front. ``limit``: most of ``x``, drawn as a
    line."""
    names = [label] if isinstance(label, str) else list(label)
    _need("plot_pareto", sweep, x, y, *names)
    ax, front = _axes(ax), pareto_front(sweep, x, y)
    for design, points in _of_the_plan(sweep).groupby("design"):
        ax.scatter(points[x], points[y], s=18, label=design, color=COLOURS.get(design))
    ax.step(front[x], front[y], where="post", color="black", linewidth=1, label="front")
    for _, point in front.iterrows() if names else ():
        ax.annotate(", ".join(str(point[name]) for name in names), (point[x], point[y]), xytext=(3, 3), textcoords="offset points",
                    fontsize=8)
    if limit is not None:
        ax.axvline(limit, color="red", linestyle="--", linewidth=1, label=f"at most {limit:g}")
    units = sweep.attrs.get("units", {})
    ax.set_xlabel(f"{x} ({units[x]})" if units.get(x) else x)
    ax.set_ylabel(f"{y} ({units[y]})" if units.get(y) else y)
    ax.legend()
    return ax


def plot_over(sweep: pd.DataFrame, x: str, reference: Mapping[str, object], value: str = "gpu.cycles", ax: Axes | None = None) -> Axes:
    """Lines of speed-up (``grtx_tlm.speedup``) over any coordinate of a sweep: one for each design and each combination of what
    else was varied."""
    _need("plot_over", sweep, x, value)
    ax, rows = _axes(ax), _of_the_plan(sweep)
    others = [name for name in coordinates(rows) if name not in (x, "design") and rows[name].nunique(dropna=False) > 1]
    rows = rows.assign(speedup=speedup(sweep, reference, value)).sort_values(x)
    for design, own in rows.groupby("design"):
        for _, points in own.groupby([*others, "design"], dropna=False) if others else [((), own)]:
            text = ", ".join([design] + [f"{name} = {points[name].iloc[0]}" for name in others])
            ax.plot(points[x], points["speedup"], marker="o", label=text, color=None if others else COLOURS.get(design))
    ax.set_xlabel(x)
    ax.set_ylabel("speed-up over " + ", ".join(f"{name} = {wanted}" for name, wanted in reference.items()))
    ax.legend()
    return ax


def stall_shares(statistics: pd.DataFrame) -> pd.DataFrame:
    """Share of each reason in the RT units' stall cycles (0 to 1), rows as reasons, columns as designs.

    ``statistics``: ``Results.statistics``, or the frame of ``read_statistics`` (one column, ``run``).
    """
    frame = statistics[["value"]].set_axis(["run"], axis=1) if "unit" in statistics else statistics
    stalls = frame[frame.index.str.startswith(STALL)]
    if stalls.empty:
        raise ValueError(f"stall_shares: there is no statistic {STALL}*")
    stalls = stalls.set_axis(stalls.index.str[len(STALL):], axis=0).fillna(0)
    return stalls / stalls.sum().replace(0, 1)


def plot_stalls(statistics: pd.DataFrame, ax: Axes | None = None) -> Axes:
    """Stacked bars: why RT units issued nothing, as shares (``stall_shares``), a bar a design."""
    shares, ax = stall_shares(statistics), _axes(ax)
    bottom = np.zeros(shares.shape[1])
    for reason, row in shares.iterrows():
        ax.bar([str(name) for name in shares.columns], row, bottom=bottom, label=reason)
        bottom += row.to_numpy()
    ax.set_ylabel("share of stall cycles")
    ax.legend(loc="center left", bbox_to_anchor=(1, 0.5))
    return ax


def plot_error_against_time(frame: pd.DataFrame, time: str, error: str, label: str | None = None,
                            ax: Axes | None = None) -> Axes:
    """Error over time, both axes logarithmic: a point a row of ``frame``, columns ``time`` and ``error``, one colour for each
    value of the column ``label``. Rows whose error or time is not above 0 are left out, as a logarithm has no place for them.
    """
    _need("plot_error_against_time", frame, time, error, *([label] if label else []))
    ax = _axes(ax)
    shown = frame[(frame[time] > 0) & (frame[error] > 0)]
    for name, rows in shown.groupby(label) if label else [(None, shown)]:
        ax.scatter(rows[time], rows[error], s=18, label=name, color=COLOURS.get(name) if label else None)
    ax.set(xscale="log", yscale="log", xlabel=time, ylabel=error)
    if label:
        ax.legend()
    return ax


def main_figure(results: Mapping[str, Results], reference: Reference | None = None, ax: Axes | None = None) -> Axes:
    """The paper's main figure from ``{scene: Results}``: speed-ups of all designs other than the one that they are over, which
    must be the same in all results. Raises ValueError."""
    over = list(dict.fromkeys(one.speedup_over for one in results.values()))
    if len(over) != 1:
        raise ValueError("main_figure: speed-ups must be over one design, not over " + (" and ".join(over) or "none"))
    speedups = pd.DataFrame({scene: one.speedup for scene, one in results.items()}).T.drop(columns=over)
    order = [d for d in DESIGNS if d in speedups] + [d for d in speedups if d not in DESIGNS]
    if not order:
        raise ValueError(f"main_figure: there is no design but {over[0]}")
    return plot_speedup(speedups[order], reference, ax, "the baseline" if over == ["baseline"] else over[0])
