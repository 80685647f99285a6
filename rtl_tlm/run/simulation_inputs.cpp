// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/run/simulation_inputs.h"

#include "grtx/rtl_tlm/gpu/memory_files.h"
#include "grtx/rtl_tlm/gpu/simulation_mode.h"

namespace grtx::sim {

std::string camera_of(const traces::Reader& trace) {
  const auto camera = trace.header().inputs.find("camera_hash");
  return camera == trace.header().inputs.end() ? "" : camera->second;
}

void add_run_before(std::map<std::string, std::string>& inputs, const std::string& ran, const std::string& camera) {
  if (!ran.empty()) inputs["warm"] = ran;
  if (!camera.empty()) inputs["warm.camera_hash"] = camera;
}

std::map<std::string, std::string> simulation_inputs(const traces::Reader& trace, const GpuConfig& config) {
  const traces::Header& header = trace.header();
  std::map<std::string, std::string> inputs;
  for (const auto& [name, value] : header.inputs) inputs["trace." + name] = value;
  inputs["accel"] = name_of(header.accel);
  inputs["k"] = std::to_string(header.k);
  inputs["width"] = std::to_string(header.width);
  inputs["height"] = std::to_string(header.height);
  inputs["checkpoint"] = header.checkpoint ? "on" : "off";
  if (header.three_level()) inputs["levels"] = "3";
  if (header.pop_test != traces::Header{}.pop_test) inputs["pop_test"] = name_of(header.pop_test);
  if (header.layout != traces::Header{}.layout) inputs["layout"] = name_of(header.layout);
  if (header.bvh_width != traces::default_width(header.layout)) inputs["bvh_width"] = std::to_string(header.bvh_width);
  if (header.checkpoint_bins != 0) {
    inputs["checkpoint_bins"] = std::to_string(header.checkpoint_bins);
    inputs["checkpoint_capacity"] = std::to_string(header.checkpoint_capacity);
  }
  inputs["trace_hash"] = trace.content_hash();
  inputs["config_hash"] = config_hash(config);
  inputs["mode"] = name_of(SimulationMode::cycle);
  const FilesRead memory = memory_files(config);
  for (const auto& [name, value] : memory.files().empty() ? std::map<std::string, std::string>() : memory.inputs()) {
    inputs["memory." + name] = value;
  }
  inputs["program"] = std::string("grtx ") + GRTX_VERSION;
  return inputs;
}

}  // namespace grtx::sim
