// SPDX-License-Identifier: Apache-2.0
// grtx info: describes the content of a scene file.
#include <fmt/format.h>

#include <memory>

#include "grtx/apps/grtx/commands.h"
#include "grtx/apps/grtx/options.h"
#include "grtx/frontend/scene/scene_info.h"
#include "grtx/frontend/scene/scene_io.h"

namespace grtx::apps {

void add_info(CLI::App& app, CommonOptions& common) {
  struct Options {
    std::string scene;
  };
  const auto options = std::make_shared<Options>();
  CLI::App* command = make_command(
      app, common, "info", "Describes a scene: counts, boxes, percentiles, dropped rows", [options, &common] {
        const frontend::SceneInfo info = frontend::describe(frontend::load_scene(options->scene));
        std::string text = common.json ? frontend::to_json(info) : frontend::to_text(info);
        if (!text.ends_with('\n')) text += '\n';
        fmt::print("{}", text);
        return 0;
      });
  command->add_option("SCENE", options->scene, "Scene file, or folder of a SOG scene (no default)")
      ->type_name(kInputFile)
      ->required();
}

}  // namespace grtx::apps
