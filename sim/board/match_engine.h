// Engines that match codes of self-projected structured light: (pixel, code) to projector line, by the model or the
// RTL.
#ifndef SELFPROJ_SIM_BOARD_MATCH_ENGINE_H
#define SELFPROJ_SIM_BOARD_MATCH_ENGINE_H

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace selfproj {

class MatchEngine {
 public:
  MatchEngine() = default;
  MatchEngine(const MatchEngine&) = delete;
  MatchEngine& operator=(const MatchEngine&) = delete;
  virtual ~MatchEngine() = default;

  // The name for the option --engine of the programs.
  [[nodiscard]] virtual std::string name() const = 0;

  // Writes the rows x columns lines (model/gray_match.h) of a code image to `lines`. Throws std::runtime_error if the
  // engine itself fails.
  virtual void look_up(const std::uint16_t* codes, int rows, int columns, std::uint16_t* lines) = 0;
};

// `table` has 2^bits words for each pixel, one pixel after another (MatchTable::by_pixels), for all pixels to look up.
std::unique_ptr<MatchEngine> make_match_model_engine(std::vector<std::uint16_t> table, int bits);

// The RTL, compiled by Verilator for 4 bits and images of up to 512 x 512 pixels, columns a multiple of
// spec::kPixelsPerBeat, with the table in a memory behind its port. Only if SELFPROJ_HAS_RTL_ENGINE is defined, from
// selfproj_sim_rtl_engine. Throws std::invalid_argument if the table does not belong to such an image.
std::unique_ptr<MatchEngine> make_match_rtl_engine(std::vector<std::uint16_t> table, int bits);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_BOARD_MATCH_ENGINE_H
