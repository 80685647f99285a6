// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/tlm/link_to_tlm.h"

#include <algorithm>
#include <ostream>

#include "grtx/modules/kernel/unit_fault.h"
#include "grtx/modules/tlm/at_payload_attributes.h"
#include "grtx/modules/tlm/at_payload_pool.h"

namespace grtx::modules {

LinkToTlm::~LinkToTlm() = default;

LinkToTlm::LinkToTlm(const sc_core::sc_module_name& name, const Config& config, ClockDomain& clock)
    : ClockedModule(name, clock),
      request("request"),
      response("response"),
      memory("memory", clock),
      config_(config),
      slots_(config.outstanding),
      pool_(std::make_unique<AtPayloadPool>()) {
  free_all();
  memory.keep_data();
  if (config_.blocking) SC_THREAD(call);
}

void LinkToTlm::end_of_elaboration() {
  request->wake(&alarm_);
  memory.wake(&alarm_);
}

void LinkToTlm::restart(Caches) {
  if (calling_) unit_fault(name(), "a restart inside of b_transport");
  memory.restart();
  free_all();
  returned_.clear();
  next_call_ = 0;
  requests_ = 0;
}

void LinkToTlm::free_all() {
  free_.clear();
  for (unsigned i = config_.outstanding; i > 0; --i) free_.push_back(i - 1);
}

Cycle LinkToTlm::tick(Cycle now) {
  memory.update(now);
  take_completion(now);
  send(now);
  Cycle next = memory.next_visible();
  if (!returned_.empty()) next = std::min(next, returned_.begin()->first);
  if (!free_.empty() && !calling_) {
    const Cycle can = config_.blocking ? next_call_ : memory.next_send();
    if (can != kNever) next = std::min(next, std::max(can, request->next_visible()));
  }
  return next;
}

bool LinkToTlm::answer(Cycle now, std::uint32_t slot) {
  if (!response->can_push(now)) return false;
  response->push(now, response_to(slots_[slot]));
  free_.push_back(slot);
  return true;
}

// One response per cycle.
void LinkToTlm::take_completion(Cycle now) {
  if (const AtInitiator::Completion* completion = memory.front(now); completion != nullptr) {
    if (!completion->ok()) memory.report_refusal(*completion);
    if (answer(now, completion->context)) memory.pop();
  } else if (!returned_.empty() && returned_.begin()->first <= now) {
    if (answer(now, returned_.begin()->second)) returned_.erase(returned_.begin());
  }
}

void LinkToTlm::send(Cycle now) {
  const MemoryRequest* head = request->front(now);
  if (head == nullptr || free_.empty()) return;
  if (config_.blocking ? calling_ || next_call_ > now : !memory.can_send(now)) return;
  const std::uint32_t slot = free_.back();
  free_.pop_back();
  slots_[slot] = *head;
  request->pop(now);
  ++requests_;
  if (!config_.blocking) return memory.send(slots_[slot].address, kSectorBytes, slots_[slot].write, slot);
  calling_ = true;
  calling_slot_ = slot;
  called_.notify(clock_.ahead_of_kernel());
}

// An SC_THREAD, because the target's b_transport may call wait().
void LinkToTlm::call() {
  while (true) {
    wait(called_);
    const MemoryRequest& head = slots_[calling_slot_];
    AtPayload& payload = pool_->acquire();
    set_attributes(payload, head.address, kSectorBytes, head.write);
    if (head.write) memory.fill(payload);
    sc_core::sc_time delay = sc_core::SC_ZERO_TIME;
    memory.socket->b_transport(payload, delay);
    if (!payload.is_response_ok()) {
      memory.report_refusal({calling_slot_, head.write, payload.get_response_status(), head.address, 0});
    }
    payload.release();
    const Cycle visible = clock_.edge_after(delay.value());
    returned_.emplace(visible, calling_slot_);
    calling_ = false;
    next_call_ = clock_.edge_after();
    alarm_.request(std::min(visible, next_call_));
  }
}

void LinkToTlm::dump_state(std::ostream& out) const {
  out << name() << ": " << slots_.size() - free_.size() << " requests under way, outstanding in the memory "
      << memory.outstanding() << (calling_ ? ", inside b_transport" : "") << '\n';
}

}  // namespace grtx::modules
