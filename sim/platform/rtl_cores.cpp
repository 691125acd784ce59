// All boards: a core for each Verilated sp_board of sim/board, including those with SystemC shells in place of blocks.
#include <memory>

#include "Vboard.h"
#include "Vboard_hls.h"
#include "Vboard_runs.h"
#include "Vboard_runs_ten.h"
#include "Vboard_runs_twelve.h"
#include "Vboard_scanner.h"
#include "Vboard_scanner_hls.h"
#include "Vboard_traced.h"
#include "sim/platform/board_core.h"
#include "sim/platform/rtl_core.h"
#include "sim/platform/shell_slot.h"

namespace selfproj::sim {
namespace {

// The shells must exist before the board's first clock, which the constructor of RtlCore runs. So they are in a base
// class before it.
struct MomentsShell {
  ColumnMomentsSlot moments{"column_moments"};
};
class HlsCore final : private MomentsShell, public RtlCore<Vboard_hls> {
 public:
  using RtlCore::RtlCore;
};

struct DecoderShells {
  GrayDecoderSlot decoder{"gray_decoder"};
  Median3x3Slot median{"median3x3"};
};
class HlsScannerCore final : private DecoderShells, public RtlCore<Vboard_scanner_hls> {
 public:
  using RtlCore::RtlCore;
};

}  // namespace

std::unique_ptr<BoardCore> make_rtl_core(const BoardCoreOptions& options) {
  if (options.codes) {
    return std::make_unique<RtlCore<Vboard_scanner>>(options);
  }
  if (options.pixel_bits == 10) {
    return std::make_unique<RtlCore<Vboard_runs_ten>>(options);
  }
  if (options.pixel_bits == 12) {
    return std::make_unique<RtlCore<Vboard_runs_twelve>>(options);
  }
  if (options.runs) {
    return std::make_unique<RtlCore<Vboard_runs>>(options);
  }
  if (options.trace_file.empty()) {
    return std::make_unique<RtlCore<Vboard>>(options);
  }
  return std::make_unique<RtlCore<Vboard_traced>>(options);
}

std::unique_ptr<BoardCore> make_hls_core(const BoardCoreOptions& options) {
  if (options.codes) {
    return std::make_unique<HlsScannerCore>(options);
  }
  return std::make_unique<HlsCore>(options);
}

}  // namespace selfproj::sim
