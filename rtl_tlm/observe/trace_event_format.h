// SPDX-License-Identifier: Apache-2.0
// How the events of a timeline become bytes: Chrome's JSON, Perfetto's protobuf, or a picture. One core cycle is 1 us
// in the first two.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace grtx::sim {

class TraceEventFormat {
 public:
  using Arguments = std::vector<std::pair<std::string_view, std::uint64_t>>;
  using Series = std::vector<std::pair<std::string_view, double>>;
  using Metadata = std::vector<std::pair<std::string, std::string>>;

  virtual ~TraceEventFormat() = default;
  // Each appends to `out`. process: from 1. track: from 1, distinct over all processes.
  virtual void head(const Metadata& metadata, std::string& out) = 0;
  virtual void process(unsigned process, const std::string& name, std::string& out) = 0;
  virtual void track(unsigned process, unsigned track, const std::string& name, std::string& out) = 0;
  virtual void begin(unsigned process, unsigned track, std::uint64_t cycle, std::string_view name,
                     const Arguments& arguments, std::string& out) = 0;
  virtual void end(unsigned process, unsigned track, std::uint64_t cycle, std::string& out) = 0;
  virtual void counter(unsigned process, std::uint64_t cycle, std::string_view name, const Series& series,
                       std::string& out) = 0;
  virtual void tail(std::string& out) = 0;
};

/// Chrome trace-event JSON.
std::unique_ptr<TraceEventFormat> make_trace_event_json();
/// Perfetto's protobuf (perfetto/protos/perfetto/trace/trace.proto).
std::unique_ptr<TraceEventFormat> make_perfetto_format();
/// An SVG of what each track did most, without counters.
std::unique_ptr<TraceEventFormat> make_timeline_picture();
/// By the end of the file's name: .pftrace, .svg, else .json or none. Throws Error for any other.
std::unique_ptr<TraceEventFormat> make_format_of(const std::string& path);

}  // namespace grtx::sim
