#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Finds places of the documentation that name what does not exist.

* Links of every Markdown file: the file they lead to, and the heading behind a '#'.
* Files and folders of the tree that Markdown names in `code` and in code blocks; links of pictures (SVG).
* Files that comments of the sources name by their path from the top, `docs/guide/testing.md` for one.
* Pages of docs/ that share a name.
* A README.md at the top of more lines than a newcomer reads.
* Sentences and lines of docs/ that are too long (docs_prose.py). How many words there are goes to stderr.
* Figures of an older model that do not say so, and golden records that are not those of the model's version
  (model_version.py); of other scenes than those of evaluation.toml (evaluation_tables.py); tables that are not those of
  their data (readme_tables.py).
* With --program: commands and options of `grtx` in Markdown.

Usage: check_docs.py [--program GRTX] [FOLDER]   (default: the folder above this script)
Exit code 1 and one line a fault: file, line, rule.
"""
import argparse
import glob
import os
import re
import subprocess
import sys

import docs_prose
import evaluation_tables
import model_version
import readme_tables

SOURCE = r"(?:h|cpp|py|sh|cmake|v|sv|toml|md|csv|svg|png|in)"

# Names that more than one folder of docs/ may have.
SHARED = {"README.md"}
README_LINES = 70  # two screens: what it is, what it shows, how to begin
# Pages of commands that are wrong on purpose; tests/scripts/newcomer_test.py runs them.
MISTAKES = {"docs/guide/when-it-fails.md"}


def tracked(top):
    """Files of the project, without what is built or ignored; all files where the project is no git checkout."""
    listing = subprocess.run(["git", "-C", top, "ls-files", "-co", "--exclude-standard"], capture_output=True, text=True)
    if listing.returncode == 0:
        return sorted(f for f in set(listing.stdout.splitlines()) if os.path.exists(os.path.join(top, f)))
    files = []
    for folder, names, here in os.walk(top):
        names[:] = [n for n in names if not n.startswith(".") and n != "build"]
        files += [os.path.relpath(os.path.join(folder, f), top) for f in here]
    return sorted(files)


def anchors(text):
    """Names that GitHub gives to headings, and <a id> marks."""
    names = set(re.findall(r'<a (?:id|name)="([^"]+)"', text))
    for heading in re.findall(r"^#+ +(.*?) *$", re.sub(r"```.*?```", "", text, flags=re.S), flags=re.M):
        words = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).lower()
        name = re.sub(r"[^\w\- ]", "", words).replace(" ", "-")
        count = 1
        unique = name
        while unique in names:
            unique = f"{name}-{count}"
            count += 1
        names.add(unique)
    return names


class Checker:
    def __init__(self, top, program=None):
        self.top = top
        self.program = program
        self.options = {}  # of each command of the program; None: there is no such command
        self.files = tracked(top)
        self.folders = sorted({f.split("/")[0] for f in self.files if "/" in f and not f.startswith(".")})
        self.names = {os.path.basename(f) for f in self.files}
        self.faults = []
        self.words = {}  # of each folder below docs/
        self.pages = {}  # the first of a name in docs/
        start = "|".join(map(re.escape, self.folders))
        self.path = re.compile(rf"(?<![\w./$-])(?:\.\./)?((?:{start})/[\w./*{{}},-]*)")
        self.cited = re.compile(rf"(?<![\w./$-])((?:{start})/[\w./-]+\.{SOURCE})(?![\w/])")

    def fault(self, file, text, at, rule):
        self.faults.append(f"{file}:{text.count(chr(10), 0, at) + 1}: {rule}")

    def exists(self, path):
        """A file, a folder, a pattern of either, or a file without its ending (a unit, a program of bench/)."""
        if re.search(r"NAME|FOLDER", path):  # placeholders
            return True
        choices = [path.rstrip("/.,")]
        while any("{" in c for c in choices):
            choices = [c.replace(m.group(0), word, 1) for c in choices for m in [re.search(r"\{([^{}]*)\}", c)] if m
                       for word in m.group(1).split(",")]
        return all(glob.glob(os.path.join(self.top, c)) or glob.glob(os.path.join(self.top, c + ".*")) for c in choices)

    def markdown(self, file):
        text = open(os.path.join(self.top, file), encoding="utf-8").read()
        plain = re.sub(r"```.*?```", lambda m: re.sub(r"[^\n]", " ", m.group(0)), text, flags=re.S)
        for link in re.finditer(r"\]\(([^)\s]+)\)", plain):
            target, _, anchor = link.group(1).partition("#")
            if "://" in target or target.startswith("mailto:"):
                continue
            place = os.path.normpath(os.path.join(os.path.dirname(file), target)) if target else file
            full = os.path.join(self.top, place)
            if not os.path.exists(full):
                self.fault(file, text, link.start(), f"link to {target}, which does not exist")
            elif anchor and place.endswith(".md") and anchor not in anchors(open(full, encoding="utf-8").read()):
                self.fault(file, text, link.start(), f"link to {link.group(1)}: no such heading")
        if os.path.basename(file) == "CHANGELOG.md":
            return  # tells what files were called before
        for code in re.finditer(r"```.*?```|`[^`\n]+`", text, flags=re.S):
            for path in self.path.finditer(code.group(0)):
                if not self.exists(path.group(1)):
                    self.fault(file, text, code.start() + path.start(), f"names {path.group(1)}, which does not exist")
            name = re.fullmatch(r"`([\w*{},-]+\.(?:h|cpp|py|sh|cmake))`", code.group(0))
            if name and not re.search(r"NAME|FOLDER", name.group(1)) and not self.is_name(name.group(1)):
                self.fault(file, text, code.start(), f"names {name.group(1)}, and no file is called that")

        if self.program is not None and file not in MISTAKES:
            self.commands(file, text)

    def prose(self, file):
        with open(os.path.join(self.top, file), encoding="utf-8") as page:
            text = page.read()
        folder, name = os.path.split(file)
        first = self.pages.setdefault(name, file)
        if first != file and name not in SHARED:
            self.faults.append(f"{file}:1: has the name of {first}")
        self.words[folder] = self.words.get(folder, 0) + docs_prose.words(text)
        self.faults += [f"{file}:{line}: {rule}" for line, rule in docs_prose.breaches(text)]

    def length(self, file):
        with open(os.path.join(self.top, file), encoding="utf-8") as page:
            lines = len(page.read().splitlines())
        if lines > README_LINES:
            self.faults.append(f"{file}:{README_LINES + 1}: {lines} lines, more than {README_LINES}")

    def options_of(self, command):
        if command not in self.options:
            run = subprocess.run([self.program, command, "--help"], capture_output=True, text=True)
            self.options[command] = set(re.findall(r"(?<![\w-])--?[a-zA-Z][\w-]*", run.stdout)) if run.returncode == 0 else None
        return self.options[command]

    def commands(self, file, text):
        for call in re.finditer(r"(?:^|(?<=[`\s/;|]))grtx ([a-z][a-z-]*)((?:[^\n`#\\]|\\\n)*)", text, flags=re.M):
            if not self.in_code(text, call.start()):
                continue
            known = self.options_of(call.group(1))
            if known is None:
                self.fault(file, text, call.start(), f"grtx has no command {call.group(1)}")
                continue
            for option in re.findall(r"(?<![\w-])--[a-z][\w-]*", call.group(2)):
                if option not in known:
                    self.fault(file, text, call.start(), f"grtx {call.group(1)} has no option {option}")

    @staticmethod
    def in_code(text, at):
        before = text[:at]
        if before.count("```") % 2 == 1:
            return True
        line = before[before.rfind("\n") + 1:]
        return line.count("`") % 2 == 1 or line.startswith("    ")

    def is_name(self, name):
        if not re.search(r"[*{]", name):
            return name in self.names
        pattern = re.escape(name).replace(r"\*", ".*").replace(r"\{", "(").replace(r"\}", ")").replace(",", "|")
        return any(re.fullmatch(pattern, n) for n in self.names)

    def picture(self, file):
        text = open(os.path.join(self.top, file), encoding="utf-8").read()
        for link in re.finditer(r'<a href="([^":#]+)"', text):
            if not os.path.exists(os.path.join(self.top, os.path.dirname(file), link.group(1))):
                self.fault(file, text, link.start(), f"link to {link.group(1)}, which does not exist")

    def source(self, file):
        try:
            text = open(os.path.join(self.top, file), encoding="utf-8").read()
        except UnicodeDecodeError:
            return
        for line in re.finditer(r"^.*$", text, flags=re.M):
            if line.group(0).lstrip().startswith("#include"):
                continue
            for path in self.cited.finditer(line.group(0)):
                # Tests and CMake files also name files from their own folder.
                if not os.path.exists(os.path.join(self.top, path.group(1))) and not os.path.exists(
                        os.path.join(self.top, os.path.dirname(file), path.group(1))):
                    self.fault(file, text, line.start(), f"names {path.group(1)}, which does not exist")

    def run(self):
        for file in self.files:
            if file.endswith(".svg"):
                self.picture(file)
            if file.startswith(".") or not re.search(r"\.(md|h|cpp|in|py|sh|toml|cmake|v)$|CMakeLists\.txt$", file):
                continue
            if file.endswith(".md"):
                self.markdown(file)
                if file.startswith("docs/"):
                    self.prose(file)
                elif file == "README.md":
                    self.length(file)
            elif not re.search(r"check_(docs|arrows)\.py$|(check_\w+|public_headers|site)_test\.py$", file):  # their own faults
                self.source(file)
        self.faults += [*model_version.faults(self.top), *evaluation_tables.faults(self.top), *readme_tables.faults(self.top)]
        return self.faults


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", nargs="?", default=os.path.join(os.path.dirname(__file__), ".."))
    parser.add_argument("--program", help="the built grtx")
    arguments = parser.parse_args()
    checker = Checker(os.path.abspath(arguments.folder), arguments.program)
    faults = checker.run()
    for line in faults:
        print(line)
    print("words: " + ", ".join(f"{folder} {count}" for folder, count in sorted(checker.words.items())) +
          f"; together {sum(checker.words.values())}", file=sys.stderr)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
