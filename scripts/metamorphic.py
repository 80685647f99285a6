#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Relations that hold without knowing what is right: the same thing asked in two ways gives the same answer.

    scripts/metamorphic.py [--program build/release/grtx] [--seed S] [--cases N] [--only NAME,...] [--keep FOLDER] [--list]

A relation is a function in scripts/relations/, whose docstring states it. A case is a relation with a seed: a random small
scene, view, machine or plan. N cases are run of each relation, fewer of the long ones (--list says of how many one stands
for). A find is printed with what differs and the commands that lead to it; --keep leaves its files there.

The same seed gives the same cases on every host, but for the moments of kills. Ends with a table and `N passed, N failed`;
exit code 1 with finds.
"""
import argparse
import os
import shutil
import sqlite3
import sys
import tempfile
import time
import traceback

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from relations import RELATIONS, Broken, Case  # noqa: E402

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))


class Count:
    """Of one relation."""

    def __init__(self):
        self.cases, self.claims, self.finds, self.seconds, self.skipped = 0, 0, 0, 0.0, set()


def run_case(relation, program, seed, folder, **more):
    """The case, and what is wrong ("": nothing)."""
    case = Case(program, folder, f"{relation.name} {seed}", **more)
    try:
        relation.check(case)
    except Broken as broken:
        return case, str(broken)
    except (LookupError, ValueError, TypeError, OSError, sqlite3.Error) as error:  # something else was written
        place = traceback.extract_tb(error.__traceback__)[-1]
        return case, f"{os.path.basename(place.filename)}, line {place.lineno}: {type(error).__name__}: {error}"
    return case, "" if case.claims else "nothing was compared"


def show(relation, seed, case, wrong, kept):
    print(f"{relation.name}, seed {seed}: {wrong}")
    for command in case.commands:
        print(f"    {command}")
    print(f"    again: scripts/metamorphic.py --only {relation.name} --seed {seed} --cases 1 --keep FOLDER"
          f"{f'; files: {kept}' if kept else ''}", flush=True)


def run(options, chosen):
    counts, program = {}, os.path.abspath(options.program)
    for relation in chosen:
        count = counts[relation.name] = Count()
        for seed in range(options.seed, options.seed + max(1, options.cases // relation.each)):
            begin = time.monotonic()
            with tempfile.TemporaryDirectory() as top:
                folder = os.path.join(os.path.realpath(top), "case")
                os.mkdir(folder)
                case, wrong = run_case(relation, program, seed, folder)
                if wrong:
                    kept = os.path.join(options.keep, f"{relation.name}_{seed}") if options.keep else ""
                    if kept:
                        shutil.rmtree(kept, ignore_errors=True)
                        shutil.copytree(folder, kept)
                    show(relation, seed, case, wrong, kept)
            count.cases += 1
            count.claims += case.claims
            count.finds += bool(wrong)
            count.seconds += time.monotonic() - begin
            count.skipped |= case.skipped
    return counts


def table(counts):
    print("| relation | cases | comparisons | finds | s |\n|---|---|---|---|---|")
    for name, count in counts.items():
        print(f"| `{name}` | {count.cases} | {count.claims} | {count.finds} | {count.seconds:.1f} |")
    for reason in sorted(set().union(*(count.skipped for count in counts.values()))):
        print(f"skipped: {reason}")
    failed = sum(count.finds for count in counts.values())
    print(f"{sum(count.cases for count in counts.values()) - failed} passed, {failed} failed")
    return 1 if failed else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=f"{ROOT}/build/release/grtx")
    parser.add_argument("--seed", type=int, default=1, help="of the first case (default: 1)")
    parser.add_argument("--cases", type=int, default=20, help="of a relation (default: 20)")
    parser.add_argument("--only", help="names, separated by commas (default: all)")
    parser.add_argument("--keep", help="folder for the files of finds")
    parser.add_argument("--list", action="store_true", help="print the relations")
    options = parser.parse_args()
    if options.list:
        for relation in RELATIONS.values():
            print(f"{relation.name}{f' (one for {relation.each})' if relation.each > 1 else ''}: {relation.check.__doc__}")
        return 0
    names = options.only.split(",") if options.only else list(RELATIONS)
    unknown = [name for name in names if name not in RELATIONS]
    if unknown:
        parser.error(f"there is no relation {unknown[0]}; --list has all")
    return table(run(options, [RELATIONS[name] for name in names]))


if __name__ == "__main__":
    sys.exit(main())
