#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What every command prints: lines of at most 80 characters, and with --json one JSON document with the same figures. Each of the cases
takes figures of the text and finds them in the document; there is a case for every command that `grtx --help` names.

    tables_test.py GRTX
"""
import json
import os
import re
import subprocess
import sys
import tempfile
import unittest

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
PROGRAM = ""
NUMBER = r"-?\d+(?:\.\d+)?(?:e[-+]\d+)?"
VIEW = "--scene scene.ply --cameras scene.cameras.json --width 8 --height 8"
PLAN = f"""base = '{ROOT}/configs/small.toml'
designs = ['sw', 'grtx']
[[scene]]
preset = 'object'
count = 300
seed = 7
width = 8
height = 8
[grid]
rt.warp_buffer.entries = [2, 4]
"""
SEARCH = f"""base = '{ROOT}/configs/small.toml'
[[scene]]
preset = 'object'
count = 300
seed = 7
width = 8
height = 8
[[scene]]
preset = 'object'
count = 300
seed = 8
width = 8
height = 8
role = 'evaluation'
[[parameter]]
key = 'design'
values = ['sw', 'grtx']
[[parameter]]
key = 'rt.warp_buffer.entries'
values = [2, 4]
[[parameter]]
key = 'rt.checkpoint.lanes'
values = [1, 4]
[[objective]]
value = 'gpu.time_us'
[[objective]]
value = 'cost.rt_unit_mm2'
[[objective]]
value = 'gpu.energy_nj_per_ray'
[reference]
design = 'sw'
rt.warp_buffer.entries = 4
rt.checkpoint.lanes = 1
[search]
population = 8
candidates = 8
"""
CASE = """title = 'tiny'
trace = '../scene.grtx'
machine = 'paper'
"""


def stat(document, name):
    return document["stats"][name]["value"]


def nodes(tree, depth):
    yield tree
    for child in tree["children"] if depth > 0 else ():
        yield from nodes(child, depth - 1)


class Tables(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(temporary.cleanup)
        cls.folder = temporary.name
        for name, text in (("plan.toml", PLAN), ("search.toml", SEARCH), ("cases/tiny.case.toml", CASE), ("cases/other.case.toml", CASE)):
            os.makedirs(os.path.dirname(os.path.join(cls.folder, name)), exist_ok=True)
            with open(os.path.join(cls.folder, name), "w", encoding="utf-8") as file:
                file.write(text)
        for command in ("synth --preset object --count 300 --seed 1 -o scene.ply", f"trace {VIEW} --accel tlas-tri20 --checkpoint on -o scene.grtx",
                        "sim scene.grtx --machine paper --stats stats.json", f"trace {VIEW} --no-trace --image a.pfm",
                        f"trace {VIEW} --no-trace --ert 0.5 --image b.pfm", "regress cases --update --reason first"):
            done = cls.call(f"{command} --quiet")
            assert done.returncode == 0, done.stderr

    @classmethod
    def call(cls, arguments):
        return subprocess.run([PROGRAM, *arguments.split()], cwd=cls.folder, capture_output=True, text=True, timeout=300, check=False)

    def both(self, arguments, code=0, again=None):
        """The text and the document; `again`: what is run with --json where a second run needs other outputs."""
        type(self).commands_run.add(arguments.split()[0])
        text = self.call(arguments)
        self.assertEqual(text.returncode, code, text.stderr)
        for line in text.stdout.splitlines():
            self.assertLessEqual(len(line), 80, line)
        told = self.call(f"{again or arguments} --json")
        self.assertEqual(told.returncode, code, told.stderr)
        document = json.loads(told.stdout)
        quiet = self.call(f"{again or arguments} --json --quiet")  # the document is the answer, not information
        self.assertEqual(quiet.returncode, code, quiet.stderr)
        self.assertTrue(json.loads(quiet.stdout))
        if isinstance(document, dict) and "steps" not in document:
            self.assertIn(document["schema"], self.reference(), arguments)
        return text.stdout, document

    commands_run = set()

    def reference(self):
        return self.call("--list-json").stdout

    def test_0_scenes(self):
        text, document = self.both("synth --preset object --count 200 --seed 2 -o made.ply")
        self.assertEqual(text, "")
        self.assertEqual(document, {"schema": "grtx.synth/1", "scene": "made.ply", "cameras": "made.cameras.json", "preset": "object",
                                    "gaussians": 200, "seed": 2, "sh_degree": 2})
        self.assertTrue(os.path.exists(os.path.join(self.folder, document["cameras"])))
        text, document = self.both("info made.ply")
        self.assertEqual(document["gaussians"], 200)
        self.assertRegex(text, r"\b200\b")
        text, document = self.both("convert made.ply made.spz")
        self.assertEqual(text, f"made.spz: {document['gaussians']} Gaussians, SH degree {document['sh_degree']}\n")
        self.assertEqual(document["left_out"], 0)

    def test_1_images(self):
        text, document = self.both("compare a.pfm b.pfm")
        self.assertEqual(f"PSNR {document['psnr']:.4f} dB, max error {document['max_error']:.6g}, mean error {document['mean_error']:.6g}, "
                         f"{document['different_pixels']} of {document['pixels']} pixels differ\n", text.replace("\n  ", " "))
        text, document = self.both(f"reference {VIEW} -o r.pfm")
        self.assertEqual((text, document["image"], document["width"], document["height"]), ("", "r.pfm", 8, 8))

    def test_2_traces(self):
        text, document = self.both(f"trace {VIEW} -o t.grtx")
        rays, rounds, visits, blended = map(float, re.match(rf"tri20: ({NUMBER}) rays, ({NUMBER}) rounds, ({NUMBER}) visits per ray, ({NUMBER}) ",
                                                            text.replace("\n  ", " ")).groups())
        self.assertEqual([rays, rounds, blended], [stat(document, f"tracer.{name}") for name in ("rays", "rounds", "blended")])
        self.assertAlmostEqual(visits, stat(document, "tracer.visits.total") / rays, delta=0.051)
        self.call(f"trace {VIEW} -o t.grtx --stats t.json --quiet")
        with open(os.path.join(self.folder, "t.json"), encoding="utf-8") as file:
            written = json.load(file)
        self.assertEqual({name: value for name, value in written["stats"].items() if "seconds" not in name and "per_second" not in name},
                         {name: value for name, value in document["stats"].items() if "seconds" not in name and "per_second" not in name})
        text, document = self.both("trace-check t.grtx")
        self.assertIn(f"{document['groups']} groups, {document['totals']['rays']} rays, {document['totals']['rounds']} rounds", text)
        type(self).commands_run.add("trace-dump")
        lines = [json.loads(line) for line in self.call("trace-dump t.grtx --json").stdout.splitlines()]
        self.assertEqual(len(lines), 1 + document["groups"])
        text, document = self.both("ray t.grtx --warp 0 -o ray.html")
        self.assertIn(f"ray.html: {document['rays']} rays, {document['rounds']} rounds, {document['events']} events", text.replace("\n  ", " "))
        self.assertEqual(document["bytes"], os.path.getsize(os.path.join(self.folder, "ray.html")))

    def test_3_simulations(self):
        for mode in ("cycle", "windows"):
            text, document = self.both(f"sim scene.grtx --machine paper --mode {mode}")
            text = text.replace("\n  ", " ")
            self.assertIn(f"{stat(document, 'gpu.cycles')} cycles, {stat(document, 'gpu.time_us'):.1f} us", text)
            self.assertIn(f"{stat(document, 'gpu.rt.node_visits'):.0f} node visits in {stat(document, 'gpu.rt.node_fetches'):.0f} fetches", text)
        text, document = self.both("stalls stats.json")
        for section in document:
            self.assertIn(section["title"], text)
            for label in section["bars"]:
                self.assertIn(label, text)
        text, document = self.both(f"run {VIEW} -o out")
        for design, statistics in document["designs"].items():
            row = re.search(rf"^{design} +{NUMBER} +({NUMBER}) +({NUMBER}) +({NUMBER}) ", text, re.M)
            cycles = statistics["gpu.cycles"]["value"]
            self.assertEqual(float(row[1]), cycles)
            self.assertAlmostEqual(float(row[2]), document["designs"]["baseline"]["gpu.cycles"]["value"] / cycles, delta=0.0051)
            self.assertAlmostEqual(float(row[3]), statistics["gpu.rt.node_visits"]["value"] * 1e-6, delta=0.00051)

    def test_4_cost(self):
        for arguments in ("--machine paper", "--machine ada-share --items --depth 9", "--config " + os.path.join(ROOT, "configs", "small.toml")):
            self.both(f"cost {arguments}")
        text, document = self.both("cost --machine paper --design grtx")
        rows = text.split("module ")[1].split("\n\n")[0].splitlines()[1:]
        self.assertEqual(len(rows), len(list(nodes(document["tree"], 3))))
        for row, node in zip(rows, nodes(document["tree"], 3)):
            cells = row.split()
            cells = cells[2:] if cells[1].startswith("x") else cells[1:]
            self.assertEqual(row.split()[0], node["name"])
            self.assertEqual(cells[:2], [str(node["flip_flop_bits"]), str(node["memory_bits"])])
            area = node["area_mm2"]
            for cell, value in zip(cells[2:], (node["gate_equivalents"]["central"] * 1e-3, area["low"], area["central"], area["high"],
                                               node["leakage_mw"]["central"], node["slowest_ns"])):
                self.assertAlmostEqual(float(cell), value, delta=max(0.00051, 0.5 * 10.0 ** -len(cell.partition(".")[2]) * 1.01))
        text, document = self.both("cost --machine paper --stats stats.json")
        self.assertGreater(len(document["parts"]), 8)
        for part in document["parts"]:
            row = re.search(rf"^{re.escape(part['part'])} +({NUMBER}) +({NUMBER}) +({NUMBER}) +({NUMBER}) +({NUMBER})%$", text, re.M)
            self.assertAlmostEqual(float(row[1]), part["actions"], delta=0.51)
            self.assertAlmostEqual(float(row[3]), part["nanojoules"]["central"] * 1e-3, delta=0.0051)
            self.assertAlmostEqual(float(row[5]), 100 * part["nanojoules"]["central"] / document["frame_nanojoules"]["central"], delta=0.051)
            self.assertIn(part["action"], text)

    def test_5_sweeps(self):
        text, document = self.both("sweep plan.toml -o s.sqlite")
        self.assertTrue(text.startswith(f"{document['points']} points: {document['status']['done']} done; s.sqlite\n"
                                        "2 traces made, 1 structure built for them\n\nfront of time against the area of the chip\n"), text)
        self.assertRegex(text, r"least time #\d+, least area #\d+, least\s+energy a ray #\d+")
        self.assertEqual((document["traces_made"], document["structures_built"]), (0, 0))  # all was there
        self.assertEqual(document["points"], 4)
        text, document = self.both("sweep plan.toml -o s.sqlite --list")
        self.assertEqual([line.split()[0] for line in text.splitlines()[:-1] if not line.startswith(" ")], [point["key"] for point in document["points"]])
        self.assertEqual({point["status"] for point in document["points"]}, {"done"})
        self.call("sweep plan.toml -o other.sqlite --mode windows --quiet")
        text, document = self.both("sweep --compare s.sqlite other.sqlite", code=1)
        self.assertEqual(len(document["differences"]), len(re.findall(r"^\S", text, re.M)))
        self.assertRegex(re.sub(r"\s+", " ", text), r"point [0-9a-f]+ \([^)]*warp_buffer\.entries[^)]*\) is only in s\.sqlite")
        self.assertNotIn("value ", text)  # of points that one database lacks
        text, document = self.both("search search.toml -o n.sqlite")
        front = text.split("\nfront")[1].split("\n\n")[0]
        self.assertEqual(len(document["front"]), front.count("   evaluation"))
        first = document["candidates"][document["front"][0]]["confirming"]["ratios"]
        self.assertIn("".join(f"{ratio:.4f} " for ratio in first).strip(), re.sub(" +", " ", front))
        text, document = self.both("regress cases")
        self.assertEqual(text, "".join(f"{case['case']}: equal, {case['compared']} statistics\n" for case in document["cases"]) +
                         "2 cases: 2 equal, 0 differ, 0 recorded, 0 refused\n")
        record = os.path.join(self.folder, "cases", "records.tsv")
        with open(record, encoding="utf-8") as file:
            statistics = file.read()
        with open(record, "w", encoding="utf-8") as file:
            lines = [line.split("\t") for line in statistics.splitlines()]
            row = next(line for line in lines if line[0] == "gpu.rt.node_fetches")
            row[lines[0].index("tiny")] = "7"
            changed = "".join("\t".join(line) + "\n" for line in lines)
            self.assertNotEqual(changed, statistics)
            file.write(changed)
        text, document = self.both("regress cases", code=1)
        case = next(case for case in document["cases"] if case["case"] == "tiny")
        self.assertEqual((case["outcome"], case["differences"][0]["statistic"], case["differences"][0]["recorded"]),
                         ("differs", "gpu.rt.node_fetches", 7))
        self.assertIn(str(case["differences"][0]["found"]), text)
        text, document = self.both("report s.sqlite -o r.html")
        self.assertEqual((text, document["report"], document["inputs"]), ("", "r.html", ["s.sqlite"]))
        with open(os.path.join(self.folder, "measured.csv"), "w", encoding="utf-8") as file:
            file.write("scene,design,over,rt.warp_buffer.entries,value\nelsewhere,grtx,sw,4,2\n")
        text, document = self.both("correlate measured.csv s.sqlite")
        figure = document["comparisons"][0]
        self.assertEqual(figure["measured"], 2)
        self.assertIn(f"{figure['simulated']:.4g}", text)

    def test_6_selftest(self):
        text = self.call("selftest --json")
        document = json.loads(text.stdout)
        self.assertEqual([step["ok"] for step in document["steps"]], [True] * 5)
        self.assertEqual((document["ok"], text.returncode), (True, 0))
        type(self).commands_run.add("selftest")

    def test_6_machine(self):
        document = json.loads(self.call("machine paper --json").stdout)
        self.assertIn(document["schema"], self.reference())
        lines = {line.split()[0]: line for line in self.call("machine paper").stdout.splitlines() if line.startswith("rt.memory.")}
        for key in lines:
            value = document["keys"][key]["value"]
            self.assertIn("not set" if value == 0 and "not set" in lines[key] else str(value).lower(), lines[key].lower())
        type(self).commands_run.add("machine")

    def test_7_every_command_was_run_and_is_in_the_reference(self):
        names = re.findall(r"^  ([a-z][a-z-]*) ", self.call("--help").stdout.split("Subcommands:")[1], re.M)
        self.assertEqual(set(names), self.commands_run)
        self.assertEqual(re.findall(r"^\| `([a-z-]+)`", self.reference(), re.M), names)

    def test_8_lists_in_markdown_have_no_json(self):
        for arguments in ("sim --list-config", "sim --list-statistics", "cost --coefficients"):
            done = self.call(f"{arguments} --json")
            self.assertEqual((done.returncode, done.stdout), (2, ""))
            self.assertRegex(done.stderr, r"^grtx: --json: needs [^\n]*\n$")

    def test_9_pages_name_each_key_and_statistic_that_the_program_lists(self):
        stale = subprocess.run([sys.executable, f"{ROOT}/scripts/generate_docs.py", "--check", PROGRAM], capture_output=True, text=True)
        self.assertEqual((stale.returncode, stale.stderr), (0, ""))

        def names(text):
            for name in re.findall(r"^[|*] `([a-z][^`]*)` [|(]", text, re.M):
                before, braces, after = re.match(r"([^{]*)(?:\{([^}]*)\})?(.*)", name).groups()
                yield from (before + part + after for part in (braces or "").split(","))

        for page, arguments in (("configuration", "sim --list-config"), ("statistics", "sim --list-statistics")):
            with open(f"{ROOT}/docs/model/{page}.md", encoding="utf-8") as file:
                generated = re.search(r"<!-- generated.*<!-- end of generated", file.read(), re.S).group()
            listed = list(names(self.call(arguments).stdout))
            self.assertGreater(len(listed), 100)
            self.assertCountEqual(names(generated), listed)


if __name__ == "__main__":
    PROGRAM = os.path.abspath(sys.argv.pop(1))
    unittest.main()
