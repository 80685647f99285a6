#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""scripts/check_licence.py finds a file without its licence line, of all that git lists or that lie there, and --fix writes it below `#!`."""
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
        os.makedirs(os.path.dirname(os.path.join(self.top, name)), exist_ok=True)
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

    def named(self):
        found = self.check()
        self.assertEqual(found.returncode, 1 if found.stdout else 0, found.stderr)
        return [line.split(":")[0] for line in found.stdout.splitlines()]

    def test_every_kind_of_file(self):
        kinds = {"a.h": "//", "cmake/a.cpp.in": "//", "a.sv": "//", "web/a.mjs": "//", "a.awk": "#", "a.cmake": "#", "cmake/a.cmake.in": "#",
                 "cmake/a.pc.in": "#", "bench/a.toml": "#", "a.supp": "#", "CITATION.cff": "#", "Containerfile": "#",
                 ".devcontainer/Dockerfile": "#", "docs/api/Doxyfile": "#", ".github/workflows/a.yml": "#", ".ci/run": "#", ".gitignore": "#",
                 "builder/CMakeLists.txt": "#", "rtl_tlm/data/a.py": "#"}
        for name in kinds:
            self.write(name, "text\n")
        self.assertEqual(self.named(), sorted(kinds))
        self.check("--fix")
        for name, comment in kinds.items():
            self.assertEqual(self.read(name), f"{comment} {LINE}\ntext\n", name)
        self.assertEqual(self.named(), [])

    def test_what_is_exempt(self):
        for name in ("data/traces/a.toml", "tests/data/a.py", "configs/scenes/a.toml", "docs/a.md", "docs/results/data/a.csv", "a.json",
                     "docs/a.svg", "LICENSE"):
            self.write(name, "text\n")
        for folder in ("build/release", "out", "modules/__pycache__", ".cache"):
            self.write(folder + "/a.py", "text\n")
        self.assertEqual(self.named(), [])

    def test_a_line_elsewhere_is_none(self):
        self.write("late.py", f"import os\n# {LINE}\n")
        self.write("other.h", "// SPDX-License-Identifier: MIT\n")
        self.assertEqual(self.named(), ["late.py", "other.h"])

    @unittest.skipUnless(shutil.which("git"), "git is not installed")
    def test_what_git_lists_is_the_project(self):
        for name in ("mine.py", "theirs.py", "notes.txt", "theirs.txt"):
            self.write(name, "text\n")
        self.assertEqual(self.named(), ["mine.py", "theirs.py"])  # without git
        for command in (("init", "-q"), ("add", "mine.py", "notes.txt", "scripts")):
            subprocess.run(["git", "-C", self.top, *command], check=True)
        unknown = "notes.txt:1: a kind of file that COMMENTS and EXEMPT of scripts/check_licence.py lack\n"
        self.assertEqual(self.check().stdout, f"mine.py:1: no line '{LINE}'\n{unknown}")
        fixed = self.check("--fix")
        self.assertEqual((fixed.returncode, fixed.stdout), (1, f"check_licence: 1 files written\n{unknown}"))
        self.assertEqual((self.read("notes.txt"), self.read("theirs.py")), ("text\n", "text\n"))


if __name__ == "__main__":
    unittest.main()
