// SPDX-License-Identifier: Apache-2.0
// Readers of what reports are made of.
#include "fuzz/readers.h"
#include "fuzz/result_seeds.h"
#include "grtx/report/page/run_results.h"
#include "grtx/report/page/sweep_results.h"

namespace grtx::fuzzing {

const std::vector<InputReader>& report_readers() {
  static const std::vector<InputReader> all = {
      {"run_results", "r.json", [](const std::string& path) { (void)report::read_run_results(path); }, nullptr,
       [] { return std::vector<std::string>{kStatistics}; }},
      {"database", "d.sqlite", [](const std::string& path) { (void)report::read_sweep_results(path); }, nullptr,
       [] { return std::vector<std::string>{database()}; }},
  };
  return all;
}

}  // namespace grtx::fuzzing
