#include "lab/thesis_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <stdexcept>

#include "host/files/numbers.h"
#include "host/images/image_files.h"
#include "host/light_section/line_finder.h"
#include "host/light_section/pattern.h"
#include "host/report/map_picture.h"
#include "host/structured_light/accuracy.h"
#include "host/structured_light/match_table.h"
#include "host/structured_light/self_reference.h"
#include "host/structured_light/self_scanner.h"
#include "lab/gray_motion.h"
#include "lab/relief_picture.h"
#include "lab/section_measurement.h"
#include "lab/structured_light.h"
#include "selfproj/light_section/differential_profile.h"
#include "selfproj/light_section/fast_moments.h"
#include "selfproj/light_section/inspection.h"
#include "selfproj/light_section/profile.h"
#include "selfproj/model/column_runs.h"
#include "selfproj/rig/calibration.h"
#include "selfproj/rig/rig.h"
#include "selfproj/structured_light/depth_geometry.h"
#include "selfproj/structured_light/scanner.h"
#include "selfproj/structured_light/triangulation.h"
#include "sim/cosim/light_section.h"
#include "sim/scene/pattern_renderer.h"
#include "sim/scene/projected_light.h"
#include "sim/scene/renderer.h"
#include "sim/scene/scene.h"
#include "sim/scene/scenes.h"
#include "sim/scene/virtual_capture.h"

namespace selfproj::lab {
namespace {

using Done = std::function<void()>;

constexpr double kMountainHeight = 23.6;  // mm
constexpr int kStairsEvery = 5;           // of 1400 frames
constexpr int kTapFrames = 600;           // three taps
constexpr int kTurnFrames = 588;          // two turns of the fist, and a cycle
// 42 images in the place of the thesis's 1792, one under each line; whole experiments use those.
constexpr sim::ScanMethod kScan = sim::ScanMethod::gray_codes;

// The rig's camera with 512 x 512 pixels has more than a page shows; a table takes every fourth of them.
constexpr int kCsvStep = 4;

std::string csv_of_map(const images::FloatImage& map) {
  std::string csv = fmt::format("row\\column");
  for (int c = 0; c < map.columns; c += kCsvStep) {
    csv += fmt::format(",{}", c + 1);
  }
  csv += "\n";
  for (int r = 0; r < map.rows; r += kCsvStep) {
    csv += std::to_string(r + 1);
    for (int c = 0; c < map.columns; c += kCsvStep) {
      const float value = map.row(r)[c];
      csv += std::isnan(value) ? "," : fmt::format(",{:.3f}", std::round(1000 * value) / 1000 + 0.0F);
    }
    csv += "\n";
  }
  return csv;
}

// Columns of numbers under their names; an entry of NaN is empty.
std::string csv_of_columns(const std::vector<std::pair<std::string, std::vector<double>>>& columns) {
  std::string csv;
  for (const auto& [name, values] : columns) {
    csv += (csv.empty() ? "" : ",") + name;
  }
  csv += "\n";
  for (std::size_t i = 0; i < columns.front().second.size(); ++i) {
    for (std::size_t k = 0; k < columns.size(); ++k) {
      const double value = columns[k].second[i];
      csv += (k == 0 ? "" : ",") + (std::isnan(value) ? std::string() : fmt::format("{:.6g}", value));
    }
    csv += "\n";
  }
  return csv;
}

std::string csv_of_plots(const std::vector<report::ReportPlot>& plots) {
  std::string csv = "plot,trace,x,y\n";
  for (const report::ReportPlot& plot : plots) {
    for (const report::ReportTrace& trace : plot.traces) {
      for (std::size_t i = 0; i < trace.x.size(); ++i) {
        csv += fmt::format("\"{}\",\"{}\",{:.6g},{}\n", plot.title, trace.name, trace.x[i],
                           std::isnan(trace.y[i]) ? std::string() : fmt::format("{:.6g}", trace.y[i]));
      }
    }
  }
  return csv;
}

report::ReportPicture map_picture(const std::string& title, const images::FloatImage& map,
                                  const report::MapScale& scale, const report::MapPitch& pitch) {
  return report::shown_map(title, map, scale, pitch);
}

// --- chapter 3: light section ---

// One frame of the mountain, under its own pattern and under a straight line.
struct Mountain {
  struct Way {
    images::Image image;
    std::vector<double> centroid, y, height;
    double range = 0;  // max - min of C, px
  };
  rig::Rig rig;
  images::FloatImage pattern;
  Way self_projected, straight;
  std::vector<double> truth;  // height of what the self-projected line meets
};

Mountain::Way measured_frame(const sim::LightSection& setup, const sim::LineRenderer& renderer, int frame) {
  const rig::Rig& rig = setup.rig;
  Mountain::Way way;
  way.image = {rig.camera.rows, rig.camera.columns, std::vector<std::uint8_t>(rig.camera.pixels())};
  renderer.render(frame, std::span(way.image.pixels));
  model::Measure measure = rig.measure.of_board();
  measure.mode = sim::kAllModes[0];
  model::Runs runs;
  runs.resize(measure.select, rig.camera.columns);
  light_section::fast_measure_columns(way.image.view(), measure, runs.view());
  light_section::Profile profile;
  profile.resize(rig.camera.columns);
  light_section::DifferentialProfiler(rig, setup.references[0]).profile(runs.view(), profile.view());
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (std::size_t c = 0; c < profile.z.size(); ++c) {
    way.centroid.push_back(static_cast<double>(profile.centroid[c]));
    way.y.push_back(static_cast<double>(profile.y[c]));
    way.height.push_back(rig.plane_z_mm - static_cast<double>(profile.z[c]));
    if (profile.validity[c] == static_cast<std::uint8_t>(light_section::Validity::valid)) {
      low = std::min(low, way.centroid.back());
      high = std::max(high, way.centroid.back());
    }
  }
  way.range = high - low;
  return way;
}

Mountain make_mountain(const Done& done) {
  Mountain result;
  result.rig = rig::load_rig("light-section");
  const sim::RenderOptions render;
  const auto scene = sim::make_scene("mountain", result.rig);
  const int frame = scene->frames() / 2;
  const sim::LightSection own = sim::self_projection(result.rig, result.rig, *scene, render, true);
  done();
  const sim::LightSection line = straight_line(result.rig, result.rig, *scene, render, kMountainHeight / 2);
  done();
  result.pattern = own.pattern;
  const sim::LineRenderer of_own(own.actual, *scene, own.pattern, render);
  result.self_projected = measured_frame(own, of_own, frame);
  result.straight = measured_frame(line, sim::LineRenderer(line.actual, *scene, line.pattern, render), frame);
  std::vector<float> truth(static_cast<std::size_t>(result.rig.camera.columns));
  of_own.truth(frame, std::span(truth));
  result.truth.assign(truth.begin(), truth.end());
  return result;
}

// The marked stairs on the belt, measured against the plain ones.
struct Stairs {
  rig::Rig rig;
  images::FloatImage pattern, height, difference;
  images::Image frame;
  report::MapPitch pitch;
};

Stairs make_stairs(const Done& done) {
  Stairs result;
  result.rig = rig::load_rig("light-section");
  const sim::RenderOptions render;
  const auto scene = sim::make_scene("stairs-marked", result.rig);
  const auto reference = sim::make_scene("stairs", result.rig);
  const sim::LightSection setup = sim::self_projection(result.rig, result.rig, *reference, render, true);
  const Measurement measurement = measure(setup, *scene, render, kStairsEvery, 0, [&](std::size_t) { done(); });
  const light_section::Inspection& inspection = measurement.by_mode[0];
  result.pattern = setup.pattern;
  result.height = inspection.height();
  result.difference = inspection.difference();
  result.frame = measurement.camera.image;
  result.pitch = {inspection.frame_spacing_mm(), inspection.column_spacing_mm()};
  return result;
}

ThesisFigure pattern_figure(const std::string& number, const std::string& of, const images::FloatImage& pattern) {
  ThesisFigure figure{number, "The self-projected light pattern of the " + of, "", {}, {}, {}, "", {}};
  figure.pictures.push_back({number + "(b): light pattern of the " + of, light_section::encode_pattern_png(pattern),
                             "As the projector shows it, " +
                                 fmt::format("{} x {} pixels. (a) is a photograph.", pattern.columns, pattern.rows)});
  std::vector<double> column;
  std::vector<double> line;
  for (int c = 0; c < pattern.columns; ++c) {
    double light = 0;
    double moment = 0;
    for (int r = 0; r < pattern.rows; ++r) {
      const auto value = static_cast<double>(pattern.row(r)[c]);
      light += value;
      moment += r * value;
    }
    column.push_back(c);
    line.push_back(light > 0 ? moment / light : std::nan(""));
  }
  figure.csv = csv_of_columns({{"projector_column", column}, {"projector_line", line}});
  return figure;
}

ThesisFigure figure_3_4(const Mountain& m) {
  ThesisFigure figure{"3.4", "Captured image of the mountain under its own pattern (above) and a straight line (below)",
                      "A1",  {},
                      {},    {},
                      "",    {}};
  figure.pictures.push_back(
      {"3.4: camera images, 96 x 512 pixels each",
       images::encode_png(below_each_other({m.self_projected.image, m.straight.image})),
       fmt::format("Above: self-projected; the line stays within {:.2f} rows. Below: straight line, {:.1f} rows.",
                   m.self_projected.range, m.straight.range)});
  std::vector<double> column;
  for (std::size_t c = 0; c < m.truth.size(); ++c) {
    column.push_back(static_cast<double>(c + 1));
  }
  figure.csv = csv_of_columns(
      {{"column", column}, {"row_self_projected", m.self_projected.centroid}, {"row_straight", m.straight.centroid}});
  figure.plots.push_back({"3.4: rows of the line",
                          "column",
                          "row, counted downwards in the image",
                          {{column, m.self_projected.centroid, "a", "self-projected"},
                           {column, m.straight.centroid, "b", "straight line"}}});
  figure.values = {{"width_self_projected_px", m.self_projected.range}, {"width_straight_px", m.straight.range}};
  return figure;
}

// The largest magnitude; entries of NaN do not count.
double largest(const std::vector<double>& errors) {
  double most = 0;
  for (const double error : errors) {
    most = std::isnan(error) ? most : std::max(most, std::abs(error));
  }
  return most;
}

ThesisFigure figure_3_5(const Mountain& m) {
  ThesisFigure figure{"3.5", "Height of the mountain on an intersected line, by both methods", "A1", {}, {}, {}, "",
                      {}};
  std::vector<double> own_error;
  std::vector<double> line_error;
  // The straight line meets the same section elsewhere along the belt, along which the part does not change.
  for (std::size_t c = 0; c < m.truth.size(); ++c) {
    own_error.push_back(m.self_projected.height[c] - m.truth[c]);
    line_error.push_back(m.straight.height[c] - m.truth[c]);
  }
  figure.plots.push_back({"3.5: height over the belt",
                          "y, mm",
                          "height, mm",
                          {{m.self_projected.y, m.self_projected.height, "a", "self-projected"},
                           {m.straight.y, m.straight.height, "b", "straight line"}}});
  figure.plots.push_back(
      {"3.5: measured less actual height",
       "y, mm",
       "error, mm",
       {{m.self_projected.y, own_error, "a", "self-projected"}, {m.straight.y, line_error, "b", "straight line"}},
       0.2});
  figure.csv = csv_of_columns({{"y_mm", m.self_projected.y},
                               {"actual_mm", m.truth},
                               {"self_projected_mm", m.self_projected.height},
                               {"straight_mm", m.straight.height}});
  figure.values = {{"self_projected_mm", largest(own_error)}};
  return figure;
}

ThesisFigure figure_3_7(const Stairs& s) {
  ThesisFigure figure{"3.7", "A camera image in the middle of the carved marks", "A2", {}, {}, {}, "", {}};
  figure.pictures.push_back({"3.7: image of 96 x 512 pixels", images::encode_png(s.frame),
                             "On the plain treads the line is straight; in the marks it is aside of it."});
  light_section::LineFinder finder(s.rig);
  finder.find(s.frame.view());
  std::vector<double> column;
  std::vector<double> row;
  for (std::size_t c = 0; c < finder.columns(); ++c) {
    column.push_back(static_cast<double>(c + 1));
    row.push_back(finder.has_line(c) ? finder.centroid(c) : std::nan(""));
  }
  figure.csv = csv_of_columns({{"column", column}, {"row", row}});
  figure.plots.push_back(
      {"3.7: rows of the line", "column", "row, counted downwards in the image", {{column, row, "a", "line"}}});
  return figure;
}

ThesisFigure figure_3_8(const Stairs& s) {
  ThesisFigure figure{"3.8", "Absolute 3-D shape of the stairs in xyz", "A2", {}, {}, {}, "", {}};
  const report::MapScale scale = report::height_scale(s.height);
  figure.pictures.push_back({"3.8: heights over the belt", relief_png(s.height, scale, s.pitch, 1),
                             fmt::format("Every {}th frame; heights from {:.1f} to {:.1f} mm in the colours of the map "
                                         "beside it; heights drawn to scale.",
                                         kStairsEvery, files::rounded(scale.low, 1), scale.high)});
  figure.pictures.push_back(map_picture("3.8: heights over the belt (mm)", s.height, scale, s.pitch));
  figure.maps = {{"figure-3.8", s.height}};
  figure.csv = csv_of_map(s.height);
  return figure;
}

ThesisFigure figure_3_9(const Stairs& s) {
  ThesisFigure figure{"3.9", "Differential 3-D shape of the stairs", "A2", {}, {}, {}, "", {}};
  const report::MapScale scale{report::ColourMap::diverging, -1.5, 1.5};
  constexpr double kExaggeration = 10;
  figure.pictures.push_back(
      {"3.9(a): xyz space", relief_png(s.difference, scale, s.pitch, kExaggeration),
       "Differences from the reference, -1.5 (blue) to 1.5 mm (red), drawn ten times as high. The "
       "band in front is where the stairs end along the belt."});
  figure.pictures.push_back(map_picture("3.9(b): xy space, difference (mm)", s.difference, scale, s.pitch));
  figure.maps = {{"figure-3.9", s.difference}};
  figure.csv = csv_of_map(s.difference);
  return figure;
}

// --- chapter 4: structured light ---

images::FloatImage height_of(const rig::Rig& rig, const images::FloatImage& depth) {
  images::FloatImage height = depth;
  for (float& value : height.values) {
    value = static_cast<float>(rig.plane_z_mm) - value;
  }
  return height;
}

double pixel_of(const rig::Rig& rig) { return rig.plane_z_mm * rig.camera.pixel_pitch_mm / rig.camera.focal_length_mm; }

// Depth images of a scene at some of its frames, and camera images under full light at the same.
struct Film {
  std::vector<double> t;  // s
  std::vector<images::FloatImage> light, height, difference;
};

// Plays one cycle of the stream's patterns up to each frame.
Film film_of(const rig::Rig& rig, const sim::PatternRenderer& renderer, DepthStream& stream,
             const std::vector<int>& frames, const Done& done) {
  Film film;
  const sim::PatternSet white(rig, std::vector<images::Image>{sim::pattern_image(
                                       images::FloatImage(rig.projector.lines, rig.projector.columns, 1))});
  const int cycle = 2 * stream.bits();
  for (const int frame : frames) {
    play(
        renderer, stream, frame - cycle, cycle, [](int) {}, done);
    film.t.push_back(frame / rig.camera.frame_rate_hz);
    film.height.push_back(height_of(rig, stream.depth()));
    film.difference.push_back(stream.difference());
    images::FloatImage light(rig.camera.rows, rig.camera.columns);
    renderer.render(frame - cycle / 2, white.of_frame(0), std::span(light.values));
    film.light.push_back(std::move(light));
  }
  return film;
}

// Frames at these times, of a scene with its own clock; the first cycle has to lie behind frame 0.
std::vector<int> frames_at(const rig::Rig& rig, double first_s, double step_s, int count, int cycle) {
  std::vector<int> frames;
  for (int i = 0; i < count; ++i) {
    const int frame = static_cast<int>(std::lround((first_s + i * step_s) * rig.camera.frame_rate_hz));
    frames.push_back(std::max(cycle, frame));
  }
  return frames;
}

// A film by Gray codes of 8 bits over all lines, as B1 to B3 observe.
Film gray_film(const std::string& scene_name, double first_s, double step_s, int count, const Done& done) {
  const rig::Rig rig = rig::load_rig("scanner");
  const auto scene = sim::make_scene(scene_name, rig);
  const auto background = sim::make_scene(sim::find_scene(scene_name).reference_name(), rig);
  const sim::RenderOptions render;
  constexpr double kBelowPlane = 15;
  const auto stream = [&] {
    return GrayStream(rig, structured_light::triangulation_of_rig(rig, kGrayBits, {0, rig.plane_z_mm + kBelowPlane}),
                      kGrayBits, rig.projector.lines);
  };
  GrayStream before = stream();
  play(
      sim::PatternRenderer(rig, *background, render), before, 0, kGrayCycle, [](int) {}, done);
  GrayStream now = stream();
  now.set_reference(before.depth());
  return film_of(rig, sim::PatternRenderer(rig, *scene, render), now,
                 frames_at(rig, first_s, step_s, count, kGrayCycle), done);
}

// A film by self-projected codes, e = 0, as B7 and B8 observe; the reference is scanned by Gray codes.
Film self_projected_film(const std::string& scene_name, double first_s, double step_s, int count, const Done& done) {
  const rig::Rig rig = rig::load_rig("scanner");
  const auto scene = sim::make_scene(scene_name, rig);
  const auto background = sim::make_scene(sim::find_scene(scene_name).reference_name(), rig);
  const sim::RenderOptions render;
  const structured_light::SelfReference reference =
      structured_light::make_self_reference(rig, sim::scan_points(rig, *background, render, kScan, done), {});
  const structured_light::MatchTable table(rig, reference, {.e = 0});
  SelfProjectedStream stream(rig, reference, table);
  return film_of(rig, sim::PatternRenderer(rig, *scene, render), stream,
                 frames_at(rig, first_s, step_s, count, 2 * stream.bits()), done);
}

std::string times_text(const std::vector<double>& t) {
  std::string text;
  for (const double time : t) {
    text += fmt::format("{}{:.3f}", text.empty() ? "" : ", ", time);
  }
  return text + " s";
}

ThesisFigure film_figure(const std::string& number, const std::string& caption, const std::string& source,
                         const Film& film, const report::MapScale& height, const report::MapScale& difference) {
  ThesisFigure figure{number, caption, source, {}, {}, {}, "", {}};
  constexpr std::size_t kAcross = 2;
  const std::string times = "t = " + times_text(film.t) + ", from left to right and down.";
  figure.pictures.push_back(
      {number + "(a): the scene under full light", strip_png(film.light, std::nullopt, kAcross), times});
  figure.pictures.push_back({number + "(b): heights over the plane", strip_png(film.height, height, kAcross),
                             fmt::format("{:g} (dark) to {:g} mm (light); grey: no depth.", height.low, height.high)});
  figure.pictures.push_back(
      {number + "(c): differences from the background", strip_png(film.difference, difference, kAcross),
       fmt::format("{:g} (blue) to {:g} mm (red), towards the camera.", difference.low, difference.high)});
  for (std::size_t i = 0; i < film.t.size(); ++i) {
    figure.maps.emplace_back(fmt::format("figure-{}-{}", number, i + 1), film.height[i]);
  }
  // A row of the picture's middle at each time.
  const images::FloatImage& first = film.height.front();
  std::vector<std::pair<std::string, std::vector<double>>> columns{{"column", {}}};
  for (int c = 0; c < first.columns; ++c) {
    columns.front().second.push_back(c + 1);
  }
  for (std::size_t i = 0; i < film.t.size(); ++i) {
    const float* row = film.height[i].row(first.rows / 2);
    columns.emplace_back(fmt::format("height_mm_middle_row_at_{:.3f}_s", film.t[i]),
                         std::vector<double>(row, row + first.columns));
  }
  figure.csv = csv_of_columns(columns);
  return figure;
}

ThesisFigure motion_figure(const std::string& number, const std::string& caption, const std::string& experiment,
                           std::size_t plots, const Done& done) {
  GrayMotionOptions options;
  options.rig = rig::load_rig("scanner");
  options.paths = 0;  // besides that of the thesis
  options.frames = experiment == "B3" ? kTapFrames : kTurnFrames;
  const StructuredLightResult result = run_gray_motion(experiment, options, [&](std::size_t, std::size_t) { done(); });
  ThesisFigure figure{number, caption, experiment, {}, result.page.plots, {}, "", {}};
  figure.plots.resize(std::min(figure.plots.size(), plots));
  figure.csv = csv_of_plots(figure.plots);
  return figure;
}

constexpr std::array<double, 3> kLevels{0, 25, 109};  // mm over the plane

ThesisFigure figure_4_10() {
  const rig::Rig rig = rig::load_rig("scanner");
  ThesisFigure figure{"4.10",
                      "Quantization error on planes at three heights, 16 x 16 points of the central 320 x 320 px",
                      "",
                      {},
                      {},
                      {},
                      "height_mm,row,column,error_mm\n",
                      {}};
  for (const double level : kLevels) {
    constexpr int kPoints = 16;
    constexpr double kStep = 20;
    images::FloatImage map(kPoints, kPoints);
    const double first_row = 0.5 * (rig.camera.rows - 1) - 0.5 * kStep * (kPoints - 1);
    const double first_column = 0.5 * (rig.camera.columns - 1) - 0.5 * kStep * (kPoints - 1);
    for (int r = 0; r < kPoints; ++r) {
      for (int c = 0; c < kPoints; ++c) {
        const structured_light::CameraPoint point{first_row + r * kStep, first_column + c * kStep,
                                                  rig.plane_z_mm - level};
        map.row(r)[c] = static_cast<float>(structured_light::half_pixel_error(rig, point));
        figure.csv += fmt::format("{:g},{:.1f},{:.1f},{:.4f}\n", level, point.row, point.column, map.row(r)[c]);
      }
    }
    const double pitch = kStep * (rig.plane_z_mm - level) * rig.camera.pixel_pitch_mm / rig.camera.focal_length_mm;
    const std::string title = fmt::format("4.10: error of z at {:g} mm (mm)", level);
    figure.pictures.push_back(map_picture(title, map, {report::ColourMap::sequential, 0, 7}, {pitch, pitch}));
    const structured_light::CameraPoint middle{0.5 * (rig.camera.rows - 1), 0.5 * (rig.camera.columns - 1),
                                               rig.plane_z_mm - level};
    figure.values.emplace_back(fmt::format("centre_at_{:g}_mm", level),
                               structured_light::half_pixel_error(rig, middle));
  }
  return figure;
}

// The cuboids with letter and blocks, by 4 self-projected bits and by 8 to 4 conventional ones.
struct CuboidScene {
  rig::Rig rig;
  std::vector<std::string> patterns;
  std::vector<images::Image> views;  // under the positives
  images::FloatImage depth, difference, truth;
  std::map<int, images::FloatImage> conventional;  // depth by bits
};

CuboidScene make_cuboids(const Done& done) {
  CuboidScene result;
  const rig::Rig& rig = result.rig = rig::load_rig("scanner");
  const sim::RenderOptions render;
  const auto scene = sim::make_scene("cuboids-marked", rig);
  const auto good = sim::make_scene("cuboids", rig);
  const structured_light::SelfReference reference =
      structured_light::make_self_reference(rig, sim::scan_points(rig, *good, render, kScan, done), {});
  const structured_light::MatchTable table(rig, reference, {.e = 8});
  const sim::PatternRenderer renderer(rig, *scene, render);
  structured_light::SelfScanner scanner(rig, reference, table, rig.measure.code_threshold);
  const auto pattern = [&](int i) { return structured_light::self_projected_pattern(reference, i); };
  scan_cycle(
      renderer, 0, reference.stripes.bits, pattern,
      [&](int i, const model::ImageView& image) {
        if (i % 2 == 0) {
          result.patterns.push_back(images::encode_png(sim::pattern_image(pattern(i))));
          result.views.push_back(images::copy_of(image));
        }
        done();
      },
      scanner);
  result.depth = scanner.depth();
  result.difference = scanner.difference();
  for (int bits = 8; bits >= 4; --bits) {
    const structured_light::PlaneTriangulation triangulation(rig, bits, {}, rig::central_lines(rig, kCodedLines, bits));
    structured_light::Scanner gray(triangulation, {.threshold = rig.measure.code_threshold});
    scan_cycle(
        renderer, 0, bits, [&](int i) { return structured_light::gray_pattern(rig, bits, kCodedLines, i); },
        [&](int, const model::ImageView&) { done(); }, gray);
    result.conventional.emplace(bits, gray.depth());
  }
  result.truth = images::FloatImage(rig.camera.rows, rig.camera.columns);
  renderer.lit_depth(0, std::span(result.truth.values));
  return result;
}

ThesisFigure images_figure(const std::string& number, const std::string& caption, const CuboidScene& c, bool camera) {
  ThesisFigure figure{number, caption, "B4", {}, {}, {}, "", {}};
  for (std::size_t i = 0; i < c.views.size(); ++i) {
    figure.pictures.push_back(
        {fmt::format("{}: {} {}", number, camera ? "camera image under pattern" : "pattern", 2 * i),
         camera ? images::encode_png(c.views[i]) : c.patterns[i], ""});
  }
  if (camera) {  // a column through the middle of each
    std::vector<std::pair<std::string, std::vector<double>>> columns{{"row", {}}};
    for (int r = 0; r < c.rig.camera.rows; ++r) {
      columns.front().second.push_back(r + 1);
    }
    for (std::size_t i = 0; i < c.views.size(); ++i) {
      columns.emplace_back(fmt::format("grey_under_pattern_{}", 2 * i), std::vector<double>{});
      for (int r = 0; r < c.rig.camera.rows; ++r) {
        columns.back().second.push_back(
            c.views[i].pixels[static_cast<std::size_t>(r * c.views[i].columns + c.views[i].columns / 2)]);
      }
    }
    figure.csv = csv_of_columns(columns);
  }
  return figure;
}

const report::MapScale kCuboidHeights{report::ColourMap::sequential, 0, 125};

ThesisFigure figure_4_15(const CuboidScene& c) {
  ThesisFigure figure{"4.15", "Depth images of the cuboids", "B4", {}, {}, {}, "", {}};
  const report::MapPitch pitch{pixel_of(c.rig), pixel_of(c.rig)};
  const images::FloatImage height = height_of(c.rig, c.depth);
  const images::FloatImage gray = height_of(c.rig, c.conventional.at(8));
  figure.pictures = {map_picture("4.15(a): 4 self-projected bits, height (mm)", height, kCuboidHeights, pitch),
                     map_picture("4.15(b): difference from the reference (mm)", c.difference,
                                 {report::ColourMap::diverging, -12, 12}, pitch),
                     map_picture("4.15(c): 8 conventional bits, height (mm)", gray, kCuboidHeights, pitch)};
  figure.maps = {{"figure-4.15a", height}, {"figure-4.15b", c.difference}, {"figure-4.15c", gray}};
  figure.csv = csv_of_map(height);
  return figure;
}

// The centre line of the maps; along y it is the middle row, horizontal in the thesis's pictures.
ThesisFigure profile_figure(const std::string& number, const std::string& caption, const CuboidScene& c, int bits,
                            bool along_row) {
  ThesisFigure figure{number, caption, "B4", {}, {}, {}, "", {}};
  std::vector<double> at;
  std::array<std::vector<double>, 3> height;
  const std::array<const images::FloatImage*, 3> depths{&c.depth, &c.conventional.at(bits), &c.truth};
  const int count = along_row ? c.rig.camera.columns : c.rig.camera.rows;
  for (int i = 0; i < count; ++i) {
    at.push_back(i + 1);
    for (std::size_t k = 0; k < depths.size(); ++k) {
      const float z =
          along_row ? depths[k]->row(c.rig.camera.rows / 2)[i] : depths[k]->row(i)[c.rig.camera.columns / 2];
      height[k].push_back(c.rig.plane_z_mm - static_cast<double>(z));
    }
  }
  const std::string gray = fmt::format("conventional, {} bits", bits);
  const std::string axis = along_row ? "column" : "row";
  figure.plots = {{number + ": height along the centre line",
                   axis,
                   "height, mm",
                   {{at, height[0], "a", "self-projected, 4 bits"}, {at, height[1], "b", gray}}},
                  {number + ": the self-projected profile and the actual one",
                   axis,
                   "height, mm",
                   {{at, height[0], "a", "self-projected, 4 bits"}, {at, height[2], "b", "actual"}}}};
  figure.csv = csv_of_columns({{axis, at},
                               {"self_projected_4_bits_mm", height[0]},
                               {fmt::format("conventional_{}_bits_mm", bits), height[1]},
                               {"actual_mm", height[2]}});
  return figure;
}

ThesisFigure figure_4_17(const CuboidScene& c) {
  ThesisFigure figure{"4.17", "Depth images by fewer bits of the conventional method", "B4", {}, {}, {}, "", {}};
  const report::MapPitch pitch{pixel_of(c.rig), pixel_of(c.rig)};
  for (int bits = 7; bits >= 4; --bits) {
    const images::FloatImage height = height_of(c.rig, c.conventional.at(bits));
    figure.pictures.push_back(map_picture(
        fmt::format("4.17({}): {} bits, stripes of {} lines, height (mm)", "abcd"[7 - bits], bits, kCodedLines >> bits),
        height, kCuboidHeights, pitch));
    figure.maps.emplace_back(fmt::format("figure-4.17{}", "abcd"[7 - bits]), height);
  }
  figure.csv = csv_of_map(figure.maps.back().second);
  return figure;
}

}  // namespace

struct ThesisFigures::Stages {
  Done done;
  std::optional<Mountain> mountain;
  std::optional<Stairs> stairs;
  std::optional<CuboidScene> cuboids;

  const Mountain& of_mountain() { return made(mountain, make_mountain); }
  const Stairs& of_stairs() { return made(stairs, make_stairs); }
  const CuboidScene& of_cuboids() { return made(cuboids, make_cuboids); }

  template <class Stage, class Make>
  const Stage& made(std::optional<Stage>& stage, const Make& make) {
    if (!stage) {
      stage.emplace(make(done));
    }
    return *stage;
  }
};

ThesisFigures::ThesisFigures(std::function<void()> done) : stages_(std::make_unique<Stages>()) {
  stages_->done = std::move(done);
}

ThesisFigures::~ThesisFigures() = default;

std::vector<std::string> ThesisFigures::numbers() {
  return {"3.3", "3.4",  "3.5",  "3.6",  "3.7",  "3.8",  "3.9",  "4.3",  "4.4",  "4.5", "4.6",
          "4.7", "4.10", "4.13", "4.14", "4.15", "4.16", "4.17", "4.18", "4.19", "4.20"};
}

ThesisFigure ThesisFigures::make(const std::string& number) {
  Stages& s = *stages_;
  const report::MapScale low{report::ColourMap::sequential, 0, 220};
  const report::MapScale moved{report::ColourMap::diverging, -100, 100};
  if (number == "3.3") {
    return pattern_figure(number, "mountain", s.of_mountain().pattern);
  }
  if (number == "3.4") {
    return figure_3_4(s.of_mountain());
  }
  if (number == "3.5") {
    return figure_3_5(s.of_mountain());
  }
  if (number == "3.6") {
    return pattern_figure(number, "stairs", s.of_stairs().pattern);
  }
  if (number == "3.7") {
    return figure_3_7(s.of_stairs());
  }
  if (number == "3.8") {
    return figure_3_8(s.of_stairs());
  }
  if (number == "3.9") {
    return figure_3_9(s.of_stairs());
  }
  if (number == "4.3") {
    return film_figure(number, "A fist that moves on a slanted circle over a desk", "B1",
                       gray_film("fist", 0.05, 0.04, 8, s.done), low, moved);
  }
  if (number == "4.4") {
    return motion_figure(number, "3-D position of the fist over time", "B1", 3, s.done);
  }
  if (number == "4.5") {
    return film_figure(number, "Waves on water of 3 cm after the impact at t = 1.36 s", "B2",
                       gray_film("waves", sim::PoolWave::kImpact + 0.02, 0.04, 8, s.done),
                       {report::ColourMap::sequential, 20, 40}, {report::ColourMap::diverging, -10, 10});
  }
  if (number == "4.6") {
    return film_figure(number, "Two fingers that tap on keys", "B3", gray_film("keys", 0.05, 0.025, 8, s.done),
                       {report::ColourMap::sequential, 0, 80}, {report::ColourMap::diverging, -40, 40});
  }
  if (number == "4.7") {
    return motion_figure(number, "Depth at the two tapped keys", "B3", 2, s.done);
  }
  if (number == "4.10") {
    return figure_4_10();
  }
  if (number == "4.13") {
    return images_figure(number, "Self-projected patterns of the cuboids, 4 bits", s.of_cuboids(), false);
  }
  if (number == "4.14") {
    return images_figure(number, "Camera images of the cuboids under these patterns", s.of_cuboids(), true);
  }
  if (number == "4.15") {
    return figure_4_15(s.of_cuboids());
  }
  if (number == "4.16") {
    return profile_figure(number, "Profile along the horizontal centre line", s.of_cuboids(), 8, true);
  }
  if (number == "4.17") {
    return figure_4_17(s.of_cuboids());
  }
  if (number == "4.18") {
    return profile_figure(number, "Profile along the vertical centre line", s.of_cuboids(), 4, false);
  }
  if (number == "4.19") {
    return film_figure(number, "A mouse that moves at 300 mm/s", "B7",
                       self_projected_film("mouse", 0.02, 0.08, 8, s.done), low,
                       {report::ColourMap::diverging, -40, 40});
  }
  if (number == "4.20") {
    return film_figure(number, "Two hands that move at different heights", "B8",
                       self_projected_film("hands", 0.02, 0.04, 8, s.done), low,
                       {report::ColourMap::diverging, -60, 60});
  }
  throw std::invalid_argument("there is no figure " + number + " to make");
}

}  // namespace selfproj::lab
