# SPDX-License-Identifier: Apache-2.0
"""Runs the program `grtx` and gives what it measured as frames."""
import itertools
import os
import shutil
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor

import pandas as pd

from .errors import ProgramError
from .frames import read_results, read_statistics


def find_program(program=None):
    """``program``, else the environment's ``GRTX``, else ``grtx`` on the PATH. Raises FileNotFoundError."""
    program = os.fspath(program or os.environ.get("GRTX", "grtx"))
    if shutil.which(program) is None:
        raise FileNotFoundError(f"{program}: no program; name it by the environment's GRTX")
    return program


def call(command, *arguments, program=None):
    """Runs ``grtx COMMAND ARGUMENTS --quiet``. Raises ProgramError with its exit code and last line on stderr."""
    done = subprocess.run([find_program(program), command, *map(os.fspath, arguments), "--quiet"], text=True,
                          capture_output=True, check=False)
    if done.returncode != 0:
        lines = [line for line in done.stderr.splitlines() if line] or [f"exit code {done.returncode}"]
        raise ProgramError(command, done.returncode, lines[-1])
    return done.stdout


def _options(options):
    """{"width": 64, "no_trace": True} as --width 64 --no-trace."""
    for name, value in options.items():
        flag = "--" + name.replace("_", "-")
        if value is True:
            yield flag
        elif value is not None and value is not False:
            yield from (flag, os.fspath(value) if isinstance(value, os.PathLike) else str(value))


def _value(value):
    return str(value).lower() if isinstance(value, bool) else str(value)


def _settings(settings):
    for key, value in (settings or {}).items():
        yield from ("--set", f"{key}={_value(value)}")


def simulate(trace, settings=None, program=None, **options):
    """``grtx sim``: the statistics of one run, as read_statistics() gives them.

    ``settings``: {key: value} of the configuration. ``options``: of the command, with _ for -: ``machine="ada-share"``,
    ``mode="sampled"``, ``warm="before.grtx"``. over_time(frame) has the run's course. Raises ProgramError.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "stats.json")
        call("sim", trace, "--stats", path, *_settings(settings), *_options(options), program=program)
        return read_statistics(path)


def run(scene, program=None, **options):
    """``grtx run``: the designs on a view, as Results. ``options``: of the command, with _ for -; without ``o``, its
    folder, the files are dropped. Raises ProgramError."""
    if "o" in options:
        folder = options.pop("o")
        call("run", "--scene", scene, "-o", folder, *_options(options), program=program)
        return read_results(folder)
    with tempfile.TemporaryDirectory() as folder:
        call("run", "--scene", scene, "-o", os.path.join(folder, "run"), *_options(options), program=program)
        return read_results(os.path.join(folder, "run"))


def simulate_all(traces, settings=None, values=None, jobs=1, program=None, **options):
    """Every trace with every combination of settings: a frame of one row a run.

    ``traces``: paths, or {name: path}. ``settings``: {key: value or list of values}. ``options``: as of simulate(), each a
    value or a list of values. Columns: ``trace``, what varies, then the statistics, integers as integers. ``values``: names
    of those wanted (default: all but host.*). ``jobs``: runs at a time.
    """
    named = dict(traces) if isinstance(traces, dict) else {os.path.basename(os.fspath(t)): t for t in traces}
    axes = {**(settings or {}), **options}
    axes = {name: value if isinstance(value, (list, tuple)) else [value] for name, value in axes.items()}
    points = [dict(zip(axes, chosen)) for chosen in itertools.product(*axes.values())]
    jobs_of = [(name, point) for name in named for point in points]

    def row(job):
        name, point = job
        frame = simulate(named[name], {k: v for k, v in point.items() if k not in options}, program=program,
                         **{k: v for k, v in point.items() if k in options})
        wanted = [s for s in frame.index if not s.startswith("host.")] if values is None else list(values)
        return {"trace": name, **point, **frame.loc[wanted, "value"].to_dict()}

    with ThreadPoolExecutor(max_workers=max(1, jobs)) as pool:
        return pd.DataFrame(list(pool.map(row, jobs_of))).rename_axis("run")
