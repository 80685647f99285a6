#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Changes constants and comparisons of modules/ (sources, and what headers of decide/ decide), one at a time, and counts which changes the tests notice.

    scripts/mutate_model.py [--count 200] [--seed 1] [--folder build/mutation] [--jobs 2] [--last units,dumps,machines,traces]

All changes are compiled into one copy of the project, each behind its number; GRTX_MUTANT=N switches one on. So a mutant costs
the time of the tests, not of the compiler: first `grtx regress data/traces` and modules_tests (seconds), and for those that live
through both the tests of rtl_tlm that --last names: units and dumps (seconds), and the second implementation's on random machines and
random traces (a minute or two). A mutant counts for the first that notices it. Changes that do not compile (constant
expressions) are replaced by others.
Prints a line for each survivor and the shares; survivors.json holds them.
"""
import argparse
import collections
import concurrent.futures
import json
import os
import random
import re
import shutil
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
HEADER = """#pragma once
// Written by scripts/mutate_model.py.
#pragma GCC diagnostic ignored "-Wsign-compare"
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wparentheses"
#pragma GCC diagnostic ignored "-Wbool-compare"
#pragma GCC diagnostic ignored "-Wextra"
#include <cstdlib>
namespace grtx_mutation {
inline const int kActive = std::getenv("GRTX_MUTANT") == nullptr ? 0 : std::atoi(std::getenv("GRTX_MUTANT"));
template <class N>
inline N number(int mutant, N value) { return mutant == kActive ? static_cast<N>(value + 1) : value; }
enum Kind { kLt, kLe, kGt, kGe, kEq, kNe };
struct Compare { int mutant; Kind kind; };
template <class T>
struct Left { const T& value; Compare compare; };
template <class T, class U>
inline bool compared(const Left<T>& l, const U& b) {
  const bool changed = l.compare.mutant == kActive;
  const T& a = l.value;
  switch (l.compare.kind) {
    case kLt: return changed ? (a < b || a == b) : a < b;
    case kLe: return changed ? (a <= b && !(a == b)) : a <= b;
    case kGt: return changed ? (a > b || a == b) : a > b;
    case kGe: return changed ? (a >= b && !(a == b)) : a >= b;
    case kEq: return changed ? !(a == b) : a == b;
    default: return changed ? a == b : !(a == b);
  }
}
template <class T>
inline Left<T> operator<(const T& a, Compare c) { return {a, c}; }
template <class T>
inline Left<T> operator==(const T& a, Compare c) { return {a, c}; }
template <class T, class U>
inline bool operator>(const Left<T>& l, const U& b) { return compared(l, b); }
template <class T, class U>
inline bool operator==(const Left<T>& l, const U& b) { return compared(l, b); }
}  // namespace grtx_mutation
"""
COMPARISON = re.compile(r" (<=|>=|==|!=|<|>) (?=\S)")
NUMBER = re.compile(r"(?<![\w.\[<'])(\d+)(?:U|UL|ULL|u)?(?![\w.'>])")
# Tests of rtl_tlm_tests, as --gtest_filter; only those that may share a process, without the longest two of the machines.
LAST = {"units": "Directed*.*:Table/*:RtUnit*Test.*:Private*",
        "dumps": "StalledMachine.*",
        "machines": "PlainGpuList.*:Shares/PlainGpu.*-*/4:*/6",
        "traces": "Traces/RtUnitPlain.*:RtUnitPlainDirected.*"}
KINDS = {"<": "kLt", "<=": "kLe", ">": "kGt", ">=": "kGe", "==": "kEq", "!=": "kNe"}
CHANGED = {"<": "<=", "<=": "<", ">": ">=", ">=": ">", "==": "!=", "!=": "=="}
# Constants of the compiler, checks of our own invariants, and what the waveforms and states print.
NOT_IN = re.compile(r"constexpr|static_assert|assert\(|template|operator|#|^\s*case |print|dump|fmt::|throw|Error\(|enum|using ")
Change = collections.namedtuple("Change", "file line column length text what")


def is_changed(path, name):
    """Whether what the file decides is changed: sources, and headers of decide/."""
    return name.endswith(".cpp") or (name.endswith(".h") and "/decide" in path)


def candidates(folder):
    for path, _, names in sorted(os.walk(folder + "/modules")):
        for name in sorted(names):
            if not is_changed(path, name):
                continue
            file = os.path.relpath(f"{path}/{name}", folder)
            with open(f"{folder}/{file}", encoding="utf-8") as stream:
                lines = stream.read().split("\n")
            for number, line in enumerate(lines):
                code = re.sub(r'"(?:\\.|[^"\\])*"', lambda m: '"' * len(m[0]), line)
                code = re.sub(r"//.*", "", code)
                if not code.startswith("  ") or NOT_IN.search(code):
                    continue
                for m in COMPARISON.finditer(code):
                    op = m[1]
                    relation = op if op in ("==", "!=") else "<"
                    other = "==" if relation != "<" else ">"
                    relation = "==" if relation != "<" else "<"
                    text = f"{relation} grtx_mutation::Compare{{@, grtx_mutation::{KINDS[op]}}} {other}"
                    yield Change(file, number, m.start(1), len(op), text, f"{op} becomes {CHANGED[op]}")
                for m in NUMBER.finditer(code):
                    yield Change(file, number, m.start(), len(m[0]), f"grtx_mutation::number(@, {m[0]})",
                                 f"{m[0]} becomes {int(m[1]) + 1}")


def apply(folder, changes):
    """changes: by number. Two on one line are fine, they do not overlap."""
    by_file = collections.defaultdict(list)
    for number, change in changes.items():
        by_file[change.file].append((number, change))
    for path, _, names in os.walk(ROOT + "/modules"):
        for name in names:
            file = os.path.relpath(f"{path}/{name}", ROOT)
            if not is_changed(path, name):
                continue
            with open(f"{ROOT}/{file}", encoding="utf-8") as stream:
                lines = stream.read().split("\n")
            for number, change in sorted(by_file[file], key=lambda c: -c[1].column):
                line = lines[change.line]
                lines[change.line] = (line[:change.column] + change.text.replace("@", str(number)) +
                                      line[change.column + change.length:])
            if by_file[file]:
                lines[0] = '#include "grtx/modules/mutation.h" ' + "\n#line 1\n" + lines[0]
            text = "\n".join(lines)
            target = f"{folder}/{file}"
            with open(target, encoding="utf-8") as stream:
                if stream.read() == text:
                    continue
            with open(target, "w", encoding="utf-8") as stream:
                stream.write(text)


def ninja(folder, targets, jobs, keep_going=False):
    result = subprocess.run(["nice", "ninja", "-C", folder + "/build/release", f"-j{jobs}", *(["-k0"] if keep_going else []),
                             *targets], capture_output=True, text=True, check=False)
    return result.returncode, result.stdout + result.stderr


def built(folder, changes, spare, jobs, targets):
    """Compiles; what does not is dropped or replaced by a spare one."""
    for _ in range(12):
        apply(folder, changes)
        code, output = ninja(folder, ["grtx_modules"], jobs, keep_going=True)
        if code == 0:
            break
        wrong = {(os.path.relpath(os.path.join(folder, "build/release", m[1]), folder), int(m[2]) - 1)
                 for m in re.finditer(r"^([^\s:]+\.(?:cpp|h)):(\d+):\d+: (?:error|  required)", output, re.M)}
        wrong |= {(m[1], int(m[2]) - 1) for m in re.finditer(r"(modules/[\w/]+\.(?:cpp|h)):(\d+):", output)}
        bad = [n for n, c in changes.items() if (c.file, c.line) in wrong]
        if not bad:
            sys.exit(output[-3000:])
        for number in bad:
            if spare:
                changes[number] = spare.pop()
            else:
                del changes[number]
    for target in targets:
        code, output = ninja(folder, [target], jobs)
        if code:
            sys.exit(output[-3000:])


def mutants_of(folder):
    """{number: (file, line, what)}, as they stand in the copy."""
    found = {}
    operators = {kind: operator for operator, kind in KINDS.items()}
    for path, _, names in os.walk(folder + "/modules"):
        for name in names:
            if not is_changed(path, name):
                continue
            with open(f"{path}/{name}", encoding="utf-8") as file:
                lines = file.read().split("\n")
            first = 2 if lines[0].startswith('#include "grtx/modules/mutation.h"') else 0
            for at, line in enumerate(lines):
                place = (os.path.relpath(f"{path}/{name}", folder), at - first + 1)
                for m in re.finditer(r"grtx_mutation::number\((\d+), (\d+)", line):
                    found[int(m[1])] = (*place, f"{m[2]} becomes {int(m[2]) + 1}")
                for m in re.finditer(r"grtx_mutation::Compare\{(\d+), grtx_mutation::(\w+)\}", line):
                    found[int(m[1])] = (*place, f"{operators[m[2]]} becomes {CHANGED[operators[m[2]]]}")
    return dict(sorted(found.items()))


def notices(command, mutant, folder, seconds):
    try:
        return subprocess.run(command, cwd=folder, env={**os.environ, "GRTX_MUTANT": str(mutant)}, timeout=seconds,
                              stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False).returncode != 0
    except subprocess.TimeoutExpired:
        return True  # the model stands still


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--folder", default=ROOT + "/build/mutation")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--last", default=",".join(LAST),
                        help="groups of tests of rtl_tlm for what the first two do not notice; '' for none")
    parser.add_argument("--reuse", action="store_true", help="the copy as it was built before")
    options = parser.parse_args()
    names = [name for name in options.last.split(",") if name]
    if not set(names) <= set(LAST):
        parser.error(f"--last: of {', '.join(LAST)}")
    folder = os.path.abspath(options.folder)
    if not os.path.exists(folder + "/CMakeLists.txt"):
        os.makedirs(folder, exist_ok=True)
        files = subprocess.run(["git", "-C", ROOT, "ls-files", "-co", "--exclude-standard"], capture_output=True, text=True,
                               check=True).stdout.split("\n")
        for file in filter(None, files):
            os.makedirs(os.path.dirname(f"{folder}/{file}"), exist_ok=True)
            shutil.copy2(f"{ROOT}/{file}", f"{folder}/{file}")
    if not options.reuse:
        with open(folder + "/modules/mutation.h", "w", encoding="utf-8") as file:
            file.write(HEADER)
        subprocess.run(["cmake", "--preset", "release"], cwd=folder, check=True, stdout=subprocess.DEVNULL)
    build = folder + "/build/release"
    if not options.reuse:
        everything = list(candidates(ROOT))
        random.Random(options.seed).shuffle(everything)
        print(f"{len(everything)} places in modules/", flush=True)
        targets = ["grtx", "modules_tests"] + (["rtl_tlm_tests"] if options.last else [])
        built(folder, dict(enumerate(everything[:options.count], 1)), everything[options.count:], options.jobs, targets)
    first = {"regress": [build + "/grtx", "regress", "data/traces"], "modules_tests": [build + "/tests/modules_tests", "--gtest_fail_fast"]}
    last = {name: [build + "/tests/rtl_tlm_tests", "--gtest_fail_fast", "--gtest_filter=" + LAST[name]]
            for name in names}
    for name, command in {**first, **last}.items():
        if notices(command, 0, folder, 900):
            sys.exit(f"{name} fails without a mutant")
    mutants = mutants_of(folder)
    noticed, left = collections.Counter(), []

    def of(tests, seconds):
        def one(number):
            return number, next((name for name, command in tests.items() if notices(command, number, folder, seconds)), None)
        return one
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        for number, by in pool.map(of(first, 120), mutants):
            if by:
                noticed[by] += 1
            else:
                left.append(number)
        print(f"{len(mutants)} mutants, {len(left)} go on: " + ", ".join(f"{n} noticed by {name}" for name, n in noticed.items()),
              flush=True)
        survivors = []
        for number, by in pool.map(of(last, 400), left):
            file, line, what = mutants[number]
            if by:
                noticed[by] += 1
                continue
            survivors.append({"file": file, "line": line, "what": what})
            with open(f"{ROOT}/{file}", encoding="utf-8") as source:
                text = source.read().split("\n")[line - 1].strip()
            print(f"SURVIVES {number}: {file}:{line}: {what}: {text}", flush=True)
    with open(folder + "/survivors.json", "w", encoding="utf-8") as file:
        json.dump(survivors, file, indent=1)
    print(f"{len(mutants)} mutants: {len(survivors)} noticed by none, " +
          ", ".join(f"{n} by {name}" for name, n in noticed.items()))


if __name__ == "__main__":
    main()
