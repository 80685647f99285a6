// SPDX-License-Identifier: Apache-2.0
// The example of docs/model/walkthrough.md, which is that of the paper (Section IV-B, "Walkthrough Example"): a
// k-buffer of four is full, its last entry is Gaussian 33 at t = 2.85, and Gaussian 5 is hit at t = 3.2.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fmt/format.h>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "grtx/base/atomic_file.h"
#include "grtx/frontend/accel/acceleration_structure.h"
#include "grtx/frontend/camera/camera.h"
#include "grtx/frontend/scene/scene_io.h"
#include "grtx/frontend/tracer/ray_tracer.h"
#include "grtx/frontend/tracer/ray_watch.h"
#include "paths.h"

namespace grtx::frontend {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using traces::EventKind;
using traces::LeafOutcome;

/// A call of the any-hit shader, with what the ray held after it.
struct Call {
  std::size_t round = 0, event = 0;  ///< event: counted in its round
  std::uint32_t gaussian = 0;
  float t = 0.0f;
  LeafOutcome outcome = LeafOutcome::miss;
  float t_max = 0.0f;
};

class Walkthrough : public testing::Test {
 protected:
  Walkthrough()
      : scene(load_scene(paths::source_dir() + "/data/walkthrough/scene.ply")),
        camera(load_cameras(paths::source_dir() + "/data/walkthrough/cameras.json").at(0)),
        gaussians(scene, Kernel()),
        accel(gaussians, {AccelKind::tlas_sphere}) {}

  WatchedRay trace(bool checkpoint) {
    TracerOptions options;
    options.k = 4;
    options.checkpoint = checkpoint;
    RayTracer tracer(scene, gaussians, accel, options);
    RayWatch watch(options, tracer.state(), tracer.stack());
    watch.begin_ray(0);
    tracer.trace(TraceRay(glm::vec3(camera.position - scene.offset), glm::vec3(camera.direction(0, 0))), watch);
    return watch.watched();
  }

  std::vector<Call> calls(const WatchedRay& watched) const {
    std::vector<Call> found;
    std::size_t at = 0, time = 0;
    for (std::size_t r = 0; r < watched.ray.rounds.size(); ++r) {
      std::uint32_t instance = 0;
      for (std::size_t e = 0; e < watched.ray.rounds[r].event_count; ++e, ++at) {
        const traces::Event& event = watched.ray.events[at];
        if (event.kind() == EventKind::visit_instance) instance = event.node;
        if (event.kind() == EventKind::visit_internal) {
          time += static_cast<std::size_t>(__builtin_popcount(event.pushed()) + __builtin_popcount(event.checkpoints));
        }
        if (event.kind() != EventKind::visit_leaf || event.outcome() == LeafOutcome::miss) continue;
        found.push_back(
            {r, e, accel.image().leaf_index(instance), watched.times.at(time++), event.outcome(), watched.t_max[at]});
      }
    }
    return found;
  }

  static unsigned count(const WatchedRay& watched, std::size_t round, EventKind kind) {
    std::size_t at = 0;
    for (std::size_t r = 0; r < round; ++r) at += watched.ray.rounds[r].event_count;
    unsigned found = 0;
    for (std::size_t e = 0; e < watched.ray.rounds[round].event_count; ++e)
      found += watched.ray.events[at + e].kind() == kind;
    return found;
  }

  static std::vector<std::uint32_t> processed(const WatchedRay& watched, std::size_t round) {
    std::size_t at = 0;
    for (std::size_t r = 0; r < round; ++r) at += watched.ray.rounds[r].processed_count;
    std::vector<std::uint32_t> ids;
    for (std::size_t i = 0; i < watched.ray.rounds[round].processed_count; ++i)
      ids.push_back(watched.ray.processed[at + i].gaussian);
    return ids;
  }

  const Scene scene;
  const Camera camera;
  const PreparedGaussians gaussians;
  const AccelerationStructure accel;
};

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNear = 5e-5f;

TEST_F(Walkthrough, TheKBufferFillsWithoutALimit) {
  const std::vector<Call> all = calls(trace(true));
  ASSERT_EQ(all.size(), 11u);
  const std::uint32_t ids[] = {12, 7, 21, 33};
  const float times[] = {1.4f, 1.9f, 2.4f, 2.85f};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(all[i].round, 0u);
    EXPECT_EQ(all[i].gaussian, ids[i]);
    EXPECT_NEAR(all[i].t, times[i], kNear);
    EXPECT_EQ(all[i].outcome, LeafOutcome::inserted);
    EXPECT_EQ(all[i].t_max, kInfinity);
  }
}

TEST_F(Walkthrough, TheFifthHitIsRejectedAndItsTBecomesTMax) {
  const std::vector<Call> all = calls(trace(true));
  EXPECT_EQ(all[4].round, 0u);
  EXPECT_EQ(all[4].gaussian, 5u);
  EXPECT_NEAR(all[4].t, 3.2f, kNear);
  EXPECT_EQ(all[4].outcome, LeafOutcome::rejected);
  EXPECT_EQ(all[4].t_max, all[4].t);
}

TEST_F(Walkthrough, WhatLiesBeyondTMaxIsCheckpointedAndNotRead) {
  const WatchedRay watched = trace(true);
  const std::vector<Call> all = calls(watched);
  const std::size_t rejection = all[4].event;
  const std::uint32_t events = watched.ray.rounds[0].event_count;
  ASSERT_EQ(events - rejection - 1, 4u);
  for (std::size_t e = rejection + 1; e < events; ++e) {
    EXPECT_EQ(watched.ray.events[e].kind(), EventKind::cull);
    EXPECT_EQ(watched.ray.events[e].checkpoints, 1);
  }
  EXPECT_THAT(processed(watched, 0), ElementsAre(12, 7, 21, 33));
}

TEST_F(Walkthrough, TheNextRoundBeginsWithTheEvictedHitAndTheCheckpoints) {
  const WatchedRay watched = trace(true);
  ASSERT_EQ(watched.ray.rounds.size(), 3u);
  EXPECT_TRUE(watched.ray.rounds[1].replay);
  EXPECT_EQ(watched.ray.rounds[1].preloaded, 1);
  ASSERT_EQ(watched.starts[1].k_buffer.size(), 1u);
  EXPECT_EQ(watched.starts[1].k_buffer[0].id, 5u);
  EXPECT_NEAR(watched.starts[1].k_buffer[0].t, 3.2f, kNear);
  EXPECT_EQ(watched.starts[1].t_max, kInfinity);
  EXPECT_EQ(count(watched, 1, EventKind::replay_take), 3u);
}

TEST_F(Walkthrough, AnEntryBeyondTMaxIsForwardedToTheRoundAfter) {
  const WatchedRay watched = trace(true);
  EXPECT_EQ(count(watched, 1, EventKind::replay_forward), 1u);
  const traces::Event& last =
      watched.ray.events[watched.ray.rounds[0].event_count + watched.ray.rounds[1].event_count - 1];
  EXPECT_EQ(last.kind(), EventKind::replay_forward);
  EXPECT_EQ(last.checkpoints, 1);
  EXPECT_EQ(count(watched, 2, EventKind::replay_take), 1u);
  EXPECT_THAT(processed(watched, 1), ElementsAre(5, 18, 2, 29));
}

TEST_F(Walkthrough, ARoundThatDoesNotFillTheKBufferIsTheLast) {
  const WatchedRay watched = trace(true);
  EXPECT_EQ(watched.ray.rounds[2].k_count, 3);
  EXPECT_THAT(processed(watched, 2), ElementsAre(9, 14, 26));
}

/// Nodes that a round reads.
std::vector<unsigned> visits(const WatchedRay& watched) {
  std::vector<unsigned> found;
  std::size_t at = 0;
  for (const traces::Round& round : watched.ray.rounds) {
    unsigned read = 0;
    for (std::size_t e = 0; e < round.event_count; ++e, ++at)
      read += watched.ray.events[at].kind() <= EventKind::visit_leaf;
    found.push_back(read);
  }
  return found;
}

std::string joined(const std::vector<unsigned>& counts) {
  unsigned sum = 0;
  std::string text;
  for (const unsigned n : counts) {
    text += fmt::format("{} | ", n);
    sum += n;
  }
  return text + fmt::format("{} |", sum);
}

TEST_F(Walkthrough, ThePageSaysWhatTheRayDoes) {
  const std::string page = read_file(paths::source_dir() + "/docs/model/walkthrough.md");
  const WatchedRay watched = trace(true);
  std::vector<KEntry> k;
  std::size_t round = 0;
  const auto number = [](float t) { return std::isinf(t) ? std::string("∞") : fmt::format("{:.5g}", t); };
  for (const Call& call : calls(watched)) {
    if (call.event == 0 || call.round != round) {
      round = call.round;
      k = watched.starts[round].k_buffer;
    }
    if (call.outcome == LeafOutcome::inserted) {
      k.push_back({call.t, call.gaussian, 0.0f});
      std::sort(k.begin(), k.end());
    }
    std::string held;
    for (const KEntry& entry : k) held += fmt::format("{}{}", held.empty() ? "" : ", ", entry.id);
    EXPECT_THAT(page, HasSubstr(fmt::format(
                          "| {} | {} | {} | {} | {} | {} | {} |", call.round, call.event, call.gaussian, number(call.t),
                          call.outcome == LeafOutcome::inserted ? "inserted" : "rejected", held, number(call.t_max))));
  }
  EXPECT_THAT(page, HasSubstr("| with checkpoints | " + joined(visits(watched))));
  EXPECT_THAT(page, HasSubstr("| without | " + joined(visits(trace(false)))));
}

}  // namespace
}  // namespace grtx::frontend
