// Tests that a capture notices every torn picture of a sequence that would be taken for one of another pattern: all
// pairs of the Gray codes of a scan, each torn in every way of the live world. The images have 64 x 64 pixels or more.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <memory>
#include <regex>
#include <span>
#include <string>
#include <vector>

#include "host/capture/light_check.h"
#include "selfproj/structured_light/gray_sequence.h"
#include "sim/scene/pattern_renderer.h"
#include "sim/scene/perturbed_rig.h"
#include "sim/scene/projected_light.h"
#include "sim/scene/scene.h"
#include "sim/scene/scenes.h"
#include "tests/host/capture/small_scanner.h"

namespace selfproj::test {
namespace {

struct World {
  const char* scene;
  int fewer_pixels;  // of the camera along each side, by this factor
  int fewer_of_projector;
};

class TornPictures : public testing::TestWithParam<World> {
 protected:
  TornPictures() {
    for (int i = 0; i <= gray_.white() + 1; ++i) {
      pictures_.push_back(gray_.image(i));
    }
    levels_ = {.white = seen(pictures_[static_cast<std::size_t>(gray_.white())]),
               .black = seen(pictures_[static_cast<std::size_t>(gray_.white()) + 1])};
  }

  // With the noise of a frame of its own.
  images::Image seen(const Picture8& picture) {
    const images::Image pattern{gray_.rows(), gray_.columns(), picture};
    images::Image image{rig_.camera.rows, rig_.camera.columns, Picture8(rig_.camera.pixels())};
    renderer_.render(frame_++, sim::project_image(rig_, pattern, renderer_.options()), std::span(image.pixels));
    return image;
  }

  rig::Rig rig_ = small_scanner(GetParam().fewer_pixels, GetParam().fewer_of_projector);
  structured_light::GraySequence gray_{rig_.projector.columns, rig_.projector.lines};
  sim::PerturbedRig actual_{rig_};
  std::unique_ptr<sim::Scene> scene_ = sim::make_scene(GetParam().scene, rig_);
  sim::PatternRenderer renderer_{actual_, *scene_, sim::RenderOptions{}, 1};
  int frame_ = 0;
  std::vector<Picture8> pictures_;
  capture::WhiteAndBlack levels_;
};

std::vector<Picture8> torn(const Picture8& old, const Picture8& now) {
  std::vector<Picture8> all = {torn_across(old, now)};
  for (int percent = 0; percent < 100; percent += 5) {
    all.push_back(torn_below(old, now, percent));
  }
  return all;
}

TEST_P(TornPictures, AreNoticedInEveryPair) {
  int others = 0;
  int missed = 0;
  for (std::size_t i = 0; i + 1 < static_cast<std::size_t>(gray_.white()); i += 2) {
    const images::Image pattern = seen(pictures_[i]);
    const images::Image negative = seen(pictures_[i + 1]);
    EXPECT_TRUE(capture::adds_up(pattern, negative, levels_)) << i;
    const auto check = [&](const images::Image& image, const images::Image& own, bool noticed) {
      if (mean_difference(image, own) >= kOtherPattern) {
        ++others;
        missed += noticed ? 0 : 1;
      }
    };
    // Before the first pattern white is shown, or black.
    for (const Picture8& old : {pictures_[i > 0 ? i - 1 : pictures_.size() - 2], pictures_.back()}) {
      for (const Picture8& picture : torn(old, pictures_[i])) {
        const images::Image image = seen(picture);
        check(image, pattern, !capture::adds_up(image, negative, levels_));
      }
    }
    for (const Picture8& picture : torn(pictures_[i], pictures_[i + 1])) {
      const images::Image image = seen(picture);
      check(image, negative, !capture::adds_up(pattern, image, levels_));
    }
  }
  EXPECT_GT(others, 500);
  EXPECT_EQ(missed, 0) << "of " << others;
}

INSTANTIATE_TEST_SUITE_P(Scenes, TornPictures,
                         testing::Values(World{"desk", 8, 8}, World{"cuboids", 8, 8}, World{"waves", 8, 8},
                                         World{"cuboids-marked", 8, 4}, World{"keyboard", 4, 8}),
                         [](const auto& world) {
                           return std::regex_replace(std::string(world.param.scene), std::regex("-"), "");
                         });

}  // namespace
}  // namespace selfproj::test
