#ifndef SELFPROJ_TESTS_HOST_DRIVER_DATAGRAM_ACCOUNTS_H
#define SELFPROJ_TESTS_HOST_DRIVER_DATAGRAM_ACCOUNTS_H

#include <gtest/gtest.h>

#include <cstdint>
#include <span>
#include <string>

#include "host/driver/datagram_assembler.h"
#include "model/datagram.h"
#include "tests/host/driver/packets.h"

namespace selfproj::test {

// Sends `count` packets of one datagram each through the assembler, from these numbers on. Every 1009th is lost, every
// 499th doubled, and every 251st overtaken by the next. Expects that each packet is delivered or counted as lost, and
// nothing else is counted. Returns the assembler's counters.
inline driver::Counters expect_all_accounted(std::uint32_t datagrams, std::uint32_t packets, std::uint64_t count) {
  SCOPED_TRACE("from datagram " + std::to_string(datagrams) + ", packet " + std::to_string(packets));
  driver::Counters counters;
  driver::DatagramAssembler assembler(counters);
  model::DatagramCutter cutter(5, model::kDatagramBytes, datagrams, packets);
  const Bytes bytes = moments_packet(1, 16);
  Bytes overtaken;
  model::PacketView packet;
  std::uint64_t delivered = 0;
  const auto drain = [&] {
    while (assembler.next(packet)) {
      ++delivered;
    }
  };
  const auto add = [&](std::span<const std::uint8_t> datagram) {
    do {
      drain();
    } while (!assembler.add(datagram));
  };
  std::uint64_t i = 0;
  const auto network = [&](std::span<const std::uint8_t> datagram) {
    if (i % 1009 == 1008) {
      return;
    }
    if (i % 251 == 250) {
      overtaken.assign(datagram.begin(), datagram.end());
      return;
    }
    add(datagram);
    if (i % 499 == 498) {
      add(datagram);
    }
    if (!overtaken.empty()) {
      add(overtaken);
      overtaken.clear();
    }
  };
  constexpr std::uint64_t kMostDeaf = 1U << 20U;  // packets; then it is told at once, not after hours
  for (; i < count && i <= delivered + counters.lost_network + kMostDeaf; ++i) {
    cutter.packet(bytes, network);
  }
  for (i = 0; i < 3; ++i) {
    cutter.idle(network);
  }
  drain();
  assembler.flush();
  drain();
  EXPECT_EQ(counters.lost_network, count / 1009);
  EXPECT_EQ(counters.datagrams_lost, count / 1009);
  EXPECT_EQ(delivered + counters.lost_network, count);
  EXPECT_EQ(counters.datagrams_refused + counters.bad + counters.reattached, 0U);
  return counters;
}

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_HOST_DRIVER_DATAGRAM_ACCOUNTS_H
