// SPDX-License-Identifier: Apache-2.0
// The machine's keys as CCI parameters (Accellera SystemC Configuration), so that a platform's broker sets them before
// the GPU is built: docs/guide/platform.md. Only for programs that link with CCI; no other file includes this one.
#pragma once

#include <algorithm>
#include <cci_configuration>
#include <cstdint>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "grtx/base/error.h"
#include "grtx/base/nearest_name.h"
#include "grtx/modules/kernel/declare.h"
#include "grtx/rtl_tlm/gpu/gpu_config.h"

namespace grtx::sim {

/// CCI parameters NAME.KEY, e.g. board.gpu0.rt.warp_buffer.entries, one for every key, those of your own units
/// included. They are immutable: presets of the broker set their values, `base` gives the others.
class CciKeys {
 public:
  /// name: relative to the module that is being built, usually that of the GpuComponent. In sc_main the broker must be
  /// passed: cci_get_global_broker(cci_originator("sc_main")). Throws Error{"CCI", parameter, rule} for a preset of the
  /// wrong type, out of range, in conflict with others, or below NAME without being a key. For parameters of your own
  /// with such a name call broker.ignore_unconsumed_preset_values() before.
  explicit CciKeys(const std::string& name, GpuConfig base = {}, cci::cci_broker_handle broker = cci::cci_get_broker())
      : machine_(std::move(base)), broker_(broker) {
    const sc_core::sc_object* const around = sc_core::sc_get_current_object();
    prefix_ = (around == nullptr ? "" : std::string(around->name()) + ".") + name + ".";
    const std::vector<modules::Parameter> keys = config_keys(machine_);
    for (const modules::Parameter& key : keys) {  // of a machine that is resolved, the bandwidth lies over the clock
      rivals_.begin(true);
      rivals_.name(key, {"the machine", 0, ""});
    }
    rivals_.begin(false);
    for (const modules::Parameter& key : keys) std::visit([&](const auto& value) { add(key, value); }, key.value);
    refuse_unknown(keys);
    try {
      rivals_.require_agreement();
      check_config(machine_, "CCI");
    } catch (const Error& error) {
      throw Error(error.file(), prefix_ + error.place(), error.rule());
    }
  }

  /// The configuration to build the GPU with.
  const GpuConfig& machine() const { return machine_; }

 private:
  template <typename Number>
  void add(const modules::Parameter& key, Number* value) {
    make(key, *value);
  }
  void add(const modules::Parameter& key, const modules::Choice& value) { make(key, value.get()); }

  template <typename T>
  void make(const modules::Parameter& key, const T before) {
    const std::string name = prefix_ + key.name;
    if (broker_.has_preset_value(name)) {
      const std::string broken = assign<T>(key, broker_.get_preset_cci_value(name));
      if (!broken.empty()) throw Error("CCI", name, broken);
      rivals_.name(key, {"CCI", 0, ""});
    }
    auto parameter = std::make_unique<cci::cci_param<T, cci::CCI_IMMUTABLE_PARAM>>(
        name, before, broker_, key.description, cci::CCI_ABSOLUTE_NAME, broker_.get_originator());
    parameter->add_metadata("unit", cci::cci_value(key.unit));
    parameter->add_metadata("range", cci::cci_value(range_text(key)));
    parameters_.push_back(std::move(parameter));
  }
  template <typename T>
  static std::string assign(const modules::Parameter& key, const cci::cci_value& value) {
    if (value.is_bool()) {
      if constexpr (!std::is_same_v<T, std::string>) return assign_bool(key, value.get_bool());
    } else if (value.is_int64()) {
      if constexpr (!std::is_same_v<T, std::string>) return assign_integer(key, value.get_int64());
    } else if (value.is_number()) {
      if constexpr (!std::is_same_v<T, std::string>) return assign_real(key, value.get_number());
    } else if (value.is_string()) {
      return assign_string(key, std::string(value.get_string()));
    }
    return "must be " + range_text(key) + ", not " + value.to_json();
  }
  void refuse_unknown(const std::vector<modules::Parameter>& keys) const {
    std::vector<std::string> known;
    for (const modules::Parameter& key : keys) known.push_back(key.name);
    const auto is_table = [&](const std::string& word) {
      return std::any_of(known.begin(), known.end(), [&](const auto& key) { return key.starts_with(word + "."); });
    };
    for (const auto& [name, value] : broker_.get_unconsumed_preset_values()) {
      if (!name.starts_with(prefix_)) continue;
      const std::string key = name.substr(prefix_.size());
      const bool of_a_module = key.starts_with("gpu.") && std::count(key.begin(), key.end(), '.') > 1;
      if (of_a_module || !is_table(key.substr(0, key.find('.')))) continue;
      throw Error("CCI", name, "is no key, the nearest is '" + nearest_name(key, known) + "'");
    }
  }

  GpuConfig machine_;
  cci::cci_broker_handle broker_;
  std::string prefix_;
  RivalKeys rivals_;
  std::vector<std::unique_ptr<cci::cci_param_untyped>> parameters_;
};

}  // namespace grtx::sim
