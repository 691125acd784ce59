// Replaces rtl_cores.cpp and rtl_engines.cpp in the demo's program. It has only the board that scripts/demo.sh
// shows. With all boards the demo's build takes half as much time again.
#include <cstdint>
#include <memory>
#include <vector>

#include "Vboard.h"
#include "selfproj/files/user_error.h"
#include "sim/board/engines.h"
#include "sim/platform/board_core.h"
#include "sim/platform/rtl_core.h"

namespace selfproj::sim {
namespace {

[[noreturn]] void refuse(const char* what) {
  throw UserError(what, "not part of the demo's program; scripts/build.sh builds selfproj-sim with all circuits");
}

}  // namespace

std::unique_ptr<BoardCore> make_rtl_core(const BoardCoreOptions& options) {
  if (options.codes) {
    refuse("the board with the Gray-code decoder");
  }
  if (options.pixel_bits > spec::kPixelBits) {
    refuse("a board with pixels of more than 8 bits");
  }
  if (options.runs) {
    refuse("the board with the strongest runs");
  }
  if (!options.trace_file.empty()) {
    refuse("--trace");
  }
  return std::make_unique<RtlCore<Vboard>>(options);
}

std::unique_ptr<BoardCore> make_hls_core(const BoardCoreOptions& /*options*/) { refuse("--engine hls"); }

std::unique_ptr<MatchEngine> make_match_rtl_engine(std::vector<std::uint16_t> /*table*/, int /*bits*/) {
  refuse("the matching block");
}

}  // namespace selfproj::sim
