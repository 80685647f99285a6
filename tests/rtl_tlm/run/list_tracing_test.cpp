// SPDX-License-Identifier: Apache-2.0
// Lists of hits in memory: the shader scans a list for each batch that it blends.
#include <gtest/gtest.h>

#include "frontend/tracer/random_scene.h"
#include "grtx/base/child_process.h"
#include "paths.h"
#include "rtl_tlm/observe/observed_run.h"
#include "rtl_tlm/traced_view.h"

namespace grtx::sim {
namespace {

using test::statistic;

class ListTracing : public ::testing::Test {
 protected:
  static void write(const std::string& path, frontend::Tracing tracing, unsigned capacity) {
    frontend::TracerOptions options;
    options.tracing = tracing;
    options.k = options.list_capacity = capacity;
    test::write_view(path, grtx::test::random_scene(67, {.count = 400, .sh_degree = 1}),
                     grtx::test::front_camera(32, 16, 2.0), 32, 16, frontend::AccelKind::tlas_sphere, options);
  }
  static nlohmann::ordered_json run(frontend::Tracing tracing, unsigned capacity,
                                    const std::vector<std::string>& settings = {}) {
    const traces::testing::TemporaryFile file("list");
    write(file.path(), tracing, capacity);
    return test::small_statistics(file.path(), settings);
  }
};

// Traversal and what is written are those of a single round; what differs is how blending finds its order.
TEST_F(ListTracing, VisitsAndHitsAreThoseOfASingleRound) {
  const auto list = run(frontend::Tracing::list, 1024), single = run(frontend::Tracing::single, 1024);
  for (const char* same : {"gpu.rt.node_visits", "gpu.rt.any_hit_calls", "gpu.simt.lsu.stores.ray",
                           "gpu.simt.processed", "gpu.simt.blended", "gpu.simt.lsu.loads.sh"}) {
    EXPECT_EQ(statistic(list, same), statistic(single, same)) << same;
  }
  EXPECT_LT(statistic(list, "gpu.simt.lsu.stores.k_buffer"), statistic(single, "gpu.simt.lsu.stores.k_buffer"))
      << "a merge sort writes";
  EXPECT_EQ(statistic(list, "gpu.simt.k_buffer_mismatches"), 0U);
}

TEST_F(ListTracing, ShorterBatchesAreMoreScans) {
  const auto scans = [&](const char* batch) { return run(frontend::Tracing::list, 1024, {batch}); };
  const auto few = scans("simt.list_batch=64"), many = scans("simt.list_batch=4");
  EXPECT_GT(statistic(many, "gpu.simt.phases.sort"), statistic(few, "gpu.simt.phases.sort"));
  EXPECT_GT(statistic(many, "gpu.simt.lsu.loads.k_buffer"), statistic(few, "gpu.simt.lsu.loads.k_buffer"));
  EXPECT_EQ(statistic(many, "gpu.simt.blended"), statistic(few, "gpu.simt.blended"));
}

}  // namespace
}  // namespace grtx::sim
