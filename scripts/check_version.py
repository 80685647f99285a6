#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""One version in all places: project() of CMakeLists.txt, python/grtx_tlm/__init__.py, CITATION.cff, packaging/, CHANGELOG.md.

A tree between releases has a suffix ("-dev", GRTX_VERSION_SUFFIX of CMakeLists.txt), no section and no date. Its Spack
recipe may still name the last release: there is no later tag. A release's section does not speak of "-dev".

CHANGELOG.md has a section for it, below [Unreleased], and each of its versions has a link to compare it with the one
before. A section has each heading once. "Model version N", said by [Unreleased] or else by the version's section, is
that of rtl_tlm/run/model_version.h. CITATION.cff has the date of the version's section, and none while that has none.

Usage: check_version.py [--tag vX.Y.Z] [--notes [--links URL]] [FOLDER]   (default: the folder above this script)
--tag: the tree must be that version, with a date. --notes: prints that version's section, for the release; its links into
the tree begin with URL, since a release's page lies elsewhere.
Exit code 1 and one line a fault: file, rule.
"""
import argparse
import os
import re
import sys

MODEL = "rtl_tlm/run/model_version.h"
SECTION = re.compile(r"^## \[([^\]]+)\](?: - (.*))?$", re.M)
DATE = re.compile(r"\d{4}-\d\d-\d\d$")


def read(top, name):
    with open(os.path.join(top, name), encoding="utf-8") as file:
        return file.read()


def first(pattern, text):
    found = re.search(pattern, text, re.M)
    return found.group(1) if found else None


def sections(text):
    """Version -> (date or what stands there, text below)."""
    marks = list(SECTION.finditer(text))
    ends = [mark.start() for mark in marks[1:]] + [len(text)]
    return {mark.group(1): (mark.group(2) or "", text[mark.end():end].strip()) for mark, end in zip(marks, ends)}


def twice(body):
    """Headings that a section has more than once, each named once."""
    headings = re.findall(r"^(### .*?) *$", body, re.M)
    return [heading for heading in dict.fromkeys(headings) if headings.count(heading) > 1]


def linked(text, url):
    """Links to files of the tree, and to headings of CHANGELOG.md itself, below url."""
    below = url.rstrip("/") + "/"
    text = re.sub(r"\]\((?=#)", f"]({below}CHANGELOG.md", text)
    return re.sub(r"\]\((?![a-z]+:)", f"]({below}", text)


def numbers(top):
    """Version of project() and suffix; (None, "") where there is no version."""
    text = read(top, "CMakeLists.txt")
    return first(r"^project\(grtx_tlm VERSION (\S+)", text), first(r'^set\(GRTX_VERSION_SUFFIX "([^"]*)"\)', text) or ""


def faults(top, tag=None):
    number, suffix = numbers(top)
    if number is None:
        return ["CMakeLists.txt: project() has no version"]
    version = number + suffix
    found = []
    for name, pattern in (("python/grtx_tlm/__init__.py", r'^__version__ = "([^"]+)"'), ("CITATION.cff", r"^version: (\S+)"),
                          ("packaging/vcpkg/vcpkg.json", r'"version-semver": "([^"]+)"'),
                          ("packaging/spack/packages/grtx-tlm/package.py", r'^    version\("([^"]+)", tag="v\1"')):
        other = first(pattern, read(top, name))
        wanted = number + suffix.replace("-dev", ".dev0") if name.startswith("python/") else version  # PEP 440
        if name.endswith("package.py"):  # a recipe names tags
            wanted = other if suffix and other else number
        if other != wanted:
            found.append(f"{name}: version {other}, CMakeLists.txt has {version}")
    text = read(top, "CHANGELOG.md")
    known = sections(text)
    order = list(known)
    if order[:1] != ["Unreleased"]:
        found.append("CHANGELOG.md: must begin with ## [Unreleased]")
    if not suffix and order[1:2] != [version]:
        found.append(f"CHANGELOG.md: the first section below [Unreleased] must be [{version}]")
    for name in order:
        if not re.search(rf"^\[{re.escape(name)}\]: ", text, re.M):
            found.append(f"CHANGELOG.md: no link for [{name}]")
    dates = [known[name][0] for name in order[1:]]
    for name, date in zip(order[2:], dates[1:]):
        if not DATE.match(date):
            found.append(f"CHANGELOG.md: [{name}] has no date")
    for name, (_, body) in known.items():
        found += [f"CHANGELOG.md: [{name}] has the heading '{heading}' twice" for heading in twice(body)]
    model = first(r"kModelVersion = (\d+);", read(top, MODEL))
    # The first that speaks of it: between releases the model may be ahead of the version, and [Unreleased] says so.
    for name in ("Unreleased", version):
        said = re.findall(r"Model\s+version\s+(\d+)", known.get(name, ("", ""))[1])
        found += [f"CHANGELOG.md: [{name}] says model version {other}, {MODEL} has {model}"
                  for other in dict.fromkeys(said) if other != model]
        if said:
            break
    date = known.get(version, ("", ""))[0]
    cited = first(r"^date-released: (\S+)", read(top, "CITATION.cff"))
    if DATE.match(date) and cited != date:
        found.append(f"CITATION.cff: date-released {cited or 'is missing'}, CHANGELOG.md has {date}")
    elif not DATE.match(date) and cited:
        found.append(f"CITATION.cff: date-released {cited}, CHANGELOG.md has no date for [{version}]")
    if not suffix and f"{number}-dev" in known.get(version, ("", ""))[1]:
        found.append(f"CHANGELOG.md: [{version}] says {number}-dev")
    if tag is not None:
        if tag != "v" + version:
            found.append(f"CMakeLists.txt: version {version} is not that of the tag {tag}")
        if not DATE.match(date):
            found.append(f"CHANGELOG.md: [{version}] has no date yet")
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", nargs="?", default=os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
    parser.add_argument("--tag", help="vX.Y.Z")
    parser.add_argument("--notes", action="store_true")
    parser.add_argument("--links", metavar="URL")
    arguments = parser.parse_args()
    found = faults(arguments.folder, arguments.tag)
    for line in found:
        print(line, file=sys.stderr if arguments.notes else sys.stdout)
    if not found and arguments.notes:
        version = "".join(numbers(arguments.folder))
        body = sections(read(arguments.folder, "CHANGELOG.md"))[version][1]
        body = re.sub(r"\n\[[^\]]+\]: .*", "", "\n" + body).strip()
        print(linked(body, arguments.links) if arguments.links else body)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
