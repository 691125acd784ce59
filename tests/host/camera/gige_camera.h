// A network of its own for tests with a simulated GigE camera.
#ifndef SELFPROJ_TESTS_HOST_CAMERA_GIGE_CAMERA_H
#define SELFPROJ_TESTS_HOST_CAMERA_GIGE_CAMERA_H

#include <gtest/gtest.h>

#include "sim/board/gige_camera.h"

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

using sim::GigeCamera;  // answers at 127.0.0.1
using sim::Picture;

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_HOST_CAMERA_GIGE_CAMERA_H
