// Engines that decode Gray-code sequences: the same task, done by the model, the RTL or the HLS kernel.
#ifndef SELFPROJ_SIM_BOARD_GRAY_ENGINE_H
#define SELFPROJ_SIM_BOARD_GRAY_ENGINE_H

#include <cstdint>
#include <memory>
#include <string>

#include "model/column_moments.h"
#include "model/gray_decoder.h"

namespace selfproj {

class GrayEngine {
 public:
  GrayEngine() = default;
  GrayEngine(const GrayEngine&) = delete;
  GrayEngine& operator=(const GrayEngine&) = delete;
  virtual ~GrayEngine() = default;

  // The name for the option --engine of the programs.
  [[nodiscard]] virtual std::string name() const = 0;

  // The size of the largest image; columns are a multiple of spec::kPixelsPerBeat.
  [[nodiscard]] virtual int max_rows() const = 0;
  [[nodiscard]] virtual int max_columns() const = 0;

  // Waits for plane 0 with these settings, and with or without the 3 x 3 median on the codes. Must be called first.
  virtual void start(const GraySettings& settings, bool median) = 0;

  // Takes the next frame, which has the size in the settings, with its pattern index. If a code image is due, writes
  // rows · columns words to `codes`, as GrayDecoder and median3x3 do, and returns true. Throws std::runtime_error if
  // the engine itself fails.
  virtual bool take(const ImageView& image, int pattern, std::uint16_t* codes) = 0;
};

// The bit-exact models.
std::unique_ptr<GrayEngine> make_gray_model_engine();

// The RTL, compiled by Verilator with memory for 4096 x 4095 pixels; only if SELFPROJ_HAS_RTL_ENGINE is defined.
std::unique_ptr<GrayEngine> make_gray_rtl_engine();

// The HLS kernel (hls/gray_decoder.h) for images of 4096 x 4095 pixels, with SystemC's integers. It is in the library
// selfproj_sim_hls_engine.
std::unique_ptr<GrayEngine> make_gray_hls_engine();

}  // namespace selfproj

#endif  // SELFPROJ_SIM_BOARD_GRAY_ENGINE_H
