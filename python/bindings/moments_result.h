// Moments on their way between arrays and the model.
#ifndef SELFPROJ_PYTHON_BINDINGS_MOMENTS_RESULT_H
#define SELFPROJ_PYTHON_BINDINGS_MOMENTS_RESULT_H

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "python/bindings/arrays.h"
#include "selfproj/model/column_runs.h"

namespace selfproj::python {

// The moments of one or several images, and, for the strongest run, the runs. They lie in one piece of memory; arrays
// of it are made when Python asks for them, and keep the object alive.
class MomentsResult {
 public:
  // Without `images` it is of one image, and the arrays have one dimension.
  MomentsResult(model::Select select, std::optional<std::size_t> images, std::size_t columns)
      : shape_{images.value_or(1), columns},
        dimensions_(images ? 2 : 1),
        count_(shape_[0] * columns),
        has_runs_(select == model::Select::strongest),
        words_(new std::uint32_t[kWords * count_ + (has_runs_ ? (2 * count_ + 3) / 4 : 0)]) {}

  // The entries from `first` on.
  [[nodiscard]] model::RunsView view(std::size_t first) const {
    std::uint8_t* const runs = has_runs_ ? bytes() + first : nullptr;
    return {{words(0) + first, words(1) + first, words(2) + first}, runs, runs != nullptr ? runs + count_ : nullptr};
  }

  [[nodiscard]] bool has_runs() const { return has_runs_; }
  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] std::vector<std::size_t> sides() const { return {shape(), shape() + dimensions_}; }

  // M0, M1 and N are words 0, 1 and 2. `self` is this object in Python.
  [[nodiscard]] Out<std::uint32_t> words_array(std::size_t which, nb::handle self) const {
    return {words(which), dimensions_, shape(), self};
  }
  // The runs are bytes 0, the second runs bytes 1; nothing unless the strongest run was measured.
  [[nodiscard]] std::optional<Out<std::uint8_t>> bytes_array(std::size_t which, nb::handle self) const {
    if (!has_runs_) {
      return std::nullopt;
    }
    return Out<std::uint8_t>(bytes() + which * count_, dimensions_, shape(), self);
  }

 private:
  static constexpr std::size_t kWords = 3;

  [[nodiscard]] std::uint32_t* words(std::size_t which) const { return words_.get() + which * count_; }
  [[nodiscard]] std::uint8_t* bytes() const { return reinterpret_cast<std::uint8_t*>(words(kWords)); }
  [[nodiscard]] const std::size_t* shape() const { return shape_.data() + (dimensions_ == 1 ? 1 : 0); }

  std::array<std::size_t, 2> shape_;
  std::size_t dimensions_;
  std::size_t count_;
  bool has_runs_;
  std::unique_ptr<std::uint32_t[]> words_;
};

// The moments of images by `kernel`, which has the arguments of measure_columns.
template <typename Pixel, typename Kernel>
MomentsResult measure_images(const In<Pixel>& array, const model::Measure& measure, const Kernel& kernel) {
  const ImagesOf<Pixel> images(array);
  MomentsResult result(measure.select, images.several() ? std::optional(images.count()) : std::nullopt,
                       images.columns());
  without_gil([&] {
    for (std::size_t i = 0; i < images.count(); ++i) {
      kernel(images.view(i), measure, result.view(i * images.columns()));
    }
  });
  return result;
}

// Defines `moments` in the module: images measured by `kernel`, of 8 bits, and of more in words of 16.
template <typename Kernel>
void def_moments(nb::module_& module, const Kernel& kernel, const char* documentation) {
  module.def(
      "moments",
      [kernel](const In<std::uint8_t>& image, int threshold, model::Mode mode, model::Select select, int gap,
               int first_row, int last_row) {
        return measure_images(image,
                              {.mode = mode,
                               .threshold = threshold,
                               .select = select,
                               .gap = gap,
                               .window = {.first = first_row, .last = last_row}},
                              kernel);
      },
      nb::arg("image").noconvert(), nb::arg("threshold"), nb::arg("mode") = model::Mode::grey_over,
      nb::arg("select") = model::Select::all, nb::arg("gap") = 0, nb::arg("first_row") = 0, nb::arg("last_row") = 0,
      documentation);
  module.def(
      "moments",
      [kernel](const In<std::uint16_t>& image, int threshold, int bits, model::Mode mode, model::Select select, int gap,
               int first_row, int last_row) {
        return measure_images(image,
                              {.mode = mode,
                               .threshold = threshold,
                               .select = select,
                               .gap = gap,
                               .window = {.first = first_row, .last = last_row},
                               .bits = bits},
                              kernel);
      },
      nb::arg("image").noconvert(), nb::arg("threshold"), nb::kw_only(), nb::arg("bits"),
      nb::arg("mode") = model::Mode::grey_over, nb::arg("select") = model::Select::all, nb::arg("gap") = 0,
      nb::arg("first_row") = 0, nb::arg("last_row") = 0,
      "The same of pixels of 8 to 12 bits in uint16, from bit 0 on, and a threshold of as many.\n"
      "Pixels of 2^bits and more are not looked for; they give wrong sums.");
}

}  // namespace selfproj::python

#endif  // SELFPROJ_PYTHON_BINDINGS_MOMENTS_RESULT_H
