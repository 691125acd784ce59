// A GigE camera for tests: Aravis' fake camera on a loopback network, whose pictures a function draws.
#ifndef SELFPROJ_TESTS_HOST_CAMERA_GIGE_CAMERA_H
#define SELFPROJ_TESTS_HOST_CAMERA_GIGE_CAMERA_H

#include <gtest/gtest.h>

#include <cstdint>
#include <functional>
#include <memory>

namespace selfproj::test {

// Gives this process and its children a network of their own, with nothing but a loopback, so that the camera meets
// neither others of its kind nor a real one. Call before the process has threads. Returns false if the system does not
// allow it.
bool enter_own_network();

// A test on a network of its own.
class OnOwnNetwork : public testing::Test {
 protected:
  void SetUp() override {
    if (!enter_own_network()) {
      GTEST_SKIP() << "this system allows no network of one's own";
    }
  }
};

// A picture to draw: rows · columns bytes.
struct Picture {
  std::uint8_t* pixels = nullptr;
  int rows = 0;
  int columns = 0;
  std::uint32_t exposure_us = 0;
  std::uint64_t number = 0;  // pictures drawn before
};

// Answers at 127.0.0.1 while it lives.
class GigeCamera {
 public:
  // `draw` is called in another thread whenever the camera takes an image. `lost` is the share of its packets that the
  // network loses. `tick_ms`: unless a rate is set, it takes an image each time, or looks for a trigger.
  explicit GigeCamera(std::function<void(const Picture&)> draw, double lost = 0, int tick_ms = 40);
  GigeCamera(const GigeCamera&) = delete;
  GigeCamera& operator=(const GigeCamera&) = delete;
  ~GigeCamera();

  // Pictures drawn so far.
  [[nodiscard]] std::uint64_t drawn() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_HOST_CAMERA_GIGE_CAMERA_H
