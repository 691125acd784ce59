#include "constraints/common/scoreboard.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "selfproj/model/board.h"
#include "selfproj/model/packet.h"

namespace selfproj::sim {

void show_frame(model::BoardModel& model, std::span<const std::uint8_t> pixels, int columns,
                model::BoardInputs inputs) {
  const auto line = static_cast<std::size_t>(columns);
  for (std::size_t at = 0; at < pixels.size(); at += spec::kPixelsPerBeat, ++inputs.clock) {
    model::VideoBeat beat{.start = at == 0, .line_end = (at + spec::kPixelsPerBeat) % line == 0};
    std::copy_n(pixels.data() + at, spec::kPixelsPerBeat, beat.pixels.begin());
    model.beat(inputs, beat);
  }
}

void FramePackets::expect(std::span<const std::uint8_t> pixels, int columns, int rows,
                          const model::PacketHeader& header) {
  expected_.clear();
  mode_ = header.mode;
  threshold_ = header.threshold;
  kind_ = header.kind;
  model::BoardModel model([this](model::BoardPacket&& packet) { expect(std::move(packet)); });
  model.write({.image = true,
               .columns = columns,
               .rows = rows,
               .mode = static_cast<model::Mode>(header.mode),
               .threshold = header.threshold,
               .stream = header.stream,
               .region_row = header.region_row,
               .region_column = header.region_column,
               .compact = header.kind == spec::kKindCompact});
  show_frame(model, pixels, columns, {.clock = 1000});
}

void FramePackets::expect(model::BoardPacket&& packet) {
  const std::pair place(packet.header.kind, packet.header.first_line);
  expected_.insert_or_assign(place, std::move(packet));
}

bool FramePackets::has(const model::PacketView& packet, bool may_stray) const {
  const auto due = expected_.find({packet.header.kind, packet.header.first_line});
  if (due == expected_.end()) {
    return false;
  }
  model::PacketHeader header = due->second.header;
  header.sequence = packet.header.sequence;
  header.time_stamp = packet.header.time_stamp;
  header.lost = packet.header.lost;
  if (may_stray) {
    header.flags |= packet.header.flags & spec::kFlagStrayBefore;
  }
  std::vector<std::uint8_t> bytes;
  model::append_packet(header, due->second.payload, due->second.status, bytes);
  return bytes.size() == packet.size && std::memcmp(bytes.data(), packet.bytes().data(), bytes.size()) == 0;
}

}  // namespace selfproj::sim
