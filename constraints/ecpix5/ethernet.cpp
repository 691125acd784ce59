#include "constraints/ecpix5/ethernet.h"

#include <fcntl.h>
#include <linux/if.h>
#include <linux/if_tun.h>
#include <sys/ioctl.h>
#include <sys/types.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>

namespace selfproj::sim {
namespace {

constexpr std::size_t kShortest = 60;
constexpr std::size_t kCheckBytes = 4;
constexpr std::size_t kPreamble = 8;  // its last byte begins the frame
constexpr std::uint8_t kBegin = 0xD5;
constexpr int kGap = 12;

}  // namespace

std::uint32_t ethernet_check(std::span<const std::uint8_t> bytes) {
  return static_cast<std::uint32_t>(crc32_z(0, bytes.data(), bytes.size()));
}

void RgmiiSender::send(const EthernetFrame& frame, bool damaged) {
  EthernetFrame wire(kPreamble + std::max(frame.size(), kShortest));
  std::fill_n(wire.begin(), kPreamble - 1, 0x55);
  wire[kPreamble - 1] = kBegin;
  std::copy(frame.begin(), frame.end(), wire.begin() + kPreamble);
  const std::uint32_t check = ethernet_check(std::span(wire).subspan(kPreamble));
  for (unsigned shift = 0; shift < 32; shift += 8) {
    wire.push_back(static_cast<std::uint8_t>(check >> shift));
  }
  if (damaged) {
    wire[wire.size() - kCheckBytes - 1] ^= 0x10U;
  }
  frames_.push_back(std::move(wire));
}

RgmiiSender::Pins RgmiiSender::rising() {
  high_ = {};
  if (gap_ > 0) {
    --gap_;
    return {};
  }
  if (frames_.empty()) {
    return {};
  }
  const std::uint8_t byte = frames_.front()[at_++];
  if (at_ == frames_.front().size()) {
    frames_.pop_front();
    at_ = 0;
    gap_ = kGap;
  }
  high_ = {true, static_cast<std::uint8_t>(byte >> 4U)};
  return {true, static_cast<std::uint8_t>(byte & 15U)};
}

RgmiiSender::Pins RgmiiSender::falling() { return high_; }

void RgmiiReceiver::rising(bool control, std::uint8_t data) {
  control_ = control;
  low_ = data;
}

std::optional<EthernetFrame> RgmiiReceiver::falling(std::uint8_t data) {
  if (control_) {
    bytes_.push_back(static_cast<std::uint8_t>(low_ | data << 4U));
    return std::nullopt;
  }
  if (bytes_.empty()) {
    return std::nullopt;
  }
  const auto begin = std::find(bytes_.begin(), bytes_.end(), kBegin);
  EthernetFrame frame(begin == bytes_.end() ? begin : begin + 1, bytes_.end());
  bytes_.clear();
  if (frame.size() < kShortest + kCheckBytes || ethernet_check(frame) != 0x2144'DF1CU) {
    ++damaged_;
    return std::nullopt;
  }
  frame.resize(frame.size() - kCheckBytes);
  return frame;
}

Tap::Tap(const std::string& name) : file_(open("/dev/net/tun", O_RDWR | O_NONBLOCK | O_CLOEXEC)) {
  ifreq request{};
  request.ifr_flags = IFF_TAP | IFF_NO_PI;
  std::copy_n(name.begin(), std::min<std::size_t>(name.size(), IFNAMSIZ - 1), request.ifr_name);
  if (file_ < 0 || ioctl(file_, TUNSETIFF, &request) != 0) {
    const std::string reason = std::strerror(errno);
    if (file_ >= 0) {
      close(file_);
    }
    throw std::runtime_error(name + ": " + reason);
  }
}

Tap::~Tap() { close(file_); }

std::optional<EthernetFrame> Tap::receive() {
  std::array<std::uint8_t, 9216> bytes{};
  const ssize_t size = read(file_, bytes.data(), bytes.size());
  return size > 0 ? std::optional(EthernetFrame(bytes.begin(), bytes.begin() + size)) : std::nullopt;
}

bool Tap::send(const EthernetFrame& frame) {
  return write(file_, frame.data(), frame.size()) == static_cast<ssize_t>(frame.size());
}

}  // namespace selfproj::sim
