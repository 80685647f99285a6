#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""docs/guide/when-it-fails.md and newcomer_answers.txt: every command there gives the answer that stands below it, and each answer
that is an error is one line with exit code 2. Every command has --help; grtx alone shows a first session
that works.

    newcomer_test.py GRTX [--record]       --record writes the answers into both.
"""
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
PAGES = (os.path.join(ROOT, "docs", "guide", "when-it-fails.md"), os.path.join(ROOT, "tests", "scripts", "newcomer_answers.txt"))
BLOCK = re.compile(r"(?<=```\n)\$ (grtx[^\n]*)\n(.*?)(?=```)", re.S)
PROGRAM = ""


def prepare(folder):
    """The files that the page speaks of."""
    def path(name):
        return os.path.join(folder, name)

    def write(name, content):
        os.makedirs(os.path.dirname(path(name)), exist_ok=True)
        with open(path(name), "wb") as file:
            file.write(content)

    run(folder, "grtx synth --preset object --count 300 --seed 1 -o scene.ply --quiet")
    run(folder, "grtx trace --scene scene.ply --cameras scene.cameras.json --width 8 --height 8 -o scene.grtx --quiet")
    with open(path("scene.ply"), "rb") as file:
        scene = file.read()
    with open(path("scene.grtx"), "rb") as file:
        trace = file.read()
    write("truck/point_cloud/iteration_30000/point_cloud.ply", scene)
    write("cut.ply", scene[:500])
    write("cut.grtx", trace[:-100])
    write("old.grtx", trace[:8] + (3).to_bytes(4, "little") + trace[12:])
    write("notes.txt", b"hello\n")
    write("photos/readme.txt", b"hello\n")
    write("own.toml", b"[l1]\nbyte = 65536\n")
    write("scene.gltf", b'{"asset": {"version": "2.0"}, "meshes": []}')
    write("scene.obj", b"v 0 0 0\n")
    write("input.ply", b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n0 0 0\n")
    write("photos/sparse/cameras.bin", bytes(100))
    write("empty.json", b"[]")


def run(folder, command):
    words = shlex.split(command)
    done = subprocess.run([PROGRAM, *words[1:]], cwd=folder, capture_output=True, text=True, timeout=120, check=False)
    return done.returncode, done.stdout + done.stderr


class Newcomer(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(temporary.cleanup)
        cls.folder = temporary.name
        prepare(cls.folder)

    def test_each_answer_is_the_page_s_in_one_line(self):
        blocks = []
        for page in PAGES:
            with open(page, encoding="utf-8") as file:
                blocks += BLOCK.findall(file.read())
        self.assertGreaterEqual(len(blocks), 40)
        for command, answer in blocks:
            with self.subTest(command):
                code, text = run(self.folder, command)
                self.assertEqual(text, answer)
                self.assertEqual(code, 2)
                self.assertEqual(text.count("\n"), 1)

    def test_every_command_has_help(self):
        self.assertGreaterEqual(len(self.commands()), 15)
        for name in self.commands():
            code, text = run(self.folder, f"grtx {name} --help")
            self.assertEqual(code, 0, name)
            self.assertIn(f"Usage: grtx {name}", text)

    def test_manual_pages_have_every_option(self):
        if shutil.which("help2man") is None:
            self.skipTest("no help2man")
        manual = os.path.join(self.folder, "man")
        subprocess.run([os.path.join(ROOT, "scripts", "man_pages.sh"), PROGRAM, manual], check=True)
        for name in ("run", "sim", "trace"):
            options = re.findall(r"^  (?:-\w,)?(--[a-z-]+)", run(self.folder, f"grtx {name} --help")[1], re.M)
            with open(os.path.join(manual, f"grtx-{name}.1"), encoding="utf-8") as file:
                page = file.read().replace("\\-", "-")
            self.assertGreater(len(options), 10)
            for option in options:
                self.assertRegex(page, rf"(?m)^\\fB(-\w\\fR,)?{option}\b")
            self.assertRegex(page, rf'(?m)^\.TH GRTX-{name.upper()} "1" "\w+ \d{{4}}" "grtx \d+\.\d+\.\d+[^"]*"')
            self.assertIn(f".SH NAME\ngrtx-{name} - ", page)
        self.assertEqual(len(os.listdir(manual)), 1 + len(self.commands()))

    def commands(self):
        text = run(self.folder, "grtx --help")[1]
        return re.findall(r"^  ([a-z][a-z-]*) ", text.split("Subcommands:")[1], re.M)

    def test_the_first_session_works(self):
        code, text = run(self.folder, "grtx")
        self.assertEqual(code, 2)
        steps = re.findall(r"^     (grtx [^\n\\]*(?:\\\n[^\n\\]*)*)", text, re.M)
        self.assertEqual(len(steps), 5)
        for step in steps:
            small = step.replace("\\\n", " ").replace("400000", "600").replace("512", "16").replace("64 ", "8 ")
            code, text = run(self.folder, small)
            self.assertEqual(code, 0, f"{small}\n{text}")
        self.assertTrue(os.path.exists(os.path.join(self.folder, "out", "report.html")))


def record():
    with tempfile.TemporaryDirectory() as folder:
        prepare(folder)
        for page in PAGES:
            with open(page, encoding="utf-8") as file:
                text = file.read()
            text = BLOCK.sub(lambda block: f"$ {block[1]}\n{run(folder, block[1])[1]}", text)
            with open(page, "w", encoding="utf-8") as file:
                file.write(text)


if __name__ == "__main__":
    PROGRAM = os.path.abspath(sys.argv.pop(1))
    if "--record" in sys.argv:
        record()
    else:
        unittest.main()
