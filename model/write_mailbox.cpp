#include "model/write_mailbox.h"

#include <cstdint>
#include <utility>

#include "model/register_file.h"
#include "model/spec/generated/register_table.h"

namespace selfproj {
namespace {

constexpr std::uint32_t kAddressMask = (1U << spec::kLinkAddressBytesBits) - 1;

}  // namespace

WriteMailbox::WriteMailbox(Access board, std::uint32_t ticket)
    : board_(std::move(board)), performed_{.ticket = ticket} {}

RegisterAnswer WriteMailbox::read(std::uint32_t address) {
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
        refused_ = board_(true, asked_.address, data).error;
      }
      return {};
    default:
      return address < spec::kLinkId ? board_(true, address, data) : RegisterAnswer{.error = true};
  }
}

}  // namespace selfproj
