#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What moved in the shared libraries since another commit, such as the last release, by libabigail's abidiff.

    scripts/abi.py COMMIT [LIBRARY...]       LIBRARY: base, traces, frontend, modules, sim, ...: all that both have

Builds COMMIT and this tree below build/abi as shared libraries, unoptimised and with debug information, and prints for
each library how many functions and variables went, changed and came, and by name what went from the public headers of
COMMIT: within a major version that is a fault (docs/api.md). Names that came again with other parameters are told, too:
a further one with a default breaks no caller. abidiff's own words are in build/abi/LIBRARY.txt.
Exit code 1: a public name went; 2: it could not be asked.
"""
import argparse
import io
import os
import re
import shutil
import subprocess
import sys
import tarfile

TOP = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
FOLDER = os.path.join(TOP, "build", "abi")
SUMMARY = re.compile(r"^(Functions|Variables) changes summary: (\d+) Removed.*?, (\d+) Changed.*?, (\d+) Added", re.M)
GONE = re.compile(r"^  \[D\] '(?:function|method|variable)? ?(.*)'", re.M)
CAME = re.compile(GONE.pattern.replace("D", "A"), re.M)


def must(command, **more):
    done = subprocess.run(command, capture_output=True, check=False, **more)
    if done.returncode != 0:
        print(f"abi.py: {' '.join(command[:4])} ended with {done.returncode}:\n"
              f"{(done.stdout + done.stderr)[-2000:].decode(errors='replace')}", file=sys.stderr)
        sys.exit(2)
    return done.stdout


def build(source, name, wanted):
    """Folder of the libraries and of the public headers of a tree, and library -> file."""
    folder = os.path.join(FOLDER, name)
    must(["cmake", "-G", "Ninja", "-S", source, "-B", folder, "-DBUILD_SHARED_LIBS=ON", "-DCMAKE_BUILD_TYPE=Debug", "-DCMAKE_UNITY_BUILD=ON",
          "-DGRTX_BUILD_TESTS=OFF", "-DGRTX_RTL=OFF", "-DGRTX_REPORT_CHARTS=OFF"])
    known = re.findall(r"^grtx_(\w+): phony", must(["ninja", "-C", folder, "-t", "targets", "all"]).decode(), re.M)
    libraries = [library for library in wanted or known if library in known]
    must(["cmake", "--build", folder, "--target", *(f"grtx_{library}" for library in libraries)])
    headers = os.path.join(folder, "headers")
    shutil.rmtree(headers, ignore_errors=True)
    parts = ";".join(part for part in os.listdir(source) if os.path.isdir(os.path.join(source, part)))
    must(["cmake", f"-DSOURCE={source}", f"-DFOLDERS={parts}", f"-DDESTINATION={headers}", "-P",
          os.path.join(source, "cmake", "install_headers.cmake")])
    found = {}
    for where, _, files in os.walk(folder):
        for file in files:
            match = re.fullmatch(r"libgrtx_(\w+)\.so", file)
            if match and match[1] in libraries:
                found[match[1]] = os.path.join(where, file)
    return headers, found


def declared(name):
    """What a declaration declares: without return type and parameters, "<>" in place of each template's arguments."""
    text, depth = "", 0
    for at, letter in enumerate(name):
        depth += letter == "<"
        text += letter if depth == 0 or (depth == 1 and letter == "<") else ""
        if letter == ">" and name[at - 1] != "-" and depth > 0:
            depth -= 1
            text += ">" if depth == 0 else ""
    return text.split("(")[0].split(" ")[-1]


def is_public(name, texts):
    """Whether one header has the name and the class or namespace that it is in. A template that is instantiated by nobody
    any more has not gone, and what std instantiates is not ours."""
    name = declared(name)
    words = [re.compile(rf"(?<!\w){re.escape(part)}(?!\w)") for part in name.split("::")[-2:]]
    return name.startswith("grtx::") and "<" not in name and any(all(word.search(text) for word in words) for text in texts)


def moved(report, texts):
    """Names of public headers (their text) that went, and those whose parameters are others now."""
    came = {declared(name) for name in CAME.findall(report)}
    gone = [name for name in GONE.findall(report) if is_public(name, texts)]
    return [name for name in gone if declared(name) not in came], [name for name in gone if declared(name) in came]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("commit")
    parser.add_argument("library", nargs="*")
    arguments = parser.parse_args()
    if not shutil.which("abidiff"):
        print("abi.py: abidiff is missing: install abigail-tools", file=sys.stderr)
        return 2
    commit = must(["git", "-C", TOP, "rev-parse", "--short=12", "--verify", arguments.commit + "^{commit}"]).decode().strip()
    source = os.path.join(FOLDER, commit, "source")
    if not os.path.isdir(source):
        with tarfile.open(fileobj=io.BytesIO(must(["git", "-C", TOP, "archive", commit]))) as archive:
            archive.extractall(source)
    old_headers, old = build(source, commit, arguments.library)
    new_headers, new = build(TOP, "tree", arguments.library)
    texts = []
    for where, _, files in os.walk(old_headers):
        for file in files:
            with open(os.path.join(where, file), encoding="utf-8") as header:
                texts.append(header.read())
    missing = [library for library in arguments.library if library not in old or library not in new]
    if missing:
        print(f"abi.py: {', '.join(missing)}: not in both; {commit} has {', '.join(sorted(old))}", file=sys.stderr)
        return 2
    public = 0
    for library in sorted(set(old) & set(new)):
        done = subprocess.run(["abidiff", "--headers-dir1", old_headers, "--headers-dir2", new_headers, "--drop-private-types", old[library],
                               new[library]], capture_output=True, text=True, check=False)
        if done.returncode & 3:  # error, wrong use
            print(f"abi.py: abidiff of {library}:\n{(done.stdout + done.stderr)[-2000:]}", file=sys.stderr)
            return 2
        with open(os.path.join(FOLDER, library + ".txt"), "w", encoding="utf-8") as report:
            report.write(done.stdout)
        print(f"{library}: " + "; ".join(f"{kind.lower()}: {gone} went, {changed} changed, {came} came"
                                         for kind, gone, changed, came in SUMMARY.findall(done.stdout)))
        went, other = moved(done.stdout, texts)
        public += len(went)
        for word, names in (("went", went), ("other parameters", other)):
            for name in names:
                print(f"  {word}: {name}")
    for library in sorted(set(old) - set(new)):
        print(f"{library}: the library is gone")
        public += 1
    return 1 if public else 0


if __name__ == "__main__":
    sys.exit(main())
