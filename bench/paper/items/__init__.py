# SPDX-License-Identifier: Apache-2.0
"""The items of the artifact in the paper's order; each is a module with TITLE and build(study, page)."""
from . import configuration, cost, memory, objects, rounds, secondary, sensitivity, sequences, speedup, vendors

ITEMS = {"configuration": configuration, "rounds": rounds, "speedup": speedup, "memory": memory,
         "sensitivity": sensitivity, "cost": cost, "secondary": secondary, "vendors": vendors, "objects": objects, "sequences": sequences}
