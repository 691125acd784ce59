// Neighbourhood search (4.19, 4.20), worked out before the first frame: of every camera pixel and code the projector
// line that is matched.
#ifndef SELFPROJ_HOST_STRUCTURED_LIGHT_MATCH_TABLE_H
#define SELFPROJ_HOST_STRUCTURED_LIGHT_MATCH_TABLE_H

#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/rig/rig.h"
#include "host/structured_light/self_reference.h"
#include "model/gray_match.h"

namespace selfproj {

struct MatchSettings {
  int e = 0;  // cells below the reference that are searched, 0..2^m - 1

  // Where the text is followed as printed; both are wrong for references that vary (README.md beside this file).
  bool printed_direction = false;  // (4.19): along Xp at constant Yp, in place of the pixel's epipolar line
  bool printed_window = false;     // (4.20): -a' e <= line - X_R < a' (2^m - e), in place of cells of the reference
  double line_width = 3;           // a', projector lines, > 0; for the printed window alone
};

// What was found of one pixel and code.
struct Match {
  double line = 0;        // middle of the matched cell, projector line from 0
  double half_width = 0;  // of the cell, in lines
  int steps = 0;          // n: by how many cells the match lies towards the camera
  double distance = 0;    // from X_R to the match, in lines
  int candidates = 0;     // in the window; 0: there is no match and the rest means nothing
};

// The search itself, a pixel at a time. A camera pixel at row r, whose own cell is k = ⌊Xc / (a δc)⌋, has its
// correspondences on its epipolar line in the projector image, a straight line; along it the cells K of the reference
// (of f_R at the nearest projector pixel, in steps of a quarter of a line) make runs, and a run with
//     n = k - K,   -e <= n < 2^m - e
// is a candidate for the code of cell K (pieces less than 2.5 lines apart are one run). Of several the one with the
// smallest |n| is taken (printed window: nearest to X_R), then that nearer to the camera. Its place is the middle of
// the run, which has the reference's own fractions of a cell. Nothing is matched at pixels that the reference does not
// show (A_R = 0), and where z does not fall with θ (z0 tan α >= x0).
class MatchSearch {
 public:
  // Rig and reference must outlive the search. Throws std::invalid_argument where a setting is out of range or the
  // reference has not the rig's sizes.
  MatchSearch(const Rig& rig, const SelfReference& reference, const MatchSettings& settings);

  // Whether anything is matched at this pixel.
  [[nodiscard]] bool can_find(int row, int column) const;

  // `matches` gets 2^m entries, one a code.
  void find(int row, int column, std::vector<Match>& matches) const;

 private:
  // A straight line in the projector image.
  struct Path {
    double at_0, slope;
    [[nodiscard]] int column(double line) const;
  };
  [[nodiscard]] int cell_on(const Path& path, int step) const;
  [[nodiscard]] int first_step(double alpha) const;
  [[nodiscard]] Path epipolar_line(double alpha, double beta) const;
  void add(const Match& candidate, int cell, std::vector<Match>& matches) const;

  const Rig* rig_;
  const SelfReference* reference_;
  MatchSettings settings_;
  std::vector<int> cells_;  // of the projector pixels, column by column: the search goes along the lines
  std::vector<int> codes_;  // of the cells of a period
  std::vector<double> tan_theta_;
};

// The words of a row of the camera image, those of a code side by side by columns. Codes lie in planes by n, by how
// many cells they are nearer to the camera than the reference (modulo 2^m; so it is with the cyclic code, with the
// reflected one the order means nothing): what is looked up of a surface near the reference is then one run over rows,
// which the processor reads ahead, and not a piece of every code in turn.
struct MatchRow {
  const std::uint16_t* first;  // of plane 0
  std::ptrdiff_t plane;        // words from a plane to the next one
  unsigned own;                // plane of code 0
  unsigned mask;               // 2^m - 1

  // `code` is in 0..2^m - 1.
  [[nodiscard]] const std::uint16_t* of(unsigned code) const {
    return first + static_cast<std::ptrdiff_t>((own - code) & mask) * plane;
  }
};

class MatchTable {
 public:
  // Searches all pixels. Throws as MatchSearch.
  MatchTable(const Rig& rig, const SelfReference& reference, const MatchSettings& settings);

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

  // The table as the circuit has it: pixel by pixel, 2^m words each.
  [[nodiscard]] std::vector<std::uint16_t> by_pixels() const;

  // Of the pixels at which something can be matched, the share of codes without a match, and of codes with more than
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

}  // namespace selfproj

#endif  // SELFPROJ_HOST_STRUCTURED_LIGHT_MATCH_TABLE_H
