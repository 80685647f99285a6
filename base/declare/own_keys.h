// SPDX-License-Identifier: Apache-2.0
// Configuration keys that a unit registers itself, once, before configurations are read: by a program for its own unit,
// or by the source file of an optional unit. The keys then exist for every machine, and their values are part of the
// machine's configuration.
#pragma once

#include <map>
#include <memory>
#include <stdexcept>
#include <string>

#include "grtx/base/declare/parameter.h"

namespace grtx::declare {

/// Values of all registered keys. A value type: each copy has its own configurations.
class OwnKeys {
 public:
  /// All registered configurations with their default values.
  OwnKeys() {
    for (const auto& [prefix, held] : registered()) held_.emplace(prefix, held->copy());
  }
  OwnKeys(const OwnKeys& other) {
    for (const auto& [prefix, held] : other.held_) held_.emplace(prefix, held->copy());
  }
  OwnKeys(OwnKeys&&) = default;
  OwnKeys& operator=(const OwnKeys& other) {
    OwnKeys copy(other);
    held_.swap(copy.held_);
    return *this;
  }
  OwnKeys& operator=(OwnKeys&&) = default;
  ~OwnKeys() = default;

  /// Registers a configuration. Config: a value type with parameters(ParameterList&). prefix: of its keys, e.g.
  /// rt.my_box. Throws std::logic_error if the prefix is taken. Returns true, so that a constant's initialiser can
  /// register.
  template <typename Config>
  static bool add(const std::string& prefix, const Config& defaults = {}) {
    if (!registered().emplace(prefix, std::make_unique<Of<Config>>(defaults)).second) {
      throw std::logic_error("keys below " + prefix + " are registered already");
    }
    return true;
  }
  /// The configuration of this type. Throws std::logic_error if none is registered.
  template <typename Config>
  const Config& get() const {
    for (const auto& [prefix, held] : held_) {
      if (const auto* of = dynamic_cast<const Of<Config>*>(held.get())) return of->config;
    }
    throw std::logic_error("no keys of this configuration are registered");
  }
  void parameters(ParameterList& list) {
    for (const auto& [prefix, held] : held_) {
      list.under(prefix, [&unit = *held](ParameterList& keys) { unit.parameters(keys); });
    }
  }

 private:
  struct Held {
    virtual ~Held() = default;
    virtual std::unique_ptr<Held> copy() const = 0;
    virtual void parameters(ParameterList& list) = 0;
  };
  template <typename Config>
  struct Of final : Held {
    explicit Of(const Config& from) : config(from) {}
    std::unique_ptr<Held> copy() const override { return std::make_unique<Of>(config); }
    void parameters(ParameterList& list) override { config.parameters(list); }
    Config config;
  };
  /// Ordered by prefix, independent of the order of registration.
  using All = std::map<std::string, std::unique_ptr<Held>>;
  static All& registered() {
    static All all;
    return all;
  }

  All held_;
};

}  // namespace grtx::declare
