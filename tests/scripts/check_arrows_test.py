#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""scripts/check_arrows.py finds each kind of include that goes the wrong way, and names its line."""
import os
import subprocess
import sys
import tempfile
import unittest

SCRIPT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scripts", "check_arrows.py")
TREE = {
    "base/error.h": "#pragma once\n",
    "explore/sweep/database.h": '#include "grtx/base/error.h"\n',
    "report/page/report.h": '#include "grtx/explore/sweep/database.h"\n',
    "experiment/run_designs.h": '#include "grtx/frontend/tracer/tracer.h"\n#include "grtx/report/page/report.h"\n',
    "traces/reader.h": '#include "grtx/base/error.h"\n',
    "traces/reader.cpp": '#include "grtx/traces/codec/columns.h"\n#include "grtx/traces/reader.h"\n',
    "traces/codec/columns.h": '#include "grtx/traces/reader.h"\n',
    "frontend/tracer/tracer.h": '#include <vector>\n\n#include "grtx/traces/reader.h"\n',
    "modules/kernel/link.h": '#include "grtx/base/error.h"\n',
    "modules/cache/l1_cache.h": '#include "grtx/modules/kernel/link.h"\n',
    "rtl_tlm/gpu/gpu.h": '#include "grtx/modules/cache/l1_cache.h"\n',
    "rtl_tlm/estimate/windows/window_run.h": '#include "grtx/rtl_tlm/gpu/gpu.h"\n',
    "rtl_tlm/estimate/mode.h": '#include "grtx/rtl_tlm/estimate/windows/window_run.h"\n',
    "apps/grtx/main.cpp": '#include "grtx/frontend/tracer/tracer.h"\n#include "grtx/rtl_tlm/gpu/gpu.h"\n',
}


class CheckArrows(unittest.TestCase):
    def faults(self, changes):
        with tempfile.TemporaryDirectory() as top:
            for name, text in {**TREE, **changes}.items():
                os.makedirs(os.path.dirname(os.path.join(top, name)), exist_ok=True)
                with open(os.path.join(top, name), "w", encoding="utf-8") as file:
                    file.write(text)
            run = subprocess.run([sys.executable, SCRIPT, top], capture_output=True, text=True)
            self.assertEqual(run.stderr, "")
            self.assertEqual(run.returncode, 1 if run.stdout else 0)
            return run.stdout.splitlines()

    def test_a_sound_tree_has_none(self):
        self.assertEqual(self.faults({}), [])

    def test_an_arrow_upward(self):
        for file, text, rule in [
            ("base/error.h", "modules/kernel/link.h", "base stands not above modules"),
            ("explore/sweep/database.h", "report/page/report.h", "explore stands not above report"),
            ("report/page/report.h", "experiment/run_designs.h", "report stands not above experiment"),
            ("explore/sweep/database.h", "frontend/tracer/tracer.h", "explore stands not above frontend"),
            ("modules/kernel/link.h", "rtl_tlm/gpu/gpu.h", "modules stands not above rtl_tlm"),
            ("modules/kernel/link.h", "frontend/tracer/tracer.h", "modules stands not above frontend"),
            ("frontend/tracer/tracer.h", "modules/kernel/link.h", "frontend stands not above modules"),
            ("rtl_tlm/gpu/gpu.h", "frontend/tracer/tracer.h", "rtl_tlm stands not above frontend"),
            ("rtl_tlm/gpu/gpu.h", "apps/grtx/main.cpp", "rtl_tlm stands not above apps"),
        ]:
            planted = f'// Two lines before it.\n\n#  include "grtx/{text}"\n'
            self.assertEqual(self.faults({file: planted}), [f"{file}:3: includes {text}, but {rule}"])

    def test_a_header_that_is_not_named_after_its_config_or_interface(self):
        for file, text, declared in [
            ("modules/rt_unit/x/decide/any_hit_config.h", "struct AnyHitCollectorConfig {\n};\n", "AnyHitConfig"),
            ("modules/rt_unit/x/rt_port_if.h", "class port_if : public I {\n};\n", "(rt_port(_in)?_if|RtPortModule)"),
        ]:
            self.assertEqual(self.faults({file: text}), [f"{file}: declares no {declared}, after which it would be named"])
            named = text.replace("AnyHitCollector", "AnyHit").replace("port_if", "rt_port_if")
            self.assertEqual(self.faults({file: named}), [])

    def test_counters_that_stand_with_another_unit(self):
        counters = "struct StackCounters {\n  static const CounterTable<StackCounters>& table();\n};\n"
        for folder in ("rt_unit/stack/stack_unit.h", "rt_unit/part/warp_counters.h"):
            file = f"modules/{folder}"
            self.assertEqual(self.faults({file: counters}),
                             [f"{file}: declares StackCounters, which belong into NAME_config.h or NAME_counters.h of their unit"])
        for name in ("stack_counters.h", "stack_unit_counters.h"):
            self.assertEqual(self.faults({f"modules/rt_unit/stack/decide/{name}": counters}), [])

    def test_a_readme_that_does_not_say_what_its_folders_include(self):
        head = "| folder | holds | includes, beside `base` |\n|---|---|---|\n"
        page = head + "| [cache/](cache/) | caches | {} |\n| [kernel/](kernel/) | links | |\n"
        self.assertEqual(self.faults({"modules/README.md": page.format("`kernel`")}), [])
        self.assertEqual(self.faults({"modules/README.md": page.format("")}),
                         ["modules/README.md: cache/ includes kernel, which its row does not say"])
        self.assertEqual(self.faults({"modules/README.md": page.format("`kernel`, `noc`")}),
                         ["modules/README.md: cache/ includes no noc, though its row says so"])
        self.assertEqual(self.faults({"modules/README.md": head + "| [cache/](cache/) | caches | `kernel` |\n"}),
                         ["modules/README.md: kernel/ has no row"])

    def test_a_circle_between_folders_of_modules(self):
        self.assertEqual(self.faults({"modules/kernel/link.h": '\n#include "grtx/modules/cache/l1_cache.h"\n'}), [
            "modules/cache/l1_cache.h:1: includes modules/kernel/link.h, "
            "an arrow of the circle modules/cache -> modules/kernel -> modules/cache",
            "modules/kernel/link.h:2: includes modules/cache/l1_cache.h, "
            "an arrow of the circle modules/cache -> modules/kernel -> modules/cache"])

    def test_a_circle_over_three_folders_inside_rtl_tlm(self):
        circle = "rtl_tlm/estimate -> rtl_tlm/estimate/windows -> rtl_tlm/gpu -> rtl_tlm/estimate"
        faults = self.faults({"rtl_tlm/gpu/gpu.h": '#include "grtx/rtl_tlm/estimate/mode.h"\n'})
        self.assertEqual(len(faults), 3, faults)
        self.assertIn(f"rtl_tlm/gpu/gpu.h:1: includes rtl_tlm/estimate/mode.h, an arrow of the circle {circle}", faults)

    def test_a_public_header_of_traces_that_shows_the_codec(self):
        faults = self.faults({"traces/reader.h": '#include "grtx/traces/codec/columns.h"\n'})
        self.assertEqual(len(faults), 2)
        self.assertIn("traces/reader.h:1: includes traces/codec/columns.h, "
                      "an arrow of the circle traces -> traces/codec -> traces", faults)

    def test_the_codec_included_by_another_folder(self):
        for file in ("frontend/tracer/tracer.h", "rtl_tlm/gpu/gpu.h", "report/page/report.h", "experiment/run_designs.h", "apps/grtx/main.cpp"):
            self.assertEqual(self.faults({file: '#include "grtx/traces/codec/columns.h"\n'}),
                             [f"{file}:1: includes traces/codec/columns.h, but traces/codec is seen by traces alone"])

    def test_a_circle_through_a_decide_folder(self):
        circle = "modules/cache -> modules/noc -> modules/cache"
        self.assertEqual(self.faults({
            "modules/cache/l1_cache.h": '#include "grtx/modules/noc/crossbar.h"\n',
            "modules/noc/crossbar.h": '#include "grtx/modules/cache/decide/tags.h"\n',
            "modules/cache/decide/tags.h": "#pragma once\n",
        }), [f"modules/cache/l1_cache.h:1: includes modules/noc/crossbar.h, an arrow of the circle {circle}",
             f"modules/noc/crossbar.h:1: includes modules/cache/decide/tags.h, an arrow of the circle {circle}"])

    def test_a_unit_and_its_own_decisions_are_no_circle(self):
        self.assertEqual(self.faults({
            "modules/cache/decide/tags.cpp": '#include "grtx/modules/cache/decide/policies/fifo.h"\n',
            "modules/cache/decide/policies/fifo.h": '#include "grtx/modules/cache/decide/tags.h"\n',
            "modules/cache/decide/tags.h": "#pragma once\n",
        }), [])

    def test_decisions_that_need_systemc(self):
        self.assertEqual(self.faults({
            "modules/kernel/link.h": "#include <systemc>\n",
            "modules/cache/decide/tags.h": '#include "grtx/modules/cache/l1_cache.h"\n',
        }), ["modules/cache/decide/tags.h: stands in a decide/, but includes modules/cache/l1_cache.h -> modules/kernel/link.h -> systemc"])

    def test_an_include_that_is_not_from_the_top_or_leads_nowhere(self):
        self.assertEqual(self.faults({"modules/cache/l1_cache.h": '#include "link.h"\n'}),
                         ["modules/cache/l1_cache.h:1: includes link.h, which is not written from the top (grtx/...)"])
        self.assertEqual(self.faults({"modules/cache/l1_cache.h": '#include "grtx/modules/none.h"\n'}),
                         ["modules/cache/l1_cache.h:1: includes modules/none.h, which does not exist"])


if __name__ == "__main__":
    unittest.main()
