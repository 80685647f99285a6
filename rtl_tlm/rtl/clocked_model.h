// SPDX-License-Identifier: Apache-2.0
// A Verilated block with its clock: pins, clock edges and reset. The basis of bridges from a unit's interface to pins;
// docs/model/rtl_bridge.md is the reference, examples/own_rtl.cpp a template.
// Does not depend on Verilator itself; only the class passed as Model does.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <type_traits>

namespace grtx::sim {

/// Sets bits at..at + width - 1 (width <= 64) of an input pin of any width.
template <typename Pin>
void put_bits(Pin& pin, unsigned at, unsigned width, std::uint64_t value) {
  if constexpr (std::is_integral_v<Pin>) {
    const std::uint64_t mask = (width < 64 ? std::uint64_t{1} << width : 0) - 1;
    pin = static_cast<Pin>((pin & ~(mask << at)) | ((value & mask) << at));
  } else {  // wide pins are arrays of 32-bit words
    for (unsigned done = 0; done < width;) {
      const unsigned low = (at + done) % 32, bits = std::min(32 - low, width - done);
      put_bits(pin[(at + done) / 32], low, bits, value >> done);
      done += bits;
    }
  }
}

/// Reads bits at..at + width - 1 (width <= 64) of an output pin of any width.
template <typename Pin>
std::uint64_t get_bits(const Pin& pin, unsigned at, unsigned width) {
  if constexpr (std::is_integral_v<Pin>) {
    const std::uint64_t mask = (width < 64 ? std::uint64_t{1} << width : 0) - 1;
    return static_cast<std::uint64_t>(pin) >> at & mask;
  } else {
    std::uint64_t value = 0;
    for (unsigned done = 0; done < width;) {
      const unsigned low = (at + done) % 32, bits = std::min(32 - low, width - done);
      value |= get_bits(pin[(at + done) / 32], low, bits) << done;
      done += bits;
    }
    return value;
  }
}

/// Model: the class that Verilator generated for a module with inputs clk and rst. Per cycle: set inputs, settle(),
/// read outputs, edge().
template <typename Model>
class ClockedModel {
 public:
  explicit ClockedModel(const char* name) : model_(new Model(name)) {}
  ~ClockedModel() { model_->final(); }
  ClockedModel(const ClockedModel&) = delete;
  ClockedModel& operator=(const ClockedModel&) = delete;

  Model* operator->() const { return model_.get(); }
  Model& pins() const { return *model_; }
  /// Evaluates combinational logic: outputs follow inputs.
  void settle() {
    model_->eval();
    low_ = true;
  }
  /// A rising clock edge with the current inputs. Outputs then show the new state with these inputs.
  void edge() {
    if (!low_) settle();
    model_->clk = 1;
    model_->eval();
    model_->clk = 0;
    low_ = false;
    ++edges_;
  }
  /// Two edges with rst high.
  void reset() {
    model_->clk = 0;
    model_->rst = 1;
    for (int i = 0; i < 2; ++i) {
      settle();
      edge();
    }
    model_->rst = 0;
    settle();
  }
  std::uint64_t edges() const { return edges_; }

 private:
  std::unique_ptr<Model> model_;
  bool low_ = false;  ///< the block has been evaluated with the clock low since the last edge
  std::uint64_t edges_ = 0;
};

}  // namespace grtx::sim
