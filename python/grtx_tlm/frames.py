# SPDX-License-Identifier: Apache-2.0
"""Statistics, results and sweeps of the program as pandas frames."""
import json
import os
import sqlite3
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from .errors import StatisticsError, StrPath, unknown

#: The designs, in the order of the program's tables.
DESIGNS: tuple[str, ...] = ("baseline", "sw", "hw", "grtx", "gautracer", "walk")


def _document(path: str, schemas: str | tuple[str, ...], made_by: str) -> dict[str, Any]:
    try:
        with open(path, encoding="utf-8") as file:
            document = json.load(file)
    except (json.JSONDecodeError, UnicodeDecodeError, RecursionError) as error:
        raise StatisticsError(path, "", f"is no JSON: {error}") from None
    found = document.get("schema") if isinstance(document, dict) else None
    known = (schemas,) if isinstance(schemas, str) else schemas
    if found not in known:
        raise StatisticsError(path, "schema", f"is {found!r}, must be {known[0]}: {made_by}")
    return document


def _part(document: dict[str, Any], name: str, path: str) -> dict[str, Any]:
    part = document.get(name)
    if not isinstance(part, dict):
        raise StatisticsError(path, name, "must be an object")
    return part


def numbers(values: Iterable[Any], index: Any = None, name: Any = None) -> pd.Series:
    """A column of numbers: int64 if all of them are integers that it can hold, else float64; None is NaN. Text stays."""
    values = list(values)
    known = [value for value in values if value is not None and value == value]
    if all(isinstance(value, bool) for value in known):
        kind = "float64" if not known else "bool" if len(known) == len(values) else "boolean"
    elif any(isinstance(value, str) or not isinstance(value, (int, float)) for value in known):
        kind = "object"
    else:
        fits = len(known) == len(values) and all(isinstance(v, int) and -2**63 <= v < 2**63 for v in known)
        kind = "int64" if fits else "float64"
    missing = pd.NA if kind == "boolean" else float("nan")
    return pd.Series([missing if value is None or value != value else value for value in values], index, kind, name)


def table(columns: dict[str, Iterable[Any]], index: Any = None) -> pd.DataFrame:
    """Columns by name as a frame, each as numbers() gives it."""
    return pd.DataFrame({name: numbers(values, index) for name, values in columns.items()}, index=index)


def named(names: str | Iterable[str]) -> list[str]:
    """A list of names; one name alone is a list of it, not of its letters."""
    return [names] if isinstance(names, str) else list(names)


def _quantities(stats: dict[str, Any], path: str, place: str) -> pd.DataFrame:
    """{name: {value, unit, description}} as a frame of one row per statistic."""
    for name, entry in stats.items():
        if not isinstance(entry, dict) or not {"value", "unit", "description"} <= set(entry):
            raise StatisticsError(path, f"{place}.{name}", "must have value, unit and description")
        if isinstance(entry["value"], bool) or not isinstance(entry["value"], (int, float, type(None))):
            raise StatisticsError(path, f"{place}.{name}", "must have a number or null as its value")
    values = [entry["value"] for entry in stats.values()]
    return pd.DataFrame({"value": pd.Series(values, index=list(stats), dtype="float64"),
                         "unit": [entry["unit"] for entry in stats.values()],
                         "description": [entry["description"] for entry in stats.values()]}).rename_axis("statistic")


def _notes(notes: Any, path: str, place: str) -> list[dict[str, str]]:
    """What limits the meaning of a run's figures: [{"id", "text"}]; files of earlier versions have none."""
    if not isinstance(notes, list) or not all(isinstance(n, dict) and {"id", "text"} <= set(n) for n in notes):
        raise StatisticsError(path, place, "must be a list of notes with id and text")
    return notes


def read_statistics(path: StrPath) -> pd.DataFrame:
    """Statistics of one run (``grtx sim --stats``, schema grtx.stats/1).

    Gives a frame of one row per statistic, index ``statistic``, columns ``value`` (float, which holds integers to 2**53; NaN
    for null), ``unit``, ``description``. ``frame.attrs`` holds ``config``, ``inputs`` and ``over_time`` (dicts), and
    ``notes``: [{"id", "text"}], what limits the figures' meaning. Raises StatisticsError, OSError.
    """
    path = os.fspath(path)
    return statistics_frame(statistics_document(path), path)


def statistics_document(path: str) -> dict[str, Any]:
    """The file as it is. Raises StatisticsError, OSError."""
    return _document(path, "grtx.stats/1", "write one with 'grtx sim --stats'")


def statistics_frame(document: dict[str, Any], path: str) -> pd.DataFrame:
    frame = _quantities(_part(document, "stats", path), path, "stats")
    frame.attrs.update(config=_part(document, "config", path), inputs=_part(document, "inputs", path),
                       notes=_notes(document.get("notes", []), path, "notes"), over_time=document.get("over_time") or {})
    return frame


def over_time(statistics: pd.DataFrame | StrPath) -> pd.DataFrame:
    """The course of a run, from its statistics (a frame of read_statistics(), or the file): a row an interval, index
    ``end_of_interval`` in cycles. ``attrs["units"]`` and ``attrs["descriptions"]`` by column. Empty in windows mode."""
    if not isinstance(statistics, pd.DataFrame):
        statistics = read_statistics(statistics)
    if "over_time" not in statistics.attrs:
        raise ValueError("over_time: takes a frame of read_statistics() or simulate(), or a statistics file")
    series = statistics.attrs["over_time"]
    frame = table({name: entry["values"] for name, entry in series.items()})
    if "end_of_interval" in frame:
        frame = frame.set_index("end_of_interval")
    frame.attrs.update(units={name: entry["unit"] for name, entry in series.items()},
                       descriptions={name: entry["description"] for name, entry in series.items()})
    return frame


@dataclass(repr=False, eq=False)
class Results:
    """What ``grtx run`` measured.

    - ``statistics``: frame of one row per statistic, one column per design (value; NaN where a design has none); of a sequence
      counts, time and energy are of all its frames.
    - ``quantities``: frame of the same rows: ``unit``, ``description``.
    - ``speedup``: series by design, over ``speedup_over`` (which itself is 1).
    - ``pictures``: frame of one row a design and frame: ``psnr`` against ``speedup_over`` and ``psnr_reference`` against the
      reference in the design's own order, in dB (infinite: identical pictures); ``order``, by which its hits are blended;
      ``reference``: "fp64", on ``reference_pixels`` of the frame, or "tracer", which traced it at full precision. Empty for
      files of earlier versions.
    - ``frames``: frame of one row per frame of a sequence, a column per design, in cycles; empty for one view.
    - ``notes``: {design: [{"id", "text"}]}, what limits the figures' meaning.
    - ``machine``, ``config``, ``images_identical``, ``violations``: as in the file.
    - ``machines``: {machine: Results} where ``grtx run`` had several, this one (the first) included; else empty.
    - ``times``: frame of one row per design, one column per machine: simulated time in µs (``attrs["units"]``), of a sequence
      that of all its frames.
    - ``keys``: frame of one row per configuration key or option of the tracer ("tracer.NAME") in which the machines differ, one
      column per machine; empty for one machine.
    """

    statistics: pd.DataFrame
    quantities: pd.DataFrame
    speedup: pd.Series
    speedup_over: str
    frames: pd.DataFrame
    machine: str
    config: dict[str, Any]
    images_identical: bool | None
    violations: list[str]
    notes: dict[str, list[dict[str, str]]]
    pictures: pd.DataFrame
    machines: dict[str, "Results"]
    times: pd.DataFrame
    keys: pd.DataFrame

    def __repr__(self) -> str:
        times = ", ".join(f"{design} {value:.2f}" for design, value in self.speedup.items() if design != self.speedup_over)
        if self.machines:
            return f"<Results: machines {', '.join(self.machines)} of {', '.join(self.statistics.columns)}; times, keys, machines[...]>"
        return (f"<Results: machine {self.machine or 'unknown'}, {len(self.statistics)} statistics of "
                f"{', '.join(self.statistics.columns)}; times as fast as {self.speedup_over}: {times or 'none'}>")


def _pictures(document: dict[str, Any], path: str) -> pd.DataFrame:
    columns = ["order", "psnr", "psnr_reference", "reference", "reference_pixels"]
    rows = {}
    for design, own in (_part(document, "pictures", path) if "pictures" in document else {}).items():
        try:
            for frame, (over, reference) in enumerate(zip(own["psnr"], own["psnr_reference"], strict=True)):
                rows[design, frame] = [own["order"], *(float("inf") if psnr is None else float(psnr) for psnr in (over, reference)),
                                       own["reference"], own["reference_pixels"]]
        except (KeyError, TypeError, ValueError):
            raise StatisticsError(path, f"pictures.{design}", "must have lists of dB, one for each frame") from None
    index = pd.MultiIndex.from_tuples(list(rows), names=["design", "frame"]) if rows else \
        pd.MultiIndex.from_arrays([[], []], names=["design", "frame"])
    return pd.DataFrame(list(rows.values()), index=index, columns=columns)


def read_results(path: StrPath) -> Results:
    """``results.json`` of ``grtx run`` (schema grtx.run/2 or 1), or its folder, as Results: of several machines the first, with
    all of them in ``machines``. Raises StatisticsError, OSError."""
    path = os.fspath(path)
    if os.path.isdir(path):
        path = os.path.join(path, "results.json")
    document = _document(path, ("grtx.run/2", "grtx.run/1"), "write one with 'grtx run -o DIR'")
    machines = document.get("machines", [document])
    if not isinstance(machines, list) or not machines or not all(isinstance(one, dict) for one in machines):
        raise StatisticsError(path, "machines", "must be a list of objects")
    of_all = {name: value for name, value in document.items() if name not in ("machines", "between_machines")}
    results = [_results({**of_all, **one}, path) for one in machines]
    if len(results) > 1:
        between = _part(document, "between_machines", path)
        names = [one.machine for one in results]
        times = pd.concat([one.times for one in results], axis=1)
        times.attrs["units"] = dict.fromkeys(names, "us")
        differing = _part(between, "keys", path)
        keys = pd.DataFrame(list(differing.values()), index=pd.Index(list(differing), name="key"), columns=names, dtype=object)
        for one in results:
            one.machines, one.times, one.keys = dict(zip(names, results)), times, keys
            suffix = f" on {one.machine.split(',')[0]}: "
            one.violations = [text for text in one.violations if suffix in text]
    return results[0]


def _results(document: dict[str, Any], path: str) -> Results:
    designs = {name: _quantities(stats, path, f"designs.{name}") for name, stats in _part(document, "designs", path).items()}
    if not designs:
        raise StatisticsError(path, "designs", "must name a design")
    over = document.get("speedup_over", "baseline")
    faster = _part(document, "speedup", path) if "speedup" in document else {}  # of one design there is none
    speedup = pd.Series({over: 1.0, **faster}, name="speedup", dtype=float)
    quantities = pd.concat([frame[["unit", "description"]] for frame in designs.values()])
    statistics = pd.DataFrame({name: frame["value"] for name, frame in designs.items()})
    statistics.attrs["units"] = quantities["unit"].to_dict()
    machine = document.get("machine", "")
    times = statistics.reindex(["gpu.time_us"]).T.set_axis([machine], axis=1).rename_axis("design")
    times.attrs["units"] = {machine: "us"}
    return Results(
        statistics=statistics,
        quantities=quantities[~quantities.index.duplicated()],
        speedup=speedup.reindex([d for d in DESIGNS if d in speedup] + [d for d in speedup.index if d not in DESIGNS]),
        speedup_over=over,
        frames=table(document.get("frames", {}).get("cycles", {})).rename_axis("frame"),
        machine=machine,
        config=_part(document, "config", path),
        images_identical=document.get("images_identical"),
        violations=document.get("violations", []),
        notes={name: _notes(notes, path, f"notes.{name}") for name, notes in document.get("notes", {}).items()},
        pictures=_pictures(document, path),
        machines={},
        times=times,
        keys=pd.DataFrame(columns=[machine], index=pd.Index([], name="key")),
    )


def read_sweep(path: StrPath, values: str | Iterable[str] | None = None) -> pd.DataFrame:
    """Points of a sweep or a search (SQLite, schema grtx.sweep/3, 2 or 1), opened read-only.

    Gives a frame of one row per point, index ``point``: ``scene``, ``design``, ``machine``, ``mode``, ``status``, ``reason``,
    ``seconds``, ``earlier_plan``, ``notes`` (ids of what limits its figures' meaning, docs/model/statistics.md; "" for none),
    a column for each coordinate, and one for each statistic and cost. Coordinates are what
    the plan varied, and whatever else points of equal machine, mode, scene and design differ in. ``earlier_plan``: the plan
    that filled the database last does not ask for the point, so compare it with no other. ``values``: names of those wanted (default: all). ``frame.attrs``: ``units`` and
    ``descriptions`` by statistic, ``plan`` (text), ``shared`` (what all points are made from: size, tracer options,
    configuration). Statistics of points that are not done are NaN. Raises StatisticsError, OSError.
    """
    path = os.fspath(path)
    with open(path, "rb"):  # an error of the operating system, not SQLite's
        pass
    try:
        database = sqlite3.connect(f"{Path(path).absolute().as_uri()}?mode=ro", uri=True)
        try:
            return _sweep(database, path, values)
        finally:
            database.close()
    except (sqlite3.Error, pd.errors.DatabaseError) as error:
        raise StatisticsError(path, "", f"is no database of a sweep: {error}") from None


OF_A_POINT = ("status", "reason", "seconds", "earlier_plan", "notes")  # columns of read_sweep that tell no points apart


def coordinates(frame: pd.DataFrame) -> list[str]:
    """Columns of a frame of ``read_sweep`` or ``simulate_all`` that tell its rows apart: neither statistics nor costs."""
    return [name for name in frame if name not in frame.attrs.get("units", {}) and name not in OF_A_POINT]


def speedup(frame: pd.DataFrame, reference: Mapping[str, Any], value: str = "gpu.cycles") -> pd.Series:
    """How many times as fast each row is as the row that has ``reference`` and is the same in all else that was varied.

    ``frame``: of ``read_sweep`` or ``simulate_all``, with ``value`` among its statistics. ``reference``: by column, say
    ``{"design": "baseline"}``, ``{"tracer.k": 16}`` or ``{"machine": "paper", "l1.bytes": 65536}``. NaN where there is no such row.
    Points of an earlier plan are left out. Raises ValueError for a column that is not there, and where several rows fit.
    """
    for name in [*reference, value]:
        if name not in frame:
            raise ValueError(f"speedup: {unknown(name, frame.columns)}")
    rows = frame[~frame["earlier_plan"]] if "earlier_plan" in frame else frame
    same = [name for name in coordinates(rows) if name not in reference]
    chosen = rows[np.logical_and.reduce([rows[name] == wanted for name, wanted in reference.items()])]
    key = lambda row: tuple(None if pd.isna(row[name]) else row[name] for name in same)
    base: dict[tuple[Any, ...], float] = {}
    for _, row in chosen.iterrows():
        if key(row) in base:
            raise ValueError(f"speedup: several rows have {dict(reference)} and are alike in {', '.join(same) or 'nothing'}")
        base[key(row)] = row[value]
    return pd.Series([base.get(key(row), np.nan) / row[value] for _, row in rows.iterrows()], index=rows.index, name="speedup",
                     dtype=float)


def _sweep(database: sqlite3.Connection, path: str, values: str | Iterable[str] | None) -> pd.DataFrame:
    meta = dict(database.execute("SELECT key, value FROM meta"))
    if meta.get("schema") != "grtx.sweep/3":
        raise StatisticsError(path, "meta.schema", "must be grtx.sweep/3: write one with 'grtx sweep -o DB'")
    quantities = pd.read_sql_query("SELECT * FROM quantity", database, index_col="name")
    names = list(quantities.index) if values is None else named(values)
    for name in names:
        if name not in quantities.index:
            raise StatisticsError(path, "values", unknown(name, quantities.index))
    points, varied, shared = _points(database, path)
    marks = ",".join("?" * len(names))
    rows = pd.read_sql_query("SELECT point_id AS point, name, value FROM value" +
                             ("" if values is None else f" WHERE name IN ({marks})"), database,
                             params=None if values is None else names)
    found = rows.pivot(index="point", columns="name", values="value").reindex(index=points.index)
    found = found.reindex(columns=[name for name in names if name in found.columns or values is not None]).astype("float64")
    found.columns.name = None
    varied = varied.drop(columns=[name for name in varied if name in points])
    frame = pd.concat([points, varied, found], axis=1)
    asked = quantities.loc[[name for name in names if name in quantities.index]]
    frame.attrs.update(units=asked["unit"].to_dict(), descriptions=asked["description"].to_dict(),
                       plan=meta.get("plan", ""), shared=shared)
    return frame


def _objects(texts: Iterable[str | None], path: str, place: str) -> list[dict[str, Any]]:
    """JSON objects of a column's texts; {} for NULL."""
    objects = []
    for text in texts:
        try:
            objects.append(json.loads(text or "{}"))
        except (json.JSONDecodeError, RecursionError) as error:
            raise StatisticsError(path, place, f"is no JSON: {error}") from None
        if not isinstance(objects[-1], dict):
            raise StatisticsError(path, place, "must be a JSON object")
    return objects


def _trace_inputs(options: dict[str, Any]) -> dict[str, Any]:
    """What a trace is made from, by the names of coordinates; as the program's trace_inputs()."""
    inputs = {name: value for name, value in options.items() if name not in ("tracer", "trace_format")}
    for name, text in options.get("tracer", {}).items():
        if name not in ("accel", "checkpoint"):  # of the design
            try:
                value = json.loads(text)
            except json.JSONDecodeError:
                value = text
            inputs[f"tracer.{name}"] = value if isinstance(value, (bool, int, float)) else text
    return inputs


def _less_registers_of_heaps(made: pd.DataFrame, points: pd.DataFrame) -> pd.DataFrame:
    """The same with one value where a design keeps its hits in registers and sets as many as its k needs, three for a hit (`grtx machine
    --design walk --k 16`): they are no other machine."""
    name = "simt.payload_registers"
    if name not in made or "tracer.k" not in made:
        return made
    needed = np.minimum(3 * pd.to_numeric(made["tracer.k"]), 255)
    own = points["design"].isin(("gautracer", "walk")) & (pd.to_numeric(made[name]) == needed)
    return made.assign(**{name: made[name].where(~own, "as k needs")})


def _points(database: sqlite3.Connection, path: str) -> tuple[pd.DataFrame, pd.DataFrame, dict[str, Any]]:
    """Frames of points and of their coordinates, and what all points share."""
    points = pd.read_sql_query(
        "SELECT id AS point, scene, design, machine, mode, status, reason, seconds, "
        "id NOT IN (SELECT point_id FROM present) AS earlier_plan, "
        "coordinates, trace_key, config, json_extract(document, '$.inputs.\"memory.files_hash\"') AS memory, "
        "json_extract(nullif(document, ''), '$.notes') AS notes FROM point "
        "ORDER BY id", database, index_col="point").astype({"earlier_plan": bool, "seconds": "float64"})
    points["notes"] = [", ".join(note["id"] for note in _notes(json.loads(text or "[]"), path, "point.document.notes"))
                       for text in points["notes"]]
    traces = dict(database.execute("SELECT key, options FROM trace"))
    traces = {key: _trace_inputs(one) for key, one in
              zip(traces, _objects(traces.values(), path, "trace.options"))}
    varied = pd.DataFrame(_objects(points.pop("coordinates"), path, "point.coordinates"), index=points.index)
    configs = _objects(points.pop("config"), path, "point.config")
    made = pd.DataFrame([{**traces.get(trace, {}), **config, **({"memory.files_hash": memory} if memory else {})}
                         for trace, config, memory in zip(points.pop("trace_key"), configs, points.pop("memory"))],
                        index=points.index, dtype=object)
    compared = _less_registers_of_heaps(made, points)
    waiting = {name for config in configs for name in config}  # unknown, and not different, of a point without configuration
    several = [name for name in made if compared[name].nunique(dropna=name in waiting) > 1]
    groups = compared[several].groupby([points[name] for name in ("machine", "mode", "scene", "design")])
    for name in several:
        if (groups[name].nunique(dropna=name in waiting) > 1).any():
            varied[name] = varied[name].where(varied[name].notna(), made[name]) if name in varied else made[name]
    varied = table(dict(varied.items()), varied.index)
    shared = {name: made[name].dropna().iloc[0] for name in made if name not in several and made[name].notna().any()}
    return points, varied, shared
