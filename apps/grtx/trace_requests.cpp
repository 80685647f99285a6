// SPDX-License-Identifier: Apache-2.0
#include "grtx/apps/grtx/trace_requests.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "grtx/apps/grtx/commands.h"
#include "grtx/base/error.h"
#include "grtx/base/json.h"
#include "grtx/frontend/tracer/scene_tracer.h"

namespace grtx::apps {
namespace {

void trace_request(std::vector<std::string> arguments, const std::shared_ptr<frontend::SceneTracer>& kept) {
  CLI::App app;
  CommonOptions common;
  add_trace(app, common, kept);
  arguments.insert(arguments.begin(), "trace");
  std::reverse(arguments.begin(), arguments.end());  // CLI11 expects them in reverse order
  try {
    app.parse(arguments);
  } catch (const CLI::ParseError& error) {
    throw Error("trace", "", error.what());
  }
  common.action();
}

}  // namespace

int answer_trace_requests(std::istream& requests, std::FILE* answers) {
  const auto kept = std::make_shared<frontend::SceneTracer>();
  for (std::string line; std::getline(requests, line);) {
    const frontend::SceneTracer::Work before = kept->work();
    trace_request(parse_json(line, "sweep --tracer").get<std::vector<std::string>>(), kept);
    const frontend::SceneTracer::Work& after = kept->work();
    fmt::print(answers, "{}\n",
               json_text(nlohmann::json{{"scenes_read", after.scenes_read - before.scenes_read},
                                        {"structures_built", after.structures_built - before.structures_built}}));
    std::fflush(answers);
  }
  return 0;
}

}  // namespace grtx::apps
