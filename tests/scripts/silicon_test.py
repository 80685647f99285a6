# SPDX-License-Identifier: Apache-2.0
"""bench/silicon.py on a small database: speeds over monolithic icosahedra beside a chart, ways over the fastest rounds."""
import csv
import json
import os
import sqlite3
import subprocess
import sys
import tempfile
import unittest
from statistics import geometric_mean

TOP = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
SCRIPT = os.path.join(TOP, "bench", "silicon.py")
sys.path.insert(0, os.path.join(TOP, "scripts"))
sys.path.insert(0, os.path.join(TOP, "bench"))
import draw_results  # noqa: E402
import silicon  # noqa: E402


class Silicon(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = os.path.join(folder.name, "ada.sqlite")
        self.chart = os.path.join(folder.name, "chart.csv")
        self.database = sqlite3.connect(self.path)
        self.addCleanup(self.database.close)
        self.database.executescript("""
            CREATE TABLE point(id INTEGER PRIMARY KEY, scene TEXT, coordinates TEXT, status TEXT);
            CREATE TABLE value(point_id INTEGER, name TEXT, value REAL);""")

    def point(self, scene, cycles, status="done", **coordinates):
        at = {"tracer." + name: value for name, value in coordinates.items() if name != "keys"} | coordinates.get("keys", {})
        number = self.database.execute("INSERT INTO point(scene, coordinates, status) VALUES (?, ?, ?)",
                                       (scene, json.dumps(at), status)).lastrowid
        self.database.execute("INSERT INTO value VALUES (?, 'gpu.cycles', ?)", (number, cycles))

    def rows(self, *arguments, code=0):
        self.database.commit()
        done = subprocess.run([sys.executable, SCRIPT, *arguments], capture_output=True, text=True)
        self.assertEqual(done.returncode, code, done.stderr)
        return done.stdout.splitlines()[2:]

    def test_structures_are_held_against_the_chart(self):
        for scene, cycles in (("room", 200), ("object", 100)):
            self.point(scene, cycles, accel="tri20", kernel_degree=4)
            self.point(scene, 100, accel="tlas-tri20", kernel_degree=4)
            self.point(scene, 1, accel="tlas-tri20", kernel_degree=4, keys={"rt.sphere.interval": 4})
        with open(self.chart, "w", encoding="utf-8") as file:
            file.write("# measured\ndesign,tracer.kernel_degree,value\ntlas-tri20,4,1\ntlas-tri20,4,1.44\n")
        self.assertEqual(self.rows("structures", self.path, "--chart", self.chart)[0],
                         "| shared icosahedron | 4 | 2.00 | 1.00 | **1.41** | 1.20 (1.00 to 1.44) | yes |")

    def test_ways_are_over_the_fastest_rounds_without_checkpoints(self):
        self.point("room", 200, accel="tri20", k=16, checkpoint="off")
        self.point("room", 100, accel="tlas-tri20", k=32, checkpoint="off")
        self.point("room", 50, accel="tlas-box", k=16, checkpoint="off", tracing="list")
        self.point("room", 125, accel="tlas-tri20", k=8, checkpoint="on")
        self.point("room", 80, accel="tlas-tri20", k=8, checkpoint="on", checkpoint_bins=4)
        self.point("room", 1, accel="tlas-tri20", k=16, checkpoint="off", status="failed")
        rows = self.rows("checkpoints", self.path)
        self.assertEqual(rows[0], "| room | 0.50 | 1.00 | 2.00 | 0.80 | 1.25 | 0.80, 1.25 |")
        self.assertTrue(rows[1].endswith("| **0.80** (0.80 to 0.80), **1.25** (1.25 to 1.25) |"), rows[1])

    def test_milliseconds_are_of_the_cards_frame_and_ratios_of_the_same_crops(self):
        self.database.executescript("""ALTER TABLE point ADD COLUMN config TEXT; ALTER TABLE point ADD COLUMN trace_key TEXT;
            CREATE TABLE trace(key TEXT, options TEXT);
            INSERT INTO trace VALUES ('t', '{"tracer": {"k": "18", "kernel_degree": 4}}');""")
        for scene, accel, cycles in (("room", "tri20", 8e6), ("room", "tlas-box", 16e6), ("hall", "tri20", 2e6), ("hall", "tlas-box", 4e6)):
            self.point(scene, cycles, accel=accel, kernel_degree=4)
            number = self.database.execute("SELECT max(id) FROM point").fetchone()[0]
            self.database.executemany("INSERT INTO value VALUES (?, ?, ?)",
                                      [(number, "gpu.rt.occupancy", 4), (number, "gpu.distributor.groups", 100)])
        self.database.execute("""UPDATE point SET trace_key = 't', config = '{"gpu.sms": 2, "rt.warp_buffer.entries": 8}'""")
        points, frames = (os.path.join(os.path.dirname(self.path), name) for name in ("points.csv", "frames.csv"))
        with open(points, "w", encoding="utf-8") as file:
            file.write("card,source,scene,design,over,quantity,tracer.kernel_degree,tracer.k,value,pixels,sms,mhz,why\n")
            for scene, design, value in (("a", "tri20", 8), ("b", "tri20", 8), ("a", "tlas-box", 20), ("b", "tlas-box", 20)):
                file.write(f"card,chart,{scene},{design},,frame.ms,4,18,{value},32000,10,1000,\n")
            file.write("card,chart,a,3dgs,,frame.ms,4,18,1,32000,10,1000,a rasteriser\n")
        with open(frames, "w", encoding="utf-8") as file:
            file.write("scene,tracer.kernel_degree,accel,crop,frame\nroom,4,tri20,10,20\nhall,4,tri20,10,20\n")
        rows = self.rows("ms", self.path, "--points", points, "--frames", frames, "--card", "card", "--fitted", "hall")
        # 8e6 cycles half full, ten crops of 3,200 rays, two of ten SMs: 8 ms, twice that as a frame.
        self.assertEqual(rows[0], "| chart | 4 | A, ms | 8 (8 to 8) | fitted, 1 | 4 | 0.50 |  |  |")
        self.assertIn("| chart | 4 | A, ms | 8 (8 to 8) | others, 1 | 16 | 2.00 |  |  |", rows)
        self.assertIn("| chart | 4 | A, ms | 8 (8 to 8) | all, 2 | 8 (4 to 16) | 1.00 | +0.0 | yes |", rows)
        self.assertTrue(any(row.startswith("| chart | 4 | D / A | 2.5 (2.5 to 2.5) | all, 2 | 2 (2 to 2) | 0.80 |") for row in rows), rows)

    def test_a_chart_of_photographs_counted_as_if_all_had_the_pixels_of_the_first(self):
        def ours(*pixels):
            lines = [{"source": "chart", "tracer.kernel_degree": "4", "tracer.k": "18", "design": "tlas-box", "scene": str(number), "value": "8",
                      "pixels": str(size), "sms": "10", "mhz": "1000"} for number, size in enumerate(pixels)]
            [(_, name, _, found)] = silicon.quantities(lines, {}, {("4", "18", "tlas-box"): {"room": 10.0}})
            self.assertEqual(name, "D, ms")
            return found["room"]
        self.assertAlmostEqual(ours(32000), 0.032)  # 10 cycles a ray of one SM, 32,000 rays, ten SMs at 1 GHz
        self.assertAlmostEqual(ours(16000, 64000), ours(32000))

    def test_points_of_an_earlier_plan_are_among_the_structures(self):
        for cycles in (900, 100):  # the first is of another size, by the same name
            self.point("room", 2 * cycles, accel="tri20", kernel_degree=4)
            self.point("room", cycles, accel="tlas-tri20", kernel_degree=4, instance_bounds="proxy")
        self.point("room", 7, accel="tlas-tri20", kernel_degree=4)
        self.database.executescript("CREATE TABLE present(point_id INTEGER PRIMARY KEY); INSERT INTO present VALUES (3), (4)")
        self.assertTrue(self.rows("structures", self.path)[0].startswith("| shared icosahedron | 4 | 2.00 |"))

    def test_spheres_by_their_interval(self):
        self.point("room", 120, accel="tlas-tri80", kernel_degree=2)
        self.point("room", 100, accel="tlas-sphere", kernel_degree=2, keys={"rt.sphere.interval": 4})
        self.assertEqual(self.rows("spheres", self.path), ["| room | 1.20 |", ""])

    def test_nothing_to_compare_is_said_by_the_code(self):
        for table in ("structures", "checkpoints", "spheres"):
            self.rows(table, self.path, code=1)


class Page(unittest.TestCase):
    def test_silicon_has_the_figures_of_cards_of_points_csv(self):
        with open(os.path.join(TOP, "docs", "results", "silicon.md"), encoding="utf-8") as file:
            text = file.read()
        with open(os.path.join(TOP, "data", "measured", "points.csv"), encoding="utf-8") as file:
            points = list(csv.DictReader(line for line in file if not line.startswith("#")))
        cards = ("no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten")[len({point["card"] for point in points})]
        self.assertIn(f"has {len(points)} points of {cards} cards", text)
        source, compared = "", 0
        for row in draw_results.table(text, "chart", "measured", "fitted, 2", "tested, 3"):
            source = row["chart"].split(",")[0] or source
            times = {}
            for point in points:
                # a chart by its name; 3dgrut's frames of scenes, which are no objects
                if point["source"].endswith(source) or (point["card"] == source and point["source"].endswith("418ad67 README")):
                    times.setdefault(point["design"], {})[point["scene"]] = float(point["value"])
            letters = [{"A": "tri20", "C": "tlas-tri20", "D": "tlas-box"}.get(letter) for letter in row[""].removesuffix(", ms").split(" / ")]
            if None in letters or letters[0] not in times:
                continue  # a single ratio
            over = times[letters[1]] if len(letters) > 1 else dict.fromkeys(times[letters[0]], 1)
            values = [value / over[scene] for scene, value in times[letters[0]].items()]
            compared += 1
            for written, value in zip(draw_results.numbers(row["measured"]), (geometric_mean(values), min(values), max(values)), strict=True):
                self.assertAlmostEqual(written, value, delta=0.0501 if len(letters) == 1 else 0.00501, msg=f"{source} {row['']}")
        self.assertEqual(compared, 14)


if __name__ == "__main__":
    unittest.main()
