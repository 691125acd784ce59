#include "sim/experiment/structured_light.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "host/report/depth_output.h"
#include "host/report/map_picture.h"
#include "host/structured_light/gray_sequence.h"
#include "host/structured_light/scanner.h"
#include "host/structured_light/self_scanner.h"
#include "host/structured_light/triangulation.h"
#include "sim/scene/parallel.h"
#include "sim/scene/pattern_renderer.h"
#include "sim/scene/pinhole.h"
#include "sim/scene/scene_list.h"
#include "sim/scene/self_scenes.h"

namespace selfproj {
namespace {

// Renders the images under pattern(0), pattern(1), ... and hands them over in their order.
void take_images(const PatternRenderer& renderer, const RenderOptions& options, int first, int count,
                 const std::function<Image(int)>& pattern, const std::function<void(int, const ImageView&)>& take,
                 const std::function<void()>& done) {
  constexpr int kBatch = 8;
  const Rig& rig = renderer.rig();
  std::array<std::vector<std::uint8_t>, kBatch> images;
  for (int begin = 0; begin < count; begin += kBatch) {
    const int size = std::min(kBatch, count - begin);
    parallel_for(size, 0, [&](int i) {
      auto& image = images.at(static_cast<std::size_t>(i));
      image.resize(rig.camera.pixels());
      const ProjectedLight light = project_image(rig, pattern(begin + i), options.projector_blur);
      renderer.render(first + begin + i, light, std::span(image));
    });
    for (int i = 0; i < size; ++i) {
      take(begin + i,
           {images.at(static_cast<std::size_t>(i)).data(), rig.camera.rows, rig.camera.columns, rig.camera.columns});
      done();
    }
  }
}

// --- B4 ---

enum Face : std::uint8_t { plane, low, letter, high, block_3, block_6, block_9, faces, none = 255 };
constexpr std::array<const char*, faces> kFaceNames{"plane",   "low cuboid", "letter", "high cuboid",
                                                    "block 3", "block 6",    "block 9"};

struct Place {
  double x, y, z;
};

Place place_of(const Rig& rig, std::size_t pixel, double z) {
  const auto columns = static_cast<std::size_t>(rig.camera.columns);
  const double scale = z * rig.camera.pixel_pitch_mm / rig.camera.focal_length_mm;
  const std::size_t row = pixel / columns;
  return {(static_cast<double>(row) - 0.5 * (rig.camera.rows - 1)) * scale,
          (static_cast<double>(pixel % columns) - 0.5 * (rig.camera.columns - 1)) * scale, z};
}

Face face_of(const Rig& rig, const Place& p) {
  const double height = rig.plane_z_mm - p.z;
  const auto is = [&](double wanted) { return std::abs(height - wanted) < 0.05; };
  const auto in = [&](const Box& box) { return p.x > box.x0 && p.x < box.x1 && p.y > box.y0 && p.y < box.y1; };
  if (is(0)) {
    return plane;
  }
  if (in(Cuboids::kLowPart.box)) {
    return is(Cuboids::kLow) ? low : is(Cuboids::kLow - Cuboids::kLetterDepth) ? letter : none;
  }
  if (in(Cuboids::kHighPart.box)) {
    for (std::size_t i = 0; i < Cuboids::kBlocks.size(); ++i) {
      if (is(Cuboids::kHigh + Cuboids::kBlockHeights.at(i))) {
        return static_cast<Face>(block_3 + i);
      }
    }
    return is(Cuboids::kHigh) ? high : none;
  }
  return none;
}

// The face of each pixel, 3 pixels and more inside of its edges; none elsewhere.
std::vector<Face> interiors(const Rig& rig, const FloatImage& truth) {
  constexpr int kMargin = 3;
  std::vector<Face> all(truth.values.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    all[i] = std::isnan(truth.values[i]) ? none : face_of(rig, place_of(rig, i, static_cast<double>(truth.values[i])));
  }
  std::vector<Face> inner(all.size(), none);
  for (int r = kMargin; r + kMargin < truth.rows; ++r) {
    for (int c = kMargin; c + kMargin < truth.columns; ++c) {
      const auto at = [&](int row, int column) {
        return all[static_cast<std::size_t>(row) * static_cast<std::size_t>(truth.columns) +
                   static_cast<std::size_t>(column)];
      };
      bool even = true;
      for (int dr = -kMargin; dr <= kMargin && even; ++dr) {
        for (int dc = -kMargin; dc <= kMargin && even; ++dc) {
          even = at(r + dr, c + dc) == at(r, c);
        }
      }
      if (even) {
        inner[static_cast<std::size_t>(r) * static_cast<std::size_t>(truth.columns) + static_cast<std::size_t>(c)] =
            at(r, c);
      }
    }
  }
  return inner;
}

// What a method finds of one face.
struct FaceFigures {
  std::size_t pixels = 0;
  std::size_t valid = 0;
  double height = 0;      // mean over the plane
  double difference = 0;  // mean, from the reference
  double rms = 0;         // of z against the truth
  double most = 0;        // likewise
  double width = 0;       // mean of a code's width in z
};
using Figures = std::array<FaceFigures, faces>;

struct Method {
  std::string name;
  FloatImage depth, difference;
  Figures figures;
};

void evaluate(const Rig& rig, const FloatImage& truth, const std::vector<Face>& inner,
              const std::function<double(std::size_t pixel)>& width, Method& method) {
  for (std::size_t i = 0; i < inner.size(); ++i) {
    if (inner[i] == none) {
      continue;
    }
    FaceFigures& face = method.figures.at(inner[i]);
    ++face.pixels;
    const auto z = static_cast<double>(method.depth.values[i]);
    const auto difference = static_cast<double>(method.difference.values[i]);
    if (std::isnan(z) || std::isnan(difference)) {
      continue;
    }
    ++face.valid;
    const double error = z - static_cast<double>(truth.values[i]);
    face.height += rig.plane_z_mm - z;
    face.difference += difference;
    face.rms += error * error;
    face.most = std::max(face.most, std::abs(error));
    face.width += width(i);
  }
  for (FaceFigures& face : method.figures) {
    const auto count = static_cast<double>(face.valid);  // NaN where there is none
    face.height /= count;
    face.difference /= count;
    face.rms = std::sqrt(face.rms / count);
    face.width /= count;
  }
}

// z of a projector line seen by a pixel of this row (4.8), by matrices of the simulation's own: the pixel's ray meets
// the plane of the line.
class LinePlanes {
 public:
  explicit LinePlanes(const Rig& rig) : rig_(&rig), projector_(Pinhole::of_projector(rig.projector)) {}
  [[nodiscard]] double z(std::size_t pixel, double line) const {
    const double middle = 0.5 * (rig_->projector.columns - 1);
    const Point3 up = projector_.ray({line, middle});
    const Point3 c = projector_.centre();
    const Place ray = place_of(*rig_, pixel, 1);
    // The line's plane holds the projector's centre, the direction `up` and y: normal (up.z, 0, -up.x).
    return (up.z * c.x - up.x * c.z) / (up.z * ray.x - up.x);
  }
  [[nodiscard]] PixelPoint light(std::size_t pixel, double z) const {
    const Place p = place_of(*rig_, pixel, z);
    return projector_.project({p.x, p.y, p.z});
  }

 private:
  const Rig* rig_;
  Pinhole projector_;
};

// A depth image of the conventional method: m bits over the central lines, median.
Method conventional(const StructuredLightOptions& options, const PatternRenderer& reference,
                    const PatternRenderer& part, int bits, const std::function<void()>& done) {
  const Rig& rig = options.rig;
  const PlaneTriangulation triangulation(rig, bits, {}, kCodedLines);
  const auto depth_of = [&](const PatternRenderer& renderer, int first) {
    Scanner scanner(triangulation, {rig.measure.code_threshold, true, false, 5});
    std::vector<std::uint8_t> positive;
    take_images(
        renderer, options.render, first, 2 * bits,
        [&](int i) { return pattern_image(gray_pattern(rig, bits, kCodedLines, i)); },
        [&](int i, const ImageView& image) {
          if (i % 2 == 0) {
            positive.assign(image.pixels, image.pixels + rig.camera.pixels());
            scanner.take({positive.data(), image.rows, image.columns, image.columns}, i);
          } else {
            scanner.take(image, i);
          }
        },
        done);
    return scanner.depth();
  };
  Method method;
  method.name = fmt::format("conventional, {} bits", bits);
  method.depth = depth_of(part, 0);
  method.difference = depth_of(reference, 1000);
  for (std::size_t i = 0; i < method.depth.values.size(); ++i) {
    method.difference.values[i] -= method.depth.values[i];
  }
  return method;
}

// Where there is a step (neighbours more than 1 mm apart in z, or a shadow's edge) within so many pixels along rows and
// columns.
std::vector<std::uint8_t> near_steps(const FloatImage& z, int reach) {
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

// Height over the plane along the middle row or column.
ReportPlot profile(const Rig& rig, const std::string& name, const FloatImage& depth, const FloatImage& truth,
                   bool along_row) {
  ReportPlot plot{fmt::format("{}: profile through the centre, {}", name, along_row ? "along y" : "along x"),
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

FloatImage height_of(const Rig& rig, const FloatImage& depth) {
  FloatImage height = depth;
  for (float& value : height.values) {
    value = static_cast<float>(rig.plane_z_mm) - value;
  }
  return height;
}

ReportTable scan_table(const SelfReference& reference, const LinePlanes& planes, const FloatImage& reference_z,
                       bool gray_scan) {
  double square = 0;
  double most = 0;
  std::size_t count = 0;
  std::size_t lit = 0;
  for (std::size_t i = 0; i < reference_z.values.size(); ++i) {
    lit += std::isnan(reference_z.values[i]) ? 0U : 1U;
    if (reference.measurable(i) && !std::isnan(reference_z.values[i])) {
      const PixelPoint truth = planes.light(i, static_cast<double>(reference_z.values[i]));
      const double error = static_cast<double>(reference.points.line.values[i]) - truth.row;
      if (std::abs(error) < 8) {  // beyond, it is another surface: at edges the truth is that of the pixel's centre
        square += error * error;
        most = std::max(most, std::abs(error));
        ++count;
      }
    }
  }
  return {
      fmt::format("Scan of the reference: {}", gray_scan ? "Gray codes, 42 images" : "lines, 1792 images"),
      {"", "lit pixels measured", "line, RMS", "line, largest"},
      {{"X_R against the truth", fmt::format("{:.1f} %", 100 * static_cast<double>(count) / static_cast<double>(lit)),
        figure_text(std::sqrt(square / static_cast<double>(count)), 3), figure_text(most)}}};
}

void add_method_rows(const Method& method, ReportTable& heights, ReportTable& errors) {
  const Figures& f = method.figures;
  heights.rows.push_back({method.name, figure_text(f[low].height), figure_text(f[high].height),
                          figure_text(-f[letter].difference), figure_text(f[block_3].difference),
                          figure_text(f[block_6].difference), figure_text(f[block_9].difference)});
  std::vector<std::string> row{method.name};
  for (const Face face : {plane, low, high, letter, block_3, block_6, block_9}) {
    row.push_back(fmt::format("{} / {} / {}", figure_text(f.at(face).rms), figure_text(f.at(face).most),
                              figure_text(f.at(face).width)));
  }
  errors.rows.push_back(row);
}

void check_figures(const Figures& f, std::vector<std::string>& not_reached) {
  const auto wanted = [&](const char* what, double value, double truth, double bound) {
    if (!(std::abs(value - truth) <= bound)) {
      not_reached.push_back(fmt::format("{} is {:.2f} mm; {} ± {} mm is wanted", what, value, truth, bound));
    }
  };
  wanted("the low cuboid's height", f[low].height, Cuboids::kLow, 0.83);
  wanted("the high cuboid's height", f[high].height, Cuboids::kHigh, 0.45);
  wanted("the letter's depth", -f[letter].difference, Cuboids::kLetterDepth, 0.70);
  constexpr std::array<double, 3> kBounds{0.22, 0.62, 0.28};  // of the published 2.78, 5.38, 9.28
  for (std::size_t i = 0; i < kBounds.size(); ++i) {
    wanted(kFaceNames.at(block_3 + i), f.at(block_3 + i).difference, Cuboids::kBlockHeights.at(i), kBounds.at(i));
  }
}

}  // namespace

std::string figure_text(double value, int digits) {
  return std::isnan(value) ? "–" : fmt::format("{:.{}f}", value, digits);
}

Image pattern_image(const FloatImage& pattern) {
  constexpr float kFull = 255;
  Image image{pattern.rows, pattern.columns, std::vector<std::uint8_t>(pattern.values.size())};
  std::transform(pattern.values.begin(), pattern.values.end(), image.pixels.begin(),
                 [](float value) { return static_cast<std::uint8_t>(std::lround(kFull * value)); });
  return image;
}

ProjectorPoints scan_points(const Rig& rig, const Scene& scene, const RenderOptions& options, bool gray_codes,
                            const std::function<void()>& done) {
  Rig scanned = rig;
  scanned.imaging.seed += 1;  // noise of its own
  const PatternRenderer renderer(scanned, scene, options);
  if (gray_codes) {
    GrayPointScan scan(rig);
    const GraySequence sequence(rig.projector.columns, rig.projector.lines);
    take_images(
        renderer, options, 0, scan.count(),
        [&](int i) {
          return Image{sequence.rows(), sequence.columns(), sequence.image(i)};
        },
        [&](int, const ImageView& image) { scan.add(image); }, done);
    return scan.points();
  }
  LinePointScan scan(rig);
  take_images(
      renderer, options, 0, scan.count(), [&](int i) { return pattern_image(scan_pattern(rig, i)); },
      [&](int, const ImageView& image) { scan.add(image); }, done);
  return scan.points();
}

std::vector<Image> images_of(const Rig& rig, const Scene& scene, const RenderOptions& options,
                             const std::vector<FloatImage>& patterns, int first) {
  const PatternRenderer renderer(rig, scene, options);
  std::vector<Image> images;
  take_images(
      renderer, options, first, static_cast<int>(patterns.size()),
      [&](int i) { return pattern_image(patterns[static_cast<std::size_t>(i)]); },
      [&](int, const ImageView& image) {
        images.push_back({image.rows, image.columns, {image.pixels, image.pixels + rig.camera.pixels()}});
      },
      [] {});
  return images;
}

MatchShares match_shares(const Rig& rig, const SelfReference& reference, const MatchSettings& settings,
                         const FloatImage& true_z, const FloatImage& reference_z) {
  const MatchSearch search(rig, reference, settings);
  const LinePlanes planes(rig);
  const int codes = 1 << reference.stripes.bits;
  const std::vector<std::uint8_t> near = near_steps(reference_z, codes * reference.stripes.width);
  std::vector<Match> matches;
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
    const PixelPoint light = planes.light(i, static_cast<double>(true_z.values[i]));
    const auto line = static_cast<int>(std::lround(light.row));
    const auto across = static_cast<int>(std::lround(light.column));
    if (line < 0 || line >= rig.projector.lines || across < 0 || across >= rig.projector.columns) {
      continue;
    }
    const int cell = reference.cell(line, across);
    const int n = cell_of_row(row, rig.camera.rows, reference.stripes.width) - cell;
    if (n < -settings.e || n >= codes - settings.e) {
      continue;
    }
    search.find(row, column, matches);
    const Match& match = matches[static_cast<std::size_t>(code_of_cell(reference.stripes, cell))];
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

StructuredLightResult run_cuboids(const StructuredLightOptions& options, const ProgressOfImages& progress) {
  const Rig& rig = options.rig;
  const auto reference_scene = make_scene("cuboids", rig);
  const auto part_scene = make_scene("cuboids-marked", rig);
  const std::size_t scan_images = options.gray_scan ? static_cast<std::size_t>(GrayPointScan(rig).count())
                                                    : static_cast<std::size_t>(LinePointScan(rig).count());
  std::size_t all = scan_images + 2 * static_cast<std::size_t>(options.stripes.bits);
  for (const int bits : options.conventional_bits) {
    all += 4 * static_cast<std::size_t>(bits);  // the reference and the part
  }
  std::size_t done = 0;
  const auto count = [&] { progress(++done, all); };

  const ProjectorPoints points = scan_points(rig, *reference_scene, options.render, options.gray_scan, count);
  const SelfReference reference = make_self_reference(rig, points, options.stripes);
  const MatchSettings settings{options.e};
  const MatchTable table(rig, reference, settings);

  const PatternRenderer reference_renderer(rig, *reference_scene, options.render);
  const PatternRenderer part_renderer(rig, *part_scene, options.render);
  FloatImage truth(rig.camera.rows, rig.camera.columns);
  FloatImage lit = truth;
  FloatImage reference_z = truth;
  part_renderer.depth(0, truth.values);
  part_renderer.depth(0, lit.values, true);
  reference_renderer.depth(0, reference_z.values, true);
  const std::vector<Face> inner = interiors(rig, lit);
  const LinePlanes planes(rig);

  StructuredLightResult result;
  std::vector<Method> methods;
  {
    SelfScanner scanner(rig, reference, table, rig.measure.code_threshold);
    std::vector<std::uint8_t> positive;
    take_images(
        part_renderer, options.render, 0, 2 * options.stripes.bits,
        [&](int i) { return pattern_image(self_projected_pattern(reference, i)); },
        [&](int i, const ImageView& image) {
          if (i % 2 == 0) {
            positive.assign(image.pixels, image.pixels + rig.camera.pixels());
            scanner.take({positive.data(), image.rows, image.columns, image.columns}, i);
          } else {
            scanner.take(image, i);
          }
          if (i == 2 * options.stripes.bits - 2) {
            result.page.pictures.push_back(
                {"Camera image, finest stripes",
                 encode_png({image.rows, image.columns, {image.pixels, image.pixels + rig.camera.pixels()}}), ""});
          }
        },
        count);
    result.page.pictures.insert(
        result.page.pictures.begin(),
        ReportPicture{"Finest self-projected pattern",
                      encode_png(pattern_image(self_projected_pattern(reference, 2 * options.stripes.bits - 2))), ""});
    Method method{
        fmt::format("self-projected, {} bits", options.stripes.bits), scanner.depth(), scanner.difference(), {}};
    const MatchSearch search(rig, reference, settings);
    std::vector<Match> matches;
    const auto width = [&](std::size_t i) {
      const PixelPoint light = planes.light(i, static_cast<double>(truth.values[i]));
      search.find(static_cast<int>(i) / rig.camera.columns, static_cast<int>(i) % rig.camera.columns, matches);
      for (const Match& match : matches) {
        if (match.candidates > 0 && std::abs(match.line - light.row) <= match.half_width + 0.5) {
          return planes.z(i, match.line - match.half_width) - planes.z(i, match.line + match.half_width);
        }
      }
      return std::numeric_limits<double>::quiet_NaN();
    };
    // Places at the edge of a cell may be in none by rounding: those do not count for the mean width.
    evaluate(
        rig, truth, inner,
        [&, last = 0.0](std::size_t i) mutable {
          const double w = width(i);
          last = std::isnan(w) ? last : w;
          return last;
        },
        method);
    result.depth = method.depth;
    result.difference = method.difference;
    methods.push_back(std::move(method));
  }
  for (const int bits : options.conventional_bits) {
    Method method = conventional(options, reference_renderer, part_renderer, bits, count);
    const double half = 0.5 * kCodedLines / (1 << bits);
    evaluate(
        rig, truth, inner,
        [&](std::size_t i) {
          const double line = planes.light(i, static_cast<double>(truth.values[i])).row;
          return planes.z(i, line - half) - planes.z(i, line + half);
        },
        method);
    methods.push_back(std::move(method));
  }

  ReportTable heights{
      "B4: mean heights of the faces' interiors, mm",
      {"", "low cuboid", "high cuboid", "letter", "block 3", "block 6", "block 9"},
      {{"true", "25", "109", "2", "3", "6", "9"},
       {"published, self-projected 4 bits", "25.83", "108.55", "2.70 or less", "2.78", "5.38", "9.28"},
       {"published, conventional 8 bits", "within 0.56", "within 1.41", "–", "–", "–", "–"}},
      "Over the plane; letter and blocks: difference from the reference. Interiors are 3 pixels and more "
      "from the faces' edges. Camera noise on."};
  ReportTable errors{"B4: error of z per pixel, mm: RMS / largest / one code's width in z",
                     {"", "plane", "low cuboid", "high cuboid", "letter", "block 3", "block 6", "block 9"},
                     {},
                     "Over the same pixels."};
  for (const Method& method : methods) {
    add_method_rows(method, heights, errors);
  }
  ReportTable valid{"B4: share of the interiors' pixels that have a depth, %", {""}, {}};
  for (const char* name : kFaceNames) {
    valid.header.emplace_back(name);
  }
  for (const Method& method : methods) {
    valid.rows.push_back({method.name});
    for (const FaceFigures& face : method.figures) {
      valid.rows.back().push_back(
          figure_text(100 * static_cast<double>(face.valid) / static_cast<double>(face.pixels), 1));
    }
  }
  ReportTable shares{"B4: wrong matches of true codes",
                     {"", "pixels", "wrong", "none", "16 cells or more from steps", "of these wrong"},
                     {},
                     "Of the pixels in the projector's light whose true place is in the window. Printed: along Xp at "
                     "constant Yp, window of 48 lines."};
  for (const StripeCode code : {StripeCode::cyclic, StripeCode::reflected}) {
    for (const bool printed : {false, true}) {
      SelfReference variant = reference;
      variant.stripes.code = code;
      const MatchShares s = match_shares(rig, variant, {options.e, printed, printed, 3}, lit, reference_z);
      shares.rows.push_back({fmt::format("{} code, {} search", code == StripeCode::cyclic ? "cyclic" : "reflected",
                                         printed ? "printed" : "corrected"),
                             std::to_string(s.pixels), fmt::format("{:.3f} %", 100 * s.wrong),
                             fmt::format("{:.2f} %", 100 * s.none), std::to_string(s.far),
                             fmt::format("{:.3f} %", 100 * s.far_wrong)});
      if (code == StripeCode::cyclic && !printed && s.far_wrong > 0) {
        result.not_reached.emplace_back("matches 16 cells or more from steps are wrong");
      }
    }
  }
  check_figures(methods[0].figures, result.not_reached);
  result.tables = {std::move(heights), std::move(errors), std::move(valid), std::move(shares),
                   scan_table(reference, planes, reference_z, options.gray_scan)};
  result.truth = truth;

  ReportPage& page = result.page;
  page.title = "Experiment B4";
  page.subtitle = "Cuboids of different heights: self-projected structured light beside the conventional method";
  page.tables = result.tables;
  const double down = rig.plane_z_mm * rig.camera.pixel_pitch_mm / rig.camera.focal_length_mm;
  const MapPitch pitch{down, down};
  const MapScale height_colours{ColourMap::sequential, 0, 125};
  for (const Method& method : methods) {
    page.pictures.push_back({method.name + ": height",
                             labelled_map_png(height_of(rig, method.depth), height_colours, pitch, "height, mm"), ""});
    page.pictures.push_back(
        {method.name + ": difference from the reference",
         labelled_map_png(method.difference, {ColourMap::diverging, -12, 12}, pitch, "difference, mm"), ""});
    page.plots.push_back(profile(rig, method.name, method.depth, truth, true));
    page.plots.push_back(profile(rig, method.name, method.depth, truth, false));
  }
  page.settings = {
      {"e", "e", static_cast<std::int64_t>(options.e)},
      {"a", "a, camera rows a code", static_cast<std::int64_t>(options.stripes.width)},
      {"threshold", "threshold of the binarization", static_cast<std::int64_t>(rig.measure.code_threshold)},
      {"seed", "seed", rig.imaging.seed}};
  return result;
}

}  // namespace selfproj
