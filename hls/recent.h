// The words that were written to a memory last, for reads that come before the memory shows them.
#ifndef SELFPROJ_HLS_RECENT_H
#define SELFPROJ_HLS_RECENT_H

#include "hls/types.h"

namespace selfproj {
namespace hls {

// The last kMemoryDistance - 1 words written, with their addresses. A step writes at most one word, so everything that
// the memory does not show yet is here.
template <typename Word, typename Address>
class Recent {
 public:
  // The word at `address`, if the memory shows `stored`.
  Word read(Address address, const Word& stored) const {
#pragma HLS inline
    Word word = stored;
    // The newest word counts, so it is checked last.
    for (int i = kWords - 1; i >= 0; --i) {
#pragma HLS unroll
      if (there_[i] && addresses_[i] == address) {
        word = words_[i];
      }
    }
    return word;
  }

  void write(Address address, const Word& word) {
#pragma HLS inline
    for (int i = kWords - 1; i > 0; --i) {
#pragma HLS unroll
      there_[i] = there_[i - 1];
      addresses_[i] = addresses_[i - 1];
      words_[i] = words_[i - 1];
    }
    there_[0] = true;
    addresses_[0] = address;
    words_[0] = word;
  }

 private:
  static constexpr int kWords = kMemoryDistance - 1;

  bool there_[kWords] = {};
  Address addresses_[kWords];
  Word words_[kWords] = {};
};

}  // namespace hls
}  // namespace selfproj

#endif  // SELFPROJ_HLS_RECENT_H
