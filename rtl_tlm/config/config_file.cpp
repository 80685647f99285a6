// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/config/config_file.h"

#include <fmt/format.h>

#include <toml++/toml.h>
#include <algorithm>
#include <filesystem>

#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/base/nearest_name.h"
#include "grtx/base/removed_names.h"

namespace grtx::sim {
namespace {

const modules::Parameter* find_key(const std::vector<modules::Parameter>& keys, const std::string& name) {
  const auto found =
      std::find_if(keys.begin(), keys.end(), [&](const modules::Parameter& key) { return key.name == name; });
  return found == keys.end() ? nullptr : &*found;
}

std::string unknown_key(const std::vector<modules::Parameter>& keys, const std::string& name) {
  if (name == "machine") return "machine: is no key: --machine names it, or the file's include = \"FILE.toml\"";
  if (const std::string said = said_of_removed(name); !said.empty()) {
    return fmt::format("unknown key '{}', {}", name, said);
  }
  std::vector<std::string> known;
  for (const modules::Parameter& key : keys) known.push_back(key.name);
  return fmt::format("unknown key '{}', the nearest is '{}'", name, nearest_name(name, known));
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

class FileReader {
 public:
  FileReader(const std::vector<modules::Parameter>& keys, KeyPlaces* places) : keys_(keys), places_(places) {}

  void read(const std::filesystem::path& path, const std::string& included_from) {
    const std::string name = path.string();
    const std::filesystem::path canonical = std::filesystem::weakly_canonical(path);
    if (std::find(open_.begin(), open_.end(), canonical) != open_.end()) {
      throw Error(included_from, "include", fmt::format("'{}' includes itself", name));
    }
    open_.push_back(canonical);
    const std::string text = read_file(name);
    toml::table table;
    try {
      table = toml::parse(text, name);
    } catch (const toml::parse_error& error) {
      throw Error(name, fmt::format("line {}", error.source().begin.line), std::string(error.description()));
    }
    include(table, path);
    const toml::node* const bandwidth = table["dram"]["bandwidth_gb_s"].node();
    const std::string both = contradiction(table["dram"]["mhz"].node() != nullptr, bandwidth != nullptr);
    if (!both.empty()) throw Error(name, line_of(*bandwidth), both);
    read_table(table, name, text, "");
    open_.pop_back();
  }

 private:
  void include(const toml::table& table, const std::filesystem::path& path) {
    const toml::node* node = table.get("include");
    if (node == nullptr) return;
    const auto read_one = [&](const toml::node& item) {
      const auto* text = item.as_string();
      if (text == nullptr) throw Error(path.string(), line_of(item), "include: must be a path or a list of paths");
      const std::filesystem::path target = path.parent_path() / text->get();
      if (!std::filesystem::exists(target)) {
        throw Error(path.string(), line_of(item), fmt::format("include: no file '{}'", target.string()));
      }
      read(target, path.string());
    };
    if (const auto* list = node->as_array()) {
      for (const toml::node& item : *list) read_one(item);
    } else {
      read_one(*node);
    }
  }

  void read_table(const toml::table& table, const std::string& file, const std::string& text,
                  const std::string& prefix) {
    for (const auto& [name, node] : table) {
      if (prefix.empty() && name.str() == "include") continue;
      const std::string full = prefix + std::string(name.str());
      if (const auto* inner = node.as_table(); inner != nullptr && find_key(keys_, full) == nullptr) {
        read_table(*inner, file, text, full + ".");
        continue;
      }
      const auto line = fmt::format("line {}", name.source().begin.line);
      const modules::Parameter* key = find_key(keys_, full);
      if (key == nullptr) throw Error(file, line, unknown_key(keys_, full));
      const std::string broken = assign(*key, node);
      if (!broken.empty()) throw Error(file, line, full + ": " + broken);
      if (places_ != nullptr) {
        (*places_)[full] = {file, name.source().begin.line, comment_behind(node.source().end, text)};
      }
    }
  }

  static std::string assign(const modules::Parameter& key, const toml::node& node) {
    if (const auto* integer = node.as_integer()) return assign_integer(key, integer->get());
    if (const auto* real = node.as_floating_point()) return assign_real(key, real->get());
    if (const auto* boolean = node.as_boolean()) return assign_bool(key, boolean->get());
    if (const auto* text = node.as_string()) return assign_string(key, text->get());
    return fmt::format("must be a single value ({}), not a list, table or date", range_text(key));
  }

  const std::vector<modules::Parameter>& keys_;
  KeyPlaces* places_;
  std::vector<std::filesystem::path> open_;  ///< files being read, to detect circular includes
};

}  // namespace

std::string contradiction(bool names_mhz, bool names_bandwidth) {
  if (!names_mhz || !names_bandwidth) return "";
  return "dram.bandwidth_gb_s and dram.mhz both set the memory clock: name one of them";
}

void load_config_file(const std::string& path, const std::vector<modules::Parameter>& keys, KeyPlaces* places) {
  FileReader(keys, places).read(path, path);
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
