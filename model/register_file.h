// The register file behind the board's AXI4-Lite port: what a host reads, which writes it takes, and which it refuses.
#ifndef SELFPROJ_MODEL_REGISTER_FILE_H
#define SELFPROJ_MODEL_REGISTER_FILE_H

#include <array>
#include <cstdint>
#include <vector>

#include "selfproj/model/board.h"
#include "selfproj/model/generated/selfproj_spec.h"
#include "selfproj/model/verdict.h"

namespace selfproj::model {

// What a build of the board can do: the register `capability`.
struct BoardBuild {
  int max_columns = spec::kMaxColumns;
  int max_rows = spec::kMaxRows;
  int pixel_bits = spec::kPixelBits;
  int lanes = spec::kPixelsPerBeat;  // pixels in a beat: 4, 8 or 16
  bool grey = true;
  bool image = true;
  bool codes = false;  // the Gray-code decoder
  bool median = false;
  bool runs = false;              // the strongest run of a column
  bool region = false;            // the register region
  bool compact = false;           // compact columns, and their register
  int verdict_log_sections = -1;  // log2 of the sections of a verdict's bank; -1 without verdicts
  int code_bits = 0;              // largest number of code bits; 0 without the decoder
};

// What the board is doing: the registers that only the board changes.
struct BoardState {
  bool frame_open = false;
  std::uint32_t frames = 0;
  std::uint32_t broken = 0;
  std::uint32_t stray = 0;
  std::uint32_t lost_moments = 0;
  std::uint32_t lost_image = 0;
  std::uint32_t lost_codes = 0;
  std::uint32_t abandoned = 0;
  std::uint64_t time = 0;  // pixel clocks
  std::uint32_t encoder = 0;
  std::uint16_t encoder_errors = 0;
  std::uint8_t verdict_missed = 0;
  std::uint8_t ejector_lost = 0;
};

// The answer of a register access.
struct RegisterAnswer {
  bool error = false;  // SLVERR: the access has changed nothing
  std::uint32_t data = 0;

  bool operator==(const RegisterAnswer&) const = default;
};

// The words of size, measure, window, timeout, region, compact and decode, in this order.
std::vector<RegisterWrite> setting_words(const BoardSettings& settings);

// What a host writes so that these settings count together from the next frame start on: `hold` is set first, and at
// the end is as the settings say. Registers that not every build has are left out if they stay as in `before`, the
// settings that were written last; after reset those are {}. `decodes`: the build has the decoder.
std::vector<RegisterWrite> setting_writes(const BoardSettings& settings, const BoardSettings& before, bool decodes);

// The model of rtl/board/sp_registers and rtl/verdict/sp_verdict_registers, without their clocks.
class RegisterFile {
 public:
  // After reset.
  explicit RegisterFile(const BoardBuild& build = {});

  // Limits that are written go to `verdict`, which is the build's size and must live longer, and its parts can be read.
  void judge_with(Verdict& verdict) { verdict_ = &verdict; }

  // Reading time_low holds time_high.
  RegisterAnswer read(std::uint32_t address, const BoardState& state);

  // Takes a write of all four bytes, or refuses it as a whole. Bits outside all fields are ignored, except in `size`
  // and in the registers of the verdict, which keep them.
  RegisterAnswer write(std::uint32_t address, std::uint32_t data);

  // A frame start has taken the settings over: status.pending becomes 0.
  void taken() { pending_ = false; }

  // The settings as they are written.
  [[nodiscard]] BoardSettings settings() const;

  // The value of a register that can be written; 0 for others.
  [[nodiscard]] std::uint32_t value(std::uint32_t address) const;

 private:
  static constexpr std::uint32_t kWords = 64;

  [[nodiscard]] bool good(std::uint32_t address, std::uint32_t data) const;
  [[nodiscard]] std::uint32_t field(std::uint32_t address, int lsb, int bits) const;
  [[nodiscard]] bool good_verdict(std::uint32_t address, std::uint32_t data) const;
  [[nodiscard]] bool bank_is_free() const;
  [[nodiscard]] std::uint32_t capability() const;
  [[nodiscard]] std::uint32_t verdict_state(const BoardState& state) const;
  void write_limits(std::uint32_t address, std::uint32_t data);

  BoardBuild build_;
  Verdict* verdict_ = nullptr;
  std::uint64_t written_ = 0;  // words of the verdict, since reset
  std::array<std::uint32_t, kWords> values_{};
  bool pending_ = true;
  std::uint32_t time_high_ = 0;
};

// Whether a build has the register. Some exist only with the Gray-code decoder, one only with the region, one
// with compact columns, those from verdict_control on with verdicts.
bool has_register(const BoardBuild& build, std::uint32_t address);

}  // namespace selfproj::model

#endif  // SELFPROJ_MODEL_REGISTER_FILE_H
