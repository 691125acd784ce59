// selfproj.structured_light: patterns, fast decoder and median, depth images and clouds.
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/files/output_file.h"
#include "host/images/image_sequence.h"
#include "host/structured_light/depth_run.h"
#include "python/bindings/arrays.h"
#include "python/bindings/images_input.h"
#include "selfproj/files/user_error.h"
#include "selfproj/structured_light/depth_geometry.h"
#include "selfproj/structured_light/fast_decoder.h"
#include "selfproj/structured_light/gray_sequence.h"
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

 private:
  structured_light::FastGrayDecoder decoder_;
  std::optional<structured_light::FastMedian> median_;
  KeptPositive positive_;
  Busy busy_;
};

// Depth from codes, and points from depth. It has no state; any number of threads may use it.
class Depths {
 public:
  explicit Depths(std::unique_ptr<structured_light::Triangulation> triangulation)
      : triangulation_(std::move(triangulation)) {}

  [[nodiscard]] const structured_light::Triangulation& triangulation() const { return *triangulation_; }

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
};

// What a folder of images gave. One that was pickled has its points instead of `depths`.
struct Scan {
  std::shared_ptr<Depths> depths;
  Out<float> depth;
  std::optional<Out<float>> kept;

  [[nodiscard]] Out<float> points() const { return kept ? *kept : depths->points(Depth(depth)); }
};

Scan scan(const ImagesArgument& images, const Path& rig, const Path& calibration, int bits, int row_bits, int threshold,
          bool median, bool strict, const std::string& channel, std::optional<int> shift, bool unchecked) {
  require(rig.empty() != calibration.empty(), "rig, calibration: give one of them");
  require(
      bits >= 1 && bits <= model::GrayDecoder::kMaxBits && row_bits >= 0 && row_bits <= model::GrayDecoder::kMaxBits,
      "bits: must be in 1..12, row_bits in 0..12");
  require(threshold >= 0 && threshold <= 255, "threshold: must be in 0..255");
  require(!(median && (row_bits > 0 || strict)), "median: goes neither with row_bits nor with strict");
  structured_light::DepthSetup setup;
  setup.geometry.rig = rig.string();
  setup.geometry.calibration = calibration.string();
  setup.geometry.bits = bits;
  setup.geometry.row_bits = row_bits;
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
  return {std::make_shared<Depths>(std::move(run.triangulation)), array_of_image(std::move(run.depth)), {}};
}

void save_ply(const Path& file, const In<float, nb::shape<-1, 3>, nb::c_contig>& points,
              const std::optional<In<std::uint8_t, nb::shape<-1, 3>, nb::c_contig>>& colours) {
  require(!colours || colours->shape(0) == points.shape(0), "colours: one is needed for each point");
  without_gil([&] {
    structured_light::PlyText ply(points.shape(0));
    for (std::size_t i = 0; i < points.shape(0); ++i) {
      constexpr std::uint8_t kGrey = 200;
      const float* at = points.data() + 3 * i;
      const std::uint8_t* colour = colours ? colours->data() + 3 * i : nullptr;
      ply.add({at[0], at[1], at[2]}, colour != nullptr ? colour[0] : kGrey, colour != nullptr ? colour[1] : kGrey,
              colour != nullptr ? colour[2] : kGrey);
    }
    files::OutputFile(file.string()).write(ply.file("points in mm"));
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
  nb::class_<FastDecoder>(module, "GrayDecoder",
                          "The results of selfproj.model.GrayDecoder, many times faster; for one thread at a time.")
      .def(nb::init<int, int, int, int, bool>(), nb::arg("rows"), nb::arg("columns"), nb::arg("bits"),
           nb::arg("threshold") = 5, nb::arg("median") = false, "median: take the 3 x 3 median of each code image.")
      .def("take", &FastDecoder::take, nb::arg("image").noconvert(), nb::arg("pattern"), nb::arg("good") = true,
           "Takes a frame with its pattern index. Returns a new code image if one is due, else None.")
      .def("restart", &FastDecoder::restart, "Waits for pattern 0.");
}

}  // namespace

void bind_structured_light(nb::module_& module) {
  bind_patterns(module);
  bind_stripes(module);
  nb::class_<Depths>(module, "Triangulation", "From code images to depth. Any number of threads may use it at once.")
      .def_prop_ro("rows", [](const Depths& self) { return self.triangulation().rows(); })
      .def_prop_ro("columns", [](const Depths& self) { return self.triangulation().columns(); })
      .def("depth", &Depths::depth, nb::arg("codes").noconvert(),
           "Depth z in mm (float32, NaN where there is none) of a code image, uint16.")
      .def("points", &Depths::points, nb::arg("depth").noconvert(),
           "The points x, y, z in mm (float32, (n, 3)) of the pixels that have a depth.")
      .def("__repr__", [](const Depths& self) {
        return shape_text("Triangulation", {static_cast<std::size_t>(self.triangulation().rows()),
                                            static_cast<std::size_t>(self.triangulation().columns())});
      });
  module.def(
      "triangulation",
      [](const rig::Rig& rig, int bits) {
        return std::make_unique<Depths>(structured_light::triangulation_of_rig(rig, bits));
      },
      nb::arg("rig"), nb::arg("bits"), "For codes of `bits` bits along the lines of the rig's projector.");
  nb::class_<Scan>(module, "Scan", "A depth image, and how its points follow from it.")
      .def_ro("depth", &Scan::depth, nb::rv_policy::reference, "z in mm, float32, NaN where there is none.")
      .def_prop_ro(
          "triangulation", [](const Scan& self) { return self.depths; }, "None for a scan that was pickled.")
      .def("points", &Scan::points, nb::rv_policy::reference, "The points x, y, z in mm, float32, (n, 3).")
      .def("__repr__", [](const Scan& self) { return shape_text("Scan", sides_of(self.depth)); })
      .def("__getstate__",
           [](const Scan& self) {
             return nb::make_tuple(nb::cast(self.depth, nb::rv_policy::reference),
                                   nb::cast(self.points(), nb::rv_policy::reference));
           })
      .def("__setstate__", [](Scan& self, const nb::tuple& state) {
        require(state.size() == 2, "state: is none of a Scan");
        new (&self) Scan{nullptr, nb::cast<Out<float>>(state[0]), nb::cast<Out<float>>(state[1])};
      });
  module.def(
      "scan", &scan, nb::arg("images").noconvert(), nb::arg("rig") = "", nb::arg("calibration") = "", nb::arg("bits"),
      nb::arg("row_bits") = 0, nb::arg("threshold") = 5, nb::arg("median") = false, nb::arg("strict") = false,
      nb::arg("channel") = "", nb::arg("shift") = nb::none(), nb::arg("unchecked") = false,
      "The depth image of captured images: a uint8 array (images, rows, columns), a list of arrays, a folder, or\n"
      "the files in order. rig: a built-in rig or a file; or calibration: OpenCV's YAML. With row_bits both axes\n"
      "are coded. Otherwise as `selfproj depth`:\n"
      "InputError where the images contradict each other or the geometry, unless unchecked.");
  module.def("save_ply", &save_ply, nb::arg("file"), nb::arg("points").noconvert(),
             nb::arg("colours").noconvert() = nb::none(),
             "Writes a cloud, whole or not at all. points: float32, (n, 3); colours: uint8, (n, 3), or None.");
  module.def("load_ply", &load_ply, nb::arg("file"), "The points of a PLY file, binary or text: float32, (n, 3).");
}

}  // namespace selfproj::python
