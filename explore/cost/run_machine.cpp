// SPDX-License-Identifier: Apache-2.0
#include "grtx/explore/cost/run_machine.h"

#include <charconv>

#include "grtx/base/error.h"

namespace grtx::explore {

namespace {

/// The input of this name, "" if there is none.
std::string text_of(const nlohmann::ordered_json& inputs, const std::string& where, const std::string& name) {
  const auto found = inputs.find(name);
  if (found == inputs.end()) return "";
  if (!found->is_string()) throw Error(where, "inputs." + name, "must be a text");
  return found->get<std::string>();
}

}  // namespace

sim::MachineUse machine_of_run(const nlohmann::ordered_json& inputs, const std::string& where) {
  const std::string accel = text_of(inputs, where, "accel"), checkpoint = text_of(inputs, where, "checkpoint");
  if (accel.empty() || checkpoint.empty()) throw Error(where, "inputs", "must name accel and checkpoint");
  const bool two_level = accel.starts_with("tlas-");
  sim::MachineUse use;
  use.design = checkpoint == "on" ? (two_level ? "grtx" : "hw") : (two_level ? "sw" : "baseline");
  use.objects = text_of(inputs, where, "levels") == "3";
  use.leaves = sim::leaf_test_of(accel);
  use.peak = true;  // as RtUnit takes a trace that does not say
  choose_nodes_and_lists(inputs, where, use);
  return use;
}

void choose_nodes_and_lists(const nlohmann::ordered_json& inputs, const std::string& where, sim::MachineUse& use) {
  // A run has some of them only among the inputs of its trace.
  const auto recorded = [&](const std::string& name) { return inputs.contains(name) ? name : "trace." + name; };
  const auto choose = [&]<typename Enum>(const std::string& option, Enum& value) {
    const std::string name = recorded(option);
    if (inputs.contains(name)) value = value_of<Enum>(text_of(inputs, where, name), where, "inputs." + name);
  };
  const auto number = [&](const std::string& option, auto& value) {
    const std::string name = recorded(option);
    if (!inputs.contains(name)) return;
    const std::string text = text_of(inputs, where, name);
    const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (fault != std::errc() || end != text.data() + text.size()) {
      throw Error(where, "inputs." + name, "must be a whole number");
    }
  };
  choose("pop_test", use.pop_test);
  choose("opacity_bound", use.opacity_bound);
  choose("layout", use.layout);
  choose("any_hit", use.any_hit);
  if (const std::string key = text_of(inputs, where, recorded("sort_key")); !key.empty()) use.peak = key == "peak";
  const std::string width = recorded("bvh_width");
  number("bvh_width", use.bvh_width);
  if (inputs.contains(width) && (use.bvh_width < 2 || use.bvh_width > traces::kMaxWidth)) {
    throw Error(where, "inputs." + width, "must be 2 to 8");
  }
  number("checkpoint_bins", use.checkpoint_bins);
  if (use.checkpoint_bins != 0) number("checkpoint_capacity", use.checkpoint_capacity);
}

std::vector<std::string> cost_arguments(const sim::MachineUse& use) {
  std::vector<std::string> arguments = {"--design",
                                        use.design,
                                        "--pop-test",
                                        std::string(name_of(use.pop_test)),
                                        "--layout",
                                        std::string(name_of(use.layout)),
                                        "--bvh-width",
                                        std::to_string(use.width()),
                                        "--leaves",
                                        std::string(name_of(use.leaves)),
                                        "--any-hit",
                                        std::string(name_of(use.any_hit)),
                                        "--sort-key",
                                        use.peak ? "peak" : "entry",
                                        "--checkpoint-bins",
                                        std::to_string(use.checkpoint_bins),
                                        "--checkpoint-capacity",
                                        std::to_string(use.checkpoint_capacity)};
  if (use.opacity_bound == traces::OpacityBound::on) {
    arguments.insert(arguments.end(), {"--opacity-bound", std::string(name_of(use.opacity_bound))});
  }
  if (use.objects) arguments.emplace_back("--objects");
  return arguments;
}

}  // namespace grtx::explore
