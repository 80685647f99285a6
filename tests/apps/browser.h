// SPDX-License-Identifier: Apache-2.0
// A page in Chromium without a screen, looked at by a script in this folder. Needs node, Chromium and the packages that
// the build fetched for the charts.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "apps/program.h"
#include "paths.h"

namespace grtx::e2e {

class InBrowser : public ::testing::Test {
 protected:
  explicit InBrowser(std::string script) : script_(std::move(script)) {}

  void SetUp() override {
    if (grtx::paths::charts_folder().empty()) GTEST_SKIP() << "built without charts";
    if (std::system("command -v node >/dev/null") != 0) GTEST_SKIP() << "needs node (Debian: nodejs)";
    for (const char* path : {"/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"}) {
      if (chromium.empty() && std::filesystem::exists(path)) chromium = path;
    }
    if (chromium.empty()) GTEST_SKIP() << "needs Chromium (Debian: chromium)";
  }

  /// What the script found; an empty object, and a failure, when it ended otherwise.
  nlohmann::json look(const std::string& page) {
    // GRTX_SCREENSHOTS=FOLDER keeps pictures of what the browser showed.
    const char* shots = std::getenv("GRTX_SCREENSHOTS");
    const std::string prefix =
        shots == nullptr ? "" : std::string(shots) + "/" + std::filesystem::path(page).stem().string();
    const std::string command = "node '" + grtx::paths::source_dir() + "/tests/apps/" + script_ + "' '" +
                                folder.path(page) + "' '" + grtx::paths::charts_folder() + "' '" + chromium + "' '" +
                                prefix + "' >'" + folder.path("found.json") + "' 2>'" + folder.path("log") + "'";
    if (std::system(command.c_str()) != 0) {
      ADD_FAILURE() << folder.read("log");
      return nlohmann::json::object();
    }
    return nlohmann::json::parse(folder.read("found.json"));
  }

  Folder folder;
  std::string chromium;

 private:
  const std::string script_;
};

}  // namespace grtx::e2e
