#include "sim/board/gige_camera.h"

#include <arv.h>

#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "selfproj/files/user_error.h"

namespace selfproj::sim {

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

GigeCamera::GigeCamera(std::function<void(const Picture&)> draw, double lost, double tick_ms,
                       const std::string& interface)
    : parts_(std::make_unique<Parts>()) {
  parts_->draw = std::move(draw);
  parts_->camera = arv_gv_fake_camera_new(interface.c_str(), "selfproj");
  if (parts_->camera == nullptr || arv_gv_fake_camera_is_running(parts_->camera) == FALSE) {
    throw UserError(interface, "a GigE camera cannot answer there: is there no such network, or another camera in it?");
  }
  g_object_set(parts_->camera, "gvsp-lost-ratio", lost, nullptr);
  ArvFakeCamera* const fake = arv_gv_fake_camera_get_fake_camera(parts_->camera);
  arv_fake_camera_write_register(fake, ARV_FAKE_CAMERA_REGISTER_ACQUISITION_FRAME_PERIOD_US,
                                 static_cast<guint32>(std::lround(1000 * tick_ms)));
  arv_fake_camera_set_fill_pattern(fake, Parts::fill, parts_.get());
}

GigeCamera::~GigeCamera() { g_object_unref(parts_->camera); }

std::uint64_t GigeCamera::drawn() const { return parts_->drawn; }

}  // namespace selfproj::sim
