// SPDX-License-Identifier: Apache-2.0
// Work in a forked child: results come back whole, errors come back as what they were.
#include "grtx/base/child_process.h"

#include <gtest/gtest.h>

#include <csignal>
#include <stdexcept>

#include "grtx/base/error.h"

namespace grtx {
namespace {

TEST(ChildProcess, ReturnsATextLargerThanAPipeHolds) {
  const std::string text(3'000'000, 'x');
  EXPECT_EQ(ChildProcess("big", [&] { return text; }).result(), text);
}

TEST(ChildProcess, TwoChildrenRunAtOnceAndKeepTheirOwnState) {
  int counter = 0;
  const auto body = [&counter] { return std::to_string(++counter); };
  ChildProcess first("first", body), second("second", body);
  EXPECT_EQ(second.result(), "1");
  EXPECT_EQ(first.result(), "1");
  EXPECT_EQ(counter, 0);
}

TEST(ChildProcess, ABadInputErrorKeepsItsFilePlaceAndRule) {
  ChildProcess child("bad", []() -> std::string { throw Error("a.grtx", "byte 12", "must hold"); });
  try {
    child.result();
    FAIL() << "nothing was thrown";
  } catch (const Error& error) {
    EXPECT_EQ(error.file(), "a.grtx");
    EXPECT_EQ(error.place(), "byte 12");
    EXPECT_EQ(error.rule(), "must hold");
  }
}

TEST(ChildProcess, AnotherExceptionIsAnInternalErrorThatNamesTheChild) {
  ChildProcess child("design grtx", []() -> std::string { throw std::logic_error("broken"); });
  try {
    child.result();
    FAIL() << "nothing was thrown";
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(), "design grtx: broken");
  }
}

TEST(ChildProcess, DeathByASignalIsAnError) {
  ChildProcess child("victim", []() -> std::string {
    std::raise(SIGKILL);
    return "";
  });
  EXPECT_THROW(child.result(), std::runtime_error);
}

}  // namespace
}  // namespace grtx
