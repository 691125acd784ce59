// The arguments that every implementation of the column moments refuses.
#ifndef SELFPROJ_TESTS_SUPPORT_MOMENTS_REFUSALS_H
#define SELFPROJ_TESTS_SUPPORT_MOMENTS_REFUSALS_H

#include <gtest/gtest.h>

#include <cstdint>
#include <stdexcept>
#include <vector>

#include "selfproj/model/column_moments.h"

namespace selfproj::test {

// Expects that `compute`, called like column_moments, throws for each argument that is out of range without writing
// anything, and accepts good ones.
template <class Compute>
void expect_refusals_of_moments(Compute compute) {
  const std::vector<std::uint8_t> pixels(64, 255);
  model::Moments moments;
  moments.resize(8);
  const model::Moments before = moments;
  const model::ImageView good = {pixels.data(), 4, 8, 8};
  const auto refuses = [&](const model::ImageView& image, int mode, int threshold, const model::MomentsView& out) {
    EXPECT_THROW(compute(image, static_cast<model::Mode>(mode), threshold, out), std::invalid_argument);
    EXPECT_EQ(moments, before);
  };
  refuses({pixels.data(), 0, 8, 8}, 0, 128, moments.view());
  refuses({pixels.data(), -1, 8, 8}, 0, 128, moments.view());
  refuses({pixels.data(), spec::kRowLimit + 1, 8, 0}, 0, 128, moments.view());
  refuses({pixels.data(), 4, 0, 8}, 0, 128, moments.view());
  refuses({pixels.data(), 4, -8, 8}, 0, 128, moments.view());
  refuses({nullptr, 4, 8, 8}, 0, 128, moments.view());
  refuses(good, 3, 128, moments.view());
  refuses(good, 0, -1, moments.view());
  refuses(good, 0, 256, moments.view());
  refuses(good, 0, 128, {nullptr, moments.m1.data(), moments.n.data()});
  refuses(good, 0, 128, {moments.m0.data(), nullptr, moments.n.data()});
  refuses(good, 0, 128, {moments.m0.data(), moments.m1.data(), nullptr});
  EXPECT_NO_THROW(compute(good, model::Mode::binary, 128, moments.view()));
}

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_SUPPORT_MOMENTS_REFUSALS_H
