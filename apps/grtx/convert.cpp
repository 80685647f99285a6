// SPDX-License-Identifier: Apache-2.0
// grtx convert: converts a scene of any supported format to .ply, .spz or .usda.
#include <fmt/format.h>

#include <filesystem>
#include <memory>

#include "grtx/apps/grtx/commands.h"
#include "grtx/apps/grtx/json_output.h"
#include "grtx/apps/grtx/options.h"
#include "grtx/base/error.h"
#include "grtx/frontend/convert/scene_writer.h"
#include "grtx/frontend/scene/scene_io.h"

namespace grtx::apps {
namespace {

struct ConvertArguments {
  std::string input;
  std::string output;
  frontend::SceneReadOptions read;
};

int convert(const ConvertArguments& options, const CommonOptions& common) {
  const std::string extension = std::filesystem::path(options.output).extension().string();
  if (extension != ".ply" && extension != ".spz" && extension != ".usda")
    throw Error(options.output, "", "must end in .ply, .spz or .usda: these are written");
  FilesRead files;
  const frontend::RawRows rows = frontend::load_rows(options.input, options.read, files);
  common.files.check(files);
  std::uint64_t left_out = 0;
  if (extension == ".ply") {
    frontend::write_ply(rows, options.output);
  } else {
    left_out = (extension == ".spz" ? frontend::write_spz : frontend::write_usda)(rows, options.output);
  }
  if (common.json) {
    nlohmann::ordered_json json = json_document("convert");
    json["scene"] = options.output;
    json["gaussians"] = rows.x.size() - left_out;
    json["sh_degree"] = rows.sh_degree;
    json["left_out"] = left_out;
    print_json(json);
  } else if (!common.quiet) {
    fmt::print("{}: {} Gaussians, SH degree {}\n", options.output, rows.x.size() - left_out, rows.sh_degree);
    if (left_out > 0) fmt::print("left out: {} with a number that is not finite\n", left_out);
  }
  return 0;
}

}  // namespace

void add_convert(CLI::App& app, CommonOptions& common) {
  const auto options = std::make_shared<ConvertArguments>();
  CLI::App* command = make_command(app, common, "convert", "Writes a scene of any format as .ply, .spz or .usda",
                                   [options, &common] { return convert(*options, common); });
  command->add_option("INPUT", options->input, "Scene file, or folder of a SOG scene (no default)")
      ->type_name(kInputFile)
      ->required();
  command->add_option("OUTPUT", options->output, "File to write, .ply, .spz or .usda (no default)")
      ->type_name(kOutputFile)
      ->required();
  command->add_option("--lod", options->read.sog_lod, "Level of detail of a streamed SOG scene; 0: the finest");
  command->add_flag("--spz-raw-axes", options->read.spz_raw_axes,
                    "An .spz input has the axes of a .ply, as splat-transform writes it (default: off)");
}

}  // namespace grtx::apps
