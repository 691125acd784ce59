// Engines that compute column moments: the same task, by the model, by the RTL, ...
#ifndef SELFPROJ_SIM_BOARD_MOMENTS_ENGINE_H
#define SELFPROJ_SIM_BOARD_MOMENTS_ENGINE_H

#include <memory>
#include <span>
#include <string>

#include "model/column_moments.h"

namespace selfproj {

// What the board is set to before the first of a row of frames.
struct MomentsSettings {
  int rows = 0;     // 1..spec::kMaxRows
  int columns = 0;  // a multiple of spec::kPixelsPerBeat, up to spec::kMaxColumns
  Mode mode = Mode::binary;
  int threshold = 128;  // 0..255; a pixel is lit where it is greater
};

class MomentsEngine {
 public:
  MomentsEngine() = default;
  MomentsEngine(const MomentsEngine&) = delete;
  MomentsEngine& operator=(const MomentsEngine&) = delete;
  virtual ~MomentsEngine() = default;

  // As the option --engine of the programs spells it.
  [[nodiscard]] virtual std::string name() const = 0;

  // Puts the moments of frames[i] into out[i], which is resized to settings.columns. All frames have the size given in
  // the settings, and there are as many of out as of frames. Throws std::runtime_error where the engine itself fails
  // (a simulated board that lost a frame, say).
  virtual void process(std::span<const ImageView> frames, const MomentsSettings& settings, std::span<Moments> out) = 0;
};

// The bit-exact model.
std::unique_ptr<MomentsEngine> make_moments_model_engine();

// The board's RTL, compiled by Verilator; only where SELFPROJ_HAS_RTL_ENGINE is defined.
std::unique_ptr<MomentsEngine> make_moments_rtl_engine();

// The HLS kernel (hls/column_moments.h) with SystemC's integers; in the library selfproj_sim_hls_engine.
std::unique_ptr<MomentsEngine> make_moments_hls_engine();

}  // namespace selfproj

#endif  // SELFPROJ_SIM_BOARD_MOMENTS_ENGINE_H
