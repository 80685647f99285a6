#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""scripts/build_site.py finds links of a site that lead nowhere, and ends with 1 then; scripts/site.sh refuses what it must. The site
itself takes too long for a test: scripts/site.sh builds and checks it, also for each change on a forge (.github/workflows/docs.yml)."""
import contextlib
import io
import os
import subprocess
import sys
import tempfile
import unittest
from unittest import mock

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
sys.path.insert(0, os.path.join(ROOT, "scripts"))
import build_site  # noqa: E402

SITE = {
    "index.html": '<a href="guide/run%20it.html#first">1</a> <a href="#top">2</a> <h1 id="top">x</h1> <img src="a.png"> <a href="guide/">3</a>',
    "guide/index.html": '<a href="../index.html#top">1</a> <a href="https://example.org/none.html">2</a> <a href="mailto:a@example.org">3</a>',
    "guide/run it.html": '<a name="first"></a> <a href="../search/">1</a> <a href="#__search">of the theme</a>',
    "search/index.html": "<p>No link.</p>",
    "404.html": '<a href="/guide/none.html">at the address of the site</a>',
    "a.png": "",
}


class Site(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.site = folder.name

    def broken(self, changes):
        for name, text in {**SITE, **changes}.items():
            os.makedirs(os.path.dirname(os.path.join(self.site, name)), exist_ok=True)
            build_site.write(os.path.join(self.site, name), text)
        return build_site.broken(self.site)

    def test_links_that_lead_somewhere(self):
        self.assertEqual(self.broken({}), ([], 7))

    def test_each_fault(self):
        for link, fault in [
            ('<a href="guide/none.html">', "index.html: guide/none.html does not exist"),
            ('<a href="guide/none.html#first">', "index.html: guide/none.html#first does not exist"),
            ('<a href="search/none/">', "index.html: search/none/ does not exist"),
            ('<img src="b.png">', "index.html: b.png does not exist"),
            ('<script src="c.js"></script>', "index.html: c.js does not exist"),
            ('<link href="d.css">', "index.html: d.css does not exist"),
            ('<a href="guide/run%20it.html#second">', "index.html: guide/run%20it.html#second: no such anchor"),
            ('<a href="guide/#top">', "index.html: guide/#top: no such anchor"),
            ('<a href="#bottom">', "index.html: #bottom: no such anchor"),
        ]:
            self.assertEqual(self.broken({"index.html": SITE["index.html"] + link}), ([fault], 8), link)

    def test_a_folder_without_a_page(self):
        self.assertEqual(self.broken({"guide/index.html": '<a href="../data/">', "data/x.csv": ""})[0],
                         ["guide/index.html: ../data/ does not exist"])

    def test_a_fault_ends_with_1_and_is_a_line(self):
        for changes, code, lines in [({}, 0, ""), ({"search/index.html": '<a href="a.html">'}, 1, "search/index.html: a.html does not exist\n")]:
            self.broken(changes)
            out, err = io.StringIO(), io.StringIO()
            with mock.patch.multiple(build_site, Copy=mock.DEFAULT, doxygen=lambda: [], mkdocs=mock.DEFAULT, search_from_disk=mock.DEFAULT), \
                    mock.patch.object(sys, "argv", ["build_site.py", self.site]), contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
                self.assertEqual(build_site.main(), code)
            self.assertEqual(out.getvalue(), lines)
            self.assertIn(f"site: 5 pages, {7 + code} links, {code} of them broken: ", err.getvalue())

    def test_unknown_options_are_refused(self):
        for options in (["--everything"], ["-o"]):
            done = subprocess.run([os.path.join(ROOT, "scripts", "site.sh"), *options], capture_output=True, text=True, check=False)
            self.assertEqual((done.returncode, done.stdout), (2, ""))
            self.assertRegex(done.stderr, rf"^site.sh: {options[0]}: must be [^\n]*\n$")

    def test_a_folder_with_files_of_another_kind_is_refused(self):
        build_site.write(os.path.join(self.site, "thesis.tex"), "Years of work.")
        done = subprocess.run([os.path.join(ROOT, "scripts", "site.sh"), "-o", self.site], capture_output=True, text=True, check=False)
        self.assertEqual((done.returncode, done.stdout), (2, ""))
        self.assertEqual(done.stderr, f"site.sh: -o {self.site}: must be a new or empty folder, or an earlier site\n")
        self.assertEqual(os.listdir(self.site), ["thesis.tex"])


if __name__ == "__main__":
    unittest.main()
