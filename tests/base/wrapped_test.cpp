// SPDX-License-Identifier: Apache-2.0
// Lines of at most 80 characters, broken at spaces.
#include "grtx/base/wrapped.h"

#include <gtest/gtest.h>

namespace grtx {
namespace {

TEST(Wrapped, BreaksAtTheLastSpaceThatFits) {
  const std::string a(40, 'a'), b(39, 'b'), c(40, 'c');
  EXPECT_EQ(wrapped(a + " " + b), a + " " + b);  // 80
  EXPECT_EQ(wrapped(a + " " + c), a + "\n  " + c);
  EXPECT_EQ(wrapped(a + " " + b + " x y"), a + " " + b + "\n  x y");
  EXPECT_EQ(wrapped(a + " " + c + " " + b, 0), a + "\n" + c + " " + b);
}

TEST(Wrapped, ColumnsOfTheFirstLineStay) { EXPECT_EQ(wrapped("  name    3  words"), "  name    3  words"); }

TEST(Wrapped, AWordThatIsTooLongStaysWhole) {
  const std::string path(100, 'p');
  EXPECT_EQ(wrapped(path + " x"), path + "\n  x");
  EXPECT_EQ(wrapped("x " + path), "x\n  " + path);
  EXPECT_EQ(wrapped(""), "");
}

TEST(Wrapped, CountsCharactersAndNoBytes) {
  std::string text;
  for (int i = 0; i < 40; ++i) text += "±";
  EXPECT_EQ(wrapped(text + " " + text.substr(0, 2 * 39)), text + " " + text.substr(0, 2 * 39));
  EXPECT_EQ(wrapped(text + " " + text), text + "\n  " + text);
}

}  // namespace
}  // namespace grtx
