// Neighbourhood search (4.19, 4.20), computed before the first frame: the projector line that is matched with each
// camera pixel and code.
#ifndef SELFPROJ_HOST_STRUCTURED_LIGHT_MATCH_TABLE_H
#define SELFPROJ_HOST_STRUCTURED_LIGHT_MATCH_TABLE_H

#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "host/structured_light/self_reference.h"
#include "selfproj/model/gray_match.h"
#include "selfproj/rig/optics.h"
#include "selfproj/rig/rig.h"

namespace selfproj::structured_light {

struct MatchSettings {
  int e = 0;  // cells below the reference that are searched, 0..2^m - 1

  // The printed forms of the text, both wrong for references that vary (docs/structured-light.md).
  bool printed_direction = false;  // (4.19): search along Xp at constant Yp, not along the pixel's epipolar line
  bool printed_window = false;     // (4.20): -a' e <= line - X_R < a' (2^m - e), not counted in cells of the reference
  double line_width = 3;           // a' > 0, in projector lines; for the printed window only
};

// The match of one pixel and code.
struct Match {
  double line = 0;        // middle of the matched cell, a projector line from 0
  double half_width = 0;  // half the width of the cell, in lines
  int steps = 0;          // n: how many cells the match lies towards the camera
  double distance = 0;    // distance from X_R to the match, in lines
  int candidates = 0;     // candidates in the window; if 0, there is no match and the rest is meaningless
};

// The search itself, one pixel at a time, by one thread. A camera pixel at row r has its own cell k = ⌊Xc / (a δc)⌋.
// Its correspondences lie on its epipolar line in the projector image, a straight line, or a curve through lenses.
// Along this line the cells K of the reference (of f_R at the nearest projector pixel, in steps of a quarter of a line)
// form runs; pieces less than 2.5 lines apart are one run. A run with
//     n = k - K,   -e <= n < 2^m - e
// is a candidate for the code of cell K. If there are several, it takes the one with the smallest |n| (printed window:
// the one nearest to X_R), and of two equal ones the one nearer to the camera. Its place is the middle of the run,
// which has the reference's own fractions of a cell. Nothing is matched at pixels that the reference does not show (A_R
// = 0), or if z does not fall with θ (z0 tan α >= x0).
class MatchSearch {
 public:
  // Rig and reference must outlive the search. Throws std::invalid_argument if a setting is out of range or the
  // reference has not the rig's sizes.
  MatchSearch(const rig::Rig& rig, const SelfReference& reference, const MatchSettings& settings);

  // Whether anything can be matched at this pixel.
  [[nodiscard]] bool can_find(int row, int column) const;

  // `matches` gets 2^m entries, one for each code.
  void find(int row, int column, std::vector<Match>& matches) const;

 private:
  // A straight line in the projector image.
  struct Path {
    double at_0, slope;
    [[nodiscard]] int column(double line) const;
  };
  // What a pixel sees: its own cell, and the projector point of the reference.
  struct Own {
    int cell;
    double line, column;
  };
  [[nodiscard]] int cell_at(int column, int step) const;
  [[nodiscard]] int first_step(double alpha) const;
  [[nodiscard]] Path epipolar_line(double alpha, double beta) const;
  [[nodiscard]] std::vector<rig::ProjectorPlace> curve(const rig::CameraPlace& place) const;
  [[nodiscard]] std::pair<int, int> columns_along(const std::vector<rig::ProjectorPlace>& curve) const;
  void find_through_lenses(const rig::CameraPlace& place, const Own& own, std::vector<Match>& matches) const;
  void add_run(int first, int last, int cell, const Own& own, std::vector<Match>& matches) const;
  void add(const Match& candidate, int cell, std::vector<Match>& matches) const;

  const rig::Rig* rig_;
  const SelfReference* reference_;
  MatchSettings settings_;
  std::vector<int> cells_;  // cells of the projector pixels, column by column, because the search goes along the lines
  std::vector<int> codes_;  // codes of the cells of a period
  std::vector<double> tan_theta_;
  std::optional<rig::RigOptics> optics_;     // none: pinholes
  mutable std::vector<int> column_of_step_;  // of the curve that is followed
};

// The words of one row of the camera image; those of one code lie side by side, column by column. The codes are ordered
// in planes by n, how many cells a match is nearer to the camera than the reference (modulo 2^m). The look-ups for a
// surface near the reference are therefore one run over rows, which the processor prefetches. With the reflected code
// this order has no meaning.
struct MatchRow {
  const std::uint16_t* first;  // the first word of plane 0
  std::ptrdiff_t plane;        // words from one plane to the next
  unsigned own;                // plane of code 0
  unsigned mask;               // 2^m - 1

  // `code` is in 0..2^m - 1.
  [[nodiscard]] const std::uint16_t* of(unsigned code) const {
    return first + static_cast<std::ptrdiff_t>((own - code) & mask) * plane;
  }
};

class MatchTable {
 public:
  // Searches all pixels. Throws as MatchSearch does.
  MatchTable(const rig::Rig& rig, const SelfReference& reference, const MatchSettings& settings);

  [[nodiscard]] int rows() const { return rows_; }
  [[nodiscard]] int columns() const { return columns_; }
  [[nodiscard]] int bits() const { return bits_; }

  // The word of model/gray_match for a pixel and a code 0..2^m - 1.
  [[nodiscard]] std::uint16_t word(int row, int column, int code) const {
    return this->row(row).of(static_cast<unsigned>(code))[column];
  }

  [[nodiscard]] MatchRow row(int row) const {
    return {words_.data() + static_cast<std::ptrdiff_t>(row) * columns_, plane_,
            static_cast<unsigned>(own_[static_cast<std::size_t>(row)]), (1U << static_cast<unsigned>(bits_)) - 1};
  }

  // The table as the circuit has it: 2^m words for each pixel, one pixel after another.
  [[nodiscard]] std::vector<std::uint16_t> by_pixels() const;

  // Over the pixels at which something can be matched: the share of codes without a match, and of codes with more than
  // one candidate, 0..1.
  [[nodiscard]] double missing() const { return missing_; }
  [[nodiscard]] double doubled() const { return doubled_; }

 private:
  int rows_, columns_, bits_;
  std::ptrdiff_t plane_;
  std::vector<int> own_;  // cell of each row of the camera
  std::vector<std::uint16_t> words_;
  double missing_ = 0, doubled_ = 0;
};

}  // namespace selfproj::structured_light

#endif  // SELFPROJ_HOST_STRUCTURED_LIGHT_MATCH_TABLE_H
