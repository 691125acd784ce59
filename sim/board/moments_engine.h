// Engines that compute column moments: the same task, done by the model, the RTL or the HLS kernel.
#ifndef SELFPROJ_SIM_BOARD_MOMENTS_ENGINE_H
#define SELFPROJ_SIM_BOARD_MOMENTS_ENGINE_H

#include <memory>
#include <span>
#include <string>

#include "model/column_moments.h"
#include "model/column_runs.h"

namespace selfproj {

// The settings of the board before the first of several frames.
struct MomentsSettings {
  int rows = 0;     // 1..spec::kMaxRows
  int columns = 0;  // a multiple of spec::kPixelsPerBeat, up to spec::kMaxColumns
  Measure measure;
};

class MomentsEngine {
 public:
  MomentsEngine() = default;
  MomentsEngine(const MomentsEngine&) = delete;
  MomentsEngine& operator=(const MomentsEngine&) = delete;
  virtual ~MomentsEngine() = default;

  // The name for the option --engine of the programs.
  [[nodiscard]] virtual std::string name() const = 0;

  // Writes what settings.measure asks for of frames[i] to out[i], which is resized to settings.columns. In mode binary
  // `second` is 8 or 0, as in a packet (unpack_runs). All frames have the size in the
  // settings, and `out` has as many entries as `frames`. Throws std::runtime_error if the engine itself fails, for
  // example if a simulated board lost a frame.
  virtual void process(std::span<const ImageView> frames, const MomentsSettings& settings, std::span<Runs> out) = 0;
};

// The bit-exact model.
std::unique_ptr<MomentsEngine> make_moments_model_engine();

// The board's RTL, compiled by Verilator; only if SELFPROJ_HAS_RTL_ENGINE is defined.
std::unique_ptr<MomentsEngine> make_moments_rtl_engine();

// The HLS kernel (hls/column_moments.h) with SystemC's integers. It is in the library selfproj_sim_hls_engine.
std::unique_ptr<MomentsEngine> make_moments_hls_engine();

}  // namespace selfproj

#endif  // SELFPROJ_SIM_BOARD_MOMENTS_ENGINE_H
