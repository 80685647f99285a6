// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/run/saved_state.h"

#include <fmt/format.h>

#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/base/hash.h"
#include "grtx/base/state_bytes.h"
#include "grtx/rtl_tlm/gpu/gpu.h"
#include "grtx/rtl_tlm/run/model_version.h"

namespace grtx::sim {
namespace {

/// The file begins with this and ends with a hash of everything before the hash.
constexpr std::string_view kMagic = "grtx.state/";
constexpr std::uint32_t kVersion = 2;
constexpr std::size_t kHashBytes = 8;

void require(bool holds, const std::string& path, const std::string& place, const std::string& rule) {
  if (!holds) throw Error(path, place, rule);
}

}  // namespace

void write_state(const std::string& path, const SavedState& state) {
  StateWriter out;
  out.put(kVersion);
  out.put(std::uint32_t{kModelVersion});
  for (const std::string* text :
       {&state.mode, &state.config_hash, &state.hardware, &state.scene, &state.ran, &state.camera})
    out.text(*text);
  out.put(state.memory_bytes);
  out.text(state.units);
  const std::string bytes = std::string(kMagic) + out.bytes();
  StateWriter hash;
  hash.put(xxh3(bytes));
  write_file(path, bytes + hash.bytes());
}

SavedState read_state(const std::string& path) {
  const std::string bytes = read_file(path);
  require(bytes.starts_with(kMagic), path, "", "is no saved state");
  require(bytes.size() >= kMagic.size() + kHashBytes, path, "", "ends too early");
  const std::size_t end = bytes.size() - kHashBytes;
  StateReader hash(path, bytes.substr(end));
  require(hash.get<std::uint64_t>() == xxh3(bytes.data(), end), path, "", "is damaged: its checksum is wrong");
  StateReader in(path, bytes.substr(kMagic.size(), end - kMagic.size()));
  const auto version = in.get<std::uint32_t>();
  require(version == kVersion, path, "version", fmt::format("is {}, this program reads {}", version, kVersion));
  const auto model = in.get<std::uint32_t>();
  require(model == kModelVersion, path, "model", fmt::format("is version {}, this is {}", model, kModelVersion));
  SavedState state;
  for (std::string* text : {&state.mode, &state.config_hash, &state.hardware, &state.scene, &state.ran, &state.camera})
    *text = in.text();
  state.memory_bytes = in.get<std::uint64_t>();
  state.units = in.text();
  in.require_end();
  return state;
}

void require_fits(const SavedState& state, const std::string& path, const GpuConfig& config,
                  const traces::Reader& trace, const std::string& mode) {
  require(state.mode == mode, path, "mode", fmt::format("is {}, this run's is {}", state.mode, mode));
  const std::string hash = config_hash(config);
  require(state.config_hash == hash, path, "machine",
          fmt::format("is another: its configuration has the hash {}, this one {}", state.config_hash, hash));
  const std::string hardware = hardware_of(trace.header());
  require(state.hardware == hardware, path, "hardware",
          fmt::format("is for {}; {} is for {}", state.hardware, trace.path(), hardware));
  const std::string scene = addressed_scene(trace.header());
  require(state.scene == scene, path, "scene",
          fmt::format("is another: {}; {} is of {}", state.scene, trace.path(), scene));
}

}  // namespace grtx::sim
