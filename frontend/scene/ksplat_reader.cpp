// SPDX-License-Identifier: Apache-2.0
// The layout is that of GaussianSplats3D 0.4.7, src/loaders/SplatBuffer.js (github.com/mkkellogg/GaussianSplats3D).
#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "grtx/base/error.h"
#include "grtx/frontend/scene/raw_encoding.h"
#include "grtx/frontend/scene/readers.h"

namespace grtx::frontend {
namespace {

constexpr std::size_t kKsplatHeaderBytes = 4096;   // of the file; one header per section follows
constexpr std::size_t kKsplatSectionBytes = 1024;  // then, per section: buckets, and splats
constexpr unsigned kKsplatDegree = 2;

/// From a bucket's centre to its sides, unless a section says otherwise.
constexpr std::uint32_t kKsplatSteps = 32767;
/// Ends of the range of 8-bit harmonics, unless the header says otherwise.
constexpr float kKsplatHarmonicsEnd = 1.5f;

struct KsplatHeader {
  std::uint32_t sections = 0;
  std::uint32_t splats = 0;
  unsigned level = 0;  ///< of compression: 0 fp32; 1 steps in a bucket and fp16; 2 as 1, harmonics in bytes
  float least = 0.0f, largest = 0.0f;  ///< of harmonics at level 2
};

KsplatHeader parse_ksplat_header(std::string_view bytes, const std::string& file) {
  KsplatHeader header;
  header.sections = load<std::uint32_t>(bytes, 4);
  header.splats = load<std::uint32_t>(bytes, 16);
  header.level = load<std::uint16_t>(bytes, 20);
  header.least = load<float>(bytes, 36);
  header.largest = load<float>(bytes, 40);
  if (header.least == 0.0f) header.least = -kKsplatHarmonicsEnd;
  if (header.largest == 0.0f) header.largest = kKsplatHarmonicsEnd;
  if (header.level > 2) {
    throw Error(file, "byte 20", "the level of compression must be 0 to 2, not " + std::to_string(header.level));
  }
  if (header.sections > (bytes.size() - kKsplatHeaderBytes) / kKsplatSectionBytes) {
    throw Error(file, "byte 4", "names " + std::to_string(header.sections) + " sections, more than the file holds");
  }
  return header;
}

struct KsplatSection {
  std::string place;
  std::uint64_t splats = 0;
  std::uint64_t bucket_size = 0, full_buckets = 0, partial_buckets = 0, buckets = 0;
  double step = 0.0;  ///< of positions
  std::uint32_t steps = 0;
  unsigned degree = 0;
  std::uint64_t partial_at = 0, centres_at = 0, splats_at = 0, end = 0;  ///< bytes of the file
  std::size_t bytes_per_splat = 0;
};

std::size_t harmonics_per_splat(unsigned degree) { return std::size_t{3} * ((degree + 1) * (degree + 1) - 1); }

KsplatSection parse_ksplat_section(std::string_view bytes, const KsplatHeader& header, std::size_t index,
                                   std::uint64_t begin, const std::string& file) {
  const std::size_t at = kKsplatHeaderBytes + index * kKsplatSectionBytes;
  const auto word = [&](std::size_t offset) { return load<std::uint32_t>(bytes, at + offset); };
  KsplatSection section;
  section.place = "section " + std::to_string(index);
  section.splats = word(0);
  if (word(4) != section.splats) {
    throw Error(file, section.place,
                "holds " + std::to_string(section.splats) + " of " + std::to_string(word(4)) +
                    " splats: it was saved before it was loaded whole");
  }
  section.degree = load<std::uint16_t>(bytes, at + 40);
  if (section.degree > kKsplatDegree) {
    throw Error(file, section.place, "the SH degree must be 0 to 2, not " + std::to_string(section.degree));
  }
  section.steps = word(24) == 0 ? kKsplatSteps : word(24);
  section.step = static_cast<double>(load<float>(bytes, at + 16)) / 2.0 / section.steps;
  section.bucket_size = word(8);
  section.buckets = word(12);
  section.full_buckets = word(32);
  section.partial_buckets = word(36);
  const std::size_t bucket_bytes = load<std::uint16_t>(bytes, at + 20);
  if (header.level > 0 && bucket_bytes != 12) {
    throw Error(file, section.place, "a bucket must have 12 bytes, not " + std::to_string(bucket_bytes));
  }
  constexpr std::array<std::size_t, 3> kSplat{44, 24, 24}, kHarmonic{4, 2, 1};  // bytes, by level
  section.bytes_per_splat = kSplat[header.level] + kHarmonic[header.level] * harmonics_per_splat(section.degree);
  section.partial_at = begin;
  section.centres_at = begin + 4 * section.partial_buckets;
  section.splats_at = section.centres_at + bucket_bytes * section.buckets;
  section.end = section.splats_at + section.bytes_per_splat * section.splats;
  if (section.end > bytes.size()) {
    throw Error(file, section.place,
                "ends at byte " + std::to_string(section.end) + ", the file at " + std::to_string(bytes.size()));
  }
  return section;
}

/// The bucket of each splat: full ones first, then those that say how many they hold.
std::vector<std::uint32_t> buckets_of(std::string_view bytes, const KsplatSection& section, const std::string& file) {
  std::vector<std::uint32_t> bucket;
  const auto fill = [&](std::uint64_t index, std::uint64_t count) {
    if (index >= section.buckets || count > section.splats - bucket.size()) {
      throw Error(file, section.place, "its buckets hold more splats than it has");
    }
    bucket.insert(bucket.end(), static_cast<std::size_t>(count), static_cast<std::uint32_t>(index));
  };
  for (std::uint64_t i = 0; i < section.full_buckets; ++i) fill(i, section.bucket_size);
  for (std::uint64_t i = 0; i < section.partial_buckets; ++i) {
    fill(section.full_buckets + i, load<std::uint32_t>(bytes, static_cast<std::size_t>(section.partial_at + 4 * i)));
  }
  if (bucket.size() != section.splats) throw Error(file, section.place, "its buckets hold fewer splats than it has");
  return bucket;
}

/// One splat's numbers, in file order: position, scale, rotation (w x y z), colour, harmonics.
class KsplatSplat {
 public:
  KsplatSplat(std::string_view bytes, std::size_t at, const KsplatHeader& header)
      : bytes_(bytes), at_(at), header_(header) {}

  double position(std::size_t axis, const KsplatSection& section, std::uint64_t centre_at) const {
    if (header_.level == 0) return static_cast<double>(load<float>(bytes_, at_ + 4 * axis));
    const double steps = static_cast<double>(load<std::uint16_t>(bytes_, at_ + 2 * axis)) - section.steps;
    return steps * section.step +
           static_cast<double>(load<float>(bytes_, static_cast<std::size_t>(centre_at) + 4 * axis));
  }
  double scale(std::size_t axis) const { return number(3 + axis); }
  float rotation(std::size_t component) const { return static_cast<float>(number(6 + component)); }
  double colour(std::size_t channel) const {
    return static_cast<unsigned char>(bytes_[at_ + (header_.level == 0 ? 40 : 20) + channel]) / 255.0;
  }
  float harmonic(std::size_t index) const {
    if (header_.level == 0) return load<float>(bytes_, at_ + 44 + 4 * index);
    if (header_.level == 1)
      return static_cast<float>(half_to_double(load<std::uint16_t>(bytes_, at_ + 24 + 2 * index)));
    const auto byte = static_cast<float>(load<std::uint8_t>(bytes_, at_ + 24 + index));
    return header_.least + byte / 255.0f * (header_.largest - header_.least);
  }

 private:
  double number(std::size_t index) const {
    return header_.level == 0 ? static_cast<double>(load<float>(bytes_, at_ + 4 * index))
                              : half_to_double(load<std::uint16_t>(bytes_, at_ + 2 * index));
  }

  std::string_view bytes_;
  std::size_t at_;
  const KsplatHeader& header_;
};

/// Harmonics lie by band, in it by channel: k1 k2 k3 of red, of green, of blue; then k4 to k8.
std::size_t harmonic_index(std::size_t coefficient, std::size_t channel) {
  return coefficient < 4 ? 3 * channel + coefficient - 1 : 9 + 5 * channel + coefficient - 4;
}

void read_ksplat_section(std::string_view bytes, const KsplatHeader& header, const KsplatSection& section,
                         std::size_t row, RawRows& rows, const std::string& file) {
  const std::vector<std::uint32_t> bucket =
      header.level == 0 ? std::vector<std::uint32_t>{} : buckets_of(bytes, section, file);
  const std::size_t kept = std::size_t{rows.sh_degree + 1} * (rows.sh_degree + 1);
  const std::size_t own = std::size_t{section.degree + 1} * (section.degree + 1);
  for (std::size_t i = 0; i < section.splats; ++i, ++row) {
    const KsplatSplat splat(bytes, static_cast<std::size_t>(section.splats_at) + i * section.bytes_per_splat, header);
    const std::uint64_t centre_at = header.level == 0 ? 0 : section.centres_at + std::uint64_t{12} * bucket[i];
    rows.x[row] = splat.position(0, section, centre_at);
    rows.y[row] = splat.position(1, section, centre_at);
    rows.z[row] = splat.position(2, section, centre_at);
    for (std::size_t c = 0; c < 3; ++c) {
      rows.log_scale[row * 3 + c] = log_of_scale(splat.scale(c));
      rows.sh[row * kept * 3 + c] = static_cast<float>((splat.colour(c) - 0.5) / kShC0);
      for (std::size_t k = 1; k < own; ++k) rows.sh[(row * kept + k) * 3 + c] = splat.harmonic(harmonic_index(k, c));
    }
    for (std::size_t c = 0; c < 4; ++c) rows.rotation[row * 4 + c] = splat.rotation(c);
    rows.opacity_logit[row] = logit_of(splat.colour(3));
  }
}

}  // namespace

bool is_ksplat(std::string_view bytes) {
  if (bytes.size() < kKsplatHeaderBytes || !bytes.starts_with(std::string_view("\0\1\0\0", 4))) return false;
  const auto number = [&](std::size_t at) { return load<std::uint32_t>(bytes, at); };
  return number(8) > 0 && number(8) <= number(4) && number(16) > 0 && number(16) <= number(12);
}

RawRows read_ksplat(std::string_view bytes, const std::string& file) {
  const KsplatHeader header = parse_ksplat_header(bytes, file);
  std::vector<KsplatSection> sections;
  std::uint64_t begin = kKsplatHeaderBytes + std::uint64_t{header.sections} * kKsplatSectionBytes, splats = 0;
  RawRows rows;
  for (std::size_t i = 0; i < header.sections; ++i) {
    sections.push_back(parse_ksplat_section(bytes, header, i, begin, file));
    begin = sections.back().end;
    splats += sections.back().splats;
    rows.sh_degree = std::max(rows.sh_degree, sections.back().degree);
  }
  if (splats != header.splats) {
    throw Error(file, "byte 16",
                "names " + std::to_string(header.splats) + " splats, the sections hold " + std::to_string(splats));
  }
  if (begin < bytes.size()) rows.noticed["bytes behind the last element"] = bytes.size() - begin;
  rows.require_memory_for(static_cast<std::size_t>(splats), file);
  rows.resize(static_cast<std::size_t>(splats));
  std::size_t row = 0;
  for (const KsplatSection& section : sections) {
    read_ksplat_section(bytes, header, section, row, rows, file);
    row += static_cast<std::size_t>(section.splats);
  }
  return rows;
}

}  // namespace grtx::frontend
