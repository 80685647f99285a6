// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <condition_variable>
#include <map>
#include <mutex>
#include <optional>
#include <stdexcept>

#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/base/hash.h"
#include "grtx/traces/codec/file_layout.h"
#include "grtx/traces/codec/header_json.h"
#include "grtx/traces/codec/stream_hash.h"
#include "grtx/traces/count_totals.h"
#include "grtx/traces/decoded_size.h"
#include "grtx/traces/encode/group_encoder.h"
#include "grtx/traces/writer.h"

namespace grtx::traces {
namespace {

constexpr std::uint64_t kMaxAhead = 1024;  ///< finished chunks that may wait for an earlier one

}  // namespace

struct Writer::Impl {
  Impl(const std::string& path, const Header& h) : header(h) {
    if (const std::string fault = header_fault(h); !fault.empty()) throw Error(path, "trace header", fault);
    const std::string json = header_to_json(h);
    if (json.size() > kMaxHeaderBytes) throw Error(path, "trace header", "must take at most 1 MiB");
    file.emplace(path);
    Bytes preamble(kFileMagic.begin(), kFileMagic.end());
    put_u32(preamble, format_version(h));
    put_u32(preamble, static_cast<std::uint32_t>(json.size()));
    put_u64(preamble, xxh3(json));
    write(preamble.data(), preamble.size());
    write(json.data(), json.size());
  }

  void write(const void* bytes, std::size_t count) {
    file->write(bytes, count);
    hash.add(bytes, count);
  }

  void write_chunk(const Bytes& chunk) {
    offsets.push_back(file->size());
    write(chunk.data(), chunk.size());
  }

  Header header;
  StreamHash hash;  ///< hash of everything written so far
  std::optional<AtomicFile> file;
  std::mutex mutex;
  std::condition_variable progress;
  std::map<std::uint64_t, Bytes> waiting;  ///< chunks that wait for an earlier one
  std::vector<std::uint64_t> offsets;      ///< file offsets of the chunks written
  Totals totals;
  std::uint64_t largest_group = 0;  ///< decoded size, bytes
  bool stopped = false;             ///< a write failed or cancel() was called: nothing can be appended any more
  bool finished = false;
};

Writer::Writer(const std::string& path, const Header& header) : impl_(std::make_unique<Impl>(path, header)) {}
Writer::~Writer() = default;

void Writer::append(const RayGroup& group) {
  EncodedGroup encoded;
  encode_group(impl_->header, group, encoded);
  append(std::move(encoded));
}

void Writer::append(EncodedGroup&& group) {
  Impl& impl = *impl_;
  std::unique_lock lock(impl.mutex);
  impl.progress.wait(lock, [&] { return impl.stopped || group.index <= impl.offsets.size() + kMaxAhead; });
  const std::string& path = impl.file->path();
  if (impl.stopped) throw Error(path, "", "is not written any more, because writing it failed or was cancelled");
  if (impl.finished || group.index < impl.offsets.size() || impl.waiting.contains(group.index)) {
    throw std::logic_error("trace group " + std::to_string(group.index) + " appended twice or after finish()");
  }
  add_totals(impl.totals, group.totals);
  impl.largest_group = std::max(impl.largest_group, traces::decoded_bytes(group.totals));
  if (group.index != impl.offsets.size()) {
    impl.waiting.emplace(group.index, std::move(group.chunk));
    return;
  }
  try {
    impl.write_chunk(group.chunk);
    while (!impl.waiting.empty() && impl.waiting.begin()->first == impl.offsets.size()) {
      impl.write_chunk(impl.waiting.begin()->second);
      impl.waiting.erase(impl.waiting.begin());
    }
  } catch (...) {
    impl.stopped = true;
    impl.progress.notify_all();
    throw;
  }
  impl.progress.notify_all();
}

void Writer::cancel() {
  const std::lock_guard lock(impl_->mutex);
  impl_->stopped = true;
  impl_->progress.notify_all();
}

void Writer::finish() {
  Impl& impl = *impl_;
  const std::lock_guard lock(impl.mutex);
  if (impl.stopped)
    throw Error(impl.file->path(), "", "cannot be finished, because writing it failed or was cancelled");
  if (impl.finished) throw std::logic_error("trace finished twice");
  if (impl.offsets.size() != impl.header.groups) {
    throw std::logic_error("trace finished with " + std::to_string(impl.offsets.size()) + " of " +
                           std::to_string(impl.header.groups) + " groups");
  }
  const std::uint64_t footer_offset = impl.file->size();
  const std::string json = totals_to_json(impl.totals);
  Bytes footer;
  put_u64(footer, impl.offsets.size());
  for (const std::uint64_t offset : impl.offsets) put_u64(footer, offset);
  put_u32(footer, static_cast<std::uint32_t>(json.size()));
  footer.insert(footer.end(), json.begin(), json.end());
  impl.hash.add(footer.data(), footer.size());
  put_u64(footer, impl.hash.value());                   // content hash: all bytes before it
  put_u64(footer, xxh3(footer.data(), footer.size()));  // footer hash: all of the footer before it
  put_u64(footer, footer_offset);
  footer.insert(footer.end(), kTrailerMagic.begin(), kTrailerMagic.end());
  impl.file->write(footer.data(), footer.size());
  impl.file->commit();
  impl.finished = true;
}

const Header& Writer::header() const { return impl_->header; }
const Totals& Writer::totals() const { return impl_->totals; }

std::uint64_t Writer::decoded_bytes() const { return traces::decoded_bytes(impl_->totals); }
std::uint64_t Writer::largest_group() const { return impl_->largest_group; }

std::uint64_t Writer::bytes() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->file->size();
}

}  // namespace grtx::traces
