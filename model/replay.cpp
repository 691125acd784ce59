#include "model/replay.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>

#include "selfproj/model/little_endian.h"

namespace selfproj::model {
namespace {

constexpr std::uint32_t kHalfRange = 0x8000'0000U;

// The header of a datagram whose magic number and length are right.
std::optional<ReplayHeader> header_of(const ReplayModel::Datagram& datagram) {
  if (datagram.came.size() < spec::kReplayHeaderBytes) {
    return std::nullopt;
  }
  const std::uint8_t* const bytes = datagram.came.data();
  const ReplayHeader header{.session = load_little_endian<std::uint16_t>(bytes + spec::kReplaySession),
                            .frame = load_little_endian<std::uint32_t>(bytes + spec::kReplayFrame),
                            .offset = load_little_endian<std::uint32_t>(bytes + spec::kReplayOffset),
                            .length = load_little_endian<std::uint16_t>(bytes + spec::kReplayLength),
                            .columns = load_little_endian<std::uint16_t>(bytes + spec::kReplayColumns),
                            .rows = load_little_endian<std::uint16_t>(bytes + spec::kReplayRows)};
  if (load_little_endian<std::uint16_t>(bytes + spec::kReplayMagicAt) != spec::kReplayMagic ||
      datagram.bytes != spec::kReplayHeaderBytes + header.length) {
    return std::nullopt;
  }
  return header;
}

}  // namespace

void write_replay_header(const ReplayHeader& header, std::uint8_t* bytes) {
  store_little_endian(bytes + spec::kReplayMagicAt, spec::kReplayMagic);
  store_little_endian(bytes + spec::kReplaySession, header.session);
  store_little_endian(bytes + spec::kReplayFrame, header.frame);
  store_little_endian(bytes + spec::kReplayOffset, header.offset);
  store_little_endian(bytes + spec::kReplayLength, header.length);
  store_little_endian(bytes + spec::kReplayColumns, header.columns);
  store_little_endian(bytes + spec::kReplayRows, header.rows);
  store_little_endian(bytes + spec::kReplayReserved, std::uint16_t{0});
}

void ReplayModel::begin(std::uint16_t session) {
  session_ = session;
  frame_ = 0;
  forget();
}

bool ReplayModel::fits(const ReplayHeader& header) const {
  const bool size = header.columns != 0 && header.columns % spec::kPixelsPerBeat == 0 &&
                    header.columns <= size_.columns && header.rows != 0 && header.rows <= size_.rows;
  const std::uint64_t end = std::uint64_t{header.offset} + header.length;
  return size && header.length != 0 && header.length % spec::kPixelsPerBeat == 0 &&
         header.offset % spec::kPixelsPerBeat == 0 && end <= std::uint64_t{header.columns} * header.rows;
}

std::optional<ReplayFrame> ReplayModel::datagram(const Datagram& datagram) {
  const std::optional<ReplayHeader> header = header_of(datagram);
  const std::uint32_t ahead = header ? header->frame - frame_ : 0;
  const bool begins = header && header->offset == 0 && ahead < kHalfRange && (pixels_.empty() || ahead != 0);
  const bool goes_on = header && !pixels_.empty() && ahead == 0 && header->offset == pixels_.size() &&
                       header->columns == columns_ && header->rows == rows_;
  const bool checked =
      datagram.may_send && !leaving_ && header && header->session == session_ && fits(*header) && (begins || goes_on);
  const auto piece = datagram.came.subspan(header ? spec::kReplayHeaderBytes : datagram.came.size());
  if (checked && begins && !piece.empty()) {  // the place of what came before is needed, whatever follows the header
    pixels_.clear();
  }
  if (!checked || datagram.damaged || piece.size() < header->length) {
    ++ignored_;
    return std::nullopt;
  }
  dropped_ += ahead;
  frame_ = header->frame;
  columns_ = header->columns;
  rows_ = header->rows;
  pixels_.insert(pixels_.end(), piece.begin(), piece.begin() + header->length);
  if (pixels_.size() < static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_)) {
    return std::nullopt;
  }
  leaving_ = true;
  ++frame_;
  return ReplayFrame{.columns = columns_, .rows = rows_, .pixels = std::exchange(pixels_, {})};
}

void ReplayModel::left() {
  leaving_ = false;
  ++frames_;
}

ReplayCounts ReplayModel::counts() const {
  return {.frame = frame_,
          .offset = static_cast<std::uint32_t>(pixels_.size()),
          .frames = frames_,
          .dropped = dropped_,
          .ignored = ignored_};
}

}  // namespace selfproj::model
