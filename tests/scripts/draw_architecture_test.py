#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""scripts/draw_architecture.py gives each row of the page a box, and --check finds a box without a row, and a file that moved."""
import contextlib
import io
import os
import sys
import tempfile
import unittest

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
sys.path.insert(0, os.path.join(ROOT, "scripts"))
import draw_architecture

PAGE = draw_architecture.PAGE
WINDOWS = "| Windows | [rtl_tlm/estimate/windows/window_simulation.h]"


class ThePictureThatNobodyDrewAgain(unittest.TestCase):
    def said(self, change=lambda page: page):
        with open(PAGE, encoding="utf-8") as file:
            page = file.read()
        with tempfile.TemporaryDirectory() as folder:
            draw_architecture.PAGE = os.path.join(folder, "architecture.md")
            self.addCleanup(setattr, draw_architecture, "PAGE", PAGE)
            changed = change(page)
            with open(draw_architecture.PAGE, "w", encoding="utf-8") as file:
                file.write(changed)
            out = io.StringIO()
            sys.argv[1:] = ["--check"]
            with contextlib.redirect_stdout(out):
                code = draw_architecture.main()
            with contextlib.suppress(draw_architecture.Fault):
                self.picture = draw_architecture.drawn()
            self.assertEqual(code, 0 if changed == page else 1)
            return out.getvalue()

    def test_the_page_as_it_is_fits(self):
        self.assertEqual(self.said(), "")

    def test_a_new_unit_takes_a_spare_place(self):
        new = "| Node buffer | [rtl_tlm/gpu/gpu.h](../rtl_tlm/gpu/gpu.h) | new | |\n"
        said = self.said(lambda page: page.replace("| Crossbar |", new + "| Crossbar |"))
        self.assertEqual(said, "docs/images/architecture.svg: out of date: run scripts/draw_architecture.py\n")
        self.assertIn(">Node buffer</text>", self.picture)

    def test_more_new_rows_than_there_is_room_for(self):
        new = "".join(f"| Mode {i} | [rtl_tlm/gpu/gpu.h](../rtl_tlm/gpu/gpu.h) | gone | |\n" for i in range(3))
        said = self.said(lambda page: page.replace(WINDOWS, new + WINDOWS))
        self.assertEqual(said.count("\n"), 1)
        self.assertIn("Mode 2: a row of docs/architecture.md for which the picture has no spare place left", said)

    def test_a_box_without_a_row(self):
        self.assertIn("Windows: a place in the picture without a row",
                      self.said(lambda page: page.replace(WINDOWS, WINDOWS.replace("Windows", "Stride"))))

    def test_a_row_whose_file_moved(self):
        self.assertIn("out of date", self.said(lambda page: page.replace(
            "(../rtl_tlm/estimate/windows/window_simulation.h)", "(../rtl_tlm/estimate/window_simulation.h)")))


if __name__ == "__main__":
    unittest.main()
