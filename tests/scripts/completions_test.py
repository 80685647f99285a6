#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Completion of bash, fish and zsh, made from --help.

Usage: completions_test.py GRTX
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

SCRIPTS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scripts")
sys.path.insert(0, SCRIPTS)
import cli_help  # noqa: E402


class Completions(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(temporary.cleanup)
        cls.folder = temporary.name
        subprocess.run([sys.executable, "-B", os.path.join(SCRIPTS, "completions.py"), PROGRAM, os.path.join(cls.folder, "completions")], check=True)
        with open(os.path.join(cls.folder, "scene.ply"), "w", encoding="utf-8"):
            pass
        cls.commands = cli_help.everything(PROGRAM)

    def path(self, name):
        return os.path.join(self.folder, "completions", name)

    def bash(self, line):
        """What bash offers behind the line, whose last word is the one that is typed."""
        words = line.split(" ")
        text = (f"source {self.path('grtx.bash')}; COMP_WORDS=({' '.join(repr(word) for word in words)}); COMP_CWORD={len(words) - 1}; "
                f"_grtx grtx {words[-1]!r} {words[-2]!r}; printf '%s\\n' \"${{COMPREPLY[@]}}\"")
        run = subprocess.run(["bash", "-uc", text], capture_output=True, text=True, check=True, cwd=self.folder)
        self.assertEqual(run.stderr, "")
        return run.stdout.split()

    def test_every_option_has_a_known_form(self):
        for command in self.commands:
            for option in command.options + command.arguments:
                self.assertRegex(option.names[0], r"^(-\w|--[a-z][\w-]*|[A-Z]+)$")
                self.assertNotRegex(option.description, r"^-|UINT|FLOAT|TEXT|REQUIRED|Excludes:|Needs:", option.names)

    def test_bash(self):
        names = [command.name for command in self.commands if command.name]
        self.assertLessEqual(set(names), set(self.bash("grtx ")))
        self.assertEqual(self.bash("grtx synt"), ["synth"])
        self.assertEqual(self.bash("grtx sim --mod"), ["--mode"])
        self.assertEqual(self.bash("grtx sim --mode "), ["cycle", "windows"])
        self.assertEqual(self.bash("grtx sim --machine paper-l"), ["paper-lean"])
        self.assertEqual(self.bash("grtx sim --set gpu.sm"), ["gpu.sms="])
        self.assertEqual(self.bash("grtx info sc"), ["scene.ply"])
        self.assertEqual(self.bash("grtx run --scene sc"), ["scene.ply"])
        self.assertEqual(self.bash("grtx synth --count "), [])

    def test_fish(self):
        if shutil.which("fish") is None:
            self.skipTest("no fish")

        def offered(line):
            run = subprocess.run(["fish", "--no-config", "-c", f"source {self.path('grtx.fish')}; complete -C '{line}'"],
                                 capture_output=True, text=True, check=True, cwd=self.folder)
            return [found.split("\t")[0] for found in run.stdout.splitlines()]

        self.assertEqual(offered("grtx synt"), ["synth"])
        self.assertEqual(offered("grtx sim --mode "), ["cycle", "windows"])
        self.assertIn("--machine", offered("grtx sim --m"))
        self.assertIn("scene.ply", offered("grtx run --scene sc"))

    def test_zsh(self):
        if shutil.which("zsh") is None:
            self.skipTest("no zsh")
        subprocess.run(["zsh", "-n", self.path("_grtx")], check=True)
        # A terminal in which the line is typed, with a tab.
        script = f"""
            zmodload zsh/zpty; zpty z zsh -f -i
            zpty -w z 'PS1=; fpath=({os.path.dirname(self.path("_grtx"))} $fpath); autoload -U compinit; compinit -u -D; cd {self.folder}'
            zpty -w z 'bindkey "^M" accept-line; print ready'; zpty -r z line '*ready*ready*'
            for typed in 'grtx synt' 'grtx sim --machine paper-l' 'grtx sim --set gpu.sm' 'grtx info sc'; do
              zpty -n -w z "$typed"$'\\t'; sleep 2; zpty -n -w z $'\\C-a: \\C-e\\n'
            done; sleep 1; zpty -w z 'print end'; zpty -r z all '*end*end*'; print -r -- $all"""
        run = subprocess.run(["zsh", "-fc", script], capture_output=True, text=True, timeout=60, check=False)
        shown = re.sub(r"\x1b\[[?\d;]*[a-zA-Z]|[\x07\r]|.\x08", "", run.stdout)
        for whole in ("synth", "paper-lean", "gpu.sms=", "scene.ply"):
            self.assertIn(whole, shown)


if __name__ == "__main__":
    PROGRAM = os.path.abspath(sys.argv.pop(1))
    unittest.main()
