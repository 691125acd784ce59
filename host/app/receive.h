// What all commands that receive packets have in common: where packets come from, when the run ends, what is shown
// meanwhile, and what --check refuses.
#ifndef SELFPROJ_HOST_APP_RECEIVE_H
#define SELFPROJ_HOST_APP_RECEIVE_H

#include <CLI/CLI.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "host/camera/camera_device.h"
#include "host/driver/control.h"
#include "host/files/stop_signal.h"
#include "host/production/production.h"
#include "host/production/verdict_table.h"
#include "selfproj/driver/counters.h"
#include "selfproj/driver/device.h"
#include "selfproj/model/column_runs.h"
#include "selfproj/model/packet.h"
#include "selfproj/rig/rig.h"

namespace selfproj::app {

struct ReceiveOptions {
  std::string things;  // what --count counts: "profiles"
  std::string device;  // URI; empty: the command reads images
  std::string control;
  std::string wait = "poll-then-block";
  bool wait_for_board = false;
  bool newest = false;
  std::uint64_t count = 0;  // 0: no limit
  double seconds = 0;       // 0: no limit
  bool check = false;
};

// instead_of_images: images come by other options, and all of these go only with --device. or_images: --count and
// --check go with images as well.
enum class DeviceIs : std::uint8_t { required, instead_of_images, or_images };
enum class BoardIs : std::uint8_t { set_up, left_as_it_is };

// Adds --device, --control, --wait, --wait-for-board, --newest, --count, --seconds and --check. `things` are what
// --count counts; `images_are` goes on after "for a camera" and says what its images are. Returns --device, with which
// alone the others go.
CLI::Option* add_receive_options(CLI::App& command, ReceiveOptions& options, const std::string& things,
                                 const std::string& images_are, DeviceIs device = DeviceIs::required,
                                 BoardIs board = BoardIs::left_as_it_is);

// Adds --tolerance, --parts, --keep-parts, --modbus and --live. If `device` is given, they go only with it.
void add_production_options(CLI::App& command, production::ProductionOptions& options, CLI::Option* device = nullptr);

// What a board measures, and of which images.
struct BoardSetup {
  rig::RigCamera camera;
  model::Measure measure;
  bool compact = false;
  // By which the board judges frames; nothing: what it does about verdicts is left as it is. And where the pulse for
  // the ejector lies, in counts of the encoder; none of length 0.
  std::optional<production::VerdictTable> verdict = {};
  std::uint32_t ejector_delay = 0;
  std::uint32_t ejector_length = 0;
};

// A run of a command that receives packets. From its construction on, Ctrl-C ends the run instead of the program.
class Receiver {
 public:
  // What a command does with what comes. All but `packet` may be missing.
  struct Handlers {
    std::function<std::uint64_t(const model::PacketView&)> packet;  // returns how many things there are so far
    std::function<std::string()> status = {};                       // the end of the line on a terminal; may be empty
    // Called five times a second and at the end, with the things a second since it was called last.
    std::function<void(double rate)> report = {};
  };

  explicit Receiver(const ReceiveOptions& options) : options_(options) {}
  Receiver(const Receiver&) = delete;
  Receiver& operator=(const Receiver&) = delete;
  ~Receiver();

  // Opens the device when everything else is ready, because a board may begin as soon as somebody listens. With
  // `setup` the board gets these settings, by --control or the registers beside the device, if there are any. Where
  // there are registers the board then runs; a board that was stopped before is stopped again at the end. Throws
  // UserError.
  void open(const camera::CameraDefaults& camera = {}, const std::optional<BoardSetup>& setup = {});

  // Passes on the packets until there are --count things, --seconds after the first packet, until Ctrl-C, or until the
  // device has ended. Where nothing comes in the first second, it notes the likely reason. Throws UserError if a file
  // ends that holds no packet, and what the handlers throw.
  void run(const Handlers& handlers);

  [[nodiscard]] driver::Device& device() { return *device_; }
  [[nodiscard]] driver::Control* control() { return control_.get(); }  // null: there are no registers
  // After run() those of its end: what a ring loses later is left to its next reader, who is told of it.
  [[nodiscard]] driver::Counters counters() const { return ended_ ? *ended_ : device_->counters(); }

  // With --check, throws CheckFailed if the driver has counted a fault, `more` is not 0, or things are missing.
  void check(std::uint64_t more = 0) const;

 private:
  void start_board(const std::optional<BoardSetup>& setup);

  const ReceiveOptions& options_;
  const files::StopSignal stop_;
  std::unique_ptr<driver::Device> device_;
  std::unique_ptr<driver::Control> control_;  // null: there are no registers
  bool ran_ = true;                           // the board ran before
  std::uint64_t done_ = 0;
  std::optional<driver::Counters> ended_;
};

}  // namespace selfproj::app

#endif  // SELFPROJ_HOST_APP_RECEIVE_H
