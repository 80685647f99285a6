// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/scene/decompress.h"

#include <zlib.h>
#include <zstd.h>
#include <zstd_errors.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <new>

#include "grtx/base/error.h"

namespace grtx::frontend {
namespace {

constexpr std::size_t kStep = std::size_t{1} << 20;  // bytes of output per step

std::string byte_text(std::size_t at) { return "byte " + std::to_string(at); }

struct InflateEnd {
  void operator()(z_stream* stream) const { inflateEnd(stream); }
};

}  // namespace

std::string inflate_gzip(std::string_view bytes, std::size_t most, const std::string& file) {
  z_stream stream{};
  constexpr int kGzipOnly = 16 + MAX_WBITS;
  if (inflateInit2(&stream, kGzipOnly) != Z_OK) throw std::bad_alloc();
  const std::unique_ptr<z_stream, InflateEnd> end(&stream);
  std::string plain;
  std::size_t fed = 0;
  int status = Z_OK;
  while (status != Z_STREAM_END) {
    if (stream.avail_in == 0 && fed < bytes.size()) {
      const std::size_t piece = std::min<std::size_t>(bytes.size() - fed, std::numeric_limits<uInt>::max());
      stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data() + fed));
      stream.avail_in = static_cast<uInt>(piece);
      fed += piece;
    }
    const std::size_t done = plain.size();
    if (done == most) return plain;
    const std::size_t step = std::min(kStep, most - done);
    plain.resize(done + step);
    stream.next_out = reinterpret_cast<Bytef*>(plain.data() + done);
    stream.avail_out = static_cast<uInt>(step);
    status = inflate(&stream, Z_NO_FLUSH);
    plain.resize(done + step - stream.avail_out);
    const std::size_t at = fed - stream.avail_in;
    if (status == Z_MEM_ERROR) throw std::bad_alloc();
    if (status == Z_BUF_ERROR) throw Error(file, byte_text(at), "the file ends within its gzip stream");
    if (status != Z_OK && status != Z_STREAM_END) {
      throw Error(file, byte_text(at),
                  std::string("its gzip stream is damaged") +
                      (stream.msg != nullptr ? std::string(" (") + stream.msg + ")" : ""));
    }
  }
  const std::size_t at = fed - stream.avail_in;
  if (at != bytes.size()) throw Error(file, byte_text(at), "the file must end with its gzip stream");
  return plain;
}

std::string inflate_zstd(std::string_view bytes, std::size_t plain_size, std::size_t begin, const std::string& file) {
  const std::unique_ptr<ZSTD_DCtx, std::size_t (*)(ZSTD_DCtx*)> context(ZSTD_createDCtx(), ZSTD_freeDCtx);
  if (context == nullptr) throw std::bad_alloc();
  ZSTD_inBuffer in{bytes.data(), bytes.size(), 0};
  std::string plain;
  std::size_t status = 1;  // 0: a frame is complete
  bool full = false;       // the last step used up its output, so more may come without more input
  while (in.pos < in.size || full) {
    const std::size_t done = plain.size();
    const std::size_t step = std::min(kStep, plain_size - done + 1);  // one more shows excess output
    plain.resize(done + step);
    ZSTD_outBuffer out{plain.data() + done, step, 0};
    status = ZSTD_decompressStream(context.get(), &out, &in);
    plain.resize(done + out.pos);
    full = out.pos == step && status != 0;
    if (ZSTD_getErrorCode(status) == ZSTD_error_memory_allocation) throw std::bad_alloc();
    if (ZSTD_isError(status) != 0) {
      throw Error(file, byte_text(begin + in.pos),
                  std::string("its zstd stream is damaged (") + ZSTD_getErrorName(status) + ")");
    }
    if (plain.size() > plain_size) break;
  }
  if (plain.size() != plain_size || status != 0) {
    throw Error(file, byte_text(begin), "the zstd stream must give exactly " + std::to_string(plain_size) + " bytes");
  }
  return plain;
}

}  // namespace grtx::frontend
