// A file takes the oldest version that can say what its header says, and a reader knows both.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "grtx/base/atomic_file.h"
#include "grtx/traces/check.h"
#include "grtx/traces/codec/byte_stream.h"
#include "grtx/traces/codec/header_json.h"
#include "grtx/traces/reader.h"
#include "traces/random_group.h"
#include "traces/temporary_file.h"

namespace grtx::traces {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

struct Case {
  ChildOrder child_order;
  PopTest pop_test;
  std::uint32_t version;
};
constexpr Case kCases[] = {{ChildOrder::near_first, PopTest::on, 4}, {ChildOrder::slot, PopTest::on, 4},
                           {ChildOrder::vulkan_sim, PopTest::on, 5}, {ChildOrder::near_first, PopTest::off, 5},
                           {ChildOrder::slot, PopTest::off, 5},      {ChildOrder::vulkan_sim, PopTest::off, 5}};

TEST(Versions, AreTheOldestThatWillDo) {
  for (const Case& c : kCases) {
    testing::RandomOptions options;
    options.child_order = c.child_order;
    options.pop_test = c.pop_test;
    SCOPED_TRACE(testing::describe(options));
    const auto trace = testing::random_trace(options);
    const testing::TemporaryFile file;
    testing::write_trace(file.path(), trace.header, trace.groups);
    const std::string bytes = read_file(file.path());
    EXPECT_EQ(load_u32(reinterpret_cast<const std::uint8_t*>(bytes.data()) + 8), c.version);
    const Reader reader(file.path());
    EXPECT_EQ(reader.header().child_order, c.child_order);
    EXPECT_EQ(reader.header().pop_test, c.pop_test);
    EXPECT_NO_THROW(check(reader, true));
  }
}

std::string fault_of(const std::string& json, std::uint32_t version) {
  try {
    header_from_json(json, version);
    return "";
  } catch (const Malformed& fault) {
    return fault.what();
  }
}

TEST(Versions, HaveTheirOwnKeys) {
  Header header;
  const std::string four = header_to_json(header);
  EXPECT_THAT(four, Not(HasSubstr("pop_test")));
  EXPECT_EQ(fault_of(four, 4), "");
  EXPECT_THAT(fault_of(four, 5), HasSubstr("key 'pop_test' is missing"));
  header.pop_test = PopTest::off;
  const std::string five = header_to_json(header);
  EXPECT_EQ(fault_of(five, 5), "");
  EXPECT_THAT(fault_of(five, 4), HasSubstr("key 'pop_test' is unknown"));
  std::string vulkan_sim = four;
  vulkan_sim.replace(vulkan_sim.find("near_first"), 10, "vulkan_sim");
  EXPECT_THAT(fault_of(vulkan_sim, 4), HasSubstr("key 'child_order' holds a value that version 4 does not have"));
}

}  // namespace
}  // namespace grtx::traces
