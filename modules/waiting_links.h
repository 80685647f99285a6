// Which of a module's many input links hold something: a module that is called in a busy cycle looks at few of them.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "modules/link.h"

namespace grtx::modules {

class WaitingLinks {
 public:
  explicit WaitingLinks(unsigned links) : words_((links + 63) / 64) {}

  /// Link number `i` of this module, the consumer. Neither is to move afterwards.
  template <typename T>
  void watch(unsigned i, Link<T>& link) {
    link.announce(&words_[i / 64], i % 64);
  }
  /// To be called when something was taken from link number `i`.
  template <typename T>
  void popped(unsigned i, const Link<T>& link) {
    if (link.empty()) words_[i / 64] &= ~(std::uint64_t{1} << i % 64);
  }

  /// f(number) for each that is not empty, lowest first. f may take from the link.
  template <typename F>
  void for_each(F&& f) const {
    for (std::size_t word = 0; word < words_.size(); ++word) for_each_bit_of(word, words_[word], f);
  }
  /// The same, beginning with number `first` and going once around.
  template <typename F>
  void for_each_from(unsigned first, F&& f) const {
    const std::size_t split = first / 64;
    const std::uint64_t before = (std::uint64_t{1} << first % 64) - 1;
    const std::uint64_t split_word = words_[split];
    for_each_bit_of(split, split_word & ~before, f);
    for (std::size_t word = split + 1; word < words_.size(); ++word) for_each_bit_of(word, words_[word], f);
    for (std::size_t word = 0; word < split; ++word) for_each_bit_of(word, words_[word], f);
    for_each_bit_of(split, split_word & before, f);
  }

 private:
  template <typename F>
  static void for_each_bit_of(std::size_t word, std::uint64_t bits, F&& f) {
    for (; bits != 0; bits &= bits - 1)
      f(static_cast<unsigned>(word * 64 + static_cast<unsigned>(std::countr_zero(bits))));
  }

  std::vector<std::uint64_t> words_;
};

}  // namespace grtx::modules
