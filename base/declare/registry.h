// SPDX-License-Identifier: Apache-2.0
// Registry of things that a configuration selects by name: first the project's own, then those registered by a program.
// Entries are never removed.
#pragma once

#include <algorithm>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "grtx/base/declare/named_enum.h"
#include "grtx/base/error.h"

namespace grtx::declare {

template <typename Thing>
class Registry {
 public:
  struct Entry {
    std::string name;
    Thing thing;
  };
  /// what: kind of the things; key: configuration key; both for messages. own: the project's entries.
  Registry(std::string what, std::string key, std::vector<Entry> own)
      : what_(std::move(what)), key_(std::move(key)), entries_(std::move(own)) {}

  /// Throws std::logic_error if the name is taken.
  void add(const std::string& name, Thing thing) {
    if (find(name) != entries_.end()) throw std::logic_error("the " + what_ + " " + name + " exists already");
    entries_.push_back({name, std::move(thing)});
  }
  const std::vector<Entry>& entries() const { return entries_; }
  std::vector<std::string> names() const {
    std::vector<std::string> names;
    for (const Entry& entry : entries_) names.push_back(entry.name);
    return names;
  }
  /// Throws Error for an unknown name and lists the known ones.
  const Thing& at(std::string_view name) const {
    const auto found = find(name);
    if (found == entries_.end()) throw Error("configuration", key_, unknown_name(name, names()));
    return found->thing;
  }
  /// Makes a thing by the factory of that name, where things are factories. Throws Error for an unknown name and if the
  /// factory makes nothing.
  template <typename... Arguments>
  auto make(std::string_view name, Arguments&&... arguments) const {
    const Thing& factory = at(name);
    decltype(factory(std::forward<Arguments>(arguments)...)) made;
    if (factory) made = factory(std::forward<Arguments>(arguments)...);
    if (made == nullptr) {
      throw Error("configuration", key_, "the factory of the " + what_ + " " + std::string(name) + " made nothing");
    }
    return made;
  }

 private:
  auto find(std::string_view name) const {
    return std::find_if(entries_.begin(), entries_.end(), [&](const Entry& entry) { return entry.name == name; });
  }

  std::string what_, key_;
  std::vector<Entry> entries_;
};

}  // namespace grtx::declare
