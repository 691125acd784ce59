// Measures how fast the host decodes Gray codes and computes depth images: 512 x 512 pixels, m = 8, one thread.
//
//     bench_gray [--benchmark_...]
//
// One item is one update: a new pair of images gives a new code image. "In cache" repeats the same pair. "From memory"
// uses 256 pairs (134 MB) one after another; the share of the read ceiling counts only the bytes of the images. A depth
// image takes all steps: decoding a new pair, median, and triangulation on the rig `scanner`. Before the first
// measurement the results are compared with the models, and the depths with (4.7) in double precision; a difference
// ends the program with exit status 1. bench_opencv compares the decoder with OpenCV.
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

#include "selfproj/model/gray_decoder.h"
#include "selfproj/model/median3x3.h"
#include "selfproj/rig/rig.h"
#include "selfproj/structured_light/fast_decoder.h"
#include "selfproj/structured_light/foreground.h"
#include "selfproj/structured_light/scanner.h"
#include "selfproj/structured_light/triangulation.h"
#include "tests/bench/collector.h"
#include "tests/bench/read_ceiling.h"

namespace selfproj::test {
namespace {

constexpr int kSide = 512;
constexpr int kBits = 8;
constexpr std::size_t kImageBytes = static_cast<std::size_t>(kSide) * kSide;
constexpr int kImages = 512;
constexpr model::GraySettings kSettings{kSide, kSide, kBits, 5};

model::ImageView image_at(const std::uint8_t* bytes, int i) {
  return {bytes + static_cast<std::size_t>(i) * kImageBytes, kSide, kSide, kSide};
}

bool results_are_right(const std::uint8_t* images) {
  model::GrayDecoder model(kSettings);
  structured_light::FastGrayDecoder fast(kSettings);
  structured_light::FastMedian median(kSide);
  std::vector<std::uint16_t> expected(kImageBytes), found(kImageBytes), expected_median(kImageBytes);
  for (int i = 0; i < 4 * kBits; ++i) {
    const int pattern = i % (2 * kBits);
    const bool due = model.add_frame(image_at(images, i), pattern, true, expected.data());
    if (fast.add_frame(image_at(images, i), pattern, true) != due) {
      return false;
    }
    if (due) {
      structured_light::code_words(fast.codes(), found.data());
      if (found != expected) {
        return false;
      }
      median.filter(fast.codes(), found.data());
      model::median3x3(expected.data(), kSide, kSide, expected_median.data());
      if (found != expected_median) {
        return false;
      }
    }
  }
  return true;
}

// z of (3.4) = (4.8) for the centre of the code, from the angles. NaN if the rules of section 1 exclude the point.
double plain_depth(const rig::Rig& rig, int row, std::uint16_t word) {
  if ((word & model::GrayDecoder::kMeasurable) == 0) {
    return std::nan("");
  }
  const rig::RigProjector& projector = rig.projector;
  const double tan_alpha = rig.camera.pixel_pitch_mm * (row - 0.5 * (rig.camera.rows - 1)) / rig.camera.focal_length_mm;
  const auto z_of_line = [&](double line) {
    const double xp = projector.center_xp_mm + projector.line_pitch_mm * (line - 0.5 * (projector.lines - 1));
    const double tan_theta = std::tan(projector.tilt_rad + std::atan(xp / projector.focal_length_mm));
    return (projector.x_mm + projector.z_mm * tan_theta) / (tan_alpha + tan_theta);
  };
  const double line = ((word & 0xFFF) + 0.5) * projector.lines / (1 << kBits) - 0.5;
  const double z = z_of_line(line);
  constexpr double kStep = 1e-4;
  const double slope = (z_of_line(line + kStep) - z_of_line(line - kStep)) / (2 * kStep);
  const bool valid = projector.z_mm * tan_alpha < projector.x_mm && slope < 0 && z > projector.z_mm &&
                     -slope < rig.measure.max_z_per_line_mm;
  return valid ? z : std::nan("");
}

bool depths_are_right(const std::uint8_t* images) {
  const rig::Rig rig = rig::load_rig("scanner");
  const structured_light::PlaneTriangulation triangulation(rig, kBits);
  structured_light::Scanner scanner(triangulation, {});
  std::size_t valid = 0;
  std::size_t on_limit = 0;
  for (int i = 0; i < 2 * kBits + 2; ++i) {
    if (!scanner.add_frame(image_at(images, i), i % (2 * kBits))) {
      continue;
    }
    for (std::size_t k = 0; k < kImageBytes; ++k) {
      const double expected = plain_depth(rig, static_cast<int>(k) / kSide, scanner.codes()[k]);
      const auto found = static_cast<double>(scanner.depth().values[k]);
      if (std::isnan(expected) != std::isnan(found)) {
        ++on_limit;  // rounding
      } else if (!std::isnan(found)) {
        ++valid;
        if (std::abs(found - expected) > 2e-3) {
          return false;
        }
      }
    }
  }
  return valid > kImageBytes / 10 && on_limit < kImageBytes / 1000;
}

// `pairs` pairs, one after another; a whole number of cycles.
void decode(benchmark::State& state, const std::uint8_t* images, int pairs) {
  structured_light::FastGrayDecoder decoder(kSettings);
  int image = 0;
  int pattern = 0;
  for (auto _ : state) {
    for (int half = 0; half < 2; ++half) {
      benchmark::DoNotOptimize(decoder.add_frame(image_at(images, image), pattern, true));
      image = (image + 1) % (2 * pairs);
      pattern = (pattern + 1) % (2 * kBits);
    }
    benchmark::ClobberMemory();
  }
  bench::set_counters(state, 1, 2 * kImageBytes);
}

structured_light::FastGrayDecoder filled_decoder(const std::uint8_t* images) {
  structured_light::FastGrayDecoder decoder(kSettings);
  for (int i = 0; i < 2 * kBits; ++i) {
    decoder.add_frame(image_at(images, i), i, true);
  }
  return decoder;
}

void to_words(benchmark::State& state, const std::uint8_t* images) {
  const structured_light::FastGrayDecoder decoder = filled_decoder(images);
  std::vector<std::uint16_t> words(kImageBytes);
  for (auto _ : state) {
    structured_light::code_words(decoder.codes(), words.data());
    benchmark::ClobberMemory();
  }
  bench::set_counters(state, 1, 2 * kImageBytes);
}

void filter(benchmark::State& state, const std::uint8_t* images) {
  const structured_light::FastGrayDecoder decoder = filled_decoder(images);
  structured_light::FastMedian median(kSide);
  std::vector<std::uint16_t> words(kImageBytes);
  for (auto _ : state) {
    median.filter(decoder.codes(), words.data());
    benchmark::ClobberMemory();
  }
  bench::set_counters(state, 1, 2 * kImageBytes);
}

void triangulate(benchmark::State& state, const std::uint8_t* images) {
  const structured_light::FastGrayDecoder decoder = filled_decoder(images);
  std::vector<std::uint16_t> words(kImageBytes);
  structured_light::FastMedian(kSide).filter(decoder.codes(), words.data());
  const structured_light::PlaneTriangulation triangulation(rig::load_rig("scanner"), kBits);
  std::vector<float> z(kImageBytes);
  for (auto _ : state) {
    triangulation.depth(words.data(), z.data());
    benchmark::ClobberMemory();
  }
  bench::set_counters(state, 1, 2 * kImageBytes);
}

void find_moved(benchmark::State& state, const std::uint8_t* images) {
  const structured_light::FastGrayDecoder decoder = filled_decoder(images);
  std::vector<std::uint16_t> words(kImageBytes);
  const structured_light::PlaneTriangulation triangulation(rig::load_rig("scanner"), kBits);
  std::vector<float> z(kImageBytes), background(kImageBytes, 500);
  structured_light::code_words(decoder.codes(), words.data());
  triangulation.depth(words.data(), z.data());
  for (auto _ : state) {
    benchmark::DoNotOptimize(structured_light::foreground_of(triangulation, z.data(), background.data(), 5));
  }
  bench::set_counters(state, 1, 2 * kImageBytes);
}

// All steps, `pairs` pairs one after another.
void depth(benchmark::State& state, const std::uint8_t* images, int pairs) {
  const structured_light::PlaneTriangulation triangulation(rig::load_rig("scanner"), kBits);
  structured_light::Scanner scanner(triangulation, {});
  int image = 0;
  int pattern = 0;
  for (auto _ : state) {
    for (int half = 0; half < 2; ++half) {
      benchmark::DoNotOptimize(scanner.add_frame(image_at(images, image), pattern));
      image = (image + 1) % (2 * pairs);
      pattern = (pattern + 1) % (2 * kBits);
    }
    benchmark::ClobberMemory();
  }
  bench::set_counters(state, 1, 2 * kImageBytes);
}

nlohmann::ordered_json print_ratios(const bench::Collector& collector) {
  nlohmann::ordered_json results;
  const double ceiling = bench::read_ceiling(collector);
  results["read_ceiling_gb_per_s"] = ceiling * 1e-9;
  const double bytes = 2.0 * kImageBytes;
  const double cache = collector.median("decode/cache");
  const double memory = collector.median("decode/memory");
  const double filtered = collector.median("median/cache");
  if (ceiling > 0 && cache > 0 && memory > 0) {
    std::printf("decode, 512 x 512, m = 8: %.0f updates/s in cache; %.0f from memory, %.1f %% of the read ceiling\n",
                cache / bytes, memory / bytes, 100 * memory / ceiling);
    std::printf("median: %.0f images/s\n", filtered / bytes);
    results["decode"] = {
        {"cache_per_s", cache / bytes}, {"memory_per_s", memory / bytes}, {"share_of_read_ceiling", memory / ceiling}};
  }
  const double triangulated = collector.median("triangulation/cache");
  const double whole = collector.median("depth/cache");
  const double streamed = collector.median("depth/memory");
  if (ceiling > 0 && cache > 0 && filtered > 0 && triangulated > 0 && whole > 0 && streamed > 0) {
    const double steps = 1 / cache + 1 / filtered + 1 / triangulated;
    const auto step = [&](const char* name, double rate) {
      return nlohmann::ordered_json{{"name", name}, {"per_s", rate / bytes}, {"share", 1 / rate / steps}};
    };
    const double moved = collector.median("moved/cache") / bytes;
    std::printf("triangulation: %.0f images/s\n", triangulated / bytes);
    std::printf("depth image, all steps: %.0f images/s in cache, %.0f from memory, %.1f %% of the read ceiling\n",
                whole / bytes, streamed / bytes, 100 * streamed / ceiling);
    std::printf("  of its time: decoding %.0f %%, median %.0f %%, triangulation %.0f %%\n", 100 / cache / steps,
                100 / filtered / steps, 100 / triangulated / steps);
    std::printf("what moved: %.0f images/s\n", moved);
    results["depth"] = {
        {"cache_per_s", whole / bytes},
        {"memory_per_s", streamed / bytes},
        {"share_of_read_ceiling", streamed / ceiling},
        {"steps", {step("decoding", cache), step("3 × 3 median", filtered), step("triangulation", triangulated)}}};
    results["moved_per_s"] = moved;
  }
  return results;
}

int run() {
  const bench::RandomBuffer images(kImages * kImageBytes);
  const std::uint8_t* data = images.data();
  bench::require(results_are_right(data), "the codes are wrong");
  bench::require(depths_are_right(data), "the depths are wrong");
  bench::add_read_ceiling({images.data(), images.size()});
  using bench::add;
  add("decode/cache", [data](benchmark::State& state) { decode(state, data, 1); });
  add("decode/memory", [data](benchmark::State& state) { decode(state, data, kImages / 2); });
  add("words/cache", [data](benchmark::State& state) { to_words(state, data); });
  add("median/cache", [data](benchmark::State& state) { filter(state, data); });
  add("triangulation/cache", [data](benchmark::State& state) { triangulate(state, data); });
  add("moved/cache", [data](benchmark::State& state) { find_moved(state, data); });
  add("depth/cache", [data](benchmark::State& state) { depth(state, data, 1); });
  add("depth/memory", [data](benchmark::State& state) { depth(state, data, kImages / 2); });
  return bench::run_registered(
      {"bench_gray", "Gray decoding and depth images on the host, 512 x 512, m = 8, one core", "bytes_per_second"},
      print_ratios);
}

}  // namespace
}  // namespace selfproj::test

int main(int argc, char** argv) {
  return selfproj::bench::main_of("bench_gray", {argv + 1, argv + argc}, selfproj::test::run);
}
