// SPDX-License-Identifier: Apache-2.0
// A sweep or a search through the program, in a folder of its own.
#pragma once

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "grtx/base/atomic_file.h"
#include "grtx/explore/sweep/database.h"
#include "grtx/explore/sweep/sqlite.h"
#include "paths.h"
#include "shell.h"
#include "temporary_folder.h"

namespace grtx::explore::test {

using grtx::test::Outcome;
using grtx::test::shell;

class SweepBench : public testing::Test {
 protected:
  /// Eight points of a tiny scene on a small machine; `more` is added to the plan.
  void write_plan(const std::string& more = "") {
    write_file(folder + "/plan.toml", "base = '" + grtx::paths::source_dir() +
                                          "/configs/small.toml'\n"
                                          "[[scene]]\npreset = 'object'\ncount = 300\nseed = 7\nwidth = 8\nheight = 8\n"
                                          "[grid]\ntracer.k = [4, 8]\nrt.warp_buffer.entries = [2, 4]\n"
                                          "rt.checkpoint.lanes = [1, 4]\n" +
                                          more);
  }
  std::string arguments(const std::string& database, const std::string& more = "") const {
    return command + " " + folder + "/plan.toml -o " + folder + "/" + database + " " + more;
  }
  Outcome sweep(const std::string& database, const std::string& more = "") const {
    return shell(grtx::paths::program() + " " + arguments(database, more));
  }
  /// Starts a sweep in a process of its own, kills it after a while, and waits for its end. Returns whether it was
  /// still running.
  bool kill_sweep(const std::string& database, std::chrono::milliseconds after, const std::string& more = "") const {
    const std::string line = "exec " + grtx::paths::program() + " " + arguments(database, more + " --quiet");
    const pid_t child = ::fork();
    if (child == 0) {
      ::execl("/bin/sh", "sh", "-c", line.c_str(), static_cast<char*>(nullptr));
      ::_exit(127);
    }
    std::this_thread::sleep_for(after);
    ::kill(child, SIGKILL);
    int status = 0;
    ::waitpid(child, &status, 0);
    return WIFSIGNALED(status);
  }
  /// All rows of a query, columns joined by '|'.
  std::vector<std::string> rows(const std::string& database, const std::string& sql, int columns = 1) const {
    Sqlite opened(folder + "/" + database, Sqlite::Open::read_only);
    SqliteStatement statement(opened, sql);
    std::vector<std::string> list;
    while (statement.step()) {
      std::string row;
      for (int i = 0; i < columns; ++i) row += (i == 0 ? "" : "|") + statement.text(i);
      list.push_back(row);
    }
    return list;
  }
  /// A program that behaves like grtx but for one command: a shell script's lines, which see "$@".
  std::string program(const std::string& lines) const {
    const std::string path = folder + "/program.sh";
    write_file(path, "#!/bin/sh\n" + lines + "\nexec " + grtx::paths::program() + " \"$@\"\n");
    std::filesystem::permissions(path, std::filesystem::perms::owner_all);
    return path;
  }

  const grtx::test::TemporaryFolder own_folder;
  const std::string folder = own_folder.path();
  std::string command = "sweep";
};

}  // namespace grtx::explore::test
