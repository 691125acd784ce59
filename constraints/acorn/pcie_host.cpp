#include "constraints/acorn/pcie_host.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

namespace selfproj::sim {
namespace {

// The first word of a packet: format and type
constexpr std::uint32_t kRead = 0x00;
constexpr std::uint32_t kWrite = 0x40;
constexpr std::uint32_t kCompletion = 0x4A;
constexpr std::uint32_t kRequester = 0x0008;  // the host
constexpr std::uint32_t kAllBytes = 0xF;
constexpr std::size_t kHeaderWords = 3;

// The first byte of a word of data is its highest.
constexpr std::uint32_t swapped(std::uint32_t word) { return __builtin_bswap32(word); }

}  // namespace

void PcieHost::write(std::uint32_t address, std::uint32_t value) {
  accesses_.push_back({.read = false, .address = address, .value = value});
}

void PcieHost::read(std::uint32_t address) {
  answer_.reset();
  accesses_.push_back({.read = true, .address = address, .value = 0});
}

std::optional<std::uint32_t> PcieHost::pop_answer() { return std::exchange(answer_, std::nullopt); }

PcieHost::To PcieHost::clock(const From& from) {
  interrupts_ += from.interrupt ? 1 : 0;
  if (from.taken) {
    for (std::size_t i = 0; i < from.beat.size(); ++i) {
      if ((from.keep >> (4 * i) & 0xFU) != 0) {
        words_.push_back(from.beat[i]);
      }
    }
    if (from.last) {
      receive(words_);
      words_.clear();
    }
  }
  if (from.given && !accesses_.empty()) {
    accesses_.pop_front();
  }
  To to{.ready = ready_(random_)};
  if (!accesses_.empty()) {
    const Access& next = accesses_.front();
    to.valid = true;
    to.read = next.read;
    to.beat = {(next.read ? kRead : kWrite) << 24U | 1U, kRequester << 16U | kAllBytes, next.address,
               swapped(next.value)};
  }
  return to;
}

void PcieHost::receive(const std::vector<std::uint32_t>& words) {
  const std::uint32_t kind = words.empty() ? 0 : words[0] >> 24U;
  const std::size_t length = words.empty() ? 0 : words[0] & 0x3FFU;
  const bool whole = words.size() == kHeaderWords + length;
  if (kind == kCompletion && whole && length == 1 && words[2] >> 16U == kRequester) {
    answer_ = swapped(words[kHeaderWords]);
  } else if (kind == kWrite && whole && length > 0) {
    store(words);
  } else {
    ++strangers_;
  }
}

void PcieHost::store(const std::vector<std::uint32_t>& words) {
  const std::size_t bytes = 4 * (words.size() - kHeaderWords);
  const std::size_t at = words[2] - kMemory;
  const bool crosses = words[2] / 4096 != (words[2] + bytes - 1) / 4096;  // which PCI Express forbids
  if (words[2] % 4 != 0 || at > memory_.size() || bytes > memory_.size() - at || crosses || bytes > 256) {
    ++strangers_;
    return;
  }
  ++writes_;
  for (std::size_t i = 0; i < bytes; ++i) {
    memory_[at + i] = static_cast<std::uint8_t>(words[kHeaderWords + i / 4] >> (24 - 8 * (i % 4)));
  }
}

}  // namespace selfproj::sim
