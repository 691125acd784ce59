// Measures how many profiles per second one core computes from packets: found, checked, triangulated.
//
//     bench_profile [--benchmark_...]
//
// For the pinholes of rig A, and for the same rig with distorting lenses on both sides ("lenses").
//
// Packets of 512 columns lie one after another in a buffer that stays in the second-level cache (64 of them, like the
// newest packets of a ring) or in one far larger than the caches. For each packet the program calls parse_packet, which
// reads all of it for the check word, and computes the differential profile of its payload into the same Profile. It
// also measures each step alone, and the ceiling: reading the same packets and writing the same profile in 8-byte words
// without computing anything. The measurements are repeated 7 times in random order, and their medians are compared.
// Before the first measurement the profiles are compared with the conventional equation in double precision; a
// difference ends the program with exit status 1.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "host/rig/geometry.h"
#include "model/cpu_clones.h"
#include "selfproj/light_section/differential_profile.h"
#include "selfproj/light_section/reference.h"
#include "selfproj/model/packet.h"
#include "selfproj/rig/calibration.h"
#include "selfproj/rig/optics.h"
#include "selfproj/rig/rig.h"
#include "tests/bench/collector.h"

namespace selfproj::test {
namespace {

using bench::Collector;

constexpr int kColumns = 512;
constexpr int kInCache = 64;
constexpr int kInMemory = 40000;  // 88 MB in mode binary

// Good packets of random lines 3 to 9 rows wide, one after another. With Select::strongest half the columns have a
// second run, of less than half the strongest.
struct Packets {
  Packets(const rig::Rig& rig, model::Mode mode, int packet_count, model::Select packet_select = model::Select::all,
          bool compact = false)
      : select(packet_select), count(packet_count) {
    std::mt19937 engine(1);
    const auto random = [&] { return static_cast<std::uint32_t>(engine()); };
    model::Runs runs;
    runs.resize(select, kColumns);
    model::Moments& moments = runs.moments;
    model::PacketHeader header;
    header.kind = compact ? spec::kKindCompact : spec::kKindMoments;
    header.columns = kColumns;
    header.rows = static_cast<std::uint16_t>(rig.camera.rows);
    header.mode = static_cast<std::uint8_t>(mode);
    header.select = static_cast<std::uint8_t>(select);
    word = model::column_word(header);
    std::vector<std::uint8_t> payload(model::columns_payload_bytes(header));
    for (int i = 0; i < kInCache; ++i) {
      for (std::size_t k = 0; k < kColumns; ++k) {
        moments.n[k] = 3 + random() % 7;
        moments.m0[k] = mode == model::Mode::binary ? moments.n[k] : moments.n[k] * 100 + random() % 100;
        moments.m1[k] = moments.m0[k] * 40 + random() % (16 * moments.m0[k]);
        if (select == model::Select::strongest) {
          runs.runs[k] = static_cast<std::uint8_t>(1 + random() % 2);
          runs.second[k] = static_cast<std::uint8_t>(runs.runs[k] > 1 ? random() % 8 : 0);
        }
      }
      model::pack_columns(header, runs.view(), payload.data());
      ++header.sequence;
      model::append_packet(header, payload, 0, bytes);
    }
    size = bytes.size() / kInCache;
    const std::size_t first = bytes.size();  // the others are copies of these
    bytes.resize(size * static_cast<std::size_t>(count));
    for (std::size_t at = first; at < bytes.size(); at += size) {
      std::copy_n(bytes.data() + at - first, size, bytes.data() + at);
    }
  }

  std::span<const std::uint8_t> packet(int i) const {
    return std::span(bytes).subspan(static_cast<std::size_t>(i) * size, size);
  }

  model::Select select;
  int count;
  model::ColumnWord word{};
  std::size_t size;
  std::vector<std::uint8_t> bytes;
};

// z in double precision: (3.4), or where the ray meets the light through the lenses.
double depth_of(const rig::Rig& rig, const light_section::ReferenceProfile& reference, std::size_t column,
                double centroid) {
  if (rig.is_pinholes()) {
    const double theta = reference.tan_theta[column];
    return (rig.projector.x_mm + rig.projector.z_mm * theta) / (rig::tan_alpha(rig.camera, centroid) + theta);
  }
  static const rig::RigOptics optics(rig);
  const auto ray = optics.ray({centroid - 1, static_cast<double>(column)});
  return optics.meet(*ray, *light_section::sheet_of(optics, reference, static_cast<int>(column))).value_or(0);
}

// Rig A with distorting lenses.
rig::Rig with_lenses(const rig::Rig& rig) {
  rig::Calibration calibration = rig::calibration_of(rig);
  calibration.camera.k = {0.08, 0.01, 0.001, -0.001, 0, 0, 0, 0};
  calibration.projector.k = {-0.08, 0.01, -0.001, 0.001, 0, 0, 0, 0};
  return rig::rig_of(calibration, rig);
}

bool profiles_are_right(const rig::Rig& rig, const light_section::ReferenceProfile& reference,
                        const light_section::DifferentialProfiler& profiler, const Packets& packets) {
  light_section::Profile profile;
  profile.resize(kColumns);
  model::Runs runs;
  runs.resize(packets.select, kColumns);
  const model::Moments& moments = runs.moments;
  for (int i = 0; i < 16; ++i) {
    model::PacketView view;
    if (model::parse_packet(packets.packet(i), view) != model::PacketError::none) {
      return false;
    }
    if (!profiler.profile(view, profile.view())) {
      return false;
    }
    model::unpack_columns(view.header, view.payload.data(), runs.view());
    for (std::size_t k = 0; k < kColumns; ++k) {
      const double z = depth_of(rig, reference, k, static_cast<double>(moments.m1[k]) / moments.m0[k]);
      if (profile.validity[k] != 0 || !(std::abs(static_cast<double>(profile.z[k]) - z) < 1e-3) ||
          !(std::abs(static_cast<double>(profile.dz[k]) - (z - reference.z_mm[k])) < 1e-4)) {
        return false;
      }
    }
  }
  return true;
}

enum class Work : std::uint8_t { parse, profile, both };

void work(benchmark::State& state, const light_section::DifferentialProfiler& profiler, const Packets& packets,
          Work what) {
  light_section::Profile profile;
  profile.resize(kColumns);
  const light_section::ProfileView out = profile.view();
  for (auto _ : state) {
    for (int i = 0; i < packets.count; ++i) {
      model::PacketView view;
      view.payload = model::payload_of(packets.packet(i));
      if (what != Work::profile && model::parse_packet(packets.packet(i), view) != model::PacketError::none) {
        state.SkipWithError("a packet is bad");
        return;
      }
      benchmark::DoNotOptimize(view);
      if (what != Work::parse) {
        profiler.profile(packets.word, view.payload.data(), out);
      }
      benchmark::ClobberMemory();
    }
  }
  bench::set_counters(state, packets.count, packets.size);
}

// Reads a packet and fills a profile with its words, in as few instructions as possible.
SELFPROJ_CLONES void read_and_write(const std::uint8_t* packet, std::size_t size,
                                    const light_section::ProfileView& out) {
  constexpr std::size_t kLanes = 32;
  std::uint64_t lanes[kLanes] = {};
  for (std::size_t at = 0; at + sizeof lanes <= size; at += sizeof lanes) {
    for (std::size_t k = 0; k < kLanes; ++k) {
      std::uint64_t word;
      std::memcpy(&word, packet + at + k * sizeof word, sizeof word);
      lanes[k] ^= word;
    }
  }
  const auto value = static_cast<float>(lanes[0] ^ lanes[7] ^ lanes[11] ^ lanes[31]);
  for (float* values : {out.centroid, out.x, out.y, out.z, out.dx, out.dy, out.dz}) {
    for (int i = 0; i < kColumns; ++i) {
      values[i] = value;
    }
  }
  std::memset(out.validity, static_cast<int>(lanes[1] & 1), kColumns);
}

void ceiling(benchmark::State& state, const Packets& packets) {
  light_section::Profile profile;
  profile.resize(kColumns);
  const light_section::ProfileView out = profile.view();
  for (auto _ : state) {
    for (int i = 0; i < packets.count; ++i) {
      read_and_write(packets.packet(i).data(), packets.size, out);
      benchmark::ClobberMemory();
    }
  }
  bench::set_counters(state, packets.count, packets.size);
}

int run() {
  struct Station {
    explicit Station(const rig::Rig& of)
        : rig(of),
          reference(light_section::reference_of_curve(
              rig, light_section::curve_of_heights(rig, std::vector<double>(kColumns)))),
          profiler(rig, reference) {}
    rig::Rig rig;
    light_section::ReferenceProfile reference;
    light_section::DifferentialProfiler profiler;
  };
  const Station pinholes(rig::load_rig("light-section"));
  const Station lenses(with_lenses(pinholes.rig));
  struct Case {
    std::string name;
    const Station* station;
    Packets packets;
  };
  const std::vector<Case> cases = {
      {"binary/cache", &pinholes, Packets(pinholes.rig, model::Mode::binary, kInCache)},
      {"binary/memory", &pinholes, Packets(pinholes.rig, model::Mode::binary, kInMemory)},
      {"grey_over/cache", &pinholes, Packets(pinholes.rig, model::Mode::grey_over, kInCache)},
      {"grey_over/memory", &pinholes, Packets(pinholes.rig, model::Mode::grey_over, kInMemory)},
      {"strongest_binary/cache", &pinholes,
       Packets(pinholes.rig, model::Mode::binary, kInCache, model::Select::strongest)},
      {"strongest_binary/memory", &pinholes,
       Packets(pinholes.rig, model::Mode::binary, kInMemory, model::Select::strongest)},
      {"strongest_grey_over/cache", &pinholes,
       Packets(pinholes.rig, model::Mode::grey_over, kInCache, model::Select::strongest)},
      {"strongest_grey_over/memory", &pinholes,
       Packets(pinholes.rig, model::Mode::grey_over, kInMemory, model::Select::strongest)},
      {"compact/cache", &pinholes, Packets(pinholes.rig, model::Mode::grey_over, kInCache, model::Select::all, true)},
      {"compact/memory", &pinholes, Packets(pinholes.rig, model::Mode::grey_over, kInMemory, model::Select::all, true)},
      {"lenses_compact/cache", &lenses,
       Packets(lenses.rig, model::Mode::grey_over, kInCache, model::Select::all, true)},
      {"lenses_compact/memory", &lenses,
       Packets(lenses.rig, model::Mode::grey_over, kInMemory, model::Select::all, true)},
      {"lenses_binary/cache", &lenses, Packets(lenses.rig, model::Mode::binary, kInCache)},
      {"lenses_binary/memory", &lenses, Packets(lenses.rig, model::Mode::binary, kInMemory)},
      {"lenses_grey_over/cache", &lenses, Packets(lenses.rig, model::Mode::grey_over, kInCache)},
      {"lenses_grey_over/memory", &lenses, Packets(lenses.rig, model::Mode::grey_over, kInMemory)}};
  for (const auto& [name, station, packets] : cases) {
    bench::require(profiles_are_right(station->rig, station->reference, station->profiler, packets),
                   std::string("the profiles are wrong (") + name + ")");
    const auto add = [&, &name = name, &set = packets, &profiler = station->profiler](const std::string& step,
                                                                                      Work what) {
      bench::add(step + "/" + name, [&, what](benchmark::State& state) { work(state, profiler, set, what); });
    };
    add("parse", Work::parse);
    add("profile", Work::profile);
    add("both", Work::both);
    bench::add("ceiling/" + name, [&set = packets](benchmark::State& state) { ceiling(state, set); });
  }
  const bench::About about{"bench_profile", "Packet to differential profile, 512 columns, one core",
                           "items_per_second"};
  return bench::run_registered(about, [&](const Collector& collector) {
    nlohmann::ordered_json results;
    std::printf("\nprofiles/s, one core, packet to differential profile (medians)\n");
    for (const auto& [name, station, packets] : cases) {
      const double both = collector.median("both/" + name);
      const double most = collector.median("ceiling/" + name);
      if (both > 0 && most > 0) {
        std::printf("%-24s: %8.0f profiles/s, %4.1f %% of reading the packets and writing the profiles alone\n",
                    name.c_str(), both, 100 * both / most);
        const std::size_t slash = name.find('/');
        results[name.substr(0, slash)][name.substr(slash + 1)] = {{"profiles_per_s", both},
                                                                  {"share_of_reading_and_writing", both / most}};
      }
    }
    return results;
  });
}

}  // namespace
}  // namespace selfproj::test

int main(int argc, char** argv) {
  return selfproj::bench::main_of("bench_profile", {argv + 1, argv + argc}, selfproj::test::run);
}
