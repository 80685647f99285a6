// Keys of units that are not the project's. A program registers the configuration of its unit once, before
// configurations are read: its keys are then keys of every machine, and its values travel with the machine's.
#pragma once

#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "grtx/base/declare/parameter.h"

namespace grtx::declare {

/// A value: copies hold configurations of their own.
class OwnKeys {
 public:
  /// Those that are registered, at their defaults.
  OwnKeys() {
    for (const auto& [prefix, held] : registered()) held_.emplace_back(prefix, held->copy());
  }
  OwnKeys(const OwnKeys& other) {
    for (const auto& [prefix, held] : other.held_) held_.emplace_back(prefix, held->copy());
  }
  OwnKeys(OwnKeys&&) = default;
  OwnKeys& operator=(const OwnKeys& other) {
    OwnKeys copy(other);
    held_.swap(copy.held_);
    return *this;
  }
  OwnKeys& operator=(OwnKeys&&) = default;
  ~OwnKeys() = default;

  /// Config: a value with parameters(ParameterList&). prefix: of its keys, e.g. rt.my_box. Throws std::logic_error when
  /// there are such keys already.
  template <typename Config>
  static void add(const std::string& prefix, const Config& defaults = {}) {
    for (const auto& [taken, held] : registered()) {
      if (taken == prefix) throw std::logic_error("keys below " + prefix + " are registered already");
    }
    registered().emplace_back(prefix, std::make_unique<Of<Config>>(defaults));
  }
  /// Throws std::logic_error when nothing of this type is registered.
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
  using All = std::vector<std::pair<std::string, std::unique_ptr<Held>>>;
  static All& registered() {
    static All all;
    return all;
  }

  All held_;
};

}  // namespace grtx::declare
