// Self-projected structured light: frames in, depth and difference from the reference out after every pair.
#ifndef SELFPROJ_HOST_STRUCTURED_LIGHT_SELF_SCANNER_H
#define SELFPROJ_HOST_STRUCTURED_LIGHT_SELF_SCANNER_H

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/structured_light/match_table.h"
#include "host/structured_light/self_reference.h"
#include "host/structured_light/sequence_check.h"
#include "selfproj/images/float_image.h"
#include "selfproj/model/column_moments.h"
#include "selfproj/rig/rig.h"
#include "selfproj/structured_light/fast_decoder.h"
#include "selfproj/structured_light/lens_triangulation.h"
#include "selfproj/structured_light/triangulation.h"

namespace selfproj::structured_light {

// The projector lines of the pixels of one row (model/gray_match), NaN if nothing is matched. `codes` and `ambiguous`
// are those of CodeImageView, table.columns() each. Allocates nothing.
void look_up_row(const MatchTable& table, int row, const std::uint8_t* codes, const std::uint8_t* ambiguous,
                 float* lines);

// Computes from - z for `count` pixels, NaN if either is NaN.
void subtract(const float* from, const float* z, std::ptrdiff_t count, float* difference);

class SelfScanner {
 public:
  // `threshold`: θ_b of (4.15). Allocates everything here; reference and table must outlive the scanner. Throws
  // std::invalid_argument if a size or setting does not fit, and UserError if depths through the rig's lenses cannot be
  // fitted.
  SelfScanner(const rig::Rig& rig, const SelfReference& reference, const MatchTable& table, int threshold,
              const DepthLimits& limits = {});

  // Takes a frame with its pattern index, by the rules of FastGrayDecoder. Returns true if there is a new depth image:
  // codes (4.15 to 4.18), match (4.19, 4.20), triangulation (4.8), difference. `good` is false for a flagged frame.
  bool add_frame(const model::ImageView& image, int pattern, bool good = true);

  // The next frame does not follow the one before: decoding begins anew.
  void restart() { decoder_.restart(); }

  // Takes a code image that was decoded elsewhere (on the board), rows x columns words. Codes of more than m bits are
  // not measurable.
  void add_codes(const std::uint16_t* words);

  // The newest depth image in mm, NaN for pixels without depth, and z_R - z in mm, positive towards the camera.
  [[nodiscard]] const images::FloatImage& depth() const { return depth_; }
  [[nodiscard]] const images::FloatImage& difference() const { return difference_; }

  // The matches in a row of the newest image, as look_up_row gives them. A depth image must have come.
  void newest_lines(int row, float* lines) const;

  // Depth of the reference, from X_R.
  [[nodiscard]] const images::FloatImage& reference_depth() const { return reference_depth_; }

  [[nodiscard]] const Triangulation& triangulation() const { return *triangulation_; }

  // The state of each pixel of the newest depth image: not_measurable because of the pair or the reference, no_line if
  // no cell of the reference is in the window.
  void explain(std::vector<PointState>& states) const;

  // How often the newest code counts on from a row to the next, beside the stripes of the reference at the same pixels:
  // 1 on a part parallel to the reference, less or more where it leans against it, below 0 where it counts backwards
  // (stripes of one bit, or reflected: never). Nothing where too few pixels tell.
  [[nodiscard]] std::optional<double> pace() const;

 private:
  void depth_of_lines(int row, const float* lines, float* z) const;
  void match(const std::uint8_t* codes, const std::uint8_t* ambiguous);

  const SelfReference* reference_;
  const MatchTable* table_;
  std::unique_ptr<Triangulation> triangulation_;
  const PlaneTriangulation* planes_ = nullptr;  // of pinholes, else null
  std::unique_ptr<LensLines> lenses_;           // of any other rig, else null
  FastGrayDecoder decoder_;
  std::vector<std::uint8_t> board_codes_, board_ambiguous_;  // from add_codes
  const std::uint8_t* codes_ = nullptr;                      // newest codes
  const std::uint8_t* ambiguous_ = nullptr;
  std::vector<float> lines_;  // lines of one row
  images::FloatImage depth_, difference_, reference_depth_;
};

// What the images of the newest cycle contradict, as the end of a message: each other (sequence_check.h), or the
// reference, of whose patterns the newest codes are not. Empty: nothing.
std::string contradiction_of(const SequenceCheck& check, const std::vector<std::string>& names,
                             const SelfScanner& scanner);

// What is less likely, but possible: surfaces that lean so against the reference everywhere.
std::string doubt_of(const SelfScanner& scanner);

// Why none of the pixels of a depth image has a point, likewise; empty if one has.
std::string reason_without_points(const DepthShares& shares);

}  // namespace selfproj::structured_light

#endif  // SELFPROJ_HOST_STRUCTURED_LIGHT_SELF_SCANNER_H
