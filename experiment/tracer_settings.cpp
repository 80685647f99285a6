// SPDX-License-Identifier: Apache-2.0
#include "grtx/experiment/tracer_settings.h"

#include <fmt/format.h>

#include <type_traits>

#include "grtx/base/error.h"
#include "grtx/experiment/option_text.h"
#include "grtx/experiment/tracer_option_table.h"
#include "grtx/frontend/accel/acceleration_structure.h"
#include "grtx/traces/node_layout.h"

namespace grtx::experiment {

using namespace frontend;

namespace {

unsigned bvh_width(const TracerSettings& settings) {
  return settings.bvh_width.value_or(traces::default_width(settings.layout));
}

}  // namespace

const std::vector<TracerOptionName>& tracer_option_names() {
  static const std::vector<TracerOptionName> all = [] {
    std::vector<TracerOptionName> names;
    const TracerSettings settings;
    visit_options(settings, [&](const char* name, const auto&, const char* description, const auto&...) {
      names.push_back({key_of(name), description});
    });
    return names;
  }();
  return all;
}

void set_option(TracerSettings& settings, const std::string& key, const std::string& text) {
  bool known = false;
  visit_options(settings, [&](const char* name, auto& value, const char*, const auto&... rule) {
    if (key_of(name) != key) return;
    known = true;
    const std::string why = take(flag_of(key), text, value, rule...);
    if (!why.empty()) throw Error("tracer", key, why);
  });
  if (!known) {
    std::vector<std::string> names;
    for (const TracerOptionName& option : tracer_option_names()) names.emplace_back(option.key);
    throw Error("tracer", key, unknown_name(key, names));
  }
}

TracerSettings traced_settings(const std::string& trace, const std::map<std::string, std::string>& inputs) {
  TracerSettings settings;
  for (const TracerOptionName& option : tracer_option_names()) {
    const auto input = inputs.find(option.key);  // inputs named like an option hold its value
    if (input == inputs.end()) continue;
    try {
      set_option(settings, option.key, input->second);
    } catch (const Error& error) {
      throw Error(trace, "inputs of the header", error.rule());
    }
  }
  return settings;
}

Kernel kernel_of(KernelRadius radius, unsigned degree) { return {radius == KernelRadius::adaptive, degree}; }

namespace {

/// Several nodes of a ray under way: the rays and modes that a warp walks together.
void check_ahead(const TracerOptions& o, AccelKind accel) {
  const std::string value = std::to_string(o.ahead);
  if (o.tracing != Tracing::multi) throw Error("--ahead", value, "is for rounds of k hits: it needs --tracing multi");
  if (o.checkpoint) throw Error("--ahead", value, "has no replay: it needs checkpointing off");
  if (o.any_hit == AnyHit::delayed) throw Error("--ahead", value, "needs --any-hit immediate: else t_max stays");
  if (traces::is_two_level(accel)) {
    throw Error("--ahead", value, "needs a structure of one level, not --accel " + accel_name(accel));
  }
}

/// The bound needs the order in which hits are blended, a shader that moves t_max, and a threshold at each hit.
void check_opacity_bound(const TracerOptions& o) {
  const auto refuse = [](const char* why) { throw Error("--opacity-bound", "on", why); };
  if (traces::collects_unsorted(o.tracing)) refuse("needs hits in order: --tracing multi, not single or list");
  if (o.tracing == Tracing::closest) refuse("has no k-buffer to look at in --tracing closest: it needs multi");
  if (o.any_hit == AnyHit::delayed) refuse("needs --any-hit immediate: else t_max stays");
  if (o.ert_check == ErtCheck::round) {
    refuse("needs --ert-check hit: with round the hits of a round are blended behind the threshold, too");
  }
  if (o.ert < frontend::kLeastBoundedErt) refuse("needs an --ert of 1e-30 or more, below which rays end");
  if (o.resume == frontend::Resume::strict)
    refuse("needs --resume exact: strict loses ties that the bound has counted");
  if (o.triangle_test == TriangleTest::world) {
    refuse("needs --triangle-test canonical: a stored triangle may be hit before its box");
  }
}

/// One colour for all rays of a frame needs one direction from which they look at a Gaussian.
void check_colour(const TracerSettings& settings) {
  if (settings.options.sh_direction != frontend::ShDirection::centre) {
    throw Error("--colour", "frame", "needs --sh-dir centre: in the ray's direction each ray sees another colour");
  }
  if (settings.secondary.what != "none") {
    throw Error("--colour", "frame",
                "needs --secondary none: rays that do not start at the camera see another side of a Gaussian");
  }
}

}  // namespace

TracerOptions tracer_options(const TracerSettings& settings, bool checkpoint, AccelKind accel) {
  TracerOptions o = settings.options;
  o.checkpoint = checkpoint;
  o.kernel = kernel_of(settings.kernel_radius, settings.kernel_degree);
  o.tracing = *from_name<Tracing>(settings.tracing);
  if (o.tracing == Tracing::closest) o.k = 1;
  if (o.tracing == Tracing::list) o.k = o.list_capacity;
  if (checkpoint && o.tracing != Tracing::multi) {
    throw Error("--tracing", settings.tracing, "has no rounds to resume: checkpointing needs --tracing multi");
  }
  if (o.any_hit == AnyHit::delayed && o.tracing != Tracing::multi) {
    throw Error("--any-hit", "delayed", "keeps a round's hits for its sorted k-buffer: it needs --tracing multi");
  }
  if (o.any_hit == AnyHit::delayed && checkpoint) {
    throw Error("--any-hit", "delayed", "leaves nothing beyond t_max to resume from: it needs checkpointing off");
  }
  if (o.ahead > 1) check_ahead(o, accel);
  if (o.opacity_bound == frontend::OpacityBound::on) check_opacity_bound(o);
  if (o.colour == frontend::ColourPer::frame) check_colour(settings);
  if (o.ert_check == ErtCheck::round && o.tracing == Tracing::list) {
    throw Error("--ert-check", "round", "is not for --tracing list, which tests each batch of a round as it blends it");
  }
  if (o.checkpoint_bins == 1) throw Error("--checkpoint-bins", "1", "is one list: 0 takes two buffers, 2 or more bins");
  if (o.checkpoint_bins != 0 && o.checkpoint_order != CheckpointOrder::fifo) {
    throw Error("--checkpoint-order", std::string(name_of(o.checkpoint_order)),
                "is an order of two buffers: --checkpoint-bins has one of its own");
  }
  if (o.triangle_test == TriangleTest::world && proxy_of(accel) == ProxyKind::sphere) {
    throw Error("--triangle-test", "world", "needs a structure of triangles, not --accel " + accel_name(accel));
  }
  if (o.triangle_test == TriangleTest::world && o.sort_key == SortKey::peak) {
    throw Error("--triangle-test", "world", "measures where a triangle is entered: it needs --sort-key entry");
  }
  if (o.inside == InsideRule::count && proxy_of(accel) != ProxyKind::sphere) {
    throw Error("--inside", "count", "needs a sphere proxy: --accel ellipsoid or tlas-sphere");
  }
  return o;
}

AccelOptions accel_options(const TracerSettings& settings, AccelKind accel) {
  if (frontend::is_quantised(settings.layout) && bvh_width(settings) > traces::kQuantisedWidth) {
    throw Error("--bvh-width", std::to_string(bvh_width(settings)), "must be at most 6 with --layout quantised");
  }
  return {accel, bvh_width(settings), settings.instance_bounds == InstanceBounds::box_corners, settings.box_bits,
          settings.layout};
}

RenderOptions render_options(const TracerSettings& settings, bool quiet) {
  RenderOptions r{.threads = settings.threads,
                  .linear_mapping = settings.mapping == traces::WarpMapping::linear,
                  .warp_size = settings.warp_size,
                  .quiet = quiet};
  return r;
}

std::map<std::string, std::string> option_texts(const TracerSettings& settings) {
  std::map<std::string, std::string> texts;
  visit_traced_options(settings, [&]<typename Value>(const char* name, const Value& value, const char*, auto...) {
    std::string& text = texts[key_of(name)];
    if constexpr (NamedEnum<Value>) {
      text = name_of(value);
    } else if constexpr (std::is_same_v<Value, std::optional<unsigned>>) {
      text = std::to_string(bvh_width(settings));
    } else {
      text = fmt::format("{}", value);
    }
  });
  return texts;
}

std::map<std::string, std::string> option_inputs(const TracerSettings& settings, bool checkpoint, AccelKind accel) {
  std::map<std::string, std::string> inputs = option_texts(settings);
  const std::map<std::string, std::string> defaults = option_texts({});
  for (const char* later : {"pop_test", "any_hit", "ert_check", "ahead", "opacity_bound", "colour", "kernel_degree",
                            "layout", "checkpoint_bins", "below_instance"}) {
    if (inputs.at(later) == defaults.at(later)) inputs.erase(later);
  }
  if (!checkpoint) {
    inputs.erase("checkpoint_bins");
    inputs.erase("below_instance");
  }
  if (settings.tracing == name_of(Tracing::closest)) inputs["k"] = "1";
  if (settings.tracing == name_of(Tracing::list)) {
    inputs["k"] = inputs.at("list_capacity");
  } else {
    inputs.erase("list_capacity");
  }
  inputs["accel"] = accel_name(accel);
  inputs["checkpoint"] = checkpoint ? "on" : "off";
  inputs.merge(secondary_inputs(settings.secondary));
  return inputs;
}

}  // namespace grtx::experiment
