// SPDX-License-Identifier: Apache-2.0
// Chrome trace-event JSON (the format of chrome://tracing, read by ui.perfetto.dev).
#include <fmt/format.h>

#include <iterator>
#include <nlohmann/json.hpp>

#include "grtx/base/json.h"
#include "grtx/rtl_tlm/observe/trace_event_format.h"

namespace grtx::sim {
namespace {

std::string json_text(std::string_view text) { return grtx::json_text(nlohmann::json(text)); }

class TraceEventJson final : public TraceEventFormat {
 public:
  void head(const Metadata& metadata, std::string& out) override {
    out += "{\"displayTimeUnit\": \"ns\", \"otherData\": {\"time\": \"1 us is 1 core cycle\"";
    for (const auto& [name, value] : metadata) out += ", " + json_text(name) + ": " + json_text(value);
    out +=
        "},\n\"traceEvents\": [\n{\"ph\": \"M\", \"pid\": 0, \"tid\": 0, \"ts\": 0, \"name\": \"process_name\", "
        "\"args\": {\"name\": \"gpu\"}}";
  }
  void process(unsigned pid, const std::string& name, std::string& out) override {
    line(out, R"({{"ph": "M", "pid": {}, "tid": 0, "ts": 0, "name": "process_name", "args": {{"name": {}}}}})", pid,
         json_text(name));
    line(out,
         R"({{"ph": "M", "pid": {}, "tid": 0, "ts": 0, "name": "process_sort_index", "args": {{"sort_index": {}}}}})",
         pid, pid);
  }
  void track(unsigned pid, unsigned tid, const std::string& name, std::string& out) override {
    line(out, R"({{"ph": "M", "pid": {}, "tid": {}, "ts": 0, "name": "thread_name", "args": {{"name": {}}}}})", pid,
         tid, json_text(name));
    line(out,
         R"({{"ph": "M", "pid": {}, "tid": {}, "ts": 0, "name": "thread_sort_index", "args": {{"sort_index": {}}}}})",
         pid, tid, tid);
  }
  void begin(unsigned pid, unsigned tid, std::uint64_t cycle, std::string_view name, const Arguments& arguments,
             std::string& out) override {
    std::string args;
    for (const auto& [key, value] : arguments) {
      args += fmt::format("{}{}: {}", args.empty() ? R"(, "args": {)" : ", ", json_text(key), value);
    }
    if (!args.empty()) args += '}';
    line(out, R"({{"ph": "B", "pid": {}, "tid": {}, "ts": {}, "name": {}{}}})", pid, tid, cycle, json_text(name), args);
  }
  void end(unsigned pid, unsigned tid, std::uint64_t cycle, std::string& out) override {
    line(out, R"({{"ph": "E", "pid": {}, "tid": {}, "ts": {}}})", pid, tid, cycle);
  }
  void counter(unsigned pid, std::uint64_t cycle, std::string_view name, const Series& series,
               std::string& out) override {
    std::string values;
    for (const auto& [key, value] : series)
      values += fmt::format("{}{}: {}", values.empty() ? "" : ", ", json_text(key), value);
    line(out, R"({{"ph": "C", "pid": {}, "tid": 0, "ts": {}, "name": {}, "args": {{{}}}}})", pid, cycle,
         json_text(name), values);
  }
  void tail(std::string& out) override { out += "\n]}\n"; }

 private:
  template <typename... Values>
  static void line(std::string& out, fmt::format_string<Values...> form, Values&&... values) {
    out += ",\n";
    fmt::format_to(std::back_inserter(out), form, std::forward<Values>(values)...);
  }
};

}  // namespace

std::unique_ptr<TraceEventFormat> make_trace_event_json() { return std::make_unique<TraceEventJson>(); }

}  // namespace grtx::sim
