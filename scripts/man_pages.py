#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes manual pages, grtx.1 and grtx-COMMAND.1, from what `grtx --help` and `grtx COMMAND --help` print.

Usage: man_pages.py GRTX FOLDER
"""
import os
import re
import subprocess
import sys


def printed(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def roff(text):
    """Text that stands for itself: backslashes, hyphens, and a dot or quote that begins a line."""
    text = text.replace("\\", "\\e").replace("-", "\\-")
    return "\n".join("\\&" + line if line[:1] in (".", "'") else line for line in text.split("\n"))


def entries(lines):
    """(name, description) of a list of --help: a name may stand alone, descriptions may go on below."""
    found = []
    for line in lines:
        if re.match(r"  \S", line):
            name, _, description = line.strip().partition("  ")
            # A name that reaches the column of descriptions is followed by one space there.
            found.append([name, description.strip()])
        elif line.strip() and found:
            found[-1][1] = f"{found[-1][1]} {line.strip()}".strip()
    return found


def sections(text):
    """Heading -> lines below it; '' holds what stands before the first."""
    found, heading = {"": []}, ""
    for line in text.splitlines():
        if re.fullmatch(r"[A-Z]\w+:", line):
            heading = line[:-1]
            found[heading] = []
        else:
            found[heading].append(line)
    return found


def page(name, text, version, others):
    parts = sections(text)
    above = [line for line in parts[""] if line and not line.startswith("Usage:")]
    usage = next(line for line in parts[""] if line.startswith("Usage:"))[len("Usage:"):].strip()
    summary = above[0].split(". A command's options")[0]
    out = [f'.TH "{name.replace(" ", "-").upper()}" 1 "" "{version}" "GRTX-TLM"', ".SH NAME",
           roff(f"{name.replace(' ', '-')} - {summary}"), ".SH SYNOPSIS", ".B " + roff(usage)]
    if above[1:]:
        out += [".SH DESCRIPTION", roff("\n".join(above[1:]))]
    for heading in ("Positionals", "Options", "Subcommands"):
        if heading not in parts:
            continue
        out.append(f".SH {'ARGUMENTS' if heading == 'Positionals' else 'COMMANDS' if heading == 'Subcommands' else 'OPTIONS'}")
        for option, description in entries(parts[heading]):
            out += [".TP", ".B " + roff(option), roff(description)]
    out += [".SH EXIT STATUS", roff("0 done, 1 a check or comparison did not hold, 2 bad input or usage (one line: file, "
                                    "place, rule, what to do), 3 internal error")]
    out += [".SH SEE ALSO", ", ".join(f"{roff(other)}(1)" for other in others)]
    return "\n".join(out) + "\n"


def main():
    program, folder = sys.argv[1], sys.argv[2]
    os.makedirs(folder, exist_ok=True)
    version, text = printed(program, "--version").strip(), printed(program, "--help")
    names = [name for name, _ in entries(sections(text)["Subcommands"])]
    pages = {"grtx": page("grtx", text, version, [f"grtx-{name}" for name in names])}
    for name in names:
        pages[f"grtx-{name}"] = page(f"grtx {name}", printed(program, name, "--help"), version, ["grtx"])
    for name, content in pages.items():
        with open(os.path.join(folder, name + ".1"), "w", encoding="utf-8") as file:
            file.write(content)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main()
