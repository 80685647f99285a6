// SPDX-License-Identifier: Apache-2.0
#include "grtx/base/removed_names.h"

#include <fmt/format.h>

namespace grtx {
namespace {

struct Removed {
  std::string_view name;  ///< with a . at its end: all keys that begin so
  std::string_view in_place;
};

// CHANGELOG.md lists them by version.
constexpr Removed kRemoved[] = {
    // 1.0.0
    {"fast", "cycle"},
    {"model", "cycle"},
    {"sampled", "cycle"},
    {"fast.", "--mode cycle"},
    {"sample.", "--mode cycle; of whole frames, --mode windows"},
    {"--sample-engine", "--mode windows"},
    {"--sample-model", "--mode windows"},
    {"--threads", "a sweep with --jobs"},
    {"--jobs", "a sweep with --jobs"},
    {"simt.private_store.", "rt.any_hit_unit.enabled"},
    {"rt.private_store.", "rt.any_hit_unit.enabled"},
    {"rt.sphere.quadric", "rt.gaussian.enabled"},
    {"rt.checkpoint.forward", "--checkpoint-bins"},
    {"rt.checkpoint.read_ahead", "--checkpoint-bins"},
    {"rt.checkpoint.prefetch_nodes", "--checkpoint-bins"},
    {"rt.stack_prefetch.", "nothing"},
    {"rt.cooperation.ahead", "nothing"},
    {"l1.held_misses", "nothing"},
    {"--skip", "nothing: what it left out is always left out"},
    {"modern", "ada"},  // others: machine.cpp of study, by the names of chips
    {"dense_indoor", "hall"},
    {"--spheres", "--leaves spheres"},
};

}  // namespace

std::string in_place_of(std::string_view name) {
  for (const Removed& removed : kRemoved) {
    if (removed.name.ends_with('.') ? name.starts_with(removed.name) : name == removed.name) {
      return std::string(removed.in_place);
    }
  }
  return "";
}

std::string said_of_removed(std::string_view name) {
  const std::string in_place = in_place_of(name);
  return in_place.empty() ? "" : fmt::format("which was removed; in its place: {}", in_place);
}

}  // namespace grtx
