#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""scripts/check_version.py finds each place that has another version, date or model, and prints a version's notes."""
import os
import subprocess
import sys
import tempfile
import unittest

SCRIPT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scripts", "check_version.py")
TREE = {
    "CMakeLists.txt": "cmake_minimum_required(VERSION 3.25)\nproject(grtx_tlm VERSION 1.2.0 LANGUAGES CXX)\n",
    "python/grtx_tlm/__init__.py": '__version__ = "1.2.0"\n',
    "CITATION.cff": "cff-version: 1.2.0\nversion: 1.2.0\ndate-released: 2027-01-02\n",
    "packaging/vcpkg/vcpkg.json": '{"version-semver": "1.2.0"}\n',
    "packaging/spack/packages/grtx-tlm/package.py": '    version("1.2.0", tag="v1.2.0")\n',
    "rtl_tlm/run/model_version.h": "inline constexpr int kModelVersion = 7;\n",
    "CHANGELOG.md": "# Changelog\n\n## [Unreleased]\n\n## [1.2.0] - 2027-01-02\n\n* A thing.\n\n## [1.1.0] - 2026-12-01\n\n"
                    "[Unreleased]: ../../c\n\n[1.2.0]: ../../b\n\n[1.1.0]: ../../a\n",
}


class CheckVersion(unittest.TestCase):
    def run_on(self, changes, *arguments):
        with tempfile.TemporaryDirectory() as top:
            for name, text in {**TREE, **changes}.items():
                os.makedirs(os.path.dirname(os.path.join(top, name)), exist_ok=True)
                with open(os.path.join(top, name), "w", encoding="utf-8") as file:
                    file.write(text)
            return subprocess.run([sys.executable, "-B", SCRIPT, top, *arguments], capture_output=True, text=True, check=False)

    def faults(self, changes, *arguments):
        run = self.run_on(changes, *arguments)
        self.assertEqual(run.returncode, 1 if run.stdout else 0, run.stderr)
        return run.stdout.splitlines()

    def test_nothing_in_a_tree_of_one_version(self):
        self.assertEqual(self.faults({}), [])
        self.assertEqual(self.faults({}, "--tag", "v1.2.0"), [])

    def test_a_tree_between_releases_says_dev_and_has_no_date(self):
        dev = {name: text.replace('1.2.0', '1.2.0.dev0' if name.startswith("python") else '1.2.0-dev') for name, text in TREE.items()
               if name.startswith(("python", "packaging/vcpkg"))}
        dev |= {"CMakeLists.txt": TREE["CMakeLists.txt"] + 'set(GRTX_VERSION_SUFFIX "-dev")\n', "CITATION.cff": "version: 1.2.0-dev\n",
                "CHANGELOG.md": TREE["CHANGELOG.md"].replace("## [1.2.0] - 2027-01-02\n", "")}
        self.assertEqual(self.faults(dev), [])
        self.assertEqual(self.faults({**dev, "python/grtx_tlm/__init__.py": TREE["python/grtx_tlm/__init__.py"]}),
                         ["python/grtx_tlm/__init__.py: version 1.2.0, CMakeLists.txt has 1.2.0-dev"])
        self.assertEqual(len(self.faults(dev, "--tag", "v1.2.0")), 2)
        recipe = "packaging/spack/packages/grtx-tlm/package.py"  # it had to name a tag that nobody has
        self.assertEqual(self.faults({**dev, recipe: '    version("1.1.0", tag="v1.1.0")\n'}), [])
        self.assertEqual(len(self.faults({**dev, recipe: '    version("1.1.0", tag="v1.0.0")\n'})), 1)

    def test_a_release_that_calls_itself_dev(self):
        text = TREE["CHANGELOG.md"].replace("* A thing.", "The tree is 1.2.0-dev.\n\n* A thing.")
        self.assertEqual(self.faults({"CHANGELOG.md": text}), ["CHANGELOG.md: [1.2.0] says 1.2.0-dev"])

    def test_each_place_of_another_version(self):
        self.assertEqual(self.faults({"python/grtx_tlm/__init__.py": '__version__ = "1.1.0"\n'}),
                         ["python/grtx_tlm/__init__.py: version 1.1.0, CMakeLists.txt has 1.2.0"])
        self.assertEqual(self.faults({"CITATION.cff": "version: 1.0.0\ndate-released: 2027-01-02\n"}),
                         ["CITATION.cff: version 1.0.0, CMakeLists.txt has 1.2.0"])
        self.assertEqual(self.faults({"packaging/vcpkg/vcpkg.json": '{"version-semver": "1.1.0"}\n'}),
                         ["packaging/vcpkg/vcpkg.json: version 1.1.0, CMakeLists.txt has 1.2.0"])
        self.assertEqual(len(self.faults({"packaging/spack/packages/grtx-tlm/package.py": '    version("1.2.0", tag="v1.1.0")\n'})), 1)
        self.assertEqual(self.faults({"CITATION.cff": "version: 1.2.0\ndate-released: 2027-01-03\n"}),
                         ["CITATION.cff: date-released 2027-01-03, CHANGELOG.md has 2027-01-02"])

    def test_the_changelog(self):
        text = TREE["CHANGELOG.md"]
        self.assertEqual(self.faults({"CHANGELOG.md": text.replace("## [Unreleased]\n", "")})[0],
                         "CHANGELOG.md: must begin with ## [Unreleased]")
        self.assertEqual(self.faults({"CHANGELOG.md": text.replace("[1.1.0]: ../../a\n", "")}), ["CHANGELOG.md: no link for [1.1.0]"])
        undated = {"CHANGELOG.md": text.replace("[1.2.0] - 2027-01-02", "[1.2.0] - soon"), "CITATION.cff": "version: 1.2.0\n"}
        self.assertEqual(self.faults(undated), [])
        self.assertEqual(self.faults(undated, "--tag", "v1.2.0"), ["CHANGELOG.md: [1.2.0] has no date yet"])

    def test_a_citation_with_a_date_that_no_section_has(self):
        text = TREE["CHANGELOG.md"]
        self.assertEqual(self.faults({"CHANGELOG.md": text.replace("[1.2.0] - 2027-01-02", "[1.2.0]")}),
                         ["CITATION.cff: date-released 2027-01-02, CHANGELOG.md has no date for [1.2.0]"])
        self.assertEqual(self.faults({"CITATION.cff": "version: 1.2.0\n"}),
                         ["CITATION.cff: date-released is missing, CHANGELOG.md has 2027-01-02"])

    def test_a_heading_twice_in_a_section(self):
        def with_headings(*headings):
            body = "".join(f"### {heading}\n\n* A thing.\n\n" for heading in headings)
            return {"CHANGELOG.md": TREE["CHANGELOG.md"].replace("* A thing.\n\n## [1.1.0] - 2026-12-01\n",
                                                                 body + "## [1.1.0] - 2026-12-01\n\n### Added\n")}

        self.assertEqual(self.faults(with_headings("Added", "Fixed")), [])
        self.assertEqual(self.faults(with_headings("Added", "Added: designs", "Added: pages")), [])
        self.assertEqual(self.faults(with_headings("Added", "Fixed", "Added")), ["CHANGELOG.md: [1.2.0] has the heading '### Added' twice"])
        self.assertEqual(self.faults(with_headings("Fixed", "Fixed ", "Fixed")), ["CHANGELOG.md: [1.2.0] has the heading '### Fixed' twice"])
        self.assertEqual(self.faults(with_headings("Added: a", "Added: a")), ["CHANGELOG.md: [1.2.0] has the heading '### Added: a' twice"])

    def test_another_model_version(self):
        def saying(unreleased, released):
            text = TREE["CHANGELOG.md"].replace("* A thing.", released + "\n\n* A thing.")
            return {"CHANGELOG.md": text.replace("## [Unreleased]\n", f"## [Unreleased]\n\n{unreleased}\n")}

        def fault(name, other):
            return [f"CHANGELOG.md: [{name}] says model version {other}, rtl_tlm/run/model_version.h has 7"]

        self.assertEqual(self.faults(saying("", "Model version 7. It is new.")), [])
        self.assertEqual(self.faults(saying("", "Model version 6.")), fault("1.2.0", 6))
        self.assertEqual(self.faults(saying("", "Model version 7.\n\n* Swifter. Model\n  version 8.")), fault("1.2.0", 8))
        # Before the next release the model may be ahead: then [Unreleased] says which.
        self.assertEqual(self.faults(saying("* Model version 7.", "Model version 6.")), [])
        self.assertEqual(self.faults(saying("* Model version 8.", "Model version 7.")), fault("Unreleased", 8))

    def test_a_tag_of_another_version(self):
        self.assertEqual(self.faults({}, "--tag", "v1.3.0"), ["CMakeLists.txt: version 1.2.0 is not that of the tag v1.3.0"])

    def test_notes_of_the_release(self):
        run = self.run_on({}, "--notes")
        self.assertEqual((run.returncode, run.stdout), (0, "* A thing.\n"))
        linked = {"CHANGELOG.md": TREE["CHANGELOG.md"].replace(
            "* A thing.", "* A [thing](docs/api.md#how), a [page\n  of it](https://example.org/a), [below](#120).")}
        run = self.run_on(linked, "--notes", "--links", "https://forge/us/it/blob/v1.2.0/")
        self.assertEqual((run.returncode, run.stdout),
                         (0, "* A [thing](https://forge/us/it/blob/v1.2.0/docs/api.md#how), a [page\n  of it](https://example.org/a), "
                             "[below](https://forge/us/it/blob/v1.2.0/CHANGELOG.md#120).\n"))
        run = self.run_on({}, "--notes", "--tag", "v1.3.0")
        self.assertEqual((run.returncode, run.stdout), (1, ""))


if __name__ == "__main__":
    unittest.main()
