# SPDX-License-Identifier: Apache-2.0
"""Runs the program `grtx` and reads what it writes: statistics, results and sweeps as pandas frames, and traces.

Plots are in ``grtx_tlm.plots``, which needs matplotlib. Guide: docs/guide/python.md.
"""
try:
    import pandas as _pandas  # noqa: F401
except ModuleNotFoundError as missing:
    raise ModuleNotFoundError(f"grtx_tlm needs {missing.name}: pip install ./python brings it, or apt install python3-pandas",
                              name=missing.name) from None

from .errors import GrtxError, ProgramError, StatisticsError, TraceError
from .frames import DESIGNS, Results, over_time, read_results, read_statistics, read_sweep, speedup
from .runs import run, simulate, simulate_all
from .trace import EVENT_KINDS, OUTCOMES, RayGroup, Trace, read_trace

__version__ = "1.1.0.dev0"
__all__ = ["DESIGNS", "EVENT_KINDS", "OUTCOMES", "GrtxError", "ProgramError", "RayGroup", "Results", "StatisticsError", "Trace",
           "TraceError", "__version__", "over_time", "read_results", "read_statistics", "read_sweep", "read_trace", "run",
           "simulate", "simulate_all", "speedup"]
