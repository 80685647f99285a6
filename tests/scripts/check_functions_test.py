#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""scripts/check_functions.py finds a long function, however its head is broken over lines, and no table of data."""
import os
import subprocess
import sys
import tempfile
import unittest

SCRIPT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scripts", "check_functions.py")
HEADS = {"one line": "int f(int a) {",
         "two lines": "int f(int a,\n      int b) {",
         "constructor": "Unit::Unit(int a)\n    : a_(a),\n      b_(2) {"}


class CheckFunctions(unittest.TestCase):
    def check(self, text):
        with tempfile.TemporaryDirectory() as top:
            os.makedirs(os.path.join(top, "modules", "kernel"))
            with open(os.path.join(top, "modules", "kernel", "unit.cpp"), "w", encoding="utf-8") as file:
                file.write(text)
            return subprocess.run([sys.executable, SCRIPT, top], capture_output=True, text=True).stdout

    def test_a_body_of_61_lines_is_found_and_one_of_60_is_not(self):
        for name, head in HEADS.items():
            with self.subTest(name):
                text = "namespace n {\n\n" + head + "\n" + "  g();\n" * 60
                self.assertEqual(self.check(text + "}\n\n}  // namespace n\n"), "")
                line = 3 + head.count("\n")
                self.assertIn(f"unit.cpp:{line}: a body of 61 lines", self.check(text + "  g();\n}\n\n}  // namespace n\n"))

    def test_a_lambda_has_a_body_of_its_own(self):
        text = "int f() {\n  return g(\n      [](int a) -> int {\n" + "        h();\n" * 61 + "      },\n      1);\n}\n"
        self.assertIn("unit.cpp:3: a body of 61 lines", self.check(text))

    def test_a_table_may_be_long(self):
        self.assertEqual(self.check("constexpr int kTable[] = {\n" + "    1,\n" * 99 + "};\n"), "")


if __name__ == "__main__":
    unittest.main()
