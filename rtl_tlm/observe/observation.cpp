// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/observe/observation.h"

#include <charconv>

#include "grtx/base/error.h"

namespace grtx::sim {
namespace {

bool parse_cycle(const std::string& text, Cycle& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

}  // namespace

CycleWindow parse_window(const std::string& option, const std::string& text) {
  CycleWindow window;
  const std::size_t colon = text.find(':');
  const std::string first = text.substr(0, colon);
  const std::string last = colon == std::string::npos ? "" : text.substr(colon + 1);
  const bool ok = colon != std::string::npos && (first.empty() || parse_cycle(first, window.first)) &&
                  (last.empty() || parse_cycle(last, window.last)) && window.first <= window.last;
  if (!ok) throw Error(option, text, "must be A:B in core cycles with A <= B; either may be left out");
  return window;
}

Observation::Observation(const sc_core::sc_module_name& name, modules::ClockDomain& domain, const CycleWindow& window,
                         CycleObserver& observer)
    : ClockedModule(name, domain), window_(window), observer_(observer) {
  SC_METHOD(look);
  sensitive << settled_;
  dont_initialize();
  begin();
}

Cycle Observation::tick(Cycle now) {
  if (now > window_.last) return modules::kNever;
  settled_.notify(sc_core::SC_ZERO_TIME);
  return now < window_.last && !observer_.rests() ? now + 1 : modules::kNever;
}

void Observation::look() {
  try {
    observer_.sample(clock_.cycle());
  } catch (...) {
    failure_ = std::current_exception();  // the kernel turns what a process throws into a report and loses its type
    throw;
  }
}

}  // namespace grtx::sim
