// A tolerance from good parts.
#ifndef SELFPROJ_HOST_PRODUCTION_LEARN_H
#define SELFPROJ_HOST_PRODUCTION_LEARN_H

#include <cstddef>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "host/production/classifier.h"
#include "host/production/cutter.h"
#include "host/production/height_map.h"
#include "host/production/part_reference.h"
#include "host/production/tolerance.h"
#include "selfproj/rig/rig.h"

namespace selfproj::production {

struct LearnOptions {
  double min_defect_mm2 = 0.5;  // area of the smallest defect
  double edge_mm = 1.5;         // strip along edges and walls that is not inspected
  double spreads = 6;           // standard deviations from the mean of the good parts to a limit
  double min_band_mm = 0.02;    // a limit is at least so far from the mean
  double max_shift_mm = 2;
  double max_turn_deg = 3;
};

// What a user should know of what was learned.
struct LearnRemarks {
  std::vector<std::string> left_out;  // parts that are not as the others, a reason each
  double unseen_mm2 = 0;              // of the regions, which most of the parts do not show (without_unseen)
  double regions_mm2 = 0;             // with them
  std::vector<std::string> doubts;    // why good parts and reference hardly belong together, or little is inspected
};

inline constexpr std::size_t kMinGoodParts = 5;
inline constexpr std::size_t kMaxGoodParts = 200;

// Collects good parts, and learns from them
//   - the outline: mean length and width; its middle across is that of the section, if the section has edges
//   - the regions: a rectangle for each stretch of the section between two walls (tolerance_regions), less what most of
//     the parts do not show (without_unseen)
//   - the band of each: mean over the parts of the highest level that the smallest area reaches (defect_levels), and
//     `spreads` standard deviations; likewise the lowest
//   - the share of missing points and the residual of the placement: mean and `spreads` standard deviations
//
// Of depth images, whose reference is a map, the outline is the whole view, parts lie where the reference did, and the
// regions are the surfaces of the reference (map_regions).
class Learner {
 public:
  Learner(const rig::Rig& rig, SectionReference section, const LearnOptions& options);
  Learner(const rig::Rig& rig, HeightCells reference, const LearnOptions& options);

  // Keeps the part's map. Parts after kMaxGoodParts are only counted.
  void add(CutPart&& part);

  [[nodiscard]] std::size_t parts() const { return parts_.size(); }
  [[nodiscard]] std::size_t not_kept() const { return not_kept_; }

  // Parts that are not as the others are left out, and named in `remarks`: those whose length, width,
  // heights or missing points are further from the parts' median than their spread explains, and those that cannot be
  // placed. Throws UserError, naming `source`, if fewer than kMinGoodParts came or remain, or no stretch between edges
  // is wide enough for a region.
  [[nodiscard]] Tolerance learn(const std::string& source, LearnRemarks* remarks = nullptr) const;

 private:
  // A reason for each part that is left out; empty for the others.
  using Reasons = std::vector<std::string>;
  // What the parts show of a region.
  struct Seen {
    RunningFigures low, high, missing;
  };
  void compare(const Classifier& classifier, const Tolerance& outline, Reasons& reasons, std::vector<Seen>& seen,
               RunningFigures& residual) const;
  [[nodiscard]] Tolerance outline(const std::string& source, Reasons& reasons) const;
  // The cells that more than half of the parts do not show, 255; parts with a reason do not count.
  [[nodiscard]] cv::Mat1b unseen(const Classifier& classifier, const MapGrid& grid, const Reasons& reasons) const;
  [[nodiscard]] std::vector<std::string> doubts_about(const Tolerance& tolerance, const std::vector<Seen>& seen,
                                                      const LearnRemarks& remarks) const;
  [[nodiscard]] Tolerance whole_view() const;
  // Throws UserError about `source` if none is left.
  void keep_regions_with_room(Tolerance& tolerance, const MapGrid& grid, const std::string& source) const;
  // Bands, missing places and residual, by what was seen of the good parts.
  void set_limits(Tolerance& tolerance, const std::vector<Seen>& seen, const RunningFigures& residual) const;
  [[nodiscard]] Classifier classifier_of(const Tolerance& tolerance, const std::string& source) const;

  rig::Rig rig_;
  std::optional<HeightCells> map_;  // the reference of depth images
  SectionReference section_;
  LearnOptions options_;
  std::vector<CutPart> parts_;
  std::size_t not_kept_ = 0;
};

// The rectangles of the outline, less a strip of edge_mm at its edges and at each wall and gap of the section; with
// bands of no meaning.
std::vector<ToleranceRegion> tolerance_regions(const Tolerance& outline, const SectionReference& section,
                                               double pitch_mm, double widest_mm, double edge_mm);

// Regions without the cells that are `unseen`, as by a shadow or a second line in the column, and without a strip of
// edge_mm around them. Where no square of `side` unseen cells fits, they stay. What the region surrounds is left out
// together with what is between it and the nearer end of the part. What falls apart becomes several regions.
std::vector<ToleranceRegion> without_unseen(const std::vector<ToleranceRegion>& regions, const cv::Mat1b& unseen,
                                            const MapGrid& grid, double edge_mm, int side);

// The surfaces of a reference as polygons on its placed map: each connected stretch of places that can be compared
// with, less a strip of edge_mm at its border, if it has at least 16 times the smallest area. A surface within another
// one belongs to both. The bands have no meaning.
std::vector<ToleranceRegion> map_regions(const images::FloatImage& comparable, const MapGrid& grid, double edge_mm,
                                         double min_defect_mm2);

}  // namespace selfproj::production

#endif  // SELFPROJ_HOST_PRODUCTION_LEARN_H
