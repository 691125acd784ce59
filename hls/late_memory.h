// For tests: a memory that shows words only some steps after they were written, as the memory of a pipeline may.
//
// A kernel that reads a word, works on it and writes it back, one step a clock, tells the tool how many steps lie
// between the write of a word and its next read (#pragma HLS dependence ... distance). The tool relies on that. This
// memory puts it to the test: it holds back what was written for as long as the statement allows, and the results must
// be the same. Call late_memory_step() before each step, to count it. Included by types.h.
#ifndef SELFPROJ_HLS_LATE_MEMORY_H
#define SELFPROJ_HLS_LATE_MEMORY_H

#include <array>
#include <cstdint>
#include <deque>
#include <vector>

namespace selfproj {
namespace hls {

inline std::int64_t& late_memory_clock() {
  static std::int64_t clock = 0;
  return clock;
}

inline void late_memory_step() { ++late_memory_clock(); }

template <typename T, int Words>
class Memory {
 public:
  class Word {
   public:
    Word(Memory& memory, int address) : memory_(memory), address_(address) {}
    operator T() const { return memory_.read(address_); }  // NOLINT: like an element of an array
    Word& operator=(const T& value) {
      memory_.write(address_, value);
      return *this;
    }

   private:
    Memory& memory_;
    int address_;
  };

  Word operator[](int address) { return Word(*this, address); }

 private:
  struct Late {
    std::int64_t clock;
    int address;
    T value;
  };

  T read(int address) {
    settle();
    return words_[static_cast<std::size_t>(address)];
  }
  void write(int address, const T& value) {
    settle();
    late_.push_back({late_memory_clock(), address, value});
  }
  void settle() {
    while (!late_.empty() && late_.front().clock + kMemoryDistance <= late_memory_clock()) {
      words_[static_cast<std::size_t>(late_.front().address)] = late_.front().value;
      late_.pop_front();
    }
  }

  std::vector<T> words_ = std::vector<T>(Words);
  std::deque<Late> late_;
};

}  // namespace hls
}  // namespace selfproj

#endif  // SELFPROJ_HLS_LATE_MEMORY_H
