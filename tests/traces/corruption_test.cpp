// SPDX-License-Identifier: Apache-2.0
// A damaged file is refused with file, place and rule, whatever byte is hit; it never crashes and never passes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/base/hash.h"
#include "grtx/traces/byte_stream.h"
#include "grtx/traces/check.h"
#include "grtx/traces/codec/columns.h"
#include "grtx/traces/codec/file_layout.h"
#include "grtx/traces/reader.h"
#include "traces/random_group.h"
#include "traces/temporary_file.h"

namespace grtx::traces {
namespace {

using ::testing::HasSubstr;
using testing::TemporaryFile;

std::string small_file() {
  testing::RandomOptions options{.groups = 2, .warp_size = 3, .two_level = true};
  const auto trace = testing::random_trace(options);
  const testing::TraceFile file(trace.header, trace.groups);
  return read_file(file.path());
}

// The rule that reading everything breaks; "" when nothing does.
std::string fault_of(const std::string& content, std::string* place = nullptr) {
  const TemporaryFile file;
  write_file(file.path(), content);
  try {
    const Reader reader(file.path());
    RayGroup group;
    for (std::uint64_t i = 0; i < reader.group_count(); ++i) reader.read(i, group);
    return "";
  } catch (const Error& error) {
    EXPECT_EQ(error.file(), file.path());
    if (place != nullptr) *place = error.place();
    return error.rule();
  }
}

TEST(Corruption, TheFileItselfIsSound) { EXPECT_EQ(fault_of(small_file()), ""); }

TEST(Corruption, EverySingleByte) {
  const std::string sound = small_file();
  for (const int flip : {0x01, 0x80}) {
    for (std::size_t i = 0; i < sound.size(); ++i) {
      std::string damaged = sound;
      damaged[i] = static_cast<char>(damaged[i] ^ flip);
      std::string place;
      EXPECT_NE(fault_of(damaged, &place), "") << "byte " << i << " of " << sound.size();
      EXPECT_THAT(place, HasSubstr("byte "));
    }
  }
}

TEST(Corruption, EveryTruncation) {
  const std::string sound = small_file();
  for (std::size_t length = 0; length < sound.size(); ++length) {
    EXPECT_NE(fault_of(sound.substr(0, length)), "") << "cut to " << length << " of " << sound.size();
  }
}

TEST(Corruption, BytesBehindTheEnd) { EXPECT_NE(fault_of(small_file() + "x"), ""); }

TEST(Corruption, NamesMagicAndVersion) {
  std::string place;
  std::string other = small_file();
  other[1] = 'X';
  EXPECT_THAT(fault_of(other, &place), HasSubstr("is not a GRTX trace"));
  EXPECT_EQ(place, "byte 0");
  other = small_file();
  other[8] = 1;
  EXPECT_EQ(fault_of(other, &place), "has format version 1; this program reads versions 4 to 14 and 16");
  EXPECT_EQ(place, "byte 8");
  other[8] = 15;
  EXPECT_EQ(fault_of(other, &place),
            "has format version 15, of --warp-beam, which was removed; this program reads versions 4 to 14 and 16");
  EXPECT_EQ(place, "byte 8");
  EXPECT_THAT(fault_of("ply\nformat ascii 1.0\n"), HasSubstr("is not a GRTX trace"));
  EXPECT_THAT(fault_of(""), HasSubstr("is not a GRTX trace"));
}

TEST(Corruption, MissingFileAndFolder) {
  EXPECT_THROW(Reader("/nonexistent-folder/t.grtx"), Error);
  EXPECT_THROW(Reader("/"), Error);
}

// Files whose hashes are right but whose content is not: made by a faulty or hostile writer.
class Forgery {
 public:
  Forgery() : content_(small_file()) {}

  std::uint64_t footer() const { return number(content_.size() - kTrailerBytes); }
  std::uint64_t chunk(std::uint64_t index) const { return number(footer() + 8 + 8 * index); }
  std::string& content() { return content_; }

  void replace_header(const std::function<std::string(std::string)>& change) {
    const std::size_t length = number(12) & 0xFFFFFFFF;
    const std::string json = change(content_.substr(kPreambleBytes, length));
    ASSERT_EQ(json.size(), length) << "the forgery keeps all offsets";
    content_.replace(kPreambleBytes, length, json);
    put(16, xxh3(json));
    seal();
  }
  void replace_text_in_footer(const std::string& from, const std::string& to) {
    ASSERT_EQ(from.size(), to.size());
    const std::size_t at = content_.find(from, footer());
    ASSERT_NE(at, std::string::npos);
    content_.replace(at, from.size(), to);
    seal();
  }
  void put(std::size_t at, std::uint64_t value) {
    Bytes bytes;
    put_u64(bytes, value);
    std::copy(bytes.begin(), bytes.end(), content_.begin() + static_cast<std::ptrdiff_t>(at));
  }
  // Content hash and footer hash.
  void seal() {
    const std::size_t footer_hash = content_.size() - kTrailerBytes - 8;
    put(footer_hash - 8, xxh3(content_.data(), footer_hash - 8));
    seal_footer();
  }
  void seal_footer() {
    const std::size_t footer_hash = content_.size() - kTrailerBytes - 8;
    put(footer_hash, xxh3(content_.data() + footer(), footer_hash - footer()));
  }

 private:
  std::uint64_t number(std::uint64_t at) const {
    return load_u64(reinterpret_cast<const std::uint8_t*>(content_.data()) + at);
  }
  std::string content_;
};

TEST(Forgery, UnknownHeaderKey) {
  Forgery forgery;
  forgery.replace_header([](std::string json) { return json.replace(json.find("\"accel\""), 7, "\"axcel\""); });
  EXPECT_THAT(fault_of(forgery.content()), HasSubstr("key 'accel' is missing"));
  forgery = Forgery();
  forgery.replace_header([](std::string json) {
    const std::size_t at = json.find("\"child_order\":\"near_first\"");
    return json.replace(at, 26, "\"child_order\":\"slot\",\"x\":1");
  });
  EXPECT_THAT(fault_of(forgery.content()), HasSubstr("key 'x' is unknown"));
}

TEST(Forgery, UnknownModeNamesTheKnownOnes) {
  Forgery forgery;
  forgery.replace_header([](std::string json) { return json.replace(json.find("near_first"), 10, "near_fist_"); });
  EXPECT_THAT(
      fault_of(forgery.content()),
      HasSubstr("key 'child_order' must be one of near_first, slot, vulkan_sim, not 'near_fist_'; the nearest is "
                "'near_first'"));
}

TEST(Forgery, HeaderValueOutOfRange) {
  Forgery forgery;
  forgery.replace_header(
      [](std::string json) { return json.replace(json.find("\"bvh_width\":6"), 13, "\"bvh_width\":9"); });
  EXPECT_THAT(fault_of(forgery.content()), HasSubstr("bvh_width must be 2..8"));
  forgery = Forgery();
  forgery.replace_header([](std::string json) { return json.replace(json.find("\"k\":4"), 5, "\"k\":-"); });
  EXPECT_THAT(fault_of(forgery.content()), HasSubstr("is not valid JSON"));
}

TEST(Forgery, GroupCountsDiffer) {
  Forgery forgery;
  forgery.replace_header([](std::string json) { return json.replace(json.find("\"groups\":2"), 10, "\"groups\":1"); });
  EXPECT_NE(fault_of(forgery.content()), "");
}

TEST(Forgery, ChunkOffsetOutOfOrder) {
  for (const std::uint64_t wrong : {std::uint64_t{0}, std::uint64_t{1} << 63, ~std::uint64_t{0}}) {
    Forgery forgery;
    forgery.put(forgery.footer() + 16, wrong);
    forgery.seal();
    EXPECT_THAT(fault_of(forgery.content()), HasSubstr("offset of group 1 is out of order"));
  }
}

TEST(Forgery, SwappedGroupIndex) {
  // The group index stands first in the first column, which is stored as is behind the column table.
  Forgery forgery;
  const std::uint64_t begin = forgery.chunk(1);
  const std::uint64_t payload = begin + kChunkPreambleBytes;
  const std::size_t length = forgery.footer() - payload;
  std::string& content = forgery.content();
  ByteReader table(reinterpret_cast<const std::uint8_t*>(content.data()) + payload, length, "table");
  for (std::size_t i = 0; i < 2 * kColumnsWithoutBins; ++i) table.varint();
  content[payload + length - table.remaining()] = 0;
  forgery.put(begin + 4, xxh3(content.data() + payload, length));
  forgery.seal();
  EXPECT_THAT(fault_of(forgery.content()), HasSubstr("index of another group"));
}

TEST(Forgery, TotalsThatTheGroupsDoNotGive) {
  Forgery forgery;
  const TemporaryFile file;
  forgery.replace_text_in_footer("\"overflows\":0", "\"overflows\":7");
  EXPECT_EQ(fault_of(forgery.content()), "");  // only counting can tell
  write_file(file.path(), forgery.content());
  const Reader reader(file.path());
  try {
    check(reader, true);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.place(), "totals overflows");
    EXPECT_EQ(error.rule(), "stored as 7, but the groups give 0");
  }
}

TEST(Forgery, ContentHashOfAnotherFile) {
  Forgery forgery;
  const TemporaryFile file;
  forgery.put(forgery.content().size() - kTrailerBytes - 16, 12345);
  forgery.seal_footer();
  write_file(file.path(), forgery.content());
  const Reader reader(file.path());
  EXPECT_EQ(reader.content_hash(), "0000000000003039");
  EXPECT_THROW(check(reader, true), Error);
}

}  // namespace
}  // namespace grtx::traces
