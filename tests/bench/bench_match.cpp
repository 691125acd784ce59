// Measures how fast the host computes depth images of self-projected structured light: 512 x 512 pixels, m = 4, one
// thread.
//
//     bench_match [--benchmark_...]
//
// One item is one update: a new pair of images gives a new depth image and its difference from the reference. The
// images show a plane with a bump on it under the patterns of the plane, drawn from the geometry with noise. "In cache"
// repeats the same four pairs. "From memory" uses 256 pairs (134 MB) one after another; the share of the read ceiling
// counts only the bytes of the images. `random` has random images, whose codes spread the accesses to the table as far
// as possible. Before the first measurement the results are compared with the models; a difference ends the program
// with exit status 1.
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "host/structured_light/match_table.h"
#include "host/structured_light/self_reference.h"
#include "host/structured_light/self_scanner.h"
#include "selfproj/model/gray_decoder.h"
#include "selfproj/model/gray_match.h"
#include "selfproj/rig/rig.h"
#include "tests/bench/collector.h"
#include "tests/bench/read_ceiling.h"
#include "tests/host/light_section/seen_surface.h"

namespace selfproj::test {
namespace {

constexpr int kSide = 512;
constexpr int kBits = 4;
constexpr std::size_t kPixels = static_cast<std::size_t>(kSide) * kSide;
constexpr int kImages = 512;

model::ImageView image_at(const std::uint8_t* bytes, int i) {
  return {bytes + static_cast<std::size_t>(i) * kPixels, kSide, kSide, kSide};
}

// Everything that is prepared before the first frame.
struct Setup {
  rig::Rig rig = rig::load_rig("scanner");
  structured_light::SelfReference reference =
      structured_light::make_self_reference(rig, test::points_of(rig, test::plane_at(550)), {});
  structured_light::MatchTable table{rig, reference, {8}};
};

// The eight images of the bump.
std::vector<std::uint8_t> images_of(const Setup& setup) {
  const auto bump = [](double x, double y) { return 550 - 20 * std::exp(-(x * x + y * y) / (2 * 40 * 40)); };
  const structured_light::ProjectorPoints points = test::points_of(setup.rig, bump);
  std::vector<std::uint8_t> images(2 * kBits * kPixels);
  std::minstd_rand random(1);
  for (int k = 0; k < 2 * kBits; ++k) {
    const images::FloatImage pattern = structured_light::self_projected_pattern(setup.reference, k);
    for (std::size_t i = 0; i < kPixels; ++i) {
      const bool seen = !std::isnan(points.line.values[i]);
      const bool light = seen && pattern.row(static_cast<int>(
                                     std::lround(points.line.values[i])))[std::lround(points.column.values[i])] > 0.5F;
      images[static_cast<std::size_t>(k) * kPixels + i] = static_cast<std::uint8_t>((light ? 120 : 10) + random() % 5);
    }
  }
  return images;
}

bool results_are_right(const Setup& setup, const std::uint8_t* images) {
  structured_light::SelfScanner scanner(setup.rig, setup.reference, setup.table, 5);
  model::GrayDecoder decoder({kSide, kSide, kBits, 5});
  const std::vector<std::uint16_t> words = setup.table.by_pixels();
  std::vector<std::uint16_t> codes(kPixels), lines(kPixels);
  std::vector<float> row(kSide), z(kSide);
  std::size_t valid = 0;
  for (int i = 0; i < 2 * kBits; ++i) {
    const bool due = decoder.add_frame(image_at(images, i), i, true, codes.data());
    if (scanner.add_frame(image_at(images, i), i) != due) {
      return false;
    }
  }
  model::GrayMatch::look_up(codes.data(), kPixels, kBits, words.data(), lines.data());
  for (std::size_t i = 0; i < kPixels; ++i) {
    const auto found = static_cast<double>(scanner.depth().values[i]);
    if (lines[i] == model::GrayMatch::kNone) {
      if (!std::isnan(found)) {
        return false;
      }
    } else if (!std::isnan(found)) {
      ++valid;
      const test::Point3 p =
          test::on_ray(setup.rig.camera, static_cast<double>(i / kSide), static_cast<double>(i % kSide), found);
      if (std::abs(test::projector_lights(setup.rig.projector, p).row - model::GrayMatch::line_of(lines[i])) > 2e-3) {
        return false;
      }
    }
  }
  return valid > kPixels / 2;
}

void whole(benchmark::State& state, const Setup& setup, const std::uint8_t* images, int count) {
  structured_light::SelfScanner scanner(setup.rig, setup.reference, setup.table, 5);
  int image = 0;
  int pattern = 0;
  for (auto _ : state) {
    for (int half = 0; half < 2; ++half) {
      benchmark::DoNotOptimize(scanner.add_frame(image_at(images, image), pattern));
      image = (image + 1) % count;
      pattern = (pattern + 1) % (2 * kBits);
    }
    benchmark::ClobberMemory();
  }
  bench::set_counters(state, 1, 2 * kPixels);
}

void decode(benchmark::State& state, const std::uint8_t* images) {
  structured_light::FastGrayDecoder decoder({kSide, kSide, kBits, 5});
  int pattern = 0;
  for (auto _ : state) {
    for (int half = 0; half < 2; ++half) {
      benchmark::DoNotOptimize(decoder.add_frame(image_at(images, pattern), pattern, true));
      pattern = (pattern + 1) % (2 * kBits);
    }
    benchmark::ClobberMemory();
  }
  bench::set_counters(state, 1, 2 * kPixels);
}

// The steps after the decoder, each over a whole image. As in the scanner, the lines of a row stay in one short array.
enum class Step { search, triangulation, difference };
void step(benchmark::State& state, const Setup& setup, const std::uint8_t* images, Step which) {
  structured_light::FastGrayDecoder decoder({kSide, kSide, kBits, 5});
  for (int i = 0; i < 2 * kBits; ++i) {
    decoder.add_frame(image_at(images, i), i, true);
  }
  const structured_light::CodeImageView codes = decoder.codes();
  const structured_light::PlaneTriangulation triangulation(setup.rig, kBits);
  std::vector<float> lines(kSide), z(kPixels), difference(kPixels), from(kPixels, 550);
  for (int r = 0; r < kSide; ++r) {
    structured_light::look_up_row(setup.table, r, codes.codes8 + r * kSide, codes.ambiguous8 + r * kSide, lines.data());
    triangulation.depth_of_lines(r, lines.data(), z.data() + static_cast<std::ptrdiff_t>(r) * kSide);
  }
  for (auto _ : state) {
    for (std::ptrdiff_t r = 0; r < kSide; ++r) {
      const std::ptrdiff_t first = r * kSide;
      if (which == Step::search) {
        structured_light::look_up_row(setup.table, static_cast<int>(r), codes.codes8 + first, codes.ambiguous8 + first,
                                      lines.data());
      } else if (which == Step::triangulation) {
        triangulation.depth_of_lines(static_cast<int>(r), lines.data(), z.data() + first);
      } else {
        structured_light::subtract(from.data() + first, z.data() + first, kSide, difference.data() + first);
      }
      benchmark::ClobberMemory();
    }
  }
  bench::set_counters(state, 1, 2 * kPixels);
}

nlohmann::ordered_json print_ratios(const bench::Collector& collector) {
  const double bytes = 2.0 * kPixels;
  const auto milliseconds = [&](const char* name) { return 1000 * bytes / collector.median(name); };
  const double cache = collector.median("match/cache");
  const double memory = collector.median("match/memory");
  const double ceiling = bench::read_ceiling(collector);
  if (!(cache > 0 && memory > 0 && ceiling > 0)) {
    return {};
  }
  std::printf(
      "depth image and difference, 512 x 512, m = 4, all steps: %.0f images/s in cache; %.0f from memory, %.1f %% "
      "of the read ceiling; %.0f of random images\n",
      cache / bytes, memory / bytes, 100 * memory / ceiling, collector.median("match/random") / bytes);
  const double decoding = milliseconds("decode/cache");
  const double search = milliseconds("search/cache");
  const double triangulation = milliseconds("triangulation/cache");
  const double difference = milliseconds("difference/cache");
  const double sum = decoding + search + triangulation + difference;
  std::printf("  step                                         ms   share   published ms (GPU)\n");
  std::printf("  binarization, measurable, Gray code, code  %.3f  %4.0f %%   0.07 + 0.09 + 0.20 + 0.09\n", decoding,
              100 * decoding / sum);
  std::printf("  neighbourhood search                       %.3f  %4.0f %%   0.07\n", search, 100 * search / sum);
  std::printf("  triangulation                              %.3f  %4.0f %%   0.10\n", triangulation,
              100 * triangulation / sum);
  std::printf("  difference                                 %.3f  %4.0f %%   –\n", difference, 100 * difference / sum);
  std::printf("  all in one                                 %.3f           0.62; with transfers 1.31\n",
              milliseconds("match/cache"));
  const auto step = [&](const char* name, double ms, const char* published) {
    return nlohmann::ordered_json{{"name", name}, {"ms", ms}, {"share", ms / sum}, {"published_ms", published}};
  };
  return {{"read_ceiling_gb_per_s", ceiling * 1e-9},
          {"cache_per_s", cache / bytes},
          {"memory_per_s", memory / bytes},
          {"share_of_read_ceiling", memory / ceiling},
          {"random_per_s", collector.median("match/random") / bytes},
          {"ms", milliseconds("match/cache")},
          {"steps",
           {step("binarization, measurable, Gray code, code", decoding, "0.07 + 0.09 + 0.20 + 0.09"),
            step("neighbourhood search", search, "0.07"), step("triangulation", triangulation, "0.10"),
            step("difference", difference, "–")}}};
}

int run() {
  const auto setup = std::make_unique<Setup>();
  const std::vector<std::uint8_t> few = images_of(*setup);
  bench::RandomBuffer random(kImages * kPixels);
  bench::require(results_are_right(*setup, few.data()), "the results are wrong");
  std::vector<std::uint8_t> many(kImages * kPixels);
  for (std::size_t at = 0; at < many.size(); at += few.size()) {
    std::memcpy(many.data() + at, few.data(), few.size());
  }
  bench::add_read_ceiling({many.data(), many.size()});
  using bench::add;
  const Setup& s = *setup;
  add("match/cache", [&](benchmark::State& state) { whole(state, s, few.data(), 2 * kBits); });
  add("match/memory", [&](benchmark::State& state) { whole(state, s, many.data(), kImages); });
  add("match/random", [&](benchmark::State& state) { whole(state, s, random.data(), 2 * kBits); });
  add("decode/cache", [&](benchmark::State& state) { decode(state, few.data()); });
  add("search/cache", [&](benchmark::State& state) { step(state, s, few.data(), Step::search); });
  add("triangulation/cache", [&](benchmark::State& state) { step(state, s, few.data(), Step::triangulation); });
  add("difference/cache", [&](benchmark::State& state) { step(state, s, few.data(), Step::difference); });
  return bench::run_registered({"bench_match",
                                "Depth image and difference of self-projected structured light, 512 x 512, "
                                "m = 4, one core",
                                "bytes_per_second"},
                               print_ratios);
}

}  // namespace
}  // namespace selfproj::test

int main(int argc, char** argv) {
  return selfproj::bench::main_of("bench_match", {argv + 1, argv + argc}, selfproj::test::run);
}
