// A chunk's payload is a fixed list of byte columns, each compressed on its own: bytes of one meaning share statistics,
// so that zstd's entropy stage models each column by itself.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "grtx/base/declare/named_enum.h"
#include "grtx/traces/codec/byte_stream.h"

namespace grtx::traces {

enum class Column : std::uint8_t {
  group = 0,         ///< index, kind, root kind, counts
  node_address,      ///< a node, unless they form a tree: distance to the one before
  node_tree,         ///< a node of a tree with internal children: which of them the group visited
  node_shape,        ///< a node: child count, kind of its leaves
  node_kinds,        ///< a node with children of several kinds: which is which
  node_children,     ///< a node: child base against its prediction
  node_hits,         ///< a node: children hit at its first visit
  ray,               ///< a ray: pixel, rounds
  round_flags,       ///< a round: replay, overflow, terminated
  preloaded,         ///< a round
  k_count,           ///< a round
  processed_count,   ///< a round: k_count - processed_count
  eviction_dropped,  ///< an overflowed round
  inner_gap,         ///< where an internal node or instance leaf is expected: predicted pops between two others
  inner,             ///< ... a pop that was not predicted
  hits,              ///< a visited internal node with other hits than at the last visit: mask of the difference
  checkpoints,       ///< a visited internal node that checkpoints: which of its hits
  leaf_gap,          ///< where a leaf is expected: predicted pops between two others
  leaf,              ///< ... a pop that was not predicted
  shifts,            ///< an insertion into the k-buffer
  replay_op,         ///< a source entry read: taken or forwarded
  replay_entry,      ///< a source entry read in nearest order: its position
  gaussian_id,       ///< the distinct Gaussians processed, ascending
  processed,         ///< a processed entry: blended, predicted
  gaussian_low,      ///< a processed entry not predicted: position in gaussian_id, low byte
  gaussian_high,     ///< the rest of that position
  bin,               ///< with bins: a replay, a checkpoint entry written
};
/// As in docs/model/trace-format.md.
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
/// Columns of a group whose header has no checkpoint_bins: all but the last.
inline constexpr std::size_t kColumnsWithoutBins = kColumnCount - 1;

using ColumnView = std::span<const std::uint8_t>;

/// Columns as byte strings. clear() keeps the memory.
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

/// A reader of each column.
class ColumnReaders {
 public:
  /// At the front of all columns, which must live as long as they are read.
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

/// Columns being filled. clear() keeps the memory.
class ColumnWriter {
 public:
  void clear() {
    for (Buffer& buffer : buffers_) buffer.end = buffer.bytes.data();
  }
  /// Room for `more` bytes. Nothing else checks.
  void reserve(Column column, std::size_t more) {
    Buffer& buffer = buffers_[static_cast<std::size_t>(column)];
    const auto used = static_cast<std::size_t>(buffer.end - buffer.bytes.data());
    if (buffer.bytes.size() - used >= more) return;
    buffer.bytes.resize(2 * (used + more));
    buffer.end = buffer.bytes.data() + used;
  }
  void put(Column column, unsigned byte) { *end(column)++ = static_cast<std::uint8_t>(byte); }
  void put_varint(Column column, std::uint64_t value) { end(column) = store_varint(end(column), value); }
  /// Where the next byte goes.
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

/// Appends the packed columns to `out`. Uses a compression context of the calling thread. Same input, same bytes.
void pack_columns(std::span<const ColumnView> columns, Bytes& out);
void pack_columns(const ColumnSet& columns, Bytes& out, std::size_t count = kColumnsWithoutBins);

/// Undoes pack_columns; columns behind `count` are empty. Throws Malformed. Allocates no more than the stored bytes can
/// stand for (kMaxGroupBytes at most).
void unpack_columns(const std::uint8_t* bytes, std::size_t size, ColumnSet& columns,
                    std::size_t count = kColumnsWithoutBins);

}  // namespace grtx::traces
