#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Finds files without a licence line (SPDX) at the top: all that git lists, or that lie there in an archive without git.

Usage: check_licence.py [--fix]
Exit code 1 and one line a file that has none, or, with git, whose kind is unknown. --fix writes the line where it is known.
"""
import fnmatch
import os
import subprocess
import sys

TOP = os.path.abspath(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
LINE = "SPDX-License-Identifier: Apache-2.0"
HASH, SLASHES = "# {}", "// {}"
# By name, or by what follows the last dot of it.
COMMENTS = {**dict.fromkeys((".h", ".cpp", ".cpp.in", ".sv", ".svh", ".js", ".mjs"), SLASHES), ".css": "/* {} */",
            **dict.fromkeys((".py", ".sh", ".awk", ".cmake", ".cmake.in", ".pc.in", ".toml", ".yml", ".yaml", ".cff", ".supp"), HASH),
            **dict.fromkeys(("CMakeLists.txt", "public_headers.txt", "Containerfile", "Dockerfile", "Doxyfile", "CODEOWNERS", "run",
                             ".clang-format", ".clang-tidy", ".dockerignore", ".editorconfig", ".gitattributes", ".gitignore"), HASH)}
# What needs no line, and why. A pattern with a slash is of the path, one without of the name.
EXEMPT = {
    "data/*": "measured or written by a program: inputs and records, byte for byte",
    "tests/data/*": "inputs of tests, some by other programs, byte for byte",
    "tests/fuzz/corpus/*": "inputs of the fuzzers",
    "tests/scripts/newcomer_answers.txt": "a golden record",
    "configs/*": "inputs that users copy; results pages have the hash of one, messages name lines of others",
    "cmake/commit.txt": "git archive writes it",
    "docs/results/*.csv": "recorded figures",
    "*.tsv": "golden records",
    "explore/cost/sram_cacti7.csv": "a table that CACTI gave",
    "*.md": "prose, under LICENSE", "LICENSE": "is the licence",
    "*.json": "has no comments", "*.ipynb": "is JSON", "py.typed": "is empty",
    "*.svg": "a picture", "*.png": "a picture", "*.webp": "a picture",
}
BUILT = (".git", ".cache", "build", "out", "node_modules", "__pycache__", "*.egg-info")  # as .gitignore has it


def matches(path, patterns):
    return any(fnmatch.fnmatchcase(path if "/" in pattern else os.path.basename(path), pattern) for pattern in patterns)


def comment_of(path):
    """How this file says it, or None if its kind is unknown."""
    name = os.path.basename(path)
    endings = [name[at:] for at, letter in enumerate(name) if letter == "." and at > 0]
    return next((COMMENTS[key] for key in (name, *endings) if key in COMMENTS), None)


def project_files():
    """Paths from the top, and whether git says that they are the project's."""
    if os.path.exists(os.path.join(TOP, ".git")):
        listing = subprocess.run(["git", "-C", TOP, "ls-files", "-z"], capture_output=True, text=True, check=False)
        if listing.returncode == 0:
            return sorted(path for path in listing.stdout.split("\0") if os.path.isfile(os.path.join(TOP, path))), True
    found = []
    for folder, names, files in os.walk(TOP):
        names[:] = [name for name in names if not matches(name, BUILT)]
        found += [os.path.relpath(os.path.join(folder, name), TOP) for name in files if not matches(name, BUILT)]
    return sorted(found), False


def with_licence(text, line):
    """The text with the line on top, below `#!` if it has one; None if it is there already."""
    lines = text.split("\n")
    at = 1 if lines[0].startswith("#!") else 0
    if len(lines) > at and lines[at] == line:
        return None
    return "\n".join(lines[:at] + [line] + lines[at:])


def main(arguments):
    missing, unknown = [], []
    files, listed = project_files()
    for path in files:
        if matches(path, EXEMPT):
            continue
        comment = comment_of(path)
        if comment is None:
            if listed:  # else somebody's scene or notes
                unknown.append(path)
            continue
        with open(os.path.join(TOP, path), encoding="utf-8") as stream:
            text = with_licence(stream.read(), comment.format(LINE))
        if text is None:
            continue
        missing.append(path)
        if "--fix" in arguments:
            with open(os.path.join(TOP, path), "w", encoding="utf-8") as stream:
                stream.write(text)
    if "--fix" in arguments:
        print(f"check_licence: {len(missing)} files written")
        missing = []
    for path in missing:
        print(f"{path}:1: no line '{LINE}'")
    for path in unknown:
        print(f"{path}:1: a kind of file that COMMENTS and EXEMPT of scripts/check_licence.py lack")
    return 1 if missing or unknown else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
