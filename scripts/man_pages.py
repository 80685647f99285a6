#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes manual pages, grtx.1 and grtx-COMMAND.1, from what `grtx --help` and `grtx COMMAND --help` print.

Their date is that of CITATION.cff, or of SOURCE_DATE_EPOCH where it is set: two builds write the same bytes.

Usage: man_pages.py GRTX FOLDER
"""
import datetime
import os
import re
import sys

import cli_help

VALUES = {"UINT": "N", "INT": "N", "FLOAT": "X", "TEXT": "TEXT", "INPUT": "FILE", "OUTPUT": "FILE", "X,Y": "X,Y"}


def roff(text):
    """Text that stands for itself: backslashes, hyphens, and a dot or quote that begins a line."""
    text = text.replace("\\", "\\e").replace("-", "\\-")
    return "\n".join("\\&" + line if line[:1] in (".", "'") else line for line in text.split("\n"))


def date():
    if "SOURCE_DATE_EPOCH" in os.environ:
        return datetime.datetime.fromtimestamp(int(os.environ["SOURCE_DATE_EPOCH"]), datetime.timezone.utc).date().isoformat()
    citation = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "CITATION.cff")
    with open(citation, encoding="utf-8") as file:
        return re.search(r"^date-released: (\S+)", file.read(), re.M).group(1)


def heading(option):
    """`-o,--output FILE`, the value in italics; few choices in its place."""
    text = roff(",".join(option.names))
    if option.value and option.names[0].startswith("-"):
        choices = "|".join(option.choices)
        text += " \\fI" + roff(choices if choices and len(choices) <= 40 else VALUES.get(option.value, option.value)) + "\\fR"
        if option.repeated:
            text += " ..."
    return text


def sentences(option):
    """The description, and what the parser's marks say of it."""
    text = re.sub(r" \(no default\)", "", option.description)
    said = [text if not text or text.endswith(".") else text + "."]
    if len("|".join(option.choices)) > 40:
        said.append("One of " + ", ".join(option.choices) + ".")
    if option.range:
        said.append({"POSITIVE": "Above 0.", "NONNEGATIVE": "At least 0."}.get(option.range, f"From {option.range}."))
    if option.default and "(default:" not in text:
        said.append(f"Default: {option.default}.")
    if option.required:
        said.append("Required.")
    if option.excludes:
        said.append("Not together with " + ", ".join(option.excludes) + ".")
    if option.needs:
        said.append("Only with " + ", ".join(option.needs) + ".")
    return " ".join(part for part in said if part)


def page(command, version, others):
    name = " ".join(filter(None, ("grtx", command.name)))
    out = [f'.TH "{name.replace(" ", "-").upper()}" 1 "{date()}" "{version}" "GRTX-TLM"', ".SH NAME",
           roff(f"{name.replace(' ', '-')} - {command.summary}"), ".SH SYNOPSIS", ".B " + roff(command.usage)]
    if command.text:
        out += [".SH DESCRIPTION", roff(command.text)]
    for title, options in (("ARGUMENTS", command.arguments), ("OPTIONS", command.options)):
        if options:
            out.append(f".SH {title}")
        for option in options:
            out += [".TP", ".B " + heading(option), roff(sentences(option))]
    if command.commands:
        out.append(".SH COMMANDS")
        for other, summary in command.commands:
            out += [".TP", ".B " + roff(other), roff(summary)]
    out += [".SH EXIT STATUS", roff("0 done, 1 a check or comparison did not hold, 2 bad input or usage (one line: file, "
                                    "place, rule, what to do), 3 internal error")]
    out += [".SH SEE ALSO", ", ".join(f"{roff(other)}(1)" for other in others)]
    return "\n".join(out) + "\n"


def main():
    program, folder = sys.argv[1], sys.argv[2]
    os.makedirs(folder, exist_ok=True)
    version = cli_help.printed(program, "--version").split(",")[0].strip()
    top, *commands = cli_help.everything(program)
    pages = {"grtx": page(top, version, [f"grtx-{command.name}" for command in commands])}
    for command in commands:
        pages[f"grtx-{command.name}"] = page(command, version, ["grtx"])
    for name, content in pages.items():
        with open(os.path.join(folder, name + ".1"), "w", encoding="utf-8") as file:
            file.write(content)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main()
