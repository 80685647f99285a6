// SPDX-License-Identifier: Apache-2.0
// Error messages are one line, whatever the input contained.
#include "grtx/base/error.h"

#include <gtest/gtest.h>

TEST(Error, NamesFilePlaceAndRule) {
  const grtx::Error error("scene.ply", "byte 12", "must be finite");
  EXPECT_STREQ(error.what(), "scene.ply: byte 12: must be finite");
}

TEST(Error, OmitsAnEmptyPlace) { EXPECT_STREQ(grtx::Error("a", "", "is empty").what(), "a: is empty"); }

TEST(Error, StaysOneLineWhenInputIsQuoted) {
  EXPECT_EQ(std::string(grtx::Error("a", "key 'x\ny'", "bad").what()).find('\n'), std::string::npos);
}

TEST(Error, EscapesWhatWouldSteerATerminal) {
  EXPECT_STREQ(grtx::Error("a\nb", "\x1b[31mkey\x7f", "bad \xc2\x9bm \xc3\xa4 \t").what(),
               "a\\nb: \\x1b[31mkey\\x7f: bad \\x9bm \xc3\xa4 \\x09");
}
