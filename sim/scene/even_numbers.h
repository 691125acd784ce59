// Evenly distributed random numbers that are the same with every standard library.
#ifndef SELFPROJ_SIM_SCENE_EVEN_NUMBERS_H
#define SELFPROJ_SIM_SCENE_EVEN_NUMBERS_H

#include <cstdint>
#include <random>

namespace selfproj {

class EvenNumbers {
 public:
  explicit EvenNumbers(std::uint64_t seed) : random_(seed) {}

  // A number in 0..1, 1 excluded.
  double next() {
    constexpr double kScale = 0x1p-53;
    return kScale * static_cast<double>(random_() >> 11U);
  }

  // A number in -bound..bound.
  double within(double bound) { return bound * (2 * next() - 1); }

 private:
  std::mt19937_64 random_;
};

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_EVEN_NUMBERS_H
