#include "sim/board/packet_recording.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <numbers>
#include <span>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

#include "selfproj/driver/device.h"
#include "selfproj/files/user_error.h"
#include "selfproj/model/board.h"
#include "selfproj/model/packet.h"

namespace selfproj::sim {

void PacketRecording::add(const model::PacketHeader& header, std::span<const std::uint8_t> packet) {
  if (frames_.empty() || frames_.back().sequence != header.sequence) {
    frames_.push_back({header.sequence, header.encoder, packets_.size(), 0});
  }
  ++frames_.back().packets;
  build_.pixel_bits = std::max<int>(build_.pixel_bits, header.pixel_bits);
  build_.max_rows = header.tall ? spec::kRowLimit : build_.max_rows;
  build_.max_columns = header.columns > build_.max_columns ? spec::kColumnLimit : build_.max_columns;
  build_.runs = build_.runs || header.select == spec::kSelectStrongest;
  build_.region = build_.region || header.region_row != 0 || header.region_column != 0;
  build_.compact = build_.compact || header.kind == spec::kKindCompact;
  packets_.push_back({bytes_.size(), packet.size()});
  bytes_.insert(bytes_.end(), packet.begin(), packet.end());
}

void PacketRecording::stamp(std::size_t packet, std::uint64_t frame, double clocks_per_frame,
                            std::uint8_t* room) const {
  const Packet& recorded = packets_[packet];
  std::copy_n(bytes_.data() + recorded.begin, recorded.size, room);

  // The encoder continues: from the last frame to the first one of the next loop it counts as much as on average from
  // frame to frame. Differences are modulo 2^32, like the count itself.
  const std::uint64_t loops = frame / frames_.size();
  const Frame& first = frames_.front();
  const auto way = static_cast<std::int32_t>(frames_.back().encoder - first.encoder);
  const double step = frames_.size() > 1 ? static_cast<double>(way) / static_cast<double>(frames_.size() - 1) : 0;
  const auto way_of_loop = static_cast<std::uint32_t>(way + static_cast<std::int32_t>(std::lround(step)));
  const std::uint32_t encoder = frames_[static_cast<std::size_t>(frame % frames_.size())].encoder +
                                static_cast<std::uint32_t>(loops) * way_of_loop;

  const auto time_stamp = static_cast<std::uint64_t>(static_cast<double>(frame) * clocks_per_frame);
  model::stamp_packet({room, recorded.size},
                      {.sequence = frame, .time_stamp = time_stamp, .encoder = encoder, .lost = 0});
}

namespace {

constexpr std::size_t kMaxHeld = 4'000'000'000;
constexpr std::uint64_t kMaxSearched = std::uint64_t{1} << 28U;  // bytes: a file may have no end

}  // namespace

PacketRecording read_recording(const std::string& file, driver::Counters& counters) {
  PacketRecording recording;
  const std::unique_ptr<driver::Device> device = driver::open_device("file:" + file);
  model::PacketView packet;
  for (driver::Next next = driver::Next::timeout; next != driver::Next::end;
       next = device->next(packet, std::chrono::seconds(1))) {
    if (next == driver::Next::packet) {
      recording.add(packet.header, packet.bytes());
    }
    if (recording.frames() == 0 && device->counters().bytes_discarded > kMaxSearched) {
      throw UserError(file, "has no good packet at its beginning");
    }
    if (recording.bytes() > kMaxHeld) {
      throw UserError(file, "has more than 4 GB of packets; they are held in memory");
    }
  }
  counters = device->counters();
  if (recording.frames() == 0) {
    throw UserError(file, counters.other_spec > 0 ? "has only packets of another specification" : "has no good packet");
  }
  return recording;
}

PacketRecording moving_line(int rows, int columns, int frames, const model::Measure& measure) {
  constexpr double kPeak = 200;
  constexpr double kBackground = 10;
  constexpr double kSigma = 2;
  constexpr std::uint32_t kEncoderPerFrame = 10;
  if (rows < 1 || rows > spec::kRowLimit || columns < spec::kPixelsPerBeat || columns > spec::kColumnLimit ||
      columns % spec::kPixelsPerBeat != 0 || frames < 1) {
    throw std::invalid_argument("moving line: the size is out of range");
  }
  PacketRecording recording;
  std::vector<std::uint8_t> pixels(static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns));
  std::vector<std::uint8_t> payload(model::moments_payload_bytes(measure.mode, columns));
  std::vector<std::uint8_t> packet;
  model::Runs runs;
  runs.resize(measure.select, columns);
  for (int frame = 0; frame < frames; ++frame) {
    for (int column = 0; column < columns; ++column) {
      const double phase = static_cast<double>(column) / columns + static_cast<double>(frame) / frames;
      const double line = (rows - 1) / 2.0 + rows / 4.0 * std::sin(2 * std::numbers::pi * phase);
      for (int row = 0; row < rows; ++row) {
        const double away = (row - line) / kSigma;
        const double grey = kBackground + (kPeak - kBackground) * std::exp(-away * away / 2);
        pixels[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(column)] =
            static_cast<std::uint8_t>(std::lround(grey));
      }
    }
    model::measure_columns({pixels.data(), rows, columns, columns}, measure, runs.view());
    model::PacketHeader header;
    header.kind = spec::kKindMoments;
    header.sequence = static_cast<std::uint64_t>(frame);
    header.encoder = static_cast<std::uint32_t>(frame) * kEncoderPerFrame;
    model::describe_frame(header, rows, columns, measure);
    model::pack_columns(header, runs.view(), payload.data());
    packet.clear();
    model::append_packet(header, payload, 0, packet);
    recording.add(header, packet);
  }
  return recording;
}

PacketRecording recording_of_images(const model::BoardSettings& settings, int pixel_bits, std::size_t images,
                                    int patterns, const std::function<model::SensorView(std::size_t)>& image) {
  constexpr std::uint64_t kPause = 100;  // clocks between two frames: enough for the decoder
  PacketRecording recording;
  std::vector<std::uint8_t> packet;
  model::BoardModel board(
      [&](model::BoardPacket&& made) {
        packet.clear();
        model::append_packet(made.header, made.payload, made.status, packet);
        recording.add(made.header, packet);
      },
      settings.median, pixel_bits, spec::kPixelsPerBeat, settings.rows > spec::kMaxRows);
  board.write(settings);
  model::BoardInputs inputs;
  model::VideoBeat beat;
  for (std::size_t i = 0; i < images; ++i) {
    const model::SensorView view = image(i);
    inputs.clock += kPause;
    inputs.pattern = static_cast<std::uint16_t>(i % static_cast<std::size_t>(patterns));
    for (int row = 0; row < settings.rows; ++row) {
      for (int column = 0; column < settings.columns; column += spec::kPixelsPerBeat) {
        ++inputs.clock;
        beat.start = row == 0 && column == 0;
        beat.line_end = column + spec::kPixelsPerBeat == settings.columns;
        std::visit(
            [&](const auto& pixels) {
              std::copy_n(pixels.pixels + row * pixels.stride + column, spec::kPixelsPerBeat, beat.pixels.begin());
            },
            view);
        board.beat(inputs, beat);
      }
    }
  }
  return recording;
}

}  // namespace selfproj::sim
