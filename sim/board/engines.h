// Engines that compute column moments: the same task, done by the model, the RTL or the HLS circuits.
#ifndef SELFPROJ_SIM_BOARD_ENGINES_H
#define SELFPROJ_SIM_BOARD_ENGINES_H

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "selfproj/model/column_moments.h"
#include "selfproj/model/column_runs.h"
#include "selfproj/model/gray_decoder.h"

namespace selfproj::sim {

// The settings of the board before the first of several frames.
struct MomentsSettings {
  int rows = 0;     // 1..spec::kMaxRows
  int columns = 0;  // a multiple of spec::kPixelsPerBeat, up to spec::kMaxColumns
  model::Measure measure;
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
  // `second` is 8 or 0, as in a packet (ColumnWord::binary_run). All frames have the size in the
  // settings, and `out` has as many entries as `frames`. Throws std::runtime_error if the engine itself fails, for
  // example if a simulated board lost a frame.
  virtual void process(std::span<const model::ImageView> frames, const MomentsSettings& settings,
                       std::span<model::Runs> out) = 0;
};

// The bit-exact model.
std::unique_ptr<MomentsEngine> make_moments_model_engine();

// The board's RTL, compiled by Verilator; only if SELFPROJ_HAS_RTL_ENGINE is defined.
std::unique_ptr<MomentsEngine> make_moments_rtl_engine();

// The SystemC shells of hls/, in the library selfproj_sim_hls_engine. Only one engine of a program may run at a time.
std::unique_ptr<MomentsEngine> make_moments_hls_engine();

// Engines that decode Gray-code sequences: the same task, done by the model, the RTL or the HLS circuits.
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
  virtual void start(const model::GraySettings& settings, bool median) = 0;

  // Takes the next frame, which has the size in the settings, with its pattern index. If a code image is due, writes
  // rows · columns words to `codes`, as GrayDecoder and median3x3 do, and returns true. Throws std::runtime_error if
  // the engine itself fails.
  virtual bool take(const model::ImageView& image, int pattern, std::uint16_t* codes) = 0;
};

// The bit-exact models.
std::unique_ptr<GrayEngine> make_gray_model_engine();

// The RTL, compiled by Verilator with memory for 4096 x 4095 pixels; only if SELFPROJ_HAS_RTL_ENGINE is defined.
std::unique_ptr<GrayEngine> make_gray_rtl_engine();

// The SystemC shells of hls/, with memory for 2048 x 4095 pixels, in the library selfproj_sim_hls_engine. Only one
// engine of a program may run at a time.
std::unique_ptr<GrayEngine> make_gray_hls_engine();

// Engines that match codes of self-projected structured light: (pixel, code) to projector line, by the model or the
// RTL.
class MatchEngine {
 public:
  MatchEngine() = default;
  MatchEngine(const MatchEngine&) = delete;
  MatchEngine& operator=(const MatchEngine&) = delete;
  virtual ~MatchEngine() = default;

  // The name for the option --engine of the programs.
  [[nodiscard]] virtual std::string name() const = 0;

  // Writes the rows x columns lines (include/selfproj/model/gray_match.h) of a code image to `lines`. Throws
  // std::runtime_error if the engine itself fails.
  virtual void look_up(const std::uint16_t* codes, int rows, int columns, std::uint16_t* lines) = 0;
};

// `table` has 2^bits words for each pixel, one pixel after another (MatchTable::by_pixels), for all pixels to look up.
std::unique_ptr<MatchEngine> make_match_model_engine(std::vector<std::uint16_t> table, int bits);

// The RTL, compiled by Verilator for 4 bits and images of up to 512 x 512 pixels, columns a multiple of
// spec::kPixelsPerBeat, with the table in a memory behind its port. Only if SELFPROJ_HAS_RTL_ENGINE is defined, from
// selfproj_sim_rtl_engine. Throws std::invalid_argument if the table does not belong to such an image.
std::unique_ptr<MatchEngine> make_match_rtl_engine(std::vector<std::uint16_t> table, int bits);

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_BOARD_ENGINES_H
