// SPDX-License-Identifier: Apache-2.0
// The text dump: every round and event of what was asked for, with byte addresses.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <tuple>
#include <vector>

#include "grtx/base/error.h"
#include "grtx/traces/dump.h"
#include "grtx/traces/reader.h"
#include "traces/random_group.h"
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
  Processed entry{.gaussian = 7, .blended = 1};
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

std::size_t occurrences(const std::string& text, const std::string& word) {
  std::size_t count = 0;
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) ++count;
  return count;
}

/// Traces in which every kind of event and every outcome occurs.
std::vector<testing::RandomTrace> traces_of_all_kinds() {
  std::vector<testing::RandomTrace> all;
  for (const Tracing tracing : {Tracing::multi, Tracing::single, Tracing::closest, Tracing::list}) {
    for (const unsigned objects : {0U, 3U}) {
      testing::RandomOptions options;
      options.seed = 5 + objects;
      options.tracing = tracing;
      options.two_level = true;
      options.objects = objects;
      options.depth = objects == 0 ? 3 : 2;
      options.checkpoint = tracing == Tracing::multi;
      if (options.checkpoint) options.k = 2;
      options.capacity = options.checkpoint ? (objects == 0 ? 6 : 1000) : 0;  // 6 overflow
      if (tracing == Tracing::closest) options.k = 1;
      all.push_back(testing::random_trace(options));
    }
  }
  return all;
}

TEST(Dump, TextNamesEveryEventAndOutcome) {
  const std::map<EventKind, std::string> kinds = {
      {EventKind::visit_internal, " internal  0x"}, {EventKind::visit_instance, " instance  0x"},
      {EventKind::visit_leaf, " leaf      0x"},     {EventKind::cull, " cull      0x"},
      {EventKind::replay_take, " take      0x"},    {EventKind::replay_forward, " forward   0x"}};
  const std::map<LeafOutcome, std::string> outcomes = {
      {LeafOutcome::miss, " miss"},           {LeafOutcome::behind, " behind"},
      {LeafOutcome::beyond, " beyond"},       {LeafOutcome::inserted, " inserted"},
      {LeafOutcome::displaced, " displaced"}, {LeafOutcome::rejected, " rejected"},
      {LeafOutcome::ignored, " ignored"},     {LeafOutcome::nearest, " nearest"}};
  std::map<std::string, std::size_t> seen;
  for (const testing::RandomTrace& trace : traces_of_all_kinds()) {
    const testing::TraceFile file(trace.header, trace.groups);
    std::ostringstream out;
    dump(Reader(file.path()), out, std::nullopt, std::nullopt);
    std::map<std::string, std::size_t> expected;
    for (const RayGroup& group : trace.groups) {
      for (const Ray& ray : group.rays) {
        for (const Event& event : ray.events) {
          ++expected[kinds.at(event.kind())];
          if (event.kind() == EventKind::visit_leaf) ++expected[outcomes.at(event.outcome())];
        }
        for (const Round& round : ray.rounds) {
          if (round.overflow) ++expected[", overflowed, "];
          if (round.replay) ++expected[" replays its source buffer"];
        }
      }
    }
    for (const auto& [word, count] : expected) {
      EXPECT_EQ(occurrences(out.str(), word), count) << word;
      seen[word] += count;
    }
  }
  EXPECT_EQ(seen.size(), kinds.size() + outcomes.size() + 2) << "each occurs in one of the traces";
}

// Counted from the groups alone, by what docs/model/trace-format.md says.
TEST(Dump, NodesListsWhatEachVisitReads) {
  using Read = std::tuple<std::uint64_t, std::size_t, std::size_t, std::string, std::uint64_t, std::uint64_t>;
  std::map<std::string, std::size_t> seen;
  for (const testing::RandomTrace& trace : traces_of_all_kinds()) {
    const testing::TraceFile file(trace.header, trace.groups);
    std::vector<Read> expected;
    for (const RayGroup& group : trace.groups) {
      for (std::size_t lane = 0; lane < group.rays.size(); ++lane) {
        const Ray& ray = group.rays[lane];
        std::size_t event = 0;
        for (std::size_t round = 0; round < ray.rounds.size(); ++round) {
          const auto reads = [&](const char* kind, std::uint64_t address, std::uint64_t bytes) {
            expected.emplace_back(group.index, lane, round, kind, address, bytes);
            ++seen[kind];
          };
          for (const std::size_t end = event + ray.rounds[round].event_count; event < end; ++event) {
            const Event& e = ray.events[event];
            const std::uint64_t address = std::uint64_t{e.node} * 64;
            if (e.kind() == EventKind::visit_internal) reads("internal", group.nodes[e.node].address * 64ULL, 64);
            if (e.kind() == EventKind::visit_leaf) reads(calls_any_hit(e.outcome()) ? "hit" : "leaf", address, 64);
            if (e.kind() != EventKind::visit_instance) continue;
            reads("instance", address, 128);
            if (e.detail != 0) continue;  // goes on at a replayed node
            std::uint64_t below = trace.header.blas_base;
            for (const SceneLeaf& leaf : trace.header.scene_leaves) {
              if (leaf.address == address) below = trace.header.object_roots[leaf.object] - 64;
            }
            reads("header", below, 64);
          }
        }
      }
    }
    const Reader reader(file.path());
    std::ostringstream out;
    dump_nodes(reader, out, std::nullopt, std::nullopt);
    std::istringstream lines(out.str());
    std::string line;
    ASSERT_TRUE(std::getline(lines, line));
    EXPECT_TRUE(line.starts_with("# grtx.node-reads/1 ")) << line;
    EXPECT_TRUE(line.ends_with(reader.content_hash())) << line;
    ASSERT_TRUE(std::getline(lines, line));
    EXPECT_EQ(line, "warp\tlane\tround\tkind\taddress\tbytes");
    std::vector<Read> listed;
    while (std::getline(lines, line)) {
      std::istringstream fields(line);
      Read read;
      fields >> std::get<0>(read) >> std::get<1>(read) >> std::get<2>(read) >> std::get<3>(read) >> std::get<4>(read) >>
          std::get<5>(read);
      listed.push_back(read);
    }
    EXPECT_EQ(listed, expected);
  }
  EXPECT_EQ(seen.size(), 5u) << "each kind occurs in one of the traces";
}

TEST(Dump, JsonHoldsEveryEvent) {
  for (const testing::RandomTrace& trace : traces_of_all_kinds()) {
    const testing::TraceFile file(trace.header, trace.groups);
    const Reader reader(file.path());
    std::ostringstream out;
    dump_json(reader, out, std::nullopt, std::nullopt);
    std::istringstream lines(out.str());
    std::string line;
    ASSERT_TRUE(std::getline(lines, line));
    EXPECT_EQ(nlohmann::json::parse(line).at("content_hash"), reader.content_hash());
    RayGroup group;
    for (std::uint64_t index = 0; index < reader.group_count(); ++index) {
      ASSERT_TRUE(std::getline(lines, line));
      reader.read(index, group);
      const nlohmann::json json = nlohmann::json::parse(line);
      EXPECT_EQ(json.at("nodes").size(), group.nodes.size());
      ASSERT_EQ(json.at("rays").size(), group.rays.size());
      for (std::size_t lane = 0; lane < group.rays.size(); ++lane) {
        const Ray& ray = group.rays[lane];
        const nlohmann::json& found = json.at("rays")[lane];
        EXPECT_EQ(found.at("pixel"), ray.pixel);
        EXPECT_EQ(found.at("rounds").size(), ray.rounds.size());
        EXPECT_EQ(found.at("processed").size(), ray.processed.size());
        nlohmann::json events = nlohmann::json::array();
        for (const Event& e : ray.events) {
          const std::uint64_t units =
              e.kind() == EventKind::visit_internal ? group.nodes[e.node].address : std::uint64_t{e.node};
          events.push_back({static_cast<unsigned>(e.kind()), units * reader.header().node_sizes().unit(), e.detail,
                            e.checkpoints, e.shifts()});
        }
        EXPECT_EQ(found.at("events"), events);
      }
    }
    EXPECT_FALSE(std::getline(lines, line));
  }
}

}  // namespace
}  // namespace grtx::traces
