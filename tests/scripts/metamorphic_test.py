# SPDX-License-Identifier: Apache-2.0
"""scripts/metamorphic.py notices what it looks for: metamorphic_test.py GRTX

Of each relation a case is run. Then every value that it compares is altered, one at a time, as if the program had given
that: the relation must not hold any more.
"""
import io
import math
import os
import random
import shutil
import stat
import subprocess
import sys
import tempfile
import unittest
from contextlib import redirect_stdout

SCRIPTS = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scripts"))
sys.path.insert(0, SCRIPTS)
import metamorphic  # noqa: E402
from relations import RELATIONS, Image, gaussians, laws, resources, sweeps  # noqa: E402
from relations.case import decibels, differences  # noqa: E402

PROGRAM = os.path.abspath(sys.argv[1])


def altered(value):
    """Other values of the same kind."""
    if isinstance(value, bool) or value is None:
        yield not value
    elif isinstance(value, (int, float)):
        yield from (value * 3 + 1, (value - 1) / 3)
    elif isinstance(value, str):
        yield value + "x"
    elif isinstance(value, bytes):
        yield value[:-1] + bytes([value[-1] ^ 1]) if value else b"x"
    elif isinstance(value, Image):
        yield Image(value.width, value.height, (value.values[0] + 1, *value.values[1:]))
        yield Image(value.width, value.height, tuple(v + 1 for v in value.values))  # a pixel may be what is allowed
    elif isinstance(value, list):
        yield from (value[:i] + [other] + value[i + 1:] for i, entry in enumerate(value) for other in altered(entry))
        yield value + [0]
    elif isinstance(value, dict):
        yield from ({**value, key: other} for key, entry in value.items() for other in altered(entry))


class EachRelation(unittest.TestCase):
    def setUp(self):
        self.top = os.path.realpath(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.top)

    def honest(self, relation):
        """A case that holds and has compared something: its seed, folder, runs and the values that it compared."""
        for seed in range(1, 9):
            folder, values = f"{self.top}/{relation.name}_{seed}", []
            os.mkdir(folder)
            case, wrong = metamorphic.run_case(relation, PROGRAM, seed, folder, alter=lambda n, v, all=values: all.append(v) or v)
            if wrong == "" and values:
                return seed, folder, case.runs, values
        self.fail(f"{relation.name} holds for no seed: {wrong}")

    def test_every_value_that_it_compares_matters(self):
        for relation in RELATIONS.values():
            with self.subTest(relation=relation.name):
                seed, folder, runs, values = self.honest(relation)

                def again(number=None, other=None):
                    return metamorphic.run_case(relation, PROGRAM, seed, folder, earlier=runs,
                                                alter=lambda n, value: other if n == number else value)[1]

                self.assertEqual(again(), "", "files of two runs need two names")
                for number, value in enumerate(values):
                    self.assertTrue(any(again(number, other) for other in altered(value)), f"seed {seed}, value {number}")

    def test_each_says_what_it_is(self):
        for relation in RELATIONS.values():
            self.assertRegex(relation.check.__doc__ or "", r"\A\S.*\.\Z", relation.name)


class Laws(unittest.TestCase):
    """Each term of each law counts: one more or less of it is noticed."""

    def test_every_term_counts(self):
        names = {"<region>": "tlas", "<n>": "0", "<any>": "retire"}
        for law in laws.LAWS.strip().splitlines():
            whole, parts = law.split(" = ")
            terms = []
            for term in parts.split(" + "):
                for mark, name in names.items():
                    term = term.replace(mark, name)
                terms.append(term)
            values = {f"gpu.{term}": 5 for term in terms}
            values[f"gpu.{whole}"] = 5 * len(terms)
            for changed in values:
                found = [(w, p) for text, w, p in laws.law_terms({**values, changed: values[changed] + 1}) if text == law]
                self.assertNotEqual(*found[0], f"{law}: {changed}")
            found = [(w, p) for text, w, p in laws.law_terms(values) if text == law]
            self.assertEqual(*found[0], law)


class Parts(unittest.TestCase):
    def test_decibels_are_those_of_compare(self):
        black, grey = Image(2, 1, (0.0,) * 6), Image(2, 1, (0.1,) * 6)
        self.assertEqual(decibels(black, black), math.inf)
        self.assertAlmostEqual(decibels(black, grey), 20.0)
        self.assertEqual(decibels(grey, Image(2, 1, (5.0,) * 6)), decibels(grey, Image(2, 1, (1.0,) * 6)))  # clamped

    def test_differences_name_the_place(self):
        self.assertEqual(list(differences({"a": {"b": 1}}, {"a": {"b": 2}, "c": 3})), ["a: b: 1 and 2", "c is in the second alone"])
        self.assertEqual(list(differences(Image(2, 1, (0.0,) * 6), Image(2, 1, (0.0, 0.0, 0.0, 1.0, 0.0, 0.0)))),
                         ["pixel 1, 0 (0.0, 0.0, 0.0) and (1.0, 0.0, 0.0)"])
        self.assertEqual(list(differences(math.nan, math.nan)), ["nan and nan"])
        self.assertEqual(list(differences({"a": math.nan}, {"a": math.nan})), [])

    def test_harmonics_turn_with_the_scene(self):
        turn = gaussians.matrix_of([0.5, 0.5, 0.5, 0.5])  # x to y, y to z, z to x
        rng = random.Random(1)
        sh = [[1.0] * 3, [0.0] * 3, [1.0] * 3, [0.0] * 3]  # of z
        turned = gaussians.turned_harmonics(turn, rng)(sh)
        for found, expected in zip(turned, [[1.0] * 3, [0.0] * 3, [0.0] * 3, [-1.0] * 3]):  # of x, whose sign 3DGS turns
            for a, b in zip(found, expected):
                self.assertAlmostEqual(a, b)

    def test_a_table_of_a_report_is_read(self):
        page = ('<table id="sweep1_points">\n<thead><tr><th scope="col" class="n">point</th><th scope="col">mm²</th></tr></thead>'
                '<tr data-id="1"><th scope="row" class="n">#1</th><td class="n">1,234</td></tr></table>')
        self.assertEqual(sweeps.page_points(page), {"#1": {"point": "#1", "mm²": "1,234"}})
        self.assertEqual((sweeps.shown(0.123456), sweeps.shown(1234.4), sweeps.shown(12.0)), ("0.1235", "1,234", "12"))

    def test_every_key_with_a_number_is_a_resource_or_named(self):
        keys = {key.name for key in resources.keys_of(PROGRAM) if not key.names}
        known = resources.resources(PROGRAM)
        self.assertEqual(sorted(keys - {*known, *resources.NOT_A_RESOURCE}), [], "resources.py must know what more of it does")
        self.assertEqual(sorted({*resources.NOT_A_RESOURCE, *resources.MAY_BE_SLOWER, *resources.CAPACITIES} - keys), [])
        self.assertEqual(sorted({*resources.NOT_A_RESOURCE} & {*known}), [])


class Script(unittest.TestCase):
    def test_a_program_that_lies_is_found_with_its_commands(self):
        """One that gives a hit too many to every file of statistics."""
        with tempfile.TemporaryDirectory() as folder:
            liar = f"{folder}/liar"
            with open(liar, "w", encoding="utf-8") as file:
                file.write(f"#!{sys.executable}\nimport re, subprocess, sys\n"
                           f"code = subprocess.run(['{PROGRAM}', *sys.argv[1:]]).returncode\n"
                           "if sys.argv[1] == 'sim' and '--stats' in sys.argv:\n"
                           "    name = sys.argv[sys.argv.index('--stats') + 1]\n"
                           "    text = open(name).read()\n"
                           "    more = lambda m: m[1] + str(int(m[2]) + 1)\n"
                           "    open(name, 'w').write(re.sub(r'(\"gpu.l1.all.hits\":\\s*{\\s*\"value\":\\s*)(\\d+)', more, text))\n"
                           "sys.exit(code)\n")
            os.chmod(liar, os.stat(liar).st_mode | stat.S_IXUSR)
            done = subprocess.run([sys.executable, "-B", f"{SCRIPTS}/metamorphic.py", "--program", liar, "--only", "counts_add_up",
                                   "--cases", "1", "--keep", f"{folder}/kept"], capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, 1, done.stderr)
            lines = done.stdout.splitlines()
            self.assertRegex(lines[0], r"counts_add_up, seed 1: l1.all.reads = l1.all.hits .*: \d+ and \d+")
            self.assertTrue(lines[1].strip().startswith("grtx synth "), lines[1])
            self.assertEqual(lines[-1], "0 passed, 1 failed")
            self.assertTrue(os.path.exists(f"{folder}/kept/counts_add_up_1/s.grtx"))

    def test_a_relation_that_does_not_exist_is_refused(self):
        done = subprocess.run([sys.executable, "-B", f"{SCRIPTS}/metamorphic.py", "--only", "nothing"], capture_output=True, text=True,
                              check=False)
        self.assertEqual((done.returncode, "there is no relation nothing" in done.stderr), (2, True))

    def test_all_passed_is_0(self):
        count = metamorphic.Count()
        count.cases = 3
        with redirect_stdout(io.StringIO()) as printed:
            self.assertEqual(metamorphic.table({"one": count}), 0)
        self.assertTrue(printed.getvalue().endswith("3 passed, 0 failed\n"))


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0]])
