#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""docs/guide/python.md: its examples run, and its tables have every function, with the parameters that it takes.

    python_guide_test.py GRTX       Exit code 77: a Python package is missing.
"""
import contextlib
import inspect
import io
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
sys.path.insert(0, os.path.join(ROOT, "python"))
try:
    import matplotlib
    matplotlib.use("Agg")
    import grtx_tlm
    from grtx_tlm import plots
except ImportError as error:
    print(f"skipped: {error}; Debian packages: python3-numpy python3-pandas python3-matplotlib")
    sys.exit(77)

PROGRAM = ""
PLAN = """mode = "cycle"
designs = ["baseline", "grtx"]
[[scene]]
file = "room.ply"
cameras = "room.cameras.json"
width = 8
height = 8
"""
with open(os.path.join(ROOT, "docs", "guide", "python.md"), encoding="utf-8") as page:
    GUIDE = page.read()


class Guide(unittest.TestCase):
    def test_its_examples_run(self):
        examples = re.findall(r"^```python\n(.*?)^```", GUIDE, re.M | re.S)
        self.assertGreater(len(examples), 2)
        before = os.getcwd()
        with tempfile.TemporaryDirectory() as folder:
            def grtx(*arguments):
                subprocess.run([PROGRAM, *arguments, "--quiet"], cwd=folder, check=True, capture_output=True)
            grtx("synth", "--preset", "object", "--count", "400", "--seed", "1", "-o", "room.ply")
            grtx("run", "--scene", "room.ply", "--cameras", "room.cameras.json", "--width", "8", "--height", "8", "--mode",
                 "cycle", "-o", "out")
            shutil.copy(os.path.join(folder, "out", "grtx.grtx"), os.path.join(folder, "room.grtx"))
            with open(os.path.join(folder, "plan.toml"), "w", encoding="utf-8") as file:
                file.write(PLAN)
            grtx("sweep", "plan.toml", "-o", "pizza.sqlite")
            with open(os.path.join(folder, "plan.toml"), "a", encoding="utf-8") as file:
                file.write("[grid]\ntracer.k = [8, 16]\n")
            grtx("sweep", "plan.toml", "-o", "rounds.sqlite")
            os.environ["GRTX"] = PROGRAM
            try:
                os.chdir(folder)
                names = {}
                for example in examples:
                    with self.subTest(example), contextlib.redirect_stdout(io.StringIO()) as said:
                        exec(compile(example, "python.md", "exec"), names)
                    self.assertEqual(bool(said.getvalue()), "print(" in example)
            finally:
                os.chdir(before)

    def test_its_tables_have_every_function_as_it_is(self):
        told = {}
        for call in re.findall(r"^\| `([\w.]+\(.*?\))` \|", GUIDE, re.M):
            name, inside = call[:-1].split("(", 1)
            told[name] = re.findall(r"(?:^|, )\**(\w+)(?==|,|$)", re.sub(r"\{.*?\}", "results", inside))
        functions = {name: one for name, one in vars(grtx_tlm).items() if inspect.isfunction(one) and name != "read_trace"}
        functions |= {f"plots.{name}": one for name, one in vars(plots).items() if inspect.isfunction(one) and
                      name.startswith(("plot_", "main_"))}
        self.assertEqual(set(told), set(functions))
        for name, parameters in told.items():
            takes = list(inspect.signature(functions[name]).parameters)
            self.assertEqual([p for p in parameters if p != "options"], takes[:len(parameters) - ("options" in parameters)], name)


if __name__ == "__main__":
    PROGRAM = os.path.abspath(sys.argv.pop(1))
    unittest.main()
