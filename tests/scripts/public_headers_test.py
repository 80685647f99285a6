#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""scripts/public_headers.py --check finds each kind of fault, and nothing in a tree without one."""
import os
import shutil
import subprocess
import sys
import tempfile
import unittest

SCRIPT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scripts", "public_headers.py")
sys.path.insert(0, os.path.dirname(SCRIPT))
import public_headers  # noqa: E402

LICENCE = "// SPDX-" "License-Identifier: Apache-2.0\n"  # in two, else reuse takes it for this file's
LIST = "docs/api/public_headers.txt"
TREE = {
    LIST: "# What is public.\n\nbase/error.h\nmodules/cache/l1_cache_if.h\n",
    "base/error.h": LICENCE + "// An error.\n#pragma once\n#include <string>\n",
    "base/lines.h": "#pragma once\n",
    "base/inner.h": '#pragma once\n#include "grtx/base/lines.h"\n',
    "base/other.h": "#pragma once\n",
    "modules/cache/l1_cache_if.h": '// What an L1 is.\n#pragma once\n#include "grtx/base/inner.h"\n',
    "apps/grtx/program.h": "#pragma once\n",
    "examples/own.cpp": '#include "grtx/base/error.h"\n#include "own.h"\n',
    "tests/package/outside/main.cpp": '#include "grtx/modules/cache/l1_cache_if.h"\n',
    "docs/guide/use.md": '# Use\n\n```\n#include "grtx/base/error.h"\n```\n',
    "docs/add-a-module.md": "# Add\n",
}


class PublicHeaders(unittest.TestCase):
    def run_on(self, changes, *arguments):
        with tempfile.TemporaryDirectory() as top:
            for name, text in {**TREE, **changes}.items():
                os.makedirs(os.path.dirname(os.path.join(top, name)), exist_ok=True)
                with open(os.path.join(top, name), "w", encoding="utf-8") as file:
                    file.write(text)
            os.mkdir(os.path.join(top, "scripts"))  # it looks below its parent's folder
            shutil.copy(SCRIPT, os.path.join(top, "scripts"))
            return subprocess.run([sys.executable, "-B", os.path.join(top, "scripts", "public_headers.py"), *arguments], capture_output=True,
                                  text=True, check=False)

    def faults(self, changes):
        run = self.run_on(changes, "--check")
        self.assertEqual(run.returncode, 1 if run.stdout else 0, run.stderr)
        return run.stdout.splitlines()

    def test_nothing_in_a_sound_tree(self):
        self.assertEqual(self.faults({}), [])

    def test_a_header_that_is_not_there_or_twice(self):
        self.assertEqual(self.faults({LIST: TREE[LIST] + "base/gone.h\n"}), [f"{LIST}: base/gone.h does not exist"])
        self.assertEqual(self.faults({LIST: TREE[LIST] + "base/error.h\n"}), [f"{LIST}: base/error.h stands there twice"])

    def test_a_header_that_does_not_say_what_it_is(self):
        for text in (LICENCE + "#pragma once\n", "#pragma once\n// Too late.\n", LICENCE + "//\n#pragma once\n"):
            self.assertEqual(self.faults({"base/error.h": text}), ["base/error.h:1: is public and does not say what it is"])

    def test_a_signature_of_an_internal_type(self):
        inner = {"base/inner.h": "#pragma once\nstruct Inner {\n  int Field;\n};\nstruct Later;\nenum class Kind : char { a };\n"}
        user = TREE["modules/cache/l1_cache_if.h"]

        def of(text):
            return self.faults({**inner, "modules/cache/l1_cache_if.h": user + text})

        rule = "modules/cache/l1_cache_if.h: shows {} of base/inner.h, which is not public (docs/api/public_headers.txt)"
        self.assertEqual(of("struct Cache {\n  void take(const Inner& inner);\n  Kind kind;\n};\n"), [rule.format("Inner"), rule.format("Kind")])
        hidden = "class Cache {\n public:\n  int Field;  // of an Inner\n private:\n  Inner inner_;\n};\nclass Later;\n"
        self.assertEqual(of(hidden), [])
        self.assertEqual(of("class Cache {\n  Inner inner_;\n\n public:\n  int size();\n};\n"), [])
        self.assertEqual(of("class Cache : public Inner {\n};\n"), [rule.format("Inner")])
        self.assertEqual(self.faults({**inner, LIST: TREE[LIST] + "base/inner.h\n", "base/inner.h": "// It.\n" + inner["base/inner.h"],
                                      "modules/cache/l1_cache_if.h": user + "Inner taken();\n"}), [])

    def test_a_user_of_what_is_not_public(self):
        line = '#include "grtx/base/other.h"\n'
        for name in ("examples/own.cpp", "tests/package/outside/main.cpp", "docs/guide/use.md", "docs/add-a-module.md", "examples/own.h"):
            self.assertEqual(self.faults({name: TREE.get(name, "") + line}), [f"{name}: includes base/other.h, which is not public ({LIST})"])

    def test_too_many_that_are_installed(self):
        def including(count):  # beside the four that are installed already
            names = [f"base/n{number}.h" for number in range(count)]
            return {"base/lines.h": "".join(f'#include "grtx/{name}"\n' for name in names), **dict.fromkeys(names, "")}

        most = public_headers.MOST
        self.assertEqual(self.faults(including(most - 4)), [])
        self.assertEqual(self.faults(including(most - 3)), [f"{LIST}: with what they include {most + 1} headers are installed, more than {most}"])

    def test_what_is_public_and_what_it_stands_on(self):
        self.assertEqual(self.run_on({}, "--list").stdout, "base/error.h\nmodules/cache/l1_cache_if.h\n")
        self.assertEqual(self.run_on({}, "--reached").stdout, "base/inner.h\nbase/lines.h\n")
        self.assertEqual(self.run_on({}).stdout, "2 public, 2 that they include, 6 in all\n")


if __name__ == "__main__":
    unittest.main()
