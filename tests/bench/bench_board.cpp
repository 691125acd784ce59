// Measures how many frames per second the board in software turns into packets on one core.
//
//     bench_board [--benchmark_...]
//
// Frames of 96 x 512 pixels with a line of light 3 to 9 rows wide over noise below the threshold lie one after another
// in a buffer far larger than the caches (4000 of them, 197 MB). One thread makes the whole packet of each: header,
// moments, trailer with its check word. In the same run it sums the moments alone, lets the board's model, the
// definition, do the same, and reads the frames as fast as it can in two ways, of which the faster one is the ceiling.
// The measurements are repeated 7 times in random order, and their medians are compared. Before the first one the
// packets are compared with those of the model; a difference ends the program with exit status 1.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "host/camera/software_board.h"
#include "selfproj/light_section/fast_moments.h"
#include "selfproj/model/board.h"
#include "tests/bench/collector.h"
#include "tests/bench/read_ceiling.h"

namespace selfproj::test {
namespace {

using bench::Collector;

constexpr int kRows = 96;
constexpr int kColumns = 512;
constexpr int kFrames = 4000;
constexpr int kModelFrames = 20;
constexpr std::size_t kFrameBytes = static_cast<std::size_t>(kRows) * kColumns;

struct Case {
  const char* name;
  model::Mode mode;
  model::Select select;
};
constexpr Case kCases[] = {{"binary", model::Mode::binary, model::Select::all},
                           {"grey_over", model::Mode::grey_over, model::Select::all},
                           {"strongest_grey_over", model::Mode::grey_over, model::Select::strongest}};

model::BoardSettings settings_of(const Case& one) {
  return {.columns = kColumns, .rows = kRows, .mode = one.mode, .threshold = 60, .select = one.select};
}

std::vector<std::uint8_t> make_frames() {
  std::vector<std::uint8_t> pixels(kFrames * kFrameBytes);
  std::mt19937 random(1);
  for (std::size_t frame = 0; frame < kFrames; ++frame) {
    std::uint8_t* const out = pixels.data() + frame * kFrameBytes;
    for (std::size_t i = 0; i < kFrameBytes; i += 4) {
      const std::uint32_t noise = static_cast<std::uint32_t>(random()) & 0x1F1F1F1FU;
      std::memcpy(out + i, &noise, sizeof noise);
    }
    for (std::size_t column = 0; column < kColumns; ++column) {
      const std::size_t first = 30 + (frame + column / 16) % 40;
      const std::size_t rows = 3 + random() % 7;
      for (std::size_t row = first; row < first + rows; ++row) {
        out[row * kColumns + column] = static_cast<std::uint8_t>(80 + random() % 170);
      }
    }
  }
  return pixels;
}

model::ImageView frame_of(const std::vector<std::uint8_t>& pixels, int frame) {
  return {pixels.data() + static_cast<std::size_t>(frame) * kFrameBytes, kRows, kColumns, kColumns};
}

void model_frame(model::BoardModel& model, const model::ImageView& image, model::BoardInputs& inputs) {
  for (int at = 0; at < kRows * kColumns; at += spec::kPixelsPerBeat) {
    model::VideoBeat beat;
    std::copy_n(image.pixels + at, spec::kPixelsPerBeat, beat.pixels.begin());
    beat.start = at == 0;
    beat.line_end = at % kColumns == kColumns - spec::kPixelsPerBeat;
    ++inputs.clock;
    model.beat(inputs, beat);
  }
}

bool packets_are_right(const std::vector<std::uint8_t>& pixels, const Case& one) {
  std::vector<std::uint8_t> expected;
  model::BoardModel model([&](model::BoardPacket&& packet) {
    model::append_packet(packet.header, packet.payload, packet.status, expected);
  });
  model.write(settings_of(one));
  camera::SoftwareBoard board(settings_of(one));
  std::vector<std::uint8_t> got;
  model::BoardInputs inputs;
  for (int frame = 0; frame < kModelFrames; ++frame) {
    model::BoardInputs at_start = inputs;
    ++at_start.clock;
    model_frame(model, frame_of(pixels, frame), inputs);
    board.process(frame_of(pixels, frame), true, static_cast<std::uint64_t>(frame), at_start);
    model::PacketView packet;
    while (board.next(packet)) {
      got.insert(got.end(), packet.bytes().begin(), packet.bytes().end());
    }
  }
  return got == expected;
}

void make_packets(benchmark::State& state, const std::vector<std::uint8_t>& pixels, const Case& one) {
  camera::SoftwareBoard board(settings_of(one));
  std::uint64_t sequence = 0;
  for (auto _ : state) {
    for (int frame = 0; frame < kFrames; ++frame) {
      board.process(frame_of(pixels, frame), true, sequence, {.clock = 15120 * sequence});
      ++sequence;
      model::PacketView packet;
      while (board.next(packet)) {
        benchmark::DoNotOptimize(packet);
      }
      benchmark::ClobberMemory();
    }
  }
  bench::set_counters(state, kFrames, kFrameBytes);
}

void sum_moments(benchmark::State& state, const std::vector<std::uint8_t>& pixels, const Case& one) {
  const model::Measure measure{.mode = one.mode, .threshold = 60, .select = one.select};
  model::Runs runs;
  runs.resize(one.select, kColumns);
  for (auto _ : state) {
    for (int frame = 0; frame < kFrames; ++frame) {
      light_section::fast_measure_columns(frame_of(pixels, frame), measure, runs.view());
      benchmark::ClobberMemory();
    }
  }
  bench::set_counters(state, kFrames, kFrameBytes);
}

void run_model(benchmark::State& state, const std::vector<std::uint8_t>& pixels, const Case& one) {
  model::BoardModel model([](model::BoardPacket&& packet) { benchmark::DoNotOptimize(packet); });
  model.write(settings_of(one));
  model::BoardInputs inputs;
  for (auto _ : state) {
    for (int frame = 0; frame < kModelFrames; ++frame) {
      model_frame(model, frame_of(pixels, frame), inputs);
    }
  }
  bench::set_counters(state, kModelFrames, kFrameBytes);
}

int run() {
  const std::vector<std::uint8_t> pixels = make_frames();
  for (const Case& one : kCases) {
    bench::require(packets_are_right(pixels, one), std::string("the packets are wrong (") + one.name + ")");
    const auto add = [&](const std::string& what, auto work) {
      bench::add(what + "/" + one.name, [&, work](benchmark::State& state) { work(state, pixels, one); });
    };
    add("packets", make_packets);
    add("moments", sum_moments);
    add("model", run_model);
  }
  bench::add_read_ceiling(pixels);
  const bench::About about{"bench_board", "The board in software: frames of 96 x 512 from memory to packets, one core",
                           "bytes_per_second"};
  return bench::run_registered(about, [](const Collector& collector) {
    nlohmann::ordered_json results;
    const double ceiling = bench::read_ceiling(collector);
    results["read_ceiling_gb_per_s"] = ceiling * 1e-9;
    for (const Case& one : kCases) {
      const double packets = collector.median(std::string("packets/") + one.name);
      const double moments = collector.median(std::string("moments/") + one.name);
      const double model = collector.median(std::string("model/") + one.name);
      if (packets > 0 && moments > 0 && model > 0 && ceiling > 0) {
        std::printf(
            "%-20s: %7.0f frames/s to packets, %3.0f %% of the read ceiling; moments alone %7.0f/s; model %5.0f/s\n",
            one.name, packets / kFrameBytes, 100 * packets / ceiling, moments / kFrameBytes, model / kFrameBytes);
        results[one.name] = {{"packets_per_s", packets / kFrameBytes},
                             {"share_of_read_ceiling", packets / ceiling},
                             {"moments_alone_per_s", moments / kFrameBytes},
                             {"model_per_s", model / kFrameBytes}};
      }
    }
    return results;
  });
}

}  // namespace
}  // namespace selfproj::test

int main(int argc, char** argv) {
  return selfproj::bench::main_of("bench_board", {argv + 1, argv + argc}, selfproj::test::run);
}
