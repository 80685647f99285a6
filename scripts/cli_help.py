# SPDX-License-Identifier: Apache-2.0
"""The commands and options of `grtx`, read from what its --help prints, for completion (completions.py).

A line of --help is a name with the parser's marks, then from column 30 on the description; a longer name stands alone, and
the description follows: `  --view UINT=0 Excludes: --views`.
"""
import re
import subprocess
from dataclasses import dataclass, field

COLUMN = 30
MARKS = re.compile(r"""(?P<names>\S+)
    (?:\ (?P<type>X,Y|[A-Z]+))?
    (?::(?P<check>\{[^}]*\}|POSITIVE|NONNEGATIVE|[-\d.]+\ to\ [-\d.]+))?
    (?:=(?P<default>\[\]|.+?))?
    (?P<repeated>\ \.\.\.)?(?:\ x\ (?P<count>\d+))?
    (?P<required>\ REQUIRED)?
    (?:\ Excludes:\ (?P<excludes>[-\w\ ]+?))?(?:\ Needs:\ (?P<needs>[-\w\ ]+))?$""", re.X)


@dataclass
class Option:
    names: list            # ["-o", "--output"]; of an argument its one name
    value: str = ""        # INPUT, OUTPUT, UINT, FLOAT, TEXT, X,Y; "" for a flag
    choices: list = field(default_factory=list)
    range: str = ""        # "0 to 65536", "POSITIVE", "NONNEGATIVE"
    default: str = ""
    repeated: bool = False
    required: bool = False
    excludes: list = field(default_factory=list)
    needs: list = field(default_factory=list)
    description: str = ""

    @property
    def is_file(self):
        return self.value in ("INPUT", "OUTPUT")


@dataclass
class Command:
    name: str              # "" of the program itself
    summary: str
    usage: str
    text: str              # what stands between both
    arguments: list
    options: list
    commands: list         # (name, summary)


def printed(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


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


def entries(lines):
    """(name with its marks, description)."""
    lines = [line for line in lines if line.strip()]
    found = []
    for line, below in zip(lines, lines[1:] + [""]):
        if line.startswith(" " * COLUMN):
            found[-1][1] = f"{found[-1][1]} {line.strip()}".strip()
        elif below.startswith(" " * COLUMN) or len(line) <= COLUMN:
            found.append([line.strip(), ""])
        else:
            found.append([line[:COLUMN].strip(), line[COLUMN:].strip()])
    return found


def option(marked, description):
    found = MARKS.match(marked)
    if found is None:  # of an unknown form: a test says so (completions_test.py), and no build fails
        return Option(names=marked.split()[0].split(","), description=f"{marked}. {description}")
    check = found["check"] or ""
    default = "" if found["default"] in (None, "[]") else found["default"]
    return Option(names=found["names"].split(","), value=found["type"] or "",
                  choices=re.split(r", *", check[1:-1]) if check.startswith("{") else [],
                  range="" if check.startswith("{") else check, default=default,
                  repeated=bool(found["repeated"]), required=bool(found["required"]),
                  excludes=(found["excludes"] or "").split(), needs=(found["needs"] or "").split(), description=description)


def command(program, name=""):
    words = [name] if name else []
    text = printed(program, *words, "--help")
    if "--help-all" in text:  # shows the options for experts, too
        text = printed(program, *words, "--help-all")
    parts = sections(text)
    groups = [heading for heading in parts if heading not in ("", "Positionals", "Subcommands")]
    above = [line for line in parts[""] if line and not line.startswith("Usage:")]
    usage = next(line for line in parts[""] if line.startswith("Usage:"))[len("Usage:"):].strip()
    return Command(name=name, summary=above[0].split(". A command's options")[0], usage=usage, text="\n".join(above[1:]),
                   arguments=[option(*entry) for entry in entries(parts.get("Positionals", []))],
                   options=[option(*entry) for heading in groups for entry in entries(parts[heading])],
                   commands=[tuple(entry) for entry in entries(parts.get("Subcommands", []))])


def everything(program):
    """The program, and each of its commands."""
    top = command(program)
    return [top] + [command(program, name) for name, _ in top.commands]


def keys(program):
    """The configuration keys that --set takes."""
    return re.findall(r"^\| `([\w.]+)` \|", printed(program, "sim", "--list-config"), re.M)


def named_values(found):
    """Values that an option takes by name, also those that only its description lists."""
    listed = re.search(r"in one word, (.+?) or a file", found.description)
    return found.choices or (re.split(r", | or ", listed.group(1)) if listed else [])
