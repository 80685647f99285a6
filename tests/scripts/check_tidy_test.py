#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""scripts/check_tidy.py passes on what clang-tidy finds, and passes a file without findings."""
import os
import subprocess
import sys
import tempfile
import unittest

SCRIPT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scripts", "check_tidy.py")
SOUND = "struct Base {\n  virtual ~Base() = default;\n  virtual int one() = 0;\n};\n"


class CheckTidy(unittest.TestCase):
    def check(self, text):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "planted.cpp")
            with open(path, "w", encoding="utf-8") as file:
                file.write(text)
            run = subprocess.run([sys.executable, SCRIPT, path], capture_output=True, text=True)
        if run.returncode == 77:
            self.skipTest(run.stdout)
        return run

    def test_a_sound_file(self):
        run = self.check(SOUND + "struct One : Base {\n  int one() override { return 1; }\n};\n")
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
        self.assertIn("1 sources, 0 with findings", run.stdout)

    def test_a_planted_fault_is_named_with_its_line(self):
        run = self.check(SOUND + "struct One : Base {\n  int one() { return 1; }\n};\n")
        self.assertEqual(run.returncode, 1, run.stdout + run.stderr)
        self.assertIn("planted.cpp:6:7: error:", run.stdout)
        self.assertIn("modernize-use-override", run.stdout)


if __name__ == "__main__":
    unittest.main()
