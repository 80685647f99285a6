#include "grtx/explore/cost/run_machine.h"

#include <charconv>

#include "grtx/base/error.h"

namespace grtx::sim {

MachineUse machine_of_run(const nlohmann::ordered_json& inputs, const std::string& where) {
  const std::string accel = inputs.value("accel", ""), checkpoint = inputs.value("checkpoint", "");
  if (accel.empty() || checkpoint.empty()) throw Error(where, "inputs", "must name accel and checkpoint");
  const bool two_level = accel.starts_with("tlas-");
  MachineUse use;
  use.design = checkpoint == "on" ? (two_level ? "grtx" : "hw") : (two_level ? "sw" : "baseline");
  use.objects = inputs.value("levels", "") == "3";
  use.leaves = leaf_test_of(accel);
  const auto choose = [&]<typename Enum>(const char* name, Enum& value) {
    if (inputs.contains(name)) {
      value = value_of<Enum>(inputs.at(name).get<std::string>(), where, std::string("inputs.") + name);
    }
  };
  choose("pop_test", use.pop_test);
  choose("layout", use.layout);
  choose_bins(inputs, where, use);
  return use;
}

void choose_bins(const nlohmann::ordered_json& inputs, const std::string& where, MachineUse& use) {
  const auto number = [&](const char* name, auto& value) {
    if (!inputs.contains(name)) return;
    const std::string text = inputs.at(name).get<std::string>();
    const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (fault != std::errc() || end != text.data() + text.size()) {
      throw Error(where, std::string("inputs.") + name, "must be a whole number");
    }
  };
  number("checkpoint_bins", use.checkpoint_bins);
  if (use.checkpoint_bins != 0) number("checkpoint_capacity", use.checkpoint_capacity);
}

}  // namespace grtx::sim
