// Tests that a preview copies the images that somebody watches, and no others.
#include "host/capture/newest_image.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "host/camera/camera.h"
#include "host/images/image_files.h"

namespace selfproj::test {
namespace {

// Asks, and offers images of one grey after another until there is an answer.
template <class Ask>
std::string answer_of(capture::NewestImage& newest, const Ask& ask) {
  std::vector<std::uint8_t> pixels(12);
  camera::CameraImage image{.view = {pixels.data(), 3, 4, 4}};
  std::uint64_t asked = 0;
  for (;;) {
    const std::shared_ptr<const std::string> answer = ask(asked);
    if (answer != nullptr) {
      return *answer;
    }
    newest.put(image, {.incomplete = 7}, "camera:a");
  }
}

TEST(NewestImage, IsCopiedOnlyWhereSomebodyWatches) {
  capture::NewestImage newest;
  std::vector<std::uint8_t> pixels(12, 255);
  camera::CameraImage image{.view = {pixels.data(), 3, 4, 4}};
  for (int i = 0; i < 1000; ++i) {
    newest.put(image, {}, "camera:a");
  }
  EXPECT_EQ(newest.copies(), 0U);
  const auto figures =
      nlohmann::json::parse(answer_of(newest, [&](std::uint64_t& asked) { return newest.figures(asked); }));
  EXPECT_EQ(newest.copies(), 1U) << "of all that came until the answer";
  EXPECT_EQ(figures["pixels"], "4 x 3");
  EXPECT_EQ(figures["saturated (255)"], "0.0 %") << "the image is one that came after the question";
  EXPECT_EQ(figures["incomplete images"], "7");
  EXPECT_FALSE(answer_of(newest, [&](std::uint64_t& asked) { return newest.png(asked); }).empty());
  EXPECT_EQ(newest.copies(), 2U);
}

// A camera that has stopped: the page shows what came last.
TEST(NewestImage, ShowsTheImageBeforeWhereNoneComes) {
  capture::NewestImage newest;
  std::uint64_t asked = 0;
  EXPECT_EQ(newest.figures(asked), nullptr);
  std::this_thread::sleep_for(std::chrono::milliseconds(550));
  ASSERT_NE(newest.figures(asked), nullptr);
  EXPECT_EQ(nlohmann::json::parse(*newest.figures(asked))["pixels"], "1 x 1");
}

}  // namespace
}  // namespace selfproj::test
