// SPDX-License-Identifier: Apache-2.0
// Ignorable TLM-2.0 extension with the SM and region that a transaction is for. Base-protocol targets may ignore it.
#pragma once

#include <tlm>

#include "grtx/modules/messages/memory_request.h"

namespace grtx::modules {

class OriginExtension final : public ::tlm::tlm_extension<OriginExtension> {
 public:
  RequestOrigin origin;

  ::tlm::tlm_extension_base* clone() const override { return new OriginExtension(*this); }
  void copy_from(const ::tlm::tlm_extension_base& other) override {
    origin = static_cast<const OriginExtension&>(other).origin;
  }
};

/// Origin of a payload; a default RequestOrigin (kNobody) if it has no such extension.
inline RequestOrigin origin_of(const ::tlm::tlm_generic_payload& payload) {
  const auto* extension = payload.get_extension<OriginExtension>();
  return extension != nullptr ? extension->origin : RequestOrigin();
}

}  // namespace grtx::modules
