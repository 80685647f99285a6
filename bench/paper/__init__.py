# SPDX-License-Identifier: Apache-2.0
"""The paper, figure by figure: what to run (sets.toml, items/), how (runs.py), what must come out (claims.toml,
expected.toml) and the pages that show it (page.py, figures.py). scripts/reproduce.sh starts it."""
