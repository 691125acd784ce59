// Pixels of the camera and lines of the projector by the renderer's pinholes, independent of the host's triangulation,
// which is measured with them.
#ifndef SELFPROJ_LAB_CUBOIDS_H
#define SELFPROJ_LAB_CUBOIDS_H

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "host/structured_light/match_table.h"
#include "host/structured_light/self_reference.h"
#include "lab/evaluation.h"
#include "lab/structured_light.h"
#include "selfproj/images/float_image.h"
#include "selfproj/rig/rig.h"
#include "sim/scene/optics.h"
#include "sim/scene/renderer.h"
#include "sim/scene/virtual_capture.h"

namespace selfproj::lab {

// The point that a pixel (row by row, from 0) sees at depth z, mm.
inline sim::Point3 point_of_pixel(const rig::Rig& rig, std::size_t pixel, double z) {
  const auto columns = static_cast<std::size_t>(rig.camera.columns);
  const double scale = z * rig.camera.pixel_pitch_mm / rig.camera.focal_length_mm;
  const std::size_t row = pixel / columns;
  return {(static_cast<double>(row) - 0.5 * (rig.camera.rows - 1)) * scale,
          (static_cast<double>(pixel % columns) - 0.5 * (rig.camera.columns - 1)) * scale, z};
}

// The planes of light of the projector's lines (4.8). The rig must outlive them.
class LinePlanes {
 public:
  explicit LinePlanes(const rig::Rig& rig) : rig_(&rig), projector_(sim::Pinhole::of_projector(rig.projector)) {}

  // The depth, mm, at which the pixel's ray meets the plane of a line (from 0, with a fraction).
  [[nodiscard]] double z(std::size_t pixel, double line) const {
    const double middle = 0.5 * (rig_->projector.columns - 1);
    const sim::Point3 up = projector_.ray({line, middle});
    const sim::Point3 c = projector_.centre();
    const sim::Point3 ray = point_of_pixel(*rig_, pixel, 1);
    // The plane of the line contains the projector's centre, the direction `up` and y. Its normal is (up.z, 0, -up.x).
    return (up.z * c.x - up.x * c.z) / (up.z * ray.x - up.x);
  }

  // The projector's point (line, column) that lights what a pixel sees at depth z.
  [[nodiscard]] sim::PixelPoint light(std::size_t pixel, double z) const {
    return projector_.project(point_of_pixel(*rig_, pixel, z));
  }

 private:
  const rig::Rig* rig_;
  sim::Pinhole projector_;
};

// How often the neighbourhood search (4.19, 4.20) is wrong, measured against the truth.

// The matches of a scene's true codes, over all pixels that the projector lights and whose true place is in the window.
struct MatchShares {
  std::size_t pixels = 0;
  double wrong = 0;      // share whose match is off by more than half the cell and one line
  double none = 0;       // share without a match
  std::size_t far = 0;   // pixels 2^m cells or more from a step of the reference, in the camera's image
  double far_wrong = 0;  // share of those with a wrong match
};

// `true_z` and `reference_z` are the depths of the scene and of its reference, mm, NaN outside the projector's light.
// Shares are 0..1, NaN if there are no pixels.
MatchShares match_shares(const rig::Rig& rig, const structured_light::SelfReference& reference,
                         const structured_light::MatchSettings& settings, const images::FloatImage& true_z,
                         const images::FloatImage& reference_z);

// The faces of B4's cuboids, and how a depth image of each compares with the truth.
enum class Face : std::uint8_t { plane, low, letter, high, block_3, block_6, block_9, none };

// Without `none`, in the order of the enumeration.
inline constexpr std::array<const char*, 7> kFaceNames{"plane",   "low cuboid", "letter", "high cuboid",
                                                       "block 3", "block 6",    "block 9"};

// The face of `cuboids-marked` that each pixel sees, from the true z (mm, NaN: none). It is `none` within less than 3
// pixels of another face or of a pixel without one.
std::vector<Face> face_interiors(const rig::Rig& rig, const images::FloatImage& truth);

// A method's findings on one face, over the pixels with a depth and a difference; mm, NaN if there are none.
struct FaceFigures {
  std::size_t pixels = 0;
  std::size_t valid = 0;
  double height = 0;      // mean over the plane
  double difference = 0;  // mean difference from the reference
  double rms = 0;         // RMS error of z
  double most = 0;        // largest error of z; 0 if there are no pixels
  ErrorSpread errors;     // of z
  double width = 0;       // mean width of a code in z, over the pixels at which it is known
};

// The figures of each face but `none`.
class CuboidFigures {
 public:
  [[nodiscard]] const FaceFigures& operator[](Face face) const { return faces_.at(static_cast<std::size_t>(face)); }
  [[nodiscard]] FaceFigures& operator[](Face face) { return faces_.at(static_cast<std::size_t>(face)); }
  [[nodiscard]] auto begin() const { return faces_.begin(); }
  [[nodiscard]] auto end() const { return faces_.end(); }

 private:
  std::array<FaceFigures, kFaceNames.size()> faces_;
};

// `depth` and `truth` are z in mm; `difference` is from the reference. `code_width` is called for every pixel with a
// depth. It returns the width of the pixel's code in z, mm, or NaN if that is unknown.
CuboidFigures cuboid_figures(const rig::Rig& rig, const std::vector<Face>& faces, const images::FloatImage& depth,
                             const images::FloatImage& difference, const images::FloatImage& truth,
                             const std::function<double(std::size_t pixel)>& code_width);

// Experiment B4 in simulation: cuboids of different heights under self-projected structured light, compared with the
// conventional method.
struct CuboidsOptions {
  rig::Rig rig;
  sim::RenderOptions render;
  sim::ScanMethod scan = sim::ScanMethod::lines;
  int e = 8;  // e of (4.20)
  structured_light::Stripes stripes;
  std::vector<int> conventional_bits{8, 7, 6, 5, 4};  // the numbers of bits for the conventional method
};

// Scans the reference, `cuboids`, and measures `cuboids-marked` under the patterns made from the scan.
StructuredLightResult run_cuboids(const CuboidsOptions& options, const ProgressOfImages& progress);

}  // namespace selfproj::lab

#endif  // SELFPROJ_LAB_CUBOIDS_H
