// SPDX-License-Identifier: Apache-2.0
// Perfetto's trace packets in protobuf's wire format: the few fields of trace_packet.proto, track_event.proto,
// track_descriptor.proto and interned_data.proto that slices and counters need. Numbers are those of the fields there.
#include <bit>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <utility>

#include "grtx/rtl_tlm/observe/trace_event_format.h"

namespace grtx::sim {
namespace {

/// A message of protobuf.
class Message {
 public:
  void number(unsigned field, std::uint64_t value) {
    varint(std::uint64_t{field} << 3);
    varint(value);
  }
  void real(unsigned field, double value) {
    varint(std::uint64_t{field} << 3 | 1);
    const auto bits = std::bit_cast<std::uint64_t>(value);
    for (unsigned byte = 0; byte < 8; ++byte) bytes_ += static_cast<char>(bits >> (8 * byte) & 0xFF);
  }
  void text(unsigned field, std::string_view value) {
    varint(std::uint64_t{field} << 3 | 2);
    varint(value.size());
    bytes_ += value;
  }
  void message(unsigned field, const Message& inner) { text(field, inner.bytes_); }
  const std::string& bytes() const { return bytes_; }

 private:
  void varint(std::uint64_t value) {
    for (; value >= 0x80; value >>= 7) bytes_ += static_cast<char>((value & 0x7F) | 0x80);
    bytes_ += static_cast<char>(value);
  }
  std::string bytes_;
};

constexpr std::uint64_t kNanoseconds = 1000;  // of a core cycle, as the JSON shows it
constexpr unsigned kSequence = 1;
enum : unsigned { kSliceBegin = 1, kSliceEnd = 2, kInstant = 3, kCounter = 4 };
constexpr std::uint64_t kGpu = 1;  // uuid of the track of the whole

// Small numbers, which take few bytes; none is kGpu, as processes and tracks begin at 1.
std::uint64_t uuid_of_process(unsigned process) { return std::uint64_t{process} * 4 + 1; }
std::uint64_t uuid_of_track(unsigned track) { return std::uint64_t{track} * 4 + 2; }

class PerfettoFormat final : public TraceEventFormat {
 public:
  void head(const Metadata& metadata, std::string& out) override {
    Message gpu;
    gpu.number(1, kGpu);
    gpu.text(2, "gpu");
    descriptor(gpu, out);
    Message event = track_event(kInstant, kGpu);
    event.text(23, "grtx sim");
    const auto note = [&event](const std::string& name, const std::string& value) {
      Message annotation;  // DebugAnnotation: name, string_value
      annotation.text(10, name);
      annotation.text(6, value);
      event.message(4, annotation);
    };
    note("time", "1 us is 1 core cycle");
    for (const auto& [name, value] : metadata) note(name, value);
    packet(0, event, {}, out);
  }
  void process(unsigned process, const std::string& name, std::string& out) override {
    Message of;  // ProcessDescriptor: pid, process_name
    of.number(1, process);
    of.text(6, name);
    Message track;
    track.number(1, uuid_of_process(process));
    track.text(2, name);
    track.message(3, of);
    descriptor(track, out);
  }
  void track(unsigned process, unsigned number, const std::string& name, std::string& out) override {
    Message of;  // ThreadDescriptor: pid, tid, thread_name
    of.number(1, process);
    of.number(2, number);
    of.text(5, name);
    Message track;
    track.number(1, uuid_of_track(number));
    track.text(2, name);
    track.message(4, of);
    track.number(5, uuid_of_process(process));
    descriptor(track, out);
  }
  void begin(unsigned, unsigned track, std::uint64_t cycle, std::string_view name, const Arguments& arguments,
             std::string& out) override {
    Message interned;
    Message event = track_event(kSliceBegin, uuid_of_track(track));
    event.number(10, iid(names_, 2, name, interned));
    for (const auto& [key, value] : arguments) {
      Message annotation;  // DebugAnnotation: name_iid, uint_value
      annotation.number(1, iid(keys_, 3, key, interned));
      annotation.number(3, value);
      event.message(4, annotation);
    }
    packet(cycle, event, interned, out);
  }
  void end(unsigned, unsigned track, std::uint64_t cycle, std::string& out) override {
    packet(cycle, track_event(kSliceEnd, uuid_of_track(track)), {}, out);
  }
  void counter(unsigned process, std::uint64_t cycle, std::string_view name, const Series& series,
               std::string& out) override {
    for (const auto& [key, value] : series) {
      const std::string whole = series.size() == 1 ? std::string(name) : std::string(name) + ", " + std::string(key);
      const auto [known, is_new] = counters_.try_emplace({process, whole}, (counters_.size() + 1) * 4 + 3);
      if (is_new) {
        Message of;  // CounterDescriptor: unit_name
        of.text(6, key);
        Message track;
        track.number(1, known->second);
        track.text(2, whole);
        track.number(5, uuid_of_process(process));
        track.message(8, of);
        descriptor(track, out);
      }
      Message event = track_event(kCounter, known->second);
      event.real(44, value);
      packet(cycle, event, {}, out);
    }
  }
  void tail(std::string&) override {}

 private:
  static Message track_event(unsigned type, std::uint64_t track) {
    Message event;
    event.number(9, type);
    event.number(11, track);
    return event;
  }
  /// A packet is field 1 of the trace.
  static void add(const Message& packet, std::string& out) {
    Message trace;
    trace.message(1, packet);
    out += trace.bytes();
  }
  static void descriptor(const Message& track, std::string& out) {
    Message packet;
    packet.number(10, kSequence);
    packet.message(60, track);
    add(packet, out);
  }
  void packet(std::uint64_t cycle, const Message& event, const Message& interned, std::string& out) {
    constexpr unsigned kCleared = 1, kNeeded = 2;  // sequence_flags of incremental state, which the names are
    Message packet;
    packet.number(8, cycle * kNanoseconds);
    packet.number(10, kSequence);
    packet.number(13, begun_ ? kNeeded : kCleared | kNeeded);
    begun_ = true;
    packet.message(11, event);
    if (!interned.bytes().empty()) packet.message(12, interned);
    add(packet, out);
  }
  /// Number of a name, which the packet that first uses it declares in `field` of its interned data.
  static std::uint64_t iid(std::map<std::string, std::uint64_t, std::less<>>& known, unsigned field,
                           std::string_view name, Message& interned) {
    if (const auto found = known.find(name); found != known.end()) return found->second;
    const std::uint64_t number = known.size() + 1;
    known.emplace(name, number);
    Message entry;
    entry.number(1, number);
    entry.text(2, name);
    interned.message(field, entry);
    return number;
  }

  bool begun_ = false;
  std::map<std::string, std::uint64_t, std::less<>> names_, keys_;
  std::map<std::pair<unsigned, std::string>, std::uint64_t> counters_;
};

}  // namespace

std::unique_ptr<TraceEventFormat> make_perfetto_format() { return std::make_unique<PerfettoFormat>(); }

}  // namespace grtx::sim
