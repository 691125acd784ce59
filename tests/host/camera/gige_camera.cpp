#include "tests/host/camera/gige_camera.h"

#include <arv.h>
#include <net/if.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

namespace selfproj::test {

bool enter_own_network() {
  const std::string user = std::to_string(geteuid());
  const std::string group = std::to_string(getegid());
  if (unshare(CLONE_NEWNET) != 0) {
    if (unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0) {
      return false;
    }
    std::ofstream("/proc/self/setgroups") << "deny";
    std::ofstream("/proc/self/uid_map") << user << " " << user << " 1";
    std::ofstream("/proc/self/gid_map") << group << " " << group << " 1";
  }
  const int socket_number = socket(AF_INET, SOCK_DGRAM, 0);
  ifreq request{};
  std::strncpy(request.ifr_name, "lo", IFNAMSIZ - 1);
  request.ifr_flags = IFF_UP | IFF_RUNNING;
  const bool up = socket_number >= 0 && ioctl(socket_number, SIOCSIFFLAGS, &request) == 0;
  close(socket_number);
  return up;
}

struct GigeCamera::Parts {
  std::function<void(const Picture&)> draw;
  std::atomic<std::uint64_t> drawn = 0;
  ArvGvFakeCamera* camera = nullptr;

  static void fill(ArvBuffer* buffer, void* parts, guint32 exposure_us, guint32 /*gain*/, ArvPixelFormat /*format*/) {
    Parts& self = *static_cast<Parts*>(parts);
    std::size_t size = 0;
    auto* const pixels = static_cast<std::uint8_t*>(const_cast<void*>(arv_buffer_get_data(buffer, &size)));
    int x = 0;
    int y = 0;
    Picture picture{.pixels = pixels, .exposure_us = exposure_us, .number = self.drawn};
    arv_buffer_get_image_region(buffer, &x, &y, &picture.columns, &picture.rows);
    self.draw(picture);
    ++self.drawn;
  }
};

GigeCamera::GigeCamera(std::function<void(const Picture&)> draw, double lost, int tick_ms)
    : parts_(std::make_unique<Parts>()) {
  parts_->draw = std::move(draw);
  parts_->camera = arv_gv_fake_camera_new("lo", "selfproj");
  if (parts_->camera == nullptr || arv_gv_fake_camera_is_running(parts_->camera) == FALSE) {
    throw std::runtime_error("the fake GigE camera does not run");
  }
  g_object_set(parts_->camera, "gvsp-lost-ratio", lost, nullptr);
  ArvFakeCamera* const fake = arv_gv_fake_camera_get_fake_camera(parts_->camera);
  arv_fake_camera_write_register(fake, ARV_FAKE_CAMERA_REGISTER_ACQUISITION_FRAME_PERIOD_US,
                                 static_cast<guint32>(1000 * tick_ms));
  arv_fake_camera_set_fill_pattern(fake, Parts::fill, parts_.get());
}

GigeCamera::~GigeCamera() { g_object_unref(parts_->camera); }

std::uint64_t GigeCamera::drawn() const { return parts_->drawn; }

}  // namespace selfproj::test
