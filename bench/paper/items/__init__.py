# SPDX-License-Identifier: Apache-2.0
"""The items of the artifact; each is a module with TITLE and build(study, page), and a section of a page."""
from . import configuration, cost, memory, rounds, secondary, sensitivity, speedup, vendors

ITEMS = {"configuration": configuration, "rounds": rounds, "speedup": speedup, "memory": memory,
         "sensitivity": sensitivity, "cost": cost, "secondary": secondary, "vendors": vendors}

# Pages and their sections: file, title, items.
PAGES = [("paper-speedup.md", "Speed-up, and where it comes from", ("configuration", "rounds", "speedup", "memory")),
         ("paper-variations.md", "Sensitivity, cost, other rays and other RT units",
          ("sensitivity", "cost", "secondary", "vendors"))]
PAGE_OF = {item: file for file, _, sections in PAGES for item in sections}
