// SPDX-License-Identifier: Apache-2.0
// Pieces of a report's page.
#include "grtx/report/page/html.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "temporary_folder.h"

namespace grtx::report {
namespace {

using nlohmann::ordered_json;

TEST(Html, NumbersForPeople) {
  const struct {
    double value;
    const char* text;
  } cases[] = {{0, "0"},
               {7, "7"},
               {-7, "-7"},
               {999, "999"},
               {1000, "1,000"},
               {-1234567, "-1,234,567"},
               {100000, "100,000"},
               {0.5, "0.5"},
               {1.0 / 3.0, "0.3333"},
               {17.36, "17.36"},
               {999.94, "999.9"},
               {3272.5, "3,272"},
               {2e15, "2e+15"},
               {std::numeric_limits<double>::quiet_NaN(), ""},
               {std::numeric_limits<double>::infinity(), ""}};
  for (const auto& c : cases) EXPECT_EQ(number(c.value), c.text);
}

// 31,563 µJ and "3M nJ" were on the pages.
TEST(Html, UnitsGoBySize) {
  const struct {
    double value;
    const char *unit, *text;
  } cases[] = {{0.0315634, "J", "31.6 mJ"}, {3.119190e-3, "J", "3.12 mJ"},
               {1353.8e-9, "J", "1.35 µJ"}, {943.48e-6, "s", "943 µs"},
               {999.6e-6, "s", "1.00 ms"},  {12.0, "B", "12 B"},
               {31667392, "B", "31.7 MB"},  {463.5e6, "B", "464 MB"},
               {0.0, "J", "0 J"},           {std::numeric_limits<double>::quiet_NaN(), "J", ""}};
  for (const auto& c : cases) EXPECT_EQ(with_unit(c.value, c.unit), c.text);
}

// Cards of a sweep broke "rt.warp_buffer.stack_entri es".
TEST(Html, KeysBreakAtTheirDots) {
  EXPECT_EQ(breakable("rt.stack_entries = 4.5, <a>."), "rt.<wbr>stack_<wbr>entries = 4.5, &lt;a&gt;.");
}

// 3.22 ms stood over 135 µs, and 2.17 mJ over 988 µJ.
TEST(Html, AColumnHasOneUnit) {
  EXPECT_EQ(in_one_unit({3.22e-3, 135e-6, std::numeric_limits<double>::quiet_NaN(), 0.0, 1e-9}, "s"),
            (std::vector<std::string>{"3.22 ms", "0.135 ms", "", "0 s", "under 0.001 ms"}));
  EXPECT_EQ(in_one_unit({1.29e6, 155e3}, "rays/s"), (std::vector<std::string>{"1.29 Mrays/s", "0.155 Mrays/s"}));
  EXPECT_EQ(in_one_unit({12.0, 7.0}, "B"), (std::vector<std::string>{"12 B", "7 B"}));
}

TEST(Html, TextIsEscaped) {
  EXPECT_EQ(escape("a<b>&\"c'"), "a&lt;b&gt;&amp;&quot;c&#39;");
  EXPECT_EQ(cell(ordered_json("<i>")), "&lt;i&gt;");
  EXPECT_EQ(cell(ordered_json({{"<i>", 1}})), "{&quot;&lt;i&gt;&quot;:1}");
  EXPECT_EQ(cell(ordered_json()), "");
}

TEST(Html, JsonCannotEndItsScript) {
  const ordered_json value = {{"</script>", "<!--"}};
  const std::string text = script_json(value);
  EXPECT_EQ(text.find('<'), std::string::npos);
  EXPECT_EQ(ordered_json::parse(text), value);
  EXPECT_NO_THROW(script_json("\xff no UTF-8"));
}

TEST(Html, PicturesBecomeDataAndNothingElseDoes) {
  const grtx::test::TemporaryFolder folder;
  const std::string path = folder.path("a.bin");
  const std::string png = "\x89PNG\r\n\x1a\n";
  const struct {
    std::string bytes;
    const char* uri;
  } cases[] = {{png, "data:image/png;base64,iVBORw0KGgo="},
               {png + "a", "data:image/png;base64,iVBORw0KGgph"},
               {png + "ab", "data:image/png;base64,iVBORw0KGgphYg=="},
               {"\xff\xd8\xff", "data:image/jpeg;base64,/9j/"},
               {"GIF89a", "data:image/gif;base64,R0lGODlh"}};
  for (const auto& c : cases) {
    write_file(path, c.bytes);
    EXPECT_EQ(picture_uri(path), c.uri);
  }
  write_file(path, "<svg onload=alert(1)>");
  EXPECT_THROW(picture_uri(path), Error);
}

// A stack unit of 0.02 % of the area had "0.0 %", and the whole "100.0 %".
TEST(Html, AShareThatIsSmallIsNotZero) {
  EXPECT_EQ(share_text(0.0), "0 %");
  EXPECT_EQ(share_text(2e-4), "< 0.1 %");
  EXPECT_EQ(share_text(0.123), "12.3 %");
  EXPECT_EQ(share_text(1.0), "100 %");
}

TEST(Html, ATableNamesItsRowsAndColumns) {
  Table table("A & B", {{"name", false}, {"count"}}, "t");
  table.row({"x", "1"}, " data-id=\"1\"");
  const std::string html = table.html();
  for (const char* part :
       {"<caption><span>A &amp; B</span></caption>", "<th scope=\"col\">name</th>",
        "<th scope=\"col\" class=\"n\">count</th>",
        "<tr data-id=\"1\"><th scope=\"row\">x</th><td class=\"n\">1</td></tr>", "aria-label=\"A &amp; B\""}) {
    EXPECT_THAT(html, testing::HasSubstr(part));
  }
}

}  // namespace
}  // namespace grtx::report
