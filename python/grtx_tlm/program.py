# SPDX-License-Identifier: Apache-2.0
"""The program `grtx`: where it is, how it is called, and how Python's values become its options."""
import os
import shutil
import subprocess
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from .errors import ProgramError, StrPath

REPEATED = ("heatmap",)  # options given once per value; other lists are joined by commas


def find_program(program: StrPath | None = None) -> str:
    """``program``, else the environment's ``GRTX``, else ``grtx`` on the PATH. Raises FileNotFoundError."""
    program = os.fspath(program or os.environ.get("GRTX", "grtx"))
    if shutil.which(program) is None:
        raise FileNotFoundError(f"{program}: no program; name it by the environment's GRTX")
    return program


def file(path: StrPath) -> str:
    """The path as an argument of its own: one that begins with - would be an option."""
    text = os.fspath(path)
    return os.path.join(os.curdir, text) if text.startswith("-") else text


def call(command: str, *arguments: StrPath, program: StrPath | None = None) -> str:
    """Runs ``grtx COMMAND ARGUMENTS --quiet``. Raises ProgramError with its exit code and last line on stderr."""
    done = subprocess.run([find_program(program), command, *map(os.fspath, arguments), "--quiet"], text=True,
                          capture_output=True, check=False)
    if done.returncode != 0:
        lines = [line for line in done.stderr.splitlines() if line] or [f"exit code {done.returncode}"]
        raise ProgramError(command, done.returncode, lines[-1])
    return done.stdout


def is_list(value: Any) -> bool:
    """Whether a value stands for several: a list, tuple, range, array, series. Text and paths stand for one."""
    return isinstance(value, Iterable) and not isinstance(value, (str, bytes, os.PathLike, Mapping)) and \
        getattr(value, "ndim", 1) > 0


def plain(value: Any) -> Any:
    """Python's own number of a number of numpy."""
    return value.item() if hasattr(value, "item") and not is_list(value) else value


def _text(value: Any) -> str:
    value = plain(value)
    if isinstance(value, bool):
        return str(value).lower()
    return os.fspath(value) if isinstance(value, os.PathLike) else str(value)


def options(given: Mapping[str, Any]) -> Iterator[str]:
    """{"width": 64, "no_trace": True, "k": None} as --width=64 --no-trace."""
    for name, value in given.items():
        flag = "--" + name.replace("_", "-")
        value = plain(value)
        if value is True:
            yield flag
        elif is_list(value) and name in REPEATED:
            yield from (f"{flag}={_text(one)}" for one in value)
        elif is_list(value):
            yield f"{flag}={','.join(map(_text, value))}"
        elif value is not None and value is not False:
            yield f"{flag}={_text(value)}"


def settings(given: Mapping[str, Any] | None) -> Iterator[str]:
    """{key: value} as --set key=value."""
    if given is not None and not isinstance(given, Mapping):
        raise TypeError(f"settings: must be {{key: value}}, not {given!r}")
    for key, value in (given or {}).items():
        yield f"--set={key}={_text(value)}"
