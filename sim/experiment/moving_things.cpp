#include "sim/experiment/moving_things.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <iterator>
#include <limits>
#include <span>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "host/report/map_picture.h"
#include "host/structured_light/scanner.h"
#include "host/structured_light/self_scanner.h"
#include "host/structured_light/triangulation.h"
#include "sim/scene/parallel.h"
#include "sim/scene/pattern_renderer.h"
#include "sim/scene/scene_list.h"
#include "sim/scene/self_scenes.h"

namespace selfproj {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// A scene that stands as it was at one time.
class Frozen final : public Scene {
 public:
  Frozen(const Scene& scene, double time) : scene_(scene), time_(time) {}
  [[nodiscard]] int frames() const override { return scene_.frames(); }
  [[nodiscard]] double height(double x, double y, double /*t*/) const override { return scene_.height(x, y, time_); }
  [[nodiscard]] HeightRange range(const Box& box, double /*t0*/, double /*t1*/) const override {
    return scene_.range(box, time_, time_);
  }
  [[nodiscard]] double speed() const override { return 0; }
  [[nodiscard]] Bodies bodies(double /*t*/) const override { return scene_.bodies(time_); }

 private:
  const Scene& scene_;
  double time_;
};

// What is to be measured: a moving thing in the part of the image with these columns.
struct Thing {
  std::string name;
  int column_0, column_1;
  double least;  // mm over the reference from which on a pixel belongs to it, for its size
};

// Of one depth image.
struct ThingFigures {
  std::size_t pixels = 0;  // that truly show it, in the projector's light
  std::size_t valid = 0;
  double square = 0;                   // of z against the truth
  double height = 0, true_height = 0;  // 95th of 100 parts of the differences from the reference
  double rows = 0, true_rows = 0;      // extent in pixels
  double columns = 0, true_columns = 0;

  [[nodiscard]] double share() const { return static_cast<double>(valid) / static_cast<double>(pixels); }
  [[nodiscard]] double rms() const { return std::sqrt(square / static_cast<double>(valid)); }
};

double quantile(std::vector<float>& values, double share) {
  if (values.empty()) {
    return kNan;
  }
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return static_cast<double>(*at);
}

// Rows and columns over which a thing reaches, of pixels that have six and more of 3 x 3 like them (with e = 0 single
// rows of the background, in which noise moves a code one down, are matched at the other end of the window): from the
// first to the last that have at least a quarter as many of its pixels as the fullest one, so that single pixels do not
// count.
std::pair<double, double> extent(const FloatImage& difference, const Thing& thing, const FloatImage& true_difference) {
  constexpr int kAround = 30;  // pixels about the true one in which it is looked for
  int row_0 = difference.rows;
  int row_1 = 0;
  int column_0 = difference.columns;
  int column_1 = 0;
  for (int r = 0; r < difference.rows; ++r) {
    for (int c = thing.column_0; c < thing.column_1; ++c) {
      if (static_cast<double>(true_difference.row(r)[c]) > thing.least) {
        row_0 = std::min(row_0, r - kAround);
        row_1 = std::max(row_1, r + kAround);
        column_0 = std::min(column_0, c - kAround);
        column_1 = std::max(column_1, c + kAround);
      }
    }
  }
  std::vector<int> of_row(static_cast<std::size_t>(difference.rows), 0);
  std::vector<int> of_column(static_cast<std::size_t>(difference.columns), 0);
  const auto is_over = [&](int r, int c) { return static_cast<double>(difference.row(r)[c]) > thing.least ? 1 : 0; };
  for (int r = std::max(1, row_0); r < std::min(row_1, difference.rows - 1); ++r) {
    for (int c = std::max({1, thing.column_0, column_0});
         c < std::min({thing.column_1, difference.columns - 1, column_1}); ++c) {
      int count = 0;
      for (int dr = -1; dr <= 1; ++dr) {
        for (int dc = -1; dc <= 1; ++dc) {
          count += is_over(r + dr, c + dc);
        }
      }
      if (is_over(r, c) != 0 && count >= 6) {
        ++of_row[static_cast<std::size_t>(r)];
        ++of_column[static_cast<std::size_t>(c)];
      }
    }
  }
  const auto length = [](const std::vector<int>& counts) {
    const int least = std::max(1, *std::max_element(counts.begin(), counts.end()) / 4);
    const auto in = [least](int count) { return count >= least; };
    const auto first = std::find_if(counts.begin(), counts.end(), in);
    const auto last = std::find_if(counts.rbegin(), counts.rend(), in);
    return first == counts.end() ? 0.0 : static_cast<double>(last.base() - first);
  };
  return {length(of_row), length(of_column)};
}

FloatImage minus(const FloatImage& a, const FloatImage& b) {
  FloatImage result = a;
  for (std::size_t i = 0; i < result.values.size(); ++i) {
    result.values[i] -= b.values[i];
  }
  return result;
}

ThingFigures figures_of(const Thing& thing, const FloatImage& depth, const FloatImage& difference,
                        const FloatImage& truth, const FloatImage& true_difference) {
  ThingFigures f;
  std::vector<float> heights;
  std::vector<float> true_heights;
  for (int r = 0; r < depth.rows; ++r) {
    for (int c = thing.column_0; c < thing.column_1; ++c) {
      if (!(true_difference.row(r)[c] > 1)) {
        continue;
      }
      ++f.pixels;
      true_heights.push_back(true_difference.row(r)[c]);
      const double error = static_cast<double>(depth.row(r)[c]) - static_cast<double>(truth.row(r)[c]);
      if (!std::isnan(error) && !std::isnan(difference.row(r)[c])) {
        ++f.valid;
        f.square += error * error;
        heights.push_back(difference.row(r)[c]);
      }
    }
  }
  constexpr double kShare = 0.95;
  f.height = quantile(heights, kShare);
  f.true_height = quantile(true_heights, kShare);
  std::tie(f.rows, f.columns) = extent(difference, thing, true_difference);
  std::tie(f.true_rows, f.true_columns) = extent(true_difference, thing, true_difference);
  return f;
}

// What a method measured of each thing in one depth image.
struct Instant {
  int frame = 0;  // in the middle of the window
  std::vector<ThingFigures> things;
};

// All depth images of a thing by a method.
class Summary {
 public:
  void add(const ThingFigures& f) {
    ++images_;
    pixels_ += static_cast<double>(f.pixels);
    valid_ += static_cast<double>(f.valid);
    square_ += f.square;
    worst_ = std::max(worst_, f.rms());
    height_ += f.height - f.true_height;
    height_most_ = std::max(height_most_, std::abs(f.height - f.true_height));
    size_most_ = std::max({size_most_, std::abs(f.rows - f.true_rows), std::abs(f.columns - f.true_columns)});
    rows_ += f.rows - f.true_rows;
    columns_ += f.columns - f.true_columns;
  }
  [[nodiscard]] double rms() const { return std::sqrt(square_ / valid_); }
  [[nodiscard]] std::vector<std::string> cells() const {
    return {std::to_string(images_),
            figure_text(100 * valid_ / pixels_, 1),
            figure_text(rms()),
            figure_text(worst_),
            figure_text(height_ / images_),
            figure_text(height_most_),
            figure_text(rows_ / images_, 1),
            figure_text(columns_ / images_, 1),
            figure_text(size_most_, 0)};
  }

 private:
  int images_ = 0;
  double pixels_ = 0, valid_ = 0, square_ = 0, worst_ = 0;
  double height_ = 0, height_most_ = 0, rows_ = 0, columns_ = 0, size_most_ = 0;
};

// One of the two methods, streaming.
class MotionStream {
 public:
  virtual ~MotionStream() = default;
  MotionStream() = default;
  MotionStream(const MotionStream&) = delete;
  MotionStream& operator=(const MotionStream&) = delete;
  [[nodiscard]] virtual bool take(const ImageView& image, int pattern) = 0;
  [[nodiscard]] virtual const FloatImage& depth() const = 0;
  [[nodiscard]] virtual FloatImage difference() const = 0;
  [[nodiscard]] virtual int bits() const = 0;
  [[nodiscard]] virtual FloatImage pattern(int index) const = 0;
};

class SelfStream final : public MotionStream {
 public:
  SelfStream(const Rig& rig, const SelfReference& reference, const MatchTable& table)
      : reference_(reference), scanner_(rig, reference, table, rig.measure.code_threshold) {}
  bool take(const ImageView& image, int pattern) override { return scanner_.take(image, pattern); }
  [[nodiscard]] const FloatImage& depth() const override { return scanner_.depth(); }
  [[nodiscard]] FloatImage difference() const override { return scanner_.difference(); }
  [[nodiscard]] int bits() const override { return reference_.stripes.bits; }
  [[nodiscard]] FloatImage pattern(int index) const override { return self_projected_pattern(reference_, index); }

 private:
  const SelfReference& reference_;
  SelfScanner scanner_;
};

// All of a coarse rig's.
int coded_lines(const Rig& rig) { return std::min(kCodedLines, rig.projector.lines); }

class ConventionalStream final : public MotionStream {
 public:
  ConventionalStream(const Rig& rig, int bits)
      : rig_(rig),
        triangulation_(rig, bits, {}, coded_lines(rig)),
        scanner_(triangulation_, {rig.measure.code_threshold, true, false, 5}) {}
  bool take(const ImageView& image, int pattern) override { return scanner_.take(image, pattern); }
  [[nodiscard]] const FloatImage& depth() const override { return scanner_.depth(); }
  [[nodiscard]] FloatImage difference() const override { return minus(reference_, scanner_.depth()); }
  [[nodiscard]] int bits() const override { return triangulation_.bits(); }
  [[nodiscard]] FloatImage pattern(int index) const override {
    return gray_pattern(rig_, triangulation_.bits(), coded_lines(rig_), index);
  }
  void set_reference(const FloatImage& depth) { reference_ = depth; }

 private:
  const Rig& rig_;
  PlaneTriangulation triangulation_;
  Scanner scanner_;
  FloatImage reference_;
};

// Frames first .. first + count - 1 under the stream's patterns, the first under pattern 0. `see` is told the frame
// after each depth image.
void play(const PatternRenderer& renderer, const RenderOptions& options, MotionStream& stream, int first, int count,
          const std::function<void(int frame)>& see, const std::function<void()>& done) {
  std::vector<Image> patterns;
  for (int i = 0; i < 2 * stream.bits(); ++i) {
    patterns.push_back(pattern_image(stream.pattern(i)));
  }
  const PatternSet lights(renderer.rig(), patterns, options.projector_blur);
  std::array<std::vector<std::uint8_t>, 2> pair;
  const Rig& rig = renderer.rig();
  for (int i = 0; i < count; i += 2) {
    parallel_for(2, 0, [&](int half) {
      auto& image = pair.at(static_cast<std::size_t>(half));
      image.resize(static_cast<std::size_t>(rig.camera.rows) * static_cast<std::size_t>(rig.camera.columns));
      renderer.render(first + i + half, lights.of_frame(i + half), std::span(image));
    });
    for (int half = 0; half < 2; ++half) {
      const ImageView view{pair.at(static_cast<std::size_t>(half)).data(), rig.camera.rows, rig.camera.columns,
                           rig.camera.columns};
      if (stream.take(view, (i + half) % lights.size())) {
        see(first + i + half);
      }
      done();
    }
  }
}

// What is measured, and where.
struct Setting {
  const MovingOptions& options;
  const Scene& scene;
  const PatternRenderer& renderer;
  const FloatImage& background_z;  // true z of what stands still
  std::vector<Thing> things;
  int start;               // frames before the first common pair
  double most_difference;  // mm, of the pictures' colours
  std::function<void()> count;
};

// What a method measured.
struct Observation {
  std::string method;
  int window = 0;  // frames
  std::vector<Instant> moving;
  std::vector<Instant> moving_then;  // those of them that were also taken at rest
  std::vector<Instant> at_rest;
  std::vector<ReportPicture> strip;
  FloatImage depth, difference, truth;  // of the last picture
};

int pairs_of(const MovingOptions& options, const Scene& scene, int start) {
  const int most = (scene.frames() - options.first - start) / 2;
  if (options.first < 0 || options.pairs < 0 || options.strips < 1 || most < std::max(options.pairs, 1)) {
    throw std::invalid_argument("moving things: the scene has not so many frames");
  }
  return options.pairs == 0 ? most : options.pairs;
}

// Every how many depth images one is shown. Odd, so that in turn each plane is the newest one.
int strip_step(const MovingOptions& options, int pairs) {
  const int step = std::max(1, pairs / options.strips);
  return step % 2 == 0 ? step + 1 : step;
}

Instant look(const Setting& setting, const MotionStream& stream, const PatternRenderer& of, int frame,
             FloatImage& truth) {
  of.depth(frame, truth.values, true);
  const FloatImage true_difference = minus(setting.background_z, truth);
  const FloatImage difference = stream.difference();
  Instant instant{frame, {}};
  for (const Thing& thing : setting.things) {
    instant.things.push_back(figures_of(thing, stream.depth(), difference, truth, true_difference));
  }
  return instant;
}

Observation observe(const Setting& setting, MotionStream& stream, const std::string& method) {
  const MovingOptions& options = setting.options;
  const Rig& rig = options.rig;
  const int pairs = pairs_of(options, setting.scene, setting.start);
  const int still_every = strip_step(options, pairs);
  const double pixel = rig.plane_z_mm * rig.camera.pixel_pitch_mm / rig.camera.focal_length_mm;
  Observation seen;
  seen.method = method;
  seen.window = 2 * stream.bits();
  FloatImage truth(rig.camera.rows, rig.camera.columns);
  play(
      setting.renderer, options.render, stream, options.first, setting.start + 2 * pairs,
      [&](int frame) {
        if (frame < options.first + setting.start) {
          return;
        }
        const int middle = frame - stream.bits() + 1;
        seen.moving.push_back(look(setting, stream, setting.renderer, middle, truth));
        // The middle one of so many.
        if (static_cast<int>(seen.moving.size() - 1) % still_every != still_every / 2) {
          return;
        }
        seen.moving_then.push_back(seen.moving.back());
        seen.depth = stream.depth();
        seen.difference = stream.difference();
        seen.truth = truth;
        seen.strip.push_back(
            {fmt::format("{}, t = {:.3f} s", method, middle / rig.camera.frame_rate_hz),
             labelled_map_png(seen.difference,
                              {ColourMap::diverging, -setting.most_difference, setting.most_difference}, {pixel, pixel},
                              "difference from the reference, mm"),
             ""});
      },
      setting.count);
  for (const Instant& then : seen.moving_then) {
    const Frozen frozen(setting.scene, then.frame / rig.camera.frame_rate_hz);
    const PatternRenderer still(rig, frozen, options.render);
    play(
        still, options.render, stream, 0, seen.window,
        [&](int frame) {
          if (frame == seen.window - 1) {
            seen.at_rest.push_back(look(setting, stream, still, 0, truth));
          }
        },
        setting.count);
  }
  return seen;
}

Summary summary_of(const std::vector<Instant>& instants, std::size_t thing) {
  Summary summary;
  for (const Instant& instant : instants) {
    summary.add(instant.things[thing]);
  }
  return summary;
}

void add_rows(const Setting& setting, const Observation& seen, ReportTable& errors, ReportTable& motion) {
  for (std::size_t k = 0; k < setting.things.size(); ++k) {
    const std::string name = setting.things[k].name + ", " + seen.method;
    errors.rows.push_back({name});
    for (const std::string& cell : summary_of(seen.moving, k).cells()) {
      errors.rows.back().push_back(cell);
    }
    const double moving = summary_of(seen.moving_then, k).rms();
    const double at_rest = summary_of(seen.at_rest, k).rms();
    motion.rows.push_back({name, figure_text(1000 * seen.window / setting.options.rig.camera.frame_rate_hz, 0),
                           figure_text(moving), figure_text(at_rest),
                           figure_text(std::sqrt(std::max(moving * moving - at_rest * at_rest, 0.0)))});
  }
}

// Height and size of a thing over time, beside the truth.
void add_plots(const Setting& setting, const Observation& seen, std::size_t thing, std::vector<ReportPlot>& plots) {
  struct Quantity {
    const char* title;
    const char* label;
    double ThingFigures::*measured;
    double ThingFigures::*truth;
  };
  constexpr std::array<Quantity, 3> kQuantities{{
      {"height", "mm", &ThingFigures::height, &ThingFigures::true_height},
      {"size along x", "rows", &ThingFigures::rows, &ThingFigures::true_rows},
      {"size along y", "columns", &ThingFigures::columns, &ThingFigures::true_columns},
  }};
  for (const Quantity& quantity : kQuantities) {
    ReportPlot plot{fmt::format("{}, {}: {}", setting.things[thing].name, seen.method, quantity.title),
                    "time, s",
                    quantity.label,
                    {{{}, {}, "a", "measured"}, {{}, {}, "b", "truth"}},
                    1};
    for (const Instant& instant : seen.moving) {
      const ThingFigures& f = instant.things[thing];
      const double t = instant.frame / setting.options.rig.camera.frame_rate_hz;
      plot.traces[0].x.push_back(t);
      plot.traces[0].y.push_back(f.*quantity.measured);
      plot.traces[1].x.push_back(t);
      plot.traces[1].y.push_back(f.*quantity.truth);
    }
    plots.push_back(std::move(plot));
  }
}

void add_series(const Setting& setting, const Observation& seen, std::string& series) {
  for (const Instant& instant : seen.moving) {
    for (std::size_t k = 0; k < setting.things.size(); ++k) {
      const ThingFigures& f = instant.things[k];
      fmt::format_to(std::back_inserter(series),
                     "\"{}\",\"{}\",{},{:.4f},{:.4f},{:.3f},{:.3f},{:.3f},{:.0f},{:.0f},{:.0f},{:.0f}\n",
                     setting.things[k].name, seen.method, instant.frame,
                     instant.frame / setting.options.rig.camera.frame_rate_hz, f.share(), f.rms(), f.height,
                     f.true_height, f.rows, f.true_rows, f.columns, f.true_columns);
    }
  }
}

}  // namespace

StructuredLightResult run_moving(const std::string& name, const MovingOptions& options,
                                 const ProgressOfImages& progress) {
  const Rig& rig = options.rig;
  const bool mouse = name == "B7";
  const auto background = make_scene(mouse ? "slider" : "block", rig);
  const auto scene = make_scene(mouse ? "mouse" : "hands", rig);
  const int columns = rig.camera.columns;
  constexpr int kConventionalBits = 8;
  const int start = 2 * kConventionalBits - 2;
  const int pairs = pairs_of(options, *scene, start);
  const int frames = start + 2 * pairs;
  const int still_every = strip_step(options, pairs);
  const int stills = (pairs - still_every / 2 + still_every - 1) / still_every;
  const int scan = options.gray_scan ? GrayPointScan(rig).count() : LinePointScan(rig).count();
  const int all = scan + 2 * kConventionalBits + 2 * frames + stills * 2 * (Stripes{}.bits + kConventionalBits);
  std::size_t done = 0;
  const auto count = [&] { progress(++done, static_cast<std::size_t>(all)); };

  const SelfReference reference =
      make_self_reference(rig, scan_points(rig, *background, options.render, options.gray_scan, count), {});
  const MatchTable table(rig, reference, {options.e});
  const PatternRenderer background_renderer(rig, *background, options.render);
  const PatternRenderer renderer(rig, *scene, options.render);
  FloatImage background_z(rig.camera.rows, rig.camera.columns);
  background_renderer.depth(0, background_z.values);
  const Setting setting{options, *scene, renderer, background_z,
                        // The mouse from 6 mm over the slider on: its plate is 3 mm thick.
                        mouse ? std::vector<Thing>{{"mouse", 0, columns, 6}}
                              : std::vector<Thing>{{"left hand, over z = 441 mm", 0, columns / 2, 5},
                                                   {"right hand, over z = 550 mm", columns / 2, columns, 5}},
                        start, mouse ? 35.0 : 60.0, count};

  std::vector<Observation> seen;
  {
    SelfStream stream(rig, reference, table);
    seen.push_back(observe(setting, stream, "self-projected, 4 bits"));
  }
  {
    ConventionalStream stream(rig, kConventionalBits);
    play(
        background_renderer, options.render, stream, 0, 2 * kConventionalBits, [](int) {}, count);
    stream.set_reference(stream.depth());
    seen.push_back(observe(setting, stream, "conventional, 8 bits"));
  }

  StructuredLightResult result;
  ReportTable errors{
      fmt::format("{}: every depth image against the truth in the middle of its window", name),
      {"", "depth images", "valid, %", "z RMS, mm", "worst image", "height, mean error", "largest", "rows, mean error",
       "columns", "largest, px"},
      {},
      "Pixels that truly show the object in the projector's light. Height: the 95th of 100 parts of the differences "
      "from the reference. Size: rows and columns that hold at least a quarter as many of its pixels as the fullest "
      "one, within 30 pixels of the true one."};
  ReportTable motion{fmt::format("{}: what motion adds", name),
                     {"", "window, ms", "z RMS moving, mm", "z RMS at rest, mm", "added, mm"},
                     {},
                     "Over the same instants. Added: root of the difference of the squares."};
  result.series =
      "thing,method,frame,time_s,valid,z_rms_mm,height_mm,true_height_mm,rows,true_rows,columns,true_columns\n";
  for (Observation& o : seen) {
    add_rows(setting, o, errors, motion);
    add_series(setting, o, result.series);
    for (std::size_t k = 0; k < setting.things.size(); ++k) {
      add_plots(setting, o, k, result.page.plots);
    }
    std::move(o.strip.begin(), o.strip.end(), std::back_inserter(result.page.pictures));
  }
  result.depth = std::move(seen.front().depth);
  result.difference = std::move(seen.front().difference);
  result.truth = std::move(seen.front().truth);
  result.tables = {std::move(errors), std::move(motion)};
  result.page.title = "Experiment " + name;
  result.page.subtitle = mouse ? "Mouse on a slider, 300 mm/s: a film strip, 500 depth images a second"
                               : "Two hands at different heights: a film strip, 500 depth images a second";
  result.page.tables = result.tables;
  result.page.settings = {
      {"e", "e", static_cast<std::int64_t>(options.e)},
      {"threshold", "threshold of the binarization", static_cast<std::int64_t>(rig.measure.code_threshold)},
      {"seed", "seed", rig.imaging.seed}};
  return result;
}

}  // namespace selfproj
