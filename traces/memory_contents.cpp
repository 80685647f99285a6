// SPDX-License-Identifier: Apache-2.0
#include "grtx/traces/memory_contents.h"

#include <algorithm>
#include <cstdint>
#include <nlohmann/json.hpp>

#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/base/hash.h"
#include "grtx/base/json.h"
#include "grtx/traces/codec/stream_hash.h"

namespace grtx::traces {
namespace {

constexpr std::string_view kMagic = "GRTXMEM1";
constexpr std::uint32_t kMostHeaderBytes = 1 << 16;

template <typename T>
T little_endian(std::string_view bytes, std::size_t at) {
  T value = 0;
  for (std::size_t i = 0; i < sizeof value; ++i) {
    value = static_cast<T>(value | static_cast<T>(static_cast<unsigned char>(bytes[at + i])) << 8 * i);
  }
  return value;
}

template <typename T>
std::string little_endian_bytes(T value) {
  std::string bytes;
  for (std::size_t i = 0; i < sizeof value; ++i) bytes.push_back(static_cast<char>(value >> 8 * i & 0xFF));
  return bytes;
}

}  // namespace

MemoryContents::MemoryContents(const std::string& path)
    : path_(path), file_(std::make_unique<const std::string>(read_file(path))) {
  const std::string_view all = *file_;
  const auto fail = [&](const std::string& place, const std::string& rule) { throw Error(path, place, rule); };
  constexpr std::size_t kPrefix = kMagic.size() + 4, kHash = 8;
  if (!all.starts_with(kMagic)) fail("offset 0", "must be GRTXMEM1: this is no file of memory contents");
  if (all.size() < kPrefix + kHash) fail("end", "the file ends early");
  const std::string_view hashed = all.substr(0, all.size() - kHash);
  if (xxh3(hashed) != little_endian<std::uint64_t>(all, hashed.size())) {
    fail("end", "the hash is not that of the file: it is damaged or incomplete");
  }
  const std::uint32_t header_bytes = little_endian<std::uint32_t>(all, kMagic.size());
  if (header_bytes > kMostHeaderBytes || header_bytes > hashed.size() - kPrefix) {
    fail("offset 8", "the header must end before the file, and have 65536 B at most");
  }
  const auto header = parse_json<nlohmann::json>(all.substr(kPrefix, header_bytes), path, "header");
  std::string_view rest = hashed.substr(kPrefix + header_bytes);
  try {
    trace_ = header.at("trace").get<std::string>();
    for (const auto& region : header.at("regions")) {
      const std::string name = region.at("name").get<std::string>();
      const auto bytes = region.at("bytes").get<std::uint64_t>();
      if (!region.at("bytes").is_number_unsigned() || bytes > rest.size()) fail(name, "must end before the file");
      if (std::ranges::find(regions_, name, &MemoryRegion::name) != regions_.end()) fail(name, "is there twice");
      regions_.push_back({name, rest.substr(0, bytes)});
      rest.remove_prefix(bytes);
    }
  } catch (const nlohmann::json::exception&) {
    fail("header", "must be an object with trace, a text, and regions, a list of name and bytes");
  }
  if (!rest.empty()) fail("regions", "must fill the file");
}

std::string_view MemoryContents::region(std::string_view name) const {
  for (const MemoryRegion& region : regions_) {
    if (region.name == name) return region.bytes;
  }
  return {};
}

void write_memory_contents(const std::string& path, const std::string& trace,
                           const std::vector<MemoryRegion>& regions) {
  nlohmann::ordered_json header = {{"trace", trace}, {"regions", nlohmann::ordered_json::array()}};
  for (const MemoryRegion& region : regions) {
    header["regions"].push_back({{"name", region.name}, {"bytes", region.bytes.size()}});
  }
  const std::string text = json_text(header);
  AtomicFile file(path);
  StreamHash hash;
  const auto write = [&](std::string_view bytes) {
    file.write(bytes);
    hash.add(bytes.data(), bytes.size());
  };
  write(kMagic);
  write(little_endian_bytes(static_cast<std::uint32_t>(text.size())));
  write(text);
  for (const MemoryRegion& region : regions) write(region.bytes);
  file.write(little_endian_bytes(hash.value()));
  file.commit();
}

}  // namespace grtx::traces
