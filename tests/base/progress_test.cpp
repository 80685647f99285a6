// SPDX-License-Identifier: Apache-2.0
// Progress on a terminal: never silent for two seconds, even while the work reports nothing.
#include "grtx/base/progress.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <pty.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <functional>
#include <string>
#include <thread>

namespace grtx {
namespace {

using std::chrono::milliseconds;
using testing::HasSubstr;
using testing::Not;

struct Seen {
  std::string text;
  milliseconds longest_silence{0};
};

/// What a terminal shows of work in a process of its own.
Seen on_a_terminal(const std::function<void()>& work) {
  int terminal = -1;
  const pid_t child = ::forkpty(&terminal, nullptr, nullptr, nullptr);
  if (child == 0) {
    work();
    ::_exit(0);
  }
  Seen seen;
  auto last = std::chrono::steady_clock::now();
  std::array<char, 4096> buffer{};
  for (;;) {
    pollfd end{terminal, POLLIN, 0};
    if (::poll(&end, 1, 10000) <= 0) break;
    const ssize_t count = ::read(terminal, buffer.data(), buffer.size());
    const auto now = std::chrono::steady_clock::now();
    seen.longest_silence = std::max(seen.longest_silence, std::chrono::duration_cast<milliseconds>(now - last));
    last = now;
    if (count <= 0) break;  // the child has ended
    seen.text.append(buffer.data(), static_cast<std::size_t>(count));
  }
  ::close(terminal);
  ::waitpid(child, nullptr, 0);
  return seen;
}

TEST(Progress, IsDrawnWhileTheWorkReportsNothing) {
  const Seen seen = on_a_terminal([] {
    Progress progress("building tri20", 10, " leaves", false);
    std::this_thread::sleep_for(milliseconds(1200));
    progress.set(5);
    progress.rename("packing tri20");
    std::this_thread::sleep_for(milliseconds(1500));
  });
  EXPECT_LT(seen.longest_silence, milliseconds(2000));
  EXPECT_THAT(seen.text, HasSubstr("building tri20  1 s"));  // no rate yet
  EXPECT_THAT(seen.text, HasSubstr("[############............] packing tri20  50 % "));
  EXPECT_THAT(seen.text, HasSubstr(" s left"));
}

TEST(Progress, WorkOfUnknownSizeShowsItsTime) {
  const Seen seen = on_a_terminal([] {
    Progress progress("reading hall.ply", 0, "", false);
    std::this_thread::sleep_for(milliseconds(1200));
  });
  EXPECT_THAT(seen.text, HasSubstr("reading hall.ply  1 s"));
  EXPECT_THAT(seen.text, Not(HasSubstr("left")));
}

TEST(Progress, WhatEndsAtOnceAndQuietWorkSayNothing) {
  EXPECT_EQ(on_a_terminal([] { Progress progress("simulate", 10, " warps", false); }).text, "");
  EXPECT_EQ(on_a_terminal([] {
              Progress progress("simulate", 10, " warps", true);
              std::this_thread::sleep_for(milliseconds(1200));
            }).text,
            "");
}

}  // namespace
}  // namespace grtx
