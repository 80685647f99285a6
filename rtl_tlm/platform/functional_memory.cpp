// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/platform/functional_memory.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "grtx/base/error.h"

namespace grtx::sim {
namespace {

constexpr std::size_t kPixelFloats = modules::MemoryMap::kPixelBytes / sizeof(float);

/// Writes to the GPU's memory, each block through the socket of its slice. address: on the bus.
bool write(Gpu& gpu, std::uint64_t address, std::string_view bytes) {
  const modules::AddressInterleave& interleave = gpu.config().interleave;
  while (!bytes.empty()) {
    const std::uint64_t local = address - gpu.base();
    const std::size_t count = std::min<std::size_t>(bytes.size(), interleave.bytes - local % interleave.bytes);
    ::tlm::tlm_generic_payload payload;
    payload.set_command(::tlm::TLM_WRITE_COMMAND);
    payload.set_address(address);
    // The target only reads it.
    payload.set_data_ptr(reinterpret_cast<unsigned char*>(const_cast<char*>(bytes.data())));
    payload.set_data_length(static_cast<unsigned>(count));
    payload.set_streaming_width(static_cast<unsigned>(count));
    if (gpu.dram[interleave.slice(local)]->transport_dbg(payload) != count) return false;
    address += count;
    bytes.remove_prefix(count);
  }
  return true;
}

std::string no_room(std::uint64_t address) {
  return fmt::format("the memory takes no data by debug transport at 0x{:x}", address);
}

const modules::MemoryMap::Extent* find(const modules::MemoryMap& map, const std::string& name) {
  const auto found = std::ranges::find(map.extents(), name, &modules::MemoryMap::Extent::name);
  return found == map.extents().end() ? nullptr : &*found;
}

std::string put(Gpu& gpu, const traces::MemoryRegion& region) {
  const std::uint64_t address = gpu.base() + find(gpu.map(), region.name)->base;
  return write(gpu, address, region.bytes) ? "" : no_room(address);
}

void check(const traces::MemoryContents& contents, const traces::Reader& trace, const GpuConfig& config) {
  if (contents.trace() != trace.content_hash()) throw Error(contents.path(), "trace", "is not of " + trace.path());
  const modules::MemoryMap map(trace.header(),
                               memory_map_config(config, trace.header(), trace.totals().max_evictions_per_ray));
  for (const traces::MemoryRegion& region : contents.regions()) {
    const modules::MemoryMap::Extent* const extent = find(map, region.name);
    if (extent == nullptr) throw Error(contents.path(), region.name, "is no region of the memory map");
    if (extent->bytes != region.bytes.size()) {
      throw Error(contents.path(), region.name, fmt::format("must have {} B", extent->bytes));
    }
  }
  if (contents.region(traces::kPixelRegion).empty()) throw Error(contents.path(), traces::kPixelRegion, "is not there");
}

}  // namespace

FunctionalMemory::FunctionalMemory(const std::vector<std::string>& contents,
                                   const std::vector<const traces::Reader*>& traces, const GpuConfig& config) {
  for (std::size_t i = 0; i < contents.size(); ++i) {
    check(contents_.emplace_back(contents[i]), *traces[i], config);
    sizes_.push_back({traces[i]->header().width, traces[i]->header().height});
  }
}

std::string FunctionalMemory::load(Gpu& gpu, std::size_t trace) const {
  for (const traces::MemoryRegion& region : contents_[trace].regions()) {
    if (region.name == traces::kPixelRegion) continue;
    if (std::string fault = put(gpu, region); !fault.empty()) return fault;
  }
  return "";
}

std::string FunctionalMemory::fault(const Picture& picture, std::size_t trace) const {
  if (picture.format == PictureFormat::none) return "";
  const unsigned bytes = pixel_bytes(picture.format);
  if (bytes == 0) return fmt::format("there is no picture format {}", static_cast<std::uint32_t>(picture.format));
  if (picture.pitch != 0 && picture.pitch < bytes * sizes_[trace].width) {
    return fmt::format("a pitch of {} B is less than a row of {} B", picture.pitch, bytes * sizes_[trace].width);
  }
  return "";
}

std::string FunctionalMemory::store(Gpu& gpu, std::size_t trace, const Picture& picture) const {
  const std::string_view pixels = contents_[trace].region(traces::kPixelRegion);
  if (std::string fault = put(gpu, {traces::kPixelRegion, pixels}); !fault.empty()) return fault;
  if (picture.format == PictureFormat::none) return "";
  const auto [width, height] = sizes_[trace];
  const std::uint64_t pitch = picture.pitch != 0 ? picture.pitch : pixel_bytes(picture.format) * width;
  std::vector<float> values(width * kPixelFloats);
  for (std::uint64_t y = 0; y < height; ++y) {
    std::memcpy(values.data(), pixels.data() + y * width * modules::MemoryMap::kPixelBytes,
                values.size() * sizeof(float));
    const std::vector<std::uint8_t> row = picture_row(picture.format, values);
    const std::uint64_t address = picture.address + y * pitch;
    if (!write(gpu, address, {reinterpret_cast<const char*>(row.data()), row.size()})) return no_room(address);
  }
  return "";
}

}  // namespace grtx::sim
