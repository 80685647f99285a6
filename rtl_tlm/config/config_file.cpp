// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/config/config_file.h"

#include <fmt/format.h>

#include <toml++/toml.h>
#include <algorithm>
#include <filesystem>
#include <string_view>
#include <variant>

#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/base/nearest_name.h"

namespace grtx::sim {
namespace {

const modules::Parameter* find_key(const std::vector<modules::Parameter>& keys, const std::string& name) {
  const auto found =
      std::find_if(keys.begin(), keys.end(), [&](const modules::Parameter& key) { return key.name == name; });
  return found == keys.end() ? nullptr : &*found;
}

std::string unknown_key(const std::vector<modules::Parameter>& keys, const std::string& name) {
  if (name == "machine") return "machine: is no key: --machine names it, or the file's include = \"FILE.toml\"";
  std::vector<std::string> known;
  for (const modules::Parameter& key : keys) known.push_back(key.name);
  return fmt::format("unknown key '{}', {}", name, nearest_keys(name, known));
}

/// The comment behind a value on its line of `text`; "" if there is none.
std::string comment_behind(const toml::source_position& end, const std::string& text) {
  std::size_t begin = 0;
  for (unsigned line = 1; line < end.line; ++line) begin = text.find('\n', begin) + 1;
  const std::string line = text.substr(begin, text.find('\n', begin) - begin);
  const std::size_t hash = line.find('#', std::min<std::size_t>(end.column - 1, line.size()));
  const std::size_t first = hash == line.npos ? hash : line.find_first_not_of("# ", hash);
  return first == line.npos ? "" : line.substr(first, line.find_last_not_of(" \r") + 1 - first);
}

std::string line_of(const toml::node& node) { return fmt::format("line {}", node.source().begin.line); }

std::string assign(const modules::Parameter& key, const toml::node& node) {
  if (const auto* integer = node.as_integer()) return assign_integer(key, integer->get());
  if (const auto* real = node.as_floating_point()) return assign_real(key, real->get());
  if (const auto* boolean = node.as_boolean()) return assign_bool(key, boolean->get());
  if (const auto* text = node.as_string()) return assign_string(key, text->get());
  return fmt::format("must be a single value ({}), not a list, table or date", range_text(key));
}

/// The value of an option of the tracer as text; which texts it may have is known to who traces.
std::string tracer_text(const std::string& name, const toml::node& node, std::string& broken) {
  std::string value;
  modules::ParameterList list;
  list.add(name.c_str(), value, {}, "", modules::kOurs);
  broken = assign(list.items().front(), node);
  return value;
}

std::string place_of(const KeyPlace& place, const std::string& key) {
  return place.line == 0 ? key : fmt::format("line {}", place.line);
}

constexpr const char* kTracer = "tracer.";
/// The keys that RivalKeys watches: the first is the clock in which times are written, the second lies over it.
constexpr std::array<const char*, 2> kRivals = {"dram.mhz", "dram.bandwidth_gb_s"};

}  // namespace

void RivalKeys::begin(bool begun_from) {
  ++layer_;
  begun_from_ = begun_from;
}

void RivalKeys::name(const modules::Parameter& key, const KeyPlace& place) {
  const auto* const found = std::find(kRivals.begin(), kRivals.end(), key.name);
  if (found == kRivals.end()) return;
  const auto* const number = std::get_if<double*>(&key.value);
  words_[static_cast<std::size_t>(found - kRivals.begin())] = {layer_, begun_from_,
                                                               number != nullptr && **number == 0.0, place};
}

void RivalKeys::require_agreement() const {
  const auto& [under, over] = words_;
  if (under.layer == 0 || over.layer == 0 || over.off) return;
  if (under.layer < over.layer && under.begun_from) return;
  const bool last = under.layer > over.layer;  // the error is where the later one is
  const Word &at = last ? under : over, &other = last ? over : under;
  std::string where = other.place.file;
  if (other.place.line != 0) where += fmt::format(", line {}", other.place.line);
  throw Error(at.place.file, place_of(at.place, kRivals[last ? 0 : 1]),
              fmt::format("{} ({} is that of {})", contradiction(true, true), kRivals[last ? 1 : 0], where));
}

struct ConfigLayers::Text {
  std::filesystem::path path;
  std::string name;
  std::string text;
  toml::table table;
};

void ConfigLayers::machine(const std::string& name) {
  if (name != kDefaultMachine) read(machine_file(kDefaultMachine), kDefaultMachine, true);
  read(machine_file(name), name, !name.ends_with(".toml"));
}

void ConfigLayers::file(const std::string& path) {
  std::error_code failed;
  const std::vector<std::string> names = machine_names();
  const bool named =
      !std::filesystem::exists(path, failed) && std::find(names.begin(), names.end(), path) != names.end();
  read(named ? machine_file(path) : path, path, named);
}

void ConfigLayers::design(const std::string& origin, const std::vector<std::pair<std::string, std::string>>& keys) {
  rivals_.begin(false);
  for (const auto& [key, value] : keys) apply(fmt::format("{}={}", key, value), {origin, 0, ""});
}

void ConfigLayers::settings(const std::vector<std::string>& all) {
  rivals_.begin(false);
  for (const std::string& setting : all) apply(setting, {"--set", 0, ""});
}

void ConfigLayers::name(const modules::Parameter& key, const KeyPlace& place) {
  places_[key.name] = place;
  rivals_.name(key, place);
}

void ConfigLayers::apply(const std::string& setting, const KeyPlace& place) {
  apply_setting(setting, keys_);
  name(*find_key(keys_, setting.substr(0, setting.find('='))), place);
}

void ConfigLayers::read(const std::filesystem::path& path, const std::string& included_from, bool begun_from) {
  const std::filesystem::path canonical = std::filesystem::weakly_canonical(path);
  if (std::find(open_.begin(), open_.end(), canonical) != open_.end()) {
    throw Error(included_from, "include", fmt::format("'{}' includes itself", path.string()));
  }
  open_.push_back(canonical);
  const Text& text = text_of(path);
  read_includes(text);
  rivals_.begin(begun_from);
  read_keys(text);
  open_.pop_back();
}

const ConfigLayers::Text& ConfigLayers::text_of(const std::filesystem::path& path) {
  std::shared_ptr<const Text>& known = texts_[path.string()];
  if (known) return *known;
  Text text{path, path.string(), read_file(path.string()), {}};
  files_.push_back(text.name);
  try {
    text.table = toml::parse(text.text, text.name);
  } catch (const toml::parse_error& error) {
    throw Error(text.name, fmt::format("line {}", error.source().begin.line), std::string(error.description()));
  }
  known = std::make_shared<const Text>(std::move(text));
  return *known;
}

void ConfigLayers::read_includes(const Text& text) {
  const toml::node* node = text.table.get("include");
  if (node == nullptr) return;
  const auto read_one = [&](const toml::node& item) {
    const auto* given = item.as_string();
    if (given == nullptr) {
      throw Error(text.name, line_of(item), "include: must be a path or a list of paths; a machine's name is one, too");
    }
    const std::string& named = given->get();
    const std::filesystem::path target = text.path.parent_path() / named;
    if (std::filesystem::exists(target)) return read(target, text.name, true);
    const std::vector<std::string> names = machine_names();
    if (std::find(names.begin(), names.end(), named) != names.end()) return read(machine_file(named), text.name, true);
    const bool is_path = named.ends_with(".toml") || names.empty();
    throw Error(
        text.name, line_of(item),
        fmt::format("include: no file '{}'{}", target.string(),
                    is_path ? "" : ", and no machine of this name: the nearest is " + nearest_name(named, names)));
  };
  if (const auto* list = node->as_array()) {
    for (const toml::node& item : *list) read_one(item);
  } else {
    read_one(*node);
  }
}

void ConfigLayers::read_keys(const Text& text) {
  const auto read_table = [&](const auto& self, const toml::table& table, const std::string& prefix) -> void {
    for (const auto& [name, node] : table) {
      if (prefix.empty() && name.str() == "include") continue;
      const std::string full = prefix + std::string(name.str());
      const modules::Parameter* key = find_key(keys_, full);
      if (const auto* inner = node.as_table(); inner != nullptr && key == nullptr) {
        self(self, *inner, full + ".");
        continue;
      }
      const KeyPlace place{text.name, name.source().begin.line, comment_behind(node.source().end, text.text)};
      const bool of_tracer = key == nullptr && full.starts_with(kTracer);
      std::string broken;
      if (of_tracer) {
        const std::string option = full.substr(std::string_view(kTracer).size());
        tracer_[option] = {tracer_text(full, node, broken), place};
      } else if (key == nullptr) {
        throw Error(text.name, place_of(place, full), unknown_key(keys_, full));
      } else {
        broken = assign(*key, node);
      }
      if (!broken.empty()) throw Error(text.name, place_of(place, full), full + ": " + broken);
      if (of_tracer) {
        places_[full] = place;
      } else {
        this->name(*key, place);
      }
    }
  };
  read_table(read_table, text.table, "");
}

void load_config_file(const std::string& path, const std::vector<modules::Parameter>& keys, KeyPlaces* places) {
  ConfigLayers layers(keys);
  layers.file(path);
  layers.require_agreement();
  if (places == nullptr) return;
  for (const auto& [key, place] : layers.places()) (*places)[key] = place;
}

std::string contradiction(bool names_mhz, bool names_bandwidth) {
  if (!names_mhz || !names_bandwidth) return "";
  return "dram.bandwidth_gb_s and dram.mhz both set the memory clock: name one of them";
}

void apply_setting(const std::string& setting, const std::vector<modules::Parameter>& keys) {
  const std::size_t equals = setting.find('=');
  if (equals == std::string::npos) throw Error("--set", setting, "must have the form key=value");
  const std::string name = setting.substr(0, equals);
  const modules::Parameter* key = find_key(keys, name);
  if (key == nullptr) throw Error("--set", name, unknown_key(keys, name));
  const std::string broken = assign_text(*key, setting.substr(equals + 1));
  if (!broken.empty()) throw Error("--set", name, broken);
}

}  // namespace grtx::sim
