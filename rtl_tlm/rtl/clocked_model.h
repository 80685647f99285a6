// A Verilated block under its clock: the pins of a Verilog module, edges and reset. What a bridge from a unit's
// interface to pins stands on; docs/model/rtl_bridge.md is its reference, examples/own_rtl.cpp its template.
// Needs nothing of Verilator: the class that is put in does.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <type_traits>

namespace grtx::sim {

/// Bits at..at + width - 1 (width <= 64) of an input pin, however wide it is.
template <typename Pin>
void put_bits(Pin& pin, unsigned at, unsigned width, std::uint64_t value) {
  if constexpr (std::is_integral_v<Pin>) {
    const std::uint64_t mask = (width < 64 ? std::uint64_t{1} << width : 0) - 1;
    pin = static_cast<Pin>((pin & ~(mask << at)) | ((value & mask) << at));
  } else {  // words of 32 bits
    for (unsigned done = 0; done < width;) {
      const unsigned low = (at + done) % 32, bits = std::min(32 - low, width - done);
      put_bits(pin[(at + done) / 32], low, bits, value >> done);
      done += bits;
    }
  }
}

/// The same of an output pin.
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

/// Model: what Verilator made of a module with the inputs clk and rst. Set inputs, settle(), read outputs, edge().
template <typename Model>
class ClockedModel {
 public:
  explicit ClockedModel(const char* name) : model_(new Model(name)) {}
  ~ClockedModel() { model_->final(); }
  ClockedModel(const ClockedModel&) = delete;
  ClockedModel& operator=(const ClockedModel&) = delete;

  Model* operator->() const { return model_.get(); }
  Model& pins() const { return *model_; }
  /// Outputs follow inputs.
  void settle() {
    model_->eval();
    low_ = true;
  }
  /// The rising edge, with the inputs as they are. Outputs then show the new state with these inputs.
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
  bool low_ = false;  ///< the block has seen the clock low since the last edge
  std::uint64_t edges_ = 0;
};

}  // namespace grtx::sim
