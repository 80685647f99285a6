// SPDX-License-Identifier: Apache-2.0
// Work in a forked child: results come back whole, errors come back as what they were.
#include "grtx/base/child_process.h"

#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "grtx/base/error.h"
#include "temporary_folder.h"

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

// The first to begin was waited for, however many others had ended: here the first ends only when the last has begun.
TEST(RunChildren, WhicheverEndsFirstMakesRoomForTheNext) {
  const test::TemporaryFolder folder;
  const std::string begun = folder.path() + "/last_begun";
  const auto wait_for_last = [&]() -> std::string {
    for (int i = 0; i < 3000 && !std::filesystem::exists(begun); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return std::filesystem::exists(begun) ? "after the last" : "the last never began";
  };
  const auto last = [&]() -> std::string {
    std::ofstream(begun) << "here";
    return "last";
  };
  std::vector<std::string> texts(3);
  run_children(
      {{"first", wait_for_last}, {"short", [] { return std::string("short"); }}, {"last", last}}, 2,
      [&](std::size_t task, const std::string& text) { texts[task] = text; }, [] {});
  EXPECT_EQ(texts, (std::vector<std::string>{"after the last", "short", "last"}));
}

TEST(RunChildren, OneAtATimeAreBegunAndEndInTheirOrder) {
  std::vector<std::size_t> order;
  const auto body = [] { return std::string("done"); };
  run_children(
      {{"a", body}, {"b", body}, {"c", body}}, 1, [&](std::size_t task, const std::string&) { order.push_back(task); },
      [] {});
  EXPECT_EQ(order, (std::vector<std::size_t>{0, 1, 2}));
}

TEST(RunChildren, AnErrorOfOneEndsTheOthers) {
  const auto begin = std::chrono::steady_clock::now();
  const auto sleep = []() -> std::string {
    std::this_thread::sleep_for(std::chrono::minutes(5));
    return "";
  };
  const auto bad = []() -> std::string { throw Error("a.grtx", "byte 12", "must hold"); };
  EXPECT_THROW(run_children(
                   {{"long", sleep}, {"bad", bad}}, 2, [](std::size_t, const std::string&) {}, [] {}),
               Error);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::minutes(2));
}

}  // namespace
}  // namespace grtx
