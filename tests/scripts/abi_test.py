#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""scripts/abi.py: which of the names that abidiff reports as gone are of a public header, from lines as abidiff 2.2 writes them."""
import os
import sys
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scripts"))
import abi  # noqa: E402

REPORT = """Functions changes summary: 4 Removed, 45 Changed (17 filtered out), 232 Added functions
Variables changes summary: 0 Removed, 1 Changed, 0 Added variable

4 Removed functions:

  [D] 'method bool grtx::ChildProcess::wait_for(std::chrono::milliseconds) const'    {_ZNK4grtx12ChildProcess8wait_forE}
  [D] 'function std::string grtx::in_place_of(std::string_view)'    {_ZN4grtx11in_place_ofB5cxx11E}
  [D] 'function const grtx::EndHeld& std::forward<const grtx::EndHeld&>(int)'    {_ZSt7forwardIRKN4grtx7EndHeld}
  [D] 'function std::array<grtx::EnumName<grtx::Column>, 27> grtx::names<grtx::Column, 27>(int&)'    {_ZN4grtx5names}
  [D] 'method grtx::NodeSizes::NodeSizes(grtx::NodeLayout)'    {_ZN4grtx9NodeSizesC2Ev}

1 Added function:

  [A] 'method grtx::NodeSizes::NodeSizes(grtx::NodeLayout, bool)'    {_ZN4grtx9NodeSizesC2Eb}
"""
HEADERS = ["class ChildProcess { bool wait_for(std::chrono::milliseconds) const; };",
           "namespace grtx { template <class T> auto names(int&); struct EndHeld {}; }",
           "// in_place_of_it, std::forward", "struct NodeSizes { NodeSizes(NodeLayout layout); };"]


class Abi(unittest.TestCase):
    def test_a_name_of_a_public_header_that_went_is_told(self):
        self.assertEqual(len(abi.GONE.findall(REPORT)), 5)
        self.assertEqual(abi.moved(REPORT, HEADERS), (["bool grtx::ChildProcess::wait_for(std::chrono::milliseconds) const"],
                                                      ["grtx::NodeSizes::NodeSizes(grtx::NodeLayout)"]))

    def test_counts_are_abidiffs(self):
        self.assertEqual(abi.SUMMARY.findall(REPORT), [("Functions", "4", "45", "232"), ("Variables", "0", "1", "0")])

    def test_a_declaration_is_taken_apart(self):
        self.assertEqual(abi.declared("const grtx::A<int, B<2> >& grtx::m::C::operator->(grtx::D<1>)"), "grtx::m::C::operator->")
        self.assertEqual(abi.declared("grtx::A<int>::pointer grtx::A<int>::data()"), "grtx::A<>::data")
        self.assertEqual(abi.declared("grtx::m::C::~C()"), "grtx::m::C::~C")


if __name__ == "__main__":
    unittest.main()
