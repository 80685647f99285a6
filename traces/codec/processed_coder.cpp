// SPDX-License-Identifier: Apache-2.0
#include "grtx/traces/codec/processed_coder.h"

#include <algorithm>
#include <limits>

#include "grtx/traces/codec/group_codec.h"

namespace grtx::traces {
namespace {

constexpr std::uint64_t kMaxGaussian = (1ULL << 31) - 1;
constexpr std::uint64_t kMaxPosition = std::numeric_limits<std::uint32_t>::max();

}  // namespace

void ProcessedEncoder::clear() {
  processed_.clear();
  ends_.clear();
}

void ProcessedEncoder::add(std::span<const Processed> entries) {
  processed_.insert(processed_.end(), entries.begin(), entries.end());
  ends_.push_back(processed_.size());
}

std::size_t ProcessedEncoder::put(ColumnWriter& columns) {
  gaussians_.clear();
  for (const Processed& entry : processed_) gaussians_.push_back(entry.gaussian);
  std::sort(gaussians_.begin(), gaussians_.end());
  gaussians_.erase(std::unique(gaussians_.begin(), gaussians_.end()), gaussians_.end());
  columns.reserve(Column::gaussian_id, 5 * gaussians_.size());
  std::uint32_t last = 0;
  for (const std::uint32_t gaussian : gaussians_) {
    columns.put_varint(Column::gaussian_id, gaussian - last);
    last = gaussian;
  }
  successor_.assign(gaussians_.size() + 1, kNoSuccessor);
  columns.reserve(Column::processed, processed_.size());
  columns.reserve(Column::gaussian_low, processed_.size());
  columns.reserve(Column::gaussian_high, 5 * processed_.size());
  std::size_t begin = 0;
  for (const std::size_t end : ends_) {
    put_ray(columns, {processed_.data() + begin, end - begin});
    begin = end;
  }
  return gaussians_.size();
}

// Branch-free binary search, since its branches would be unpredictable. The Gaussian must be in the list.
std::uint32_t ProcessedEncoder::position_of(std::uint32_t gaussian) const {
  const std::uint32_t* first = gaussians_.data();
  for (std::size_t count = gaussians_.size(); count > 1;) {
    const std::size_t half = count / 2;
    first += first[half] <= gaussian ? half : 0;
    count -= half;
  }
  return static_cast<std::uint32_t>(first - gaussians_.data());
}

void ProcessedEncoder::put_ray(ColumnWriter& columns, std::span<const Processed> entries) {
  std::size_t last = gaussians_.size();
  for (const Processed& entry : entries) {
    std::uint32_t index = successor_[last];
    const bool predicted = index != kNoSuccessor && gaussians_[index] == entry.gaussian;
    if (!predicted) {
      index = position_of(entry.gaussian);
      columns.put(Column::gaussian_low, index & 0xFF);
      columns.put_varint(Column::gaussian_high, index >> 8);
    }
    columns.put(Column::processed,
                (entry.blended != 0 ? kProcessedBlended : 0) | (predicted ? 0 : kProcessedNotPredicted));
    successor_[last] = index;
    last = index;
  }
}

void ProcessedDecoder::begin(std::uint64_t count, ColumnReaders& readers) {
  ByteReader& ids = readers[Column::gaussian_id];
  gaussians_.clear();
  std::uint64_t last = 0;
  for (std::uint64_t i = 0; i < count; ++i) {
    last += ids.varint(kMaxGaussian);
    if (last > kMaxGaussian) ids.fail("leaves 31 bits");
    gaussians_.push_back(static_cast<std::uint32_t>(last));
  }
  successor_.assign(gaussians_.size() + 1, kNoSuccessor);
}

void ProcessedDecoder::take_ray(std::uint64_t count, ColumnReaders& readers, std::vector<Processed>& processed) {
  ByteReader& symbols = readers[Column::processed];
  if (count > symbols.remaining()) symbols.fail("ends too early");
  std::size_t last = gaussians_.size();
  for (std::uint64_t i = 0; i < count; ++i) {
    const unsigned symbol = symbols.u8();
    if (symbol > (kProcessedBlended | kProcessedNotPredicted)) symbols.fail("holds an unknown symbol");
    std::uint64_t index = successor_[last];
    if ((symbol & kProcessedNotPredicted) != 0) {
      index = readers[Column::gaussian_low].u8();
      index |= readers[Column::gaussian_high].varint(kMaxPosition) << 8;
    }
    if (index >= gaussians_.size()) symbols.fail("names a Gaussian that is not listed");
    successor_[last] = static_cast<std::uint32_t>(index);
    last = static_cast<std::size_t>(index);
    Processed entry;
    entry.gaussian = gaussians_[last] & 0x7FFFFFFFU;
    entry.blended = symbol & kProcessedBlended;
    processed.push_back(entry);
  }
}

}  // namespace grtx::traces
