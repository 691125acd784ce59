// selfproj.model: the definitions of model/, on arrays.
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <new>
#include <optional>
#include <tuple>
#include <vector>

#include "python/bindings/arrays.h"
#include "python/bindings/images_input.h"
#include "python/bindings/moments_result.h"
#include "selfproj/model/column_runs.h"
#include "selfproj/model/gray_decoder.h"
#include "selfproj/model/gray_match.h"
#include "selfproj/model/median3x3.h"

namespace selfproj::python {
namespace {

using ModelCodes = In<std::uint16_t, nb::c_contig>;

std::vector<std::size_t> shape_of(const ModelCodes& array) {
  std::vector<std::size_t> shape;
  for (std::size_t i = 0; i < array.ndim(); ++i) {
    shape.push_back(array.shape(i));
  }
  return shape;
}

// The decoder of the model, for one thread at a time.
class Decoder {
 public:
  Decoder(int rows, int columns, int bits, int threshold)
      : decoder_({.rows = rows, .columns = columns, .bits = bits, .threshold = threshold}) {}

  std::optional<Out<std::uint16_t>> take(const In<std::uint8_t>& image, int pattern, bool good) {
    const Busy::Entered entered(busy_);
    const model::ImageView view = image_of(image);
    if (!spare_) {
      spare_ = new_array<std::uint16_t>(
          {static_cast<std::size_t>(decoder_.settings().rows), static_cast<std::size_t>(decoder_.settings().columns)});
    }
    if (!without_gil([&] { return decoder_.add_frame(view, pattern, good, spare_->data()); })) {
      return std::nullopt;
    }
    std::optional<Out<std::uint16_t>> codes;
    codes.swap(spare_);
    return codes;
  }

  void restart() {
    const Busy::Entered entered(busy_);
    decoder_.restart();
  }

  [[nodiscard]] const model::GraySettings& settings() const { return decoder_.settings(); }

 private:
  model::GrayDecoder decoder_;
  std::optional<Out<std::uint16_t>> spare_;  // where the next code image goes
  Busy busy_;
};

Out<std::uint16_t> median(const ModelCodes& codes) {
  require(codes.ndim() == 2, "codes: an array of 2 dimensions is needed");
  constexpr std::size_t kMaxSide = 32768;
  require(codes.shape(0) <= kMaxSide && codes.shape(1) <= kMaxSide, "codes: too large");
  auto filtered = new_array<std::uint16_t>(shape_of(codes));
  without_gil([&] {
    model::median3x3(codes.data(), static_cast<int>(codes.shape(0)), static_cast<int>(codes.shape(1)), filtered.data());
  });
  return filtered;
}

Out<std::uint16_t> match(const ModelCodes& codes, const ModelCodes& table) {
  const std::size_t dimensions = codes.ndim();
  bool fits = table.ndim() == dimensions + 1;
  for (std::size_t i = 0; fits && i < dimensions; ++i) {
    fits = table.shape(i) == codes.shape(i);
  }
  require(fits, "table: its shape must be that of the codes, and 2^bits behind");
  const std::size_t words = table.shape(dimensions);
  require(std::has_single_bit(words), "table: its last side must be a power of two, 2^bits");
  auto lines = new_array<std::uint16_t>(shape_of(codes));
  without_gil([&] {
    model::GrayMatch::look_up(codes.data(), codes.size(), std::countr_zero(words), table.data(), lines.data());
  });
  return lines;
}

// Properties of Moments.
template <std::size_t Which>
Out<std::uint32_t> words_of(nb::pointer_and_handle<MomentsResult> self) {
  return self.p->words_array(Which, self.h);
}

template <std::size_t Which>
std::optional<Out<std::uint8_t>> bytes_of(nb::pointer_and_handle<MomentsResult> self) {
  return self.p->bytes_array(Which, self.h);
}

// Pickled as shape, words and, of the strongest run, bytes.
using MomentsState = std::tuple<std::vector<std::size_t>, bool, nb::bytes>;

MomentsState state_of(const MomentsResult& self) {
  const model::RunsView view = self.view(0);
  const std::size_t words = 3 * self.count() * sizeof(std::uint32_t);
  const std::size_t runs = self.has_runs() ? 2 * self.count() : 0;
  return {self.sides(), self.has_runs(), nb::bytes(view.moments.m0, words + runs)};
}

void set_state(MomentsResult& self, const MomentsState& state) {
  const auto& [sides, has_runs, bytes] = state;
  require(sides.size() == 1 || sides.size() == 2, "state: is none of Moments");
  new (&self) MomentsResult(has_runs ? model::Select::strongest : model::Select::all,
                            sides.size() == 2 ? std::optional(sides[0]) : std::nullopt, sides.back());
  const std::size_t size = self.count() * (3 * sizeof(std::uint32_t) + (has_runs ? 2 : 0));
  require(bytes.size() == size, "state: is none of Moments");
  std::memcpy(self.view(0).moments.m0, bytes.data(), size);
}

}  // namespace

void bind_model(nb::module_& module) {
  nb::enum_<model::Mode>(module, "Mode", "How much a lit pixel p > T weighs.")
      .value("BINARY", model::Mode::binary, "1")
      .value("GREY", model::Mode::grey, "p")
      .value("GREY_OVER", model::Mode::grey_over, "p - T");
  nb::enum_<model::Select>(module, "Select", "What of a column is measured.")
      .value("ALL", model::Select::all, "All lit pixels.")
      .value("STRONGEST", model::Select::strongest, "Its strongest run of lit pixels.");
  nb::class_<MomentsResult>(module, "Moments",
                            "Moments of every column: arrays of shape (columns,) or (images, columns).")
      .def_prop_ro("m0", words_of<0>, "Sum of the weights w, uint32.")
      .def_prop_ro("m1", words_of<1>, "Sum of row * w, rows from 1, uint32.")
      .def_prop_ro("n", words_of<2>, "Number of lit pixels, uint32.")
      .def_prop_ro("runs", bytes_of<0>, "Select.STRONGEST: number of runs, 3 for three or more, uint8. Else None.")
      .def_prop_ro("second", bytes_of<1>,
                   "Select.STRONGEST: sixteenths of M0 that the second run has, uint8. Else None.")
      .def("__repr__", [](const MomentsResult& self) { return shape_text("Moments", self.sides()); })
      .def("__getstate__", &state_of)
      .def("__setstate__", &set_state);
  const auto kernel = [](const auto& image, const model::Measure& measure, const model::RunsView& out) {
    model::measure_columns(image, measure, out);
  };
  def_moments(
      module, kernel,
      "Column moments of an image, as sp_column_moments gives them, to the last bit.\n\n"
      "image: uint8, (rows, columns), or (images, rows, columns), not of 3 or 4 columns, which are taken for\n"
      "colours. Rows 1..2047, of pixels of more than 10 bits 1..1023. It is not copied.\n"
      "threshold: T, 0..255. gap: dark rows between two lit pixels of one run, 0..3. first_row, last_row: rows that\n"
      "count, from 1; 0 stands for the first and the last. ValueError if something is out of range.");
  auto decoder =
      nb::class_<Decoder>(module, "GrayDecoder", "The Gray-code decoder of the board, for one thread at a time.");
  refuse_pickling(decoder, "is in the midst of a cycle of images; pickle its code images");
  decoder
      .def(nb::init<int, int, int, int>(), nb::arg("rows"), nb::arg("columns"), nb::arg("bits"),
           nb::arg("threshold") = 5, "Images of rows x columns, 1..12 bits (pairs in a cycle), threshold 0..255.")
      .def("take", &Decoder::take, nb::arg("image").noconvert(), nb::arg("pattern"), nb::arg("good") = true,
           "Takes a frame, uint8, with its pattern index: 2p is the positive of bit p, 2p + 1 its negative. Returns\n"
           "a new code image (uint16, code in bits 11..0, bit 15 measurable) if one is due, else None.")
      .def("restart", &Decoder::restart, "Waits for pattern 0.")
      .def("__repr__", [](const Decoder& self) { return decoder_text(self.settings()); });
  module.def("median3x3", &median, nb::arg("codes").noconvert(),
             "3 x 3 median of a code image, uint16 (rows, columns), as sp_median3x3 gives it.");
  module.def("match", &match, nb::arg("codes").noconvert(), nb::arg("table").noconvert(),
             "The projector line of each code word in 1/64 line, 0xFFFF where there is none. codes: uint16 of any\n"
             "shape; table: uint16, the same shape and 2^bits behind, 1..8 bits.");
}

}  // namespace selfproj::python
