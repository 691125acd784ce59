#include "lab/cuboids.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "host/images/image_files.h"
#include "host/report/map_picture.h"
#include "host/report/report.h"
#include "host/structured_light/match_table.h"
#include "host/structured_light/self_reference.h"
#include "host/structured_light/self_scanner.h"
#include "lab/structured_light.h"
#include "selfproj/rig/calibration.h"
#include "selfproj/structured_light/scanner.h"
#include "selfproj/structured_light/triangulation.h"
#include "sim/scene/optics.h"
#include "sim/scene/pattern_renderer.h"
#include "sim/scene/scene.h"
#include "sim/scene/scenes.h"
#include "sim/scene/virtual_capture.h"

namespace selfproj::lab {
namespace {

// Marks the pixels with a step (neighbours more than 1 mm apart in z, or the edge of a shadow) within `reach` pixels
// along rows and columns.
std::vector<std::uint8_t> steps_within(const images::FloatImage& z, int reach) {
  const auto at = [&](int r, int c) {
    return static_cast<std::size_t>(r) * static_cast<std::size_t>(z.columns) + static_cast<std::size_t>(c);
  };
  const auto differ = [&](std::size_t a, std::size_t b) {
    return std::isnan(z.values[a]) != std::isnan(z.values[b]) || std::abs(z.values[a] - z.values[b]) > 1;
  };
  std::vector<std::uint8_t> steps(z.values.size(), 0);
  for (int r = 0; r < z.rows; ++r) {
    for (int c = 0; c < z.columns; ++c) {
      const bool down = r + 1 < z.rows && differ(at(r, c), at(r + 1, c));
      const bool right = c + 1 < z.columns && differ(at(r, c), at(r, c + 1));
      steps[at(r, c)] = down || right ? 1 : 0;
    }
  }
  std::vector<std::uint8_t> along = steps;
  for (int r = 0; r < z.rows; ++r) {
    for (int c = 0; c < z.columns; ++c) {
      for (int k = std::max(0, c - reach); k <= std::min(z.columns - 1, c + reach) && along[at(r, c)] == 0; ++k) {
        along[at(r, c)] = steps[at(r, k)];
      }
    }
  }
  std::vector<std::uint8_t> result = along;
  for (int r = 0; r < z.rows; ++r) {
    for (int c = 0; c < z.columns; ++c) {
      for (int k = std::max(0, r - reach); k <= std::min(z.rows - 1, r + reach) && result[at(r, c)] == 0; ++k) {
        result[at(r, c)] = along[at(k, c)];
      }
    }
  }
  return result;
}

}  // namespace

MatchShares match_shares(const rig::Rig& rig, const structured_light::SelfReference& reference,
                         const structured_light::MatchSettings& settings, const images::FloatImage& true_z,
                         const images::FloatImage& reference_z) {
  const structured_light::MatchSearch search(rig, reference, settings);
  const LinePlanes planes(rig);
  const int codes = 1 << reference.stripes.bits;
  const std::vector<std::uint8_t> near = steps_within(reference_z, codes * reference.stripes.width);
  std::vector<structured_light::Match> matches;
  MatchShares shares;
  std::size_t wrong = 0;
  std::size_t missing = 0;
  std::size_t far_wrong = 0;
  for (std::size_t i = 0; i < true_z.values.size(); ++i) {
    const auto columns = static_cast<std::size_t>(rig.camera.columns);
    const int row = static_cast<int>(i / columns);
    const int column = static_cast<int>(i % columns);
    if (std::isnan(true_z.values[i]) || !search.can_find(row, column)) {
      continue;
    }
    const sim::PixelPoint light = planes.light(i, static_cast<double>(true_z.values[i]));
    const auto line = static_cast<int>(std::lround(light.row));
    const auto across = static_cast<int>(std::lround(light.column));
    if (line < 0 || line >= rig.projector.lines || across < 0 || across >= rig.projector.columns) {
      continue;
    }
    const int cell = reference.cell(line, across);
    const int n = structured_light::cell_of_row(row, rig.camera.rows, reference.stripes.width) - cell;
    if (n < -settings.e || n >= codes - settings.e) {
      continue;
    }
    search.find(row, column, matches);
    const structured_light::Match& match =
        matches[static_cast<std::size_t>(structured_light::code_of_cell(reference.stripes, cell))];
    const bool is_wrong = match.candidates > 0 && std::abs(match.line - light.row) > match.half_width + 1;
    ++shares.pixels;
    missing += match.candidates == 0 ? 1 : 0;
    wrong += is_wrong ? 1 : 0;
    if (near[i] == 0) {
      ++shares.far;
      far_wrong += is_wrong ? 1 : 0;
    }
  }
  shares.wrong = static_cast<double>(wrong) / static_cast<double>(shares.pixels);
  shares.none = static_cast<double>(missing) / static_cast<double>(shares.pixels);
  shares.far_wrong = static_cast<double>(far_wrong) / static_cast<double>(shares.far);
  return shares;
}

namespace {

Face face_of(const rig::Rig& rig, const sim::Point3& p) {
  const double height = rig.plane_z_mm - p.z;
  const auto is = [&](double wanted) { return std::abs(height - wanted) < 0.05; };
  const auto in = [&](const sim::Box& box) { return p.x > box.x0 && p.x < box.x1 && p.y > box.y0 && p.y < box.y1; };
  if (is(0)) {
    return Face::plane;
  }
  if (in(sim::Cuboids::kLowPart.box)) {
    return is(sim::Cuboids::kLow)                                ? Face::low
           : is(sim::Cuboids::kLow - sim::Cuboids::kLetterDepth) ? Face::letter
                                                                 : Face::none;
  }
  if (in(sim::Cuboids::kHighPart.box)) {
    constexpr std::array<Face, 3> kBlocks{Face::block_3, Face::block_6, Face::block_9};
    for (std::size_t i = 0; i < kBlocks.size(); ++i) {
      if (is(sim::Cuboids::kHigh + sim::Cuboids::kBlockHeights.at(i))) {
        return kBlocks.at(i);
      }
    }
    return is(sim::Cuboids::kHigh) ? Face::high : Face::none;
  }
  return Face::none;
}

}  // namespace

std::vector<Face> face_interiors(const rig::Rig& rig, const images::FloatImage& truth) {
  constexpr int kMargin = 3;
  std::vector<Face> all(truth.values.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    all[i] = std::isnan(truth.values[i]) ? Face::none
                                         : face_of(rig, point_of_pixel(rig, i, static_cast<double>(truth.values[i])));
  }
  const auto index = [&](int row, int column) {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(truth.columns) + static_cast<std::size_t>(column);
  };
  std::vector<Face> inner(all.size(), Face::none);
  for (int r = kMargin; r + kMargin < truth.rows; ++r) {
    for (int c = kMargin; c + kMargin < truth.columns; ++c) {
      bool even = true;
      for (int dr = -kMargin; dr <= kMargin && even; ++dr) {
        for (int dc = -kMargin; dc <= kMargin && even; ++dc) {
          even = all[index(r + dr, c + dc)] == all[index(r, c)];
        }
      }
      if (even) {
        inner[index(r, c)] = all[index(r, c)];
      }
    }
  }
  return inner;
}

CuboidFigures cuboid_figures(const rig::Rig& rig, const std::vector<Face>& faces, const images::FloatImage& depth,
                             const images::FloatImage& difference, const images::FloatImage& truth,
                             const std::function<double(std::size_t pixel)>& code_width) {
  CuboidFigures figures;
  std::array<std::size_t, kFaceNames.size()> widths{};  // number of known widths of each face
  for (std::size_t i = 0; i < faces.size(); ++i) {
    if (faces[i] == Face::none) {
      continue;
    }
    FaceFigures& face = figures[faces[i]];
    ++face.pixels;
    const auto z = static_cast<double>(depth.values[i]);
    const auto from_reference = static_cast<double>(difference.values[i]);
    if (std::isnan(z) || std::isnan(from_reference)) {
      face.errors.add(std::numeric_limits<double>::quiet_NaN());
      continue;
    }
    ++face.valid;
    const double error = z - static_cast<double>(truth.values[i]);
    face.errors.add(error);
    face.height += rig.plane_z_mm - z;
    face.difference += from_reference;
    face.rms += error * error;
    face.most = std::max(face.most, std::abs(error));
    const double width = code_width(i);
    if (!std::isnan(width)) {
      face.width += width;
      ++widths.at(static_cast<std::size_t>(faces[i]));
    }
  }
  for (std::size_t k = 0; k < kFaceNames.size(); ++k) {
    FaceFigures& face = figures[static_cast<Face>(k)];
    const auto count = static_cast<double>(face.valid);  // NaN if there is none
    face.height /= count;
    face.difference /= count;
    face.rms = std::sqrt(face.rms / count);
    face.width /= static_cast<double>(widths.at(k));
  }
  return figures;
}

namespace {

// Both scenes in front of the camera, and their truth.
struct Stage {
  explicit Stage(const CuboidsOptions& experiment)
      : options(experiment),
        rig(experiment.rig),
        reference_scene(sim::make_scene("cuboids", rig)),
        part_scene(sim::make_scene("cuboids-marked", rig)),
        reference(rig, *reference_scene, options.render),
        part(rig, *part_scene, options.render),
        truth(rig.camera.rows, rig.camera.columns),
        lit(truth),
        reference_z(truth),
        planes(rig) {
    part.depth(0, truth.values);
    part.lit_depth(0, lit.values);
    reference.lit_depth(0, reference_z.values);
    faces = face_interiors(rig, lit);
  }

  const CuboidsOptions& options;
  const rig::Rig& rig;
  std::unique_ptr<sim::Scene> reference_scene, part_scene;
  sim::PatternRenderer reference, part;
  images::FloatImage truth;        // z of the part, mm
  images::FloatImage lit;          // the same, NaN outside the projector's light
  images::FloatImage reference_z;  // z of the reference, mm
  LinePlanes planes;
  std::vector<Face> faces;
};

// The results of a method.
struct Method {
  std::string name;
  images::FloatImage depth, difference;
  CuboidFigures figures;
};

// The width in z of the cell whose match is the true one for a pixel; NaN if there is no match.
double width_of_match(const Stage& stage, const structured_light::MatchSearch& search, std::size_t pixel,
                      std::vector<structured_light::Match>& matches) {
  const sim::PixelPoint light = stage.planes.light(pixel, static_cast<double>(stage.truth.values[pixel]));
  const int columns = stage.rig.camera.columns;
  search.find(static_cast<int>(pixel) / columns, static_cast<int>(pixel) % columns, matches);
  for (const structured_light::Match& match : matches) {
    if (match.candidates > 0 && std::abs(match.line - light.row) <= match.half_width + 0.5) {
      return stage.planes.z(pixel, match.line - match.half_width) -
             stage.planes.z(pixel, match.line + match.half_width);
    }
  }
  return std::numeric_limits<double>::quiet_NaN();
}

Method measure_self_projected(const Stage& stage, const structured_light::SelfReference& reference,
                              const std::function<void()>& done, report::ReportPage& page) {
  const rig::Rig& rig = stage.rig;
  const int bits = reference.stripes.bits;
  const structured_light::MatchSettings settings{.e = stage.options.e};
  const structured_light::MatchTable table(rig, reference, settings);
  structured_light::SelfScanner scanner(rig, reference, table, rig.measure.code_threshold);
  const int finest = 2 * bits - 2;
  page.pictures.push_back(
      {"Finest self-projected pattern",
       images::encode_png(sim::pattern_image(structured_light::self_projected_pattern(reference, finest))), ""});
  scan_cycle(
      stage.part, 0, bits, [&](int i) { return structured_light::self_projected_pattern(reference, i); },
      [&](int i, const model::ImageView& image) {
        if (i == finest) {
          page.pictures.push_back({"Camera image, finest stripes", images::encode_png(images::copy_of(image)), ""});
        }
        done();
      },
      scanner);
  Method method{fmt::format("self-projected, {} bits", bits), scanner.depth(), scanner.difference(), {}};
  const structured_light::MatchSearch search(rig, reference, settings);
  std::vector<structured_light::Match> matches;
  method.figures = cuboid_figures(rig, stage.faces, method.depth, method.difference, stage.truth,
                                  [&](std::size_t i) { return width_of_match(stage, search, i, matches); });
  return method;
}

// Measures with codes of `bits` bits over the central lines, with the median.
Method measure_conventional(const Stage& stage, int bits, const std::function<void()>& done) {
  const rig::Rig& rig = stage.rig;
  const structured_light::PlaneTriangulation triangulation(rig, bits, {}, rig::central_lines(rig, kCodedLines, bits));
  const auto depth_of = [&](const sim::PatternRenderer& renderer, int first) {
    structured_light::Scanner scanner(triangulation, {.threshold = rig.measure.code_threshold});
    scan_cycle(
        renderer, first, bits, [&](int i) { return structured_light::gray_pattern(rig, bits, kCodedLines, i); },
        [&](int /*i*/, const model::ImageView& /*image*/) { done(); }, scanner);
    return scanner.depth();
  };
  Method method;
  method.name = fmt::format("conventional, {} bits", bits);
  method.depth = depth_of(stage.part, 0);
  method.difference = minus(depth_of(stage.reference, 1000), method.depth);
  const double half = 0.5 * kCodedLines / (1 << bits);
  method.figures = cuboid_figures(rig, stage.faces, method.depth, method.difference, stage.truth, [&](std::size_t i) {
    const double line = stage.planes.light(i, static_cast<double>(stage.truth.values[i])).row;
    return stage.planes.z(i, line - half) - stage.planes.z(i, line + half);
  });
  return method;
}

// --- tables ---

report::ReportTable heights_table(const std::vector<Method>& methods) {
  report::ReportTable table{
      "B4: mean heights of the faces' interiors, mm",
      {"", "low cuboid", "high cuboid", "letter", "block 3", "block 6", "block 9"},
      {{"true", "25", "109", "2", "3", "6", "9"},
       {"published, self-projected 4 bits", "25.83", "108.55", "2.70 or less", "2.78", "5.38", "9.28"},
       {"published, conventional 8 bits", "within 0.56", "within 1.41", "–", "–", "–", "–"}},
      "Over the plane; letter and blocks: difference from the reference. Interiors are 3 pixels and more "
      "from the faces' edges. Camera noise on."};
  for (const Method& method : methods) {
    const CuboidFigures& f = method.figures;
    table.rows.push_back({method.name, figure_text(f[Face::low].height), figure_text(f[Face::high].height),
                          figure_text(-f[Face::letter].difference), figure_text(f[Face::block_3].difference),
                          figure_text(f[Face::block_6].difference), figure_text(f[Face::block_9].difference)});
  }
  return table;
}

report::ReportTable errors_table(const std::vector<Method>& methods) {
  report::ReportTable table{"B4: error of z per pixel, mm: RMS / largest / one code's width in z",
                            {"", "plane", "low cuboid", "high cuboid", "letter", "block 3", "block 6", "block 9"},
                            {},
                            "Over the same pixels."};
  for (const Method& method : methods) {
    table.rows.push_back({method.name});
    for (const Face face :
         {Face::plane, Face::low, Face::high, Face::letter, Face::block_3, Face::block_6, Face::block_9}) {
      const FaceFigures& f = method.figures[face];
      table.rows.back().push_back(
          fmt::format("{} / {} / {}", figure_text(f.rms), figure_text(f.most), figure_text(f.width)));
    }
  }
  return table;
}

// What RMS and mean do not show: single pixels that are far off, on the plane above all.
report::ReportTable spread_table(const std::vector<Method>& methods) {
  report::ReportTable table{
      "B4: error of z per pixel, mm: median / 99 % / 99.9 % / largest, and the share that is more than 10 mm off",
      {""},
      {},
      "Over the same pixels. The plane is the largest face."};
  for (const char* name : kFaceNames) {
    table.header.emplace_back(name);
  }
  for (const Method& method : methods) {
    table.rows.push_back({method.name});
    for (const FaceFigures& face : method.figures) {
      const ErrorSpread& e = face.errors;
      table.rows.back().push_back(fmt::format("{} / {} / {} / {}, {:.3f} %", figure_text(e.quantile(0.5)),
                                              figure_text(e.quantile(0.99)), figure_text(e.quantile(0.999)),
                                              figure_text(e.quantile(1)), 100 * e.beyond(10)));
    }
  }
  return table;
}

// The errors of the plane in columns of their own, for its goal.
report::ReportTable plane_table(const std::vector<Method>& methods) {
  report::ReportTable table{
      "B4: error of z on the plane", {"", "RMS, mm", "largest, mm", "more than 10 mm off, %"}, {}};
  for (const Method& method : methods) {
    const FaceFigures& plane = method.figures[Face::plane];
    table.rows.push_back(
        {method.name, figure_text(plane.rms), figure_text(plane.most), figure_text(100 * plane.errors.beyond(10), 3)});
  }
  return table;
}

report::ReportTable valid_table(const std::vector<Method>& methods) {
  report::ReportTable table{"B4: share of the interiors' pixels that have a depth, %", {""}, {}};
  for (const char* name : kFaceNames) {
    table.header.emplace_back(name);
  }
  for (const Method& method : methods) {
    table.rows.push_back({method.name});
    for (const FaceFigures& face : method.figures) {
      table.rows.back().push_back(
          figure_text(100 * static_cast<double>(face.valid) / static_cast<double>(face.pixels), 1));
    }
  }
  return table;
}

// Both codes and both searches. If the one in use fails what the project asks of it, this is added to `not_reached`.
report::ReportTable shares_table(const Stage& stage, const structured_light::SelfReference& reference,
                                 std::vector<std::string>& not_reached) {
  report::ReportTable table{
      "B4: wrong matches of true codes",
      {"", "pixels", "wrong", "none", "16 cells or more from steps", "of these wrong"},
      {},
      "Of the pixels in the projector's light whose true place is in the window. Printed: along Xp at "
      "constant Yp, window of 48 lines."};
  for (const structured_light::StripeCode code :
       {structured_light::StripeCode::cyclic, structured_light::StripeCode::reflected}) {
    for (const bool printed : {false, true}) {
      structured_light::SelfReference variant = reference;
      variant.stripes.code = code;
      const structured_light::MatchSettings settings{
          .e = stage.options.e, .printed_direction = printed, .printed_window = printed, .line_width = 3};
      const MatchShares s = match_shares(stage.rig, variant, settings, stage.lit, stage.reference_z);
      table.rows.push_back(
          {fmt::format("{} code, {} search", code == structured_light::StripeCode::cyclic ? "cyclic" : "reflected",
                       printed ? "printed" : "corrected"),
           std::to_string(s.pixels), fmt::format("{:.3f} %", 100 * s.wrong), fmt::format("{:.2f} %", 100 * s.none),
           std::to_string(s.far), fmt::format("{:.3f} %", 100 * s.far_wrong)});
      if (code == structured_light::StripeCode::cyclic && !printed && s.far_wrong > 0) {
        not_reached.emplace_back("matches 16 cells or more from steps are wrong");
      }
    }
  }
  return table;
}

report::ReportTable scan_table(const structured_light::SelfReference& reference, const LinePlanes& planes,
                               const images::FloatImage& reference_z, sim::ScanMethod scan) {
  double square = 0;
  double most = 0;
  std::size_t count = 0;
  std::size_t lit = 0;
  for (std::size_t i = 0; i < reference_z.values.size(); ++i) {
    lit += std::isnan(reference_z.values[i]) ? 0U : 1U;
    if (reference.measurable(i) && !std::isnan(reference_z.values[i])) {
      const sim::PixelPoint truth = planes.light(i, static_cast<double>(reference_z.values[i]));
      const double error = static_cast<double>(reference.points.line.values[i]) - truth.row;
      // Beyond this it is another surface, because at edges the truth is that of the pixel's centre.
      if (std::abs(error) < 8) {
        square += error * error;
        most = std::max(most, std::abs(error));
        ++count;
      }
    }
  }
  return {
      fmt::format("Scan of the reference: {}",
                  scan == sim::ScanMethod::gray_codes ? "Gray codes, 42 images" : "lines, 1792 images"),
      {"", "lit pixels measured", "line, RMS", "line, largest"},
      {{"X_R against the truth", fmt::format("{:.1f} %", 100 * static_cast<double>(count) / static_cast<double>(lit)),
        figure_text(std::sqrt(square / static_cast<double>(count)), 3), figure_text(most)}}};
}

void check_figures(const CuboidFigures& f, std::vector<std::string>& not_reached) {
  const auto wanted = [&](const char* what, double value, double truth, double bound) {
    if (!(std::abs(value - truth) <= bound)) {
      not_reached.push_back(fmt::format("{} is {:.2f} mm; {} ± {} mm is wanted", what, value, truth, bound));
    }
  };
  wanted("the low cuboid's height", f[Face::low].height, sim::Cuboids::kLow, 0.83);
  wanted("the high cuboid's height", f[Face::high].height, sim::Cuboids::kHigh, 0.45);
  wanted("the letter's depth", -f[Face::letter].difference, sim::Cuboids::kLetterDepth, 0.70);
  wanted("the plane's error of z, RMS,", f[Face::plane].rms, 0, kHalfPixelOnPlane);
  constexpr std::array<double, 3> kBounds{0.22, 0.62, 0.28};  // for the published 2.78, 5.38, 9.28
  for (std::size_t i = 0; i < kBounds.size(); ++i) {
    const auto block = static_cast<std::size_t>(Face::block_3) + i;
    wanted(kFaceNames.at(block), f[static_cast<Face>(block)].difference, sim::Cuboids::kBlockHeights.at(i),
           kBounds.at(i));
  }
}

// --- pictures ---

enum class Axis { x, y };

// Height over the plane along the middle row (y) or column (x).
report::ReportPlot profile(const rig::Rig& rig, const std::string& name, const images::FloatImage& depth,
                           const images::FloatImage& truth, Axis axis) {
  const bool along_row = axis == Axis::y;
  report::ReportPlot plot{fmt::format("{}: profile through the centre, {}", name, along_row ? "along y" : "along x"),
                          along_row ? "column" : "row",
                          "height, mm",
                          {{{}, {}, "a", "measured"}, {{}, {}, "b", "truth"}},
                          1};
  const int count = along_row ? depth.columns : depth.rows;
  for (int i = 0; i < count; ++i) {
    const int r = along_row ? depth.rows / 2 : i;
    const int c = along_row ? i : depth.columns / 2;
    for (std::size_t k = 0; k < 2; ++k) {
      const float z = k == 0 ? depth.row(r)[c] : truth.row(r)[c];
      plot.traces[k].x.push_back(i);
      plot.traces[k].y.push_back(rig.plane_z_mm - static_cast<double>(z));
    }
  }
  return plot;
}

images::FloatImage height_of(const rig::Rig& rig, const images::FloatImage& depth) {
  images::FloatImage height = depth;
  for (float& value : height.values) {
    value = static_cast<float>(rig.plane_z_mm) - value;
  }
  return height;
}

void add_pictures(const Stage& stage, const std::vector<Method>& methods, report::ReportPage& page) {
  const rig::Rig& rig = stage.rig;
  const double pixel = rig.plane_z_mm * rig.camera.pixel_pitch_mm / rig.camera.focal_length_mm;
  const report::MapPitch pitch{pixel, pixel};
  const report::MapScale height_colours{report::ColourMap::sequential, 0, 125};
  for (const Method& method : methods) {
    page.pictures.push_back(
        report::shown_map(method.name + ": height", height_of(rig, method.depth), height_colours, pitch));
    page.pictures.push_back(report::shown_map(method.name + ": difference from the reference", method.difference,
                                              {report::ColourMap::diverging, -12, 12}, pitch));
    page.plots.push_back(profile(rig, method.name, method.depth, stage.truth, Axis::y));
    page.plots.push_back(profile(rig, method.name, method.depth, stage.truth, Axis::x));
  }
}

std::size_t all_images(const CuboidsOptions& options) {
  int all = sim::scan_images(options.rig, options.scan) + 2 * options.stripes.bits;
  for (const int bits : options.conventional_bits) {
    all += 4 * bits;  // the reference and the part
  }
  return static_cast<std::size_t>(all);
}

}  // namespace

StructuredLightResult run_cuboids(const CuboidsOptions& options, const ProgressOfImages& progress) {
  const rig::Rig& rig = options.rig;
  const std::size_t all = all_images(options);
  std::size_t done = 0;
  const auto count = [&] { progress(++done, all); };

  const Stage stage(options);
  const structured_light::ProjectorPoints points =
      sim::scan_points(rig, *stage.reference_scene, options.render, options.scan, count);
  const structured_light::SelfReference reference = structured_light::make_self_reference(rig, points, options.stripes);
  StructuredLightResult result;
  std::vector<Method> methods;
  methods.push_back(measure_self_projected(stage, reference, count, result.page));
  for (const int bits : options.conventional_bits) {
    methods.push_back(measure_conventional(stage, bits, count));
  }
  result.tables = {heights_table(methods),
                   errors_table(methods),
                   valid_table(methods),
                   shares_table(stage, reference, result.not_reached),
                   scan_table(reference, stage.planes, stage.reference_z, options.scan),
                   spread_table(methods),
                   plane_table(methods)};
  check_figures(methods[0].figures, result.not_reached);
  add_pictures(stage, methods, result.page);
  result.page.title = "Experiment B4";
  result.page.subtitle = "Cuboids of different heights: self-projected structured light beside the conventional method";
  result.page.tables = result.tables;
  result.page.settings = {
      {"e", "e", static_cast<std::int64_t>(options.e)},
      {"a", "a, camera rows a code", static_cast<std::int64_t>(options.stripes.width)},
      {"threshold", "threshold of the binarization", static_cast<std::int64_t>(rig.measure.code_threshold)},
      {"seed", "seed", rig.imaging.seed}};
  result.depth = std::move(methods[0].depth);
  result.difference = std::move(methods[0].difference);
  result.truth = stage.truth;
  return result;
}

}  // namespace selfproj::lab
