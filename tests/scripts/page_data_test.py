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
import vulkan_tables  # noqa: E402


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
            for name in (page, *(os.path.join(page_data.FOLDER, file) for file in (data, *beside))):
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
        text = io.StringIO()
        writer = csv.DictWriter(text, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
        with open(os.path.join(top, page_data.FOLDER, data), "w", encoding="utf-8") as file:
            file.write(text.getvalue())
        return any(faults(top, scripts, page))

    def test_another_count_beside_vulkan_sim_is_a_fault_of_its_page(self):
        self.assertEqual(self.unnoticed("docs/results/vulkan-sim.md", vulkan_tables.DATA, [vulkan_tables], ("ours", "theirs"), ("setting", "quantity")), [])

    def test_another_figure_of_its_readings_on_paper_is_a_fault(self):
        self.assertEqual(self.unnoticed("docs/results/vulkan-sim.md", vulkan_tables.READINGS, [vulkan_tables],
                                        ("cycles", "l2_accesses", "node_latency", "node_fetches"), ("reading",)), [])


if __name__ == "__main__":
    unittest.main()
