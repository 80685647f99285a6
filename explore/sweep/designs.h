// SPDX-License-Identifier: Apache-2.0
// The named designs, which are compared. Each has a structure, tracer options, and configuration keys of its own; the
// machine is the configuration that all compared designs share.
#pragma once

#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "grtx/rtl_tlm/gpu/gpu_config.h"

namespace grtx::explore {

struct Design {
  using Texts = std::vector<std::pair<std::string, std::string>>;
  std::string name;
  std::string says;   ///< what it is, in a clause
  std::string accel;  ///< a name of AccelKind
  bool checkpoint = false;
  Texts tracer;                    ///< options of the tracer, by name with _ for -; k is the one recommended
  Texts keys;                      ///< configuration keys, but for registers of heaps
  unsigned registers_per_hit = 0;  ///< registers of a thread for each of the k hits of a heap; 0: no heaps in registers
};

/// Name of the design among the parameters that plans vary.
inline constexpr const char* kDesign = "design";

/// All designs, in the order of tables: baseline, sw, hw and grtx (GRTX, HPCA 2026), gautracer (ISCA 2026), and walk,
/// this project's own.
const std::vector<Design>& designs();
/// Their names, in the same order.
const std::vector<std::string>& design_names();
/// Throws Error for an unknown name.
const Design& design_of(std::string_view name);
/// Tracer options for a design, by name with _ for -: the machine's, overridden by the design's, overridden by those
/// that the user sets.
std::map<std::string, std::string> tracer_of(const Design& design, std::map<std::string, std::string> machine,
                                             const std::map<std::string, std::string>& named);
/// The k in this text; if it holds none, the k that is recommended for the design.
unsigned k_of(const Design& design, const std::string& text = "");
/// The design's configuration keys for rounds of k hits: registers follow k, up to the 255 that the key may have.
Design::Texts keys_for(const Design& design, unsigned k);
/// The configuration with the design's keys for this k, except those in `named`.
sim::GpuConfig with_keys_of(const Design& design, unsigned k, sim::GpuConfig config,
                            const std::set<std::string>& named);
/// The keys of settings, each "key=value".
std::set<std::string> keys_of(const std::vector<std::string>& settings);

}  // namespace grtx::explore
