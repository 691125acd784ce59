// make_depth_parts FOLDER: a coarse scanner whose parts are cut by image (rig.yaml) and by trigger (trigger.yaml), the
// stripes of an empty plane (reference), and packets of a board that decodes the images of good parts (good.packets)
// and of a run in which a block stands on every third part (run.packets).
//
// A part stands still for kFrames frames, and 100 ms without frames follow. kFrames is a whole number of sequences.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "host/files/output_folder.h"
#include "host/structured_light/self_reference.h"
#include "selfproj/model/gray_decoder.h"
#include "selfproj/model/packet.h"
#include "selfproj/model/packet_payload.h"
#include "tests/cli/program.h"
#include "tests/host/light_section/seen_surface.h"

namespace selfproj::test {
namespace {

constexpr double kPlane = 550;     // z, mm
constexpr double kBlock = 60;      // height of the block, mm
constexpr double kHalfBlock = 45;  // half of its side, mm
constexpr int kFrames = 24;
constexpr int kBits = 4;
constexpr std::uint64_t kPauseMs = 100;

class Board {
 public:
  Board(const rig::Rig& rig, const structured_light::SelfReference& reference, std::uint64_t seed)
      : rig_(rig), random_(seed) {
    for (int i = 0; i < 2 * kBits; ++i) {
      patterns_.push_back(structured_light::self_projected_pattern(reference, i));
    }
    words_.resize(rig.camera.pixels());
  }

  // Shows the part for kFrames frames, and then nothing for a while.
  void pass(const Surface& part) {
    const structured_light::ProjectorPoints points = points_of(rig_, part);
    for (int i = 0; i < kFrames; ++i, ++frame_) {
      send(image(points, patterns_[frame_ % patterns_.size()]));
    }
    clock_ += kPauseMs * clocks_per_ms();
  }

  [[nodiscard]] std::string text() const { return {bytes_.begin(), bytes_.end()}; }

 private:
  [[nodiscard]] std::uint64_t clocks_per_ms() const { return static_cast<std::uint64_t>(rig_.pixel_clock_hz() / 1000); }

  std::vector<std::uint8_t> image(const structured_light::ProjectorPoints& points, const images::FloatImage& pattern) {
    std::normal_distribution<double> noise(0, 2);
    std::vector<std::uint8_t> pixels(rig_.camera.pixels());
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      double grey = 20;
      if (!std::isnan(points.line.values[i])) {
        const int line = static_cast<int>(std::lround(points.line.values[i]));
        grey = pattern.row(line)[std::lround(points.column.values[i])] > 0.5F ? 150 : 20;
      }
      pixels[i] = static_cast<std::uint8_t>(std::lround(std::clamp(grey + noise(random_), 0.0, 255.0)));
    }
    return pixels;
  }

  void send(const std::vector<std::uint8_t>& pixels) {
    const rig::RigCamera& camera = rig_.camera;
    model::PacketHeader header;
    header.rows = static_cast<std::uint16_t>(camera.rows);
    header.columns = static_cast<std::uint16_t>(camera.columns);
    header.sequence = frame_;
    header.time_stamp = clock_ += clocks_per_ms();
    header.kind = spec::kKindMoments;
    model::append_packet(header,
                         std::vector<std::uint8_t>(model::moments_payload_bytes(model::Mode::binary, camera.columns)),
                         0, bytes_);
    const model::ImageView view{pixels.data(), camera.rows, camera.columns, camera.columns};
    if (!decoder_.add_frame(view, static_cast<int>(frame_ % patterns_.size()), true, words_.data())) {
      return;
    }
    header.kind = spec::kKindCodes;
    header.lines = 1;
    std::vector<std::uint8_t> payload(model::codes_line_payload_bytes(camera.columns));
    for (int row = 0; row < camera.rows; ++row) {
      header.first_line = static_cast<std::uint16_t>(row + 1);
      model::pack_codes(camera.columns, words_.data() + static_cast<std::ptrdiff_t>(row) * camera.columns,
                        payload.data());
      model::append_packet(header, payload, 0, bytes_);
    }
  }

  const rig::Rig& rig_;
  std::mt19937_64 random_;
  std::vector<images::FloatImage> patterns_;
  model::GrayDecoder decoder_{{rig_.camera.rows, rig_.camera.columns, kBits, rig_.measure.code_threshold}};
  std::vector<std::uint16_t> words_;
  std::uint64_t frame_ = 0;
  std::uint64_t clock_ = 0;
  std::vector<std::uint8_t> bytes_;
};

void make(const std::filesystem::path& folder) {
  rig::Rig rig = coarse_scanner(8);
  rig.measure.max_z_per_line_mm = 50;
  rig.parts = rig::RigParts{.cut = rig::PartCut::image, .grid_mm = 8, .pause_s = 0.02};
  write_text(folder / "rig.yaml", rig::to_yaml(rig));
  rig.parts->cut = rig::PartCut::trigger;
  write_text(folder / "trigger.yaml", rig::to_yaml(rig));
  rig = rig::load_rig((folder / "rig.yaml").string());

  structured_light::Stripes stripes;
  stripes.bits = kBits;
  const structured_light::SelfReference reference =
      structured_light::make_self_reference(rig, points_of(rig, plane_at(kPlane)), stripes);
  files::OutputFolder written((folder / "reference").string());
  structured_light::write_self_reference(rig, reference, written);
  written.commit();

  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> any(-1, 1);
  Board good(rig, reference, 1);
  Board run(rig, reference, 2);
  for (int i = 0; i < 9; ++i) {
    good.pass(plane_at(kPlane + any(random)));
    const double z = kPlane + any(random);
    run.pass(i % 3 != 2 ? plane_at(z) : Surface([z](double x, double y) {
      return std::abs(x) < kHalfBlock && std::abs(y) < kHalfBlock ? z - kBlock : z;
    }));
  }
  write_text(folder / "good.packets", good.text());
  write_text(folder / "run.packets", run.text());
}

}  // namespace
}  // namespace selfproj::test

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: make_depth_parts FOLDER\n");
    return 2;
  }
  selfproj::test::make(argv[1]);
  return 0;
}
