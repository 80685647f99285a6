# SPDX-License-Identifier: Apache-2.0
"""Databases of `grtx sweep`, for the tables of this folder."""
import contextlib
import json
import sqlite3


def points(path, *names, earlier=False):
    """The points that are done of the plan that filled the database last, in their order: dictionaries of what the table `point` says, with
    `at` (coordinates), `values` (the named statistics; without names all) and, where it is there, `config` and the trace's `tracer` options as objects.
    earlier: also what is left of plans before, which is compared with nothing else (docs/guide/sweep.md); a database of before schema
    grtx.sweep/3 does not say it."""
    with contextlib.closing(sqlite3.connect(f"file:{path}?mode=ro", uri=True)) as database:
        database.row_factory = sqlite3.Row
        tables = {row[0] for row in database.execute("SELECT name FROM sqlite_master")}
        present = " AND id IN (SELECT point_id FROM present)" if "present" in tables and not earlier else ""
        found = {row["id"]: {**row, "at": json.loads(row["coordinates"]), "values": {}} for row in database.execute(
            f"SELECT * FROM point WHERE status = 'done'{present} ORDER BY id")}
        for number, name, value in database.execute(
                "SELECT point_id, name, value FROM value" + (f" WHERE name IN ({','.join('?' * len(names))})" if names else ""), names):
            if number in found:
                found[number]["values"][name] = value
        traces = dict(map(tuple, database.execute("SELECT key, options FROM trace"))) if "trace" in tables else {}
    for point in found.values():
        if traces:
            point.update(config=json.loads(point["config"]), tracer=json.loads(traces[point["trace_key"]])["tracer"])
    return list(found.values())
