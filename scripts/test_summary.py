#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What a run of the tests was: a line a label, every test that was skipped with its reason, every test that failed.

    test_summary.py RESULTS.xml TESTS.json      as ctest --output-junit and ctest --show-only=json-v1 write them

Exit code 1 if a test failed or none ran.
"""
import json
import re
import sys
import xml.etree.ElementTree as ElementTree

# How a test says why it is skipped: Google Test's GTEST_SKIP(), or a line "skipped: ..." of a script that ends with 77.
REASON = re.compile(r"^\S+:\d+: Skipped\n(.+?)$|^(?:\S+: )?skipped: (.+)$", re.M | re.I)


def labels(path):
    """Label of every test, by name."""
    with open(path, encoding="utf-8") as file:
        tests = json.load(file)["tests"]
    return {test["name"]: p["value"][0] for test in tests for p in test.get("properties", []) if p["name"] == "LABELS"}


def read(path, label):
    """(name, label, state, seconds, output) of every test."""
    for case in ElementTree.parse(path).getroot().iter("testcase"):
        state = {"run": "passed", "notrun": "skipped", "disabled": "skipped"}.get(case.get("status"), "failed")
        name = case.get("name")
        yield name, label.get(name, "others"), state, float(case.get("time", 0)), case.findtext("system-out") or ""


def reason(output):
    found = REASON.search(output)
    if found:
        return next(text for text in found.groups() if text).strip()
    last = [line.strip() for line in output.splitlines() if line.strip()]
    return last[-1] if last else "it does not say why"


def summary(tests):
    lines = []
    lines.append(f"{'part':<10}{'passed':>8}{'skipped':>9}{'failed':>8}{'seconds':>9}")
    for label in sorted({test[1] for test in tests}) + ["all"]:
        own = [test for test in tests if label in (test[1], "all")]
        count = {state: sum(test[2] == state for test in own) for state in ("passed", "skipped", "failed")}
        lines.append(f"{label:<10}{count['passed']:>8}{count['skipped']:>9}{count['failed']:>8}{sum(t[3] for t in own):>9.0f}")
    skipped = {}
    for name, _, state, _, output in tests:
        if state == "skipped":
            skipped.setdefault(reason(output), []).append(name)
    for why, names in sorted(skipped.items(), key=lambda item: item[1][0]):
        lines.append(f"skipped: {names[0]}" + (f" and {len(names) - 1} more" if len(names) > 1 else "") + f": {why}")
    lines += [f"FAILED: {name}" for name, _, state, _, _ in tests if state == "failed"]
    return lines


def main(results, names):
    tests = list(read(results, labels(names)))
    print("\n".join(summary(tests)))
    return 1 if not tests or any(state == "failed" for _, _, state, _, _ in tests) else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2]))
