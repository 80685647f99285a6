# SPDX-License-Identifier: Apache-2.0
"""Runs the program `grtx` and gives what it measured as frames."""
import itertools
import os
import tempfile
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, Literal

import pandas as pd

from . import program as grtx
from .errors import StatisticsError, StrPath, unknown
from .frames import Results, named, read_results, statistics_document, statistics_frame, table

Mode = Literal["cycle", "windows"]
Settings = Mapping[str, Any]


def _simulated(trace: StrPath, settings: Settings | None, options: Mapping[str, Any],
               program: StrPath | None) -> dict[str, Any]:
    """The statistics file of a run."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "stats.json")
        grtx.call("sim", grtx.file(trace), "--stats", path, *grtx.settings(settings), *grtx.options(options), program=program)
        return statistics_document(path)


def _given(parameters: Mapping[str, Any], *others: str) -> dict[str, Any]:
    """The options among a call's parameters that it gave."""
    return {name: value for name, value in parameters.items()
            if name not in others and value is not None and value is not False}


def simulate(trace: StrPath, settings: Settings | None = None, *, machine: StrPath | None = None,
             config: StrPath | None = None, design: str | None = None, mode: Mode | None = None,
             target_error: str | None = None, share: float | None = None, seed: int | None = None,
             warm: StrPath | None = None, warm_state: StrPath | None = None, save_state: StrPath | None = None,
             strict: bool = False, vcd: StrPath | None = None, vcd_scope: str | None = None,
             vcd_window: str | None = None, vcd_level: str | None = None, timeline: StrPath | None = None,
             timeline_window: str | None = None, heatmap: str | Sequence[str] | None = None,
             watchdog: int | None = None, construction_order: int | None = None, no_idle_skip: bool = False,
             latency: bool = False, program: StrPath | None = None) -> pd.DataFrame:
    """``grtx sim``: the statistics of one run, as read_statistics() gives them.

    ``settings``: {key: value} of the configuration. The others are the command's options, with _ for -; None takes the
    program's default. ``design``: the named design that the trace is of, whose keys are set. over_time(frame) has the run's course. Raises ProgramError.
    """
    options = _given(locals(), "trace", "settings", "program")
    return statistics_frame(_simulated(trace, settings, options, program), os.fspath(trace))


def run(scene: StrPath, cameras: StrPath, settings: Settings | None = None, *,
        output: StrPath | None = None, designs: str | Sequence[str] | None = None,
        machine: StrPath | Sequence[StrPath] | None = None,
        config: StrPath | None = None, mode: Mode | None = None, target_error: str | None = None,
        share: float | None = None, seed: int | None = None, jobs: int | None = None, threads: int | None = None,
        flatten: bool = False, latency: bool = False, view: int | None = None, views: str | None = None, width: int | None = None,
        height: int | None = None, fov_scale: float | None = None, k: int | None = None,
        checkpoint_capacity: int | None = None, checkpoint_bins: int | None = None, below_instance: str | None = None,
        checkpoint_order: str | None = None, ert: float | None = None, ert_check: str | None = None,
        sort_key: str | None = None, resume: str | None = None, kernel_radius: str | None = None,
        kernel_degree: int | None = None, child_order: str | None = None, pop_test: str | None = None,
        any_hit: str | None = None, ahead: int | None = None, tmax_update: str | None = None,
        opacity_bound: str | None = None, replay_tmax: str | None = None, inside: str | None = None,
        sh_dir: str | None = None, colour: str | None = None,
        instance_bounds: str | None = None, layout: str | None = None, bvh_width: int | None = None,
        mapping: str | None = None, warp_size: int | None = None, secondary: str | None = None,
        glass: Sequence[float] | None = None, mirror: Sequence[float] | None = None, glass_index: float | None = None,
        secondary_seed: int | None = None, secondary_bounces: int | None = None, tracing: str | None = None,
        list_capacity: int | None = None, triangle_test: str | None = None, box_bits: int | None = None,
        response_precision: str | None = None, program: StrPath | None = None) -> Results:
    """``grtx run``: the designs on a view, as Results; ``machine``: one, or several, which Results.machines has.

    ``settings``: {key: value} of the configuration. ``output``: the folder; without it the files are dropped. The others are
    the command's options, with _ for -; None takes the program's default. Raises ProgramError.
    """
    options = _given(locals(), "scene", "cameras", "settings", "output", "program")
    with tempfile.TemporaryDirectory() as folder:
        output = os.path.join(folder, "run") if output is None else output
        grtx.call("run", "--scene", grtx.file(scene), "--cameras", grtx.file(cameras), "--output", grtx.file(output),
                  *grtx.settings(settings), *grtx.options(options), program=program)
        return read_results(output)


def _traces(traces: StrPath | Iterable[StrPath] | Mapping[str, StrPath]) -> dict[str, StrPath]:
    """Traces by name: of the file, or its path where two files have one name."""
    if isinstance(traces, Mapping):
        return dict(traces)
    paths = list(traces) if grtx.is_list(traces) else [traces]
    names = Counter(os.path.basename(os.fspath(path)) for path in paths)
    return {os.fspath(path) if names[os.path.basename(os.fspath(path))] > 1 else os.path.basename(os.fspath(path)): path
            for path in paths}


def _axis(name: str, value: Any) -> list[Any]:
    values = [grtx.plain(one) for one in value] if grtx.is_list(value) else [grtx.plain(value)]
    if not values:
        raise ValueError(f"{name}: an axis needs a value")
    if any(grtx.is_list(one) or isinstance(one, Mapping) for one in values):
        raise ValueError(f"{name}: an axis is a value, or a list of one dimension")
    return values


def simulate_all(traces: StrPath | Iterable[StrPath] | Mapping[str, StrPath], settings: Settings | None = None,
                 values: str | Iterable[str] | None = None, jobs: int = 1, *, machine: Any = None, config: Any = None,
                 design: Any = None, mode: Any = None, target_error: Any = None, share: Any = None, seed: Any = None,
                 warm: Any = None, warm_state: Any = None, strict: Any = False, watchdog: Any = None,
                 construction_order: Any = None, no_idle_skip: Any = False, latency: Any = False,
                 program: StrPath | None = None) -> pd.DataFrame:
    """Every trace with every combination of settings: a frame of one row per run.

    ``traces``: a path, several, or {name: path}. ``settings``: {key: value}. Options are simulate()'s. Each value may be a
    list, a range, an array or a series: an axis. Columns: ``trace``, what was given, then the statistics, integers as
    integers; ``attrs["units"]`` has their units. ``values``: names of those wanted (default: all but host.*). ``jobs``: runs at a time. The first run that the
    program refuses ends all. Raises ProgramError; StatisticsError for an unknown name in ``values``.
    """
    given = _given(locals(), "traces", "settings", "values", "jobs", "program")
    if settings is not None and not isinstance(settings, Mapping):
        raise TypeError(f"settings: must be {{key: value or list of values}}, not {settings!r}")
    axes = {name: _axis(name, value) for name, value in {**(settings or {}), **given}.items()}
    wanted = None if values is None else named(values)
    paths = _traces(traces)

    units: dict[str, str] = {}

    def row(name: str, point: dict[str, Any]) -> dict[str, Any]:
        own = {key: value for key, value in point.items() if key not in given}
        options = {key: value for key, value in point.items() if key in given}
        statistics = _simulated(paths[name], own, options, program)["stats"]
        for asked in wanted or ():
            if asked not in statistics:
                raise StatisticsError(paths[name], "values", unknown(asked, statistics))
        names = [s for s in statistics if not s.startswith("host.")] if wanted is None else wanted
        units.update({s: statistics[s]["unit"] for s in names})
        return {"trace": name, **point, **{s: statistics[s]["value"] for s in names}}

    with ThreadPoolExecutor(max_workers=max(1, jobs)) as pool:
        runs = [pool.submit(row, name, dict(zip(axes, chosen)))
                for name in paths for chosen in itertools.product(*axes.values())]
        try:
            rows = [one.result() for one in runs]
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise
    columns = {name: None for one in rows for name in one}  # a dict keeps their order
    frame = table({name: [one.get(name) for one in rows] for name in columns}).rename_axis("run")
    frame.attrs["units"] = units
    return frame
