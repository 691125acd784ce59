// The wave that a body makes when it falls into shallow water, by the linear theory of waves under gravity and surface
// tension (Airy; Lamb, Hydrodynamics, § 228, § 267).
#ifndef SELFPROJ_SIM_SCENE_RING_WAVE_H
#define SELFPROJ_SIM_SCENE_RING_WAVE_H

#include <cstddef>
#include <vector>

namespace selfproj::sim {

// A wave of wavenumber k turns at omega^2 = (g k + tension/density k^3) tanh(k depth): long waves run at sqrt(g depth),
// shorter ones more slowly, and ripples of less than 17 mm faster again. At t = 0 the water rests, with a crater whose
// rim holds the water that the crater lacks:
//
//     eta(r, 0) = -crater (1 - r^2/(2 s^2)) exp(-r^2/(2 s^2))
//     eta(r, t) = -crater s^4/2 . integral over k of k^3 exp(-k^2 s^2/2) J0(k r) cos(omega t)
//
// The integral is computed once for a table of radii and times, and interpolated linearly.
class RingWave {
 public:
  // Millimetres and seconds. Throws std::invalid_argument unless all are > 0.
  RingWave(double depth_mm, double crater_mm, double s_mm, double longest_s);

  // omega in rad/s of a wave with k >= 0 in rad/mm.
  static double omega(double k, double depth_mm);

  [[nodiscard]] double speed() const { return speed_; }  // of long waves, mm/s: the fastest of those in this wave
  // No |eta| is ever greater.
  [[nodiscard]] double most() const { return most_; }

  // The wave at one time as a function of the radius.
  class Profile {
   public:
    struct Value {
      double rise;   // mm
      double slope;  // d rise / d r
    };
    // 0 beyond its reach.
    [[nodiscard]] Value at(double r) const {
      const double place = r / kStep;
      const auto i = static_cast<std::size_t>(place);
      if (!(place >= 0) || i + 1 >= values_.size()) {
        return {0, 0};
      }
      const double f = place - static_cast<double>(i);
      return {values_[i].rise + f * (values_[i + 1].rise - values_[i].rise),
              values_[i].slope + f * (values_[i + 1].slope - values_[i].slope)};
    }
    // The radius beyond which there is no wave, mm.
    [[nodiscard]] double reach() const { return values_.empty() ? 0 : kStep * static_cast<double>(values_.size() - 1); }

   private:
    friend class RingWave;
    std::vector<Value> values_;
  };
  // For t < 0 the water is level. Times beyond the longest give that one.
  [[nodiscard]] Profile profile(double t) const;

 private:
  static constexpr double kStep = 1;         // mm of radius
  static constexpr double kTimeStep = 5e-4;  // s

  double speed_;
  double s_;
  double most_ = 0;
  std::size_t radii_ = 0;
  std::vector<float> rise_;  // times x radii
};

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_SCENE_RING_WAVE_H
