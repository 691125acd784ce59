#include "model/write_mailbox.h"

#include <cstdint>
#include <utility>

#include "model/register_file.h"
#include "model/spec/generated/register_table.h"

namespace selfproj::model {
namespace {

constexpr std::uint32_t kAddressMask = (1U << spec::kLinkAddressBytesBits) - 1;

}  // namespace

WriteMailbox::WriteMailbox(Access board, std::uint32_t ticket, const VideoBuild& video, ReplayModel* replay)
    : board_(std::move(board)), video_(video), replay_(replay), performed_{.ticket = ticket} {}

RegisterAnswer WriteMailbox::read(std::uint32_t address) {
  const ReplayCounts counts = replay_ != nullptr ? replay_->counts() : ReplayCounts{};
  switch (address) {
    case spec::kLinkId:
      return {.data = spec::kLinkIdReset};
    case spec::kLinkTicket:
      return {.data = performed_.ticket};
    case spec::kLinkAddress:
      return {.data = performed_.address};
    case spec::kLinkValue:
      return {.data = performed_.value};
    case spec::kLinkAnswer:
      return {.data = std::uint32_t{refused_} << spec::kLinkAnswerRefusedLsb};
    case spec::kLinkSource:
      return {.data = source_};
    case spec::kLinkReplaySession:
      return {.data = session_};
    case spec::kLinkVideo:
      return {.data = video_.sources << spec::kLinkVideoSourcesLsb |
                      static_cast<std::uint32_t>(video_.replay.rows) << spec::kLinkVideoReplayRowsLsb |
                      static_cast<std::uint32_t>(video_.replay.columns) << spec::kLinkVideoReplayColumnsLsb};
    case spec::kLinkReplayFrame:
      return {.data = counts.frame};
    case spec::kLinkReplayOffset:
      return {.data = counts.offset};
    case spec::kLinkReplayFrames:
      return {.data = counts.frames};
    case spec::kLinkReplayDropped:
      return {.data = counts.dropped};
    case spec::kLinkReplayIgnored:
      return {.data = counts.ignored};
    default:
      return address < spec::kLinkId ? board_(false, address, 0) : RegisterAnswer{.error = true};
  }
}

RegisterAnswer WriteMailbox::write(std::uint32_t address, std::uint32_t data) {
  switch (address) {
    case spec::kLinkTicket:
      asked_.ticket = data;
      return {};
    case spec::kLinkAddress:
      asked_.address = data & kAddressMask;
      return {};
    case spec::kLinkValue:
      if (asked_.ticket == performed_.ticket + 1) {
        performed_ = {.ticket = asked_.ticket, .address = asked_.address, .value = data};
        refused_ = refuses(asked_.address, data);
      }
      return {};
    default:
      return address < spec::kLinkId ? board_(true, address, data) : RegisterAnswer{.error = true};
  }
}

bool WriteMailbox::refuses(std::uint32_t address, std::uint32_t data) {
  constexpr std::uint32_t kSourceMask = (1U << spec::kLinkSourceVideoBits) - 1;
  constexpr std::uint32_t kSessionMask = (1U << spec::kLinkReplaySessionNumberBits) - 1;
  if (address < spec::kLinkId) {
    return board_(true, address, data).error;
  }
  if (address == spec::kLinkSource && data <= kSourceMask && (video_.sources >> data & 1U) != 0) {
    source_ = data;
    return false;
  }
  if (address == spec::kLinkReplaySession && data <= kSessionMask && video_.replay.columns != 0) {
    session_ = data;
    if (replay_ != nullptr) {
      replay_->begin(static_cast<std::uint16_t>(data));
    }
    return false;
  }
  return true;
}

}  // namespace selfproj::model
