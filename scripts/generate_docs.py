#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the generated parts of the documentation anew.

What lies between a line `<!-- generated: grtx ARGUMENTS -->` and the next line `<!-- end of generated -->` of a page in
docs/ becomes what that command prints. Lists of keys and statistics are folded: a section per unit, which a click opens,
and one line for names that differ in one part alone, or in "_max" or "_p95" at their end. A source that the key above
has, too, is "″"; a key without one is of confidence C, and a statistic without a kind is a count.

Usage: generate_docs.py [--check] GRTX
--check: writes nothing; exit code 1 and one line for each page that is out of date.
"""
import argparse
import glob
import os
import re
import subprocess
import sys

PART = re.compile(r"(<!-- generated: grtx ([^\n]*) -->\n)(.*?)(<!-- end of generated -->\n)", re.S)


def folded_rows(rows):
    """Rows whose names differ in one part, and whose other cells are alike or differ in that part alone, become one:
    `a.{x,y}.b`. In the other cells the part is then "…"."""
    groups = {}
    for name, *cells in rows:
        parts = name.split(".")
        for i, part in enumerate(parts):
            key = (i, tuple(parts[:i]), tuple(parts[i + 1 :]),
                   tuple(re.sub(rf"(?<!\w){re.escape(part)}(?!\w)", "…", cell) for cell in cells))
            groups.setdefault(key, []).append(name)
    largest, done = {}, set()
    for key, names in sorted(groups.items(), key=lambda entry: -len(entry[1])):
        names = [name for name in names if name not in largest]
        if len(names) > 1:
            largest.update({name: (key, names) for name in names})
    for name, *cells in rows:
        if name not in largest:
            yield [name, *cells]
        elif name not in done:
            (i, before, after, common), names = largest[name]
            done.update(names)
            several = "{" + ",".join(one.split(".")[i] for one in names) + "}"
            yield [".".join([*before, several, *after]), *common]


def folded(printed):
    """The list that the program prints, with a section for each unit, and fewer columns and rows."""
    sections, head, above = {}, None, None
    for line in printed.splitlines():
        cells = [cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]]
        if not cells or cells[0].startswith("-"):
            continue
        if not cells[0].startswith("`"):
            head = cells
            continue
        name, *cells = cells
        name = name.strip("`")
        parts = name.split(".")
        if head[0] == "key":
            default, limits, unit, meaning, source, confidence = cells
            limits = re.sub(r"(?<=\d) to (?=\d)", "–", limits)
            others = "" if default in ("true", "false") else ", ".join(value for value in limits.split(", ") if value != default)
            source = "" if source == "this project" else source.removeprefix("this project: ")
            row = [name, f"{default}; {others} {unit}".rstrip("; "), meaning, f"{confidence}: {source}".rstrip(": ")]
            sections.setdefault(parts[0], []).append(row)
        else:
            unit, kind, meaning = cells
            several = len(parts) > 2 and "_" not in parts[1].removeprefix("energy_nj")
            sections.setdefault(".".join(parts[: 1 + several]), []).append([name, unit if kind == "count" else f"{unit}, {kind}", meaning])
    text = []
    for unit, rows in sections.items():
        title, what = (f"[{unit}]", "keys") if head[0] == "key" else (unit, "statistics")
        text += [f"### {title}", "", '<details markdown="1">', f"<summary>{len(rows)} {what}</summary>", ""]
        for name, values, meaning, *source in folded_rows(rows):
            stem = re.sub("_(max|p95)$", "", name)
            if stem != name and text[-1].startswith(f"* `{stem}` ("):  # more of the same values
                text[-1] = text[-1].replace(stem, f"{stem}{{,{name.removeprefix(stem)}}}", 1)
                continue
            text.append(f"* `{name}` ({values}): {meaning}")
            if source and ":" in source[0]:
                text[-1] += " [″]" if source == above else f" [{source[0]}]"
            above = source
        text += ["", "</details>", ""]
    return "\n".join(text)


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--check", action="store_true")
    options.add_argument("grtx", help="the program")
    arguments = options.parse_args()

    def renewed(part):
        command = [arguments.grtx] + part.group(2).split()
        printed = subprocess.run(command, check=True, capture_output=True, text=True).stdout
        if "--list-json" not in command:
            printed = folded(printed)
        return part.group(1) + "\n" + printed.rstrip("\n") + "\n\n" + part.group(4)

    top = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")
    stale = 0
    for page in sorted(glob.glob(os.path.join(top, "docs", "**", "*.md"), recursive=True)):
        with open(page, encoding="utf-8") as file:
            text = file.read()
        fresh = PART.sub(renewed, text)
        if fresh == text:
            continue
        stale += 1
        name = os.path.relpath(page, top)
        if arguments.check:
            print(f"{name}: out of date: run scripts/generate_docs.py {arguments.grtx}", file=sys.stderr)
        else:
            with open(page, "w", encoding="utf-8") as file:
                file.write(fresh)
            print(name)
    return 1 if arguments.check and stale else 0


if __name__ == "__main__":
    sys.exit(main())
