#!/usr/bin/env python3
"""scripts/check_docs.py finds each kind of fault, and nothing in a tree without one."""
import os
import subprocess
import sys
import tempfile
import unittest

SCRIPT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scripts", "check_docs.py")
sys.path.insert(0, os.path.dirname(SCRIPT))
import docs_prose  # noqa: E402
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

    def test_two_pages_of_one_name(self):
        self.assertEqual(self.faults({"docs/notes/l1_cache.md": "", "docs/README.md": "", "docs/notes/README.md": "", "docs/start.md": ""}),
                         ["docs/notes/l1_cache.md:1: has the name of docs/model/l1_cache.md"])

    def test_a_sentence_that_nobody_reads_to_its_end(self):
        short, very = "Short. " * 9, "very " * 38
        for sentence, faults in [
            (f"A {very}`long name`", []),  # 40 words
            (f"A {very}very `long name`", ["docs/start.md:3: a sentence of 41 words, more than 40: A " + "very " * 9 + "ver…"]),
        ]:
            self.assertEqual(self.faults({"docs/start.md": docs_prose.wrap(f"# Start\n\n{short}{sentence}.\n")}), faults)
        table = f"| a |\n|---|\n| {very * 2} |\n\n```\n{very * 2}\n```\n"
        self.assertEqual(self.faults({"docs/start.md": table}), [])
        self.assertEqual(self.faults({"start.md": very * 2, "docs/start.md": ""}), [])

    def test_sentences_that_are_long_in_the_mean(self):
        for last, faults in [("w " * 31, []), ("w " * 32, ["docs/start.md:1: sentences of 18.5 words in the mean, more than 18"])]:
            self.assertEqual(self.faults({"docs/start.md": f"One two three.\n\n* W {last}end.\n"}), faults)

    def test_a_line_wider_than_the_screen(self):
        for line, faults in [("Word. " * 20, []), ("Word. " * 20 + "x", [
                "docs/start.md:3: a line of 121 characters, more than 120: scripts/docs_prose.py --wrap breaks it"])]:
            self.assertEqual(self.faults({"docs/start.md": f"# Start\n\n{line}\n"}), faults)

    def test_wrapping_changes_no_word_and_no_item(self):
        wrapped = docs_prose.wrap("# " + "t " * 80 + "\n\n* " + "word " * 30 + "+ 1\n  " + "`a b` " * 30 + "\n* x\n\n    code " + "c " * 80)
        heading, item = wrapped.split("\n\n")[:2]
        self.assertEqual(heading, "# " + "t " * 80)
        self.assertEqual(item.split(), ("* " + "word " * 30 + "+ 1 " + "`a b` " * 30 + "* x").split())
        self.assertLessEqual(max(map(len, item.split("\n"))), 120)
        self.assertEqual([line[:2] for line in item.split("\n")], ["* ", "  ", "  ", "* "])
        self.assertEqual(wrapped.split("\n\n")[2], "    code " + "c " * 80)
        self.assertEqual(docs_prose.wrap(wrapped), wrapped)


if __name__ == "__main__":
    unittest.main()
