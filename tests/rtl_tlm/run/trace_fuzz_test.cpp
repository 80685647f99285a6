// SPDX-License-Identifier: Apache-2.0
// What a trace claims, damaged where its hashes still fit: refused by the reader or by the check, or simulated to its
// end (or refused there with an Error).
#include <gtest/gtest.h>

#include <filesystem>

#include "grtx/base/child_process.h"
#include "grtx/base/error.h"
#include "grtx/traces/check.h"
#include "mutations.h"
#include "paths.h"
#include "rtl_tlm/simulate_priced.h"
#include "traces/random_group.h"
#include "traces/temporary_file.h"

namespace grtx::sim {
namespace {

using traces::testing::RandomOptions;
using traces::testing::RandomTrace;

std::uint64_t extreme(std::mt19937_64& random, std::uint64_t value) {
  switch (random() % 5) {
    case 0:
      return 0;
    case 1:
      return value + 1;
    case 2:
      return value == 0 ? 0 : value - 1;
    case 3:
      return std::uint64_t{1} << random() % 64;
    default:
      return random();
  }
}

void damage_header(traces::Header& h, std::mt19937_64& random) {
  std::uint64_t* const wide[] = {&h.node_image_bytes,   &h.root,      &h.blas_base,       &h.blas_root,
                                 &h.blas_bytes,         &h.gaussians, &h.sh_record_bytes, &h.gaussian_record_bytes,
                                 &h.checkpoint_capacity};
  unsigned* const narrow[] = {&h.k, &h.width, &h.height, &h.bvh_width, &h.sh_degree};
  const std::size_t which = random() % (std::size(wide) + std::size(narrow));
  if (which < std::size(wide)) {
    *wide[which] = extreme(random, *wide[which]);
  } else {
    unsigned& value = *narrow[which - std::size(wide)];
    value = static_cast<unsigned>(extreme(random, value));
  }
}

void damage_group(traces::RayGroup& group, std::mt19937_64& random) {
  if (!group.nodes.empty() && random() % 3 == 0) {
    traces::NodeDefinition& node = group.nodes[random() % group.nodes.size()];
    switch (random() % 4) {
      case 0:
        node.address = static_cast<std::uint32_t>(extreme(random, node.address));
        break;
      case 1:
        node.child_base = static_cast<std::uint32_t>(extreme(random, node.child_base));
        break;
      case 2:
        node.child_count = static_cast<std::uint8_t>(extreme(random, node.child_count));
        break;
      default:
        node.child_kinds[random() % node.child_kinds.size()] = static_cast<traces::NodeKind>(random() % 5);
    }
    return;
  }
  if (group.rays.empty()) return;
  traces::Ray& ray = group.rays[random() % group.rays.size()];
  if (ray.events.empty()) return;
  traces::Event& event = ray.events[random() % ray.events.size()];
  switch (random() % 5) {
    case 0:
      event.node = static_cast<std::uint32_t>(extreme(random, event.node));
      break;
    case 1:
      event.detail = static_cast<std::uint8_t>(extreme(random, event.detail));
      break;
    case 2:
      event.checkpoints = static_cast<std::uint8_t>(extreme(random, event.checkpoints));
      break;
    case 3:
      event.kind_shifts = traces::Event::pack(event.kind(), static_cast<unsigned>(random() % 9));
      break;
    default:
      event.kind_shifts = traces::Event::pack(static_cast<traces::EventKind>(random() % 6), event.shifts());
  }
}

/// Empty when the simulation ended or refused the trace.
std::string simulated(const std::string& path) {
  ChildProcess child("simulation", [&] {
    SimulationOptions options;
    options.watchdog_cycles = 200'000;
    const SimulationResult result =
        simulate(path, load_config(grtx::paths::source_dir() + "/configs/small.toml", {}), options);
    return result.violations.empty() ? std::string() : result.violations.front();
  });
  try {
    return child.result();
  } catch (const Error&) {
    return "";
  } catch (const std::exception& error) {
    return error.what();
  }
}

TEST(TraceFuzz, WhatPassesTheCheckIsSimulatedToItsEndOrRefused) {
  std::mt19937_64 random(testing_fuzz::seed());
  std::uint64_t refused = 0, passed = 0;
  for (std::uint64_t i = 0; i < testing_fuzz::count(400); ++i) {
    RandomOptions options;
    options.seed = static_cast<std::uint32_t>(1 + random() % 20);
    options.two_level = random() % 2 == 0;
    options.checkpoint = random() % 2 == 0;
    options.capacity = options.checkpoint ? 1000 : 0;
    RandomTrace trace = traces::testing::random_trace(options);
    for (std::size_t changes = 1 + random() % 2; changes > 0; --changes) {
      if (random() % 2 == 0) {
        damage_header(trace.header, random);
      } else {
        damage_group(trace.groups[random() % trace.groups.size()], random);
      }
    }
    const traces::testing::TemporaryFile file;
    try {
      traces::testing::write_trace(file.path(), trace.header, trace.groups);
      traces::check(traces::Reader(file.path()), true);
    } catch (const std::exception&) {  // the writer holds its callers to the format, too
      ++refused;
      continue;
    }
    ++passed;
    const std::string failure = simulated(file.path());
    EXPECT_EQ(failure, "") << "mutation " << i << " of seed " << testing_fuzz::seed();
    if (failure.empty()) continue;
    const auto find = std::filesystem::temp_directory_path() / ("grtx_find_" + std::to_string(i) + ".grtx");
    std::filesystem::copy_file(file.path(), find, std::filesystem::copy_options::overwrite_existing);
  }
  EXPECT_GT(refused, passed);
  EXPECT_GT(passed, 0U);
}

}  // namespace
}  // namespace grtx::sim
