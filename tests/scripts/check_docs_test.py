#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""scripts/check_docs.py finds each kind of fault, and nothing in a tree without one."""
import hashlib
import os
import re
import subprocess
import sys
import tempfile
import unittest

SCRIPT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scripts", "check_docs.py")
sys.path.insert(0, os.path.dirname(SCRIPT))
import docs_prose  # noqa: E402
import draw_results  # noqa: E402
import evaluation_tables  # noqa: E402
import show_tables  # noqa: E402
SCENES = "# views\n"
HASH = hashlib.sha256(SCENES.encode()).hexdigest()[:8]
TREE = {
    "modules/cache/l1_cache.h": "// Timing: docs/model/l1_cache.md.\n",
    "docs/model/l1_cache.md": "# L1 cache\n\n## What it costs\n",
    "docs/start.md": "[L1](model/l1_cache.md#what-it-costs), `modules/cache/l1_cache.{h,md}`, `l1_cache.h`, `build/x.h`\n",
}
EXCEPTED = "docs/results/readings.md,2,2026-11-22,host is gone\n"


def evaluation(cycles=100, model=2, scenes=HASH):
    """Text of evaluation.csv: a room and an object in the paper's four designs, three times; grtx takes 1/4 of the baseline's cycles."""
    usual = {name: 1 for name in evaluation_tables.COLUMNS} | {
        "part": "paper-128", "mode": "cycle", "half_interval": 0, "generated": 0, "took_part": "", "k": 8, "model": model, "set": scenes,
        "date": "2026-11-22"}
    rows = [usual | {"machine": machine, "view": view, "class": view, "design": design, "cycles": count}
            for view in ("room", "object") for machine in ("paper", "paper-charged", "paper-lean")
            for design, count in {"baseline": 4 * cycles, "sw": 200, "hw": 200, "grtx": 100}.items()
            if machine == "paper" or design in ("hw", "grtx")]
    return "\n".join(",".join(map(str, row)) for row in [evaluation_tables.COLUMNS, *(row.values() for row in rows)]) + "\n"


HEADLINE = "docs/results/README.md"


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

    # One page of results that README quotes, measured with the present model.
    def results(self, **changes):
        cell = changes.get("cell", "2")
        cycles = changes.get("cycles", "100")
        tree = {
            "docs/start.md": "",
            "rtl_tlm/run/model_version.h": "inline constexpr int kModelVersion = 2;\n",
            "tests/rtl_tlm/run/golden.tsv": f"statistic\tsw\ngpu.cycles\t{cycles}\ngpu.queue\t{changes.get('queue', '3')}\n",
            "data/traces/records.tsv": "statistic\tsw.windows\ngpu.cycles\t7\n",
            "docs/results/data/model_versions.csv": "version,date,records,what changed\n1,2026-11-21,,first\n2,2026-11-22,HASH,second\n",
            "docs/results/readings.md": f"# R\n\n| | |\n|---|---|\n| command | x |\n| date | y |\n| model version | {cell} |\n| machine | any |\n"
                                        f"{changes.get('assumes', '| assumes | z |')}\n",
            "docs/results/data/older_pages.csv": "page,model,date,reason\n" + changes.get("excepted", ""),
            "README.md": f"# G\n\n* A room gains 3.4 ([r](docs/results/readings.md)){changes.get('said', '')}.\n",
        }
        hashed = "data/traces/records.tsv sw.windows gpu.cycles 7\ntests/rtl_tlm/run/golden.tsv sw gpu.cycles 100"
        tree["docs/results/data/model_versions.csv"] = tree["docs/results/data/model_versions.csv"].replace(
            "HASH", hashlib.sha256(hashed.encode()).hexdigest()[:16])
        return tree

    def test_figures_of_the_present_model(self):
        self.assertEqual(self.faults(self.results()), [])
        self.assertEqual(self.faults(self.results(queue="4")), [])  # pages do not quote it

    def test_golden_records_that_changed_without_a_version(self):
        self.assertEqual(self.faults(self.results(cycles="101")),
                         ['docs/results/data/model_versions.csv:1: golden records are not those of version 2: scripts/model_version.py raise "what changed"'])

    def test_a_page_of_an_older_model_that_does_not_say_so(self):
        fault = "docs/results/readings.md:1: model version 1: must be 2, 'measured with version N', or 'none' and why"
        said = dict(said=", measured with version 1")
        self.assertEqual(self.faults(self.results(cell="1", excepted=EXCEPTED, **said)), [fault])
        self.assertEqual(self.faults(self.results(cell="measured with version 1", excepted=EXCEPTED, **said)), [])
        self.assertEqual(self.faults(self.results(cell="none: images alone")), [])
        self.assertEqual(self.faults(self.results(assumes="")), ["docs/results/readings.md:1: its stamp lacks assumes (scripts/model_version.py)"])

    def test_a_page_of_an_older_model_fails_unless_a_dated_line_says_why_it_stays(self):
        said = dict(said=", measured with version 1")
        stale = ("docs/results/readings.md:1: is of version 1, the model has 2: measure again, move its figures to docs/notes, "
                 "or say in docs/results/data/older_pages.csv why it stays")
        line = "docs/results/data/older_pages.csv:2: docs/results/readings.md: "
        old = dict(cell="measured with version 1", **said)
        for cell, excepted, faults in [
                ("measured with version 1", "", [stale]),
                ("measured with version 1", EXCEPTED, []),
                ("measured with version 1", EXCEPTED.replace("2026-11-22", "soon"), [line + "needs a date and a reason"]),
                ("measured with version 1", EXCEPTED.replace("host is gone", " "), [line + "needs a date and a reason"]),
                ("measured with version 1", EXCEPTED.replace(",2,", ",1,"), [line + "was excepted for version 1, and the model has 2"])]:
            self.assertEqual(self.faults(self.results(**old | {"cell": cell}, excepted=excepted)), faults, excepted)
        in_part = self.results(cell="2, one table measured with version 1")
        self.assertEqual(self.faults(in_part), [stale])
        self.assertEqual(self.faults(self.results(excepted=EXCEPTED)), [line + "is not older than the model, or not there: the line goes"])

    def test_a_readme_that_quotes_an_older_page(self):
        self.assertEqual(self.faults(self.results(cell="measured with version 1", excepted=EXCEPTED)),
                         ["README.md:3: quotes docs/results/readings.md: must say 'measured with version 1'"])
        self.assertEqual(self.faults(self.results(cell="measured with version 1", said=", measured with version 1", excepted=EXCEPTED)), [])

    def test_a_page_of_results_that_quotes_an_older_page(self):
        tree = self.results(cell="measured with version 1", said=", measured with version 1", excepted=EXCEPTED)
        page = "# R\n\n* A room gains 3.4 ([r](readings.md)){}.\n"
        self.assertEqual(self.faults(tree | {HEADLINE: page.format("")}),
                         ["docs/results/README.md:3: quotes docs/results/readings.md: must say 'measured with version 1'"])
        self.assertEqual(self.faults(tree | {HEADLINE: page.format(", measured with version 1")}), [])

    # README of the results with the table of the evaluation.
    def evaluated(self, **changes):
        tree = {**self.results(), evaluation_tables.SET: SCENES, evaluation_tables.DATA: evaluation(**changes)}
        with tempfile.TemporaryDirectory() as top:
            os.makedirs(os.path.join(top, "docs", "results", "data"))
            with open(os.path.join(top, evaluation_tables.DATA), "w", encoding="utf-8") as file:
                file.write(tree[evaluation_tables.DATA])
            made = evaluation_tables.made(top, "headline")
        return tree | {HEADLINE: f"# R\n\n<!-- generated: scripts/readme_tables.py headline -->\n\n{made}\n<!-- end of generated -->\n"}

    def test_a_table_is_that_of_its_data(self):
        tree = self.evaluated()
        self.assertIn("| `paper-charged` | objects, 1 | 2.00 | 2.00 | 4.00 | 1.00 | 1.00 | 1.00 |", tree[HEADLINE])
        self.assertEqual(self.faults(tree), [])
        [fault] = self.faults(tree | {HEADLINE: tree[HEADLINE].replace("| 4.00 |", "| 4.50 |", 1)})
        self.assertTrue(fault.startswith("docs/results/README.md:8: is not what scripts/readme_tables.py makes of docs/results/data"), fault)
        unmeasured = {name: text for name, text in tree.items() if name != evaluation_tables.DATA}
        self.assertEqual(self.faults(unmeasured), [])  # stays as it is

    # The page of designs on views of role show and README: all views have the same speeds, and half of them with dense rays.
    def shown(self):
        speeds = {("sw", 32, ""): 2, ("hw", 16, ""): 2, ("grtx", 16, ""): 4, ("gautracer", 48, ""): 20, ("gautracer", 64, "tracer.sort_key=entry"): 40,
                  **{("gautracer", k, f"tracer.sort_key=entry{checkpoint}; tracer.child_order=near_first"): 50 + k / 8
                     for k in (48, 64) for checkpoint in ("", "; tracer.checkpoint=on")},
                  ("walk", 64, ""): 80, ("walk", 64, "tracer.child_order=near_first"): 116, ("walk", 64, "tracer.colour=frame"): 60}
        rows = [("view", "lines", "sms", "design", "k", "keys", "cycles", "rt_unit_mm2")]
        for view in (*show_tables.ROOMS, *show_tables.OBJECTS):
            for lines, less in (("128", 1), ("1080", 2)):
                for (design, k, keys), speed in {("baseline", 32, ""): 1, **speeds}.items():
                    rows.append((f"{view}-0", lines, 2, design, k, keys, 1e6 if design == "baseline" else 1e6 * less / speed, 0.9))
        data = "\n".join(",".join(map(str, row)) for row in rows) + "\n"
        with tempfile.TemporaryDirectory() as top:
            os.makedirs(os.path.join(top, "docs", "results", "data"))
            with open(os.path.join(top, show_tables.DATA), "w", encoding="utf-8") as file:
                file.write(data)
            made = show_tables.MADE["show-128"](top, "")
        readme = ("# R\n\n| design | near | far |\n|---|---|---|\n| GRTX | 4.00 | 4.00 | 2.00 | 2.00 |\n| GauTracer | 20.0 | 20.0 | 10.0 | 10.0 |\n"
                  "| the mix | 58.0 | 58.0 | 29.0 | 29.0 |\n| walk | 116.0 | 116.0 | 58.0 | 58.0 |\n| over it | **2.00** | **2.00** | **2.00** | **2.00** |\n"
                  "\nBy view 2.00 to 2.00; with both off it is 2.00, 2.00, 2.00 and 2.00.\n")
        page = f"# D\n\n<!-- generated: scripts/readme_tables.py show-128 -->\n\n{made}\n<!-- end of generated -->\n"
        return {show_tables.DATA: data, "README.md": readme, show_tables.PAGE: page}

    def test_designs_on_views_of_role_show_are_those_of_their_data(self):
        def of_show(tree):
            return [fault for fault in self.faults(tree) if "designs-show.csv" in fault or "readme_tables" in fault]
        tree = self.shown()
        self.assertIn("| walk, near | 64 | 116.00, 116.00, 116.00 | **116.00** | 116.00, 116.00 | **116.00** | 0.900 |", tree[show_tables.PAGE])
        self.assertIn("| walk over the best of by entry, near | | 2.00, 2.00, 2.00 | **2.00** | 2.00, 2.00 | **2.00** | |", tree[show_tables.PAGE])
        self.assertEqual(of_show(tree), [])
        [fault] = of_show(tree | {show_tables.PAGE: tree[show_tables.PAGE].replace("| 80.00, 80.00 |", "| 80.00, 81.00 |")})
        self.assertTrue(fault.startswith(f"{show_tables.PAGE}:16: is not what scripts/readme_tables.py makes"), fault)

    def test_a_figure_of_readme_that_the_page_of_designs_does_not_have(self):
        tree = self.shown()
        for there, wrong in [("4.00 | 4.00 | 2.00 | 2.00 |", "4.00 | 4.00 | 2.00 | 2.10 |"), ("2.00 to 2.00", "1.90 to 2.00")]:
            faults = [fault for fault in self.faults(tree | {"README.md": tree["README.md"].replace(there, wrong)}) if fault.startswith("README.md")]
            self.assertEqual(faults, [f"README.md:1: does not have '{there}', which {show_tables.DATA} gives"])

    def test_a_chart_is_that_of_its_data(self):
        page = {"docs/results/scene-classes.md": "# C\n\n![speeds](../images/results/scene-classes.svg)\n"}
        faults = self.faults(self.evaluated() | page | {"docs/images/results/scene-classes.svg": "<svg/>\n"})
        self.assertIn("docs/images/results/scene-classes.svg:1: is not what scripts/draw_results.py makes of docs/results/data: "
                      "run scripts/readme_tables.py", faults)

    # A page of results with a chart of its own table.
    CASES = ("# V\n\n![cycles](../images/results/vulkan-sim.svg)\n\n| view | descriptors | ours ÷ theirs |\n|---|---|---|\n"
             "| room, tri20 | no | 0.967 |\n| the same, box corners | yes | **1.098** |\n")

    def test_a_chart_is_that_of_the_table_of_its_page(self):
        page, chart = "docs/results/vulkan-sim.md", "docs/images/results/vulkan-sim.svg"
        drawn = draw_results.vulkan_sim("", self.CASES)
        stale = f"{chart}:1: is not what scripts/draw_results.py makes of {page}: run scripts/readme_tables.py"
        missing = f"{page}:1: has no table with columns view, descriptors, ours ÷ theirs, which scripts/draw_results.py draws"
        for text, fault in [(self.CASES, None), (self.CASES.replace("1.098", "1.198"), stale), (self.CASES.replace("| view", "| what"), missing)]:
            of_chart = [line for line in self.faults(self.results() | {page: text, chart: drawn}) if "draw_results" in line]
            self.assertEqual(of_chart, [fault] if fault else [])
        self.assertIn(">room, tri20, box corners, descriptors<", drawn)

    def test_a_mark_stands_where_its_value_is(self):
        drawn = draw_results.dots("d", [], [("a", [("c1", 1.0, None, None)], ""), ("b", [("c1", 2.0, 1.0, 4.0)], "")], (0.5, 1, 2, 4, 8), 260)
        ends = 260, draw_results.draw_units.WIDTH - 64
        self.assertEqual(re.findall(r'cx="([\d.]+)"', drawn), [f"{ends[0]:.1f}", f"{sum(ends) / 2:.1f}"])  # axis of 1 to 4: 2 is its middle
        self.assertIn(f'class="c1 span" d="M{ends[0]:.1f} 85.0 L{ends[1]:.1f} 85.0"', drawn)

    def test_a_chart_has_the_colours_of_the_pages_in_both_schemes(self):
        import model_version
        pages = re.findall(r"--c1: (#\w+)", model_version.read(model_version.TOP, "report/page/web/report.css"))
        light, _, dark = draw_results.Chart.style.fget(None).rpartition("@media (prefers-color-scheme: dark)")
        self.assertEqual([re.findall(r"\.c1\{fill:(#\w+)", part) for part in (light, dark)], [[pages[0]], [pages[1]]])

    def test_a_chart_of_the_papers_figures_is_that_of_what_is_recorded(self):
        claims = '[[claim]]\nid = "height"\nitem = "i"\nwhat = "Height"\npaper = 20.0\nsource = "Table"\nwhy = "w"\n'
        page = self.results()["docs/results/readings.md"] + "\n![r](../images/results/readings.svg)\n"
        tree = self.results() | {"docs/results/readings.md": page, "bench/paper/claims.toml": claims}
        recorded = "[quick.paper]\nheight = {}\n"
        with tempfile.TemporaryDirectory() as top:
            os.makedirs(os.path.join(top, "bench", "paper"))
            for name, text in (("claims", claims), ("expected", recorded.format(24.0))):
                with open(os.path.join(top, "bench", "paper", name + ".toml"), "w", encoding="utf-8") as file:
                    file.write(text)
            tree["docs/images/results/readings.svg"] = draw_results.readings(top, "")
        self.assertIn("1 of 1 hold", tree["docs/images/results/readings.svg"])
        self.assertEqual(self.faults(tree | {"bench/paper/expected.toml": recorded.format(24.0)}), [])
        self.assertEqual(self.faults(tree | {"bench/paper/expected.toml": recorded.format(25.0)}), [
            "docs/images/results/readings.svg:1: is not what scripts/draw_results.py makes of bench/paper: run scripts/readme_tables.py"])

    def test_a_page_of_results_opens_with_one_sentence_and_its_chart(self):
        import model_version
        for page in model_version.pages(model_version.TOP):
            if os.path.dirname(page) == "docs/results":
                name = os.path.basename(page)[:-3]
                opening = rf"# [^\n]+\n\n\*\*[^*]+\*\*\n\n!\[[^\]]+\]\(\.\./images/results/{name}\.svg\)\n"
                self.assertRegex(model_version.read(model_version.TOP, page), r"\A" + opening)

    def test_figures_of_other_scenes_or_of_another_model(self):
        rule = f"{evaluation_tables.DATA}:1: paper-128: of another "
        self.assertEqual(self.faults(self.evaluated() | {evaluation_tables.SET: "# others\n"}),
                         [rule + f"scenes, {evaluation_tables.SET} is {hashlib.sha256(b'# others' + bytes([10])).hexdigest()[:8]}: python3 bench/evaluate"])
        self.assertEqual(self.faults(self.evaluated(model=1)), [rule + "version of the model, it has 2: python3 bench/evaluate"])

    def test_data_that_a_dated_line_excepts(self):
        line = EXCEPTED.replace("docs/results/readings.md", evaluation_tables.DATA)
        older = {"docs/results/data/older_pages.csv": "page,model,date,reason\n" + line}
        self.assertEqual(self.faults(self.evaluated(model=1) | older), [])
        self.assertEqual(self.faults(self.evaluated() | older | {evaluation_tables.SET: "# others\n"}), [])
        gone = f"docs/results/data/older_pages.csv: {evaluation_tables.DATA}: is of the present scenes and model: the line goes"
        self.assertEqual(self.faults(self.evaluated() | older), [gone])
        void = f"docs/results/data/older_pages.csv:2: {evaluation_tables.DATA}: was excepted for version 1, and the model has 2"
        self.assertEqual(self.faults(self.evaluated(model=1) | {name: text.replace(",2,", ",1,") for name, text in older.items()}), [void])

    def test_a_page_whose_scenes_changed_after_its_figures(self):
        page = self.results()["docs/results/readings.md"].rstrip("\n")
        for stamp, faults in ((HASH, []), ("0123abcd", [
                f"docs/results/readings.md:1: its figures are of scenes 0123abcd, {evaluation_tables.SET} is {HASH}: python3 bench/evaluate"])):
            tree = self.evaluated() | {"docs/results/readings.md": f"{page}\n| scenes | evaluation.toml, {stamp} |\n"}
            self.assertEqual(self.faults(tree), faults)

    def test_a_header_that_its_readme_does_not_name(self):
        tree = {"base/README.md": "# base\n\n[a.h](a.h)\n\n<!-- generated: scripts/readme_tables.py headers -->\n\n| header | holds |\n"
                                  "|---|---|\n<!-- end of generated -->\n", "base/a.h": "// One thing. More of it.\n"}
        self.assertEqual(self.faults(self.results() | tree | {"base/README.md": tree["base/README.md"].replace("<!-- end", "\n<!-- end")}), [])
        [fault] = self.faults(self.results() | tree | {"base/b/c.h": "// Another: of them.\n#pragma once\n"})
        self.assertTrue(fault.endswith("of headers: | [b/c.h](b/c.h) | Another |"), fault)

    def test_the_next_version_marks_what_is_older(self):
        import model_version
        with tempfile.TemporaryDirectory() as top:
            for name, text in self.results(cycles="101").items():
                os.makedirs(os.path.dirname(os.path.join(top, name)), exist_ok=True)
                with open(os.path.join(top, name), "w", encoding="utf-8") as file:
                    file.write(text)
            self.assertEqual(len(list(model_version.faults(top))), 1)
            model_version.rise(top, "third")
            self.assertEqual(model_version.current(top), 3)
            [stale] = model_version.faults(top)
            self.assertIn("docs/results/readings.md:1: is of version 2, the model has 3", stale)
            self.assertIn("| model version | measured with version 2 |", model_version.read(top, "docs/results/readings.md"))
            self.assertIn("measured with version 2", model_version.read(top, "README.md").lower())

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

    def test_a_readme_that_is_long(self):
        for lines, faults in [(70, []), (71, ["README.md:71: 71 lines, more than 70"])]:
            self.assertEqual(self.faults({"docs/start.md": "", "README.md": "# G\n" + "\n" * (lines - 1)}), faults)
        self.assertEqual(self.faults({"docs/start.md": "", "modules/README.md": "# M\n" * 71}), [])

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
