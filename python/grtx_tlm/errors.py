# SPDX-License-Identifier: Apache-2.0
"""Errors: one line that names the file, the place and the rule, as the program's own."""
import difflib
import os
from collections.abc import Iterable

StrPath = str | os.PathLike[str]


class GrtxError(ValueError):
    """A file that does not hold what its format says.

    Attributes: ``file`` (path as given), ``place`` (where in it, e.g. ``group 3``), ``rule`` (what does not hold).
    ``str()`` is ``FILE: PLACE: RULE``.
    """

    def __init__(self, file: StrPath, place: str, rule: str) -> None:
        self.file, self.place, self.rule = str(file), place, rule
        super().__init__(f"{file}: {place}: {rule}" if place else f"{file}: {rule}")


class TraceError(GrtxError):
    """A trace that the program refuses: damaged, cut, of an unknown version, or contradicting itself."""


class ProgramError(GrtxError):
    """The program has refused, or failed: ``code`` is its exit code, ``rule`` what it said last."""

    def __init__(self, command: str, code: int, rule: str) -> None:
        super().__init__(f"grtx {command}", "", rule.removeprefix("grtx: "))
        self.code = code


class StatisticsError(GrtxError):
    """A statistics, result or sweep file that is damaged or of an unknown schema, or has not what is asked of it."""


def unknown(name: object, known: Iterable[object]) -> str:
    """What to say of a name that is none of the known: with those that are near."""
    near = difflib.get_close_matches(str(name), [str(one) for one in known], n=3, cutoff=0.7)
    return f"there is no '{name}'" + (f"; near it: {', '.join(near)}" if near else "")
