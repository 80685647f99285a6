// SPDX-License-Identifier: Apache-2.0
// A small reader of value change dumps, for tests: scopes, variables and all changes.
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace grtx::sim {

struct VcdFile {
  struct Change {
    std::uint64_t time = 0;
    std::uint64_t value = 0;
    friend bool operator==(const Change&, const Change&) = default;
  };
  std::string comment;
  std::string timescale;
  std::map<std::string, unsigned> width;               ///< by full name
  std::map<std::string, std::vector<Change>> changes;  ///< by full name, the initial value first
  std::uint64_t begin = 0;                             ///< first time
  std::uint64_t end = 0;                               ///< last time

  /// Value at `time`: that of the last change not after it.
  std::uint64_t at(const std::string& name, std::uint64_t time) const {
    std::uint64_t value = 0;
    for (const Change& change : changes.at(name)) {
      if (change.time > time) break;
      value = change.value;
    }
    return value;
  }
  /// Calls f(value, duration) for each stretch of time between `from` and `to` in which the signal does not change.
  template <typename F>
  void for_each_stretch(const std::string& name, std::uint64_t from, std::uint64_t to, F&& f) const {
    const std::vector<Change>& all = changes.at(name);
    for (std::size_t i = 0; i < all.size(); ++i) {
      const std::uint64_t start = std::max(from, all[i].time);
      const std::uint64_t stop = std::min(to, i + 1 < all.size() ? all[i + 1].time : to);
      if (start < stop) f(all[i].value, stop - start);
    }
  }
};

/// Throws std::runtime_error on anything that a value change dump may not contain.
inline VcdFile read_vcd(const std::string& text) {
  VcdFile file;
  std::map<std::string, std::string> name_of;  // by identifier
  std::vector<std::string> scopes;
  std::istringstream in(text);
  std::string word;
  const auto until_end = [&] {
    std::string content, part;
    while (in >> part && part != "$end") content += (content.empty() ? "" : " ") + part;
    if (part != "$end") throw std::runtime_error("missing $end");
    return content;
  };
  bool header = true;
  std::uint64_t time = 0;
  const auto change = [&](const std::string& id, const std::string& bits) {
    if (header) throw std::runtime_error("a change before $enddefinitions");
    if (!name_of.contains(id)) throw std::runtime_error("undeclared identifier " + id);
    const std::string& name = name_of[id];
    if (bits.empty() || bits.size() > file.width[name]) throw std::runtime_error("wrong width of " + name);
    if (bits.find_first_not_of("01") != std::string::npos) throw std::runtime_error("wrong digit in " + name);
    file.changes[name].push_back({time, std::stoull(bits, nullptr, 2)});
  };
  while (in >> word) {
    if (word == "$comment") {
      file.comment += until_end();
    } else if (word == "$timescale") {
      file.timescale = until_end();
    } else if (word == "$version" || word == "$date" || word == "$attrbegin") {
      until_end();
    } else if (word == "$scope") {
      const std::string scope = until_end();
      if (!scope.starts_with("module ")) throw std::runtime_error("wrong scope " + scope);
      scopes.push_back(scope.substr(7));
    } else if (word == "$upscope") {
      until_end();
      if (scopes.empty()) throw std::runtime_error("$upscope without scope");
      scopes.pop_back();
    } else if (word == "$var") {
      std::istringstream var(until_end());
      std::string type, id, name;
      unsigned width = 0;
      if (!(var >> type >> width >> id >> name) || type != "wire") throw std::runtime_error("wrong $var");
      for (std::size_t i = scopes.size(); i-- > 0;) name = scopes[i] + "." + name;
      if (!name_of.emplace(id, name).second) throw std::runtime_error("identifier used twice: " + id);
      if (!file.width.emplace(name, width).second) throw std::runtime_error("name used twice: " + name);
    } else if (word == "$enddefinitions") {
      until_end();
      if (!scopes.empty()) throw std::runtime_error("scope left open");
      header = false;
    } else if (word == "$dumpvars" || word == "$end") {
      continue;
    } else if (word[0] == '#') {
      const std::uint64_t next = std::stoull(word.substr(1));
      if (next < time) throw std::runtime_error("time goes back");
      if (file.changes.empty()) file.begin = next;
      time = file.end = next;
    } else if (word[0] == 'b') {
      std::string id;
      in >> id;
      change(id, word.substr(1));
    } else {
      change(word.substr(1), word.substr(0, 1));
    }
  }
  return file;
}

}  // namespace grtx::sim
