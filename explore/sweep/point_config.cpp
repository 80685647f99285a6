// SPDX-License-Identifier: Apache-2.0
#include "grtx/explore/sweep/point_config.h"

#include <algorithm>

#include "grtx/base/error.h"
#include "grtx/base/json.h"
#include "grtx/rtl_tlm/gpu/memory_files.h"

namespace grtx::explore {
namespace {

std::string entry_of(const modules::Parameter& key) {
  return json_text(nlohmann::ordered_json(key.name)) + ":" + json_text(sim::value_json(key));
}

}  // namespace

std::string PointConfig::text() const {
  std::size_t length = base_->length + base_->entries.size() + 2;
  for (const auto& [index, entry] : changed_) length += entry.size();
  std::string text = "{";
  text.reserve(length);
  auto change = changed_.begin();
  for (std::size_t i = 0; i < base_->entries.size(); ++i) {
    const bool changed = change != changed_.end() && change->first == i;
    if (i > 0) text += ',';
    text += changed ? (change++)->second : base_->entries[i];
  }
  return text += '}';
}

PointConfigs::PointConfigs(const sim::GpuConfig& base, const sim::RivalKeys& rivals) : trial_(base), rivals_(rivals) {
  const auto made = std::make_shared<PointConfig::Base>();
  for (const modules::Parameter& key : trial_.keys()) {
    made->entries.push_back(entry_of(key));
    made->length += made->entries.back().size();
  }
  base_ = made;
}

PointConfig PointConfigs::with(const Settings& settings, std::string& broken) {
  trial_.reset();
  PointConfig config;
  config.base_ = base_;
  std::vector<std::size_t> places;
  sim::RivalKeys rivals = rivals_;
  rivals.begin(false);
  for (const auto& [name, value] : settings) {
    places.push_back(trial_.set(name, value));
    rivals.name(trial_.keys()[places.back()], {"the plan", 0, ""});
  }
  for (const std::size_t place : places) {
    std::string entry = entry_of(trial_.keys()[place]);
    if (entry != base_->entries[place]) config.changed_.emplace_back(place, std::move(entry));
  }
  std::sort(config.changed_.begin(), config.changed_.end());
  config.changed_.erase(std::unique(config.changed_.begin(), config.changed_.end()), config.changed_.end());
  config.changed_.shrink_to_fit();
  try {
    rivals.require_agreement();
    trial_.check("configuration");
    if (const FilesRead files = sim::memory_files(trial_.config()); !files.files().empty()) {
      config.memory_files_ = files.hash();
    }
  } catch (const Error& error) {
    if (broken.empty()) broken = error.what();
  }
  return config;
}

}  // namespace grtx::explore
