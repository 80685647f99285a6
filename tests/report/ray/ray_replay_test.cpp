// SPDX-License-Identifier: Apache-2.0
// Rays with several nodes under way, as design walk traces them, and traces that check_group() passes and no ray can be
// replayed from: each is shown or refused in one line.
#include "grtx/report/ray/ray_replay.h"

#include <gmock/gmock.h>

#include <map>
#include <random>

#include "grtx/base/error.h"
#include "grtx/traces/check.h"
#include "grtx/traces/reader.h"
#include "paths.h"
#include "shell.h"
#include "temporary_folder.h"

namespace grtx::report {
namespace {

using testing::HasSubstr;
using traces::Event;
using traces::EventKind;
using traces::LeafOutcome;

constexpr const char* kFile = "w.grtx";

/// The rays of a warp; those without rounds left out.
std::vector<unsigned> lanes_of(const traces::RayGroup& group) {
  std::vector<unsigned> lanes;
  for (unsigned lane = 0; lane < group.rays.size(); ++lane) {
    if (!group.rays[lane].rounds.empty()) lanes.push_back(lane);
  }
  return lanes;
}

/// Replays all rays of a group that check_group() passes.
std::vector<ReplayedRay> replay(const traces::Header& header, const traces::RayGroup& group) {
  traces::check_group(kFile, header, group);
  const std::vector<unsigned> lanes = lanes_of(group);
  const RayNodes nodes(kFile, header, group, lanes);
  std::vector<ReplayedRay> rays;
  for (const unsigned lane : lanes) rays.push_back(replay_ray(kFile, header, group, lane, nodes, nullptr));
  return rays;
}

struct Walk {
  const char* name;
  const char* options;
  const char* ahead;
};

class ReplayOfAWalk : public testing::TestWithParam<Walk> {
 protected:
  /// The traces of one view with several nodes under way, and with one.
  ReplayOfAWalk() {
    const std::string grtx = "cd '" + folder_.path() + "' && '" + grtx::paths::program() + "' ";
    const std::string options = " --quiet --width 16 --height 16 --scene s.ply --cameras s.cameras.json ";
    run(grtx + "synth --preset object --count 2000 --seed 7 --sh-degree 1 -o s.ply --quiet");
    run(grtx + "trace" + options + GetParam().options + " --ahead " + GetParam().ahead + " -o w.grtx");
    run(grtx + "trace" + options + GetParam().options + " --ahead 1 -o one.grtx");
  }
  static void run(const std::string& command) {
    const test::Outcome outcome = test::shell(command);
    EXPECT_EQ(outcome.code, 0) << outcome.output;
  }

  test::TemporaryFolder folder_;
};

// Which Gaussian lies behind a leaf follows from the order in which its hits came: in another order than the tracer's
// the k-buffer's places belong to other leaves.
TEST_P(ReplayOfAWalk, NamesTheGaussiansThatOneNodeUnderWayNames) {
  const traces::Reader several(folder_.path("w.grtx")), one(folder_.path("one.grtx"));
  ASSERT_GT(several.header().ahead, 1u);
  std::size_t named = 0;
  for (std::uint64_t g = 0; g < several.group_count(); ++g) {
    traces::RayGroup group, plain;
    several.read(g, group);
    one.read(g, plain);
    const RayNodes nodes(kFile, several.header(), group, lanes_of(group));
    const RayNodes plain_nodes(kFile, one.header(), plain, lanes_of(plain));
    const std::vector<ReplayedRay> rays = replay(several.header(), group), plain_rays = replay(one.header(), plain);
    ASSERT_EQ(rays.size(), plain_rays.size());
    for (std::size_t i = 0; i < rays.size(); ++i) {
      std::map<std::uint32_t, std::uint32_t> found, expected;  // address -> Gaussian
      for (const auto& [node, gaussian] : rays[i].learnt) found[nodes.nodes()[node].units] = gaussian;
      for (const auto& [node, gaussian] : plain_rays[i].learnt) expected[plain_nodes.nodes()[node].units] = gaussian;
      EXPECT_EQ(found, expected) << "group " << g << " ray " << i;
      named += found.size();
      for (std::size_t r = 0; r < rays[i].rounds.size(); ++r) {
        EXPECT_EQ(rays[i].rounds[r].blended, plain_rays[i].rounds[r].blended);
        EXPECT_EQ(rays[i].rounds[r].round.k_count, plain_rays[i].rounds[r].round.k_count);
      }
    }
  }
  EXPECT_GT(named, 1000u);
}

// Single fields of events, of nodes and of the header's k and ahead, at random. check_group() refuses most.
TEST_P(ReplayOfAWalk, OfADamagedTraceIsShownOrRefusedInOneLine) {
  const traces::Reader reader(folder_.path("w.grtx"));
  traces::RayGroup sound;
  reader.read(2, sound);
  std::mt19937 random(5);
  const auto below = [&](std::size_t n) { return static_cast<std::uint32_t>(random() % n); };
  std::size_t shown = 0, refused = 0;
  for (int i = 0; i < 600; ++i) {
    traces::RayGroup group = sound;
    traces::Header header = reader.header();
    for (std::uint32_t changes = 1 + below(3); changes > 0; --changes) {
      traces::Ray& ray = group.rays[below(group.rays.size())];
      if (ray.events.empty()) continue;
      Event& event = ray.events[below(ray.events.size())];
      switch (below(6)) {
        case 0:
          event.kind_shifts = Event::pack(event.kind(), below(header.k));
          break;
        case 1:
          event.detail = static_cast<std::uint8_t>(below(8));
          break;
        case 2:
          event.node = ray.events[below(ray.events.size())].node;
          break;
        case 3:
          header.ahead = 1 + below(32);
          break;
        case 4: {
          traces::NodeDefinition& node = group.nodes[below(group.nodes.size())];
          node.child_base = group.nodes[below(group.nodes.size())].child_base;
          break;
        }
        default:
          if (event.kind() == EventKind::visit_leaf) event.kind_shifts = Event::pack(EventKind::cull);
          break;
      }
    }
    try {
      (void)replay(header, group);
      ++shown;
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), HasSubstr("w.grtx: group 2"));
      ++refused;
    }
  }
  EXPECT_GT(shown, 20u);
  EXPECT_GT(refused, 200u);
}

INSTANTIATE_TEST_SUITE_P(Every, ReplayOfAWalk,
                         testing::Values(Walk{"walk", "--accel ellipsoid --layout quantised --k 64 --child-order slot",
                                              "16"},
                                         Walk{"rounds", "--accel ellipsoid --layout quantised --k 4", "8"},
                                         Walk{"triangles", "--accel tri20 --k 8 --tmax-update kth", "2"}),
                         [](const auto& one) { return one.param.name; });

/// A root at 1 with leaves at 2, 3 and 4, which a ray visits in this order; a k-buffer of two hits. Two nodes under
/// way.
struct SmallWalk {
  traces::Header header;
  traces::RayGroup group;

  explicit SmallWalk(const std::vector<Event>& leaves) {
    header.accel = traces::AccelKind::ellipsoid;
    header.k = 2;
    header.ahead = 2;
    header.width = header.height = 1;
    header.groups = 1;
    header.node_image_bytes = 5 * header.node_sizes().unit();
    header.root = header.node_sizes().unit();
    header.gaussians = 3;
    traces::NodeDefinition root;
    root.address = 1;
    root.child_base = 2;
    root.child_count = 3;
    root.child_kinds.fill(traces::NodeKind::internal);
    std::fill_n(root.child_kinds.begin(), 3, traces::NodeKind::procedural);
    group.nodes = {root};
    traces::Ray ray;
    ray.events = {{0, 0b111, 0, Event::pack(EventKind::visit_internal)}};
    ray.events.insert(ray.events.end(), leaves.begin(), leaves.end());
    traces::Round round;
    round.event_count = 4;
    round.k_count = 2;
    round.processed_count = 2;
    round.terminated = true;
    ray.rounds = {round};
    ray.processed.resize(2);
    ray.processed[1].gaussian = 1;
    group.rays = {ray};
  }
};

Event leaf(std::uint32_t node, LeafOutcome outcome, unsigned shifts = 0) {
  return {node, static_cast<std::uint8_t>(outcome), 0, Event::pack(EventKind::visit_leaf, shifts)};
}

std::string fault_of(const SmallWalk& walk) {
  try {
    (void)replay(walk.header, walk.group);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(ReplayOfASmallWalk, IsShown) {
  EXPECT_EQ(fault_of(SmallWalk({leaf(2, LeafOutcome::inserted), leaf(3, LeafOutcome::inserted, 1),
                                leaf(4, LeafOutcome::displaced, 1)})),
            "");
}

// packed_round.h: the page applies these changes and knows no rule.
TEST(ReplayOfASmallWalk, EachEventSaysWhatItChanges) {
  const SmallWalk walk(
      {leaf(2, LeafOutcome::inserted), leaf(3, LeafOutcome::inserted, 1), leaf(4, LeafOutcome::displaced, 1)});
  const std::vector<ReplayedRay> rays = replay(walk.header, walk.group);
  constexpr std::uint8_t kLeafInserted = 2 | 3 << 3, kLeafDisplaced = 2 | 4 << 3;
  const std::vector<std::uint8_t> expected = {
      0,
      0,
      0,  // nothing in k-buffer, eviction buffer, source list
      1,
      0,
      0,
      0,  // the root on the stack
      1,
      0,  // it is started
      0,
      0,
      3,
      0,
      1,
      2,
      0,
      2,
      0,
      1,  // the root, from the top: pushes slots 0, 1, 2; the two on top are started
      kLeafInserted,
      0,
      0,
      1,
      1,  // its hit at place 0 of the k-buffer; the leaf in slot 2 is started
      kLeafInserted,
      0,
      0,
      0,  // before it
      kLeafDisplaced,
      0,
      1 + 2,
      0,
      0};  // the hit at place 1 falls out
  EXPECT_EQ(rays.at(0).rounds.at(0).packed, expected);
}

TEST(ReplayOfASmallWalk, ShiftsOfEntriesThatHaveNotComeYetAreRefused) {
  EXPECT_EQ(fault_of(SmallWalk(
                {leaf(2, LeafOutcome::inserted, 1), leaf(3, LeafOutcome::inserted), leaf(4, LeafOutcome::rejected)})),
            "w.grtx: group 0 lane 0 round 0 event 1: an insertion cannot shift more entries than there are");
}

TEST(ReplayOfASmallWalk, AHitThatIsDisplacedBeforeTheBufferIsFullIsRefused) {
  EXPECT_EQ(fault_of(SmallWalk(
                {leaf(2, LeafOutcome::displaced), leaf(3, LeafOutcome::inserted), leaf(4, LeafOutcome::inserted)})),
            "w.grtx: group 0 lane 0 round 0 event 1: only a full k-buffer displaces or rejects");
}

TEST(ReplayOfASmallWalk, NodesThatAreNoTreeAreRefused) {
  SmallWalk walk({leaf(1, LeafOutcome::inserted), leaf(2, LeafOutcome::inserted), leaf(3, LeafOutcome::rejected)});
  walk.group.nodes[0].child_base = 1;  // the root is its own child
  EXPECT_EQ(fault_of(walk), "w.grtx: group 0: no node may be a child of two");
}

}  // namespace
}  // namespace grtx::report
