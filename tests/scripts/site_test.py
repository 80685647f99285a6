#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The documentation's site: links that leave docs/, a link that leads nowhere, and what scripts/site.sh refuses. The site itself takes
too long for a test: scripts/site.sh builds it, also for each change on a forge (.github/workflows/docs.yml)."""
import os
import shutil
import subprocess
import sys
import tempfile
import types
import unittest
from unittest import mock

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(ROOT, "docs", "site"))
import links  # noqa: E402


class Site(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.site = folder.name

    def write(self, name, text):
        path = os.path.join(self.site, name)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)

    def test_links_that_leave_the_folder_lead_to_the_forge_or_are_text(self):
        page = types.SimpleNamespace(file=types.SimpleNamespace(src_path="model/gpu.md"))
        text = "[a](dram.md#x) [`b`](../README.md) [c](../../frontend/) [d](https://e.org)\n   * nested"
        rest = "[a](dram.md#x) [`b`](../README.md) {} [d](https://e.org)\n    * nested"
        self.assertEqual(links.on_page_markdown(text, page), rest.format("c"))
        with mock.patch.object(links, "FORGE", "https://f.org/blob/main/"):
            self.assertEqual(links.on_page_markdown(text, page), rest.format("[c](https://f.org/blob/main/frontend)"))

    def test_a_link_that_leads_nowhere_is_named(self):
        if shutil.which("mkdocs") is None:
            self.skipTest("no mkdocs")
        shutil.copy(os.path.join(ROOT, "mkdocs.yml"), self.site)
        shutil.copytree(os.path.join(ROOT, "docs", "site"), os.path.join(self.site, "docs", "site"))
        for target, code in (("b.md", 0), ("c.md", 1)):
            self.write("docs/README.md", f"# Title\n\n[link]({target})\n")
            self.write("docs/b.md", "# Other\n")
            done = subprocess.run(["mkdocs", "build", "--strict", "-d", "out"], cwd=self.site, capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, code, done.stderr)
            self.assertEqual("contains a link to 'c.md'" in done.stderr, code == 1, done.stderr)

    def test_unknown_options_are_refused(self):
        for options in (["--everything"], ["-o"]):
            done = subprocess.run([os.path.join(ROOT, "scripts", "site.sh"), *options], capture_output=True, text=True, check=False)
            self.assertEqual((done.returncode, done.stdout), (2, ""))
            self.assertRegex(done.stderr, rf"^site.sh: {options[0]}: must be [^\n]*\n$")

    def test_a_folder_with_files_of_another_kind_is_refused(self):
        self.write("thesis.tex", "Years of work.")
        done = subprocess.run([os.path.join(ROOT, "scripts", "site.sh"), "-o", self.site], capture_output=True, text=True, check=False)
        self.assertEqual((done.returncode, done.stdout), (2, ""))
        self.assertEqual(done.stderr, f"site.sh: -o {self.site}: must be a new or empty folder, or an earlier site\n")
        self.assertEqual(os.listdir(self.site), ["thesis.tex"])


if __name__ == "__main__":
    unittest.main()
