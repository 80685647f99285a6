#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""scripts/check_licence.py finds a file without its licence line, and --fix writes it below `#!`."""
import os
import shutil
import subprocess
import sys
import tempfile
import unittest

SCRIPT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scripts", "check_licence.py")
LINE = "SPDX-License-Identifier: Apache-2.0"


class CheckLicence(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.top = folder.name
        os.mkdir(os.path.join(self.top, "scripts"))
        shutil.copy(SCRIPT, os.path.join(self.top, "scripts"))  # it looks below its parent's folder

    def write(self, name, text):
        with open(os.path.join(self.top, name), "w", encoding="utf-8") as stream:
            stream.write(text)

    def read(self, name):
        with open(os.path.join(self.top, name), encoding="utf-8") as stream:
            return stream.read()

    def check(self, *arguments):
        script = os.path.join(self.top, "scripts", "check_licence.py")
        return subprocess.run([sys.executable, script, *arguments], capture_output=True, text=True)

    def test_files_without_the_line_are_named_and_mended(self):
        self.write("good.h", f"// {LINE}\n#pragma once\n")
        self.write("bad.cpp", "int one() { return 1; }\n")
        self.write("tool.py", "#!/usr/bin/env python3\nprint(1)\n")
        self.write("notes.md", "No source.\n")
        found = self.check()
        self.assertEqual(found.returncode, 1)
        self.assertEqual([line.split(":")[0] for line in found.stdout.splitlines()], ["bad.cpp", "tool.py"])
        self.assertEqual(self.check("--fix").returncode, 0)
        self.assertEqual(self.read("tool.py"), f"#!/usr/bin/env python3\n# {LINE}\nprint(1)\n")
        self.assertEqual(self.read("good.h"), f"// {LINE}\n#pragma once\n")
        self.assertEqual(self.check().returncode, 0)


if __name__ == "__main__":
    unittest.main()
