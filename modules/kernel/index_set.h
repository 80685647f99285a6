// SPDX-License-Identifier: Apache-2.0
// A bit set of small numbers, for example the ports of a module that have work.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace grtx::modules {

class IndexSet {
 public:
  /// An empty set of numbers below `size`.
  explicit IndexSet(unsigned size) : words_((size + 63) / 64) {}

  void insert(unsigned i) { words_[i / 64] |= std::uint64_t{1} << i % 64; }
  void erase(unsigned i) { words_[i / 64] &= ~(std::uint64_t{1} << i % 64); }
  void clear() { std::fill(words_.begin(), words_.end(), 0); }
  bool contains(unsigned i) const { return (words_[i / 64] >> i % 64 & 1) != 0; }
  /// The word whose bit i % 64 stands for number `i`. Its address stays valid for the lifetime of the set.
  std::uint64_t* word_of(unsigned i) { return &words_[i / 64]; }

  /// Calls f(number) for each number, lowest first. f may insert and erase; whether this call sees that is unspecified.
  template <typename F>
  void for_each(F&& f) const {
    for (std::size_t word = 0; word < words_.size(); ++word) for_each_bit_of(word, words_[word], f);
  }
  /// The same, beginning with number `first` and going once around.
  template <typename F>
  [[gnu::always_inline]] void for_each_from(unsigned first, F&& f) const {
    // Of several words, that of `first` is visited twice: the numbers from `first` on at the start, those before it at
    // the end. A single word is rotated. f stands here once, so that the compiler inlines it.
    const auto rotation = static_cast<int>(words_.size() == 1 ? first : 0);
    const std::uint64_t before = (std::uint64_t{1} << first % 64) - 1;
    std::size_t left = words_.size() == 1 ? 0 : words_.size();
    std::size_t word = first / 64;
    std::uint64_t bits = left == 0 ? std::rotr(words_[0], rotation) : words_[word] & ~before;
    for (;;) {
      for (; bits != 0; bits &= bits - 1) {
        f(static_cast<unsigned>(word * 64 + static_cast<unsigned>(std::countr_zero(bits) + rotation) % 64));
      }
      if (left == 0) return;
      if (++word == words_.size()) word = 0;
      bits = --left == 0 ? words_[word] & before : words_[word];
    }
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
