// SPDX-License-Identifier: Apache-2.0
#include "grtx/apps/grtx/options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "grtx/apps/grtx/json_output.h"
#include "grtx/apps/grtx/usage_error.h"
#include "grtx/experiment/machine.h"
#include "grtx/experiment/option_text.h"
#include "grtx/rtl_tlm/gpu/memory_files.h"

namespace grtx::apps {

CLI::App* make_command(CLI::App& app, CommonOptions& common, const std::string& name, const std::string& description,
                       std::function<int()> body) {
  CLI::App* command = app.add_subcommand(name, description);
  command->option_defaults()->always_capture_default();
  command->add_flag(
      "--quiet", common.quiet,
      "No progress, and no text but errors, warnings and what the command is asked to print (default: off)");
  command->add_flag("--json", common.json, json_help(name));
  command->callback([&common, command, body = std::move(body)] {
    refuse_odd_numbers(*command);
    common.files.take(*command);
    common.action = body;
  });
  return command;
}

CLI::Validator one_of(experiment::OneOf rule) {
  const std::string choices = "{" + joined_names(rule.names) + "}";
  return CLI::Validator([rule = std::move(rule)](std::string& value) { return experiment::breach(rule, value); },
                        choices);
}

CLI::Validator one_of(std::vector<std::string> names) { return one_of(experiment::OneOf{std::move(names)}); }

CLI::Validator above_zero() {
  return CLI::Validator(
      [](std::string& text) -> std::string {
        double value = 0.0;
        if (CLI::detail::lexical_cast(text, value) && value > 0.0) return {};
        return fmt::format("must be above 0, not {}", text);
      },
      "POSITIVE");
}

void add_view_options(CLI::App* command, experiment::ViewOptions& view) {
  command
      ->add_option("--cameras", view.cameras, "3DGS cameras.json, NeRF transforms.json or COLMAP folder (no default)")
      ->type_name(kInputFile)
      ->required();
  command->add_option("--view", view.view, "Index of the view in the camera file");
  command->add_option("--width", view.width, "Image width in pixels; 0 takes the camera's")
      ->check(in_range(0U, 65536U));
  command->add_option("--height", view.height, "Image height in pixels; 0 takes the camera's")
      ->check(in_range(0U, 65536U));
  command->add_option("--fov-scale", view.fov_scale, "Factor on the tangent of half the field of view")
      ->check(in_range(1e-3, 1e3));
}

void add_views_option(CLI::App* command, experiment::ViewOptions& view) {
  command
      ->add_option("--views", view.views,
                   "Views A:B, both included, as the frames of a sequence in one trace: caches stay warm from frame to "
                   "frame (default: one view)")
      ->excludes("--view");
}

namespace {

std::string machine_help(const char* which) {
  return fmt::format(
      "{}: hardware configuration and tracer options in one word, {} or a file .toml of what differs "
      "from paper, or from what it includes; --config and options of the tracer override it",
      which, fmt::join(experiment::machine_names(), ", "));
}

}  // namespace

CLI::Option* add_machine_option(CLI::App* command, std::string& machine) {
  return command->add_option("--machine", machine, machine_help("Machine"))->type_name(kMachineType);
}

CLI::Option* add_machine_option(CLI::App* command, std::vector<std::string>& machines) {
  return command
      ->add_option("--machine", machines, machine_help("Machine, or several with commas, which are compared, too"))
      ->delimiter(',')
      ->allow_extra_args(false)
      ->default_str(machines.front())
      ->type_name(kMachineType);
}

experiment::ChosenMachine choose_machine(const experiment::MachineChoice& choice, const CommonOptions& common,
                                         bool check) {
  experiment::ChosenMachine chosen = experiment::choose_machine(choice, check);
  for (const std::string& file : chosen.files) common.files.check(file);
  common.files.check(sim::memory_files(chosen.config));
  return chosen;
}

void add_flatten_option(CLI::App* command, bool& flatten) {
  command->add_flag("--flatten", flatten,
                    "Of an object list: all Gaussians in one scene, not three levels (default: off)");
}

void add_heatmap_option(CLI::App* command, std::vector<std::string>& texts, const std::vector<std::string>& names) {
  command
      ->add_option(
          "--heatmap", texts,
          fmt::format("NAME or NAME=F.png: picture of a number per pixel, and the raw values as F.exr; NAME is "
                      "one of {}; may be repeated (default: none)",
                      fmt::join(names, ", ")))
      ->type_name(kOutputFile)
      ->allow_extra_args(false);
}

}  // namespace grtx::apps
