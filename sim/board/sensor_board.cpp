#include "sim/board/sensor_board.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <variant>

#include "selfproj/light_section/fast_moments.h"
#include "selfproj/model/packet.h"

namespace selfproj::sim {

std::span<const std::uint8_t> SensorBoard::packet_of(std::uint64_t frame, double clocks_per_frame) {
  const model::BoardSettings written = registers_.settings();
  taken_ = written.hold ? taken_ : written;
  if (taken_.region_row > 0 && taken_.region_column > 0) {
    row_ = taken_.region_row - 1;
    column_ = taken_.region_column - 1;
  }
  const images::SensorImage& image = images_[static_cast<std::size_t>(frame % frames())];
  const auto [rows, columns] = std::visit([](const auto& one) { return std::pair(one.rows, one.columns); }, image);
  if (!written.run || row_ + taken_.rows > rows || column_ + taken_.columns > columns) {
    return {};
  }
  model::Measure measure = taken_.measure();
  measure.bits = pixel_bits_;
  model::PacketHeader header;
  header.kind = model::kind_of_columns(taken_.compact, measure.mode);
  header.stream = static_cast<std::uint8_t>(taken_.stream);
  header.sequence = frame;
  header.time_stamp = static_cast<std::uint64_t>(static_cast<double>(frame) * clocks_per_frame);
  header.encoder = encoder_at(frame, counts_per_frame_);
  header.region_row = static_cast<std::uint16_t>(taken_.region_row);
  header.region_column = static_cast<std::uint16_t>(taken_.region_column);
  model::describe_frame(header, taken_.rows, taken_.columns, measure);
  runs_.resize(measure.select, taken_.columns);
  std::visit(
      [&]<typename Pixel>(const images::ImageOf<Pixel>& one) {
        const auto stride = static_cast<std::ptrdiff_t>(one.columns);
        light_section::fast_measure_columns(
            model::PixelView<Pixel>{one.pixels.data() + row_ * stride + column_, taken_.rows, taken_.columns, stride},
            measure, runs_.view());
      },
      image);
  payload_.resize(model::columns_payload_bytes(header));
  model::pack_columns(header, runs_.view(), payload_.data());
  packet_.clear();
  model::append_packet(header, payload_, 0, packet_);
  return packet_;
}

}  // namespace selfproj::sim
