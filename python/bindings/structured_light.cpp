// selfproj.structured_light: patterns, fast decoder and median, depth images and clouds.
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/variant.h>
#include <nanobind/stl/vector.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "host/files/output_file.h"
#include "host/images/image_sequence.h"
#include "host/structured_light/depth_run.h"
#include "python/bindings/arrays.h"
#include "python/bindings/images_input.h"
#include "selfproj/files/user_error.h"
#include "selfproj/rig/calibration.h"
#include "selfproj/rig/rig.h"
#include "selfproj/structured_light/depth_geometry.h"
#include "selfproj/structured_light/fast_decoder.h"
#include "selfproj/structured_light/gray_sequence.h"
#include "selfproj/structured_light/lens_triangulation.h"
#include "selfproj/structured_light/point_cloud.h"

namespace selfproj::python {
namespace {

using Depth = In<float, nb::ndim<2>, nb::c_contig>;
using CodeImage = In<std::uint16_t, nb::ndim<2>, nb::c_contig>;

// The fast decoder, for one thread at a time.
class FastDecoder {
 public:
  FastDecoder(int rows, int columns, int bits, int threshold, bool median)
      : decoder_({.rows = rows, .columns = columns, .bits = bits, .threshold = threshold}) {
    if (median) {
      median_.emplace(columns);
    }
  }

  std::optional<Out<std::uint16_t>> take(const In<std::uint8_t>& image, int pattern, bool good) {
    const Busy::Entered entered(busy_);
    const model::ImageView view = image_of(image);
    const model::GraySettings& settings = decoder_.settings();
    require(view.rows == settings.rows && view.columns == settings.columns, "image: its size is not the decoder's");
    if (!without_gil([&] { return decoder_.add_frame(positive_.keep(view, pattern), pattern, good); })) {
      return std::nullopt;
    }
    auto codes =
        new_array<std::uint16_t>({static_cast<std::size_t>(settings.rows), static_cast<std::size_t>(settings.columns)});
    without_gil([&] {
      if (median_) {
        median_->filter(decoder_.codes(), codes.data());
      } else {
        structured_light::code_words(decoder_.codes(), codes.data());
      }
    });
    return codes;
  }

  void restart() {
    const Busy::Entered entered(busy_);
    decoder_.restart();
  }

  [[nodiscard]] const model::GraySettings& settings() const { return decoder_.settings(); }

 private:
  structured_light::FastGrayDecoder decoder_;
  std::optional<structured_light::FastMedian> median_;
  KeptPositive positive_;
  Busy busy_;
};

// Depth from codes, and points from depth. It has no state; any number of threads may use it.
class Depths {
 public:
  // `rig` and `lines` are those of a triangulation by pinholes.
  Depths(std::unique_ptr<structured_light::Triangulation> triangulation, const rig::Rig& rig, double lines)
      : triangulation_(std::move(triangulation)), rig_(rig), lines_(lines) {}
  explicit Depths(std::unique_ptr<structured_light::LensTriangulation> triangulation)
      : triangulation_(std::move(triangulation)) {}

  [[nodiscard]] const structured_light::Triangulation& triangulation() const { return *triangulation_; }
  [[nodiscard]] const rig::Rig& rig() const { return rig_.value(); }
  [[nodiscard]] double lines() const { return lines_; }

  [[nodiscard]] Out<float> depth(const CodeImage& codes) const {
    require_size(codes.shape(0), codes.shape(1), "codes: their size is not that of the images");
    auto z = new_array<float>(shape());
    without_gil([&] { triangulation_->depth(codes.data(), z.data()); });
    return z;
  }

  [[nodiscard]] Out<float> points(const Depth& depth) const {
    require_size(depth.shape(0), depth.shape(1), "depth: its size is not that of the images");
    std::vector<float> points;
    without_gil([&] {
      for (std::size_t i = 0; i < triangulation_->pixels(); ++i) {
        if (!std::isnan(depth.data()[i])) {
          const structured_light::Point3f point = triangulation_->point(i, depth.data()[i]);
          points.insert(points.end(), {point.x, point.y, point.z});
        }
      }
    });
    const std::size_t count = points.size() / 3;
    return array_of(std::move(points), {count, 3});
  }

 private:
  [[nodiscard]] std::vector<std::size_t> shape() const {
    return {static_cast<std::size_t>(triangulation_->rows()), static_cast<std::size_t>(triangulation_->columns())};
  }
  void require_size(std::size_t rows, std::size_t columns, const char* text) const {
    require(shape() == std::vector<std::size_t>{rows, columns}, text);
  }

  std::unique_ptr<structured_light::Triangulation> triangulation_;
  std::optional<rig::Rig> rig_;
  double lines_ = 0;
};

// All numbers of the settings. visit(number) may change it.
template <class Settings, class Visit>
void visit_settings(Settings& s, const Visit& visit) {
  visit(s.rows), visit(s.columns), visit(s.bits), visit(s.row_bits), visit(s.lines), visit(s.row_lines);
  visit(s.max_residual_px), visit(s.limits.min_z_mm), visit(s.limits.max_z_mm), visit(s.limits.max_z_per_line_mm);
  visit(s.rows_are_x);
}

// Pickled as what it was made of: a rig, bits and lines, or a calibration and settings.
using DepthsState = std::variant<std::tuple<rig::Rig, int, double>, std::tuple<rig::Calibration, std::vector<double>>>;

DepthsState state_of_depths(const Depths& self) {
  const auto* lenses = dynamic_cast<const structured_light::LensTriangulation*>(&self.triangulation());
  if (lenses == nullptr) {
    return std::tuple(self.rig(), self.triangulation().bits(), self.lines());
  }
  std::vector<double> numbers;
  visit_settings(lenses->settings(), [&](auto value) { numbers.push_back(static_cast<double>(value)); });
  return std::tuple(lenses->calibration(), numbers);
}

void set_depths(Depths& self, const DepthsState& state) {
  if (const auto* of_rig = std::get_if<0>(&state)) {
    const auto& [rig, bits, lines] = *of_rig;
    new (&self) Depths(structured_light::triangulation_of_rig(rig, bits, {}, lines), rig, lines);
    return;
  }
  const auto& [calibration, numbers] = std::get<1>(state);
  structured_light::LensSettings settings;
  std::size_t next = 0;
  visit_settings(settings, [&](auto& value) {
    require(next < numbers.size(), "state: is none of a Triangulation");
    value = static_cast<std::decay_t<decltype(value)>>(numbers[next++]);
  });
  new (&self) Depths(std::make_unique<structured_light::LensTriangulation>(calibration, settings));
}

// What a folder of images gave.
struct Scan {
  std::shared_ptr<Depths> depths;
  Out<float> depth, intensity, quality;
};

using ScanState = std::tuple<std::shared_ptr<Depths>, Out<float>, Out<float>, Out<float>>;

std::shared_ptr<Depths> depths_of(std::unique_ptr<structured_light::Triangulation> triangulation,
                                  const std::string& rig, double lines) {
  if (auto* lenses = dynamic_cast<structured_light::LensTriangulation*>(triangulation.get())) {
    static_cast<void>(triangulation.release());
    return std::make_shared<Depths>(std::unique_ptr<structured_light::LensTriangulation>(lenses));
  }
  return std::make_shared<Depths>(std::move(triangulation), rig::load_rig(rig), lines);
}

Scan scan(const ImagesArgument& images, const Path& rig, const Path& calibration, int bits, int row_bits, int threshold,
          bool median, bool strict, const std::string& channel, std::optional<int> shift, bool unchecked, double lines,
          double row_lines) {
  require(rig.empty() != calibration.empty(), "rig, calibration: give one of them");
  require(
      bits >= 1 && bits <= model::GrayDecoder::kMaxBits && row_bits >= 0 && row_bits <= model::GrayDecoder::kMaxBits,
      "bits: must be in 1..12, row_bits in 0..12");
  require(threshold >= 0 && threshold <= 255, "threshold: must be in 0..255");
  require(lines >= 0 && row_lines >= 0, "lines, row_lines: must be 0 or more");
  require(!(median && (row_bits > 0 || strict)), "median: goes neither with row_bits nor with strict");
  structured_light::DepthSetup setup;
  setup.geometry.rig = rig.string();
  setup.geometry.calibration = calibration.string();
  setup.geometry.bits = bits;
  setup.geometry.row_bits = row_bits;
  setup.geometry.lines = lines;
  setup.geometry.row_lines = row_lines;
  setup.scanner.threshold = threshold;
  setup.scanner.median = median;
  setup.scanner.strict = strict;
  GivenImages given(images, {channel, shift});
  const std::size_t need = 2 * static_cast<std::size_t>(bits + row_bits);
  if (given.count() == need + 2) {
    given.resize(need);  // white and black come last
  }
  require(given.count() == need, "images: 2 (bits + row_bits) of them are needed; white and black may follow");
  structured_light::DepthRun run = without_gil([&] {
    images::ImageSequence sequence = given.sequence();
    return row_bits > 0
               ? structured_light::depth_of_both_axes(setup, sequence)
               : structured_light::depth_of_images(setup, sequence, [](std::size_t, const images::FloatImage&) {});
  });
  if (!unchecked && !run.contradiction.empty()) {
    throw UserError("images", run.contradiction);
  }
  const std::vector<std::size_t> shape = sides_of_image(run.depth.rows, run.depth.columns);
  structured_light::LightOfPixels light = std::move(run.light).value();
  return {depths_of(std::move(run.triangulation), setup.geometry.rig, lines), array_of_image(std::move(run.depth)),
          array_of(std::move(light.intensity), shape), array_of(std::move(light.contrast), shape)};
}

using PointValues = In<float, nb::ndim<1>, nb::c_contig>;

void save_ply(const Path& file, const In<float, nb::shape<-1, 3>, nb::c_contig>& points,
              const std::optional<In<std::uint8_t, nb::shape<-1, 3>, nb::c_contig>>& colours,
              const std::optional<PointValues>& intensity, const std::optional<PointValues>& quality,
              const std::string& axes) {
  const std::size_t count = points.shape(0);
  require(!colours || colours->shape(0) == count, "colours: one is needed for each point");
  require(intensity.has_value() == quality.has_value(), "intensity, quality: give both or none");
  require(axes.find_first_of("\r\n") == std::string::npos, "axes: must be one line");
  const bool measured = intensity.has_value();
  require(!measured || (intensity->shape(0) == count && quality->shape(0) == count),
          "intensity, quality: one is needed for each point");
  without_gil([&] {
    structured_light::PlyText ply(count, measured);
    for (std::size_t i = 0; i < count; ++i) {
      constexpr std::uint8_t kGrey = 200;
      const float* at = points.data() + 3 * i;
      const std::uint8_t* colour = colours ? colours->data() + 3 * i : nullptr;
      ply.add({at[0], at[1], at[2]}, colour != nullptr ? colour[0] : kGrey, colour != nullptr ? colour[1] : kGrey,
              colour != nullptr ? colour[2] : kGrey, measured ? intensity->data()[i] : 0,
              measured ? quality->data()[i] : 0);
    }
    files::OutputFile(file.string()).write(ply.file(axes.empty() ? "points in mm" : "points in mm, " + axes));
  });
}

Out<float> load_ply(const Path& file) {
  const std::vector<structured_light::Point3f> points =
      without_gil([&] { return structured_light::read_ply(file.string()); });
  auto array = new_array<float>({points.size(), 3});
  static_assert(sizeof(structured_light::Point3f) == 3 * sizeof(float));
  std::memcpy(array.data(), points.data(), points.size() * sizeof(structured_light::Point3f));
  return array;
}

void bind_patterns(nb::module_& module) {
  nb::class_<structured_light::GraySequence>(
      module, "GraySequence",
      "The Gray-code patterns of both axes of a projector, in the order in which to show them: each\n"
      "positive and its inverse, columns before rows, then white and black.")
      .def(nb::init<int, int>(), nb::arg("columns"), nb::arg("rows"), "Sides 1..16384.")
      .def_prop_ro("count", &structured_light::GraySequence::count, "The number of images.")
      .def_prop_ro("column_bits", &structured_light::GraySequence::column_bits)
      .def_prop_ro("row_bits", &structured_light::GraySequence::row_bits)
      .def(
          "image",
          [](const structured_light::GraySequence& self, int index) {
            return array_of(self.image(index),
                            {static_cast<std::size_t>(self.rows()), static_cast<std::size_t>(self.columns())});
          },
          nb::arg("index"), "Image `index`: uint8, (rows, columns), 0 or 255. IndexError if there is none.")
      .def("__repr__",
           [](const structured_light::GraySequence& self) {
             return "GraySequence(" + std::to_string(self.columns()) + ", " + std::to_string(self.rows()) + ")";
           })
      .def("__getstate__",
           [](const structured_light::GraySequence& self) { return std::pair(self.columns(), self.rows()); })
      .def("__setstate__", [](structured_light::GraySequence& self, const std::pair<int, int>& sides) {
        new (&self) structured_light::GraySequence(sides.first, sides.second);
      });
  auto decoder = nb::class_<FastDecoder>(
      module, "GrayDecoder", "The results of selfproj.model.GrayDecoder, many times faster; for one thread at a time.");
  refuse_pickling(decoder, "is in the midst of a cycle of images; pickle its code images");
  decoder
      .def(nb::init<int, int, int, int, bool>(), nb::arg("rows"), nb::arg("columns"), nb::arg("bits"),
           nb::arg("threshold") = 5, nb::arg("median") = false, "median: take the 3 x 3 median of each code image.")
      .def("take", &FastDecoder::take, nb::arg("image").noconvert(), nb::arg("pattern"), nb::arg("good") = true,
           "Takes a frame with its pattern index. Returns a new code image if one is due, else None.")
      .def("restart", &FastDecoder::restart, "Waits for pattern 0.")
      .def("__repr__", [](const FastDecoder& self) { return decoder_text(self.settings()); });
}

}  // namespace

void bind_structured_light(nb::module_& module) {
  bind_patterns(module);
  bind_stripes(module);
  nb::class_<Depths>(module, "Triangulation", "From code images to depth. Any number of threads may use it at once.")
      .def_prop_ro("rows", [](const Depths& self) { return self.triangulation().rows(); })
      .def_prop_ro(
          "rows_are_x", [](const Depths& self) { return self.triangulation().rows_are_x(); },
          "Whether x runs from row to row, as in a rig; otherwise from column to column.")
      .def_prop_ro(
          "axes", [](const Depths& self) { return self.triangulation().axes(); },
          "The axes of its points in words, for save_ply.")
      .def_prop_ro("columns", [](const Depths& self) { return self.triangulation().columns(); })
      .def("depth", &Depths::depth, nb::arg("codes").noconvert(),
           "Depth z in mm (float32, NaN where there is none) of a code image, uint16.")
      .def("points", &Depths::points, nb::arg("depth").noconvert(),
           "The points x, y, z in mm (float32, (n, 3)) of the pixels that have a depth.")
      .def("__repr__",
           [](const Depths& self) {
             return shape_text("Triangulation",
                               sides_of_image(self.triangulation().rows(), self.triangulation().columns()));
           })
      .def("__getstate__", &state_of_depths)
      .def("__setstate__", &set_depths);
  module.def(
      "triangulation",
      [](const rig::Rig& rig, int bits, double lines) {
        require(lines == 0 || lines >= std::ldexp(1.0, bits), "lines: must be 0, or 2^bits or more");
        return std::make_unique<Depths>(structured_light::triangulation_of_rig(rig, bits, {}, lines), rig, lines);
      },
      nb::arg("rig"), nb::arg("bits"), nb::arg("lines") = 0.0,
      "For codes of `bits` bits along the lines of the rig's projector, which cover `lines` of them (0: all, or one\n"
      "for each code where the codes are more).");
  nb::class_<Scan>(module, "Scan", "A depth image, and how its points follow from it.")
      .def_ro("depth", &Scan::depth, nb::rv_policy::reference, "z in mm, float32, NaN where there is none.")
      .def_ro("intensity", &Scan::intensity, nb::rv_policy::reference,
              "Grey value under light, float32, (rows, columns).")
      .def_ro("quality", &Scan::quality, nb::rv_policy::reference,
              "Contrast of the newest pair in grey values, float32: how sure its bit is.")
      .def_prop_ro("triangulation", [](const Scan& self) { return self.depths; })
      .def(
          "points", [](const Scan& self) { return self.depths->points(Depth(self.depth)); }, nb::rv_policy::reference,
          "The points x, y, z in mm, float32, (n, 3).")
      .def("__repr__", [](const Scan& self) { return shape_text("Scan", sides_of(self.depth)); })
      .def("__getstate__",
           [](const Scan& self) {
             return nb::make_tuple(self.depths, pickled(self.depth), pickled(self.intensity), pickled(self.quality));
           })
      .def("__setstate__", [](Scan& self, const ScanState& state) {
        const auto& [depths, depth, intensity, quality] = state;
        new (&self) Scan{depths, depth, intensity, quality};
      });
  module.def(
      "scan", &scan, nb::arg("images").noconvert(), nb::kw_only(), nb::arg("rig") = "", nb::arg("calibration") = "",
      nb::arg("bits"), nb::arg("row_bits") = 0, nb::arg("threshold") = 5, nb::arg("median") = false,
      nb::arg("strict") = false, nb::arg("channel") = "", nb::arg("shift") = nb::none(), nb::arg("unchecked") = false,
      nb::arg("lines") = 0.0, nb::arg("row_lines") = 0.0,
      "The depth image of captured images: a uint8 array (images, rows, columns), a list of arrays, a folder, or\n"
      "the files in order. rig: a built-in rig or a file; or calibration: OpenCV's YAML. With row_bits both axes\n"
      "are coded. The other arguments are the options of `selfproj depth`.\n"
      "InputError where the images contradict each other or the geometry, unless unchecked.");
  module.def("save_ply", &save_ply, nb::arg("file"), nb::arg("points").noconvert(),
             nb::arg("colours").noconvert() = nb::none(), nb::arg("intensity").noconvert() = nb::none(),
             nb::arg("quality").noconvert() = nb::none(), nb::arg("axes") = "",
             "Writes a cloud, whole or not at all. points: float32, (n, 3); colours: uint8, (n, 3), or None.\n"
             "intensity and quality: float32, (n,), both or none, such as scan.intensity[isfinite(scan.depth)]; of a\n"
             "light section m0 / n and m0, as in the clouds of the commands. axes: their directions in words for the\n"
             "head of the file, such as scan.triangulation.axes.");
  module.def("load_ply", &load_ply, nb::arg("file"), "The points of a PLY file, binary or text: float32, (n, 3).");
}

}  // namespace selfproj::python
