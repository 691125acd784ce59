// The SystemC shells of the moments for pixels of more bits, and for 8 and 16 pixels a clock, beside the RTL.
#include <gtest/gtest.h>

#include <string>
#include <type_traits>

#include "Vsp_column_moments_eight_of_twelve_ports.h"
#include "Vsp_column_moments_eight_ports.h"
#include "Vsp_column_moments_sixteen_ports.h"
#include "Vsp_column_moments_ten_ports.h"
#include "Vsp_column_moments_twelve_ports.h"
#include "Vsp_column_runs_eight_ports.h"
#include "Vsp_column_runs_sixteen_ports.h"
#include "Vsp_column_runs_ten_of_eight_ports.h"
#include "Vsp_column_runs_twelve_ports.h"
#include "tests/hls/beside.h"

namespace selfproj::test {
namespace {

template <int PixelBits, int Lanes>
using MomentsOf = sim::ColumnMomentsBlockOf<hls::MomentsFormats<PixelBits, Lanes>>;
template <int PixelBits, int Lanes>
using RunsOf = sim::ColumnRunsBlockOf<hls::MomentsFormats<PixelBits, Lanes>>;

struct Shells {
  MomentsOf<10, 4> ten{"ten"};
  MomentsOf<12, 4> twelve{"twelve"};
  MomentsOf<8, 8> eight{"eight"};
  MomentsOf<12, 8> eight_of_twelve{"eight_of_twelve"};
  MomentsOf<8, 16> sixteen{"sixteen"};
  RunsOf<12, 4> runs_twelve{"runs_twelve"};
  RunsOf<8, 8> runs_eight{"runs_eight"};
  RunsOf<10, 8> runs_ten_of_eight{"runs_ten_of_eight"};
  RunsOf<8, 16> runs_sixteen{"runs_sixteen"};
};

Shells& shells() {
  static Shells all;
  return all;
}

}  // namespace

template <>
MomentsOf<10, 4>& shell_of() {
  return shells().ten;
}
template <>
MomentsOf<12, 4>& shell_of() {
  return shells().twelve;
}
template <>
MomentsOf<8, 8>& shell_of() {
  return shells().eight;
}
template <>
MomentsOf<12, 8>& shell_of() {
  return shells().eight_of_twelve;
}
template <>
MomentsOf<8, 16>& shell_of() {
  return shells().sixteen;
}
template <>
RunsOf<12, 4>& shell_of() {
  return shells().runs_twelve;
}
template <>
RunsOf<8, 8>& shell_of() {
  return shells().runs_eight;
}
template <>
RunsOf<10, 8>& shell_of() {
  return shells().runs_ten_of_eight;
}
template <>
RunsOf<8, 16>& shell_of() {
  return shells().runs_sixteen;
}

namespace {

template <typename Circuit>
class WideShell : public ::testing::Test {};
using Circuits = ::testing::Types<
    MomentsBeside<MomentsOf<10, 4>, Vsp_column_moments_ten>, MomentsBeside<MomentsOf<12, 4>, Vsp_column_moments_twelve>,
    MomentsBeside<MomentsOf<8, 8>, Vsp_column_moments_eight>,
    MomentsBeside<MomentsOf<12, 8>, Vsp_column_moments_eight_of_twelve>,
    MomentsBeside<MomentsOf<8, 16>, Vsp_column_moments_sixteen>, MomentsBeside<RunsOf<12, 4>, Vsp_column_runs_twelve>,
    MomentsBeside<RunsOf<8, 8>, Vsp_column_runs_eight>, MomentsBeside<RunsOf<10, 8>, Vsp_column_runs_ten_of_eight>,
    MomentsBeside<RunsOf<8, 16>, Vsp_column_runs_sixteen>>;
struct Names {
  template <typename Circuit>
  static std::string GetName(int /*number*/) {
    using Format = typename std::remove_reference_t<decltype(Circuit::block())>::Format;
    return (moments::kRuns<Circuit> ? "Runs" : "Moments") + std::to_string(Format::kPixelBits) + "Bits" +
           std::to_string(Format::kLanes) + "Lanes";
  }
};
TYPED_TEST_SUITE(WideShell, Circuits, Names);

TYPED_TEST(WideShell, SmallSizes) { small_sizes<TypeParam>(); }
TYPED_TEST(WideShell, TallestImages) { tallest_images<TypeParam>(); }
TYPED_TEST(WideShell, WidestImages) { widest_images<TypeParam>(); }
TYPED_TEST(WideShell, RandomFrames) { random_frames<TypeParam>(); }

}  // namespace
}  // namespace selfproj::test
