// The text dump: every round and event of what was asked for, with byte addresses.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "grtx/base/error.h"
#include "grtx/traces/dump.h"
#include "grtx/traces/reader.h"
#include "traces/temporary_file.h"

namespace grtx::traces {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// Root at byte 64 with a leaf at 128 and an internal node at 192, which has two leaves at 256 and 320.
void write_small_trace(const std::string& path) {
  Header header;
  header.k = 1;
  header.width = header.height = 8;
  header.groups = 1;
  header.node_image_bytes = 384;
  header.root = 64;
  header.gaussians = 10;
  RayGroup group;
  NodeDefinition root{1, 2, {NodeKind::triangle, NodeKind::internal}, 2};
  NodeDefinition inner{3, 4, {NodeKind::triangle, NodeKind::triangle}, 2};
  group.nodes = {root, inner};
  group.rays.resize(2);
  Ray& ray = group.rays[1];
  ray.pixel = 9;
  ray.events = {{0, 0b11, 0, Event::pack(EventKind::visit_internal)},
                {1, 0b10, 0, Event::pack(EventKind::visit_internal)},
                {5, static_cast<std::uint8_t>(LeafOutcome::inserted), 0, Event::pack(EventKind::visit_leaf)},
                {2, 0, 0, Event::pack(EventKind::cull)}};
  Round round;
  round.event_count = 4;
  round.k_count = round.processed_count = 1;
  round.terminated = true;
  ray.rounds = {round};
  Processed entry;
  entry.gaussian = 7;
  entry.blended = 1;
  ray.processed = {entry};
  testing::write_trace(path, header, {group});
}

TEST(Dump, PrintsEventsWithAddresses) {
  const testing::TemporaryFile file;
  write_small_trace(file.path());
  const Reader reader(file.path());
  std::ostringstream out;
  dump(reader, out, std::nullopt, std::nullopt);
  EXPECT_THAT(out.str(), HasSubstr("group 0: primary rays, 2 lanes, 2 distinct internal nodes\n"
                                   "  lane 0 pixel 0: 0 rounds, 0 events\n"
                                   "  lane 1 pixel 9: 1 rounds, 4 events\n"
                                   "    round 0 starts at the root, 0 preloaded\n"
                                   "          0 internal  0x0000000040 pushed 0:0x80 1:0xc0\n"
                                   "          1 internal  0x00000000c0 pushed 1:0x140\n"
                                   "          2 leaf      0x0000000140 inserted\n"
                                   "          3 cull      0x0000000080\n"
                                   "    round 0 ends: k-buffer 1, processed 1, terminated\n"
                                   "      processed 7\n"));
  EXPECT_THAT(out.str(), HasSubstr("\"accel\":\"tri20\""));
  EXPECT_THAT(out.str(), HasSubstr(reader.content_hash()));
}

TEST(Dump, RestrictsToGroupAndLane) {
  const testing::TemporaryFile file;
  write_small_trace(file.path());
  const Reader reader(file.path());
  std::ostringstream out;
  dump(reader, out, 0, 0);
  EXPECT_THAT(out.str(), HasSubstr("lane 0 pixel 0"));
  EXPECT_THAT(out.str(), Not(HasSubstr("lane 1")));
  EXPECT_THROW(dump(reader, out, 1, std::nullopt), Error);
  EXPECT_THROW(dump(reader, out, std::nullopt, 32), Error);
}

}  // namespace
}  // namespace grtx::traces
