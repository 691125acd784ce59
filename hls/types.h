// The types in which the kernels are written: exact-width integers, streams, beats of AXI4-Stream, arrays.
//
// With SELFPROJ_HLS_VENDOR_TYPES they are those of the HLS tool (ap_int.h, hls_stream.h, and ap_axi_sdata.h if it
// exists), whose folder must be in the include path. Otherwise they are SystemC's integers, which need no kernel, and a
// queue. The kernels use only what both have in common: every operation has at least the bits of the exact result, or
// is assigned directly to a variable of the intended width. Nothing relies on values that were not assigned.
#ifndef SELFPROJ_HLS_TYPES_H
#define SELFPROJ_HLS_TYPES_H

#include <cstdint>

#ifdef SELFPROJ_HLS_VENDOR_TYPES
#include <ap_int.h>
#include <hls_stream.h>
#if defined(__has_include)
#if __has_include(<ap_axi_sdata.h>)
#include <ap_axi_sdata.h>
#define SELFPROJ_HLS_VENDOR_AXIS
#endif
#endif
#else
#include <sysc/datatypes/int/sc_biguint.h>
#include <sysc/datatypes/int/sc_uint.h>
#include <sysc/kernel/sc_ver.h>
#if SC_VERSION_MAJOR >= 3  // their functions are in headers that only this one includes in the right order
#include <systemc>
#endif

#include <deque>
#endif

namespace selfproj {
namespace hls {

#ifdef SELFPROJ_HLS_VENDOR_TYPES

template <int Bits>
using Uint = ap_uint<Bits>;  // 1..64 bits
template <int Bits>
using WideUint = ap_uint<Bits>;  // any number of bits

template <typename T>
using Stream = ::hls::stream<T>;

#else

template <int Bits>
using Uint = sc_dt::sc_uint<Bits>;
template <int Bits>
using WideUint = sc_dt::sc_biguint<Bits>;

// The part of hls::stream that the kernels and their users need: for a C++ program, an unlimited queue.
template <typename T>
class Stream {
 public:
  bool empty() const { return queue_.empty(); }
  void write(const T& value) { queue_.push_back(value); }
  // Takes the first value; returns false if there is none.
  bool read_nb(T& value) {
    if (queue_.empty()) {
      return false;
    }
    value = queue_.front();
    queue_.pop_front();
    return true;
  }

 private:
  std::deque<T> queue_;
};

#endif

// The data of a beat.
template <int Bits, bool Wide>
struct AxisDataOf {
  using Type = Uint<Bits>;
};
template <int Bits>
struct AxisDataOf<Bits, true> {
  using Type = WideUint<Bits>;
};
template <int Bits>
using AxisData = typename AxisDataOf<Bits, (Bits > 64)>::Type;

// A beat of AXI4-Stream with tuser (start of a frame) and tlast.
#ifdef SELFPROJ_HLS_VENDOR_AXIS
template <int Bits>
using AxisBeat = ap_axiu<Bits, 1, 1, 1>;
#else
template <int Bits>
struct AxisBeat {
  AxisData<Bits> data;
  Uint<Bits / 8> keep;
  Uint<Bits / 8> strb;
  Uint<1> user;
  Uint<1> last;
  Uint<1> id;
  Uint<1> dest;
};
#endif

// A beat in which all bytes count.
template <int Bits>
AxisBeat<Bits> axis_beat(const AxisData<Bits>& data, bool user, bool last) {
  AxisBeat<Bits> beat;
  beat.data = data;
  beat.keep = 0;
  beat.keep = ~beat.keep;
  beat.strb = beat.keep;
  beat.user = user ? 1 : 0;
  beat.last = last ? 1 : 0;
  beat.id = 0;
  beat.dest = 0;
  return beat;
}

// Steps from a write to a kernel's memory to the first read of the same word that must see it there. The kernels tell
// the tool (#pragma HLS dependence ... distance = 4), and get newer words elsewhere.
constexpr int kMemoryDistance = 4;

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

// A memory of a kernel. For tools it is an array. With SELFPROJ_HLS_LATE_MEMORY (tests) it is one that puts
// kMemoryDistance to the test.
#ifdef SELFPROJ_HLS_LATE_MEMORY
#include "hls/late_memory.h"
#else
namespace selfproj {
namespace hls {
template <typename T, int Words>
using Memory = T[Words];
inline void late_memory_step() {}
}  // namespace hls
}  // namespace selfproj
#endif

#endif  // SELFPROJ_HLS_TYPES_H
