#include "selfproj/model/board.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "selfproj/model/median3x3.h"

namespace selfproj::model {

void BoardModel::beat(const BoardInputs& inputs, const VideoBeat& beat) {
  idle(inputs.clock - 1);
  last_beat_ = inputs.clock;
  timeout_ = written_.timeout;

  if (beat.start) {
    if (open_) {
      end_frame(spec::kStatusStartInFrame);
    }
    if (!written_.run) {
      return;
    }
    if (taken_ || !written_.hold) {
      start_frame(inputs);
    }
  }
  if (!open_) {
    if (written_.run) {
      ++stray_;
      stray_seen_ = true;
    }
    return;
  }

  const auto at = static_cast<std::size_t>(row_) * static_cast<std::size_t>(settings_.columns);
  const int below = pixel_bits_ - spec::kPixelBits;
  const std::ptrdiff_t place = static_cast<std::ptrdiff_t>(at) + column_;
  std::uint8_t* const upper = pixels_.data() + place;  // bits
  std::transform(beat.pixels.begin(), beat.pixels.begin() + lanes_, upper,
                 [&](std::uint16_t p) { return static_cast<std::uint8_t>(p >> below); });
  if (below > 0) {
    std::copy_n(beat.pixels.begin(), lanes_, wide_pixels_.begin() + place);
  }
  last_frame_beat_ = inputs.clock;
  ++frame_beats_;
  if (settings_.codes) {
    decoder_.pixels(row_, column_, lanes_, upper,
                    due_ ? codes_.data() + at + static_cast<std::size_t>(column_) : nullptr);
  }
  column_ += lanes_;

  const bool complete = column_ == settings_.columns;
  if (beat.line_end && !complete) {
    end_frame(spec::kStatusShortLine);
  } else if (!beat.line_end && complete) {
    end_frame(spec::kStatusLongLine);
  } else if (complete) {
    end_line(0);
    ++row_;
    column_ = 0;
    if (row_ == settings_.rows) {
      end_frame(0);
    }
  }
}

void BoardModel::idle(std::uint64_t clock) {
  if (broken_passes_ && clock >= inputs_.clock + kSeenDistance) {
    pass_broken();
  }
  if (open_ && timeout_ != 0 && clock > last_beat_ + static_cast<std::uint64_t>(timeout_)) {
    end_frame(spec::kStatusIncomplete);
  }
}

void BoardModel::start_frame(const BoardInputs& inputs) {
  if (broken_passes_ && inputs.clock >= inputs_.clock + kSeenDistance) {
    pass_broken();
  }
  broken_passes_ = false;
  if (!written_.hold && (!taken_ || inputs.clock >= last_take_ + kTakeDistance)) {
    settings_ = written_;
    last_take_ = inputs.clock;
    taken_ = true;
  }
  open_ = true;
  at_start_ = written_;
  inputs_ = inputs;
  stray_before_ = std::exchange(stray_seen_, false);
  row_ = 0;
  column_ = 0;
  pixels_.assign(static_cast<std::size_t>(settings_.rows) * static_cast<std::size_t>(settings_.columns), 0);
  if (pixel_bits_ > spec::kPixelBits) {
    wide_pixels_.assign(pixels_.size(), 0);
  }
  ++next_sequence_;
  start_decoding(inputs.clock);
}

Measure BoardModel::measure() const {
  Measure measure = settings_.measure();
  measure.bits = pixel_bits_;
  return measure;
}

PacketHeader BoardModel::header(std::uint8_t kind) const {
  PacketHeader header;
  header.kind = kind;
  header.stream = static_cast<std::uint8_t>(settings_.stream);
  header.region_row = static_cast<std::uint16_t>(settings_.region_row);
  header.region_column = static_cast<std::uint16_t>(settings_.region_column);
  header.sequence = next_sequence_ - 1;
  header.time_stamp = inputs_.clock;
  header.encoder = inputs_.encoder;
  header.pattern = inputs_.pattern;
  describe_frame(header, settings_.rows, settings_.columns, measure());
  header.tall = tall_;
  header.flags = stray_before_ ? spec::kFlagStrayBefore : 0;
  return header;
}

void BoardModel::start_decoding(std::uint64_t clock) {
  const bool close = frame_beats_ != 0 && frame_beats_ < kDecodeDistance && clock < last_frame_beat_ + kDecodeDistance;
  frame_beats_ = 0;
  due_ = false;
  if (!settings_.codes) {
    decoder_.restart();
    return;
  }
  decoder_.configure({.rows = settings_.rows,
                      .columns = settings_.columns,
                      .bits = settings_.code_bits,
                      .threshold = settings_.code_threshold});
  if (close) {
    decoder_.restart();
  }
  due_ = decoder_.begin(inputs_.pattern);
  const bool busy = median_built_ && due_ && last_codes_columns_ >= 0 &&
                    clock <= last_codes_ + kMedianClocks + static_cast<std::uint64_t>(last_codes_columns_ / lanes_) +
                                 median_pause(lanes_, last_codes_columns_);
  if (busy) {
    decoder_.end(false);
    due_ = false;
  }
  abandoned_ += close || busy ? 1U : 0U;
  if (due_) {
    last_codes_columns_ = -1;
    codes_.assign(pixels_.size(), 0);
  }
}

// The packet of a line of codes, of which the first `columns` are known; the rest are zeros.
void BoardModel::send_codes(int row, int columns, std::uint32_t status) {
  const auto line_size = static_cast<std::size_t>(settings_.columns);
  const auto first = static_cast<std::size_t>(std::max(row - 1, 0));  // of the lines that count
  const int lines = std::min(row + 2, settings_.rows) - static_cast<int>(first);
  std::vector<std::uint16_t> out(codes_.begin() + static_cast<std::ptrdiff_t>(first * line_size),
                                 codes_.begin() + static_cast<std::ptrdiff_t>(first * line_size) +
                                     static_cast<std::ptrdiff_t>(lines) * settings_.columns);
  if (settings_.median) {
    const std::vector<std::uint16_t> raw = out;
    median3x3(raw.data(), lines, settings_.columns, out.data());
  }
  const std::uint16_t* line = out.data() + (static_cast<std::size_t>(row) - first) * line_size;
  BoardPacket packet{.header = header(spec::kKindCodes), .payload = {}, .status = status};
  packet.header.first_line = static_cast<std::uint16_t>(row + 1);
  packet.header.lines = 1;
  packet.payload.resize(codes_line_payload_bytes(settings_.columns));
  packet.header.payload_size = static_cast<std::uint32_t>(packet.payload.size());
  pack_codes(columns, line, packet.payload.data());
  sink_(std::move(packet));
}

// A line of codes. If the median is built, this is the line before the one that ended. If the latter broke, only those
// pixels are sent whose right neighbours have come.
void BoardModel::end_code_line(std::uint32_t status) {
  if (!due_) {
    return;
  }
  if (!median_built_) {
    send_codes(row_, column_, status);
    return;
  }
  const int columns = status == 0 ? column_ : column_ - lanes_;
  if (row_ > 0 && columns > 0) {
    send_codes(row_ - 1, columns, status);
  }
  if (status == 0 && row_ == settings_.rows - 1) {
    send_codes(row_, column_, 0);
  }
}

// A line of the raw image; a broken line is filled up with zeros.
void BoardModel::end_line(std::uint32_t status) {
  end_code_line(status);
  if (!settings_.image) {
    return;
  }
  BoardPacket packet{.header = header(spec::kKindImage), .payload = {}, .status = status};
  packet.header.first_line = static_cast<std::uint16_t>(row_ + 1);
  packet.header.lines = 1;
  packet.payload.resize(image_line_payload_bytes(settings_.columns));
  packet.header.payload_size = static_cast<std::uint32_t>(packet.payload.size());
  const auto first = pixels_.begin() + static_cast<std::ptrdiff_t>(row_) * settings_.columns;
  std::copy_n(first, column_, packet.payload.begin());
  sink_(std::move(packet));
}

// The moments. A frame that broke before its last row gives an empty packet. One that broke in its last row keeps the
// complete columns, followed by zeros.
void BoardModel::end_frame(std::uint32_t status) {
  open_ = false;
  if (status != 0) {
    ++broken_;
    if (column_ != 0) {
      end_line(status);
    }
  } else if (due_) {
    last_codes_ = last_frame_beat_;
    last_codes_columns_ = settings_.columns;
  }
  decoder_.end(status == 0);
  due_ = false;
  const int packets = settings_.verdict ? settings_.verdict_packets : 0;
  BoardPacket packet{
      .header = header(packets == 2 ? spec::kKindVerdict : kind_of_columns(settings_.compact, settings_.mode)),
      .payload = {},
      .status = status};
  if (packets == 1) {
    packet.header.flags |= spec::kFlagVerdict;
  }
  const bool in_last_row = row_ == settings_.rows || (row_ == settings_.rows - 1 && column_ != 0);
  if (in_last_row) {
    const int complete = row_ == settings_.rows ? settings_.columns : column_;
    Runs runs;
    runs.resize(settings_.select, settings_.columns);
    const RunsView view = runs.view();
    const auto measure_image = [&]<typename Pixel>(const std::vector<Pixel>& pixels) {  // what did not come is 0
      measure_columns(PixelView<Pixel>{pixels.data(), settings_.rows, complete, settings_.columns}, measure(), view);
    };
    if (pixel_bits_ > spec::kPixelBits) {
      measure_image(wide_pixels_);
    } else {
      measure_image(pixels_);
    }
    packet.payload.resize(frame_payload_bytes(packet.header));
    if (has_columns(packet.header.kind)) {
      pack_columns(packet.header, view, packet.payload.data());
    }
    judge(view, complete, packet);
  } else {
    broken_passes_ = true;
    if (!settings_.verdict) {
      pass_broken();
    }
  }
  packet.header.payload_size = static_cast<std::uint32_t>(packet.payload.size());
  sink_(std::move(packet));
}

// Tells the verdict of a frame that broke before its last row.
void BoardModel::pass_broken() {
  broken_passes_ = false;
  BoardPacket none;
  judge({}, 0, none);
}

// Judges the frame by its first `complete` columns. Only a good frame's packet has the verdict.
void BoardModel::judge(const RunsView& columns, int complete, BoardPacket& packet) {
  if (verdict_ == nullptr) {
    return;
  }
  if (!settings_.verdict) {
    verdict_->stop();
    return;
  }
  const auto count = static_cast<std::size_t>(complete);
  const FrameVerdict found =
      verdict_->frame(at_start_.verdict_settings, at_start_.verdict_hold, at_start_.part_rule, inputs_.encoder,
                      {columns.moments.m0, count}, {columns.moments.m1, count}, complete == settings_.columns);
  if (packet.status == 0 && has_verdict(packet.header)) {
    pack_verdict(found, packet.payload.data() + packet.payload.size() - spec::kVerdictWordBits / 8);
  }
}

void append_moments_packet(const ImageView& image, const Measure& measure, PacketHeader header,
                           std::vector<std::uint8_t>& out) {
  Runs runs;
  runs.resize(measure.select, image.columns);
  measure_columns(image, measure, runs.view());
  header.kind = kind_of_columns(header.kind == spec::kKindCompact, measure.mode);
  describe_frame(header, image.rows, image.columns, measure);
  header.flags &= static_cast<std::uint8_t>(~spec::kFlagVerdict);
  std::vector<std::uint8_t> payload(columns_payload_bytes(header));
  pack_columns(header, runs.view(), payload.data());
  append_packet(header, payload, 0, out);
}

}  // namespace selfproj::model
