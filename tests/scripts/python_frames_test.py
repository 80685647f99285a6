#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""python/grtx_tlm: frames have the numbers of the files, as numbers; plots draw them; what is wrong is named.

    python_frames_test.py GRTX       Exit code 77: a Python package is missing.
"""
import dataclasses
import json
import os
import pathlib
import re
import shutil
import sqlite3
import subprocess
import sys
import tempfile
import unittest

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
sys.path.insert(0, os.path.join(ROOT, "python"))
try:
    import matplotlib
    matplotlib.use("Agg")
    import numpy as np
    import pandas as pd
    import grtx_tlm
    from grtx_tlm import plots
except ImportError as error:
    print(f"skipped: {error}; Debian packages: python3-numpy python3-pandas python3-matplotlib")
    sys.exit(77)

PROGRAM = ""
PLAN = """mode = "cycle"
designs = ["baseline", "grtx"]
[[scene]]
name = "s"
file = "s.ply"
cameras = "s.cameras.json"
width = 8
height = 8
[grid]
"l1.bytes" = [32768, 131072]
"""


def grtx(*arguments):
    done = subprocess.run([PROGRAM, *arguments], capture_output=True, text=True)
    if done.returncode != 0:
        raise AssertionError(f"grtx {' '.join(arguments)}: {done.stderr}")


class Frames(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.path = staticmethod(lambda name: os.path.join(folder.name, name))
        grtx("synth", "--preset", "object", "--count", "400", "--seed", "1", "-o", cls.path("s.ply"), "--quiet")
        grtx("run", "--scene", cls.path("s.ply"), "--cameras", cls.path("s.cameras.json"), "--width", "8", "--height", "8",
             "--designs", "baseline,sw,hw,grtx,gautracer", "--k", "8", "-o", cls.path("run"), "--quiet")
        trace = next(f for f in os.listdir(cls.path("run")) if f.endswith(".grtx"))
        grtx("sim", os.path.join(cls.path("run"), trace), "--stats", cls.path("stats.json"), "--quiet")
        with open(cls.path("plan.toml"), "w", encoding="utf-8") as file:
            file.write(PLAN)
        grtx("sweep", cls.path("plan.toml"), "-o", cls.path("s.sqlite"), "--quiet")

    def trace(self):
        return self.path(os.path.join("run", next(f for f in os.listdir(self.path("run")) if f.endswith(".grtx"))))

    def document(self, name):
        with open(self.path(name), encoding="utf-8") as file:
            return json.load(file)

    def raw(self, name):
        with open(self.path(name), "rb") as file:
            return file.read()

    def test_a_call_runs_the_program_and_gives_frames(self):
        trace = self.trace()
        frame = grtx_tlm.simulate(trace, {"l1.bytes": 65536}, program=PROGRAM)
        self.assertEqual(frame.attrs["config"]["l1.bytes"], 65536)
        self.assertEqual(frame.attrs["inputs"]["mode"], "cycle")
        with self.assertRaises(grtx_tlm.ProgramError) as caught:
            grtx_tlm.simulate(trace, {"l1.byte": 1}, program=PROGRAM)
        self.assertEqual(caught.exception.code, 2)
        self.assertIn("unknown key 'l1.byte', the nearest is 'l1.bytes'", str(caught.exception))
        with self.assertRaises(grtx_tlm.ProgramError) as caught:
            grtx_tlm.simulate(trace, mode="sampled", program=PROGRAM)
        self.assertEqual(caught.exception.code, 2)
        self.assertIn("mode 'sampled' is gone: use cycle; of whole frames, windows", str(caught.exception))
        results = grtx_tlm.run(self.path("s.ply"), self.path("s.cameras.json"), program=PROGRAM, width=8, height=8,
                               designs="baseline,sw,hw,grtx,gautracer", k=8)
        self.assertEqual(results.statistics.loc["gpu.cycles"].tolist(),
                         grtx_tlm.read_results(self.path("run")).statistics.loc["gpu.cycles"].tolist())

    def test_files_whose_names_begin_with_a_dash_are_no_options(self):
        here = os.getcwd()
        os.chdir(os.path.dirname(self.path("x")))
        self.addCleanup(os.chdir, here)
        shutil.copy("s.ply", "-h")
        shutil.copy("s.cameras.json", "--quiet")
        results = grtx_tlm.run("-h", "--quiet", output="-o", designs="sw", width=8, height=8, program=PROGRAM)
        self.assertEqual(results.statistics.shape, grtx_tlm.read_results("-o").statistics.shape)
        shutil.move("-o/sw.grtx", "-T")
        frame = grtx_tlm.simulate("-T", timeline="--t.json", program=PROGRAM)
        self.assertGreater(frame.loc["gpu.cycles", "value"], 0)
        self.assertTrue(os.path.exists("--t.json"))

    def test_many_runs_are_one_tidy_frame(self):
        trace = self.trace()
        many = grtx_tlm.simulate_all({"a": trace, "b": trace}, {"l1.bytes": [32768, 65536], "rt.prefetch.enabled": True},
                                     ["gpu.cycles", "gpu.l1.all.hit_rate"], jobs=2, program=PROGRAM, mode="cycle")
        self.assertEqual(list(many.columns), ["trace", "l1.bytes", "rt.prefetch.enabled", "mode", "gpu.cycles",
                                              "gpu.l1.all.hit_rate"])
        self.assertEqual(many["l1.bytes"].tolist(), [32768, 65536] * 2)
        self.assertEqual(many["gpu.cycles"].dtype, "int64")
        self.assertEqual(many.attrs["units"]["gpu.cycles"], "cycles")
        self.assertEqual(grtx_tlm.speedup(many, {"trace": "a"}).tolist(), [1.0] * 4)
        for _, row in many.iterrows():
            alone = grtx_tlm.simulate(trace, {"l1.bytes": row["l1.bytes"], "rt.prefetch.enabled": True}, program=PROGRAM,
                                      mode="cycle")
            self.assertEqual(row["gpu.cycles"], alone.loc["gpu.cycles", "value"])

    def test_the_course_of_a_run_is_a_frame(self):
        trace = self.trace()
        frame = grtx_tlm.simulate(trace, program=PROGRAM)
        course = grtx_tlm.over_time(frame)
        self.assertEqual(course.index.name, "end_of_interval")
        self.assertEqual(course.index[-1], frame.loc["gpu.cycles", "value"])
        self.assertEqual(course.attrs["units"]["dram.bytes_per_cycle"], "B/cycle")
        lengths = pd.Series(course.index).diff().fillna(course.index[0]).to_numpy()
        self.assertGreater((course["dram.bytes_per_cycle"] * lengths).sum(), 0)

    def test_integers_are_exact_and_null_is_nan(self):
        document = self.document("stats.json")
        document["stats"]["gpu.cycles"]["value"] = 2**53
        document["stats"]["gpu.l2.hit_rate"]["value"] = None
        with open(self.path("large.json"), "w", encoding="utf-8") as file:
            json.dump(document, file)
        value = grtx_tlm.read_statistics(self.path("large.json"))["value"]
        self.assertEqual(int(value["gpu.cycles"]), 2**53)
        self.assertTrue(np.isnan(value["gpu.l2.hit_rate"]))

    # All values were objects: a ratio raised ZeroDivisionError, nlargest TypeError.
    def test_numbers_are_numbers_in_every_frame(self):
        statistics = grtx_tlm.read_statistics(self.path("stats.json"))
        course = grtx_tlm.simulate(self.trace(), program=PROGRAM)
        grtx("run", "--scene", self.path("s.ply"), "--cameras", self.path("s.cameras.json"), "--width", "8", "--height", "8",
             "--views", "0:1", "--designs", "baseline,grtx,gautracer", "--mode", "cycle", "-o", self.path("two"), "--quiet")
        results, sequence = grtx_tlm.read_results(self.path("run")), grtx_tlm.read_results(self.path("two"))
        sweep = grtx_tlm.read_sweep(self.path("s.sqlite"))
        many = grtx_tlm.simulate_all(self.trace(), {"l1.bytes": [32768, 65536]}, program=PROGRAM)
        frames = {"statistics": statistics, "over_time": grtx_tlm.over_time(course), "results": results.statistics,
                  "frames": sequence.frames, "speedup": results.speedup.to_frame(), "sweep": sweep, "many": many,
                  "shares": plots.stall_shares(results.statistics)}
        for name, frame in frames.items():
            self.assertFalse(frame.empty, name)
            for column in frame:
                text = frame[column].dropna().map(type).eq(str).all() and len(frame[column].dropna()) > 0
                self.assertTrue(text or column == "reason" or pd.api.types.is_numeric_dtype(frame[column]), f"{name}: {column}")
        self.assertEqual(sequence.frames.shape, (2, 3))
        with np.errstate(all="ignore"):
            ratio = results.statistics["baseline"] / results.statistics["grtx"]
        self.assertEqual(ratio["gpu.cycles"], results.speedup["grtx"])
        self.assertEqual(results.statistics.loc["gpu.cycles"].nlargest(1).index[0], "baseline")
        self.assertEqual(statistics["value"].nlargest(1).iloc[0], statistics["value"].max())
        self.assertGreater(sweep["l1.bytes"].corr(sweep["cost.mm2"]), 0)

    def test_a_coordinate_that_some_points_lack_is_a_number_with_nan(self):
        for values, kind in (([1, None, 2], "float64"), ([1, 2, 3], "int64"), ([2**70, 1, 2], "float64"),
                             ([True, False, True], "bool"), ([True, None, False], "boolean"), ([None, None], "float64"),
                             (["off", None, 3], "object"), ([0.5, 1, 2], "float64")):
            with self.subTest(values):
                column = grtx_tlm.frames.numbers(values)
                self.assertEqual(column.dtype, kind)
                self.assertEqual(column.isna().tolist(), [value is None for value in values])

    def test_arrays_ranges_and_series_are_axes(self):
        axes = ({"l1.bytes": np.array([32768, 65536]), "gpu.sms": range(1, 3)},
                {"l1.bytes": pd.Series([32768, 65536]), "gpu.sms": (1, 2)}, {"l1.bytes": [32768, 65536], "gpu.sms": [1, 2]})
        frames = [grtx_tlm.simulate_all(pathlib.Path(self.trace()), settings, "gpu.cycles", 2, program=PROGRAM,
                                        mode=np.array(["cycle"])) for settings in axes]
        self.assertEqual(list(frames[0].columns), ["trace", "l1.bytes", "gpu.sms", "mode", "gpu.cycles"])
        self.assertEqual(frames[0]["l1.bytes"].tolist(), [32768, 32768, 65536, 65536])
        for other in frames[1:]:
            pd.testing.assert_frame_equal(frames[0], other)
        for wrong, words in (([], "l1.bytes: an axis needs a value"), (np.ones((2, 2)), "l1.bytes: an axis is a value")):
            with self.assertRaisesRegex(ValueError, words):
                grtx_tlm.simulate_all(self.trace(), {"l1.bytes": wrong}, program=PROGRAM)

    def test_one_text_is_one_name_not_its_letters(self):
        self.assertEqual(grtx_tlm.read_sweep(self.path("s.sqlite"), "gpu.cycles").columns[-1], "gpu.cycles")
        one = grtx_tlm.simulate_all(self.trace(), values="gpu.cycles", program=PROGRAM, mode="cycle")
        self.assertEqual((one["trace"].tolist(), one["mode"].tolist()), ([os.path.basename(self.trace())], ["cycle"]))
        with self.assertRaisesRegex(TypeError, "settings: must be {key: value}"):
            grtx_tlm.simulate(self.trace(), "l1.bytes=1", program=PROGRAM)
        both = grtx_tlm.run(self.path("s.ply"), self.path("s.cameras.json"), {"l1.bytes": 65536}, designs="grtx", width=8,
                            height=8, program=PROGRAM)
        self.assertEqual((list(both.statistics), both.config["l1.bytes"]), (["grtx"], 65536))

    def test_two_traces_of_one_name_are_two_rows(self):
        os.makedirs(self.path("copy"), exist_ok=True)
        copy = shutil.copy(self.trace(), self.path("copy"))
        many = grtx_tlm.simulate_all([self.trace(), copy], values=["gpu.cycles"], program=PROGRAM)
        self.assertEqual(many["trace"].tolist(), [self.trace(), copy])

    def test_lists_are_options_of_several_values(self):
        given = {"designs": ["baseline", "grtx"], "glass": np.array([-1.0, 0.5]), "heatmap": ["cycles", "cycles=a.png"],
                 "flatten": True, "k": np.int64(4), "warp": None, "config": pathlib.Path("a.toml")}
        self.assertEqual(list(grtx_tlm.program.options(given)),
                         ["--designs=baseline,grtx", "--glass=-1.0,0.5", "--heatmap=cycles", "--heatmap=cycles=a.png",
                          "--flatten", "--k=4", "--config=a.toml"])
        self.assertEqual(list(grtx_tlm.program.settings({"a": True, "b": np.bool_(False), "c": 1.5})),
                         ["--set=a=true", "--set=b=false", "--set=c=1.5"])

    def test_an_unknown_name_is_told_with_what_is_near(self):
        sweep = grtx_tlm.read_sweep(self.path("s.sqlite"))
        calls = [(lambda: grtx_tlm.read_sweep(self.path("s.sqlite"), "gpu.cycle"), "'gpu.cycle'; near it: gpu.cycles"),
                 (lambda: grtx_tlm.simulate_all(self.trace(), values=["gpu.cycle"], program=PROGRAM),
                  "values: there is no 'gpu.cycle'; near it: gpu.cycles"),
                 (lambda: plots.plot_pareto(sweep, "cost.mm3"), "'cost.mm3'; near it: cost.mm2"),
                 (lambda: plots.pareto_front(sweep, "cost.mm2", "gpu.time"), "'gpu.time'; near it: gpu.time_us"),
                 (lambda: plots.plot_error_against_time(sweep, "second", "gpu.cycles"), "'second'; near it: seconds"),
                 (lambda: grtx_tlm.over_time(sweep), "takes a frame of read_statistics")]
        for call, words in calls:
            with self.subTest(words), self.assertRaisesRegex(ValueError, words):
                call()

    def test_a_refused_run_ends_the_others(self):
        with self.assertRaisesRegex(grtx_tlm.ProgramError, "unknown key 'l1.byte'"):
            grtx_tlm.simulate_all(self.trace(), {"l1.byte": range(1, 1000)}, program=PROGRAM)

    def test_results_show_what_they_are(self):
        results = grtx_tlm.read_results(self.path("run"))
        self.assertRegex(repr(results), r"^<Results: machine paper, \d+ statistics of baseline, sw, hw, grtx, gautracer; "
                                        rf"times as fast as baseline: sw {results.speedup['sw']:.2f}, .*>$")

    def test_statistics_have_the_file_s_values(self):
        frame, document = grtx_tlm.read_statistics(self.path("stats.json")), self.document("stats.json")
        self.assertEqual(list(frame.index), list(document["stats"]))
        for name, entry in document["stats"].items():
            row = frame.loc[name]
            self.assertTrue(row["value"] == entry["value"] or entry["value"] is None and pd.isna(row["value"]), name)
            self.assertEqual((row["unit"], row["description"]), (entry["unit"], entry["description"]))
        self.assertEqual(frame.attrs["config"], document["config"])
        self.assertEqual(frame.attrs["notes"], document["notes"])
        self.assertIn("partial-launch", [note["id"] for note in frame.attrs["notes"]])

    def test_a_design_is_that_of_the_run_and_of_no_other_trace(self):
        results = grtx_tlm.read_results(self.path("run"))
        options = {"design": "gautracer", "mode": self.document("run/results.json")["inputs"]["gautracer"]["mode"],
                   "program": PROGRAM}
        frame = grtx_tlm.simulate(self.path("run/gautracer.grtx"), **options)
        self.assertEqual(frame.loc["gpu.cycles", "value"], results.statistics.loc["gpu.cycles", "gautracer"])
        with self.assertRaises(grtx_tlm.ProgramError) as caught:
            grtx_tlm.simulate(self.path("run/baseline.grtx"), **options)
        self.assertIn("is not of design gautracer: accel is tri20, not ellipsoid", str(caught.exception))

    def test_results_have_the_file_s_values(self):
        results, document = grtx_tlm.read_results(self.path("run")), self.document("run/results.json")
        self.assertEqual(list(results.statistics.columns), ["baseline", "sw", "hw", "grtx", "gautracer"])
        for design, stats in document["designs"].items():
            for name in ("gpu.cycles", "tracer.rays", "gpu.l1.node.hit_rate"):
                self.assertEqual(results.statistics.loc[name, design], stats[name]["value"])
        cycles = results.statistics.loc["gpu.cycles"]
        self.assertEqual(results.notes, document["notes"])
        self.assertEqual(set(results.notes), set(document["designs"]))
        for design in ("sw", "hw", "grtx"):
            self.assertEqual(results.speedup[design], document["speedup"][design])
            self.assertAlmostEqual(results.speedup[design], cycles["baseline"] / cycles[design], places=12)
        self.assertEqual(results.quantities.loc["gpu.cycles", "unit"], document["designs"]["sw"]["gpu.cycles"]["unit"])
        self.assertTrue(results.images_identical)

    def test_a_sweep_has_the_database_s_values(self):
        frame = grtx_tlm.read_sweep(self.path("s.sqlite"))
        database = sqlite3.connect(self.path("s.sqlite"))
        self.assertEqual(len(frame), 4)
        self.assertEqual(sorted(zip(frame["design"], frame["l1.bytes"])),
                         [(d, b) for d in ("baseline", "grtx") for b in (32768, 131072)])
        rows = database.execute("SELECT point_id, name, value FROM value").fetchall()
        self.assertGreater(len(rows), 1000)
        for point, name, value in rows:
            self.assertEqual(frame.loc[point, name], value)
        few = grtx_tlm.read_sweep(self.path("s.sqlite"), ["gpu.cycles"])
        self.assertTrue(few["gpu.cycles"].equals(frame["gpu.cycles"]))
        self.assertNotIn("cost.mm2", few)
        self.assertEqual(frame.attrs["units"]["gpu.cycles"], "cycles")
        self.assertTrue(frame["notes"].str.contains("partial-launch").all())
        database.close()

    def test_a_speed_up_is_over_any_key(self):
        sweep = grtx_tlm.read_sweep(self.path("s.sqlite"), ["gpu.cycles", "cost.mm2"])
        cycles = {(d, b): c for d, b, c in zip(sweep["design"], sweep["l1.bytes"], sweep["gpu.cycles"])}
        over_design = grtx_tlm.speedup(sweep, {"design": "baseline"})
        over_key = grtx_tlm.speedup(sweep, {"l1.bytes": 32768})
        for point, row in sweep.iterrows():
            own = cycles[row["design"], row["l1.bytes"]]
            self.assertEqual(over_design[point], cycles["baseline", row["l1.bytes"]] / own)
            self.assertEqual(over_key[point], cycles[row["design"], 32768] / own)
        self.assertTrue(grtx_tlm.speedup(sweep, {"design": "walk"}).isna().all())
        lines = plots.plot_over(sweep, "l1.bytes", {"design": "baseline"}).get_lines()
        self.assertEqual([line.get_label() for line in lines], ["baseline", "grtx"])
        self.assertEqual(list(lines[0].get_ydata()), [1.0, 1.0])
        with self.assertRaisesRegex(ValueError, "l1.byte"):
            grtx_tlm.speedup(sweep, {"l1.byte": 1})

    def test_a_sweep_of_two_keys_has_a_line_per_value(self):
        rows = [{"design": "grtx", "scene": "room", "notes": "", "l1.bytes": b, "tracer.k": k, "gpu.cycles": 100.0 * k / b}
                for b in (2, 1, 4) for k in (8, 16)]
        sweep = pd.DataFrame(rows)
        sweep.attrs["units"] = {"gpu.cycles": "cycles"}
        lines = plots.plot_over(sweep, "l1.bytes", {"l1.bytes": 1}).get_lines()
        self.assertEqual([(line.get_label(), list(line.get_xdata()), list(line.get_ydata())) for line in lines],
                         [(f"grtx, tracer.k = {k}", [1, 2, 4], [1.0, 2.0, 4.0]) for k in (8, 16)])
        self.assertNotEqual(lines[0].get_color(), lines[1].get_color())

    def test_a_front_has_names_and_a_limit(self):
        sweep = pd.DataFrame({"design": "grtx", "l1.bytes": [1, 2, 4], "area": [1.0, 2.0, 3.0], "time": [9.0, 4.0, 6.0]})
        ax = plots.plot_pareto(sweep, "area", "time", label="l1.bytes", limit=2.5)
        self.assertEqual([text.get_text() for text in ax.texts], ["1", "2"])
        self.assertEqual(list(ax.get_lines()[-1].get_xdata()), [2.5, 2.5])
        with self.assertRaisesRegex(ValueError, "l1.byte"):
            plots.plot_pareto(sweep, "area", "time", label="l1.byte")

    def test_gautracer_and_walk_have_a_speed_up_over_k(self):
        with open(self.path("k.toml"), "w", encoding="utf-8") as file:
            file.write(PLAN.replace('"grtx"', '"gautracer", "walk"').replace('"l1.bytes" = [32768, 131072]', '"tracer.k" = [4, 96]'))
        grtx("sweep", self.path("k.toml"), "-o", self.path("k.sqlite"), "--quiet")
        frame = grtx_tlm.read_sweep(self.path("k.sqlite"), ["gpu.cycles"])
        self.assertNotIn("simt.payload_registers", frame)
        self.assertEqual(grtx_tlm.speedup(frame, {"design": "baseline", "tracer.k": 4}).notna().sum(), 6)
        # Registers that somebody sets are told apart.
        with open(self.path("k.toml"), encoding="utf-8") as file:
            plan = file.read().replace('"baseline", ', "") + '[set]\n"simt.payload_registers" = 255\n'
        with open(self.path("k.toml"), "w", encoding="utf-8") as file:
            file.write(plan)
        grtx("sweep", self.path("k.toml"), "-o", self.path("k.sqlite"), "--quiet")
        frame = grtx_tlm.read_sweep(self.path("k.sqlite"), ["gpu.cycles"])
        self.assertEqual(frame[frame["design"] == "walk"]["simt.payload_registers"].tolist(), [12, 255, 255])

    def test_points_of_two_plans_and_machines_are_told_apart(self):
        path = self.path("edited.sqlite")
        for machine, width in (("paper", 8), ("paper-charged", 16)):
            with open(self.path("edited.toml"), "w", encoding="utf-8") as file:
                file.write(PLAN.replace("width = 8", f"width = {width}") + f'[set]\n"gpu.sms" = {width // 4}\n')
            grtx("sweep", self.path("edited.toml"), "-o", path, "--machine", machine, "--quiet")
        frame = grtx_tlm.read_sweep(path, ["gpu.time_us", "cost.mm2"])
        self.assertEqual(frame["machine"].tolist(), ["paper"] * 4 + ["paper-charged"] * 4)
        self.assertEqual(frame["earlier_plan"].tolist(), [True] * 4 + [False] * 4)
        self.assertEqual((frame["mode"].unique().tolist(), frame.attrs["shared"]["height"]), (["cycle"], 8))
        self.assertTrue(set(plots.pareto_front(frame, "cost.mm2", "gpu.time_us").index) <= {5, 6, 7, 8})
        self.assertEqual(sum(len(dot.get_offsets()) for dot in plots.plot_pareto(frame).collections), 4)
        # On one machine the plans differ in what they set.
        grtx("sweep", self.path("plan.toml"), "-o", path, "--machine", "paper-charged", "--quiet")
        frame = grtx_tlm.read_sweep(path, [])
        charged = frame[frame["machine"] == "paper-charged"]
        self.assertEqual(charged["width"].tolist(), [16] * 4 + [8] * 4)
        self.assertEqual(charged["gpu.sms"].tolist(), [4] * 4 + [8] * 4)
        self.assertEqual(charged["earlier_plan"].tolist(), [True] * 4 + [False] * 4)

    def test_plots_show_the_numbers(self):
        results, sweep = grtx_tlm.read_results(self.path("run")), grtx_tlm.read_sweep(self.path("s.sqlite"))
        bars = plots.main_figure({"s": results}, pd.Series({"sw": 2.0, "hw": 1.94, "grtx": 4.36})).patches
        self.assertEqual([bar.get_height() for bar in bars], list(results.speedup[["sw", "hw", "grtx", "gautracer"]]))
        shares = plots.stall_shares(results.statistics)
        self.assertTrue((abs(shares.sum() - 1) < 1e-12).all())
        self.assertEqual(len(plots.plot_stalls(results.statistics).patches), shares.size)
        self.assertEqual(list(plots.stall_shares(grtx_tlm.read_statistics(self.path("stats.json"))).columns), ["run"])
        dots = plots.plot_pareto(sweep).collections
        self.assertEqual(sum(len(dot.get_offsets()) for dot in dots), 4)
        errors = pd.DataFrame({"speed": [1.0, 4.0, 8.0], "error": [0.0, 0.005, 0.01]})
        self.assertEqual(len(plots.plot_error_against_time(errors, "speed", "error").collections[0].get_offsets()), 2)

    def test_the_main_figure_has_every_design_and_says_over_which(self):
        # gautracer and walk were missing, runs over sw were called "over the baseline", {baseline, walk} failed.
        results = grtx_tlm.read_results(self.path("run"))
        walk = dataclasses.replace(results, speedup=pd.Series({"baseline": 1.0, "walk": 8.0}))
        axes = plots.main_figure({"s": walk})
        self.assertEqual([bar.get_height() for bar in axes.patches], [8.0])
        self.assertEqual(axes.get_ylabel(), "speed-up over the baseline")
        over_sw = dataclasses.replace(results, speedup=pd.Series({"sw": 1.0, "mine": 3.0, "grtx": 2.0}), speedup_over="sw")
        axes = plots.main_figure({"s": over_sw})
        self.assertEqual([bar.get_height() for bar in axes.patches], [2.0, 3.0])
        self.assertEqual(axes.get_ylabel(), "speed-up over sw")
        for bad, words in (({"a": walk, "b": over_sw}, "not over baseline and sw"), ({}, "not over none"),
                           ({"s": dataclasses.replace(walk, speedup=walk.speedup[:1])}, "no design but baseline")):
            with self.assertRaisesRegex(ValueError, words):
                plots.main_figure(bad)

    def test_a_design_has_one_colour_in_plots_and_on_pages(self):
        with open(os.path.join(ROOT, "report", "page", "web", "report.css"), encoding="utf-8") as file:
            pages = dict(re.findall(r"--d-(\w+): (#[0-9A-F]{6});", file.read()))
        self.assertEqual(plots.COLOURS, pages)
        self.assertEqual(list(plots.COLOURS), list(grtx_tlm.DESIGNS))

    def test_results_say_whose_pictures_differ(self):
        pictures = grtx_tlm.read_results(self.path("run")).pictures
        self.assertEqual(pictures.index.get_level_values("design").tolist(), ["baseline", "sw", "hw", "grtx", "gautracer"])
        self.assertEqual(pictures.loc[("grtx", 0), "psnr"], float("inf"))
        self.assertLess(pictures.loc[("gautracer", 0), "psnr"], 100)
        self.assertEqual(pictures.loc[("gautracer", 0), "order"], "peak")
        self.assertTrue((pictures["psnr_reference"] > 60).all())
        self.assertEqual(set(pictures["reference"]), {"fp64"})
        document = self.document("run/results.json")
        for damaged in ({"baseline": {"psnr": [1.0]}}, {"baseline": {"order": "", "psnr": [1.0], "psnr_reference": []}}):
            with open(self.path("damaged.json"), "w", encoding="utf-8") as file:
                json.dump({**document, "pictures": damaged}, file)
            with self.assertRaisesRegex(grtx_tlm.StatisticsError, "pictures.baseline: must have lists of dB"):
                grtx_tlm.read_results(self.path("damaged.json"))
        del document["pictures"]
        with open(self.path("older.json"), "w", encoding="utf-8") as file:
            json.dump(document, file)
        self.assertTrue(grtx_tlm.read_results(self.path("older.json")).pictures.empty)

    def test_several_machines_have_results_times_and_the_keys_that_differ(self):
        document = self.document("run/results.json")
        of_all = ("schema", "version", "model_version", "images", "images_identical", "pictures", "other_orders", "violations")
        first = {name: value for name, value in document.items() if name not in of_all}
        second = json.loads(json.dumps({**first, "machine": "ada"}))
        second["config"]["gpu.sms"] = 142
        second["designs"]["grtx"]["gpu.time_us"]["value"] = 0.5 * first["designs"]["grtx"]["gpu.time_us"]["value"]
        several = {**{name: document[name] for name in of_all if name in document}, "machines": [first, second],
                   "between_machines": {"over": first["machine"], "keys": {"gpu.sms": [first["config"]["gpu.sms"], 142]}},
                   "violations": ["grtx on ada: a law"]}
        with open(self.path("several.json"), "w", encoding="utf-8") as file:
            json.dump(several, file)
        results = grtx_tlm.read_results(self.path("several.json"))
        self.assertEqual(list(results.machines), [first["machine"], "ada"])
        self.assertIs(results.machines[first["machine"]], results)
        self.assertEqual(list(results.times.columns), [first["machine"], "ada"])
        self.assertAlmostEqual(results.times.loc["grtx", "ada"], 0.5 * results.times.loc["grtx", first["machine"]])
        self.assertEqual(results.times.attrs["units"]["ada"], "us")
        self.assertEqual(results.keys.loc["gpu.sms", "ada"], 142)
        self.assertEqual(results.machines["ada"].config["gpu.sms"], 142)
        self.assertEqual((results.violations, results.machines["ada"].violations), ([], ["grtx on ada: a law"]))
        self.assertIn("machines " + first["machine"] + ", ada", repr(results))
        self.assertEqual(list(grtx_tlm.read_results(self.path("run")).times.columns), [first["machine"]])

    def test_the_front_holds_what_nothing_beats(self):
        frame = pd.DataFrame({"a": [1, 2, 2, 3, 4, None], "b": [9, 5, 6, 5, 1, 0]})
        self.assertEqual(list(plots.pareto_front(frame, "a", "b").index), [0, 1, 4])

    def test_bad_files_are_named(self):
        stats = self.document("stats.json")
        stats["stats"]["gpu.cycles"] = 3
        cases = [(grtx_tlm.read_statistics, "{", "is no JSON"), (grtx_tlm.read_statistics, "[1]", "must be grtx.stats/1"),
                 (grtx_tlm.read_results, '{"schema": "grtx.stats/1"}', "must be grtx.run/2"),
                 (grtx_tlm.read_results, '{"schema": "grtx.run/1"}', "designs: must be an object"),
                 (grtx_tlm.read_results, '{"schema": "grtx.run/1", "designs": {}}', "must name a design"),
                 (grtx_tlm.read_statistics, json.dumps(stats), "stats.gpu.cycles: must have value"),
                 (grtx_tlm.read_sweep, "no database at all", "is no database of a sweep")]
        for read, text, words in cases:
            with self.subTest(words):
                with open(self.path("bad"), "w", encoding="utf-8") as file:
                    file.write(text)
                with self.assertRaisesRegex(grtx_tlm.StatisticsError, words) as caught:
                    read(self.path("bad"))
                self.assertTrue(str(caught.exception).startswith(self.path("bad") + ": "))
        for read in (grtx_tlm.read_statistics, grtx_tlm.read_results, grtx_tlm.read_sweep):
            with self.assertRaises(FileNotFoundError):
                read(self.path("missing"))
        with self.assertRaisesRegex(grtx_tlm.StatisticsError, "there is no 'gpu.cycle'"):
            grtx_tlm.read_sweep(self.path("s.sqlite"), ["gpu.cycle"])

    def test_a_sweep_is_opened_read_only(self):
        before = self.raw("s.sqlite")
        grtx_tlm.read_sweep(self.path("s.sqlite"))
        self.assertEqual(self.raw("s.sqlite"), before)


if __name__ == "__main__":
    PROGRAM = os.path.abspath(sys.argv.pop(1))
    unittest.main()
