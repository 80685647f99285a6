#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""scripts/check_format.py finds a line that is not as clang-format writes it, and says when it cannot look."""
import os
import shutil
import stat
import subprocess
import sys
import tempfile
import unittest

SCRIPT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scripts", "check_format.py")


class CheckFormat(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        top = os.path.join(os.path.dirname(SCRIPT), "..")
        shutil.copy(os.path.join(top, ".clang-format"), self.folder)  # clang-format looks for it upward from the file

    def write(self, name, text):
        path = os.path.join(self.folder, name)
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
        return path

    def check(self, *arguments, path=None):
        environment = {**os.environ, "PATH": path} if path else None
        return subprocess.run([sys.executable, SCRIPT, *arguments], capture_output=True, text=True, env=environment)

    def test_a_planted_line_is_found_and_fixed(self):
        good = self.write("good.cpp", "int one() { return 1; }\n")
        bad = self.write("bad.cpp", "int one() { return 1; }\nint  two( ){return 2;}\n")
        run = self.check(good, bad)
        if run.returncode == 77:
            self.skipTest(run.stdout)
        self.assertEqual(run.returncode, 1, run.stdout + run.stderr)
        self.assertRegex(run.stdout, r"^\S*bad\.cpp:2: is not as clang-format writes it .*\n$")
        self.assertEqual(self.check("--fix", bad).returncode, 0)
        self.assertEqual(self.check(good, bad).returncode, 0)

    def test_another_version_is_named_and_skipped(self):
        tool = self.write("clang-format", "#!/bin/sh\necho 'clang-format version 19.1.0'\n")
        os.chmod(tool, os.stat(tool).st_mode | stat.S_IXUSR)
        run = self.check(self.write("bad.cpp", "int  two( ){return 2;}\n"), path=self.folder + ":/nowhere")
        self.assertEqual(run.returncode, 77)
        self.assertIn("clang-format 14 is needed and there is clang-format version 19.1.0", run.stdout)


if __name__ == "__main__":
    unittest.main()
