// SPDX-License-Identifier: Apache-2.0
// The statistics file: order, number formats, one line per statistic, host.* at the end.
#include "grtx/rtl_tlm/run/statistics_json.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "grtx/rtl_tlm/run/model_version.h"

namespace grtx::sim {
namespace {

nlohmann::ordered_json document() {
  modules::StatisticList statistics, host;
  statistics.add("gpu.cycles", std::uint64_t{18446744073709551615ULL}, "cycles", "time", modules::StatisticKind::count);
  statistics.add("gpu.b_rate", 0.1, "ratio", "a \"quoted\" text", modules::StatisticKind::ratio);
  statistics.add("gpu.a_none", std::numeric_limits<double>::quiet_NaN(), "ratio", "not a number",
                 modules::StatisticKind::ratio);
  host.add("host.wall_seconds", 1.5, "s", "wall time", modules::StatisticKind::count);
  return statistics_document({{"l1.latency", 20}}, {{"trace", "abc"}}, {{"no-hits", "of none"}}, statistics, host);
}

TEST(StatisticsJson, KeepsTheOrderOfTheListAndPutsTheHostLast) {
  std::vector<std::string> names;
  const nlohmann::ordered_json doc = document();
  for (const auto& [name, entry] : doc["stats"].items()) names.push_back(name);
  EXPECT_EQ(names, (std::vector<std::string>{"gpu.cycles", "gpu.b_rate", "gpu.a_none", "host.wall_seconds"}));
}

TEST(StatisticsJson, WritesIntegersExactlyAndDoublesInTheShortestForm) {
  EXPECT_EQ(statistics_text(document()),
            "{\n"
            "  \"schema\": \"grtx.stats/1\",\n"
            "  \"model_version\": " +
                std::to_string(kModelVersion) +
                ",\n"
                "  \"config\": {\n"
                "    \"l1.latency\": 20\n"
                "  },\n"
                "  \"inputs\": {\n"
                "    \"trace\": \"abc\"\n"
                "  },\n"
                "  \"notes\": [{\"id\":\"no-hits\",\"text\":\"of none\"}],\n"
                "  \"stats\": {\n"
                "    \"gpu.cycles\": {\"value\":18446744073709551615,\"unit\":\"cycles\",\"description\":\"time\"},\n"
                "    \"gpu.b_rate\": {\"value\":0.1,\"unit\":\"ratio\",\"description\":\"a \\\"quoted\\\" text\"},\n"
                "    \"gpu.a_none\": {\"value\":null,\"unit\":\"ratio\",\"description\":\"not a number\"},\n"
                "    \"host.wall_seconds\": {\"value\":1.5,\"unit\":\"s\",\"description\":\"wall time\"}\n"
                "  }\n"
                "}\n");
}

TEST(StatisticsJson, TextReadsBackAsTheSameDocument) {
  const nlohmann::ordered_json doc = document();
  EXPECT_EQ(nlohmann::ordered_json::parse(statistics_text(doc)), doc);
}

}  // namespace
}  // namespace grtx::sim
