#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""bench/evaluate on its tiny set: pages are well formed and pass the check of their tables, a second run simulates nothing and changes
nothing, a part alone keeps the rows of the others, and bad requests are one line.

    evaluate_test.py GRTX
"""
import csv
import json
import os
import re
import shutil
import sqlite3
import subprocess
import sys
import tempfile
import tomllib
import unittest

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
PROGRAM = ""
PARTS = ("who-128", "who-full", "secondary", "cards", "l2", "steps", "paper-128", "paper-full", "lean")


def tables(text):
    return [block.splitlines() for block in re.findall(r"(?:^\|.*\n)+", text, re.M)]


class Evaluate(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.work = folder.name
        cls.first = cls.evaluate()

    @classmethod
    def evaluate(cls, *more):
        return subprocess.run([sys.executable, "-B", os.path.join(ROOT, "bench", "evaluate"), "--quick", "--work", cls.work, "--program", PROGRAM,
                               *more], capture_output=True, text=True, check=False)

    def path(self, *names):
        return os.path.join(self.work, *names)

    def read(self, *names):
        with open(self.path(*names), encoding="utf-8") as file:
            return file.read()

    def written(self):
        return {os.path.join(folder, name): self.read(folder, name) for folder, _, names in os.walk(self.path("tree")) for name in names}

    def rows(self):
        with open(self.path("tree", "docs", "results", "data", "evaluation.csv"), encoding="utf-8", newline="") as file:
            return list(csv.DictReader(file))

    def test_every_point_of_every_part_is_a_row_that_says_what_it_is_of(self):
        self.assertEqual(self.first.returncode, 0, self.first.stderr)
        rows = self.rows()
        self.assertEqual({row["part"] for row in rows}, set(PARTS))
        for row in rows:
            self.assertTrue(int(row["cycles"]) > 0 and float(row["energy_nj_per_ray"]) > 0 and row["mode"] and row["machine"], row)
            self.assertRegex(row["set"] + row["model"], r"^[0-9a-f]{8}\d+$")
        with open(os.path.join(ROOT, "bench", "evaluate", "designs.toml"), "rb") as file:
            designs = tomllib.load(file)["design"]
        self.assertEqual({row["design"] for row in rows if row["part"] == "who-128"}, {design["name"] for design in designs if {"who", "who-128"} & set(design["tables"])})
        base, walk = ([int(row["cycles"]) for row in rows if (row["part"], row["design"], row["k"]) == ("who-128", name, "16")]
                      for name in ("baseline", "walk"))
        self.assertTrue(all(one > other for one, other in zip(base, walk)))

    def test_walk_and_the_papers_designs_are_said_once(self):
        with open(os.path.join(ROOT, "bench", "evaluate", "designs.toml"), "rb") as file:
            designs = {design["name"]: design for design in tomllib.load(file)["design"]}
        for name in ("baseline", "sw", "hw", "grtx", "gautracer", "walk"):  # explore/sweep/designs.cpp says what they are
            self.assertEqual((designs[name]["keys"], set(designs[name].get("parts", [])) - {"wide"}), ({"design": name}, set()))

    def test_pages_are_well_formed(self):
        made = 0
        for name, text in self.written().items():
            for part in re.findall(r"<!-- generated: scripts/readme_tables\.py \S+ -->\n(.*?)<!-- end of generated -->", text, re.S):
                for table in tables(part):
                    self.assertEqual(len({line.count("|") for line in table}), 1, f"{name}: {table[0]}")
                    self.assertTrue(set(table[1]) <= set("|-"), table[1])
                made += "(Scenes `" in part
            self.assertNotIn("nan", text)
        self.assertGreaterEqual(made, 5)
        check = subprocess.run([sys.executable, "-B", "-c", f"""
import sys
sys.path.insert(0, {os.path.join(ROOT, 'scripts')!r})
import docs_prose, evaluation_tables, readme_tables
for page in ("README", "rivals", "bounds", "scene-classes", "checkpoints"):
    with open({self.path('tree')!r} + "/docs/results/" + page + ".md", encoding="utf-8") as file:
        print(*docs_prose.breaches(file.read()))
print("\\n".join([*evaluation_tables.faults({self.path('tree')!r}), *readme_tables.faults({self.path('tree')!r})]))"""],
                               capture_output=True, text=True, check=True)
        self.assertEqual(check.stdout.strip(), "")
        self.assertRegex(self.read("tree", "docs", "results", "rivals.md"), r"\n\| scenes \| \[evaluation\.toml\]\([./\w]+\), [0-9a-f]{8} \|\n")

    def test_a_second_run_simulates_nothing_and_changes_nothing(self):
        def ended():
            with sqlite3.connect(self.path("who-128", "paper-charged.sqlite")) as database:
                return database.execute("SELECT id, key, seconds FROM point ORDER BY id").fetchall()
        before = self.written(), ended()
        again = self.evaluate()
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assertEqual((self.written(), ended()), before)
        self.assertNotIn("points each", again.stderr)

    def test_a_part_alone_keeps_the_rows_of_the_others(self):
        before = self.rows()
        self.assertEqual(self.evaluate("--only", "secondary").returncode, 0)
        self.assertEqual(self.rows(), before)

    def test_the_plan_runs_nothing(self):
        before = os.listdir(self.work)
        plan = self.evaluate("--plan", "--only", "who-128")
        self.assertEqual(plan.returncode, 0, plan.stderr)
        self.assertRegex(plan.stdout, r"who-128 +paper-charged +(\d+) +\1 +0\.00\ntogether +0\.00 of at most 8\n$")
        self.assertEqual(os.listdir(self.work), before)

    def test_the_set_of_scenes(self):
        with open(os.path.join(ROOT, "configs", "scenes", "evaluation.toml"), "rb") as file:
            scenes = tomllib.load(file)
        with open(os.path.join(ROOT, "configs", "scenes", "scenes.txt"), encoding="utf-8") as file:
            public = {line.split()[0] for line in file if line[0] != "#"}
        views = scenes["view"] + scenes["quick"]
        self.assertEqual({view["scene"] for view in views if "preset" not in view}, public)
        seeds = [view["seed"] for view in views if "preset" in view]
        self.assertEqual(len(set(seeds)), len(seeds))
        for view in views:
            self.assertIn(view["class"], ("room", "building", "object"))
            if "preset" not in view:
                with open(os.path.join(ROOT, "configs", "scenes", view["scene"] + ".cameras.json"), encoding="utf-8") as file:
                    self.assertLess(view["view"], len(json.load(file)))

    def test_a_view_that_shows_was_not_chosen_on(self):
        sys.path.insert(0, os.path.join(ROOT, "bench", "evaluate"))
        import plans  # pylint: disable=import-outside-toplevel
        views = plans.read(os.path.join(ROOT, plans.SET))["view"]
        self.assertEqual(plans.check_roles(views), views)
        self.assertGreaterEqual(len({view["scene"] for view in views if view["role"] == "show" and view["class"] == "room" and "preset" not in view}), 3)
        view = {"scene": "hall", "view": 3}
        for own, rule in (({"role": "show", "tuned": ["walk: k"]}, "role is \"show\": must be choose, since it has tuned"),
                          ({"role": "show", "tuned": ["walk: k"], "fitted": ["paper"]}, "must be choose, since it has tuned and fitted"),
                          ({"role": "choose"}, "role is \"choose\": must be show, since it has neither tuned nor fitted"),
                          ({"role": "shown"}, "role is \"shown\": must be show"), ({}, "role is \"missing\": must be show")):
            with self.assertRaises(plans.BadSet, msg=own) as refused:
                plans.check_roles([view | own])
            self.assertTrue(str(refused.exception).startswith("configs/scenes/evaluation.toml: hall-3: role is "), own)
            self.assertIn(rule, str(refused.exception))

    def test_cards_are_compared_where_nothing_was_chosen_each_design_at_its_recommended_k(self):
        sys.path.insert(0, os.path.join(ROOT, "bench", "evaluate"))
        import plans  # pylint: disable=import-outside-toplevel
        cards = next(part for part in plans.PARTS if part.name == "cards")
        views = plans.views(cards, False)
        self.assertEqual({view["role"] for view in views}, {"show"})
        self.assertGreaterEqual({(view["class"], "preset" in view) for view in views}, {("room", False), ("object", False)})
        sizes = {}
        for design, k in plans.points(cards, "ada-share", False):
            sizes.setdefault(design, []).append(k)
        for design in ("baseline", "sw", "hw", "grtx", "gautracer", "walk"):
            done = subprocess.run([PROGRAM, "machine", "paper", "--design", design, "--json"], capture_output=True, text=True, check=True)
            self.assertEqual(sizes[design], [int(json.loads(done.stdout)["keys"]["tracer.k"]["value"])], design)

    def test_k_is_chosen_on_views_that_do_not_show(self):
        sys.path.insert(0, os.path.join(ROOT, "scripts"))
        import evaluation_tables  # pylint: disable=import-outside-toplevel

        def row(view, took_part, design, k, cycles):
            return {"view": view, "class": "room", "generated": "0", "took_part": took_part, "design": design, "k": k, "cycles": cycles,
                    "energy_nj_per_ray": 1}
        rows = [row("a-0", "tuned: walk: k", "baseline", 16, 100), row("b-0", "", "baseline", 16, 100),
                row("a-0", "tuned: walk: k", "walk", 48, 20), row("a-0", "tuned: walk: k", "walk", 64, 10),
                row("b-0", "", "walk", 48, 10), row("b-0", "", "walk", 64, 25)]
        part = evaluation_tables.Part(rows)
        self.assertEqual((part.best("walk"), part.heading("rooms")), (64, "rooms, 1"))
        self.assertAlmostEqual(part.mean("walk", 64, "rooms"), 4.0)
        alone = evaluation_tables.Part([own for own in rows if own["took_part"]])
        self.assertEqual(alone.heading("rooms"), "rooms, 1 (k is chosen on them)")
        self.assertAlmostEqual(alone.mean("walk", 64, "rooms"), 10.0)

    def test_views_that_show_have_the_k_that_the_others_chose_and_no_more(self):
        for folder in (os.path.join("bench", "evaluate"), "scripts"):
            sys.path.insert(0, os.path.join(ROOT, folder))
        import evaluation_tables  # pylint: disable=import-outside-toplevel
        import plans  # pylint: disable=import-outside-toplevel
        choose, show = (part for part in plans.PARTS if part.name == "who-128")
        labels = [[plans.label(view) for view in plans.views(part, False)] for part in (choose, show)]
        whole = plans.Part("who-128", "who", choose.machines, "cycle", 48, 128, 1)
        self.assertEqual(sorted(sum(labels, [])), sorted(map(plans.label, plans.views(whole, False))))
        scanned, shown = (plans.points(part, "paper-charged", False) for part in (choose, show))
        self.assertLess(set(shown), set(scanned))
        measured = evaluation_tables.part(evaluation_tables.load(ROOT), "who-128")
        for design, first in measured.first.items():
            self.assertLessEqual({(design, first), (design, measured.best(design))}, set(shown), design)

    def test_all_parts_take_no_more_hours_than_the_plan_says(self):
        sys.path.insert(0, os.path.join(ROOT, "bench", "evaluate"))
        import plans  # pylint: disable=import-outside-toplevel
        hours = sum(len(plans.views(part, False)) * len(plans.points(part, machine, False)) * part.seconds / 2 / 3600
                    for part in plans.PARTS for machine in part.machines)
        self.assertLessEqual(hours, plans.HOURS)
        self.assertEqual({part.mode for part in plans.PARTS}, {"cycle"})

    def test_a_wrong_role_stops_the_evaluation_in_one_line(self):
        with tempfile.TemporaryDirectory() as tree:
            for folder in ("bench", "scripts", os.path.join("configs", "scenes")):
                shutil.copytree(os.path.join(ROOT, folder), os.path.join(tree, folder), ignore=shutil.ignore_patterns("__pycache__"))
            path = os.path.join(tree, "configs", "scenes", "evaluation.toml")
            with open(path, encoding="utf-8") as file:
                text = file.read()
            with open(path, "w", encoding="utf-8") as file:
                file.write(text.replace('role = "choose"', 'role = "show"', 1))
            bad = subprocess.run([sys.executable, "-B", os.path.join(tree, "bench", "evaluate"), "--plan", "--program", PROGRAM],
                                 capture_output=True, text=True, check=False)
        self.assertEqual((bad.returncode, bad.stdout), (2, ""))
        self.assertRegex(bad.stderr.splitlines()[-1], r"evaluation\.toml: wang_sha-1: role is \"show\": must be choose")

    def test_bad_requests_are_one_line(self):
        for arguments, rule in ((("--only", "everything"), "invalid choice"), (("--program", "/no/grtx"), "no program")):
            bad = self.evaluate(*arguments)
            self.assertEqual(bad.returncode, 2)
            self.assertIn(rule, bad.stderr.splitlines()[-1])


if __name__ == "__main__":
    PROGRAM = os.path.abspath(sys.argv.pop(1))
    unittest.main()
