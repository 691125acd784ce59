#include <fmt/format.h>
#include <sys/prctl.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <ctime>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "host/cli/command_line.h"
#include "host/cli/progress.h"
#include "host/driver/clock.h"
#include "host/driver/ring_memory.h"
#include "host/driver/ring_writer.h"
#include "host/files/output_file.h"
#include "host/files/stop_signal.h"
#include "selfproj/files/user_error.h"
#include "selfproj/model/packet.h"
#include "selfproj/model/pixel_clock.h"
#include "sim/app/board_source.h"
#include "sim/app/commands.h"
#include "sim/board/etherbone_board.h"
#include "sim/board/packet_recording.h"
#include "sim/board/sensor_board.h"
#include "sim/board/udp_sender.h"

namespace selfproj::sim {
namespace {

constexpr double kDefaultRate = 10000;
constexpr std::int64_t kSecondNs = 1'000'000'000;

struct BoardOptions {
  BoardSource source;
  std::string ring;
  std::string udp;
  std::string from;  // empty: any address and port
  bool jumbo = false;
  std::string control;
  std::string record;
  double rate = kDefaultRate;
  double pixel_clock_hz = model::kDefaultPixelClockHz;
  std::uint64_t count = 0;
  double seconds = 0;
  bool loop = false;
  std::optional<std::uint32_t> slots;  // empty: RingWriter::deep_slots()
  bool wait_for_reader = false;
  bool keep = false;
};

void sleep_until(std::int64_t time_ns) {
  const timespec until{static_cast<std::time_t>(time_ns / kSecondNs), static_cast<long>(time_ns % kSecondNs)};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR && !files::StopSignal::came()) {
  }
}

// The clock of the new time stamps.
double clocks_per_frame(const BoardOptions& options) {
  return options.pixel_clock_hz / (options.rate > 0 ? options.rate : kDefaultRate);
}

// How many frames the options ask for; the largest number if it is endless, 0 for those of the source once.
std::uint64_t frames_wanted(const BoardOptions& options) {
  if (options.count > 0) {
    return options.count;
  }
  return options.loop || options.seconds > 0 ? std::numeric_limits<std::uint64_t>::max() : 0;
}

template <class Source>
std::uint64_t frames_to_play(const BoardOptions& options, const Source& source) {
  const std::uint64_t wanted = frames_wanted(options);
  return wanted > 0 ? wanted : source.frames();
}

void record(const BoardOptions& options, const PacketRecording& source) {
  const files::OutputFile file(options.record);
  std::uint64_t frames = frames_to_play(options, source);
  if (options.seconds > 0 && options.rate > 0) {
    frames = std::min(frames, static_cast<std::uint64_t>(options.seconds * options.rate));
  }
  constexpr double kMaxBytes = 4e9;  // they are put together in memory
  const double bytes =
      static_cast<double>(source.bytes()) / static_cast<double>(source.frames()) * static_cast<double>(frames);
  if (bytes > kMaxBytes) {
    throw UserError("--record " + options.record, "would be larger than 4 GB; limit it with --count or --seconds");
  }
  const double clocks = clocks_per_frame(options);
  std::string stream;
  stream.reserve(static_cast<std::size_t>(bytes));
  cli::Progress progress("frame", static_cast<std::size_t>(frames));
  for (std::uint64_t frame = 0; frame < frames; ++frame) {
    source.play(frame, clocks, [&](std::size_t size, const auto& stamp) {
      stream.resize(stream.size() + size);
      stamp(reinterpret_cast<std::uint8_t*>(stream.data()) + stream.size() - size);
    });
    progress.update(static_cast<std::size_t>(frame + 1));
  }
  file.write(stream);
  fmt::print("{} frames, {} bytes → {}\n", frames, stream.size(), options.record);
}

// Packets into the ring of --ring.
class RingOutput {
 public:
  explicit RingOutput(const BoardOptions& options)
      : options_(options),
        writer_(options.ring, options.slots.value_or(driver::RingWriter::deep_slots(options.ring))) {}

  [[nodiscard]] bool has_reader() const { return writer_.has_reader(); }
  template <class Stamp>
  void packet(std::size_t size, const Stamp& stamp) {
    if (const std::span<std::uint8_t> room = writer_.claim(); !room.empty()) {
      stamp(room.data());
      writer_.publish(size);
    }
  }
  void glance() { renewed_ += writer_.renew_if_removed() ? 1 : 0; }
  void finish() const {
    if (!options_.keep) {
      driver::remove_ring(options_.ring);
    }
  }
  [[nodiscard]] std::string text() const {
    return fmt::format("{} lost in the full ring; ring made anew {} times", writer_.lost(), renewed_);
  }

 private:
  const BoardOptions& options_;
  driver::RingWriter writer_;
  std::uint64_t renewed_ = 0;
};

// Packets to the host of --udp. Nobody can tell whether it listens.
class UdpOutput {
 public:
  explicit UdpOutput(const BoardOptions& options) : sender_(options.udp, options.from, options.jumbo) {}

  [[nodiscard]] static bool has_reader() { return true; }
  template <class Stamp>
  void packet(std::size_t size, const Stamp& stamp) {
    stamp(packet_.data());
    sender_.send({packet_.data(), size});
  }
  static void glance() {}
  void finish() { sender_.finish(); }
  [[nodiscard]] std::string text() const {
    return fmt::format("{} datagrams, {} could not be sent", sender_.datagrams(), sender_.failed());
  }

 private:
  UdpSender sender_;
  std::array<std::uint8_t, model::kLargestPacketBytes> packet_{};
};

// A board in real time. Frames are due at fixed times from the start, not from each other, so that the rate is kept
// exactly; a late one follows immediately. The summary says how late the latest was.
template <class Output, class Source>
void play(const BoardOptions& options, Source& source, PlayedRegisters& registers, Output& output) {
  const files::StopSignal stop;
  cli::StatusLine status;
  prctl(PR_SET_TIMERSLACK, 1UL, 0UL, 0UL, 0UL);  // sleep to the point, not up to 50 µs longer

  constexpr std::int64_t kGlanceNs = kSecondNs / 10;
  while (options.wait_for_reader && !output.has_reader() && !files::StopSignal::came()) {
    status.show("waiting for a reader of ring:" + options.ring);
    sleep_until(driver::now_ns() + kGlanceNs / 10);
  }

  const auto stopped = [&] { return options.source.sensor && !registers.settings().run; };
  while (stopped() && !files::StopSignal::came()) {
    status.show("waiting for a host that starts the board");
    sleep_until(driver::now_ns() + kGlanceNs / 100);
  }

  const std::uint64_t frames = frames_to_play(options, source);
  const double period = options.rate > 0 ? static_cast<double>(kSecondNs) / options.rate : 0;
  const double clocks = clocks_per_frame(options);
  const std::int64_t start = driver::now_ns();
  const std::int64_t end = options.seconds > 0 ? start + std::llround(options.seconds * kSecondNs)
                                               : std::numeric_limits<std::int64_t>::max();
  std::int64_t next_glance = start + kGlanceNs;
  std::int64_t latest = 0;
  std::uint64_t packets = 0;
  std::uint64_t frame = 0;
  for (; frame < frames && !files::StopSignal::came() && !stopped(); ++frame) {
    const std::int64_t due = start + static_cast<std::int64_t>(static_cast<double>(frame) * period);
    if (period > 0 ? due >= end : driver::now_ns() >= end) {
      break;
    }
    if (period > 0) {
      if (driver::now_ns() < due) {
        sleep_until(due);
      }
      latest = std::max(latest, driver::now_ns() - due);
    }
    source.play(frame, clocks, [&](std::size_t size, const auto& stamp) {
      ++packets;
      output.packet(size, stamp);
    });
    registers.set_frames(frame + 1);
    if (due >= next_glance || (period == 0 && frame % 1024 == 0 && driver::now_ns() >= next_glance)) {
      const std::int64_t now = driver::now_ns();
      next_glance = std::max(now, due) + kGlanceNs;
      output.glance();
      if (status.visible()) {
        status.show(fmt::format("{} frames, {:.1f} s, {}", frame + 1, static_cast<double>(now - start) / kSecondNs,
                                output.text()));
      }
    }
  }
  const double seconds = static_cast<double>(driver::now_ns() - start) / kSecondNs;
  status.show("");
  output.finish();
  fmt::print("{} frames in {:.3f} s: {:.0f} frames/s, {} packets, {}; latest frame {:.3f} ms late\n", frame, seconds,
             static_cast<double>(frame) / seconds, packets, output.text(), static_cast<double>(latest) / 1e6);
}

// Plays it where the options say, with registers where they say.
template <class Source>
void play(const BoardOptions& options, Source& source, PlayedRegisters& registers) {
  std::optional<EtherboneServer> server;
  if (!options.control.empty()) {
    server.emplace(
        "--control " + options.control, options.control,
        [&](bool write, std::uint32_t address, std::uint32_t data) { return registers.access(write, address, data); });
  }
  if (!options.udp.empty()) {
    UdpOutput output(options);
    play(options, source, registers, output);
  } else {
    RingOutput output(options);
    play(options, source, registers, output);
  }
}

void run_board(const BoardOptions& options) {
  if ((options.ring.empty() ? 0 : 1) + (options.record.empty() ? 0 : 1) + (options.udp.empty() ? 0 : 1) != 1) {
    throw UserError("--ring, --udp, --record", "give one of them");
  }
  constexpr double kMinRate = 1e-3;
  if (options.rate != 0 && !(options.rate >= kMinRate && options.rate <= 1e9)) {
    throw UserError("--rate", fmt::format("is {}; 0 (as fast as it can) or a number from {} to 1e9 is needed",
                                          options.rate, kMinRate));
  }
  if (!(options.seconds >= 0) || options.seconds > 1e9) {
    throw UserError("--seconds", "a number from 0 to 1e9 is needed");
  }
  if (options.source.sensor) {
    if (options.source.images.empty() || options.control.empty() || options.source.bits > 0 ||
        !options.record.empty()) {
      throw UserError("--sensor", "needs --images and --control, and goes neither with --bits nor with --record");
    }
    const int bits = pixel_bits_of(options.source);
    const model::BoardBuild build{
        .max_rows = model::row_limit(bits), .pixel_bits = bits, .runs = true, .region = true, .compact = true};
    PlayedRegisters registers(options.pixel_clock_hz, build);
    SensorBoard source(read_sensor_images(options.source), bits, counts_per_image(options.source), registers);
    play(options, source, registers);
    return;
  }
  const PacketRecording source = read_source(options.source, frames_wanted(options));
  if (!options.record.empty()) {
    record(options, source);
    return;
  }
  PlayedRegisters registers(options.pixel_clock_hz, source.build());
  play(options, source, registers);
}
}  // namespace

void add_board_command(CLI::App& app) {
  CLI::App* command = cli::add_command(
      app,
      {.name = "board",
       .purpose = "Plays a board in real time, into a shared-memory ring or over the network.",
       .details =
           "Packets come from a recording (--replay), from recorded images (--images) or from a line of light that "
           "moves (--line); they go into a ring (--ring), to a host on the network (--udp) or into a file (--record). "
           "Sequence numbers, time stamps, encoder counts and check words are written anew, so that repetitions follow "
           "each other as one run. At each repetition the board begins to decode anew.\n\n"
           "Frames are due at fixed times from the start. A late frame follows immediately. The last line says how "
           "many frames were played, how many found the ring full, and how late the latest was.",
       .examples = R"(
# Record the packets of a moving line.
selfproj-sim board --line 512x96 --record line.slfp

# What a board decodes of recorded images, as packets.
selfproj-sim scene render desk --bits 4 --count 16 --out codes
selfproj-sim board --images codes/*.png --bits 4 --record codes.slfp

# Play them at 10,000 frames a second for 2 seconds, to a reader in another process.
selfproj-sim board --replay line.slfp --ring line1 --seconds 2 --wait-for-reader &
selfproj inspect --device ring:line1 --wait-for-board --seconds 3
)"});
  const auto options = std::make_shared<BoardOptions>();
  add_source_options(*command, options->source);
  cli::begin_group(*command, "Destination (one of --ring, --udp and --record is required)");
  CLI::Option* const ring =
      command->add_option("--ring", options->ring, "Ring to write into. A driver reads it as ring:NAME.")
          ->type_name("NAME");
  command->add_option("--slots", options->slots, "Packets that the ring holds, a power of two.")
      ->transform(cli::whole_number(1, 65536))
      ->type_name("N")
      ->default_str(fmt::format("{}, or fewer where /dev/shm is small", driver::RingWriter::kDeepSlots));
  command->add_flag("--wait-for-reader", options->wait_for_reader, "Begin when a reader has opened the ring.")
      ->needs(ring);
  command->add_flag("--keep", options->keep, "Leave the ring in place at the end, for a later reader.");
  CLI::Option* const udp = command
                               ->add_option("--udp", options->udp,
                                            "Host to send datagrams to, HOST or HOST:PORT. Its driver reads "
                                            "udp:ADDRESS, the address of this machine.")
                               ->type_name("HOST");
  command
      ->add_option("--from", options->from,
                   "Address of this machine to send from, or ADDRESS:PORT; the port is that of --udp unless given.")
      ->type_name("ADDRESS")
      ->needs(udp);
  command->add_flag("--jumbo", options->jumbo, "Send datagrams for frames of 9,000 bytes, not 1,500.")->needs(udp);
  command
      ->add_option(
          "--control", options->control,
          "Address of this machine, or ADDRESS:PORT, port 1234 unless given, where the board's registers "
          "answer to Etherbone. `selfproj board` takes udp:ADDRESS. Settings change no packet, but with --sensor.")
      ->type_name("ADDRESS");
  command->add_option("--record", options->record, "File for the same packets, written as fast as possible.")
      ->type_name("FILE");
  cli::begin_group(*command, "Timing");
  command
      ->add_option("--rate", options->rate,
                   "Frames a second. 0 plays as fast as possible, whether they are read or not.")
      ->transform(cli::real_number(0, 1e9))
      ->type_name("FPS")
      ->capture_default_str();
  command->add_option("--pixel-clock-hz", options->pixel_clock_hz, "Pixel clock in Hz, which the time stamps count.")
      ->transform(cli::real_number(model::kMinPixelClockHz, model::kMaxPixelClockHz))
      ->type_name("HZ")
      ->capture_default_str();
  command->add_option("--count", options->count, "Frames to play, repeating the source as needed.")
      ->transform(cli::whole_number(1))
      ->type_name("N")
      ->default_str("the source once");
  command->add_option("--seconds", options->seconds, "Seconds to play, repeating the source as needed.")
      ->transform(cli::real_number(0, 1e9))
      ->type_name("S");
  command->add_flag("--loop", options->loop, "Repeat the source until Ctrl-C.");
  command->callback([options] { run_board(*options); });
}

}  // namespace selfproj::sim
