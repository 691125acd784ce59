// What commands share that measure by light section: their options, and the way from packets to profiles.
#ifndef SELFPROJ_HOST_APP_SECTION_RUN_H
#define SELFPROJ_HOST_APP_SECTION_RUN_H

#include <CLI/CLI.hpp>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/driver/clock.h"
#include "selfproj/driver/device.h"
#include "selfproj/light_section/differential_profile.h"
#include "selfproj/light_section/profile.h"
#include "selfproj/light_section/validity_counts.h"
#include "selfproj/model/column_runs.h"
#include "selfproj/model/packet.h"
#include "selfproj/rig/rig.h"

namespace selfproj::app {

struct SectionOptions {
  std::string rig = "light-section";
  std::string reference;                 // empty: the plane
  std::optional<double> pixel_clock_hz;  // empty: the rig's
  std::string assume;                    // values that are taken though they were never measured

  // The rig, with the pixel clock. Throws UserError if it is none of kind light-section, or if millimetres would come
  // from a value that was never measured (rig::expect_measured). With `way_is_said` the rig need not know how the belt
  // moves.
  [[nodiscard]] rig::Rig load_rig(bool way_is_said = false) const;

  // The reference of the folder, or the rig's empty table or conveyor. Beside a recording, the device "file:PATH", may
  // lie the one under which it was taken (reference_file_of), and in the folder of images as reference.csv: it is the
  // default, and with a recording no other is taken. Throws UserError.
  [[nodiscard]] light_section::ReferenceProfile load_reference(const rig::Rig& loaded, const std::string& device,
                                                               const std::vector<std::string>& images = {}) const;

  // Its name, for reports.
  [[nodiscard]] std::string reference_name(const std::string& device,
                                           const std::vector<std::string>& images = {}) const;
};

// Adds --rig, --assume, --reference and --pixel-clock-hz.
void add_section_options(CLI::App& command, SectionOptions& options);

// What the board has to measure: as the rig says, except for what --select says, if it is not empty.
model::Measure measure_of_rig(const rig::Rig& rig, const std::string& select = {});

// Counts beside those of the driver.
struct SectionCounts {
  std::uint64_t profiles = 0;               // frames that became a profile
  std::uint64_t broken = 0;                 // frames flagged by the board
  std::uint64_t other_size = 0;             // frames of another size than the rig's camera
  std::uint64_t other_select = 0;           // frames measured otherwise than --select or the reference says
  std::uint64_t not_moments = 0;            // packets of images, codes and verdicts alone
  light_section::ValidityCounts columns{};  // of all profiles
  int threshold = 0;                        // of the newest frame
  std::int64_t first_done_ns = 0;           // when the first profile was there
  std::int64_t last_done_ns = 0;            // and the last one
  driver::DurationHistogram delay;          // from a packet's arrival to its profile

  [[nodiscard]] std::uint64_t of(light_section::Validity validity) const {
    return columns.at(static_cast<std::size_t>(validity));
  }
  [[nodiscard]] std::uint64_t points() const { return of(light_section::Validity::valid); }

  // Frames per second from the first profile to the last; 0 if there are fewer than two. (Packets of a file arrive many
  // at a time.)
  [[nodiscard]] double rate() const {
    const auto ns = static_cast<double>(last_done_ns - first_done_ns);
    return profiles > 1 && ns > 0 ? static_cast<double>(profiles - 1) * 1e9 / ns : 0;
  }
};

// Why fewer than half of the columns became points, in words, and what to do; empty where half of them or more did.
std::string doubt_about(const SectionCounts& counts, const rig::Rig& rig);

// The same about the newest seconds of a run.
class NewestDoubt {
 public:
  // To be called five times a second.
  const std::string& about(const SectionCounts& counts, const rig::Rig& rig);

 private:
  light_section::ValidityCounts before_{};
  int calls_ = 0;
  std::string text_;
};

// "delay p50 ..., p99 ..., max ...".
std::string delay_text(const driver::DurationHistogram& delay);

// Computes the profiles of packets, and counts what becomes of these.
class SectionRun {
 public:
  // The profiler must outlive it. `select` is what the board must have selected; nothing: whatever comes. Notes if the
  // first frame is not measured as the rig says; frames of other bits than the first give no profile, and a note.
  SectionRun(const light_section::DifferentialProfiler& profiler, const rig::RigMeasure& measure,
             std::optional<model::Select> select = {})
      : profiler_(profiler), measure_(measure.of_board()), select_(select) {}

  // Computes the newest packet of the device. Returns false if it gives no profile. Throws UserError if the device
  // sends frames of another rig, or measured otherwise than `select` or the reference says, from the first on.
  bool profile(const model::PacketView& packet, const driver::Device& device, const light_section::ProfileView& to);

  // Computes the columns of a frame that came as an image, at arrival_ns. Throws UserError about `source` if the
  // reference was measured otherwise.
  void profile(const model::PacketHeader& header, const model::RunsView& runs, const std::string& source,
               std::int64_t arrival_ns, const light_section::ProfileView& to);

  [[nodiscard]] const SectionCounts& counts() const { return counts_; }

 private:
  bool is_usable(const model::PacketView& packet, const std::string& uri);
  void note_differences(const model::PacketHeader& header, const std::string& uri) const;
  void count(const model::PacketHeader& header, const light_section::ProfileView& made, std::int64_t arrival_ns);

  const light_section::DifferentialProfiler& profiler_;
  model::Measure measure_;   // of the rig
  int bits_ = 0;             // of the first frame
  bool other_bits_ = false;  // there were frames of other bits
  std::optional<model::Select> select_;
  SectionCounts counts_;
};

}  // namespace selfproj::app

#endif  // SELFPROJ_HOST_APP_SECTION_RUN_H
