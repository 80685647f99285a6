#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""scripts/scenes.sh with a repository made here: a scene comes from a clone or, where there is none, from the network (a file:// in place of
GitHub); one whose SHA-256 is another is refused and leaves nothing. Every scene on the real list has cameras and a row in the guide.

    scenes_test.py GRTX
"""
import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
SCRIPT = os.path.join(ROOT, "scripts", "scenes.sh")
PROGRAM = ""


def listed():
    with open(os.path.join(ROOT, "configs", "scenes", "scenes.txt"), encoding="utf-8") as file:
        return [line.split() for line in file if line.strip() and not line.startswith("#")]


class Scenes(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = temporary.name
        repository = self.path("clones", "somebody", "hall")
        shutil.copytree(os.path.join(ROOT, "tests", "data", "sog_lod"), os.path.join(repository, "lod_output"))
        with open(os.path.join(repository, "large.bin"), "wb") as file:
            file.write(b"what nobody asked for")
        self.git(repository, "init", "-q")
        self.git(repository, "config", "uploadpack.allowFilter", "true")
        self.git(repository, "add", ".")
        self.git(repository, "-c", "user.name=t", "-c", "user.email=t@example.org", "commit", "-qm", "A scene")
        self.commit = self.git(repository, "rev-parse", "HEAD").strip()
        plain = self.path("plain.ply")
        subprocess.run([PROGRAM, "convert", os.path.join(repository, "lod_output"), plain, "--lod", "1", "--quiet"], check=True)
        with open(plain, "rb") as file:
            self.bytes = file.read()
        os.makedirs(self.path("lists"))
        with open(self.path("lists", "hall.cameras.json"), "w", encoding="utf-8") as file:
            file.write("[]\n")

    def path(self, *names):
        return os.path.join(self.folder, *names)

    def git(self, folder, *arguments):
        return subprocess.run(["git", "-C", folder, *arguments], capture_output=True, text=True, check=True).stdout

    def scenes(self, *more, sha=None, environment=None, folder="lod_output", level="1"):
        sha = sha or hashlib.sha256(self.bytes).hexdigest()
        with open(self.path("lists", "scenes.txt"), "w", encoding="utf-8") as file:
            file.write(f"# name ...\nhall  somebody/hall  {self.commit}  {folder}  {level}  {sha}\n")
        return subprocess.run([SCRIPT, self.path("out"), "--program", PROGRAM, "--list", self.path("lists", "scenes.txt"), *more],
                              capture_output=True, text=True, check=False, env={**os.environ, **(environment or {})})

    def check_result(self):
        with open(self.path("out", "hall.ply"), "rb") as file:
            self.assertEqual(file.read(), self.bytes)
        self.assertEqual(sorted(os.listdir(self.path("out"))), ["hall.cameras.json", "hall.ply"])

    def test_a_scene_comes_from_a_clone_once(self):
        done = self.scenes("--clones", self.path("clones"))
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.check_result()
        done = self.scenes("--clones", self.path("clones"))
        self.assertEqual((done.returncode, done.stdout), (0, "hall: is there\n"))

    def test_without_a_clone_it_is_cloned(self):
        environment = {"GIT_CONFIG_COUNT": "1", "GIT_CONFIG_KEY_0": f"url.file://{self.path('clones')}/.insteadOf",
                       "GIT_CONFIG_VALUE_0": "https://github.com/"}
        done = self.scenes(environment=environment)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.check_result()

    def test_a_scene_at_the_top_of_its_repository_is_cloned_without_the_rest(self):
        repository = self.path("clones", "somebody", "hall")
        for name in os.listdir(os.path.join(repository, "lod_output")):
            self.git(repository, "mv", f"lod_output/{name}", name)
        self.git(repository, "-c", "user.name=t", "-c", "user.email=t@example.org", "commit", "-qm", "Up")
        self.commit = self.git(repository, "rev-parse", "HEAD").strip()
        environment = {"GIT_CONFIG_COUNT": "1", "GIT_CONFIG_KEY_0": f"url.file://{self.path('clones')}/.insteadOf",
                       "GIT_CONFIG_VALUE_0": "https://github.com/", "GIT_TRACE": self.path("trace"), "GIT_TRACE_PACKET": self.path("trace")}
        done = self.scenes(environment=environment, folder=".")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.check_result()
        with open(self.path("trace"), encoding="utf-8") as file:
            trace = file.read()
        self.assertEqual(trace.count("built-in: git fetch"), 1)  # for all files that it needs: one after the clone
        asked = re.findall(r"clone> want ([0-9a-f]{40})|fetch> want ([0-9a-f]{40})", trace)
        wanted = {first or second for first, second in asked}
        self.assertNotIn(self.git(repository, "rev-parse", "HEAD:large.bin").strip(), wanted)
        self.assertIn(self.git(repository, "rev-parse", "HEAD:lod-meta.json").strip(), wanted)

    def test_cameras_that_went_come_again(self):
        self.scenes("--clones", self.path("clones"))
        os.remove(self.path("out", "hall.cameras.json"))
        self.assertEqual(self.scenes("--clones", self.path("clones")).stdout, "hall: is there\n")
        self.check_result()

    def test_a_plain_scene_has_no_level(self):
        plain = os.path.join(self.path("clones", "somebody", "hall"), "lod_output", "1_0")
        subprocess.run([PROGRAM, "convert", plain, self.path("plain.ply"), "--quiet"], check=True)
        with open(self.path("plain.ply"), "rb") as file:
            self.bytes = file.read()
        done = self.scenes("--clones", self.path("clones"), folder="lod_output/1_0", level="-")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.check_result()

    def test_another_sum_is_refused_and_leaves_nothing(self):
        done = self.scenes("--clones", self.path("clones"), sha="0" * 64)
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stderr, r"^scenes.sh: hall: SHA-256 is [0-9a-f]{64}, on record is 0{64}\n$")
        self.assertEqual(os.listdir(self.path("out")), [])

    def test_bad_requests_are_one_line(self):
        for arguments, rule in ((("--everything",), "must be FOLDER"), (("--only", "attic"), "no such scene")):
            done = self.scenes(*arguments)
            self.assertEqual(done.returncode, 2)
            self.assertRegex(done.stderr, rf"^scenes.sh: [^\n]*{rule}[^\n]*\n$")

    def test_every_scene_has_cameras_and_a_row_in_the_guide(self):
        with open(os.path.join(ROOT, "docs", "guide", "scenes.md"), encoding="utf-8") as file:
            guide = file.read()
        self.assertGreaterEqual(len(listed()), 5)
        for name, repository, commit, _, _, sha in listed():
            with open(os.path.join(ROOT, "configs", "scenes", f"{name}.cameras.json"), encoding="utf-8") as file:
                self.assertGreaterEqual(len(json.load(file)), 2, name)
            self.assertTrue(f"| `{name}` |" in guide and f"| {repository} |" in guide, name)
            self.assertEqual((len(commit), len(sha)), (40, 64))


if __name__ == "__main__":
    PROGRAM = os.path.abspath(sys.argv.pop(1))
    unittest.main()
