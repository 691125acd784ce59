// Tests that a preview copies the images that somebody watches, and no others.
#include "host/capture/newest_image.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <future>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "host/camera/camera.h"
#include "host/images/image_files.h"

namespace selfproj::test {
namespace {

// Offers images of one grey after another until what waits for one has it.
template <class Answer>
auto answer_of(capture::NewestImage& newest, std::future<Answer>& waiting) {
  std::vector<std::uint8_t> pixels(12);
  camera::CameraImage image{.view = {pixels.data(), 3, 4, 4}};
  while (waiting.wait_for(std::chrono::milliseconds(0)) != std::future_status::ready) {
    newest.put(image, {.incomplete = 7}, "camera:a");
  }
  return waiting.get();
}

TEST(NewestImage, IsCopiedOnlyWhereSomebodyWatches) {
  capture::NewestImage newest;
  std::vector<std::uint8_t> pixels(12, 255);
  camera::CameraImage image{.view = {pixels.data(), 3, 4, 4}};
  for (int i = 0; i < 1000; ++i) {
    newest.put(image, {}, "camera:a");
  }
  EXPECT_EQ(newest.copies(), 0U);
  auto waiting = std::async(std::launch::async, [&] { return newest.figures(); });
  const auto figures = nlohmann::json::parse(*answer_of(newest, waiting));
  EXPECT_EQ(newest.copies(), 1U) << "of all that came until the answer";
  EXPECT_EQ(figures["pixels"], "4 x 3");
  EXPECT_EQ(figures["saturated (255)"], "0.0 %") << "the image is one that came after the question";
  EXPECT_EQ(figures["incomplete images"], "7");
  auto picture = std::async(std::launch::async, [&] { return newest.png(); });
  EXPECT_FALSE(answer_of(newest, picture)->empty());
  EXPECT_EQ(newest.copies(), 2U);
}

// A camera that has stopped: the page shows what came last.
TEST(NewestImage, ShowsTheImageBeforeWhereNoneComes) {
  capture::NewestImage newest;
  EXPECT_EQ(nlohmann::json::parse(*newest.figures())["pixels"], "1 x 1");
}

}  // namespace
}  // namespace selfproj::test
