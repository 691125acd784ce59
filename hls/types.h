// The integers of the shells: SystemC's, of exact width.
#ifndef SELFPROJ_HLS_TYPES_H
#define SELFPROJ_HLS_TYPES_H

#include <systemc>

namespace selfproj {
namespace hls {

template <int Bits>
using Uint = sc_dt::sc_uint<Bits>;  // 1..64 bits
template <int Bits>
using WideUint = sc_dt::sc_biguint<Bits>;  // any number of bits

// Bits needed for 0..largest.
constexpr int bits_for(long long largest) {
  int bits = 1;
  for (int i = 1; i < 62; ++i) {
    bits += (largest >> i) != 0 ? 1 : 0;
  }
  return bits;
}

}  // namespace hls
}  // namespace selfproj

#endif  // SELFPROJ_HLS_TYPES_H
