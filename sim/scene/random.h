// Random numbers that are the same with every standard library and on every machine.
#ifndef SELFPROJ_SIM_SCENE_RANDOM_H
#define SELFPROJ_SIM_SCENE_RANDOM_H

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <utility>

namespace selfproj::sim {

// Evenly distributed random numbers that are the same with every standard library.
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

// Normally distributed random numbers that depend on neither the machine, the threads nor the order of frames.

// The numbers of one seed and stream (a frame's number). Bits come from SplitMix64 (Steele, Lea, Flood 2014), which is
// a mixed counter. Box and Muller make two normal numbers at a time, with tails that are right up to 8 standard
// deviations.
class NormalNoise {
 public:
  NormalNoise(std::uint64_t seed, std::uint64_t stream) : state_(mix(mix(seed + kStep) + stream * kStep)) {}

  // Two independent numbers of mean 0 and variance 1.
  std::pair<float, float> two() {
    const double radius = std::sqrt(-2 * std::log(uniform()));
    const double angle = 2 * std::numbers::pi * uniform();
    return {static_cast<float>(radius * std::cos(angle)), static_cast<float>(radius * std::sin(angle))};
  }

 private:
  static constexpr std::uint64_t kStep = 0x9e3779b97f4a7c15U;

  static std::uint64_t mix(std::uint64_t z) {
    z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9U;
    z = (z ^ (z >> 27U)) * 0x94d049bb133111ebU;
    return z ^ (z >> 31U);
  }

  // A number in 2^-53 .. 1.
  double uniform() {
    state_ += kStep;
    return (static_cast<double>(mix(state_) >> 11U) + 1) * 0x1p-53;
  }

  std::uint64_t state_;
};

}  // namespace selfproj::sim

#endif  // SELFPROJ_SIM_SCENE_RANDOM_H
