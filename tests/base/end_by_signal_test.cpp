// SPDX-License-Identifier: Apache-2.0
// A signal that ends a process removes what it is writing, and nothing else.
#include "grtx/base/end_by_signal.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <functional>

#include "grtx/base/atomic_file.h"
#include "temporary_folder.h"

namespace grtx {
namespace {

struct EndBySignal : testing::Test {
  bool has(const char* name) const { return std::filesystem::exists(folder / name); }

  /// Status of a process that does this; its stderr goes to a file.
  int status_of(const std::function<void()>& body) const {
    const pid_t child = ::fork();
    if (child == 0) {
      if (std::freopen((folder / "err").c_str(), "w", stderr) == nullptr) ::_exit(9);
      for (const int signal : {SIGHUP, SIGINT, SIGTERM}) ::signal(signal, SIG_DFL);  // nohup and a shell's & ignore two
      end_tidily_by_signals();
      body();
      ::_exit(0);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    return status;
  }
  std::string said() const { return read_file(folder / "err"); }

  const grtx::test::TemporaryFolder own_folder;
  const std::filesystem::path folder = own_folder.path();
};

TEST_F(EndBySignal, NoPartialFileStays) {
  for (const auto& [signal, name] : {std::pair(SIGHUP, "SIGHUP"), {SIGINT, "SIGINT"}, {SIGTERM, "SIGTERM"}}) {
    write_file(folder / "a", "old");
    const int status = status_of([&, number = signal] {
      write_file(folder / "c", "complete");
      AtomicFile a(folder / "a"), b(folder / "b");
      { const AtomicFile gone(folder / "gone"); }
      a.write("half");
      ::raise(number);
    });
    EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == signal) << "a shell's loop ends, too";
    EXPECT_EQ(said(), std::string("grtx: ended by ") + name + ": what was being written is removed\n");
    EXPECT_EQ(read_file(folder / "a"), "old");
    EXPECT_EQ(read_file(folder / "c"), "complete");
    EXPECT_FALSE(has("a.partial") || has("b.partial") || has("b") || has("gone.partial"));
  }
}

TEST_F(EndBySignal, AForkedProcessLeavesWhatItsParentWritesAlone) {
  const int status = status_of([&] {
    AtomicFile parents(folder / "parents");
    say_when_ended_by_signal("; it goes on");
    const pid_t child = ::fork();
    if (child == 0) {
      const AtomicFile own(folder / "own");
      ::raise(SIGTERM);
    }
    int of_child = 0;
    ::waitpid(child, &of_child, 0);
    if (WIFSIGNALED(of_child) && said().empty() && has("parents.partial") && !has("own.partial")) ::raise(SIGTERM);
  });
  EXPECT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(said(), "grtx: ended by SIGTERM: what was being written is removed; it goes on\n");
  EXPECT_FALSE(has("parents.partial"));
}

TEST_F(EndBySignal, AnIgnoredSignalStaysIgnored) {
  const pid_t child = ::fork();
  if (child == 0) {
    ::signal(SIGINT, SIG_IGN);
    end_tidily_by_signals();
    ::raise(SIGINT);
    ::_exit(7);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 7) << "as of nohup, or of a shell's background";
}

}  // namespace
}  // namespace grtx
