// SPDX-License-Identifier: Apache-2.0
// A file appears under its final name only when it was committed.
#include "grtx/base/atomic_file.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "grtx/base/error.h"
#include "temporary_folder.h"

namespace {

std::size_t files_in(const std::filesystem::path& folder) {
  std::size_t count = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder)) ++count;
  return count;
}

struct AtomicFileTest : testing::Test {
  const grtx::test::TemporaryFolder own_folder;
  const std::filesystem::path folder = own_folder.path();
};

TEST_F(AtomicFileTest, LeavesNothingWithoutCommit) {
  { grtx::AtomicFile(folder / "a").write("half"); }
  EXPECT_EQ(files_in(folder), 0u);
}

TEST_F(AtomicFileTest, KeepsTheOldFileWithoutCommit) {
  grtx::write_file(folder / "a", "old");
  { grtx::AtomicFile(folder / "a").write("new"); }
  EXPECT_EQ(grtx::read_file(folder / "a"), "old");
}

TEST_F(AtomicFileTest, ReplacesOnCommit) {
  grtx::write_file(folder / "a", "old");
  grtx::write_file(folder / "a", "new");
  EXPECT_EQ(grtx::read_file(folder / "a"), "new");
  EXPECT_EQ(files_in(folder), 1u);
}

TEST_F(AtomicFileTest, MissingFolderIsAnError) {
  EXPECT_THROW(grtx::write_file(folder / "missing" / "a", "x"), grtx::Error);
}

TEST_F(AtomicFileTest, FollowsASymbolicLinkToItsTarget) {
  std::filesystem::create_directories(folder / "there");
  grtx::write_file(folder / "there" / "target", "old");
  std::filesystem::create_symlink("there/target", folder / "link");
  std::filesystem::create_symlink("there/new", folder / "dangling");
  grtx::write_file(folder / "link", "new");
  grtx::write_file(folder / "dangling", "made");
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "link"));
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "dangling"));
  EXPECT_EQ(grtx::read_file(folder / "there" / "target"), "new");
  EXPECT_EQ(grtx::read_file(folder / "there" / "new"), "made");
  EXPECT_EQ(files_in(folder), 3u);
}

TEST_F(AtomicFileTest, WritesWhatIsNoRegularFileDirectly) {
  const std::filesystem::path fifo = folder / "fifo";
  ASSERT_EQ(::mkfifo(fifo.c_str(), 0600), 0);
  const int reader = ::open(fifo.c_str(), O_RDONLY | O_NONBLOCK);
  grtx::write_file(fifo, "text");
  char text[8] = {};
  EXPECT_EQ(::read(reader, text, sizeof text), 4);
  EXPECT_STREQ(text, "text");
  ::close(reader);
  EXPECT_TRUE(std::filesystem::is_fifo(fifo));
  grtx::write_file("/dev/null", "text");
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/null"));
  EXPECT_THROW(grtx::write_file(folder, "text"), grtx::Error);
}

TEST_F(AtomicFileTest, ADeviceThatIsFullIsAnError) {
  EXPECT_THROW(grtx::write_file("/dev/full", "text"), grtx::Error);
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/full"));
}

TEST_F(AtomicFileTest, TakesOverWhatAKilledRunLeft) {
  grtx::write_file(folder / "a.partial", "a longer text that was left");
  grtx::write_file(folder / "a", "new");
  EXPECT_EQ(grtx::read_file(folder / "a"), "new");
  EXPECT_EQ(files_in(folder), 1u);
}

TEST_F(AtomicFileTest, TwoProcessesThatWriteTheSameFileDoNotMix) {
  grtx::AtomicFile mine(folder / "a");
  mine.write("of the parent");
  const pid_t child = ::fork();
  if (child == 0) {
    // Another process, with its own view of what it writes: as a run of its own would.
    const int other = ::open((folder / "a.partial").c_str(), O_WRONLY);
    ::_exit(other >= 0 && ::flock(other, LOCK_EX | LOCK_NB) != 0 ? 0 : 1);
  }
  int status = -1;
  ::waitpid(child, &status, 0);
  EXPECT_EQ(status, 0) << "the partial file is not locked while it is written";
  EXPECT_THROW(grtx::AtomicFile(folder / "a"), grtx::Error);  // the same process: two outputs with one name
  mine.commit();
  EXPECT_EQ(grtx::read_file(folder / "a"), "of the parent");
  grtx::write_file(folder / "a", "again");
  EXPECT_EQ(grtx::read_file(folder / "a"), "again");
}

TEST_F(AtomicFileTest, TwoProcessesThatWriteTheSameFileAgainAndAgainDoNotLoseIt) {
  const std::string path = (folder / "f").string();
  constexpr int kProcesses = 4, kTimes = 200;
  const auto content = [](int process) { return std::string(5000, static_cast<char>('a' + process)); };
  std::vector<pid_t> children;
  for (int process = 0; process < kProcesses; ++process) {
    const pid_t child = ::fork();
    if (child == 0) {
      try {
        for (int i = 0; i < kTimes; ++i) {
          grtx::write_file(path, content(process));
          const std::string read = grtx::read_file(path);
          if (read.size() != 5000 || read != std::string(5000, read.front())) ::_exit(2);
        }
      } catch (const grtx::Error&) {
        ::_exit(1);
      }
      ::_exit(0);
    }
    children.push_back(child);
  }
  for (const pid_t child : children) {
    int status = -1;
    ::waitpid(child, &status, 0);
    EXPECT_EQ(WEXITSTATUS(status), 0);  // 1: a file could not be written; 2: it was of nobody
  }
  EXPECT_EQ(files_in(folder), 1U);
}

TEST_F(AtomicFileTest, LinksAndPipesInPlaceOfItsPartialFilesKeepWhatTheyHold) {
  const std::string own = "a.partial." + std::to_string(::getpid());
  grtx::write_file(folder / "victim", "somebody's work");
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  struct Trap {
    const char* says;
    std::function<void(const std::filesystem::path&)> set;
  };
  const Trap traps[] = {
      {"symbolic link", [&](const auto& at) { std::filesystem::create_symlink(folder / "victim", at); }},
      {"link to nothing", [&](const auto& at) { std::filesystem::create_symlink(folder / "none", at); }},
      {"second name", [&](const auto& at) { std::filesystem::create_hard_link(folder / "victim", at); }},
      {"pipe", [&](const auto& at) { std::filesystem::create_hard_link(folder / "pipe", at); }}};
  for (const Trap& trap : traps) {
    SCOPED_TRACE(trap.says);
    for (const std::string& name : {std::string("a.partial"), own, own + ".1"}) trap.set(folder / name);
    grtx::write_file(folder / "a", trap.says);
    EXPECT_EQ(grtx::read_file(folder / "a"), trap.says);
    EXPECT_EQ(grtx::read_file(folder / "victim"), "somebody's work");
    EXPECT_EQ(files_in(folder), 6u);  // a, the victim, the pipe and three traps
    for (const std::string& name : {std::string("a.partial"), own, own + ".1"}) {
      EXPECT_TRUE(std::filesystem::remove(folder / name));
    }
  }
}

TEST_F(AtomicFileTest, GoesByAnotherNameWhileAnotherProcessWrites) {
  grtx::write_file(folder / "a.partial", "theirs");
  const int theirs = ::open((folder / "a.partial").c_str(), O_RDWR);
  ASSERT_EQ(::flock(theirs, LOCK_EX | LOCK_NB), 0);
  grtx::write_file(folder / "a", "mine");
  EXPECT_EQ(grtx::read_file(folder / "a"), "mine");
  EXPECT_EQ(grtx::read_file(folder / "a.partial"), "theirs");
  ::close(theirs);
}

TEST_F(AtomicFileTest, ANameOf255BytesIsTakenAndOneOf256Refused) {
  for (const std::string& name : {std::string(250, 'n'), std::string(255, 'n'), "n" + std::string(254, '\xc3')}) {
    grtx::write_file(folder / name, "text");
    EXPECT_EQ(grtx::read_file(folder / name), "text");
  }
  EXPECT_EQ(files_in(folder), 3u);
  EXPECT_THROW(grtx::AtomicFile(folder / std::string(256, 'n')), grtx::Error) << "at once, not when it is complete";
  // Names that are cut differ where the whole ones do, and are found again.
  grtx::AtomicFile a(folder / (std::string(250, 'm') + "a")), b(folder / (std::string(250, 'm') + "b"));
  EXPECT_EQ(files_in(folder), 5u);
}

TEST_F(AtomicFileTest, DevStdoutIsWrittenAndNotReplaced) {
  int ends[2] = {};
  ASSERT_EQ(::pipe(ends), 0);
  const int file = ::open((folder / "redirected").c_str(), O_RDWR | O_CREAT, 0600);
  ASSERT_EQ(::write(file, "before ", 7), 7);
  for (const char* folder_of : {"/dev/fd/", "/proc/self/fd/"}) {
    grtx::write_file(folder_of + std::to_string(ends[1]), "text");
    char text[8] = {};
    EXPECT_EQ(::read(ends[0], text, sizeof text), 4);
    EXPECT_STREQ(text, "text");
    grtx::write_file(folder_of + std::to_string(file), "text ");
  }
  std::filesystem::create_symlink("/dev/fd/" + std::to_string(file), folder / "link");
  grtx::write_file(folder / "link", "linked");
  EXPECT_EQ(grtx::read_file(folder / "redirected"), "before text text linked");
  EXPECT_THROW(grtx::write_file("/dev/fd/999", "text"), grtx::Error);
  ::close(ends[0]);
  ::close(ends[1]);
  ::close(file);
}

}  // namespace
