// SPDX-License-Identifier: Apache-2.0
// A chunk's payload is a fixed list of byte columns, compressed separately: bytes of one meaning share statistics,
// which suits zstd's entropy coder. The comments of Column give the item that adds to a column, then what is stored.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "grtx/base/declare/named_enum.h"
#include "grtx/traces/byte_stream.h"

namespace grtx::traces {

enum class Column : std::uint8_t {
  group = 0,         ///< index, kind, root kind, counts
  node_address,      ///< a node, unless they form a tree: distance to the previous one
  node_tree,         ///< a node of a tree with internal children: mask of those that the group visited
  node_shape,        ///< a node: child count, kind of its leaves
  node_kinds,        ///< a node with children of several kinds: the kind of each
  node_children,     ///< a node: difference of its child base from the prediction
  node_hits,         ///< a node: children hit at its first visit
  ray,               ///< a ray: pixel, rounds
  round_flags,       ///< a round: replay, overflow, terminated
  preloaded,         ///< a round
  k_count,           ///< a round
  processed_count,   ///< a round: k_count - processed_count
  eviction_dropped,  ///< an overflowed round
  inner_gap,         ///< pops where an internal node or instance leaf is expected: predicted pops in a row
  inner,             ///< ... a mispredicted one
  hits,              ///< a visit of an internal node with other hits than at its last visit: mask of the difference
  checkpoints,       ///< a visit of an internal node that checkpoints: mask among its hits
  leaf_gap,          ///< pops where a leaf is expected: predicted pops in a row
  leaf,              ///< ... a mispredicted one
  shifts,            ///< an insertion into the k-buffer
  replay_op,         ///< a source entry read: taken or forwarded
  replay_entry,      ///< a source entry read in nearest order: its position
  gaussian_id,       ///< the distinct Gaussians processed, ascending
  processed,         ///< a processed entry: blended, predicted
  gaussian_low,      ///< a mispredicted processed entry: position in gaussian_id, low byte
  gaussian_high,     ///< ... the remaining bits of that position
  bin,               ///< with bins: a replay: its order; a checkpoint entry written: its bin
};
/// Column names as in docs/model/trace-format.md.
constexpr auto enum_names(Column) {
  return names_in_order<Column>({"group",
                                 "node_address",
                                 "node_tree",
                                 "node_shape",
                                 "node_kinds",
                                 "node_children",
                                 "node_hits",
                                 "ray",
                                 "round_flags",
                                 "preloaded",
                                 "k_count",
                                 "processed_count",
                                 "eviction_dropped",
                                 "inner_gap",
                                 "inner",
                                 "hits",
                                 "checkpoints",
                                 "leaf_gap",
                                 "leaf",
                                 "shifts",
                                 "replay_op",
                                 "replay_entry",
                                 "gaussian_id",
                                 "processed",
                                 "gaussian_low",
                                 "gaussian_high",
                                 "bin"});
}
inline constexpr std::size_t kColumnCount = kCountOf<Column>;
/// Number of columns if the header has no checkpoint_bins: all but the last.
inline constexpr std::size_t kColumnsWithoutBins = kColumnCount - 1;

using ColumnView = std::span<const std::uint8_t>;

/// Columns as byte strings. clear() keeps the allocated memory.
class ColumnSet {
 public:
  Bytes& operator[](Column column) { return columns_[static_cast<std::size_t>(column)]; }
  const Bytes& operator[](Column column) const { return columns_[static_cast<std::size_t>(column)]; }
  void clear() {
    for (Bytes& column : columns_) column.clear();
  }
  std::size_t bytes() const;

 private:
  std::array<Bytes, kColumnCount> columns_;
};

/// One ByteReader per column.
class ColumnReaders {
 public:
  /// Starts at the front of all columns, which must stay valid while they are read.
  void begin(const ColumnSet& columns) {
    for (std::size_t i = 0; i < kColumnCount; ++i) {
      const auto column = static_cast<Column>(i);
      readers_[i] = ByteReader(columns[column].data(), columns[column].size(), name_of(column).data());
    }
  }
  ByteReader& operator[](Column column) { return readers_[static_cast<std::size_t>(column)]; }
  void expect_end() const {
    for (const ByteReader& reader : readers_) reader.expect_end();
  }

 private:
  std::array<ByteReader, kColumnCount> readers_;
};

/// Columns being filled. clear() keeps the allocated memory.
class ColumnWriter {
 public:
  void clear() {
    for (Buffer& buffer : buffers_) buffer.end = buffer.bytes.data();
  }
  /// Makes room for `more` bytes. put(), put_varint() and end() do not check.
  void reserve(Column column, std::size_t more) {
    Buffer& buffer = buffers_[static_cast<std::size_t>(column)];
    const auto used = static_cast<std::size_t>(buffer.end - buffer.bytes.data());
    if (buffer.bytes.size() - used >= more) return;
    buffer.bytes.resize(2 * (used + more));
    buffer.end = buffer.bytes.data() + used;
  }
  void put(Column column, unsigned byte) { *end(column)++ = static_cast<std::uint8_t>(byte); }
  void put_varint(Column column, std::uint64_t value) { end(column) = store_varint(end(column), value); }
  /// Pointer to the next byte to write.
  std::uint8_t*& end(Column column) { return buffers_[static_cast<std::size_t>(column)].end; }
  ColumnView view(Column column) const {
    const Buffer& buffer = buffers_[static_cast<std::size_t>(column)];
    return {buffer.bytes.data(), static_cast<std::size_t>(buffer.end - buffer.bytes.data())};
  }
  std::size_t bytes() const;

 private:
  struct Buffer {
    Bytes bytes;
    std::uint8_t* end = nullptr;
  };
  std::array<Buffer, kColumnCount> buffers_;
};

/// Appends the compressed columns to `out`. Deterministic. Uses a thread-local compression context.
void pack_columns(std::span<const ColumnView> columns, Bytes& out);
void pack_columns(const ColumnSet& columns, Bytes& out, std::size_t count = kColumnsWithoutBins);

/// Inverse of pack_columns(); columns from `count` on are empty. Throws Malformed. Allocates no more than the stored
/// bytes can decompress to, and at most kMaxGroupBytes.
void unpack_columns(const std::uint8_t* bytes, std::size_t size, ColumnSet& columns,
                    std::size_t count = kColumnsWithoutBins);

}  // namespace grtx::traces
