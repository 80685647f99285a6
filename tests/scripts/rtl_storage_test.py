#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The memories of the checkpoint unit's RTL have the bits of the inventory and of the paper's table, no more and no less; a
difference is named. Skipped without yosys.

    rtl_storage_test.py GRTX
"""
import os
import shutil
import sys
import unittest

TOP = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(TOP, "scripts"))
import rtl  # noqa: E402

GRTX = sys.argv.pop() if len(sys.argv) > 1 else ""
CONFIGURATIONS = [[], ["rt.checkpoint.write_combine=true", "rt.checkpoint.lanes=1"],
                  ["rt.checkpoint.read_buffer=true", "rt.checkpoint.entry_bytes=16", "rt.checkpoint.write_queue=7",
                   "rt.checkpoint.lanes=2"]]


class Storage(unittest.TestCase):
    def test_is_that_of_the_inventory(self):
        for settings in CONFIGURATIONS:
            config, bits, _ = rtl.model(GRTX, settings)
            memories, flip_flops, _ = rtl.checkpoint_unit(config, False)
            self.assertEqual(rtl.check_storage(bits, memories, flip_flops), [], settings)
            if not settings:
                self.assertEqual(sum(memory[0] for memory in memories.values()) + 144,
                                 1074 * 8 + 16 * (256 + 32 + 48) + 2 * 256 * 8, "the paper's table, and the queues")
                wrong = dict(bits, reads=bits["reads"] + 1, more=8)
                self.assertEqual(rtl.check_storage(wrong, memories, flip_flops + 1),
                                 ["reads: 2048 bits in the RTL, 2049 in the inventory", "more: the RTL has no such memory",
                                  "flip-flops: 521 in the RTL, 144 + 376 expected"])


if __name__ == "__main__":
    if shutil.which("yosys") is None:
        print("skipped: no yosys")
        sys.exit(77)
    unittest.main()
