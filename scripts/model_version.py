#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Which model the figures of the documentation are of.

    model_version.py               the version, and which pages are older
    model_version.py raise TEXT    golden records changed: the next version. Pages say which one they are of, and are faults
                                   until they are measured again
    model_version.py same TEXT     records changed, but no result did (a new column): notes it beside the version

The version is one constant (rtl_tlm/run/model_version.h). docs/results/data/model_versions.csv says what changed with each
and holds a hash of the golden records: of the statistics that pages quote, in tests/rtl_tlm/run/golden.tsv and
data/traces/records.tsv. A page of docs/results begins with a table, its stamp: command, date, model version, machine,
assumes. `model version` is the present one, or says `measured with version N`, or `none` and why no model is in it. In
README.md and docs/results/README.md a paragraph that quotes figures of an older page says `measured with version N`, too.

A page of an older version than the model is a fault: it is measured again, or goes to docs/notes. What stays all the same has
a line in docs/results/data/older_pages.csv: page, the model's version for which it may stay, date, reason. With the next version
the line is void. Such a line excepts a page, or docs/results/data/evaluation.csv, from a changed set of scenes, too
(evaluation_tables.py). check_docs.py asks.
"""
import csv
import datetime
import glob
import hashlib
import os
import re
import sys

TOP = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
HEADER = "rtl_tlm/run/model_version.h"
VERSIONS = "docs/results/data/model_versions.csv"
OLDER = "docs/results/data/older_pages.csv"
RECORDS = ("tests/rtl_tlm/run/golden.tsv", "data/traces/records.tsv")
QUOTED = {"gpu.cycles", "gpu.dram.bytes", "gpu.energy_nj", "gpu.l1.accesses", "gpu.l2.accesses", "gpu.rt.node_fetches",
          "gpu.rt.node_fetch_latency"}
STAMP = ("command", "date", "model version", "machine", "assumes")
CONSTANT = re.compile(r"(kModelVersion = )(\d+)")
QUOTING = ("README.md", "docs/results/README.md")  # pages that quote figures of pages of results
MEASURED = re.compile(r"measured with version (\d+)", re.I)


def read(top, name):
    with open(os.path.join(top, name), encoding="utf-8") as file:
        return file.read()


def write(top, name, text):
    with open(os.path.join(top, name), "w", encoding="utf-8", newline="") as file:
        file.write(text)


def current(top):
    return int(CONSTANT.search(read(top, HEADER)).group(2))


def versions(top):
    return list(csv.DictReader(read(top, VERSIONS).splitlines()))


def hash_of_records(top):
    cells = []
    for name in RECORDS:
        columns, *rows = [line.split("\t") for line in read(top, name).splitlines()]
        cells += [f"{name} {column} {row[0]} {value}" for row in rows if row[0] in QUOTED for column, value in zip(columns[1:], row[1:])]
    return hashlib.sha256("\n".join(sorted(cells)).encode()).hexdigest()[:16]


def pages(top):
    found = glob.glob(os.path.join(top, "docs", "results", "*.md")) + glob.glob(os.path.join(top, "docs", "results", "paper", "*.md"))
    return sorted(os.path.relpath(page, top) for page in found if os.path.relpath(page, top) != "docs/results/README.md")


def stamp(text):
    """Rows of the table that the page begins with."""
    table = re.search(r"^\| \| \|\n\|---\|---\|\n((?:\|.*\n)+)", text, flags=re.M)
    return dict(re.findall(r"^\| ([^|]+?) \| (.*) \|$", table.group(1), flags=re.M)) if table else {}


def version_of(text, now):
    """The version that a page's stamp names first; the present one where no model is in it."""
    named = re.search(r"(?<![\w.-])(\d+)(?![\w.-])", stamp(text).get("model version", ""))
    return int(named.group(1)) if named else now


def versions_of(text, now):
    """All versions that a page's stamp names; the present one where no model is in it."""
    named = re.findall(r"(?<![\w.-])(\d+)(?![\w.-])", stamp(text).get("model version", ""))
    return [int(version) for version in named] or [now]


def old_pages(top):
    """Page and the least version that its stamp names, of pages that are older than the model in whole or part."""
    now = current(top)
    oldest = {page: min(versions_of(read(top, page), now)) for page in pages(top)}
    return {page: version for page, version in oldest.items() if version < now}


def exceptions(top):
    """Lines of OLDER."""
    return list(csv.DictReader(read(top, OLDER).splitlines())) if os.path.exists(os.path.join(top, OLDER)) else []


def faults_of_old_pages(top):
    """Pages that are older than the model and not excepted, and lines of OLDER that except nothing."""
    now, old, excepted = current(top), old_pages(top), set()
    for number, line in enumerate(exceptions(top), 2):
        place = f"{OLDER}:{number}: {line['page']}"
        if not (re.fullmatch(r"\d{4}-\d\d-\d\d", line["date"] or "") and (line["reason"] or "").strip()):
            yield f"{place}: needs a date and a reason"
        elif line["page"] not in old and not line["page"].endswith(".csv"):
            yield f"{place}: is not older than the model, or not there: the line goes"
        elif line["model"] != str(now):
            yield f"{place}: was excepted for version {line['model']}, and the model has {now}"
        excepted.add(line["page"])
    for page, version in old.items():
        if page not in excepted:
            yield (f"{page}:1: is of version {version}, the model has {now}: measure again, move its figures to docs/notes, "
                   f"or say in {OLDER} why it stays")


def blocks(text):
    """Paragraphs and list items outside code and tables, with their places."""
    plain = re.sub(r"```.*?```|<!-- generated:.*?<!-- end of generated -->", lambda m: re.sub(r"[^\n]", "|", m.group(0)), text, flags=re.S)
    for block in re.finditer(r"^(?![|#<]).+(?:\n(?![*|#<\n]).+)*", plain, flags=re.M):
        yield block.start(), block.end()


def old_quotations(top, quoting):
    """Place of the end, and version, of each paragraph of a page that quotes an older page and does not say so."""
    if not os.path.exists(os.path.join(top, quoting)):
        return
    text, now = read(top, quoting), current(top)
    for start, end in blocks(text):
        block = text[start:end]
        if not re.search(r"\d", re.sub(r"\]\([^)]*\)", "", block)):
            continue
        for link in re.findall(r"\]\(([\w./-]+\.md)", block):
            page = os.path.normpath(os.path.join(os.path.dirname(quoting), link))
            if not page.startswith("docs/results/") or page == "docs/results/README.md" or not os.path.exists(os.path.join(top, page)):
                continue
            of = version_of(read(top, page), now)
            if of < now and str(of) not in MEASURED.findall(block):
                yield end, of, page


def faults(top):
    """Line by line, what check_docs.py prints."""
    if not os.path.exists(os.path.join(top, HEADER)):
        return
    now, known = current(top), versions(top)
    if int(known[-1]["version"]) != now:
        yield f"{VERSIONS}:1: ends with version {known[-1]['version']}, {HEADER} has {now}"
    if known[-1]["records"] != hash_of_records(top):
        yield f"{VERSIONS}:1: golden records are not those of version {now}: scripts/model_version.py raise \"what changed\""
    for page in pages(top):
        text = read(top, page)
        rows = stamp(text)
        missing = [row for row in STAMP if row not in rows and not (row == "date" and "/paper/" in page)]  # the same bytes each day
        if missing:
            yield f"{page}:1: its stamp lacks {', '.join(missing)} (scripts/model_version.py)"
            continue
        cell = rows["model version"]
        old = [n for n in re.findall(r"(?<![\w.-])(\d+)(?![\w.-])", MEASURED.sub("", cell)) if int(n) != now]
        if old or not re.search(r"\d|^none", cell):
            yield f"{page}:1: model version {cell}: must be {now}, 'measured with version N', or 'none' and why"
        if any(int(n) > now for n in MEASURED.findall(text)):
            yield f"{page}:1: names a version of the model that is not there yet"
    yield from faults_of_old_pages(top)
    for quoting in QUOTING:
        for end, of, page in old_quotations(top, quoting):
            line = read(top, quoting).count("\n", 0, end) + 1
            yield f"{quoting}:{line}: quotes {page}: must say 'measured with version {of}'"


def add(top, version, what):
    rows = versions(top)
    if int(rows[-1]["version"]) == version:
        rows[-1]["what changed"] += "; " + what
    else:
        rows.append({"version": version, "what changed": what})
    rows[-1].update({"date": datetime.date.today().isoformat(), "records": hash_of_records(top)})
    with open(os.path.join(top, VERSIONS), "w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def rise(top, what):
    before = current(top)
    add(top, before + 1, what)
    write(top, HEADER, CONSTANT.sub(rf"\g<1>{before + 1}", read(top, HEADER)))
    for page in pages(top):
        text = read(top, page)
        write(top, page, re.sub(rf"^(\| model version \| )({before}\b)", r"\1measured with version \2", text, count=1, flags=re.M))
    for quoting in QUOTING:
        for end, of, _ in sorted(old_quotations(top, quoting), reverse=True):
            text = read(top, quoting)
            if str(of) not in MEASURED.findall(text[text.rfind("\n\n", 0, end) + 1:end].rsplit("\n* ", 1)[-1]):
                write(top, quoting, text[:end] + f"\n  (Measured with version {of}.)" + text[end:])


def main():
    if len(sys.argv) == 1:
        now = current(TOP)
        print(f"version {now}: {versions(TOP)[-1]['what changed']}")
        for page, of in old_pages(TOP).items():
            print(f"version {of}: {page}")
    elif len(sys.argv) == 3 and sys.argv[1] == "raise":
        rise(TOP, sys.argv[2])
    elif len(sys.argv) == 3 and sys.argv[1] == "same":
        add(TOP, current(TOP), sys.argv[2])
    else:
        sys.exit(__doc__.strip())
        return
    if len(sys.argv) > 1:
        import readme_tables  # its tables say which version they are of
        readme_tables.renew(TOP)


if __name__ == "__main__":
    main()
