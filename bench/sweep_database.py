# SPDX-License-Identifier: Apache-2.0
"""Databases of `grtx sweep`, for the tables of this folder."""
import sqlite3


def open_plan(path):
    """The database, read-only, with a view `of_plan`: the points of the plan that filled it last. What is left of an
    earlier plan is compared with nothing (docs/guide/sweep.md); a database of before schema grtx.sweep/3 does not say it."""
    database = sqlite3.connect(f"file:{path}?mode=ro", uri=True)
    marked = database.execute("SELECT count(*) FROM sqlite_master WHERE name = 'present'").fetchone()[0]
    database.execute("CREATE TEMP VIEW of_plan AS SELECT * FROM main.point" +
                     (" WHERE id IN (SELECT point_id FROM main.present)" if marked else ""))
    return database
