#!/usr/bin/env python3
"""scripts/check_docs.py finds each kind of fault, and nothing in a tree without one."""
import os
import subprocess
import sys
import tempfile
import unittest

SCRIPT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scripts", "check_docs.py")
TREE = {
    "modules/cache/l1_cache.h": "// Timing: docs/model/l1_cache.md.\n",
    "docs/model/l1_cache.md": "# L1 cache\n\n## What it costs\n",
    "docs/start.md": "[L1](model/l1_cache.md#what-it-costs), `modules/cache/l1_cache.{h,md}`, `l1_cache.h`, `build/x.h`\n",
}


class CheckDocs(unittest.TestCase):
    def faults(self, changes, program=None):
        with tempfile.TemporaryDirectory() as top:
            for name, text in {**TREE, **changes}.items():
                os.makedirs(os.path.dirname(os.path.join(top, name)), exist_ok=True)
                with open(os.path.join(top, name), "w", encoding="utf-8") as file:
                    file.write(text)
            arguments = []
            if program is not None:
                arguments = ["--program", os.path.join(top, "grtx")]
                with open(arguments[1], "w", encoding="utf-8") as file:
                    file.write(program)
                os.chmod(arguments[1], 0o755)
            run = subprocess.run([sys.executable, SCRIPT, top, *arguments], capture_output=True, text=True)
            self.assertEqual(run.returncode, 1 if run.stdout else 0, run.stderr)
            return run.stdout.splitlines()

    def test_a_sound_tree_has_none(self):
        self.assertEqual(self.faults({"docs/start.md": TREE["docs/start.md"].replace(".{h,md}", ".{h,h}")}), [])

    def test_a_file_of_a_brace_list_that_is_missing(self):
        self.assertEqual(self.faults({}),
                         ["docs/start.md:1: names modules/cache/l1_cache.{h,md}, which does not exist"])

    def test_each_fault_is_one_line_with_its_place(self):
        for text, rule in [
            ("\n[page](model/none.md)\n", "link to model/none.md, which does not exist"),
            ("\n[page](model/l1_cache.md#none)\n", "link to model/l1_cache.md#none: no such heading"),
            ("\n`modules/l1_cache.h`\n", "names modules/l1_cache.h, which does not exist"),
            ("\n`l2_cache.h`\n", "names l2_cache.h, and no file is called that"),
            ("```\ncat modules/none.txt\n```\n", "names modules/none.txt, which does not exist"),
        ]:
            self.assertEqual(self.faults({"docs/start.md": text}), ["docs/start.md:2: " + rule])

    def test_a_comment_that_names_a_page_of_before(self):
        self.assertEqual(self.faults({"modules/cache/l1_cache.h": "// docs/l1_cache.md\n", "docs/start.md": ""}),
                         ["modules/cache/l1_cache.h:1: names docs/l1_cache.md, which does not exist"])

    def test_a_box_of_a_picture(self):
        self.assertEqual(self.faults({"docs/start.md": "", "docs/a.svg": '<svg>\n<a href="../modules/none.h"/>\n</svg>'}),
                         ["docs/a.svg:2: link to ../modules/none.h, which does not exist"])

    def test_commands_and_options_that_the_program_does_not_have(self):
        program = '#!/bin/sh\n[ "$1" = sim ] && echo "  --stats TEXT   Statistics"\n'
        text = "# Start\n\n```\ngrtx sim T.grtx --stats S.json \\\n  --vdc W.vcd   # --not-this\n```\n`grtx simulate`, the grtx house\n"
        self.assertEqual(self.faults({"docs/start.md": text}, program),
                         ["docs/start.md:4: grtx sim has no option --vdc", "docs/start.md:7: grtx has no command simulate"])


if __name__ == "__main__":
    unittest.main()
