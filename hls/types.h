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

// An integer of `Bits`, of whichever kind it takes.
template <int Bits, bool Narrow = (Bits <= 64)>
struct UintOfBits {
  using Type = Uint<Bits>;
};
template <int Bits>
struct UintOfBits<Bits, false> {
  using Type = WideUint<Bits>;
};
template <int Bits>
using AnyUint = typename UintOfBits<Bits>::Type;

// The `Bits` bits of a number from bit `lsb` on, 64 at most.
template <int Bits, int Of>
inline Uint<Bits> part_of(Uint<Of> whole, int lsb) {
  Uint<Bits> part = whole >> lsb;
  return part;
}
template <int Bits, int Of>
inline Uint<Bits> part_of(WideUint<Of> whole, int lsb) {
  Uint<Bits> part = whole.range(lsb + Bits - 1, lsb).to_uint64();
  return part;
}

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
