#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""python/notebooks/main_figure.ipynb runs from end to end, and its figure has the numbers of its runs.

    python_notebook_test.py GRTX       Exit code 77: a Python package is missing.
"""
import json
import os
import sys
import tempfile
import unittest

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
NOTEBOOK = os.path.join(ROOT, "python", "notebooks", "main_figure.ipynb")
try:
    import ipykernel  # noqa: F401  (nbclient starts it)
    import matplotlib  # noqa: F401
    import nbformat
    import pandas  # noqa: F401
    from nbclient import NotebookClient
except ImportError as error:
    print(f"skipped: {error}; Debian packages: python3-nbclient python3-nbformat python3-ipykernel")
    sys.exit(77)

PROGRAM = ""


class MainFigure(unittest.TestCase):
    def test_it_runs_and_shows_the_speedups(self):
        with tempfile.TemporaryDirectory() as folder:
            os.environ.update(GRTX=PROGRAM, GRTX_NOTEBOOK_FOLDER=folder, IPYTHONDIR=folder, MPLCONFIGDIR=folder,
                              JUPYTER_RUNTIME_DIR=folder, PYTHONDONTWRITEBYTECODE="1",
                              PYTHONPATH=os.path.join(ROOT, "python"))
            notebook = nbformat.read(NOTEBOOK, as_version=4)
            sizes = next(cell for cell in notebook.cells if "count, pixels = 60_000, 48\n" in cell.source)
            sizes.source = sizes.source.replace("60_000, 48", "6_000, 16")  # two minutes are for readers
            self.assertFalse(any(cell.get("outputs") for cell in notebook.cells), "the notebook is kept without outputs")
            NotebookClient(notebook, timeout=600, kernel_name="python3",
                           resources={"metadata": {"path": folder}}).execute()
            outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
            tables = " ".join(output.data.get("text/plain", "") for output in outputs if "data" in output)
            for preset in ("hall", "building", "object"):
                with open(os.path.join(folder, preset, "results.json"), encoding="utf-8") as file:
                    speedup = json.load(file)["speedup"]
                for design in ("sw", "hw", "grtx"):
                    self.assertRegex(tables, rf"\b{preset}\b.*\b{round(speedup[design], 2):g}0?\b")
            self.assertEqual(sum("image/png" in output.get("data", {}) for output in outputs), 2)
            self.assertIn("visit_internal", tables)
            with open(os.path.join(folder, "main_figure.png"), "rb") as file:
                self.assertEqual(file.read(8), b"\x89PNG\r\n\x1a\n")


if __name__ == "__main__":
    PROGRAM = os.path.abspath(sys.argv.pop(1))
    unittest.main()
