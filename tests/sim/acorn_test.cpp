// Tests what the FPGA of an Acorn has beside LitePCIe, together with the host's device and registers for LitePCIe:
// every packet against the models, and every loss counted.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>

#include "host/driver/control.h"
#include "host/driver/counters.h"
#include "host/driver/device.h"
#include "host/driver/litepcie.h"
#include "model/packet.h"
#include "sim/target/camera_judge.h"
#include "tests/sim/acorn_bench.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

constexpr const char* kUri = "litepcie:bench";

// The host of a board on the bench.
class Host {
 public:
  explicit Host(std::uint64_t seed)
      : bench_(seed), control_(make_litepcie_port(std::make_unique<LitePciePlayerPort>(bench_.player()), kUri)) {
    control_.write_together({{register_part("size.columns"), AcornBench::kColumns},
                             {register_part("size.rows"), AcornBench::kRows},
                             {register_part("measure.mode"), 2},
                             {register_part("measure.threshold"), 100}});
  }

  AcornBench& bench() { return bench_; }
  Counters counters() const { return device_->counters(); }
  std::uint64_t newest_frame() const { return newest_frame_; }
  int of_newest_frame() const { return of_newest_frame_; }  // packets
  std::uint64_t of(const char* name) { return control_.read(name); }
  // Packets that the board says it has made and not lost.
  std::uint64_t sent() { return packets_ + packets_of_run() - of("lost_moments") - of("lost_image"); }

  void open() {
    device_ = make_litepcie_device(std::make_unique<LitePciePlayerPort>(bench_.player()), kUri, {});
    judge_.emplace(AcornBench::kColumns, AcornBench::kRows, AcornBench::kFrameClocks);
  }
  void close() { device_.reset(); }

  void start(bool image) {
    packets_ += packets_of_run();
    frames_ = of("frames");
    image_ = image;
    judge_.emplace(AcornBench::kColumns, AcornBench::kRows, AcornBench::kFrameClocks);
    control_.write("control.image", image ? 1 : 0);
    control_.write("control.run", 1);
  }
  // And waits for much longer than the FPGA takes to see that nothing follows.
  void stop() {
    control_.write("control.run", 0);
    run(10);
  }

  // Reads every 1000 clocks.
  void run(int times) {
    for (int i = 0; i < times; ++i) {
      bench_.run(1000);
      if (device_) {
        read();
      }
    }
  }

  // Each packet must be the models'.
  void read() {
    PacketView packet;
    while (device_->next(packet, std::chrono::nanoseconds(0)) == Next::packet) {
      ASSERT_TRUE(judge_->judge(packet)) << "frame " << packet.header.sequence << ", kind " << int{packet.header.kind};
      of_newest_frame_ = packet.header.sequence == newest_frame_ ? of_newest_frame_ + 1 : 1;
      newest_frame_ = packet.header.sequence;
    }
  }

 private:
  std::uint64_t packets_of_run() { return (of("frames") - frames_) * (image_ ? 1 + AcornBench::kRows : 1); }

  AcornBench bench_;
  Control control_;
  std::optional<CameraJudge> judge_;
  std::unique_ptr<Device> device_;
  std::uint64_t newest_frame_ = 0;
  int of_newest_frame_ = 0;
  std::uint64_t packets_ = 0;  // of earlier runs
  std::uint64_t frames_ = 0;   // before this run
  bool image_ = false;
};

TEST(Acorn, EveryPacketAndNoneStaysBehind) {
  for (const std::uint64_t seed : seeds(3)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Host host(seed);
    host.open();
    for (const int frames : {1, 2, 300}) {
      for (const bool image : {false, true}) {
        host.bench().set_ready(image ? 60 : 100);
        host.start(image);
        host.run(frames * static_cast<int>(AcornBench::kFrameClocks) / 1000 + 1);
        host.stop();
        EXPECT_EQ(host.counters().delivered, host.sent());
      }
    }
    Counters want;
    want.delivered = host.sent();
    EXPECT_EQ(host.counters(), want);
    EXPECT_GT(want.delivered, 5000U);
  }
}

TEST(Acorn, WhatTheBoardLosesIsCounted) {
  Host host(1);
  host.open();
  host.bench().set_ready(20);  // too seldom for raw images
  host.start(true);
  host.run(100);
  host.bench().set_ready(100);
  host.run(10);
  host.stop();
  const Counters counters = host.counters();
  EXPECT_GT(counters.lost_board, 0U);
  EXPECT_EQ(counters.lost_board, host.of("lost_moments") + host.of("lost_image"));
  EXPECT_EQ(counters.delivered, host.sent());
  EXPECT_EQ(counters.bad + counters.bytes_discarded + counters.read_errors, 0U);
}

// Zeros only behind the last packet of a burst: the camera's frames follow each other within IdleClocks.
TEST(Acorn, NoZerosWhilePacketsFollow) {
  Host host(1);
  host.open();
  host.start(false);
  host.run(100);
  host.stop();
  const std::uint64_t bytes = host.counters().delivered * packet_bytes(8 * AcornBench::kColumns);
  EXPECT_GT(bytes, 10U * 8192);
  EXPECT_LE(host.bench().player().finished(), bytes / 8192 + 2);
}

// Whenever the DMA starts, its first byte is that of a packet, and none stays behind.
TEST(Acorn, TheDmaStartsAnewInTheMiddle) {
  Host host(1);
  Random random(1);
  host.start(true);
  for (int i = 0; i < 40; ++i) {
    host.open();
    host.run(random.between(4, 12));  // two buffers take less than 3000 clocks
    EXPECT_GT(host.counters().delivered, 0U);
    EXPECT_EQ(host.counters().bytes_discarded, 0U);
    EXPECT_EQ(host.counters().bad, 0U);
    if (i % 2 == 1) {
      host.stop();
      EXPECT_EQ(host.newest_frame() + 1, host.of("frames"));
      EXPECT_EQ(host.of_newest_frame(), 1 + AcornBench::kRows);
      host.start(true);
    }
    host.close();
    host.bench().run(static_cast<std::uint64_t>(random.between(1, 700)));
  }
}

TEST(Acorn, AHostThatIsTooSlow) {
  Host host(1);
  host.open();
  host.start(true);
  host.run(20);
  while (host.bench().player().finished() < 400) {  // once round, and more
    host.bench().run(1000);
  }
  host.run(20);
  host.stop();
  const Counters counters = host.counters();
  EXPECT_EQ(counters.read_errors, 1U);
  EXPECT_EQ(counters.resynchronized, 1U);
  EXPECT_EQ(counters.lost_board, 0U);
  EXPECT_GT(counters.missing, 0U);
  EXPECT_LT(counters.delivered, host.sent());
}

}  // namespace
}  // namespace selfproj::test
