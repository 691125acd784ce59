// A verdict from the moments of frames, without a division: the definition, which the circuit sp_verdict equals to the
// last bit.
//
// **Columns.** A table has for each column η two limits, in 1/128 rows, and whether the column is judged. Limits may be
// moved by s columns and d/128 rows, because a part does not always lie in the same place: column η has the limits of
// column η - s, plus d. A judged column with the moments M0, M1 is
//
//     unlit   if M0 = 0
//     above   if 128 M1 - d M0 < low  · M0      its centroid M1 / M0 lies above the band, at smaller rows
//     below   if 128 M1 - d M0 > high · M0      … below it, at larger rows
//     good    otherwise
//
// It is *out* if it is above, where defects above are asked for, or below, where those below are.
//
// **Defects.** Write the frames of a part under each other, one row of cells for each frame, and mark the cells of
// columns that are out. A column has a *hit* for each of its last h frames, this one included, in which it was out.
// A frame has a defect if w neighbouring columns or more have at least m hits each. The part is without hits until its
// first whole frame has come: frames that break before that are judged by themselves.
//
// A frame *lacks light* if more than u of its judged columns are unlit.
//
// A frame that breaks is judged over the whole groups of four columns that came. The other columns keep their hits.
// All frames of a part have the same size.
//
// **Parts.** By light: a part begins with the frame after a whole frame with t lit columns or more, and ends with the
// last of e whole frames in a row that have fewer. A column is lit if M0 > 0, judged or not; t and e are those in force
// at the next frame. By the encoder, which counts up: part k = 0, 1, … begins with the first frame whose encoder count
// is not before start + k · pitch, and ends before the first frame whose count is `length` or more behind that point. k
// counts from where the encoder was chosen, or from the first frame behind stop(). Counts are compared modulo 2^24. A
// part ends, too, where the way of telling parts changes. Frames outside of parts are never bad.
//
// The encoder must not count back: behind the beginning of a part, by one count only, `length` or `begins` are reached
// modulo 2^24, so that a part by the encoder ends, and a part by light begins a section with each frame.
//
// **Sections.** A part may have other limits along its way. It begins with section 0; the next section begins with the
// first frame whose count is `begins[section + 1]` or more behind the part's beginning, by one section at most from
// frame to frame. The beginning is start + k · pitch, or with parts by light the count of the part's first frame.
//
// **Settings** are taken over where a part begins, and so is the bank of limits: a bank can be written while the other
// judges. While they are held, the part keeps those of the part before; without any no part begins. The settings by
// which parts begin and end are always those in force.
#ifndef SELFPROJ_MODEL_VERDICT_H
#define SELFPROJ_MODEL_VERDICT_H

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace selfproj::model {

inline constexpr int kRowParts = 128;
inline constexpr std::uint32_t kMaxLimit = (1U << 17) - 1;   // rows to 1023
inline constexpr std::uint32_t kMaxBand = (1U << 14) - 1;    // between the two limits, in the board's registers
inline constexpr int kMaxShiftColumns = 127;                 // both ways
inline constexpr int kUnlitNotJudged = 4095;                 // for most_unlit, which is less where light is judged
inline constexpr int kMaxShiftRows = 8191;                   // both ways, in 1/kRowParts rows
inline constexpr int kMaxHistory = 8;                        // frames
inline constexpr std::uint32_t kCountMask = (1U << 24) - 1;  // of the encoder, as far as parts need it

// The limits of a column, in 1/kRowParts rows, row 1 being kRowParts.
struct ColumnLimits {
  std::uint32_t low = 0;   // 0..kMaxLimit
  std::uint32_t high = 0;  // 0..kMaxLimit
  bool judged = false;

  bool operator==(const ColumnLimits&) const = default;
};

// The limits of a section of a part.
struct SectionLimits {
  std::uint32_t begin = 0;  // counts of the encoder behind the part's beginning; 0 in the first
  std::vector<ColumnLimits> limits;

  bool operator==(const SectionLimits&) const = default;
};

enum class ColumnState : std::uint8_t { good, above, below, unlit };

// The state of a judged column. `shift` is d. The inequalities above, exactly.
ColumnState column_state(const ColumnLimits& limits, int shift, std::uint32_t m0, std::uint32_t m1);

// What is taken over where a part begins.
struct VerdictSettings {
  int width = 1;      // w, 1..255 columns
  int history = 1;    // h, 1..kMaxHistory frames
  int hits = 1;       // m, 1..15; more than h: there are no defects
  bool above = true;  // defects above are asked for
  bool below = true;
  int most_unlit = kUnlitNotJudged;  // u, in columns
  int shift_columns = 0;             // s, -kMaxShiftColumns..kMaxShiftColumns
  int shift_rows = 0;                // d, -kMaxShiftRows..kMaxShiftRows
  int bank = 0;                      // 0 or 1

  bool operator==(const VerdictSettings&) const = default;
};

// Where parts begin and end.
struct PartRule {
  bool by_encoder = false;
  int lit = 1;               // t, 1..4095 columns
  int dark_frames = 1;       // e, 1..255
  std::uint32_t start = 0;   // count at which part 0 begins
  std::uint32_t length = 1;  // counts, 1..2^24 - 1
  std::uint32_t pitch = 1;   // counts, 1..2^24 - 1, which is to be more than length

  bool operator==(const PartRule&) const = default;
};

// The registers verdict_defect, verdict_shift and verdict_light (docs/register-reference.md).
struct VerdictWords {
  std::uint32_t defect = 0;
  std::uint32_t shift = 0;
  std::uint32_t light = 0;
};
VerdictWords verdict_words(const VerdictSettings& settings, const PartRule& rule);
VerdictSettings settings_of_words(const VerdictWords& words);

// The register verdict_limits. The limits are kMaxBand apart at most, the lower one first.
std::uint32_t limits_word(const ColumnLimits& limits);

// The register verdict_control; `packets` is its field.
std::uint32_t verdict_control_word(bool on, bool hold, bool by_encoder, int packets);

// A write of a register, and what a host writes, in this order: settings and rule, and all sections of a bank of a
// board with so many columns and sections. Columns behind the last one, which a shift may reach, are then not judged,
// and no section follows the last one. The limits must be those that limits_word takes.
struct RegisterWrite {
  std::uint32_t address = 0;
  std::uint32_t data = 0;
};
std::vector<RegisterWrite> verdict_writes(const VerdictSettings& settings, const PartRule& rule);
std::vector<RegisterWrite> limits_writes(int bank, std::span<const SectionLimits> sections, int board_columns,
                                         int board_sections);

// What was found in a frame of a part.
struct FrameVerdict {
  bool in_part = false;
  bool defect = false;
  bool lacks_light = false;
  int section = 0;         // this and the next two outside of parts are those of the part before
  int bank = 0;            // of limits in force
  std::uint32_t part = 0;  // its number, from 1: parts that have begun, modulo 2^16
  bool first_bad = false;  // the first frame of its part that has a defect or lacks light
  int first_column = 0;    // of the leftmost defect, from 1; 0 without one
  int columns = 0;         // of it
  int unlit = 0;           // judged columns that are unlit

  bool operator==(const FrameVerdict&) const = default;
};

// The 16 bytes of a packet that have the verdict (docs/packet-reference.md); all but first_bad, which they do not have.
void pack_verdict(const FrameVerdict& verdict, std::uint8_t* bytes);

// Reads them back; nothing if the packet has none, because the frame broke.
std::optional<FrameVerdict> unpack_verdict(const std::uint8_t* bytes);

// Judges frame after frame.
class Verdict {
 public:
  // Tables of `columns` (a multiple of 4), in 1 to 64 sections.
  Verdict(int columns, int sections);

  // Writes the limits of a column, from 0. Throws std::invalid_argument if something is out of range.
  void write(int bank, int section, int column, const ColumnLimits& limits);

  // Writes all sections of a bank, of which there may be fewer than it has, and columns from 0 on.
  void write(int bank, std::span<const SectionLimits> sections);

  // From which count behind a part's beginning on a section, from 1, is in force.
  void begin_section(int bank, int section, std::uint32_t count);

  // Judges the next frame: its encoder count, and the moments of the columns that came, which are as many as it has
  // unless it broke. Settings and rule are those of this moment.
  FrameVerdict frame(const VerdictSettings& settings, bool hold, const PartRule& rule, std::uint32_t encoder,
                     std::span<const std::uint32_t> m0, std::span<const std::uint32_t> m1, bool whole);

  // A frame that is not to be judged: no part passes, and the next frame is the first one of all.
  void stop();

  [[nodiscard]] int columns() const { return columns_; }
  [[nodiscard]] int sections() const { return sections_; }
  [[nodiscard]] bool in_part() const { return in_part_; }  // as of the last frame
  [[nodiscard]] int section() const { return section_; }
  [[nodiscard]] int bank() const { return settings_.bank; }     // in force
  [[nodiscard]] std::uint32_t parts() const { return parts_; }  // that have begun
  [[nodiscard]] std::uint32_t bad_parts() const { return bad_parts_; }

 private:
  void begin(const VerdictSettings& settings, bool hold, std::uint32_t count);
  void find_part(const VerdictSettings& settings, bool hold, const PartRule& rule, std::uint32_t encoder);
  void judge(std::span<const std::uint32_t> m0, std::span<const std::uint32_t> m1, FrameVerdict& found);
  bool look_for_light(const PartRule& rule);

  int columns_;
  int sections_;
  std::vector<ColumnLimits> limits_;   // [bank][section][column]
  std::vector<std::uint32_t> begins_;  // [bank][section]
  std::vector<std::uint8_t> past_;     // hits of each column: bit 0 the frame before, bit 1 the one before that …
  VerdictSettings settings_;           // in force
  bool taken_ = false;                 // there are settings in force
  bool in_part_ = false;
  int lit_ = -1;       // lit columns of the frame before; -1: it was not whole
  bool fresh_ = true;  // no whole frame of the part has come
  bool bad_ = false;   // a frame of the part was bad
  int section_ = 0;
  int dark_ = 0;
  std::uint32_t began_ = 0;  // encoder count, or where the first part by the encoder begins
  bool by_encoder_ = false;  // the frame before
  bool waits_ = true;        // no part by the encoder has begun since it was chosen
  std::uint32_t parts_ = 0;  // that have begun
  std::uint32_t bad_parts_ = 0;
};

}  // namespace selfproj::model

#endif  // SELFPROJ_MODEL_VERDICT_H
