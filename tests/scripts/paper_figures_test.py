#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A number that the paper prints stands in one file: report/page/paper_targets.toml, or claims.toml where no run gives it.

    paper_figures_test.py
"""
import glob
import os
import sys
import tokenize
import unittest

TOP = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
sys.path[:0] = [os.path.join(TOP, "bench"), os.path.join(TOP, "scripts")]
import draw_results  # noqa: E402
from paper import claims  # noqa: E402

TARGETS = [target for kind in claims.read(claims.TARGETS).values() if isinstance(kind, list) for target in kind]
OWN = [entry for entry in claims.read(os.path.join(TOP, "bench", "paper", "claims.toml"))["claim"] if "paper" in entry]


class PaperFigures(unittest.TestCase):
    def test_claims_do_not_have_the_numbers_of_the_targets_once_more(self):
        printed = {target["paper"] for target in TARGETS}
        self.assertEqual([entry["id"] for entry in OWN if entry["paper"] in printed or "target" in entry], [])
        self.assertEqual([entry["id"] for entry in OWN if " over " in entry["source"]], [], "a quotient of printed numbers names both")

    def test_scripts_have_no_list_of_the_papers_numbers_of_their_own(self):
        numbers = {float(entry["paper"]) for entry in TARGETS + OWN} - {2.43}  # so many M Gaussians has a scene, too
        unmistakable = {number for number in numbers if len(str(number)) > 3 and number % 1}
        self.assertTrue({4.36, 5.94} <= unmistakable)
        found = []
        for path in sorted(glob.glob(os.path.join(TOP, "bench", "**", "*.py"), recursive=True) + glob.glob(os.path.join(TOP, "scripts", "*.py"))):
            with open(path, "rb") as file:
                found += [f"{os.path.relpath(path, TOP)}:{token.start[0]}: {token.string}" for token in tokenize.tokenize(file.readline)
                          if token.type == tokenize.NUMBER and token.string.replace(".", "").isdigit() and float(token.string) in unmistakable]
        self.assertEqual(found, [])

    def test_claims_that_refer_have_the_number_they_refer_to(self):
        known = claims.load()
        for name, number in {"speedup-grtx": 4.36, "grtx-over-best": 2.18, "small-fov-hw": 1.94, "fov-trend-sw": 0.715, "storage": 1074}.items():
            self.assertAlmostEqual(known[name].paper, number)
        self.assertIn("consistent", known["small-fov-hw"].source)
        self.assertTrue(known["l1-sw"].bound)

    def test_readings_has_the_figures_that_are_recorded(self):
        with open(os.path.join(TOP, "docs", "results", "readings.md"), encoding="utf-8") as file:
            text = file.read()
        known, recorded = claims.load(), claims.read(os.path.join(TOP, "bench", "paper", "expected.toml"))["quick"]["paper"]
        main = draw_results.table(text, "figure", "the paper", "today", "all four")[:10]
        others = draw_results.table(text, "figure", "the paper", "today", "within 20 %")
        of_main = ("speedup-sw", "speedup-hw", "speedup-grtx", "grtx-over-best", "fetches-grtx", "fetches-hw-on-sw", "latency-grtx", "l2-grtx", "l1-sw",
                   "l1-grtx-over-sw")
        of_others = ("best-k-baseline", "small-fov-sw", "small-fov-hw", "fov-trend-sw", "fov-trend-hw", "hw-secondary-over-primary")
        self.assertEqual((len(main), len(others)), (len(of_main), len(of_others)))
        for name, row in zip(of_main + of_others, main + others):
            digits = len(row["today"].partition(".")[2])
            self.assertEqual(row["today"], f"{recorded[name]:.{digits}f}", name)
        for name, row in zip(of_others, others):
            self.assertEqual(row["within 20 %"], "yes" if known[name].holds(recorded[name]) else "no", name)
        met = [claim.holds(recorded[name]) for name, claim in known.items() if claim.paper is not None and name in recorded]
        self.assertIn(f"meets {sum(met)} of the paper's {len(met)} printed figures", text.replace("\n", " "))


if __name__ == "__main__":
    unittest.main()
