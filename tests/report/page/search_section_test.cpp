// SPDX-License-Identifier: Apache-2.0
// What a report says of a search: front, path, contributions, reasons; all of it text and never markup.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "grtx/base/error.h"
#include "grtx/report/page/sections.h"
#include "sweep_database.h"
#include "temporary_folder.h"

namespace grtx::report {
namespace {

using testing::HasSubstr;

nlohmann::ordered_json result() {
  return nlohmann::ordered_json::parse(R"({
    "schema": "grtx.search/1", "screening": {"mode": "cycle", "scale": 0.5}, "confirming": {"mode": "cycle"},
    "objectives": ["gpu.time_us", "cost.mm2"], "constraints": ["cost.mm2 <= 1.1 * reference"],
    "parameters": [{"key": "tracer.k", "values": [4, 8]}, {"key": "design", "values": ["<sw>", "grtx"]}],
    "reference": {"coordinates": {"tracer.k": 8}, "evaluation": []},
    "counts": {"space": 4.0, "generations": 2, "candidates": 4, "broken": 1, "too_dear": 1, "screened": 2, "failed": 0,
               "confirmed": 1, "front": 1},
    "invalid": [{"outcome": "broken", "reason": "a < b", "candidates": 1}],
    "front": [1],
    "candidates": [
      {"coordinates": {"tracer.k": 8, "design": "<sw>"}, "screening": {"outcome": "measured", "ratios": [1.0, 1.0]}},
      {"coordinates": {"tracer.k": 4, "design": "grtx"}, "screening": {"outcome": "measured", "ratios": [0.5, 1.0]},
       "confirming": {"outcome": "measured", "ratios": [0.625, 1.0625]},
       "evaluation": {"outcome": "failed", "reason": "timeout"}},
      {"coordinates": {"tracer.k": 4, "design": "<sw>"}, "screening": {"outcome": "broken", "reason": "a < b"}},
      {"coordinates": {"tracer.k": 8, "design": "grtx"}, "screening": {"outcome": "refused", "reason": "cost"}}],
    "path": [{"key": "design", "from": null, "to": "grtx", "outcome": "broken", "reason": "a < b", "together": true},
             {"key": "tracer.k", "from": 8, "to": 4, "outcome": "measured", "ratios": [0.625, 1.0625]}],
    "effects": [{"objective": "gpu.time_us", "explained": 0.9,
                 "parameters": [{"key": "tracer.k", "values": [{"value": 4, "candidates": 1, "factor": 0.7071}]}]}]})");
}

class SearchSection : public testing::Test {
 protected:
  SearchSection() {
    testing_sweep::make_points(path, nlohmann::json::parse(R"([{"id": 1, "values": {"gpu.time_us": 1}}])"));
  }
  void store(const std::string& document) {
    testing_sweep::execute(path,
                           "INSERT OR REPLACE INTO meta VALUES ('search', " + testing_sweep::quoted(document) + ")");
  }
  const grtx::test::TemporaryFolder folder;
  const std::string path = folder.path("a.sqlite");
};

TEST_F(SearchSection, HoldsFrontPathContributionsAndReasons) {
  store(result().dump());
  ReportSweep sweep;
  sweep.results = read_sweep_results(path);
  sweep.id = "sweep1";
  const std::string html = search_section(sweep);
  EXPECT_THAT(
      html,
      HasSubstr(
          "4 candidates of 4 in 3 generations: 1 broken, 1 too dear, 0 failed, 2 screened (cycle, images × 0.5), 1 "
          "confirmed (cycle), 1 on the front. Reference: tracer.k = 8. Constraints: cost.mm2 &lt;= "
          "1.1 * reference."));
  const std::string headline = search_headline(sweep);
  EXPECT_THAT(headline,
              HasSubstr("<th scope=\"row\" class=\"n\">1</th><td class=\"n\">0.62×</td><td class=\"n\">1.06×</td>"
                        "<td class=\"n\">failed</td><td class=\"n\">failed</td><td class=\"n\">4</td>"
                        "<td class=\"n\">grtx</td>"));
  EXPECT_THAT(html,
              HasSubstr("design: base → grtx</th><td class=\"n\"></td><td class=\"n\"></td><td>a &lt; b (only with "
                        "the next)</td>"));
  EXPECT_THAT(html, HasSubstr("tracer.k: 8 → 4</th><td class=\"n\">0.62×</td>"));
  EXPECT_THAT(html, HasSubstr("<td class=\"n\">4</td><td class=\"n\">1</td><td class=\"n\">0.707</td>"));
  EXPECT_THAT(html, HasSubstr("<td>a &lt; b</td><td class=\"n\">1</td>"));
  EXPECT_THAT(html, testing::Not(HasSubstr("<sw>")));
  EXPECT_THAT(headline, HasSubstr("<dd>0.62×</dd>"));
  EXPECT_THAT(headline, testing::Not(HasSubstr("<sw>")));
}

// Candidates were "#0", "#1" as the points of the database are, of which "#1" is another design.
TEST_F(SearchSection, ACandidateIsNotCalledAsAPointIs) {
  store(result().dump());
  ReportSweep sweep;
  sweep.results = read_sweep_results(path);
  sweep.id = "sweep1";
  EXPECT_THAT(search_section(sweep),
              testing::AllOf(HasSubstr("\"label\":\"candidate 1\""), testing::Not(HasSubstr("#1"))));
  EXPECT_THAT(search_headline(sweep),
              testing::AllOf(HasSubstr("least gpu.time_us: candidate 1 (0.625)"), testing::Not(HasSubstr("#1"))));
}

TEST_F(SearchSection, ASweepHasNone) {
  ReportSweep sweep;
  sweep.results = read_sweep_results(path);
  EXPECT_EQ(search_section(sweep), "");
  EXPECT_EQ(search_headline(sweep), "");
}

TEST_F(SearchSection, AnotherSchemaIsRefused) {
  for (const char* document : {R"({"schema": "grtx.search/2"})", "[1]", "no json"}) {
    store(document);
    EXPECT_THROW(read_sweep_results(path), Error) << document;
  }
}

}  // namespace
}  // namespace grtx::report
