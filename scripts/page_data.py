# SPDX-License-Identifier: Apache-2.0
"""What scripts that hold pages of results to docs/results/data share: rows of a file there, and sentences that a page must have."""
import csv
import math
import os

import model_version

FOLDER = os.path.join("docs", "results", "data")


def rows(top, name):
    """None where the file is not there: a tree of a test, or a figure that is not measured yet."""
    path = os.path.join(top, FOLDER, name)
    if not os.path.exists(path):
        return None
    with open(path, encoding="utf-8", newline="") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def unsaid(top, page, data, sentences):
    """A fault for each of the sentences, which the data give, that the page does not have; bold and the ends of lines count as nothing."""
    if os.path.exists(os.path.join(top, page)):
        text = " ".join(model_version.read(top, page).replace("*", "").split())
        for words in sentences:
            if words not in text:
                yield f"{page}:1: does not have '{words}', which {data} gives"


def significant(value, digits=3):
    """So many digits, thousands apart, none behind the point where those before it are enough."""
    rounded = float(f"{value:.{digits}g}")
    return f"{rounded:,.{max(0, digits - 1 - math.floor(math.log10(rounded)))}f}"
