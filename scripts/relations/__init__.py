# SPDX-License-Identifier: Apache-2.0
"""The relations of scripts/metamorphic.py, a file per kind."""
from . import costs, images, laws, resources, surroundings, sweeps  # noqa: F401
from .case import RELATIONS, Broken, Case, Image  # noqa: F401
