#include "host/camera/software_board.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <stdexcept>

#include "selfproj/light_section/fast_moments.h"
#include "selfproj/model/generated/selfproj_spec.h"
#include "selfproj/model/packet_payload.h"

namespace selfproj::camera {
namespace {

model::PacketHeader header_of(const model::BoardSettings& settings, const model::Measure& measure) {
  model::PacketHeader header;
  header.stream = static_cast<std::uint8_t>(settings.stream);
  header.region_row = static_cast<std::uint16_t>(settings.region_row);
  header.region_column = static_cast<std::uint16_t>(settings.region_column);
  model::describe_frame(header, settings.rows, settings.columns, measure);
  return header;
}

bool within(int value, int min, int max) { return value >= min && value <= max; }

void check_settings(const model::BoardSettings& settings, int pixel_bits) {
  const bool good = within(settings.columns, spec::kPixelsPerBeat, spec::kColumnLimit) &&
                    settings.columns % spec::kPixelsPerBeat == 0 &&
                    within(settings.rows, 1, model::row_limit(pixel_bits)) && model::is_known(settings.mode) &&
                    model::is_known(settings.select) && within(pixel_bits, spec::kPixelBits, model::kMaxPixelBits) &&
                    within(settings.threshold, 0, (1 << pixel_bits) - 1) && within(settings.gap, 0, model::kMaxGap) &&
                    within(settings.stream, 0, UINT8_MAX) && within(settings.window.first, 0, spec::kRowLimit) &&
                    within(settings.window.last, 0, spec::kRowLimit) && within(settings.region_row, 0, UINT16_MAX) &&
                    within(settings.region_column, 0, UINT16_MAX);
  if (!good) {
    throw std::invalid_argument("software board: a setting is out of range");
  }
}

}  // namespace

SoftwareBoard::SoftwareBoard(const model::BoardSettings& settings, int pixel_bits)
    : settings_(settings), measure_(settings.measure()) {
  check_settings(settings, pixel_bits);
  measure_.bits = pixel_bits;
  header_ = header_of(settings, measure_);
  runs_.resize(settings.select, settings.columns);
  const auto rows = static_cast<std::size_t>(settings.rows);
  const std::size_t pixels = rows * static_cast<std::size_t>(settings.columns);
  const std::size_t moments_bytes = model::moments_payload_bytes(settings.mode, settings.columns);
  std::size_t packets = 1;
  std::size_t bytes = model::packet_bytes(moments_bytes);
  payload_.resize(moments_bytes);
  if (settings.image) {
    const std::size_t line = model::image_line_payload_bytes(settings.columns);
    packets += rows;
    bytes += rows * model::packet_bytes(line);
    payload_.resize(std::max(payload_.size(), line));
  }
  if (settings.codes) {
    const std::size_t line = model::codes_line_payload_bytes(settings.columns);
    packets += rows;
    bytes += rows * model::packet_bytes(line);
    payload_.resize(std::max(payload_.size(), line));
    decoder_.emplace(model::GraySettings{.rows = settings.rows,
                                         .columns = settings.columns,
                                         .bits = settings.code_bits,
                                         .threshold = settings.code_threshold});
    if (settings.median) {
      median_.emplace(settings.columns);
    }
    positive_.resize(pixels);
    codes_.resize(pixels);
  }
  places_.reserve(packets);
  bytes_.reserve(bytes);
}

void SoftwareBoard::process(const model::ImageView& image, bool complete, std::uint64_t sequence,
                            const model::BoardInputs& inputs, const model::WideImageView& wide) {
  if (complete && measure_.bits > spec::kPixelBits &&
      (wide.rows != settings_.rows || wide.columns != settings_.columns || wide.pixels == nullptr)) {
    throw std::invalid_argument("software board: there is no image of all bits, or it has another size");
  }
  if (complete && (image.rows != settings_.rows || image.columns != settings_.columns || image.pixels == nullptr)) {
    throw std::invalid_argument("software board: the image has another size");
  }
  places_.clear();
  bytes_.clear();
  given_ = 0;
  model::PacketHeader header = header_;
  header.sequence = sequence;
  header.time_stamp = inputs.clock;
  header.encoder = inputs.encoder;
  header.pattern = inputs.pattern;
  const bool codes = decode(image, complete, inputs.pattern);
  if (!complete) {
    header.kind = model::kind_of_columns(settings_.compact, settings_.mode);
    send(header, 0, spec::kStatusIncomplete);
    return;
  }
  send_moments(image, wide, header);
  if (settings_.image) {
    send_image(image, header);
  }
  if (codes) {
    send_codes(header);
  }
}

bool SoftwareBoard::next(model::PacketView& packet) {
  if (given_ == places_.size()) {
    return false;
  }
  const Place& place = places_[given_++];
  packet.header = place.header;
  packet.payload = {bytes_.data() + place.begin + spec::kHeaderBytes, place.header.payload_size};
  packet.status = place.status;
  packet.size = place.size;
  return true;
}

void SoftwareBoard::send(model::PacketHeader header, std::size_t payload_bytes, std::uint32_t status) {
  header.payload_size = static_cast<std::uint32_t>(payload_bytes);
  const std::size_t begin = bytes_.size();
  model::append_packet(header, {payload_.data(), payload_bytes}, status, bytes_);
  places_.push_back({.header = header, .begin = begin, .size = bytes_.size() - begin, .status = status});
}

void SoftwareBoard::send_moments(const model::ImageView& image, const model::WideImageView& wide,
                                 const model::PacketHeader& header) {
  const model::RunsView view = runs_.view();
  if (measure_.bits > spec::kPixelBits) {
    light_section::fast_measure_columns(wide, measure_, view);
  } else {
    light_section::fast_measure_columns(image, measure_, view);
  }
  model::PacketHeader moments = header;
  moments.kind = model::kind_of_columns(settings_.compact, measure_.mode);
  model::pack_columns(moments, view, payload_.data());
  send(moments, model::columns_payload_bytes(moments), 0);
}

void SoftwareBoard::send_image(const model::ImageView& image, model::PacketHeader header) {
  header.kind = spec::kKindImage;
  header.lines = 1;
  const std::size_t bytes = model::image_line_payload_bytes(image.columns);
  for (int row = 0; row < image.rows; ++row) {
    header.first_line = static_cast<std::uint16_t>(row + 1);
    std::uint8_t* const end = std::copy_n(image.pixels + row * image.stride, image.columns, payload_.data());
    std::fill(end, payload_.data() + bytes, std::uint8_t{0});
    send(header, bytes, 0);
  }
}

// Returns whether codes are due, which are then in codes_.
bool SoftwareBoard::decode(const model::ImageView& image, bool complete, int pattern) {
  if (!decoder_) {
    return false;
  }
  if (!complete) {
    decoder_->restart();
    return false;
  }
  model::ImageView kept = image;
  if (pattern % 2 == 0) {
    kept = {positive_.data(), image.rows, image.columns, image.columns};
    for (int row = 0; row < image.rows; ++row) {
      std::copy_n(image.pixels + row * image.stride, image.columns,
                  positive_.data() + static_cast<std::ptrdiff_t>(row) * image.columns);
    }
  }
  if (!decoder_->add_frame(kept, pattern)) {
    return false;
  }
  if (median_) {
    median_->filter(decoder_->codes(), codes_.data());
  } else {
    structured_light::code_words(decoder_->codes(), codes_.data());
  }
  return true;
}

void SoftwareBoard::send_codes(model::PacketHeader header) {
  header.kind = spec::kKindCodes;
  header.lines = 1;
  const std::size_t bytes = model::codes_line_payload_bytes(settings_.columns);
  std::fill(payload_.begin(), payload_.end(), std::uint8_t{0});
  for (int row = 0; row < settings_.rows; ++row) {
    header.first_line = static_cast<std::uint16_t>(row + 1);
    model::pack_codes(settings_.columns, codes_.data() + static_cast<std::ptrdiff_t>(row) * settings_.columns,
                      payload_.data());
    send(header, bytes, 0);
  }
}

}  // namespace selfproj::camera
