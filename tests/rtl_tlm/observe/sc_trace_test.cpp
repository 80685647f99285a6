// SPDX-License-Identifier: Apache-2.0
// SystemC's own sc_trace works beside this model: a user's module that watches an SM is traced into a standard file.
#include <gtest/gtest.h>

#include <systemc>

#include "grtx/base/atomic_file.h"
#include "grtx/modules/simt/simt_core.h"
#include "grtx/rtl_tlm/gpu/gpu.h"
#include "grtx/rtl_tlm/run/trace_source.h"
#include "paths.h"
#include "rtl_tlm/observe/observed_run.h"
#include "rtl_tlm/observe/vcd_reader.h"

namespace grtx::sim {
namespace {

/// What a user writes: a signal that follows the model, sensitive to the core clock's tick.
class WarpCounter final : public sc_core::sc_module {
 public:
  using SC_CURRENT_USER_MODULE = WarpCounter;  // SC_HAS_PROCESS, which SystemC 3 deprecates
  WarpCounter(const sc_core::sc_module_name& name, const Gpu& gpu) : sc_module(name), gpu_(gpu) {
    SC_METHOD(look);
    sensitive << gpu.core().tick();
    dont_initialize();
  }
  sc_core::sc_signal<unsigned> resident{"resident"};
  unsigned most = 0;

 private:
  void look() {
    const unsigned warps = dynamic_cast<const modules::SimtCore&>(gpu_.sms()[0]->simt()).resident();
    most = std::max(most, warps);
    resident.write(warps);
  }
  const Gpu& gpu_;
};

TEST(ScTrace, RecordsAUsersSignal) {
  const test::ObservedRun run;
  const auto cycles = test::statistic(run.run({}), "gpu.cycles");
  ChildProcess child("simulation", [&] {
    modules::set_time_resolution_to_fs();
    const traces::Reader reader(run.path("t.grtx"));
    std::vector<std::uint64_t> groups(reader.group_count());
    for (std::size_t i = 0; i < groups.size(); ++i) groups[i] = i;
    TraceSource source(reader, groups);
    const GpuConfig config = load_config(grtx::paths::source_dir() + "/configs/small.toml", {});
    Gpu gpu("gpu", config, reader.header(), reader.totals().max_evictions_per_ray, source, {});
    const PauseAtEnd pause("pause_at_end", gpu);
    const auto memory = memory_system(kBuiltInMemory)(gpu, {});
    WarpCounter counter("counter", gpu);
    sc_core::sc_trace_file* file = sc_core::sc_create_vcd_trace_file(run.path("user").c_str());
    file->set_time_unit(1, sc_core::SC_FS);
    sc_core::sc_trace(file, counter.resident, "resident");
    sc_core::sc_start();  // the GPU pauses the kernel at its end
    sc_core::sc_close_vcd_trace_file(file);
    return std::to_string(gpu.distributor().end_cycle()) + " " + std::to_string(counter.most);
  });
  const std::string result = child.result();
  EXPECT_EQ(std::stoull(result), cycles);  // watching changed nothing
  const std::string text = read_file(run.path("user.vcd"));
  EXPECT_NE(text.find("resident"), std::string::npos);
  // The file's changes reach the most warps that were resident.
  const unsigned long most = std::stoul(result.substr(result.find(' ')));
  unsigned long largest = 0;
  for (std::size_t at = text.find("\nb"); at != std::string::npos; at = text.find("\nb", at + 1)) {
    largest = std::max(largest, std::stoul(text.substr(at + 2, text.find(' ', at) - at - 2), nullptr, 2));
  }
  EXPECT_GT(most, 0U);
  EXPECT_EQ(largest, most);
}

}  // namespace
}  // namespace grtx::sim
