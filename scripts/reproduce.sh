#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# The paper, figure by figure: runs everything, writes docs/results/paper, exit code 1 when a figure leaves its tolerance.
# Options: --help. Plans, claims and tolerances: bench/paper.
top=$(cd "$(dirname "$0")/.." && pwd)
PYTHONPATH="$top/bench${PYTHONPATH:+:$PYTHONPATH}" PYTHONDONTWRITEBYTECODE=1 exec python3 -m paper "$@"
