// What the model says of an image, and the host's fast kernel with it.
#ifndef SELFPROJ_TESTS_HLS_MODEL_AND_KERNEL_H
#define SELFPROJ_TESTS_HLS_MODEL_AND_KERNEL_H

#include <gtest/gtest.h>

#include "selfproj/light_section/fast_moments.h"
#include "selfproj/model/column_runs.h"

namespace selfproj::test {

// Measures the image by the model. The fast kernel must say the same.
template <typename Pixel>
void measure_by_both(const model::PixelView<Pixel>& image, const model::Measure& measure, model::Runs& right) {
  model::Runs found;
  right.resize(measure.select, image.columns);
  found.resize(measure.select, image.columns);
  model::measure_columns(image, measure, right.view());
  light_section::fast_measure_columns(image, measure, found.view());
  ASSERT_TRUE(found == right) << "the fast kernel differs";
}

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_HLS_MODEL_AND_KERNEL_H
