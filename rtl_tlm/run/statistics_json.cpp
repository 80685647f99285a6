// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/run/statistics_json.h"

#include <fmt/format.h>

#include <cassert>
#include <cmath>

#include "grtx/base/error.h"
#include "grtx/base/json.h"
#include "grtx/rtl_tlm/run/model_version.h"

namespace grtx::sim {

nlohmann::ordered_json statistics_object(const modules::StatisticList& list) {
  nlohmann::ordered_json object = nlohmann::ordered_json::object();
  for (const modules::Statistic& statistic : list.items()) {
    assert(!object.contains(statistic.name) && "two statistics with one name");
    nlohmann::ordered_json& entry = object[statistic.name];
    if (const auto* integer = std::get_if<std::uint64_t>(&statistic.value)) {
      entry["value"] = *integer;
    } else if (const double real = std::get<double>(statistic.value); std::isfinite(real)) {
      entry["value"] = real;
    } else {
      entry["value"] = nullptr;
    }
    entry["unit"] = statistic.unit;
    entry["description"] = statistic.description;
  }
  return object;
}

nlohmann::ordered_json list_json(const modules::StatisticList& list) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const modules::Statistic& s : list.items()) {
    nlohmann::ordered_json value;
    std::visit([&value](auto v) { value = v; }, s.value);
    json.push_back({s.name, value, s.unit, s.description, s.picojoules, name_of(s.kind), s.of.part, s.of.whole,
                    s.of.part_name, s.of.whole_name});
  }
  return json;
}

modules::StatisticList list_from_json(const nlohmann::ordered_json& json) {
  modules::StatisticList list;
  for (const nlohmann::ordered_json& j : json) {
    modules::Statistic s;
    s.name = j.at(0);
    if (j.at(1).is_number_unsigned()) {
      s.value = j.at(1).get<std::uint64_t>();
    } else {
      s.value = j.at(1).get<double>();
    }
    s.unit = j.at(2);
    s.description = j.at(3);
    s.picojoules = j.at(4);
    s.kind = *from_name<modules::StatisticKind>(j.at(5).get<std::string>());
    s.of = {j.at(6), j.at(7), j.at(8), j.at(9)};
    list.add(std::move(s));
  }
  return list;
}

nlohmann::ordered_json statistics_document(const nlohmann::ordered_json& config,
                                           const std::map<std::string, std::string>& inputs, const ResultNotes& notes,
                                           const modules::StatisticList& statistics, const modules::StatisticList& host,
                                           const nlohmann::ordered_json& over_time) {
  nlohmann::ordered_json document;
  document["schema"] = "grtx.stats/1";
  document["model_version"] = kModelVersion;
  document["config"] = config;
  document["inputs"] = inputs;
  document["notes"] = notes_json(notes);
  if (!over_time.is_null()) document["over_time"] = over_time;
  document["stats"] = statistics_object(statistics);
  const nlohmann::ordered_json last = statistics_object(host);
  for (const auto& [name, entry] : last.items()) document["stats"][name] = entry;
  return document;
}

std::string statistics_text(const nlohmann::ordered_json& document) {
  std::string text = "{\n";
  const auto member = [&text](const std::string& indent, const std::string& name, const std::string& value, bool last) {
    text += indent + json_text(nlohmann::ordered_json(name)) + ": " + value + (last ? "\n" : ",\n");
  };
  std::size_t written = 0;
  for (const auto& [name, value] : document.items()) {
    const bool last = ++written == document.size();
    if (!value.is_object() || value.empty()) {
      member("  ", name, json_text(value), last);
      continue;
    }
    text += "  " + json_text(nlohmann::ordered_json(name)) + ": {\n";
    std::size_t inner_written = 0;
    for (const auto& [inner_name, inner] : value.items()) {
      member("    ", inner_name, json_text(inner), ++inner_written == value.size());
    }
    text += last ? "  }\n" : "  },\n";
  }
  return text + "}\n";
}

nlohmann::ordered_json read_statistics(const std::string& path) {
  nlohmann::ordered_json document = read_json(path);
  if (!document.is_object() || !document.contains("schema") || document.at("schema") != "grtx.stats/1") {
    throw Error(path, "schema", "must be grtx.stats/1");
  }
  for (const char* part : {"config", "inputs", "stats"}) {
    if (!document.contains(part) || !document.at(part).is_object()) throw Error(path, part, "must be an object");
  }
  if (document.contains("notes")) notes_from(document.at("notes"), path);
  check_statistics(document.at("stats"), path, "");
  return document;
}

void check_statistics(const nlohmann::ordered_json& statistics, const std::string& path, const std::string& place) {
  if (!statistics.is_object()) throw Error(path, place, "must be an object of statistics");
  for (const auto& [name, statistic] : statistics.items()) {
    const std::string at = place + name;
    if (!statistic.is_object() || !statistic.contains("value")) throw Error(path, at, "must have a value");
    if (!statistic.at("value").is_number() && !statistic.at("value").is_null()) {
      throw Error(path, at, "its value must be a number");
    }
    for (const char* text : {"unit", "description"}) {
      if (statistic.contains(text) && !statistic.at(text).is_string())
        throw Error(path, at, std::string("its ") + text + " must be a text");
    }
  }
}

}  // namespace grtx::sim
