// SPDX-License-Identifier: Apache-2.0
#include "grtx/traces/codec/columns.h"

#define ZSTD_STATIC_LINKING_ONLY  // for ZSTD_c_literalCompressionMode
#include <zstd.h>

#include <memory>
#include <new>
#include <stdexcept>

#include "grtx/traces/codec/file_layout.h"
#include "grtx/traces/decoded_size.h"

namespace grtx::traces {
namespace {

// The columns hold prediction residuals, in which short zstd matches cost more than Huffman codes of the same bytes. A
// fast level that soon gives up searching for matches is both smaller and faster than level 1, if Huffman coding is
// enabled explicitly, which fast levels otherwise leave out.
constexpr int kCompressionLevel = -50;
constexpr std::size_t kStoreBelow = 24;  ///< shorter columns are not worth zstd's frame header
// A zstd block of up to 128 KiB takes at least 4 bytes (run-length block).
constexpr std::uint64_t kMaxExpansion = (128ULL << 10) / 4;

struct FreeContext {
  void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
  void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
};

ZSTD_CCtx* compression_context() {
  thread_local std::unique_ptr<ZSTD_CCtx, FreeContext> context;
  if (!context) {
    context.reset(ZSTD_createCCtx());
    if (!context) throw std::bad_alloc();
    ZSTD_CCtx_setParameter(context.get(), ZSTD_c_compressionLevel, kCompressionLevel);
    ZSTD_CCtx_setParameter(context.get(), ZSTD_c_literalCompressionMode, ZSTD_ps_enable);
    ZSTD_CCtx_setParameter(context.get(), ZSTD_c_contentSizeFlag, 0);  // sizes are in the column table
  }
  return context.get();
}

ZSTD_DCtx* decompression_context() {
  thread_local std::unique_ptr<ZSTD_DCtx, FreeContext> context;
  if (!context) {
    context.reset(ZSTD_createDCtx());
    if (!context) throw std::bad_alloc();
  }
  return context.get();
}

}  // namespace

std::size_t ColumnSet::bytes() const {
  std::size_t sum = 0;
  for (const Bytes& column : columns_) sum += column.size();
  return sum;
}

std::size_t ColumnWriter::bytes() const {
  std::size_t sum = 0;
  for (std::size_t i = 0; i < kColumnCount; ++i) sum += view(static_cast<Column>(i)).size();
  return sum;
}

void pack_columns(const ColumnSet& columns, Bytes& out, std::size_t count) {
  std::array<ColumnView, kColumnCount> views;
  for (std::size_t i = 0; i < count; ++i) views[i] = columns[static_cast<Column>(i)];
  pack_columns(std::span(views).first(count), out);
}

void pack_columns(std::span<const ColumnView> columns, Bytes& out) {
  thread_local Bytes blobs;
  thread_local Bytes frame;
  blobs.clear();
  for (const ColumnView column : columns) {
    std::size_t stored = 0;  // compressed size; 0 if stored uncompressed
    if (column.size() >= kStoreBelow) {
      const std::size_t bound = ZSTD_compressBound(column.size());
      if (frame.size() < bound) frame.resize(bound);  // never shrunk: each resize would fill it with zeros
      stored = ZSTD_compress2(compression_context(), frame.data(), frame.size(), column.data(), column.size());
      if (ZSTD_isError(stored)) throw std::runtime_error(std::string("zstd: ") + ZSTD_getErrorName(stored));
      if (stored >= column.size()) stored = 0;
    }
    put_varint(out, column.size());
    put_varint(out, stored);
    if (stored == 0) {
      blobs.insert(blobs.end(), column.begin(), column.end());
    } else {
      blobs.insert(blobs.end(), frame.begin(), frame.begin() + static_cast<std::ptrdiff_t>(stored));
    }
  }
  out.insert(out.end(), blobs.begin(), blobs.end());
}

void unpack_columns(const std::uint8_t* bytes, std::size_t size, ColumnSet& columns, std::size_t count) {
  ByteReader reader(bytes, size, "column table");
  std::array<std::uint64_t, kColumnCount> raw{};
  std::array<std::uint64_t, kColumnCount> stored{};
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i < count; ++i) {
    raw[i] = reader.varint(kMaxGroupBytes);
    stored[i] = reader.varint(size);
    if (stored[i] != 0 && raw[i] > stored[i] * kMaxExpansion) reader.fail("claims more than zstd can expand to");
    if (stored[i] == 0 && raw[i] > reader.remaining()) reader.fail("claims more bytes than the chunk has");
    sum += raw[i];
  }
  if (sum > kMaxGroupBytes) reader.fail("claims more bytes than a group may have");
  take_memory(sum);
  for (std::size_t i = count; i < kColumnCount; ++i) columns[static_cast<Column>(i)].clear();
  for (std::size_t i = 0; i < count; ++i) {
    Bytes& column = columns[static_cast<Column>(i)];
    const std::uint8_t* blob = reader.position();
    if (stored[i] == 0) {
      reader.skip(static_cast<std::size_t>(raw[i]));
      column.assign(blob, blob + raw[i]);
      continue;
    }
    reader.skip(static_cast<std::size_t>(stored[i]));
    column.resize(static_cast<std::size_t>(raw[i]));
    const std::size_t got = ZSTD_decompressDCtx(decompression_context(), column.data(), column.size(), blob,
                                                static_cast<std::size_t>(stored[i]));
    if (ZSTD_isError(got) || got != column.size()) {
      throw Malformed("column " + std::string(name_at<Column>(i)) + " does not decompress to its size");
    }
  }
  reader.expect_end();
}

}  // namespace grtx::traces
