# SPDX-License-Identifier: Apache-2.0
"""Pages of results are held to docs/results/data: with another figure in any row that a page rests on, its tables or sentences are faults."""
import csv
import io
import os
import shutil
import sys
import tempfile
import unittest

TOP = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
sys.path.insert(0, os.path.join(TOP, "scripts"))
import page_data  # noqa: E402
import readme_tables  # noqa: E402
import rtl_tables  # noqa: E402
import show_tables  # noqa: E402
import silicon_tables  # noqa: E402
import vulkan_tables  # noqa: E402
import windows_tables  # noqa: E402


def faults(top, scripts, page):
    """Of one page: of its sentences, and of its generated tables."""
    for script in scripts:
        yield from script.faults(top)
    if readme_tables.renewed(top, page) != readme_tables.model_version.read(top, page):
        yield f"{page}: other tables"


def other(cell):
    """Half as much again; a whole number stays one."""
    return f"{float(cell) * 1.5:.0f}" if cell.isdigit() else f"{float(cell) * 1.5:.9g}"


class PagesAndData(unittest.TestCase):
    def unnoticed(self, page, data, scripts, columns, kind, beside=()):
        """Kinds of figures (values of the columns `kind`, and the changed one) of which none, when it is another, is a fault of the page."""
        with tempfile.TemporaryDirectory() as top:
            for name in (page, *(os.path.join(page_data.FOLDER, file) for file in (data, *beside)), silicon_tables.POINTS):
                os.makedirs(os.path.dirname(os.path.join(top, name)), exist_ok=True)
                shutil.copy(os.path.join(TOP, name), os.path.join(top, name))
            self.assertEqual(list(faults(top, scripts, page)), [])
            rows = page_data.rows(top, data)
            kinds, noticed = set(), set()
            for number, row in enumerate(rows):
                for column in (column for column in columns if row[column] not in ("", "0")):
                    this = (*(row[name] for name in kind), column)
                    kinds.add(this)
                    if this not in noticed and self.is_fault(top, scripts, page, data, [*rows[:number], {**row, column: other(row[column])}, *rows[number + 1:]]):
                        noticed.add(this)
            self.assertGreater(len(kinds), 0)
            return sorted(kinds - noticed)

    def is_fault(self, top, scripts, page, data, rows):
        self.write(top, data, rows)
        return any(faults(top, scripts, page))

    @staticmethod
    def write(top, data, rows):
        text = io.StringIO()
        writer = csv.DictWriter(text, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
        with open(os.path.join(top, page_data.FOLDER, data), "w", encoding="utf-8") as file:
            file.write(text.getvalue())

    def test_another_count_beside_vulkan_sim_is_a_fault_of_its_page(self):
        self.assertEqual(self.unnoticed("docs/results/vulkan-sim.md", vulkan_tables.DATA, [vulkan_tables], ("ours", "theirs"), ("setting", "quantity")), [])

    def test_another_figure_of_its_readings_on_paper_is_a_fault(self):
        self.assertEqual(self.unnoticed("docs/results/vulkan-sim.md", vulkan_tables.READINGS, [vulkan_tables],
                                        ("cycles", "l2_accesses", "node_latency", "node_fetches"), ("reading",)), [])

    def test_another_figure_of_a_crop_on_a_card_is_a_fault_of_its_page(self):
        frames = ("silicon-frames.csv", "silicon-frames-show.csv")
        self.assertEqual(self.unnoticed("docs/results/silicon.md", silicon_tables.DATA, [silicon_tables], ("cycles",),
                                        ("plan", "machine", "accel", "kernel_degree", "k", "tracing"), beside=frames), [])
        for file in frames:
            self.assertEqual(self.unnoticed("docs/results/silicon.md", file, [silicon_tables], ("crop", "frame"), ("scene", "tracer.kernel_degree", "accel"),
                                            beside=(silicon_tables.DATA, *(set(frames) - {file}))), [])

    def test_another_count_of_a_crop_of_more_pixels_is_a_fault_of_its_page(self):
        self.assertEqual(self.unnoticed("docs/results/designs-show.md", show_tables.SIZE, [show_tables], ("cycles", "tail_cycles"), ("design",)), [])

    def test_other_gates_or_another_clock_of_the_rtl_are_a_fault_of_its_page(self):
        self.assertEqual(self.unnoticed("docs/results/rtl.md", rtl_tables.DATA, [rtl_tables], ("rtl", "low", "model", "high", "path_ns", "mhz_low", "mhz_high", "cycles"),
                                       ("part",)), [])

    def test_another_figure_of_a_machine_that_was_fitted_is_a_fault_of_readings(self):
        page = "docs/results/readings.md"
        self.assertEqual(self.unnoticed(page, "fit_public.csv", [], ("value",), ("machine",), beside=("fit.csv",)), [])
        unnoticed = self.unnoticed(page, "fit.csv", [], ("value",), ("machine",), beside=("fit_public.csv",))
        self.assertNotIn(("paper", "value"), unnoticed)
        self.assertNotIn(("queue", "value"), unnoticed)

    def test_another_case_of_windows_is_a_fault_of_its_page(self):
        self.assertEqual(self.unnoticed(windows_tables.PAGE, windows_tables.DATA, [windows_tables], ("error", "width"), ("what",)), [])
        self.assertEqual(self.unnoticed(windows_tables.PAGE, windows_tables.FRAME, [windows_tables], ("cycles", "cycles_high"), ("mode",)), [])

    def test_another_picture_is_a_fault_of_the_page_of_designs(self):
        self.assertEqual(self.unnoticed("docs/results/designs-show.md", show_tables.PICTURES, [show_tables], ("dB",), ("view",),
                                        beside=(os.path.basename(show_tables.DATA),)), [])
        rows = [{**row, "picture": "another"} if show_tables.called(row) == "grtx" else row for row in page_data.rows(TOP, show_tables.PICTURES)]
        with tempfile.TemporaryDirectory() as top:
            os.makedirs(os.path.join(top, page_data.FOLDER))
            shutil.copy(os.path.join(TOP, show_tables.DATA), os.path.join(top, show_tables.DATA))
            self.write(top, show_tables.PICTURES, [{**row, "dB": row["dB"] or "99"} for row in rows])
            self.assertIn("99.0, 99.0, 99.0, 99.0, 99.0", show_tables.pictures(top))

    def test_a_whole_frame_beside_the_walk_in_the_mode_that_both_have(self):
        made = show_tables.frame(TOP).splitlines()
        [entry] = [line.split(" | ") for line in made if line.startswith("| by entry, near | 64 |")]
        rows = {(show_tables.called(row), row["mode"]): row for row in page_data.rows(TOP, show_tables.FRAME) if row["k"] == "64"}
        cycles = [float(rows[name, "cycle"]["cycles"]) for name in ("by entry, near", "walk, near")]
        self.assertIn(f"{cycles[0] / cycles[1]:.2f}", entry)
        self.assertIn(f"{float(rows['by entry, near', 'windows']['cycles']) / 1365e3:.1f}", entry)

    def test_so_many_digits(self):
        self.assertEqual([page_data.significant(value) for value in (0.0504, 0.9996, 6.534, 9.996, 46.49, 115.2, 1234.5)],
                         ["0.0504", "1.00", "6.53", "10.0", "46.5", "115", "1,230"])


if __name__ == "__main__":
    unittest.main()
