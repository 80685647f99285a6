// SPDX-License-Identifier: Apache-2.0
// JSON of others: an error names file and place, however wrong the text is. JSON for others is UTF-8.
#include "grtx/base/json.h"

#include <gtest/gtest.h>

#include "error_of.h"
#include "grtx/base/error.h"
#include "grtx/base/printable.h"

namespace grtx {
namespace {

std::string nested(int levels) {
  return std::string(static_cast<std::size_t>(levels), '[') + std::string(static_cast<std::size_t>(levels), ']');
}

TEST(Json, ListsNestedTooDeeplyAreRefused) {
  EXPECT_NO_THROW(parse_json(nested(kMostJsonLevels), "f"));
  const std::string rule = "must be nested at most 128 levels deep, as JSON";
  EXPECT_EQ(test::error_of([] { parse_json(nested(kMostJsonLevels + 1), "f"); }), "f: byte 129: " + rule);
  std::string objects;
  for (int i = 0; i < 100'000; ++i) objects += "{\"a\":";
  EXPECT_EQ(test::error_of([&] { parse_json(objects, "f", "row 3"); }), "f: row 3: byte 641: " + rule);
}

TEST(Json, BracketsInTextsAreNoLevels) {
  const std::string text = "[\"" + std::string(1000, '[') + "\\\"" + std::string(1000, '{') + "\\\\\", {\"[[\": 1}]";
  EXPECT_EQ(parse_json(text, "f").at(1).at("[["), 1);
  EXPECT_EQ(test::error_of([&] { parse_json("[\"\\\\\"," + nested(200) + "]", "f"); }).substr(0, 12), "f: byte 134:");
}

TEST(Json, NamesThePlaceOfAFault) {
  EXPECT_EQ(test::error_of([] { parse_json("[1,", "f"); }), "f: byte 4: is not valid JSON");
  EXPECT_EQ(test::error_of([] { parse_json("", "f", "line 2"); }), "f: line 2: byte 1: is not valid JSON");
  EXPECT_EQ(test::error_of([] { parse_json("[1e999]", "f"); }),
            "f: is not readable JSON: holds a number that no double can hold");
}

TEST(Json, ANameInLatin1IsEscaped) {
  const nlohmann::ordered_json json = {{"f",
                                        "K\xfc"
                                        "che.jpg"},
                                       {"K\xfc", {1, "gr\xc3\xbcn"}}};
  EXPECT_EQ(json_text(json), R"({"f":"K\\xfcche.jpg","K\\xfc":[1,"grün"]})");
  EXPECT_EQ(json_text(json.at("K\xfc"), 1), "[\n 1,\n \"grün\"\n]");
}

TEST(Json, WhatAnotherProcessOpensIsExactOrRefused) {
  const nlohmann::json json = {{"arguments",
                                {"--scene",
                                 "K\xfc"
                                 "che.ply"}}};
  EXPECT_EQ(test::error_of([&] { exact_json_text(json); }), "K\\xfcche.ply: must be UTF-8: it is handed on as JSON");
  EXPECT_EQ(exact_json_text(nlohmann::json{"grün"}), "[\"grün\"]");
}

TEST(Utf8, EscapesWhatIsNone) {
  const struct {
    const char* text;
    const char* shown;
  } cases[] = {{"", ""},
               {"plain", "plain"},
               {"\xc3\xbc \xe2\x82\xac \xf0\x9f\x98\x80", "\xc3\xbc \xe2\x82\xac \xf0\x9f\x98\x80"},
               {"\xfc", "\\xfc"},
               {"a\xc3", "a\\xc3"},                            // cut
               {"\xe2\x82z", "\\xe2\\x82z"},                   // cut
               {"\xc0\xaf", "\\xc0\\xaf"},                     // longer than needed
               {"\xe0\x9f\xbf", "\\xe0\\x9f\\xbf"},            // longer than needed
               {"\xed\xa0\x80", "\\xed\\xa0\\x80"},            // a surrogate
               {"\xf4\x90\x80\x80", "\\xf4\\x90\\x80\\x80"}};  // beyond U+10FFFF
  for (const auto& c : cases) {
    EXPECT_EQ(utf8(c.text), c.shown);
    EXPECT_EQ(printable(c.text), c.shown);
    EXPECT_NO_THROW(nlohmann::json(utf8(c.text)).dump());
  }
}

}  // namespace
}  // namespace grtx
