// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "grtx/base/error.h"
#include "grtx/base/hash.h"
#include "grtx/traces/codec/file_layout.h"
#include "grtx/traces/codec/group_codec.h"
#include "grtx/traces/codec/header_json.h"
#include "grtx/traces/codec/stream_hash.h"
#include "grtx/traces/reader.h"

namespace grtx::traces {
namespace {

std::string at(std::uint64_t offset) { return "byte " + std::to_string(offset); }

}  // namespace

struct Reader::Impl {
  explicit Impl(const std::string& p) : path(p) {
    descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);  // so that opening a FIFO does not block
    if (descriptor < 0) throw Error(path, "", std::string("cannot be read: ") + std::strerror(errno));
  }
  ~Impl() {
    if (descriptor >= 0) ::close(descriptor);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  [[noreturn]] void fail(std::uint64_t offset, const std::string& rule) const { throw Error(path, at(offset), rule); }

  void pread_exactly(std::uint64_t offset, std::uint8_t* into, std::size_t count) const {
    while (count > 0) {
      const ssize_t got = ::pread(descriptor, into, count, static_cast<off_t>(offset));
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) fail(offset, std::string("cannot be read: ") + std::strerror(errno));
      if (got == 0) fail(offset, "the file ends too early");
      into += got;
      offset += static_cast<std::uint64_t>(got);
      count -= static_cast<std::size_t>(got);
    }
  }

  Bytes pread_bytes(std::uint64_t offset, std::uint64_t count) const {
    Bytes bytes(static_cast<std::size_t>(count));
    pread_exactly(offset, bytes.data(), bytes.size());
    return bytes;
  }

  void open() {
    struct stat status {};
    if (::fstat(descriptor, &status) != 0) throw Error(path, "", std::strerror(errno));
    if (!S_ISREG(status.st_mode)) throw Error(path, "", "is not a regular file");
    size = static_cast<std::uint64_t>(status.st_size);
    read_header();
    read_footer();
  }

  void read_header() {
    const Bytes start = pread_bytes(0, std::min<std::uint64_t>(size, kPreambleBytes));
    if (start.size() < kFileMagic.size() || !std::equal(kFileMagic.begin(), kFileMagic.end(), start.begin())) {
      fail(0, "is not a GRTX trace: it does not start with the magic bytes");
    }
    if (start.size() < kPreambleBytes) fail(start.size(), "the file ends inside its first 24 bytes");
    const std::uint32_t version = load_u32(&start[8]);
    if (version < kOldestFormatVersion || version > kFormatVersion || version == kRemovedFormatVersion) {
      fail(8, "has format version " + std::to_string(version) +
                  (version == kRemovedFormatVersion ? ", of --warp-beam, which was removed" : "") +
                  "; this program reads versions " + std::to_string(kOldestFormatVersion) + " to " +
                  std::to_string(kRemovedFormatVersion - 1) + " and " + std::to_string(kFormatVersion));
    }
    const std::uint64_t length = load_u32(&start[12]);
    if (length > kMaxHeaderBytes || length > size - kPreambleBytes) {
      fail(12, "header length " + std::to_string(length) + " exceeds the file or 1 MiB");
    }
    const Bytes json = pread_bytes(kPreambleBytes, length);
    if (xxh3(json.data(), json.size()) != load_u64(&start[16])) fail(16, "the hash of the header is wrong");
    try {
      header = header_from_json({reinterpret_cast<const char*>(json.data()), json.size()}, version);
    } catch (const Malformed& fault) {
      fail(kPreambleBytes, std::string("header: ") + fault.what());
    }
    chunks_begin = kPreambleBytes + length;
  }

  void read_footer() {
    if (size - chunks_begin < kTrailerBytes) fail(size, "the file ends without its trailer; it was cut off");
    const std::uint64_t trailer = size - kTrailerBytes;
    const Bytes end = pread_bytes(trailer, kTrailerBytes);
    if (!std::equal(kTrailerMagic.begin(), kTrailerMagic.end(), end.begin() + 8)) {
      fail(trailer + 8, "the trailer's magic bytes are missing; the file was cut off");
    }
    footer = load_u64(end.data());
    // Sizes of: group count, offsets, totals length, content hash, footer hash.
    const std::uint64_t fixed = 8 + 8 * header.groups + 4 + 8 + 8;
    if (footer < chunks_begin || footer > trailer || trailer - footer < fixed) {
      fail(trailer, "the footer offset does not fit the file");
    }
    const std::uint64_t length = trailer - footer;
    if (length > fixed + kMaxTotalsBytes) fail(trailer, "the footer is longer than its groups and totals allow");
    const Bytes bytes = pread_bytes(footer, length);
    const std::size_t hash_at = bytes.size() - 8;
    if (xxh3(bytes.data(), hash_at) != load_u64(&bytes[hash_at]))
      fail(footer + hash_at, "the hash of the footer is wrong");
    if (load_u64(bytes.data()) != header.groups) fail(footer, "header and footer differ in the number of groups");
    read_index(bytes);
    const std::size_t totals_at = static_cast<std::size_t>(8 + 8 * header.groups);
    const std::uint64_t totals_length = load_u32(&bytes[totals_at]);
    if (totals_length != length - fixed) fail(footer + totals_at, "the length of the totals does not fit the footer");
    try {
      totals = totals_from_json(
          {reinterpret_cast<const char*>(&bytes[totals_at + 4]), static_cast<std::size_t>(totals_length)});
    } catch (const Malformed& fault) {
      fail(footer + totals_at + 4, std::string("totals: ") + fault.what());
    }
    content_end = footer + hash_at - 8;
    content_hash = hex(load_u64(&bytes[hash_at - 8]));
  }

  // Chunks must be contiguous between header and footer.
  void read_index(const Bytes& bytes) {
    offsets.reserve(static_cast<std::size_t>(header.groups) + 1);
    for (std::uint64_t i = 0; i < header.groups; ++i) {
      const std::uint64_t place = 8 + 8 * i;
      const std::uint64_t offset = load_u64(&bytes[static_cast<std::size_t>(place)]);
      const bool in_order = i == 0 ? offset == chunks_begin : offset > offsets.back() + kChunkPreambleBytes;
      if (!in_order || offset > footer || footer - offset <= kChunkPreambleBytes) {
        fail(footer + place, "the offset of group " + std::to_string(i) + " is out of order");
      }
      offsets.push_back(offset);
    }
    if (header.groups == 0 && footer != chunks_begin)
      fail(chunks_begin, "bytes between header and footer belong to no group");
    offsets.push_back(footer);
  }

  std::string path;
  int descriptor = -1;
  std::uint64_t size = 0;
  std::uint64_t chunks_begin = 0;
  std::uint64_t footer = 0;
  std::uint64_t content_end = 0;  ///< bytes that the content hash covers
  Header header;
  Totals totals;
  std::string content_hash;
  std::vector<std::uint64_t> offsets;  ///< file offsets of the chunks, then of the footer
};

Reader::Reader(const std::string& path) : impl_(std::make_unique<Impl>(path)) { impl_->open(); }
Reader::~Reader() = default;

const Header& Reader::header() const { return impl_->header; }
const Totals& Reader::totals() const { return impl_->totals; }
const std::string& Reader::path() const { return impl_->path; }
std::uint64_t Reader::bytes() const { return impl_->size; }
const std::string& Reader::content_hash() const { return impl_->content_hash; }
std::uint64_t Reader::group_count() const { return impl_->header.groups; }

void Reader::read(std::uint64_t index, RayGroup& group) const {
  const Impl& impl = *impl_;
  if (index >= impl.header.groups) throw std::out_of_range("trace group " + std::to_string(index));
  const std::uint64_t offset = impl.offsets[static_cast<std::size_t>(index)];
  const std::uint64_t size = impl.offsets[static_cast<std::size_t>(index) + 1] - offset;
  thread_local Bytes chunk;
  chunk.resize(static_cast<std::size_t>(size));
  impl.pread_exactly(offset, chunk.data(), chunk.size());
  const std::string group_name = "group " + std::to_string(index) + ": ";
  const std::size_t payload = chunk.size() - kChunkPreambleBytes;
  if (load_u32(chunk.data()) != payload) impl.fail(offset, group_name + "the chunk length differs from the index");
  if (xxh3(chunk.data() + kChunkPreambleBytes, payload) != load_u64(chunk.data() + 4)) {
    impl.fail(offset + 4, group_name + "the hash of the chunk is wrong");
  }
  try {
    decode_group(impl.header, chunk.data() + kChunkPreambleBytes, payload, index, group);
    group.frame = impl.header.frame_of(index);
  } catch (const Malformed& fault) {
    impl.fail(offset + kChunkPreambleBytes, group_name + fault.what());
  }
}

void Reader::verify_content() const {
  const Impl& impl = *impl_;
  constexpr std::uint64_t kBlock = std::uint64_t{1} << 20;
  Bytes block(static_cast<std::size_t>(std::min(kBlock, impl.content_end)));
  StreamHash hash;
  for (std::uint64_t offset = 0; offset < impl.content_end;) {
    const std::uint64_t count = std::min<std::uint64_t>(block.size(), impl.content_end - offset);
    impl.pread_exactly(offset, block.data(), static_cast<std::size_t>(count));
    hash.add(block.data(), static_cast<std::size_t>(count));
    offset += count;
  }
  if (hex(hash.value()) != impl.content_hash) impl.fail(impl.content_end, "the content hash of the file is wrong");
}

}  // namespace grtx::traces
