"""Reads what the program `grtx` writes: statistics, results and sweeps as pandas frames, and traces.

Plots are in ``grtx_tlm.plots``, which needs matplotlib. Guide: docs/guide/python.md.
"""
from .errors import GrtxError, StatisticsError, TraceError
from .frames import DESIGNS, Results, read_results, read_statistics, read_sweep
from .trace import EVENT_KINDS, OUTCOMES, RayGroup, Trace, read_trace

__all__ = ["DESIGNS", "EVENT_KINDS", "OUTCOMES", "GrtxError", "RayGroup", "Results", "StatisticsError", "Trace", "TraceError",
           "read_results", "read_statistics", "read_sweep", "read_trace"]
