// A GigE Vision camera in the network of this machine: Aravis' fake camera, whose pictures a function draws.
#ifndef SELFPROJ_SIM_BOARD_GIGE_CAMERA_H
#define SELFPROJ_SIM_BOARD_GIGE_CAMERA_H

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

namespace selfproj::sim {

// A picture to draw: rows · columns bytes.
struct Picture {
  std::uint8_t* pixels = nullptr;
  int rows = 0;
  int columns = 0;
  std::uint32_t exposure_us = 0;
  std::uint64_t number = 0;  // pictures drawn before
};

// Answers at the address of a network while it lives.
class GigeCamera {
 public:
  // `draw` is called in another thread whenever the camera takes an image. `lost` is the share of its packets that the
  // network loses. `tick_ms`: unless a rate is set, it takes an image each time, or looks for a trigger.
  // Throws UserError if it cannot answer there.
  explicit GigeCamera(std::function<void(const Picture&)> draw, double lost = 0, double tick_ms = 40,
                      const std::string& interface = "lo");
  GigeCamera(const GigeCamera&) = delete;
  GigeCamera& operator=(const GigeCamera&) = delete;
  ~GigeCamera();

  // Pictures drawn so far.
  [[nodiscard]] std::uint64_t drawn() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_BOARD_GIGE_CAMERA_H
