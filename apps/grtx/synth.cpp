// SPDX-License-Identifier: Apache-2.0
// grtx synth: makes a scene with the statistics of trained ones, and its cameras.
#include <memory>
#include <string>

#include "grtx/apps/grtx/commands.h"
#include "grtx/apps/grtx/json_output.h"
#include "grtx/apps/grtx/options.h"
#include "grtx/base/error.h"
#include "grtx/frontend/synth/synth.h"

namespace grtx::apps {

void add_synth(CLI::App& app, CommonOptions& common) {
  struct Options {
    frontend::SynthOptions synth;
    std::string output;
  };
  const auto options = std::make_shared<Options>();
  CLI::App* command =
      make_command(app, common, "synth", "Makes a scene with the statistics of trained ones", [options, &common] {
        frontend::synthesise(options->synth, options->output);
        if (common.json) {
          nlohmann::ordered_json json = json_document("synth");
          json["scene"] = options->output;
          json["cameras"] = frontend::synth_cameras_path(options->output);
          json["preset"] = options->synth.preset;
          json["gaussians"] = options->synth.count;
          json["seed"] = options->synth.seed;
          json["sh_degree"] = options->synth.sh_degree;
          print_json(json);
        }
        return 0;
      });
  command->add_option("--preset", options->synth.preset, "Kind of scene")->check(one_of(frontend::synth_presets()));
  // Checked as a real number, so that 1e6 is answered with the rule for whole numbers and not with the range.
  command->add_option("--count", options->synth.count, "Number of Gaussians")->check(in_range(1.0, 4294967294.0));
  command->add_option("--seed", options->synth.seed, "Random seed; the same seed gives the same bytes on every host");
  command->add_option("--sh-degree", options->synth.sh_degree, "Spherical-harmonics degree")->check(in_range(0U, 3U));
  command
      ->add_option("-o,--output", options->output, "Scene to write, F.ply; cameras go to F.cameras.json (no default)")
      ->type_name(kOutputFile)
      ->required();
}

}  // namespace grtx::apps
