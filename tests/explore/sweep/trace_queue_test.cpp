// SPDX-License-Identifier: Apache-2.0
// Which traces one process makes.
#include "grtx/explore/sweep/trace_queue.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <list>

namespace grtx::explore {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using Keys = std::vector<std::string>;
constexpr std::size_t kMany = 100;

class TraceQueueOf : public testing::Test {
 protected:
  void add(const std::string& key, const std::string& scene, const std::string& structure) {
    SweepTrace trace;
    trace.key = key;
    trace.scene_file = scene;
    trace.structure = structure;
    queue.add(traces.emplace_back(trace));
  }
  Keys take(std::size_t places, std::size_t most = kMany) {
    Keys keys;
    for (const SweepTrace* trace : queue.take(places, most)) keys.push_back(trace->key);
    return keys;
  }
  std::list<SweepTrace> traces;
  TraceQueue queue;
};

TEST_F(TraceQueueOf, OneProcessMakesTheTracesOfAStructure) {
  add("1", "room", "tri20");
  add("2", "room", "tlas");
  add("3", "room", "tri20");
  EXPECT_THAT(take(2), ElementsAre("1", "3"));
  EXPECT_THAT(take(2), ElementsAre("2"));
  EXPECT_TRUE(queue.empty());
  EXPECT_THAT(take(2), IsEmpty());
}

TEST_F(TraceQueueOf, AProcessThatIsTheOnlyOneReadsTheSceneOnce) {
  add("1", "room", "tri20");
  add("2", "room", "tlas");
  add("3", "hall", "tri20");
  add("4", "room", "tri20");
  EXPECT_THAT(take(1), ElementsAre("1", "4", "2"));
  EXPECT_THAT(take(1), ElementsAre("3"));
  EXPECT_TRUE(queue.empty());
}

TEST_F(TraceQueueOf, AsManyProcessesAsScenesReadOneEach) {
  add("1", "room", "tri20");
  add("2", "hall", "tri20");
  add("3", "hall", "tlas");
  add("4", "room", "tlas");
  EXPECT_THAT(take(2), ElementsAre("1", "4"));
  EXPECT_THAT(take(1), ElementsAre("2", "3"));
}

TEST_F(TraceQueueOf, StructuresOfTwoScenesOfOneNameAreTwo) {
  add("1", "room", "tri20");
  add("2", "hall", "tri20");
  EXPECT_THAT(take(3), ElementsAre("1"));
  EXPECT_THAT(take(3), ElementsAre("2"));
}

TEST_F(TraceQueueOf, PlacesThatWouldStayFreeShareAStructure) {
  for (int i = 10; i < 21; ++i) add(std::to_string(i), "room", "tri20");
  add("21", "room", "tlas");
  EXPECT_THAT(take(4), ElementsAre("10", "11", "12", "13", "14", "15")) << "eleven for two processes";
  EXPECT_THAT(take(3), ElementsAre("16", "17", "18", "19", "20")) << "three places for two structures";
  EXPECT_THAT(take(2), ElementsAre("21"));
}

TEST_F(TraceQueueOf, FewTracesAreNotWorthAnotherStructure) {
  for (int i = 1; i < 7; ++i) add(std::to_string(i), "room", "tri20");
  EXPECT_THAT(take(16), ElementsAre("1", "2", "3", "4"));
  EXPECT_THAT(take(15), ElementsAre("5", "6"));
}

TEST_F(TraceQueueOf, TakesNoMoreThanAProcessDoes) {
  add("1", "room", "tri20");
  add("2", "room", "tlas");
  add("3", "room", "tri20");
  EXPECT_THAT(take(4, 1), ElementsAre("1"));
  EXPECT_THAT(take(1, 1), ElementsAre("3"));
  EXPECT_THAT(take(1, 2), ElementsAre("2"));
  EXPECT_TRUE(queue.empty());
}

}  // namespace
}  // namespace grtx::explore
