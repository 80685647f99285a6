// SPDX-License-Identifier: Apache-2.0
#include "grtx/report/page/subject.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <set>
#include <string_view>

#include "grtx/base/json.h"
#include "grtx/explore/sweep/axis.h"
#include "grtx/explore/sweep/designs.h"

namespace grtx::report {
namespace {

using nlohmann::ordered_json;

bool is_one_of(std::string_view name, std::initializer_list<std::string_view> names) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

// Names are those of a trace's header, without the prefix "trace.".
/// Inputs that define the design, follow from other facts, or are less exact forms of them.
bool is_no_fact(std::string_view name) {
  return is_one_of(name, {"accel", "checkpoint", "trace_hash", "config_hash", "files", "files_hash", "warm", "clamped",
                          "scene", "camera"});
}
bool is_of_checkpoints(std::string_view name) {
  return is_one_of(name,
                   {"checkpoint_capacity", "checkpoint_bins", "checkpoint_order", "below_instance", "replay_tmax"});
}
/// Includes glass and mirror, whose position depends on the view.
bool is_of_the_view(std::string_view name) {
  return is_one_of(name, {"scene_hash", "camera_hash", "glass", "mirror"}) || name.starts_with("object_hash.");
}

/// Options of the tracer that a machine chooses: the same picture, traced in another way.
bool is_of_the_machine(std::string_view name) {
  return is_one_of(name, {"machine", "child_order", "pop_test", "any_hit", "ahead", "bvh_width", "instance_bounds",
                          "layout", "mapping", "warp_size"}) ||
         is_of_checkpoints(name) || name.starts_with("memory.");
}

/// The most important facts, listed first and in this order.
constexpr std::array<const char*, 4> kMachineFacts = {"machine", "mode", "warm.camera_hash", "model_version"};

constexpr const char* kNone = "–";           ///< for a fact that a result lacks
constexpr const char* kUnknown = "unknown";  ///< warm caches, but the warming view is not recorded

/// A fact as part of a sentence.
std::string words(const std::string& name, const std::string& value) {
  if (is_one_of(name, {"machine", "mode", "view"})) return name + " " + value;
  if (name == "model_version") return "model version " + value;
  if (name == "warm.camera_hash") return value == kNone ? "cold caches" : "warm caches";
  if (is_one_of(name, {"scene", "size"})) return value;
  return name + " = " + value;
}

std::string joined(const std::vector<std::string>& parts, const char* between = ", ") {
  std::string text;
  for (const std::string& part : parts) text += (text.empty() ? "" : between) + part;
  return text;
}

std::string value_of(const std::map<std::string, std::string>& facts, const std::string& name) {
  const auto found = facts.find(name);
  return found == facts.end() ? "" : found->second;
}

void add_differences(const std::map<std::string, std::string>& own, const std::map<std::string, std::string>& other,
                     std::vector<Fact>& facts) {
  std::set<std::string> names;
  for (const auto* side : {&own, &other}) {
    for (const auto& [name, value] : *side) names.insert(name);
  }
  for (const std::string& name : names) {
    if (value_of(own, name) != value_of(other, name)) facts.push_back({name, value_of(own, name)});
  }
}

bool has(const ordered_json& config, const std::string& key, const std::string& value) {
  return config.is_object() && config.contains(key) && explore::text_of(config.at(key)) == value;
}

/// A key that says whether the design's hardware is there or how it works: not how much of it. What is so by default
/// tells no design from another.
bool is_switch(const std::pair<std::string, std::string>& key) {
  static const ordered_json by_default = sim::config_json(sim::GpuConfig());
  return key.second.find_first_not_of("0123456789.") != std::string::npos && !has(by_default, key.first, key.second);
}

/// The machine's name without what says that keys of it were changed.
std::string unchanged(const std::string& machine) { return machine.substr(0, machine.find(", changed")); }

std::string size_of(const Subject& subject) {
  const std::string width = subject.setting("width");
  return width.empty() ? "" : width + " × " + subject.setting("height");
}

}  // namespace

std::string design_name(const ordered_json& inputs, const ordered_json& config) {
  const auto input = [&](const char* name) {
    return inputs.is_object() && inputs.contains(name) ? explore::text_of(inputs.at(name)) : "";
  };
  const std::string accel = input("accel"), checkpoint = input("checkpoint");
  if (accel.empty() || (checkpoint != "on" && checkpoint != "off")) return "";
  std::string name = accel + (checkpoint == "on" ? "+checkpoint" : "");
  std::ptrdiff_t most = -1;
  for (const explore::Design& design : explore::designs()) {
    if (design.accel != accel || design.checkpoint != (checkpoint == "on")) continue;
    const std::ptrdiff_t own = std::count_if(design.keys.begin(), design.keys.end(), is_switch);
    const bool all = std::all_of(design.keys.begin(), design.keys.end(), [&](const auto& key) {
      return !is_switch(key) || has(config, key.first, key.second);
    });
    if (!all || own <= most) continue;
    name = design.name;
    most = own;
  }
  return name;
}

Subject::Subject(const ordered_json& inputs, const ordered_json& config,
                 const std::map<std::string, std::string>& more) {
  if (config.is_object()) config_ = config;
  std::map<std::string, std::string> all;
  if (inputs.is_object()) {
    for (const auto& [name, value] : inputs.items()) {
      all[name.starts_with("trace.") ? name.substr(6) : name] = explore::text_of(value);
    }
  }
  for (const auto& [name, value] : more) {
    if (!value.empty()) all[name] = value;
  }
  scene_ = std::filesystem::path(value_of(all, "scene")).stem().string();
  camera_ = value_of(all, "camera");
  checkpoint_ = value_of(all, "checkpoint") == "on";
  if (!value_of(all, "machine").empty()) all["machine"] = std::filesystem::path(all["machine"]).stem().string();
  if (!value_of(all, "warm").empty()) all.try_emplace("warm.camera_hash", kUnknown);  // result of an older version
  for (const auto& [name, value] : all) {
    if (is_no_fact(name)) continue;
    (is_of_the_view(name) ? view_ : is_of_checkpoints(name) ? checkpoint_settings_ : settings_)[name] = value;
  }
  design_ = design_name(inputs, config);
  for (const explore::Design& design : explore::designs()) {
    if (design.name != design_) continue;
    for (const auto& [name, value] : design.tracer) {
      if (setting(name) == value) of_design_.insert(name);
    }
    for (const auto& [key, value] : explore::keys_for(design, explore::k_of(design, setting("k")))) {
      if (has(config_, key, value)) of_design_.insert(key);
    }
  }
}

std::string Subject::setting(const std::string& name) const { return value_of(settings_, name); }

std::string Subject::text(const std::string& k) const {
  std::vector<std::string> parts;
  if (!scene_.empty()) parts.push_back(scene_);
  if (!camera_.empty()) parts.push_back("view " + camera_);
  if (const std::string size = size_of(*this); !size.empty()) parts.push_back(size);
  if (!k.empty()) parts.push_back(words("k", k));
  if (const std::string machine = machine_text(); !machine.empty()) parts.push_back(machine);
  return joined(parts);
}

std::string Subject::machine_text() const {
  std::vector<std::string> parts;
  for (const std::string name : kMachineFacts) {
    const auto found = settings_.find(name);
    if (found != settings_.end()) parts.push_back(words(found->first, found->second));
  }
  return joined(parts);
}

std::vector<Fact> Subject::differences(const Subject& other, MayDiffer may) const {
  std::vector<Fact> facts;
  const bool designs = may == MayDiffer::designs && design_ != other.design_;
  const auto brought = [&](const Fact& fact) {
    return designs && (of_design_.contains(fact.name) || other.of_design_.contains(fact.name));
  };
  std::vector<Fact> keys;
  if (config_ != other.config_) {
    std::map<std::string, std::string> own, its;
    for (const auto& [key, value] : config_.items()) own[key] = explore::text_of(value);
    for (const auto& [key, value] : other.config_.items()) its[key] = explore::text_of(value);
    add_differences(own, its, keys);
    std::erase_if(keys, brought);
  }
  if (may != MayDiffer::views) {
    // Reports the name if names differ, else the hash (an edited file, or two cameras of one name).
    const auto add = [&](const char* name, const std::string& own, const std::string& its, const char* hash) {
      facts.push_back(own != its ? Fact{name, own} : Fact{hash, value_of(view_, hash)});
    };
    const auto same = [&](const char* hash) { return value_of(view_, hash) == value_of(other.view_, hash); };
    if (!same("scene_hash")) add("scene", scene_, other.scene_, "scene_hash");
    const bool resized = size_of(*this) != size_of(other) || setting("fov_scale") != other.setting("fov_scale");
    if (!same("camera_hash") && (camera_ != other.camera_ || !resized)) {
      add("view", camera_, other.camera_, "camera_hash");
    }
    std::map<std::string, std::string> own = view_, its = other.view_;
    for (const char* name : {"scene_hash", "camera_hash"}) {
      own.erase(name);
      its.erase(name);
    }
    add_differences(own, its, facts);
  }
  if (size_of(*this) != size_of(other)) facts.push_back({"size", size_of(*this)});
  const std::size_t before = facts.size();
  add_differences(settings_, other.settings_, facts);
  const std::string machine = setting("machine"), its_machine = other.setting("machine");
  // Keys of the design change the machine's name, too.
  const bool one_machine = designs && keys.empty() && unchanged(machine) == unchanged(its_machine);
  std::erase_if(facts, [&](const Fact& fact) {
    return is_one_of(fact.name, {"width", "height"}) || brought(fact) || (one_machine && fact.name == "machine");
  });
  std::stable_partition(facts.begin() + static_cast<std::ptrdiff_t>(before), facts.end(), [](const Fact& fact) {
    return std::find(kMachineFacts.begin(), kMachineFacts.end(), fact.name) != kMachineFacts.end();
  });
  if (may == MayDiffer::machines) {
    std::erase_if(facts, [](const Fact& fact) { return is_of_the_machine(fact.name); });
    return facts;
  }
  if (checkpoint_ && other.checkpoint_) add_differences(checkpoint_settings_, other.checkpoint_settings_, facts);
  // If the machines' names differ, their keys are not listed.
  if (machine == its_machine) facts.insert(facts.end(), keys.begin(), keys.end());
  return facts;
}

std::string Subject::unknown() const {
  for (const auto& [name, what] : {std::pair("scene_hash", "scene"), std::pair("camera_hash", "camera")}) {
    if (value_of(view_, name).empty()) return what;
  }
  for (const auto& [name, what] :
       {std::pair("width", "size"), std::pair("mode", "mode"), std::pair("model_version", "model version")}) {
    if (setting(name).empty()) return what;
  }
  const auto warm = settings_.find("warm.camera_hash");
  return warm != settings_.end() && warm->second == kUnknown ? "view that ran before" : "";
}

std::string Subject::fact(const std::string& name) const {
  if (name == "scene") return scene_;
  if (name == "view") return camera_;
  if (name == "size") return size_of(*this);
  for (const auto* facts : {&settings_, &view_, &checkpoint_settings_}) {
    if (std::string value = value_of(*facts, name); !value.empty()) return value;
  }
  return config_.contains(name) ? explore::text_of(config_.at(name)) : "";
}

std::string Subject::settings_text(const std::set<std::string>& without) const {
  ordered_json keys = config_;
  for (const std::string& name : without) keys.erase(name);
  std::string text = json_text(keys);
  for (const auto& [name, value] : settings_) {
    if (!without.contains(name) && name != "mode" && !name.starts_with("windows."))
      text.append("\n").append(name).append("=").append(value);
  }
  return text;
}

std::string Subject::view_text() const {
  std::string text = size_of(*this) + "\n" + setting("fov_scale");
  for (const auto& [name, value] : view_) text.append("\n").append(name).append("=").append(value);
  return text;
}

std::vector<std::string> set_apart(const std::vector<Subject>& subjects, const std::vector<std::string>& otherwise) {
  constexpr std::size_t kMostFacts = 4;
  std::vector<std::string> facts = {"scene", "view", "size"};
  facts.insert(facts.end(), kMachineFacts.begin(), kMachineFacts.end());
  for (const Subject& a : subjects) {
    for (const Subject& b : subjects) {
      for (const Fact& fact : a.differences(b, MayDiffer::designs)) {
        if (std::find(facts.begin(), facts.end(), fact.name) == facts.end()) facts.push_back(fact.name);
      }
    }
  }
  // Uses a fact only if it distinguishes results that earlier facts do not.
  std::vector<std::string> names(subjects.size());
  for (std::size_t f = 0, named = 0; f < facts.size() && named < kMostFacts; ++f) {
    std::vector<std::string> parts;
    for (const Subject& subject : subjects) {
      const std::string value = subject.fact(facts[f]);
      parts.push_back(facts[f] == "machine" && !value.empty() ? value : words(facts[f], value.empty() ? kNone : value));
    }
    bool tells = false;
    for (std::size_t i = 0; i < names.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) tells = tells || (names[i] == names[j] && parts[i] != parts[j]);
    }
    if (!tells) continue;
    ++named;
    for (std::size_t i = 0; i < names.size(); ++i) names[i] += (names[i].empty() ? "" : ", ") + parts[i];
  }
  std::map<std::string, std::size_t> all, seen;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i].empty()) names[i] = otherwise[i];
    ++all[names[i]];
  }
  for (std::string& name : names) {
    if (all[name] > 1) name += fmt::format(" ({})", ++seen[name]);
  }
  return names;
}

std::string machines_text(const std::vector<Subject>& subjects) {
  std::vector<std::string> parts;
  for (const std::string name : kMachineFacts) {
    std::vector<std::string> values;
    for (const Subject& subject : subjects) {
      const std::string value = subject.setting(name);
      if (!value.empty() && std::find(values.begin(), values.end(), value) == values.end()) values.push_back(value);
    }
    if (values.empty()) continue;
    const std::string text = words(name, joined(values, " and "));
    const bool plural = values.size() > 1 && is_one_of(name, {"machine", "mode"});
    parts.push_back(plural ? text.substr(0, name.size()) + "s" + text.substr(name.size()) : text);
  }
  return joined(parts);
}

}  // namespace grtx::report
