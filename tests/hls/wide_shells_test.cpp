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

template <typename Block>
struct Held {
  Block block{sc_core::sc_gen_unique_name("block")};
};
template <typename... Blocks>
struct AllHeld : Held<Blocks>... {};
using Shells = AllHeld<MomentsOf<10, 4>, MomentsOf<12, 4>, MomentsOf<8, 8>, MomentsOf<12, 8>, MomentsOf<8, 16>,
                       RunsOf<12, 4>, RunsOf<8, 8>, RunsOf<10, 8>, RunsOf<8, 16>>;

Shells& shells() {
  static Shells all;
  return all;
}

}  // namespace

template <typename Block>
Block& shell_of() {
  return static_cast<Held<Block>&>(shells()).block;
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
